#include "pipeline/document/json.h"

#include "formats/json_structure.h"

namespace lightcook::pipeline {
namespace {

constexpr std::size_t kDeepest = 64;  ///< our files are at most 8 deep

}  // namespace

Json parseJson(const std::string& text) {
    return formats::faultOfStructure(text, kDeepest) ? Json(Json::value_t::discarded) : Json::parse(text, nullptr, false);
}

std::string textOf(const Json& json) {
    return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

std::string asUtf8(const std::string& text) {
    return parseJson(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace)).get<std::string>();
}

bool isUtf8(const std::string& text) {
    return asUtf8(text) == text;
}

}  // namespace lightcook::pipeline
