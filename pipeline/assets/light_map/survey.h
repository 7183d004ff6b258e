// One pass over a light map finds these figures, and all actions of a cook that read the map share them (LightMapSource::survey).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>

#include "compress/light_map.h"
#include "pipeline/assets/light_map/constant_light.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/action.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

/// Chunk `index` of a light map.
using ChunkFunction = std::function<formats::Result<std::shared_ptr<const formats::LightMapStrip>>(int index)>;

/// Figures of a whole map, or of some of its rows. Parts of a map are merged in the order of their rows.
struct MapSurvey {
    verify::LightMapKey key;            ///< that of every error figure, and that which a display is exposed for
    compress::LightMapMeasure measure;  ///< ranges that an encoder needs
    ConstantLight light;
    std::array<double, 3> energy{};  ///< squares of coefficients by band, summed over covered texels
    formats::LightMapRepairs repairs;
    std::int64_t negativeAfterGamut = 0;

    /// Figures of none of the map's texels.
    /// hasSharedExit  true if a layout needs it (compress::needsSharedExit)
    MapSurvey(const LightMapSource& source, bool hasSharedExit);
    MapSurvey() = default;
    void add(const formats::LightMapStrip& strip);
    void merge(const MapSurvey& next);
    bool hasSharedExit() const { return hasSharedExit_; }

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.key, self.measure, self.light, self.energy, self.repairs, self.negativeAfterGamut, self.hasSharedExit_);
    }

private:
    bool hasSharedExit_ = false;
};

/// Passes over a map. LightMapSource::survey() calls it.
formats::Result<MapSurvey> surveyMap(LightMapSource& source, bool hasSharedExit, const ActionContext& context);
/// Returns the key of chunks that are not those of the bake itself.
formats::Result<verify::LightMapKey> surveyKey(const LightMapSource& bake, const ChunkFunction& chunkOf, const ActionContext& context);

}  // namespace lightcook::pipeline
