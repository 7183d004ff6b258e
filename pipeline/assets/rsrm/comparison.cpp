#include "pipeline/assets/rsrm/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "pipeline/assets/verdict.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

/// Returns the texel and channel with the largest error in a part of the map.
verify::ErrorPlace worstOf(const std::vector<verify::RsrmRow>& rows, const glm::ivec2& first, const glm::ivec2& size) {
    verify::ErrorPlace worst;
    for (int y = first.y; y < std::min(first.y + size.y, static_cast<int>(rows.size())); ++y) {
        int column = 0;
        for (const verify::RsrmRow::Point& point : rows[static_cast<std::size_t>(y)].points) {
            if (!point.isCentre) continue;
            const int x = column++;
            if (x < first.x || x >= first.x + size.x) continue;
            for (int channel = 0; channel < 3; ++channel) {
                const double error = std::abs(point.cooked[channel] - point.reference[channel]);
                if (worst.isKnown() && error <= std::abs(worst.found - worst.reference)) continue;
                worst.x = x;
                worst.y = y;
                worst.channel = channel;
                worst.normal = {std::sqrt(std::max(0.0, 1 - point.z * point.z)), 0, point.z};
                worst.reference = point.reference[channel];
                worst.found = point.cooked[channel];
            }
        }
    }
    return worst;
}

std::string_view allowedCodes(verify::RsrmCodes codes) {
    if (codes == verify::RsrmCodes::Dithered) return "at most one code in all";
    return codes == verify::RsrmCodes::SharedExponent ? "at most 1.225 codes in all" : "at most half a code in all";
}

/// Returns the faults of a map: codes that rounding does not explain.
std::vector<verify::Violation> violationsOf(const verify::CookedRsrm& map, const verify::RsrmSource& source,
                                            const std::vector<verify::RsrmRow>& rows) {
    std::vector<verify::Violation> violations;
    const verify::RsrmCodeError off = verify::rsrmCodeError(map, source, rows);
    if (off.codes > 0)
        violations.push_back({fmt::format("row {}, texel {}", off.row, off.column),
                              fmt::format("an error of {:.3g} codes beyond rounding", off.codes), std::string(allowedCodes(map.codes)),
                              worstOf(rows, {off.column, off.row}, {1, 1})});
    if (const verify::RsrmCodeError sum = verify::rsrmDitherError(map, source, rows); off.codes <= 0 && sum.codes > 0)
        violations.push_back({fmt::format("row {}, texel {}, dither", sum.row, sum.column),
                              fmt::format("errors that sum to {:.3g} codes more than dithering leaves", sum.codes),
                              "dithered codes, as the manifest calls them"});
    return violations;
}

}  // namespace

verify::CookedRsrm decodedRsrm(const RsrmFormatInfo& format, bool isDithered, const RsrmConstants& constants,
                               std::span<const std::byte> bytes, int width) {
    verify::CookedRsrm map;
    map.color = constants.color;
    map.exponents = constants.exponents;
    map.texels = formats::Image<glm::vec4>(width, static_cast<int>(constants.exponents.size()));
    verify::decodeRows(format.pixels, bytes, map.texels.view());
    map.isGrey = format.id == RsrmFormat::Bc4;
    map.codes = isDithered && format.codes == verify::RsrmCodes::Rounded ? verify::RsrmCodes::Dithered : format.codes;
    map.tolerance = verify::toleranceOf(format.pixels);
    map.spans = verify::blockSpans(format.pixels, bytes, width);
    return map;
}

std::optional<RsrmComparison> compareRsrm(const verify::CookedRsrm& map, const verify::RsrmSource& source,
                                          const glm::vec3& luminanceWeights, const ActionContext& context, const std::string& what,
                                          const std::optional<verify::Viewing>& viewing) {
    RsrmComparison comparison;
    comparison.rows.resize(map.exponents.size());
    if (!forEachIndex(comparison.rows.size(), context, what,
                      [&](std::size_t row) { comparison.rows[row] = verify::compareRsrmRow(map, source, static_cast<int>(row)); }))
        return std::nullopt;
    comparison.stages = verify::rsrmStages(map, source, comparison.rows, luminanceWeights, viewing);
    comparison.violations = violationsOf(map, source, comparison.rows);
    return comparison;
}

RsrmFormatErrors formatErrors(const RsrmComparison& comparison) {
    const verify::StageError &quantize = comparison.stages.front(), &total = comparison.stages.back();
    return {std::max(total.diffuse.relRms, total.specular.relRms), std::max(quantize.diffuse.p99, quantize.specular.p99),
            comparison.violations.empty() && isFinite(total.diffuse) && isFinite(total.specular)};
}

}  // namespace lightcook::pipeline
