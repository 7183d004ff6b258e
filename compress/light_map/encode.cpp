// Encoding of rows: dispatch on the family of the layout, and the families raw and flat, which need no file of their own.
#include <algorithm>
#include <cassert>
#include <glm/common.hpp>

#include "compress/light_map/families.h"
#include "compress/light_map/filter_fit.h"

namespace lightcook::compress {

namespace {

using formats::LightMapFamily;

/// Encodes the values as they are: halves hold signed values.
EncodedLightMapRows encodeRaw(const LightMapPlan& plan, const rows::Source& source, const EncodeOptions& options) {
    EncodedLightMapRows out;
    out.textures.resize(1);
    for (std::size_t i = 0; i < static_cast<std::size_t>(plan.textures[0].layerCount); ++i) {
        rows::Layer layer = rows::encodeHdr(plan, source, source.values[i], rows::constant(plan, "range", 0), options, false, out.report);
        out.textures[0].layers.push_back(std::move(layer.bytes));
    }
    return out;
}

/// Encodes exit radiance, in one texture or two.
EncodedLightMapRows encodeFlat(const LightMapPlan& plan, const rows::Source& source, const EncodeOptions& options) {
    EncodedLightMapRows out;
    const bool hasSecond = plan.textures.size() > 1;
    const float range = rows::constant(plan, "range", 0);
    rows::Layer first = rows::encodeHdr(plan, source, source.values[0], range, options, hasSecond, out.report);
    out.textures.resize(plan.textures.size());
    if (hasSecond) {
        formats::Image<glm::vec4> wanted(source.width, source.height);
        for (int y = 0; y < source.height; ++y)
            for (int x = 0; x < source.width; ++x) wanted.at(x, y) = glm::vec4(source.values[0].at(x, y) / range, 1);
        out.textures[1].layers.push_back(rows::encodeSecond(plan, source, wanted, first.bytes, first.decoded, options, out.report).bytes);
    }
    out.textures[0].layers.push_back(std::move(first.bytes));
    return out;
}

}  // namespace

EncodedLightMapRows encodeLightMapRows(const LightMapPlan& plan, const formats::LightMapStrip& strip, int firstRow, int rowCount,
                                       const EncodeOptions& options) {
    assert(strip.sh.width() == plan.width);
    assert(firstRow % plan.blockHeight() == 0 && (rowCount % plan.blockHeight() == 0 || firstRow + rowCount == plan.height));
    assert(strip.firstRow <= std::max(0, firstRow - plan.contextRows()));
    assert(strip.firstRow + strip.sh.height() >= std::min(plan.height, firstRow + rowCount + plan.contextRows()));
    rows::Source source = rows::makeSource(plan, strip, firstRow, rowCount);
    // The fit assumes filters of light and of ratios. Family unreal filters logarithms, for which the mean of the neighbours is better.
    if (!plan.hasCoverage()) {
        if (formats::info(plan.layout).family != LightMapFamily::Unreal) rows::fitToFilter(plan, strip, firstRow, source);
        rows::dropFarPadding(source, plan.blockHeight());
    }
    switch (formats::info(plan.layout).family) {
        case LightMapFamily::Raw:
            return encodeRaw(plan, source, options);
        case LightMapFamily::Flat:
            return encodeFlat(plan, source, options);
        case LightMapFamily::Ratio:
        case LightMapFamily::Sh4:
            return rows::encodeRatio(plan, source, options);
        case LightMapFamily::Godot:
        case LightMapFamily::Bakery:
            return rows::encodeLinearExit(plan, strip, source, options);
        case LightMapFamily::Hdr:
            return rows::encodeHdrCoefficients(plan, source, options);
        case LightMapFamily::Halo3:
            return rows::encodeHalo3(plan, source, options);
        case LightMapFamily::Unreal:
            return rows::encodeUnreal(plan, strip, source, options);
        case LightMapFamily::Rnm:
            return rows::encodeRnm(plan, strip, source, options);
        case LightMapFamily::Lit:
            return rows::encodeLit(plan, source, options);
        case LightMapFamily::Basis:
            return rows::encodeBasis(plan, strip, source, options);
    }
    return {};
}

std::vector<std::byte> coverageTexels(const formats::LightMapStrip& strip, int firstRow, int rowCount) {
    using formats::kCoverageColumns, formats::kCoverageRows;
    const int width = strip.covered.width(), across = formats::coverageSize(width, rowCount).x;
    std::vector<std::byte> texels(
        formats::bytesPerImage(formats::PixelFormat::Rgba8Unorm, across, formats::coverageSize(width, rowCount).y));
    for (int y = 0; y < rowCount; ++y)
        for (int x = 0; x < width; ++x) {
            if (strip.covered.at(x, firstRow - strip.firstRow + y) == 0) continue;
            const int texel = y / kCoverageRows * across + x / kCoverageColumns;
            texels[static_cast<std::size_t>(4 * texel + y % kCoverageRows)] |= std::byte{1} << (x % kCoverageColumns);
        }
    return texels;
}

}  // namespace lightcook::compress
