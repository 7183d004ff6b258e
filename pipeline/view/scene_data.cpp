#include "pipeline/view/scene_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <span>

#include "formats/gpu_texture.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/light_map/unpacked_bake.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/results.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/cook/plan.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Half floats reach 65504. What a filter adds up of several texels stays below.
constexpr float kLargestReference = 32768;

/// Form of the texture of a bake.
struct ReferenceForm {
    float scale = 1;  ///< power of two, at most 1, that brings every coefficient to kLargestReference at most
    int layers = 1;   ///< coefficients up to the last one that is not 0: one for a flat map, four for two bands
};

Result<ReferenceForm> referenceForm(LightMapSource& bake) {
    ReferenceForm form;
    float largest = 0;
    for (int index = 0; index < bake.chunkCount(); ++index) {
        LC_TRY(chunk, bake.chunk(index));
        const formats::Image<lighting::ShRgb>& sh = (*chunk)->sh;
        for (int y = 0; y < sh.height(); ++y)
            for (int x = 0; x < sh.width(); ++x) {
                if ((*chunk)->covered.at(x, y) == 0) continue;
                const lighting::ShRgb& texel = sh.at(x, y);
                for (int layer = 0; layer < static_cast<int>(texel.size()); ++layer) {
                    const glm::vec3& coefficient = texel[static_cast<std::size_t>(layer)];
                    if (coefficient != glm::vec3(0)) form.layers = std::max(form.layers, layer + 1);
                    for (int channel = 0; channel < 3; ++channel) largest = std::max(largest, std::abs(coefficient[channel]));
                }
            }
    }
    if (largest > kLargestReference) form.scale = std::exp2(-std::ceil(std::log2(largest / kLargestReference)));
    return form;
}

/// Fails if a bake is too large for the page.
/// layers  coefficients that are not 0
Result<void> checkSize(const LightMapSource& bake, int layers, const std::filesystem::path& file) {
    if (std::int64_t{bake.width()} * bake.height() * layers <= kMostReferenceTexels) return {};
    return failure(ErrorCode::ValueOutOfRange, file,
                   fmt::format("found {} x {} texels of {}, the page takes 2048 x 2048 texels of nine coefficients, or as many colours",
                               bake.width(), bake.height(), layers == 1 ? "one coefficient" : fmt::format("{} coefficients", layers)));
}

/// Writes a bake as the texture that ViewedLightMap::reference describes.
Result<void> writeReference(LightMapSource& bake, const ReferenceForm& form, const std::filesystem::path& file, const RunState& state) {
    formats::TextureShape shape;
    shape.width = bake.width();
    shape.height = bake.height();
    shape.layerCount = form.layers;
    shape.isArray = true;
    LC_TRY(writer, formats::TextureWriter::create(file, shape, {}));
    std::vector<std::uint64_t> texels;
    for (int index = 0; index < bake.chunkCount(); ++index) {
        if (state.interrupted) return failure(ErrorCode::Interrupted, "view", "interrupted");
        LC_TRY(chunk, bake.chunk(index));
        const formats::LightMapStrip& strip = **chunk;
        for (int layer = 0; layer < form.layers; ++layer) {
            texels.clear();
            for (int y = 0; y < strip.sh.height(); ++y)
                for (int x = 0; x < strip.sh.width(); ++x) {
                    const bool isCovered = strip.covered.at(x, y) != 0;
                    const glm::vec3 light = isCovered ? form.scale * strip.sh.at(x, y)[static_cast<std::size_t>(layer)] : glm::vec3(0);
                    texels.push_back(glm::packHalf4x16(glm::vec4(light, isCovered && layer == 0 ? 1 : 0)));
                }
            LC_TRY(written, writer->writeBlockRows({0, layer, 0}, index * kChunkRows, std::as_bytes(std::span(texels))));
        }
    }
    return writer->commit();
}

/// Returns the mesh that a light map lights.
std::optional<std::string> meshOf(const Manifest& manifest, const std::string& lightMap) {
    for (const CookedAsset& asset : manifest.assets)
        if (asset.kind == AssetKind::Mesh && asset.lightMap == lightMap) return asset.name;
    return std::nullopt;
}

/// Writes the bakes of light maps, and describes how they are shown.
class References {
public:
    References(const ViewFolders& folders, const RunState& state) : folders_(folders), state_(state) {}

    /// Adds the bake of a light map to its description.
    Result<void> add(const CookedAsset& asset, ViewedLightMap& map) {
        LC_TRY(sources, unchangedSources(asset, folders_.sceneDirectory));
        LC_TRY(description, descriptionOf(asset));
        LC_TRY(unpacked, unpackedBakeOf(asset));
        if (*unpacked) description->constantOf = {};  // may be true of the texels of its charts alone
        if (const auto config = sources->find(kColorConfigRole); config != sources->end()) description->colors.config = config->second;
        const Action action = verifyAction(asset.name, asset.kind, *sources, asset.verify.value_or(Json::object()));
        const ActionContext context{action, folders_.bakes, folders_.cooked, {}, shared_, state_};
        LC_TRY(parameters, parametersOf<LightMapVerifyParameters>(context));
        map.shading = ViewedShading{parameters->shading.normalMapTilt, {}, {}};
        map.shading->m.assign(parameters->shading.m.begin(), parameters->shading.m.end());
        map.shading->f0.assign(parameters->shading.f0.begin(), parameters->shading.f0.end());
        LC_TRY(bake, openLightMap(context, *description));
        LC_CHECK(checkSize(**bake, 1, action.inputs.at(kSourceRole)));
        LC_TRY(survey, (*bake)->survey(context));
        LC_TRY(form, referenceForm(**bake));
        LC_CHECK(checkSize(**bake, form->layers, action.inputs.at(kSourceRole)));
        const std::string name = fmt::format("{}.reference.ktx2", asset.name);
        LC_CHECK(writeReference(**bake, *form, folders_.bakes / name, state_));
        map.display = parameters->display.of((*survey)->key.displayKey());
        map.referenceScale = double(form->scale);
        map.referenceLayers = form->layers;
        map.reference = fmt::format("{}/{}", kViewerFolder, name);
        return {};
    }

private:
    const ViewFolders& folders_;
    const RunState& state_;
    SharedObjects shared_;
};

}  // namespace

Result<ViewedScene> describeForView(const Manifest& manifest, const ViewFolders& folders, const RunState& state) {
    ViewedScene scene;
    scene.scene = manifest.scene;
    scene.tool = manifest.tool;
    References references(folders, state);
    for (const CookedAsset& asset : manifest.assets) {
        if (asset.kind != AssetKind::LightMap) continue;
        ViewedLightMap map;
        map.name = asset.name;
        map.mesh = meshOf(manifest, asset.name);
        if (auto added = references.add(asset, map); !added) {
            if (added.error().code == ErrorCode::Interrupted || added.error().code == ErrorCode::Internal)
                return tl::make_unexpected(added.error());
            map.referenceMissing = added.error().line();
        }
        scene.lightMaps.push_back(std::move(map));
    }
    return scene;
}

}  // namespace lightcook::pipeline
