#include "pipeline/assets/light_map/kept_plan.h"

#include <fmt/format.h>

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

formats::Result<KeptMap> keysOf(const std::string& asset, const std::optional<KeptMap>& kept, const verify::LightMapKey& ofBake) {
    const KeptMap found{{}, ofBake.key(), ofBake.displayKey()};
    if (!kept) return found;
    if (kept->serves(found.key, found.displayKey)) return *kept;
    return formats::failure(formats::ErrorCode::Verification, asset,
                            fmt::format("found kept keys of {:.4g} and {:.4g}, expected those of the bake within 1 %, {:.4g} and {:.4g}",
                                        kept->key, kept->displayKey, found.key, found.displayKey));
}

StripEncoder::StripEncoder(const compress::LightMapPlan& plan, const compress::EncodeOptions& options, const ActionContext& context)
    : plan_(plan), options_(options), parts_(context.parts), digest_(digestOf(plan, options)) {}

formats::Result<EncodedStrip> StripEncoder::encode(LightMapSource& source, int index) const {
    const int firstRow = source.stripFirstRow(index), rowCount = source.stripRows(index);
    return partOf(source, index, "strip", [&](const formats::LightMapStrip& strip) -> formats::Result<EncodedStrip> {
        return EncodedStrip{compress::encodeLightMapRows(plan_, strip, firstRow, rowCount, options_),
                            plan_.hasCoverage() ? compress::coverageTexels(strip, firstRow, rowCount) : std::vector<std::byte>()};
    });
}

}  // namespace lightcook::pipeline
