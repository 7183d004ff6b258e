#include "pipeline/json/json.h"

namespace lightcook::pipeline {
namespace {

constexpr int kDeepest = 64;  ///< our files are at most 8 deep

}  // namespace

Json parseJson(const std::string& text) {
    bool isTooDeep = false;
    Json json = Json::parse(
        text,
        [&](int depth, Json::parse_event_t, Json&) {
            isTooDeep = isTooDeep || depth > kDeepest;
            return !isTooDeep;
        },
        false);
    return isTooDeep ? Json(Json::value_t::discarded) : json;
}

std::string textOf(const Json& json) {
    return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace lightcook::pipeline
