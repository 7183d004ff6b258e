// Plans any layout for a small map held in memory: the steps that pipeline/ takes in passes over strips.
#pragma once

#include "compress/light_map.h"

namespace lightcook::synthetic {

inline compress::LightMapPlan planOf(formats::LightMapLayout layout, formats::Target target, const formats::LightMapStrip& map,
                                     const compress::EncodeOptions& options, int clusters = 0,
                                     formats::LightMapFilter filter = formats::LightMapFilter::Hardware) {
    const int width = map.sh.width(), height = map.sh.height();
    compress::LightMapMeasure measure;
    measure.add(map);
    compress::MeasuredLightMap measured{target, width, height, measure};
    measured.filter = filter;
    if (!formats::info(layout).isLearned()) return compress::planLightMap(layout, measured);
    compress::LightMapBlocks blocks(width, height);
    blocks.add(map, 0, height);
    const std::vector<int> chartOfBlock = blocks.chartOfBlock();
    compress::LightMapSamples samples(blocks.choose(chartOfBlock, compress::learningBlocks(options.effort, width, height)),
                                      blocks.across());
    samples.add(map, 0, height);
    // Visible errors on a display that shows the key as a grey card.
    compress::LightMapObjective& objective = measured.objective.emplace();
    objective.display.nitsPerUnit = lighting::DisplaySettings{}.of(measure.key()).nitsPerUnit;
    return compress::planLearnedLightMap(layout, measured, {chartOfBlock, samples, clusters}, options);
}

}  // namespace lightcook::synthetic
