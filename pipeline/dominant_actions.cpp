#include "pipeline/dominant_actions.h"

#include <algorithm>
#include <cmath>

#include "compress/encode.h"
#include "fit/dominant_light.h"
#include "formats/padding.h"
#include "pipeline/bands.h"
#include "pipeline/light_map_source.h"
#include "pipeline/textures.h"

namespace pipeline {
namespace {

using formats::LightMapBand;
using formats::PixelFormat;
using formats::Result;

/// Rows around a band that fill the texels outside charts: as far as a 4 x 4 block or a bilinear filter reaches.
constexpr int kPaddingRows = 2;

/// Direction and intensity of some rows, padded across the edges of charts.
struct DominantRows {
    formats::Image<glm::vec4> direction, intensity;
    formats::Image<float> significance;
};

DominantRows fitRows(const LightMapBand& band, int firstRow, int rowCount, const fit::DominantLightOptions& options) {
    const int width = band.sh.width();
    DominantRows rows{formats::Image<glm::vec4>(width, rowCount), formats::Image<glm::vec4>(width, rowCount),
                      formats::Image<float>(width, rowCount)};
    for (int y = 0; y < rowCount; ++y) {
        const int bandY = firstRow + y - band.firstRow;
        for (int x = 0; x < width; ++x) {
            fit::DominantLight light;
            bool known = band.covered.at(x, bandY) != 0;
            if (known) {
                light = fit::dominantLight(band.sh.at(x, bandY), band.normal.at(x, bandY), options);
            } else {
                const int count = formats::visitNearestCovered(band.covered.view(), x, bandY, kPaddingRows, [&](int nearX, int nearY) {
                    const fit::DominantLight near = fit::dominantLight(band.sh.at(nearX, nearY), band.normal.at(nearX, nearY), options);
                    light.direction += near.direction;
                    light.intensity += near.intensity;
                });
                if (count > 0) {
                    light.direction /= static_cast<float>(count);
                    light.intensity /= static_cast<float>(count);
                }
            }
            rows.direction.at(x, y) = glm::vec4(light.direction, 1.0f);
            rows.intensity.at(x, y) = glm::vec4(light.intensity, 1.0f);
            rows.significance.at(x, y) = known ? 1.0f : 0.0f;
        }
    }
    return rows;
}

struct Formats {
    PixelFormat direction, intensity;
    bool isSignedDirection;  ///< stored as it is, rather than as (v + 1) / 2
};

Formats formatsOf(const std::string& target) {
    if (target == "float") return {PixelFormat::Rgba16f, PixelFormat::Rgba16f, true};
    if (target == "astc") return {PixelFormat::Astc4x4Ldr, PixelFormat::Astc4x4Hdr, false};
    return {PixelFormat::Bc7, PixelFormat::Bc6hUf16, false};
}

Result<float> brightestIntensity(LightMapSource& source, const fit::DominantLightOptions& options, const ActionContext& context) {
    const auto parts = forEachBand<float>(source.bandCount(), context, "measure " + context.action.asset, [&](int index) -> Result<float> {
        const auto band = source.band(index);
        if (!band) return tl::make_unexpected(band.error());
        const DominantRows rows = fitRows(**band, (*band)->firstRow, source.bandRows(index), options);
        float largest = 0;
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
    auto writer = createTexture(context.folder / file, shape, settings,
                                {{"io.lightcook", Json({{"layout", "dominant"}, {"constants", constants}}).dump()}});
    if (!writer) return tl::make_unexpected(writer.error());
    return Output{role, file, shape, std::move(*writer)};
}

/// What is stored: directions moved into [0, 1] where the format is unsigned, intensities over their range.
void toStored(DominantRows& rows, bool isSignedDirection, float range) {
    for (glm::vec4& value : rows.direction.texels())
        if (!isSignedDirection) value = 0.5f * value + 0.5f;
    for (glm::vec4& value : rows.intensity.texels()) value /= range;
}

struct Stored {
    bool isSignedDirection;
    float range;
};

Result<compress::EncodeReport> encodeBands(LightMapSource& source, const fit::DominantLightOptions& fitOptions, const Stored& stored,
                                           int effort, Output& direction, Output& intensity, const ActionContext& context) {
    compress::EncodeOptions options;
    options.effort = effort;
    using Report = compress::EncodeReport;
    const auto reports =
        forEachBand<Report>(source.bandCount(), context, "encode " + context.action.asset, [&](int index) -> Result<Report> {
            const auto band = source.bandWithMargin(index, kPaddingRows, kPaddingRows);
            if (!band) return tl::make_unexpected(band.error());
            const int firstRow = index * kBandRows;
            DominantRows rows = fitRows(*band, firstRow, source.bandRows(index), fitOptions);
            toStored(rows, stored.isSignedDirection, stored.range);
            Report report;
            for (const auto& [output, texels] : {std::pair(&direction, &rows.direction), std::pair(&intensity, &rows.intensity)}) {
                const auto bytes = encodeImage(output->shape.format, texels->view(), rows.significance.view(), options, report);
                const int firstBlockRow = firstRow / formats::info(output->shape.format).blockHeight;
                if (auto written = output->writer.writeBlockRows({}, firstBlockRow, bytes); !written)
                    return tl::make_unexpected(written.error());
            }
            return report;
        });
    if (!reports) return tl::make_unexpected(reports.error());
    Report total;
    for (const Report& each : *reports) total.add(each);
    return total;
}

Json entryOf(const Output& output, const ActionContext& context) {
    return textureEntry(output.role, output.file, output.shape, std::filesystem::file_size(context.folder / output.file), {});
}

}  // namespace

Result<ActionOutcome> cookDominant(const ActionContext& context) {
    const Json& parameters = context.action.parameters;
    const TextureSettings settings = TextureSettings::fromJson(parameters.at("textures"));
    const auto description = lightMapDescriptionFromJson(parameters.at("description"), context.action.asset);
    if (!description) return tl::make_unexpected(description.error());
    const auto source = context.lightMaps.open(context.action.inputs.at("source"), *description);
    if (!source) return tl::make_unexpected(source.error());
    fit::DominantLightOptions fitOptions;
    fitOptions.luminanceWeights = (*source)->luminanceWeights();
    const auto brightest = brightestIntensity(**source, fitOptions, context);
    if (!brightest) return tl::make_unexpected(brightest.error());

    const Formats pixelFormats = formatsOf(parameters.at("target").get<std::string>());
    const Stored stored{pixelFormats.isSignedDirection, hdrRange(*brightest)};
    const Json constants = {{"direction_scale", stored.isSignedDirection ? 1.0 : 2.0},
                            {"direction_bias", stored.isSignedDirection ? 0.0 : -1.0},
                            {"intensity_range", stored.range}};
    auto direction = createOutput("direction", pixelFormats.direction, **source, settings, constants, context);
    if (!direction) return tl::make_unexpected(direction.error());
    auto intensity = createOutput("intensity", pixelFormats.intensity, **source, settings, constants, context);
    if (!intensity) return tl::make_unexpected(intensity.error());
    const auto report = encodeBands(**source, fitOptions, stored, settings.effort, *direction, *intensity, context);
    if (!report) return tl::make_unexpected(report.error());
    for (Output* output : {&*direction, &*intensity})
        if (auto committed = output->writer.commit(); !committed) return tl::make_unexpected(committed.error());

    ActionOutcome outcome;
    outcome.files = {direction->file, intensity->file};
    outcome.result["asset"] = {{"name", context.action.asset},
                               {"kind", "dominant"},
                               {"layout", "direction-intensity"},
                               {"width", (*source)->width()},
                               {"height", (*source)->height()},
                               {"quantity", "incident radiance, a delta from the direction"},
                               {"units", "radiometric"},
                               {"frame", "world"},
                               {"constants", constants},
                               {"textures", Json::array({entryOf(*direction, context), entryOf(*intensity, context)})},
                               {"source", {{"description", parameters.at("description")}}}};
    outcome.result["bytes_in"] = std::filesystem::file_size(context.action.inputs.at("source"));
    outcome.result["notes"] = {{"clamped_high", report->clampedHigh}, {"clamped_negative", report->clampedNegative}};
    return outcome;
}

}  // namespace pipeline
