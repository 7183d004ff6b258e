#include "pipeline/assets/dominant/dominant.h"

#include <fmt/format.h>

#include <optional>

#include "formats/vocabulary.h"
#include "pipeline/assets/dominant/encoder.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::PixelFormat;
using formats::Result;

/// Layout of all sizes of a dominant light, as the manifest names it.
constexpr const char* kTextureLayout = "direction-intensity";

/// The textures of the asset, by their index in AssetTextures.
struct Outputs {
    AssetTextures files;
    std::size_t direction = 0, intensity = 0;
    std::optional<std::size_t> residual;

    Result<void> write(const EncodedDominantRows& rows, const DominantFormats& formats) {
        const auto writeTo = [&](std::size_t output, PixelFormat format, const std::vector<std::byte>& bytes) {
            return files.writer(output).writeBlockRows({}, rows.firstRow / formats::info(format).blockHeight, bytes);
        };
        if (auto written = writeTo(intensity, formats.intensity, rows.intensity); !written) return written;
        if (auto written = writeTo(direction, formats.direction, rows.direction); !written) return written;
        return residual ? writeTo(*residual, formats.direction, rows.residual) : Result<void>();
    }
};

struct StripReport {
    compress::EncodeReport encoded;
    DominantFitCounts fitted;
    void add(const StripReport& other) {
        encoded.add(other.encoded);
        fitted.add(other.fitted);
    }
};

Result<StripReport> encodeStrips(LightMapSource& source, const DominantEncoder& encoder, Outputs& outputs, const ActionContext& context) {
    const auto encodeStrip = [&](int index) -> Result<StripReport> {
        const auto rows = encoder.encode(index);
        if (!rows) return tl::make_unexpected(rows.error());
        if (auto written = outputs.write(*rows, encoder.formats()); !written) return tl::make_unexpected(written.error());
        return StripReport{rows->report, rows->fitted};
    };
    const auto reports = mapInOrder<StripReport>(source.stripCount(), context, "encode " + context.action.asset, encodeStrip);
    if (!reports) return tl::make_unexpected(reports.error());
    StripReport total;
    for (const StripReport& each : *reports) total.add(each);
    return total;
}

/// Creates the files of all textures, in the order of the manifest.
Result<Outputs> createOutputs(const DominantEncoder& encoder, const TextureSettings& settings, const ActionContext& context) {
    Outputs outputs{AssetTextures(context, settings, {AssetKind::Dominant, kTextureLayout}), 0, 0, {}};
    const auto create = [&](const std::string& role, PixelFormat format) {
        formats::TextureShape shape;
        shape.format = format;
        shape.width = encoder.size().x;
        shape.height = encoder.size().y;
        return outputs.files.create({role, context.action.asset + "_" + role, shape, toJson(encoder.constants())});
    };
    const auto direction = create("direction", encoder.formats().direction);
    if (!direction) return tl::make_unexpected(direction.error());
    if (encoder.hasResidual()) {
        const auto residual = create("residual", encoder.formats().direction);
        if (!residual) return tl::make_unexpected(residual.error());
        outputs.residual = *residual;
    }
    const auto intensity = create("intensity", encoder.formats().intensity);
    if (!intensity) return tl::make_unexpected(intensity.error());
    outputs.direction = *direction;
    outputs.intensity = *intensity;
    return outputs;
}

Json notesOf(const std::string& fitName, fit::DominantFit fit, const StripReport& report) {
    Json notes = {{note_keys::kFit, fitName}};
    if (fit != fit::DominantFit::Closed) {
        notes[note_keys::kRefined] = report.fitted.texels.refined;
        notes[note_keys::kSkipped] = report.fitted.texels.skipped;
        notes[note_keys::kSolvedWithNeighbours] = report.fitted.solved;
    }
    notes[note_keys::kClampedHigh] = report.encoded.clampedHigh;
    notes[note_keys::kClampedNegative] = report.encoded.clampedNegative;
    return notes;
}

}  // namespace

std::vector<PixelFormat> dominantFormats(formats::Target target, bool withResidual) {
    const DominantFormats formats = dominantFormatsOf(target);
    std::vector<PixelFormat> all = {formats.direction, formats.intensity};
    if (withResidual && formats.hasResidual) all.push_back(formats.direction);
    return all;
}

formats::Result<const DominantLayoutInfo*> dominantLayoutOf(const std::string& asset, const DominantParameters& parameters) {
    const DominantLayoutInfo* layout = dominantLayoutFromName(parameters.layout.value_or(std::string(allDominantLayouts().front().name)));
    if (layout != nullptr && layout->divisor > 0) return layout;
    return formats::failure(formats::ErrorCode::InvalidRequest, asset + ", layout",
                            fmt::format("found \"{}\", expected {}", *parameters.layout, formats::listOfNames(allDominantLayouts())));
}

Result<ActionOutcome> cookDominant(const ActionContext& context) {
    const auto parameters = parametersOf<DominantParameters>(context);
    if (!parameters) return tl::make_unexpected(parameters.error());
    const auto layout = dominantLayoutOf(context.action.asset, *parameters);
    if (!layout) return tl::make_unexpected(layout.error());
    const auto source = openLightMap(context, parameters->description);
    if (!source) return tl::make_unexpected(source.error());
    const auto encoder = DominantEncoder::create(**source, *parameters, **layout, context);
    if (!encoder) return tl::make_unexpected(encoder.error());
    auto outputs = createOutputs(*encoder, parameters->textures, context);
    if (!outputs) return tl::make_unexpected(outputs.error());
    const auto report = encodeStrips(**source, *encoder, *outputs, context);
    if (!report) return tl::make_unexpected(report.error());

    CookResult result{makeCookedAsset(context.action.asset, AssetKind::Dominant, kTextureLayout, encoder->size().x, encoder->size().y),
                      bakeBytes(context.action), notesOf(parameters->fit, encoder->fit(), *report)};
    result.asset.fit = parameters->fit;
    result.asset.lightMap = parameters->lightMap;
    result.asset.constants = toJson(encoder->constants());
    result.asset.source.description = toJson(parameters->description);
    return outputs->files.finish(std::move(result));
}

}  // namespace lightcook::pipeline
