#include "pipeline/assets/dominant/dominant.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <glm/common.hpp>
#include <optional>

#include "compress/encode.h"
#include "fit/dominant_light.h"
#include "formats/padding.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/textures.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::LightMapStrip;
using formats::PixelFormat;
using formats::Result;

/// Rows around a band that fill the texels outside charts: as far as a 4 x 4 block or a bilinear filter reaches.
constexpr int kPaddingRows = 2;

/// Direction and intensity of some rows, padded across the edges of charts.
struct DominantRows {
    formats::Image<glm::vec4> direction, intensity;
    formats::Image<float> significance;
};

/// counts: of the rows themselves, not of those around them that only pad.
DominantRows fitRows(const LightMapStrip& band, int firstRow, int rowCount, const fit::DominantLightOptions& options,
                     fit::DominantCounts& counts) {
    const int width = band.sh.width(), above = firstRow - band.firstRow;
    formats::Image<glm::vec3> direction(width, band.sh.height()), intensity(width, band.sh.height());
    const auto fit = [&](int first, int count) {
        return fit::dominantLight(band.sh.view().rows(first, count), band.covered.view().rows(first, count),
                                  band.normal.view().rows(first, count), options, direction.view().rows(first, count),
                                  intensity.view().rows(first, count));
    };
    fit(0, above);
    counts = fit(above, rowCount);
    fit(above + rowCount, band.sh.height() - above - rowCount);
    DominantRows rows{formats::Image<glm::vec4>(width, rowCount), formats::Image<glm::vec4>(width, rowCount),
                      formats::Image<float>(width, rowCount)};
    for (int y = 0; y < rowCount; ++y) {
        const int bandY = above + y;
        for (int x = 0; x < width; ++x) {
            glm::vec3 towards = direction.at(x, bandY), light = intensity.at(x, bandY);
            const bool known = band.covered.at(x, bandY) != 0;
            if (!known) {
                const int count = formats::visitNearestCovered(band.covered.view(), x, bandY, kPaddingRows, [&](int nearX, int nearY) {
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

fit::DominantFit fitFromName(const std::string& name) {
    if (name == "refined") return fit::DominantFit::Refined;
    if (name == "explained") return fit::DominantFit::Explained;
    return name == "refined-ambient" ? fit::DominantFit::RefinedAmbient : fit::DominantFit::Closed;
}

struct Formats {
    PixelFormat direction, intensity;
    bool hasBlocks;  ///< directions are stored as (v + 1) / 2 in two textures, the second coding what the first one left
};

Formats formatsOf(const std::string& target) {
    if (target == "float") return {PixelFormat::Rgba16f, hdrFormat(target), false};
    return {target == "astc" ? PixelFormat::Astc4x4Ldr : PixelFormat::Bc7, hdrFormat(target), true};
}

/// The largest intensity, or of a refined fit what none can exceed: it only sets a range, and is not worth a second search.
Result<float> brightestIntensity(LightMapSource& source, const fit::DominantLightOptions& options, const ActionContext& context) {
    const auto parts = forEachBand<float>(source.bandCount(), context, "measure " + context.action.asset, [&](int index) -> Result<float> {
        const auto band = source.band(index);
        if (!band) return tl::make_unexpected(band.error());
        float largest = 0;
        if (options.fit != fit::DominantFit::Closed) {
            for (const lighting::ShRgb& sh : (*band)->sh.texels()) largest = std::max(largest, fit::largestIntensity(sh));
            return largest;
        }
        fit::DominantCounts counts;
        const DominantRows rows = fitRows(**band, (*band)->firstRow, source.bandRows(index), options, counts);
        for (const glm::vec4& value : rows.intensity.texels()) largest = std::max({largest, value.x, value.y, value.z});
        return largest;
    });
    if (!parts) return tl::make_unexpected(parts.error());
    return *std::max_element(parts->begin(), parts->end());
}

/// One of the two textures on its way to its file.
struct Output {
    std::string role, file;
    formats::TextureShape shape;
    formats::TextureWriter writer;
};

Result<Output> createOutput(const char* role, PixelFormat format, const LightMapSource& source, const TextureSettings& settings,
                            const Json& constants, const ActionContext& context) {
    formats::TextureShape shape;
    shape.format = format;
    shape.width = source.width();
    shape.height = source.height();
    const std::string file = context.action.asset + "_" + role + std::string(settings.extension());
    auto writer =
        createTexture(context.folder / file, shape, settings, textureMetadata({{"layout", "dominant"}, {"constants", constants}}));
    if (!writer) return tl::make_unexpected(writer.error());
    return Output{role, file, shape, std::move(*writer)};
}

/// What is stored is what the shader undoes: direction = scale * lcDominantStored(first, residual) + bias, intensity = range * texel.
struct Stored {
    float directionScale, directionBias, intensityRange;
};
/// Of the residual texture: wide enough for what BC7 leaves in a block whose directions do not lie on a few lines.
constexpr float kResidualScale = 1.0f / 8, kResidualCentre = 128.0f / 255;

struct Outputs {
    Output direction, intensity;
    std::optional<Output> residual;
};

compress::EncodeReport encodeInto(Output& output, formats::ImageView<const glm::vec4> texels, formats::ImageView<const float> significance,
                                  const compress::EncodeOptions& options, std::vector<std::byte>& bytes,
                                  formats::ImageView<glm::vec4> decoded) {
    const PixelFormat format = output.shape.format;
    bytes.resize(formats::bytesPerBlockRow(format, texels.width) * static_cast<std::size_t>(formats::blocksDown(format, texels.height)));
    return compress::encodeRows(format, texels, significance, options, bytes, decoded);
}

/// Encodes and writes the rows from firstRow on of every texture.
Result<compress::EncodeReport> writeRows(DominantRows& rows, int firstRow, const Stored& stored, const compress::EncodeOptions& options,
                                         Outputs& outputs) {
    compress::EncodeReport report;
    std::vector<std::byte> bytes;
    const auto write = [&](Output& output, formats::ImageView<const glm::vec4> texels, formats::ImageView<glm::vec4> decoded) {
        report.add(encodeInto(output, texels, rows.significance.view(), options, bytes, decoded));
        return output.writer.writeBlockRows({}, firstRow / formats::info(output.shape.format).blockHeight, bytes);
    };
    for (glm::vec4& value : rows.intensity.texels()) value /= stored.intensityRange;
    if (auto written = write(outputs.intensity, rows.intensity.view(), {}); !written) return tl::make_unexpected(written.error());
    for (glm::vec4& value : rows.direction.texels()) value = (value - stored.directionBias) / stored.directionScale;
    formats::Image<glm::vec4> decoded(rows.direction.width(), rows.direction.height());
    if (auto written = write(outputs.direction, rows.direction.view(), decoded.view()); !written)
        return tl::make_unexpected(written.error());
    if (!outputs.residual) return report;
    for (std::size_t i = 0; i < decoded.texels().size(); ++i)
        decoded.texels()[i] = glm::clamp((rows.direction.texels()[i] - decoded.texels()[i]) / kResidualScale + kResidualCentre, 0.0f, 1.0f);
    if (auto written = write(*outputs.residual, decoded.view(), {}); !written) return tl::make_unexpected(written.error());
    return report;
}

struct BandReport {
    compress::EncodeReport encoded;
    fit::DominantCounts fitted;
    void add(const BandReport& other) {
        encoded.add(other.encoded);
        fitted.refined += other.fitted.refined;
        fitted.skipped += other.fitted.skipped;
    }
};

Result<BandReport> encodeBands(LightMapSource& source, const fit::DominantLightOptions& fitOptions, const Stored& stored,
                               const compress::EncodeOptions& options, Outputs& outputs, const ActionContext& context) {
    const auto reports =
        forEachBand<BandReport>(source.stripCount(), context, "encode " + context.action.asset, [&](int index) -> Result<BandReport> {
            const auto band = source.stripWithMargin(index, kPaddingRows, kPaddingRows);
            if (!band) return tl::make_unexpected(band.error());
            BandReport report;
            DominantRows rows = fitRows(*band, source.stripFirstRow(index), source.stripRows(index), fitOptions, report.fitted);
            const auto encoded = writeRows(rows, source.stripFirstRow(index), stored, options, outputs);
            if (!encoded) return tl::make_unexpected(encoded.error());
            report.encoded = *encoded;
            return report;
        });
    if (!reports) return tl::make_unexpected(reports.error());
    BandReport total;
    for (const BandReport& each : *reports) total.add(each);
    return total;
}

Json entryOf(const Output& output, const ActionContext& context) {
    return textureEntry(output.role, output.file, output.shape, std::filesystem::file_size(context.folder / output.file), {});
}

Result<Outputs> createOutputs(const Formats& pixelFormats, const LightMapSource& source, const TextureSettings& settings,
                              const Json& constants, const ActionContext& context) {
    auto direction = createOutput("direction", pixelFormats.direction, source, settings, constants, context);
    if (!direction) return tl::make_unexpected(direction.error());
    auto intensity = createOutput("intensity", pixelFormats.intensity, source, settings, constants, context);
    if (!intensity) return tl::make_unexpected(intensity.error());
    Outputs outputs{std::move(*direction), std::move(*intensity), std::nullopt};
    if (!pixelFormats.hasBlocks) return outputs;
    auto residual = createOutput("residual", pixelFormats.direction, source, settings, constants, context);
    if (!residual) return tl::make_unexpected(residual.error());
    outputs.residual = std::move(*residual);
    return outputs;
}

}  // namespace

Result<ActionOutcome> cookDominant(const ActionContext& context) {
    const Json& parameters = context.action.parameters;
    const TextureSettings settings = TextureSettings::fromJson(parameters.at("textures"));
    const auto source = openLightMap(context, parameters.at("description"));
    if (!source) return tl::make_unexpected(source.error());
    fit::DominantLightOptions fitOptions;
    fitOptions.luminanceWeights = (*source)->luminanceWeights();
    const std::string fitName = parameters.at("fit").get<std::string>();
    fitOptions.fit = fitFromName(fitName);
    const auto brightest = brightestIntensity(**source, fitOptions, context);
    if (!brightest) return tl::make_unexpected(brightest.error());

    const Formats pixelFormats = formatsOf(parameters.at("target").get<std::string>());
    const Stored stored{pixelFormats.hasBlocks ? 2.0f : 1.0f, pixelFormats.hasBlocks ? -1.0f : 0.0f, hdrRange(*brightest)};
    const Json constants = {{"direction_scale", stored.directionScale},
                            {"direction_bias", stored.directionBias},
                            {"residual_scale", pixelFormats.hasBlocks ? kResidualScale : 0.0f},
                            {"residual_centre", kResidualCentre},
                            {"intensity_range", stored.intensityRange}};
    auto outputs = createOutputs(pixelFormats, **source, settings, constants, context);
    if (!outputs) return tl::make_unexpected(outputs.error());
    const auto report = encodeBands(**source, fitOptions, stored, settings.encodeOptions(), *outputs, context);
    if (!report) return tl::make_unexpected(report.error());

    ActionOutcome outcome;
    Json textures = Json::array();
    for (Output* output : {&outputs->direction, outputs->residual ? &*outputs->residual : nullptr, &outputs->intensity}) {
        if (output == nullptr) continue;
        if (auto committed = output->writer.commit(); !committed) return tl::make_unexpected(committed.error());
        outcome.files.push_back(output->file);
        textures.push_back(entryOf(*output, context));
    }
    outcome.result["asset"] = {{"name", context.action.asset},
                               {"kind", "dominant"},
                               {"layout", "direction-intensity"},
                               {"fit", fitName},
                               {"width", (*source)->width()},
                               {"height", (*source)->height()},
                               {"quantity", "incident radiance, a delta from the direction"},
                               {"units", "radiometric"},
                               {"frame", "world"},
                               {"constants", constants},
                               {"textures", textures},
                               {"source", {{"description", parameters.at("description")}}}};
    outcome.result["bytes_in"] = std::filesystem::file_size(context.action.inputs.at("source"));
    Json notes = {{"fit", fitName}};
    if (fitOptions.fit != fit::DominantFit::Closed) {
        notes["refined"] = report->fitted.refined;
        notes["skipped"] = report->fitted.skipped;
    }
    notes["clamped_high"] = report->encoded.clampedHigh;
    notes["clamped_negative"] = report->encoded.clampedNegative;
    outcome.result["notes"] = notes;
    return outcome;
}

}  // namespace lightcook::pipeline
