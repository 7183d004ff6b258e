// Plans of light maps in the cache, where `cook --patch` finds those of the last cook.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "compress/light_map.h"
#include "pipeline/assets/light_map/detail.h"
#include "pipeline/assets/light_map/kept_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/strip_digest.h"
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

/// Returns the keys that the errors of a map are relative to: those of the bake, or kept ones that are close to them. Fails for others.
formats::Result<KeptMap> keysOf(const std::string& asset, const std::optional<KeptMap>& kept, const verify::LightMapKey& ofBake);

/// Blocks of a strip, and its texels of texture "coverage" where the map has it.
struct EncodedStrip {
    compress::EncodedLightMapRows rows;
    std::vector<std::byte> coverage;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.rows, self.coverage);
    }
};

/// Encodes strips with a plan. Strips that an earlier cook has encoded, or an earlier pass of this one, come from the cache.
class StripEncoder {
public:
    StripEncoder(const compress::LightMapPlan& plan, const compress::EncodeOptions& options, const ActionContext& context);
    const compress::LightMapPlan& plan() const { return plan_; }
    const compress::EncodeOptions& options() const { return options_; }
    /// Encodes strip `index`: see compress::encodeLightMapRows().
    formats::Result<EncodedStrip> encode(LightMapSource& source, int index) const;

    /// Returns what make(strip) encodes with the plan of strip `index` and the rows around it that the encoder reads. It returns a Result.
    /// what  tells it apart from others of the same strip
    template <class Make>
    auto partOf(LightMapSource& source, int index, const std::string& what, Make make) const {
        const int context = plan_.contextRows();
        using Made = decltype(make(formats::LightMapStrip()));
        return cachedPart(
            parts_,
            [&]() -> formats::Result<std::string> {
                LC_TRY(rows, source.digestOfStrip(index, context, context, *parts_));
                return digestOf(digest_, what, index, *rows);
            },
            [&]() -> Made {
                LC_TRY(strip, source.stripWithMargin(index, context, context));
                return make(std::move(*strip));
            });
    }

private:
    const compress::LightMapPlan& plan_;
    compress::EncodeOptions options_;
    const PartCache* parts_;
    std::string digest_;  ///< of plan and options
};

}  // namespace lightcook::pipeline
