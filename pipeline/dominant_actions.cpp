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

}  // namespace

Result<ActionOutcome> cookDominant(const ActionContext& context) {
    const Json& parameters = context.action.parameters;
    const TextureSettings settings = TextureSettings::fromJson(parameters.at("textures"));
    const auto description = lightMapDescriptionFromJson(parameters.at("description"), context.action.asset);
    if (!description) return tl::make_unexpected(description.error());
    const auto opened = context.lightMaps.open(context.action.inputs.at("source"), *description);
    if (!opened) return tl::make_unexpected(opened.error());
    LightMapSource& source = **opened;
    fit::DominantLightOptions fitOptions;
    fitOptions.luminanceWeights = source.luminanceWeights();

    const auto brightest =
        forEachBand<float>(source.bandCount(), context, "measure " + context.action.asset, [&](int index) -> Result<float> {
            const auto band = source.band(index);
            if (!band) return tl::make_unexpected(band.error());
            const DominantRows rows = fitRows(**band, (*band)->firstRow, source.bandRows(index), fitOptions);
            float largest = 0;
            for (const glm::vec4& value : rows.intensity.texels()) largest = std::max({largest, value.x, value.y, value.z});
            return largest;
        });
    if (!brightest) return tl::make_unexpected(brightest.error());
    const float range = hdrRange(*std::max_element(brightest->begin(), brightest->end()));

    const Formats pixelFormats = formatsOf(parameters.at("target").get<std::string>());
    formats::TextureShape directionShape, intensityShape;
    directionShape.format = pixelFormats.direction;
    intensityShape.format = pixelFormats.intensity;
    directionShape.width = intensityShape.width = source.width();
    directionShape.height = intensityShape.height = source.height();
    const Json constants = {{"direction_scale", pixelFormats.isSignedDirection ? 1.0 : 2.0},
                            {"direction_bias", pixelFormats.isSignedDirection ? 0.0 : -1.0},
                            {"intensity_range", range}};
    const std::map<std::string, std::string> metadata = {{"io.lightcook", Json({{"layout", "dominant"}, {"constants", constants}}).dump()}};
    const std::string directionFile = context.action.asset + "_direction" + std::string(settings.extension());
    const std::string intensityFile = context.action.asset + "_intensity" + std::string(settings.extension());
    auto direction = createTexture(context.folder / directionFile, directionShape, settings, metadata);
    if (!direction) return tl::make_unexpected(direction.error());
    auto intensity = createTexture(context.folder / intensityFile, intensityShape, settings, metadata);
    if (!intensity) return tl::make_unexpected(intensity.error());

    compress::EncodeOptions options;
    options.effort = settings.effort;
    using Report = compress::EncodeReport;
    const auto reports =
        forEachBand<Report>(source.bandCount(), context, "encode " + context.action.asset, [&](int index) -> Result<Report> {
            const auto band = source.bandWithMargin(index, kPaddingRows, kPaddingRows);
            if (!band) return tl::make_unexpected(band.error());
            const int firstRow = index * kBandRows;
            DominantRows rows = fitRows(*band, firstRow, source.bandRows(index), fitOptions);
            for (glm::vec4& value : rows.direction.texels())
                if (!pixelFormats.isSignedDirection) value = 0.5f * value + 0.5f;
            for (glm::vec4& value : rows.intensity.texels()) value /= range;
            Report report;
            const auto write = [&](formats::TextureWriter& writer, PixelFormat format,
                                   formats::ImageView<const glm::vec4> texels) -> Result<void> {
                const auto bytes = encodeImage(format, texels, rows.significance.view(), options, report);
                return writer.writeBlockRows({}, firstRow / formats::info(format).blockHeight, bytes);
            };
            if (auto written = write(*direction, pixelFormats.direction, rows.direction.view()); !written)
                return tl::make_unexpected(written.error());
            if (auto written = write(*intensity, pixelFormats.intensity, rows.intensity.view()); !written)
                return tl::make_unexpected(written.error());
            return report;
        });
    if (!reports) return tl::make_unexpected(reports.error());
    if (auto committed = direction->commit(); !committed) return tl::make_unexpected(committed.error());
    if (auto committed = intensity->commit(); !committed) return tl::make_unexpected(committed.error());

    ActionOutcome outcome;
    outcome.files = {directionFile, intensityFile};
    const Json textures = {
        textureEntry("direction", directionFile, directionShape, std::filesystem::file_size(context.folder / directionFile), {}),
        textureEntry("intensity", intensityFile, intensityShape, std::filesystem::file_size(context.folder / intensityFile), {})};
    outcome.result["asset"] = {{"name", context.action.asset},
                               {"kind", "dominant"},
                               {"layout", "direction-intensity"},
                               {"width", source.width()},
                               {"height", source.height()},
                               {"quantity", "incident radiance, a delta from the direction"},
                               {"units", "radiometric"},
                               {"frame", "world"},
                               {"constants", constants},
                               {"textures", textures},
                               {"source", {{"description", parameters.at("description")}}}};
    outcome.result["bytes_in"] = std::filesystem::file_size(context.action.inputs.at("source"));
    Report total;
    for (const Report& each : *reports) total.add(each);
    outcome.result["notes"] = {{"clamped_high", total.clampedHigh}, {"clamped_negative", total.clampedNegative}};
    return outcome;
}

}  // namespace pipeline
