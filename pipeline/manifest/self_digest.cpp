#include "pipeline/manifest/self_digest.h"

#include <fmt/format.h>

#include "pipeline/document/json.h"
#include "pipeline/graph/digest.h"

namespace lightcook::pipeline {
namespace {

constexpr const char* kKey = "digest";
constexpr std::size_t kDigits = 32;

}  // namespace

std::string withSelfDigest(Json document) {
    const std::string zeros(kDigits, '0');
    document.erase(std::string(kKey));
    document.push_back({kKey, zeros});
    std::string text = textOf(document) + "\n";
    text.replace(text.rfind(zeros), kDigits, digestOfText(text));
    return text;
}

formats::Result<void> checkSelfDigest(const std::string& text, const formats::Subject& subject) {
    const Json document = parseJson(text);
    std::string stated;
    if (document.is_object() && document.contains(kKey) && document[kKey].is_string()) stated = document[kKey].get<std::string>();
    if (stated.size() != kDigits || text.rfind(stated) == std::string::npos)
        return formats::failure(formats::ErrorCode::Verification, subject,
                                "found no digest of its own, expected the file as `lightcook cook` left it");
    std::string blank = text;
    blank.replace(blank.rfind(stated), kDigits, std::string(kDigits, '0'));
    const std::string digest = digestOfText(blank);
    if (digest != stated)
        return formats::failure(formats::ErrorCode::Verification, subject,
                                fmt::format("found content {}, expected {} as cooked", digest, stated));
    return {};
}

}  // namespace lightcook::pipeline
