#include "pipeline/assets/light_map/kept_plan.h"

#include "pipeline/assets/light_map/strip_digest.h"

namespace lightcook::pipeline {

std::string EncodingPlan::digest() const {
    return digestOf(*this);
}

std::optional<EncodingPlan> EncodingPlan::find(const PartCache& parts, const std::string& digest) {
    const auto bytes = parts.find(digest);
    if (!bytes) return std::nullopt;
    auto plan = formats::unarchived<EncodingPlan>(*bytes);
    return plan && plan->digest() == digest ? std::move(plan) : std::nullopt;
}

StripEncoder::StripEncoder(const compress::LightMapPlan& plan, const compress::EncodeOptions& options, const ActionContext& context)
    : plan_(plan), options_(options), parts_(context.parts), digest_(digestOf(plan, options)) {}

compress::EncodedLightMapRows StripEncoder::encode(const formats::LightMapStrip& strip, int firstRow, int rowCount) const {
    return cachedPart(
        parts_, [&] { return digestOf(digest_, firstRow, rowCount, digestOfStrip(strip)); },
        [&] { return compress::encodeLightMapRows(plan_, strip, firstRow, rowCount, options_); });
}

}  // namespace lightcook::pipeline
