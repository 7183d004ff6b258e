#include "pipeline/document/toml_file.h"

#include "formats/read_file.h"
#include "pipeline/document/toml_nesting.h"

namespace lightcook::pipeline {

formats::Result<std::string> readTomlText(const std::filesystem::path& file, std::uint64_t mostBytes, const char* expected) {
    constexpr int kDeepest = 16;
    const auto text = formats::readWholeText(file, mostBytes);
    if (!text) return formats::failure(formats::ErrorCode::InvalidRequest, text.error().subject, text.error().detail);
    if (const auto place = placeNestedDeeper(*text, kDeepest))
        return formats::failure(formats::ErrorCode::InvalidRequest, fmt::format("{}:{}:{}", file.string(), place->line, place->column),
                                fmt::format("found values nested more than {} deep, expected {}", kDeepest, expected));
    return *text;
}

}  // namespace lightcook::pipeline
