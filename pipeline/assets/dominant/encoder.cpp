#include "pipeline/assets/dominant/encoder.h"

#include <algorithm>
#include <glm/common.hpp>
#include <numbers>

#include "fit/dominant_light.h"
#include "formats/padding.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {
namespace {

using formats::LightMapStrip;
using formats::PixelFormat;
using formats::Result;

/// Rows around a strip that fill the texels outside charts: as far as a 4 x 4 block or a bilinear filter reaches.
constexpr int kPaddingRows = 2;
/// Rows around a strip that are solved with it, so that neighbouring strips agree on the light between them.
constexpr int kSolvedRows = 4;
static_assert(kSolvedRows >= kPaddingRows);
constexpr int kMargin = kSolvedRows + fit::kFilteredLightMargin;

/// Direction and intensity of some rows, padded across the edges of charts.
struct DominantRows {
    formats::Image<glm::vec4> direction, intensity;
    formats::Image<float> significance;
};

/// Lights of the rows of a strip.
struct Lights {
    formats::Image<glm::vec3> direction, intensity;
};

/// Fits the lights of a strip: of each texel, and then for the filter unless the fit is the paper's.
/// counts  of the rows [firstRow, firstRow + rowCount)
Lights fitLights(const LightMapStrip& strip, int firstRow, int rowCount, const fit::FilteredLightOptions& options,
                 DominantFitCounts& counts) {
    const int width = strip.sh.width(), height = strip.sh.height(), above = firstRow - strip.firstRow;
    Lights lights{formats::Image<glm::vec3>(width, height), formats::Image<glm::vec3>(width, height)};
    const auto rowsOf = [&](int first, int count) {
        return fit::DominantLightRows{strip.sh.view().rows(first, count), strip.covered.view().rows(first, count),
                                      strip.normal.view().rows(first, count), lights.direction.view().rows(first, count),
                                      lights.intensity.view().rows(first, count)};
    };
    const auto fit = [&](int first, int count) { return fit::fitDominantLights(rowsOf(first, count), options.light); };
    fit(0, above);
    counts.texels = fit(above, rowCount);
    fit(above + rowCount, height - above - rowCount);
    if (options.light.fit == fit::DominantFit::Closed) return lights;
    formats::Image<std::uint8_t> solved(width, height);
    const int firstSolved = std::max(0, above - kSolvedRows), lastSolved = std::min(height, above + rowCount + kSolvedRows);
    fit::DominantLightRows rows = rowsOf(0, height);
    rows.chart = strip.chart.view();
    fit::fitForFilter(rows, solved.view(), firstSolved, lastSolved - firstSolved, options);
    const auto own = solved.view().rows(above, rowCount);
    counts.solved = std::count(own.row(0), own.row(rowCount), std::uint8_t{1});
    return lights;
}

/// Fits the lights of some rows.
/// strip   holds these rows, and kMargin more on either side as far as the map has them
/// counts  of the rows themselves
DominantRows fitRows(const LightMapStrip& strip, int firstRow, int rowCount, const fit::FilteredLightOptions& options,
                     DominantFitCounts& counts) {
    const int width = strip.sh.width(), above = firstRow - strip.firstRow;
    const Lights lights = fitLights(strip, firstRow, rowCount, options, counts);
    DominantRows rows{formats::Image<glm::vec4>(width, rowCount), formats::Image<glm::vec4>(width, rowCount),
                      formats::Image<float>(width, rowCount)};
    for (int y = 0; y < rowCount; ++y) {
        const int stripY = above + y;
        for (int x = 0; x < width; ++x) {
            glm::vec3 towards = lights.direction.at(x, stripY), light = lights.intensity.at(x, stripY);
            const bool known = strip.covered.at(x, stripY) != 0;
            if (!known) {
                const int count = formats::visitNearestCovered(strip.covered.view(), x, stripY, kPaddingRows, [&](int nearX, int nearY) {
                    towards += lights.direction.at(nearX, nearY);
                    light += lights.intensity.at(nearX, nearY);
                });
                if (count > 0) {
                    towards /= static_cast<float>(count);
                    light /= static_cast<float>(count);
                }
            }
            rows.direction.at(x, y) = glm::vec4(towards, 1.0f);
            rows.intensity.at(x, y) = glm::vec4(light, 1.0f);
            rows.significance.at(x, y) = known ? 1.0f : 0.0f;
        }
    }
    return rows;
}

/// Returns the largest intensity of a map; for a refined fit an upper bound, since a range is not worth a second search.
Result<float> brightestLight(LightMapSource& source, const fit::FilteredLightOptions& options, const ActionContext& context) {
    float brightest = 0;
    LC_CHECK(foldInOrder<float>(
        source.chunkCount(), context, "measure " + context.action.asset,
        [&](int index) -> Result<float> {
            LC_TRY(chunk, source.chunk(index));
            float part = 0;
            if (options.light.fit != fit::DominantFit::Closed) {
                for (const lighting::ShRgb& sh : (*chunk)->sh.texels()) part = std::max(part, fit::largestIntensity(sh));
                return part;
            }
            DominantFitCounts counts;
            const DominantRows rows = fitRows(**chunk, (*chunk)->firstRow, source.chunkRows(index), options, counts);
            for (const glm::vec4& value : rows.intensity.texels()) part = std::max({part, value.x, value.y, value.z});
            return part;
        },
        [&](float part) { brightest = std::max(brightest, part); }));
    return brightest;
}

/// Constants of the residual texture: its range is wide enough for the error of BC7 in a block whose directions lie on no few lines.
constexpr float kResidualScale = 1.0f / 8, kResidualCentre = 128.0f / 255;

/// Encodes rows of every texture.
void encodeRows(DominantRows& rows, const DominantConstants& constants, const DominantFormats& formats,
                const compress::EncodeOptions& options, EncodedDominantRows& out) {
    const auto encode = [&](PixelFormat format, formats::ImageView<const glm::vec4> texels, formats::ImageView<glm::vec4> decoded) {
        std::vector<std::byte> bytes(formats::bytesPerBlockRow(format, texels.width) *
                                     static_cast<std::size_t>(formats::blocksDown(format, texels.height)));
        out.report.add(compress::encodeRows(format, texels, rows.significance.view(), options, bytes, decoded));
        return bytes;
    };
    for (glm::vec4& value : rows.intensity.texels()) value /= constants.intensityRange;
    out.intensity = encode(formats.intensity, rows.intensity.view(), {});
    for (glm::vec4& value : rows.direction.texels()) value = (value - constants.directionBias) / constants.directionScale;
    formats::Image<glm::vec4> decoded(rows.direction.width(), rows.direction.height());
    out.direction = encode(formats.direction, rows.direction.view(), decoded.view());
    if (constants.residualScale == 0) return;
    for (std::size_t i = 0; i < decoded.texels().size(); ++i)
        decoded.texels()[i] = glm::clamp((rows.direction.texels()[i] - decoded.texels()[i]) / kResidualScale + kResidualCentre, 0.0f, 1.0f);
    out.residual = encode(formats.direction, decoded.view(), {});
}

}  // namespace

