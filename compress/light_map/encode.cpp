// Encoding of rows: dispatch on the family of the layout, and the families raw and flat, which need no file of their own.
#include <algorithm>
#include <cassert>

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
        rows::Layer layer = rows::encodeHdr(plan.textures[0].format, source, source.values[i], rows::constant(plan, "range", 0),
                                            static_cast<float>(plan.key), options, false, out.report);
        out.textures[0].layers.push_back(std::move(layer.bytes));
    }
    return out;
}

}  // namespace

EncodedLightMapRows encodeLightMapRows(const LightMapPlan& plan, const formats::LightMapStrip& strip, int firstRow, int rowCount,
                                       const EncodeOptions& options) {
    assert(strip.sh.width() == plan.width);
    assert(firstRow % plan.blockHeight() == 0 && (rowCount % plan.blockHeight() == 0 || firstRow + rowCount == plan.height));
    assert(strip.firstRow <= std::max(0, firstRow - kLightMapContextRows));
    assert(strip.firstRow + strip.sh.height() >= std::min(plan.height, firstRow + rowCount + kLightMapContextRows));
    rows::Source source = rows::makeSource(plan, strip, firstRow, rowCount);
    rows::fitToFilter(plan, strip, firstRow, source);
    rows::dropFarPadding(source, plan.blockHeight());
    switch (formats::info(plan.layout).family) {
        case LightMapFamily::Raw:
        case LightMapFamily::Flat:
            return encodeRaw(plan, source, options);
        case LightMapFamily::Luvw:
            return rows::encodeLuvw(plan, source, options);
        case LightMapFamily::Ratio:
        case LightMapFamily::Zh3:
        case LightMapFamily::Sh4:
            return rows::encodeRatio(plan, source, options);
        case LightMapFamily::Godot:
        case LightMapFamily::Bakery:
            return rows::encodeEngine(plan, strip, source, options);
        case LightMapFamily::Hdr:
            return rows::encodeHdrCoefficients(plan, source, options);
        case LightMapFamily::Basis:
            return rows::encodeBasis(plan, strip, source, options);
    }
    return {};
}

}  // namespace lightcook::compress
