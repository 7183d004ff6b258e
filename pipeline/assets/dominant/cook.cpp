#include "pipeline/assets/dominant/dominant.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <glm/common.hpp>
#include <numbers>
#include <optional>

#include "compress/encode.h"
#include "fit/dominant_light.h"
#include "fit/filtered_light.h"
#include "formats/padding.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/scene/dominant_fit.h"
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

struct FitCounts {
    fit::DominantCounts texels;
    std::int64_t solved = 0;  ///< covered texels whose light was solved with that of their neighbours
    void add(const FitCounts& other) {
        texels.refined += other.texels.refined;
        texels.skipped += other.texels.skipped;
        solved += other.solved;
    }
};

/// Lights of the rows of a strip.
struct Lights {
    formats::Image<glm::vec3> direction, intensity;
};

/// Fits the lights of a strip: of each texel, and then for the filter unless the fit is the paper's.
/// counts  of the rows [firstRow, firstRow + rowCount)
Lights fitLights(const LightMapStrip& strip, int firstRow, int rowCount, const fit::FilteredLightOptions& options, FitCounts& counts) {
    const int width = strip.sh.width(), height = strip.sh.height(), above = firstRow - strip.firstRow;
    Lights lights{formats::Image<glm::vec3>(width, height), formats::Image<glm::vec3>(width, height)};
    const auto fit = [&](int first, int count) {
        return fit::dominantLight(strip.sh.view().rows(first, count), strip.covered.view().rows(first, count),
                                  strip.normal.view().rows(first, count), options.light, lights.direction.view().rows(first, count),
                                  lights.intensity.view().rows(first, count));
    };
    fit(0, above);
    counts.texels = fit(above, rowCount);
    fit(above + rowCount, height - above - rowCount);
    if (options.light.fit == fit::DominantFit::Closed) return lights;
    formats::Image<std::uint8_t> solved(width, height);
    const int firstSolved = std::max(0, above - kSolvedRows), lastSolved = std::min(height, above + rowCount + kSolvedRows);
    fit::fitForFilter(
        {strip.sh.view(), strip.covered.view(), strip.normal.view(), lights.direction.view(), lights.intensity.view(), solved.view()},
        firstSolved, lastSolved - firstSolved, options);
    const auto own = solved.view().rows(above, rowCount);
    counts.solved = std::count(own.row(0), own.row(rowCount), std::uint8_t{1});
    return lights;
}

/// Fits the lights of some rows.
/// strip   holds these rows, and kMargin more on either side as far as the map has them
/// counts  of the rows themselves
DominantRows fitRows(const LightMapStrip& strip, int firstRow, int rowCount, const fit::FilteredLightOptions& options, FitCounts& counts) {
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

struct Formats {
    PixelFormat direction, intensity;
    bool hasResidual;  ///< directions are stored as (v + 1) / 2, and a second texture encodes the residual of the first one
};

Formats formatsOf(formats::Target target) {
    const formats::TargetInfo& row = formats::info(target);
    if (target == formats::Target::Float) return {PixelFormat::Rgba16f, row.hdr, false};
    return {row.ldr, row.hdr, true};
}

/// Measurements of a whole map before its lights are encoded.
struct Measured {
    float brightest = 0;  ///< largest intensity; for a refined fit an upper bound, since a range is not worth a second search
    verify::LightMapKey key;
};

Result<Measured> measure(LightMapSource& source, const fit::FilteredLightOptions& options, const ActionContext& context) {
    const auto parts =
        mapInOrder<Measured>(source.chunkCount(), context, "measure " + context.action.asset, [&](int index) -> Result<Measured> {
            const auto chunk = source.chunk(index);
            if (!chunk) return tl::make_unexpected(chunk.error());
            Measured part{0, verify::LightMapKey(source.luminanceWeights())};
            part.key.add(**chunk, (*chunk)->firstRow, source.chunkRows(index));
            if (options.light.fit != fit::DominantFit::Closed) {
                for (const lighting::ShRgb& sh : (*chunk)->sh.texels())
                    part.brightest = std::max(part.brightest, fit::largestIntensity(sh));
                return part;
            }
            FitCounts counts;
            const DominantRows rows = fitRows(**chunk, (*chunk)->firstRow, source.chunkRows(index), options, counts);
            for (const glm::vec4& value : rows.intensity.texels()) part.brightest = std::max({part.brightest, value.x, value.y, value.z});
            return part;
        });
    if (!parts) return tl::make_unexpected(parts.error());
    Measured whole{0, verify::LightMapKey(source.luminanceWeights())};
    for (const Measured& part : *parts) {
        whole.brightest = std::max(whole.brightest, part.brightest);
        whole.key.merge(part.key);
    }
    return whole;
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
    FitCounts fitted;
    void add(const StripReport& other) {
        encoded.add(other.encoded);
        fitted.add(other.fitted);
    }
};

Result<StripReport> encodeStrips(LightMapSource& source, const fit::FilteredLightOptions& fitOptions, const DominantConstants& constants,
                                 const Formats& formats, const compress::EncodeOptions& options, Outputs& outputs,
                                 const ActionContext& context) {
    const auto encodeStrip = [&](int index) -> Result<StripReport> {
        const auto strip = source.stripWithMargin(index, kMargin, kMargin);
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
        notes["refined"] = report.fitted.texels.refined;
        notes["skipped"] = report.fitted.texels.skipped;
        notes["solved_with_neighbours"] = report.fitted.solved;
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
    fit::FilteredLightOptions fitOptions;
    fitOptions.light.luminanceWeights = (*source)->luminanceWeights();
    const auto fit = dominantFitOf(context.action.asset, parameters->fit);
    if (!fit) return tl::make_unexpected(fit.error());
    fitOptions.light.fit = (*fit)->cooked;
    const auto measured = measure(**source, fitOptions, context);
    if (!measured) return tl::make_unexpected(measured.error());
    // The intensity of a light that alone gives a tenth of the key to a white surface that faces it.
    fitOptions.floor = 0.1 * std::numbers::pi * measured->key.key();

    const Formats formats = formatsOf(parameters->target);
    const DominantConstants constants{.directionScale = formats.hasResidual ? 2.0f : 1.0f,
                                      .directionBias = formats.hasResidual ? -1.0f : 0.0f,
                                      .residualScale = formats.hasResidual ? kResidualScale : 0.0f,
                                      .residualCentre = kResidualCentre,
                                      .intensityRange = hdrRange(measured->brightest)};
    auto outputs = createOutputs(formats, **source, parameters->textures, constants, context);
    if (!outputs) return tl::make_unexpected(outputs.error());
    const auto report = encodeStrips(**source, fitOptions, constants, formats, parameters->textures.encodeOptions(), *outputs, context);
    if (!report) return tl::make_unexpected(report.error());

    CookResult result{
        makeCookedAsset(context.action.asset, AssetKind::Dominant, "direction-intensity", (*source)->width(), (*source)->height()),
        bakeBytes(context.action), notesOf(parameters->fit, fitOptions.light.fit, *report)};
    result.asset.fit = parameters->fit;
    result.asset.constants = toJson(constants);
    result.asset.source.description = toJson(parameters->description);
    return outputs->files.finish(std::move(result));
}

}  // namespace lightcook::pipeline