void DominantFitCounts::add(const DominantFitCounts& other) {
    texels.refined += other.texels.refined;
    texels.skipped += other.texels.skipped;
    solved += other.solved;
}

DominantFormats dominantFormatsOf(formats::Target target) {
    const formats::TargetInfo& row = formats::info(target);
    if (target == formats::Target::Float) return {PixelFormat::Rgba16f, row.hdr, false};
    return {row.ldr, row.hdr, true};
}

Result<DominantEncoder> DominantEncoder::create(LightMapSource& source, const DominantParameters& parameters,
                                                const ActionContext& context) {
    DominantEncoder encoder(source);
    encoder.options_.light.luminanceWeights = source.luminanceWeights();
    LC_TRY(fit, dominantFitOf(context.action.asset, parameters.fit));
    encoder.options_.light.fit = (*fit)->cooked;
    LC_TRY(survey, source.survey(context));
    LC_TRY(brightest, brightestLight(source, encoder.options_, context));
    // The intensity of a light that alone gives a tenth of the key to a white surface that faces it.
    encoder.options_.floor = 0.1 * std::numbers::pi * (*survey)->key.key();
    encoder.formats_ = dominantFormatsOf(parameters.target);
    const bool isBiased = encoder.formats_.hasResidual;
    encoder.constants_ = {.directionScale = isBiased ? 2.0f : 1.0f,
                          .directionBias = isBiased ? -1.0f : 0.0f,
                          .residualScale = isBiased ? kResidualScale : 0.0f,
                          .residualCentre = kResidualCentre,
                          .intensityRange = hdrRange(*brightest)};
    encoder.encodeOptions_ = parameters.textures.encodeOptions();
    return encoder;
}

Result<EncodedDominantRows> DominantEncoder::encode(int strip) const {
    EncodedDominantRows out;
    out.firstRow = source_->stripFirstRow(strip);
    out.rowCount = source_->stripRows(strip);
    const int first = std::max(0, out.firstRow - kMargin), end = std::min(source_->height(), out.firstRow + out.rowCount + kMargin);
    LC_TRY(texels, source_->rows(first, end - first));
    DominantRows rows = fitRows(*texels, out.firstRow, out.rowCount, options_, out.fitted);
    encodeRows(rows, constants_, formats_, encodeOptions_, out);
    return out;
}

}  // namespace lightcook::pipeline
