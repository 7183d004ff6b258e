// Plans of light maps in the cache, where `cook --patch` finds those of the last cook.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "compress/light_map.h"
#include "pipeline/assets/light_map/detail.h"
#include "pipeline/graph/part_cache.h"

namespace lightcook::pipeline {

/// All that is decided before the first strip of a map is encoded.
struct EncodingPlan {
    compress::LightMapPlan map;
    std::optional<DetailPlan> detail;
    double key = 0, displayKey = 0;  ///< of the bake (verify::LightMapKey)
    std::int64_t clamped = 0;        ///< values of that bake which did not fit

    std::string digest() const;
    void store(const PartCache& parts) const { parts.store(digest(), formats::archived(*this)); }
    /// Returns the plan of a digest; nothing if the cache does not have it, or this program did not make it.
    static std::optional<EncodingPlan> find(const PartCache& parts, const std::string& digest);

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.map, self.detail, self.key, self.displayKey, self.clamped);
    }
};

/// Encodes strips with a plan. Strips that an earlier cook has encoded, or an earlier pass of this one, come from the cache.
class StripEncoder {
public:
    StripEncoder(const compress::LightMapPlan& plan, const compress::EncodeOptions& options, const ActionContext& context);
    const compress::LightMapPlan& plan() const { return plan_; }
    const compress::EncodeOptions& options() const { return options_; }
    /// See compress::encodeLightMapRows().
    compress::EncodedLightMapRows encode(const formats::LightMapStrip& strip, int firstRow, int rowCount) const;

private:
    const compress::LightMapPlan& plan_;
    compress::EncodeOptions options_;
    const PartCache* parts_;
    std::string digest_;  ///< of plan and options
};

}  // namespace lightcook::pipeline
