#include "pipeline/report/page_parts.h"

#include <cmath>
#include <limits>

namespace lightcook::pipeline {

const Json& member(const Json& object, const char* key) {
    static const Json kAbsent;
    if (!object.is_object()) return kAbsent;
    const auto found = object.find(key);
    return found == object.end() ? kAbsent : *found;
}

const Json& list(const Json& object, const char* key) {
    static const Json kEmpty = Json::array();
    const Json& value = member(object, key);
    return value.is_array() ? value : kEmpty;
}

std::string words(const Json& value) {
    return value.is_string() ? value.get<std::string>() : "";
}

double number(const Json& value) {
    const double found = value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
    return std::isfinite(found) ? found : std::numeric_limits<double>::quiet_NaN();
}

const Json& lastStage(const Json& asset) {
    static const Json kNone;
    const Json& stages = list(asset, "stages");
    return stages.empty() ? kNone : stages.back();
}

}  // namespace lightcook::pipeline
