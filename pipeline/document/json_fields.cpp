#include "pipeline/document/json_fields.h"

#include <fmt/format.h>

namespace lightcook::pipeline {

std::string markdownTable(const std::vector<FieldRow>& rows) {
    std::string text = "| field | type | meaning |\n| --- | --- | --- |\n";
    for (const FieldRow& row : rows)
        text += fmt::format("| `{}` | {}{} | {} |\n", row.path, row.type, row.isRequired ? "" : ", optional", row.caption);
    return text;
}

}  // namespace lightcook::pipeline
