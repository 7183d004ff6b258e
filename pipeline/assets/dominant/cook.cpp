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
        LC_CHECK(writeTo(intensity, formats.intensity, rows.intensity));
        LC_CHECK(writeTo(direction, formats.direction, rows.direction));
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
        LC_TRY(rows, encoder.encode(index));
        LC_CHECK(outputs.write(*rows, encoder.formats()));
        return StripReport{rows->report, rows->fitted};
    };
    LC_TRY(reports, mapInOrder<StripReport>(source.stripCount(), context, "encode " + context.action.asset, encodeStrip));
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
    LC_TRY(direction, create("direction", encoder.formats().direction));
    if (encoder.hasResidual()) {
        LC_TRY(residual, create("residual", encoder.formats().direction));
        outputs.residual = *residual;
    }
    LC_TRY(intensity, create("intensity", encoder.formats().intensity));
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

std::vector<PixelFormat> dominantFormats(formats::Target target) {
    const DominantFormats formats = dominantFormatsOf(target);
    std::vector<PixelFormat> all = {formats.direction, formats.intensity};
    if (formats.hasResidual) all.push_back(formats.direction);
    return all;
}

Result<ActionOutcome> cookDominant(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<DominantParameters>(context));
    LC_TRY(source, openLightMap(context, parameters->description));
    LC_TRY(encoder, DominantEncoder::create(**source, *parameters, context));
    LC_TRY(outputs, createOutputs(*encoder, parameters->textures, context));
    LC_TRY(report, encodeStrips(**source, *encoder, *outputs, context));

    CookResult result{makeCookedAsset(context.action.asset, AssetKind::Dominant, kTextureLayout, encoder->size().x, encoder->size().y),
                      bakeBytes(context.action), notesOf(parameters->fit, encoder->fit(), *report)};
    result.asset.fit = parameters->fit;
    result.asset.lightMap = parameters->lightMap;
    result.asset.constants = toJson(encoder->constants());
    result.asset.source.description = toJson(parameters->description);
    return outputs->files.finish(std::move(result));
}

}  // namespace lightcook::pipeline
