// Measures and plans of the synthetic map, at effort 1.
#pragma once

#include "tests/compress/light_map_plan.h"
#include "tests/compress/synthetic_light_map.h"

namespace lightcook::synthetic {

inline constexpr int kWidth = 46, kHeight = 38;  // not multiples of a block

inline compress::LightMapMeasure measureOf(Kind kind) {
    compress::LightMapMeasure measure;
    measure.add(synthetic::makeBand(kind, kWidth, 0, kHeight));
    return measure;
}

inline compress::LightMapPlan planOf(Kind kind, formats::LightMapLayout layout, formats::Target target) {
    compress::EncodeOptions options;
    options.effort = 1;
    return synthetic::planOf(layout, target, synthetic::makeBand(kind, kWidth, 0, kHeight), options);
}

inline compress::EncodeOptions fast() {
    compress::EncodeOptions options;
    options.effort = 1;
    return options;
}

}  // namespace lightcook::synthetic
