// What the encoders of all light-map layouts start from: rows of a map, padded and weighed, and layers of texels to encode. Private to
// compress/.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "compress/light_map.h"

namespace lightcook::compress::rows {

/// The rows to encode, padded: one value array per coefficient, and how much each texel counts.
struct Source {
    int width = 0, height = 0;
    std::vector<formats::Image<glm::vec3>> values;  ///< nine coefficients, or one exit radiance
    formats::Image<float> coverage;                 ///< 1 inside charts, 1/256 beside them, 0 elsewhere
    formats::Image<float> importance;               ///< what a squared absolute error weighs: coverage over (exit radiance + knee) squared
    formats::Image<glm::ivec2> owner;               ///< texel of the map that this one takes after: itself, or the nearest
};
Source makeSource(const LightMapPlan& plan, const formats::LightMapStrip& band, int firstRow, int rowCount);

/// One layer: encoded bytes, and the decoded texels if anyone will need them.
struct Layer {
    std::vector<std::byte> bytes;
    formats::Image<glm::vec4> decoded;
};
Layer encodeLayer(formats::PixelFormat format, formats::Image<glm::vec4>& texels, const formats::Image<float>& significance,
                  const EncodeOptions& options, bool wantsDecoded, EncodeReport& report);
/// An HDR layer of values / range. Relative to what the eye compares with: above a tenth of the key errors count by their ratio.
Layer encodeHdr(formats::PixelFormat format, const Source& source, std::size_t value, float range, float key, const EncodeOptions& options,
                bool wantsDecoded, EncodeReport& report);

/// Returns a plan with everything but the constants, the textures as the table of layouts has them.
LightMapPlan emptyPlan(formats::LightMapLayout layout, formats::Target target, int width, int height, const LightMapMeasure& measure);
/// A power of two that brings the largest value into (8192, 16384]: room above for encoders that overshoot, and 27 octaves below it before
/// half floats lose bits to subnormals, whatever the map's unit.
float halfRange(float largest);

float constant(const LightMapPlan& plan, const char* name, std::size_t index);

/// The rows under a learned layout.
EncodedLightMapRows encodeBasis(const LightMapPlan& plan, const formats::LightMapStrip& band, const Source& source,
                                const EncodeOptions& options);

}  // namespace lightcook::compress::rows
