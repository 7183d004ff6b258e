#include "pipeline/assets/dominant/dominant.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <glm/common.hpp>
#include <optional>

#include "compress/encode.h"
#include "fit/dominant_light.h"
#include "formats/padding.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/scene/dominant_fit.h"

namespace lightcook::pipeline {
namespace {

using formats::LightMapStrip;
using formats::PixelFormat;
using formats::Result;

/// Rows around a strip that fill the texels outside charts: as far as a 4 x 4 block or a bilinear filter reaches.
constexpr int kPaddingRows = 2;

/// Direction and intensity of some rows, padded across the edges of charts.
struct DominantRows {
    formats::Image<glm::vec4> direction, intensity;
    formats::Image<float> significance;
};

/// Fits the lights of some rows.
/// strip   holds these rows and those around them that only pad
/// counts  of the rows themselves
DominantRows fitRows(const LightMapStrip& strip, int firstRow, int rowCount, const fit::DominantLightOptions& options,
                     fit::DominantCounts& counts) {
    const int width = strip.sh.width(), above = firstRow - strip.firstRow;
    formats::Image<glm::vec3> direction(width, strip.sh.height()), intensity(width, strip.sh.height());
    const auto fit = [&](int first, int count) {
        return fit::dominantLight(strip.sh.view().rows(first, count), strip.covered.view().rows(first, count),
                                  strip.normal.view().rows(first, count), options, direction.view().rows(first, count),
                                  intensity.view().rows(first, count));
    };
    fit(0, above);
    counts = fit(above, rowCount);
    fit(above + rowCount, strip.sh.height() - above - rowCount);
    DominantRows rows{formats::Image<glm::vec4>(width, rowCount), formats::Image<glm::vec4>(width, rowCount),
                      formats::Image<float>(width, rowCount)};
    for (int y = 0; y < rowCount; ++y) {
        const int stripY = above + y;
        for (int x = 0; x < width; ++x) {
            glm::vec3 towards = direction.at(x, stripY), light = intensity.at(x, stripY);
            const bool known = strip.covered.at(x, stripY) != 0;
            if (!known) {
                const int count = formats::visitNearestCovered(strip.covered.view(), x, stripY, kPaddingRows, [&](int nearX, int nearY) {
                    towards += direction.at(nearX, nearY);
                    light += intensity.at(nearX, nearY);
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

struct Formats {
    PixelFormat direction, intensity;
    bool hasResidual;  ///< directions are stored as (v + 1) / 2, and a second texture encodes the residual of the first one
};

Formats formatsOf(formats::Target target) {
    const formats::TargetInfo& row = formats::info(target);
    if (target == formats::Target::Float) return {PixelFormat::Rgba16f, row.hdr, false};
    return {row.ldr, row.hdr, true};
}

/// Returns the largest intensity; for a refined fit an upper bound, since a range is not worth a second search.
Result<float> brightestIntensity(LightMapSource& source, const fit::DominantLightOptions& options, const ActionContext& context) {
    const auto parts = mapInOrder<float>(source.chunkCount(), context, "measure " + context.action.asset, [&](int index) -> Result<float> {
        const auto chunk = source.chunk(index);
        if (!chunk) return tl::make_unexpected(chunk.error());
        float largest = 0;
        if (options.fit != fit::DominantFit::Closed) {
            for (const lighting::ShRgb& sh : (*chunk)->sh.texels()) largest = std::max(largest, fit::largestIntensity(sh));
            return largest;
        }
        fit::DominantCounts counts;
        const DominantRows rows = fitRows(**chunk, (*chunk)->firstRow, source.chunkRows(index), options, counts);
        for (const glm::vec4& value : rows.intensity.texels()) largest = std::max({largest, value.x, value.y, value.z});
        return largest;
    });
    if (!parts) return tl::make_unexpected(parts.error());
    return *std::max_element(parts->begin(), parts->end());
}

/// Constants of the residual texture: its range is wide enough for the error of BC7 in a block whose directions lie on no few lines.
constexpr float kResidualScale = 1.0f / 8, kResidualCentre = 128.0f / 255;

/// The textures of the asset, by their index in AssetTextures.
struct Outputs {
    AssetTextures files;
    std::size_t direction = 0, intensity = 0;
    std::optional<std::size_t> residual;
};

/// Encodes and writes rows of every texture, from firstRow on.
Result<compress::EncodeReport> writeRows(DominantRows& rows, int firstRow, const DominantConstants& constants, const Formats& formats,
                                         const compress::EncodeOptions& options, Outputs& outputs) {
    compress::EncodeReport report;
    std::vector<std::byte> bytes;
    const auto write = [&](std::size_t output, PixelFormat format, formats::ImageView<const glm::vec4> texels,
                           formats::ImageView<glm::vec4> decoded) {
        bytes.resize(formats::bytesPerBlockRow(format, texels.width) *
                     static_cast<std::size_t>(formats::blocksDown(format, texels.height)));
        report.add(compress::encodeRows(format, texels, rows.significance.view(), options, bytes, decoded));
        return outputs.files.writer(output).writeBlockRows({}, firstRow / formats::info(format).blockHeight, bytes);
    };
    for (glm::vec4& value : rows.intensity.texels()) value /= constants.intensityRange;
    if (auto written = write(outputs.intensity, formats.intensity, rows.intensity.view(), {}); !written)
        return tl::make_unexpected(written.error());
    for (glm::vec4& value : rows.direction.texels()) value = (value - constants.directionBias) / constants.directionScale;
    formats::Image<glm::vec4> decoded(rows.direction.width(), rows.direction.height());
    if (auto written = write(outputs.direction, formats.direction, rows.direction.view(), decoded.view()); !written)
        return tl::make_unexpected(written.error());
    if (!outputs.residual) return report;
    for (std::size_t i = 0; i < decoded.texels().size(); ++i)
        decoded.texels()[i] = glm::clamp((rows.direction.texels()[i] - decoded.texels()[i]) / kResidualScale + kResidualCentre, 0.0f, 1.0f);
    if (auto written = write(*outputs.residual, formats.direction, decoded.view(), {}); !written)
        return tl::make_unexpected(written.error());
    return report;
}

struct StripReport {
    compress::EncodeReport encoded;
    fit::DominantCounts fitted;
    void add(const StripReport& other) {
        encoded.add(other.encoded);
        fitted.refined += other.fitted.refined;
        fitted.skipped += other.fitted.skipped;
    }
};

Result<StripReport> encodeStrips(LightMapSource& source, const fit::DominantLightOptions& fitOptions, const DominantConstants& constants,
                                 const Formats& formats, const compress::EncodeOptions& options, Outputs& outputs,
                                 const ActionContext& context) {
    const auto encodeStrip = [&](int index) -> Result<StripReport> {
        const auto strip = source.stripWithMargin(index, kPaddingRows, kPaddingRows);
        if (!strip) return tl::make_unexpected(strip.error());
        const int firstRow = source.stripFirstRow(index);
        StripReport report;
        DominantRows rows = fitRows(*strip, firstRow, source.stripRows(index), fitOptions, report.fitted);
        const auto encoded = writeRows(rows, firstRow, constants, formats, options, outputs);
        if (!encoded) return tl::make_unexpected(encoded.error());
        report.encoded = *encoded;
        return report;
    };
    const auto reports = mapInOrder<StripReport>(source.stripCount(), context, "encode " + context.action.asset, encodeStrip);
    if (!reports) return tl::make_unexpected(reports.error());
    StripReport total;
    for (const StripReport& each : *reports) total.add(each);
    return total;
}

/// Creates the files of all textures, in the order of the manifest.
Result<Outputs> createOutputs(const Formats& formats, const LightMapSource& source, const TextureSettings& settings,
                              const DominantConstants& constants, const ActionContext& context) {
    Outputs outputs{AssetTextures(context, settings), 0, 0, {}};
    const auto create = [&](const std::string& role, PixelFormat format) {
        formats::TextureShape shape;
        shape.format = format;
        shape.width = source.width();
        shape.height = source.height();
        return outputs.files.create(
            {role, context.action.asset + "_" + role, shape, {{"layout", "dominant"}, {"constants", toJson(constants)}}});
    };
    const auto direction = create("direction", formats.direction);
    if (!direction) return tl::make_unexpected(direction.error());
    if (formats.hasResidual) {
        const auto residual = create("residual", formats.direction);
        if (!residual) return tl::make_unexpected(residual.error());
        outputs.residual = *residual;
    }
    const auto intensity = create("intensity", formats.intensity);
    if (!intensity) return tl::make_unexpected(intensity.error());
    outputs.direction = *direction;
    outputs.intensity = *intensity;
    return outputs;
}

Json notesOf(const std::string& fitName, fit::DominantFit fit, const StripReport& report) {
    Json notes = {{"fit", fitName}};
    if (fit != fit::DominantFit::Closed) {
        notes["refined"] = report.fitted.refined;
        notes["skipped"] = report.fitted.skipped;
    }
    notes["clamped_high"] = report.encoded.clampedHigh;
    notes["clamped_negative"] = report.encoded.clampedNegative;
    return notes;
}

}  // namespace

std::vector<PixelFormat> dominantFormats(formats::Target target) {
    const Formats formats = formatsOf(target);
    std::vector<PixelFormat> all = {formats.direction, formats.intensity};
    if (formats.hasResidual) all.push_back(formats.direction);
    return all;
}

Result<ActionOutcome> cookDominant(const ActionContext& context) {
    const auto parameters = parametersOf<DominantParameters>(context);
    if (!parameters) return tl::make_unexpected(parameters.error());
    const auto source = openLightMap(context, parameters->description);
    if (!source) return tl::make_unexpected(source.error());
    fit::DominantLightOptions fitOptions;
    fitOptions.luminanceWeights = (*source)->luminanceWeights();
    const auto fit = dominantFitOf(context.action.asset, parameters->fit);
    if (!fit) return tl::make_unexpected(fit.error());
    fitOptions.fit = (*fit)->cooked;
    const auto brightest = brightestIntensity(**source, fitOptions, context);
    if (!brightest) return tl::make_unexpected(brightest.error());

    const Formats formats = formatsOf(parameters->target);
    const DominantConstants constants{.directionScale = formats.hasResidual ? 2.0f : 1.0f,
                                      .directionBias = formats.hasResidual ? -1.0f : 0.0f,
                                      .residualScale = formats.hasResidual ? kResidualScale : 0.0f,
                                      .residualCentre = kResidualCentre,
                                      .intensityRange = hdrRange(*brightest)};
    auto outputs = createOutputs(formats, **source, parameters->textures, constants, context);
    if (!outputs) return tl::make_unexpected(outputs.error());
    const auto report = encodeStrips(**source, fitOptions, constants, formats, parameters->textures.encodeOptions(), *outputs, context);
    if (!report) return tl::make_unexpected(report.error());

    CookResult result{
        makeCookedAsset(context.action.asset, AssetKind::Dominant, "direction-intensity", (*source)->width(), (*source)->height()),
        std::filesystem::file_size(context.action.inputs.at("source")), notesOf(parameters->fit, fitOptions.fit, *report)};
    result.asset.fit = parameters->fit;
    result.asset.constants = toJson(constants);
    result.asset.source.description = toJson(parameters->description);
    return outputs->files.finish(std::move(result));
}

}  // namespace lightcook::pipeline
