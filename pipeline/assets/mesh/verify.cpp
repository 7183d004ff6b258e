#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/mesh/quantization.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/mesh.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Collects the covered texels of a bake.
Result<verify::CoveredTexels> coverageOf(LightMapSource& bake, const ActionContext& context) {
    verify::CoveredTexels covered(bake.width(), bake.height());
    const auto walked = mapInOrder<int>(bake.chunkCount(), context, "survey " + context.action.asset, [&](int index) -> Result<int> {
        LC_TRY(chunk, bake.chunk(index));
        covered.add(**chunk, (*chunk)->firstRow, bake.chunkRows(index));
        return 0;
    });
    if (!walked) return tl::make_unexpected(walked.error());
    return covered;
}

/// Checks that each vertex names the cluster of the light map that its triangles lie in.
/// uvShift  largest distance that quantization moved light-map UVs [UV units]
Result<void> verifyClusters(const ActionContext& context, const CookedAsset& mesh, const formats::GltfScene& cooked, double uvShift,
                            LightMapSource& bake) {
    LC_TRY(lightMap, upstreamAsset(context, 1));
    if (lightMap->width != bake.width() || lightMap->height != bake.height())
        return formats::failure(formats::ErrorCode::Verification, context.action.inputs.at("source"),
                                fmt::format("found {} x {} texels, expected {} x {} as cooked", bake.width(), bake.height(),
                                            lightMap->width, lightMap->height));
    LC_TRY(map, clusterMapOf(*lightMap));
    LC_TRY(covered, coverageOf(bake, context));
    constexpr double kEdgeRounding = 1e-2;  // [texels]
    const double inset = uvShift * std::max(map->width, map->height) + kEdgeRounding;
    for (const formats::TriangleMesh* primitive : cooked.triangleMeshes())
        if (const auto mistake = verify::clusterMistake(*primitive, *map, *covered, inset))
            return formats::failure(formats::ErrorCode::Verification, mesh.file.value_or(mesh.name), *mistake);
    return {};
}

/// Returns the faults of a mesh. Vertices lie at most half a step of the manifest's lattice from their source; without a lattice they do
/// not move. Light-map UVs stay in their texel: beyond it another chart may begin, and the gradient says nothing of the error.
std::vector<verify::Violation> violationsOf(const formats::MeshError& moved, const verify::MeshShift& shift,
                                            const MeshQuantization& quantization) {
    std::vector<verify::Violation> violations;
    const auto expect = [&](const char* place, const std::string& unit, double found, double allowed, const std::string& why) {
        if (found > allowed)
            violations.push_back(
                {place, fmt::format("{:.4g} {} from the source", found, unit), fmt::format("at most {:.4g}{}", allowed, why)});
    };
    constexpr double kFloats = 1e-6;
    // stepsAllowed  of a lattice that divides the extent
    const auto expectWithinBits = [&](const char* place, const std::string& unit, double found, double extent, std::optional<int> bits,
                                      double stepsAllowed) {
        const int count = bits.value_or(0);
        const double share = count > 0 ? stepsAllowed / latticeSteps(count) : 0;
        expect(place, unit, found, extent * (share + kFloats), count > 0 ? fmt::format(" with {} bits", count) : ": not quantized");
    };
    expectWithinBits("positions", "scene units", moved.position, moved.positionExtent, quantization.positionBits, kPositionSteps);
    expectWithinBits("light-map UVs", "of their range", moved.lightMapUv, moved.lightMapUvExtent, quantization.lightMapUvBits, kUvSteps);
    expectWithinBits("normals", "radians", moved.normalRadians, 1, quantization.normalBits, kNormalSteps);
    expect("light-map UVs", "texels", std::max(shift.uTexels, shift.vTexels), kMostUvTexels, " texels");
    return violations;
}

/// Checks that the light-map UVs are those at which the seams of the light map are measured.
void checkUvsAtSeams(const formats::MeshError& moved, const verify::MeshShift& shift, const LightMapSource& bake,
                     std::vector<verify::Violation>& violations) {
    const double found = std::max(shift.uTexels, shift.vTexels),
                 allowed = mostUvShiftAtSeams(moved.lightMapUvExtent * std::max(bake.width(), bake.height()));
    if (found > allowed)
        violations.push_back({"light-map UVs", fmt::format("{:.4g} texels from the source", found),
                              fmt::format("at most {:.4g}: max_seam is judged at the UVs of the source", allowed)});
}

/// Compares the bits in the manifest with those of the Draco streams.
void checkBits(const CookedAsset& asset, const formats::MeshError& moved, std::vector<verify::Violation>& violations) {
    const MeshQuantization bits = asset.quantization.value_or(MeshQuantization{});
    const auto check = [&](const char* key, const char* semantic, const std::optional<int>& stated) {
        const auto found = moved.dracoBits.find(semantic);
        if (found == moved.dracoBits.end()) return;
        for (const int ofStream : found->second)
            if (ofStream != stated.value_or(0))
                violations.push_back({fmt::format("quantization/{}", key), fmt::format("{}", stated.value_or(0)),
                                      fmt::format("{} of {} in the file", ofStream, semantic)});
    };
    if (asset.layout != kDracoMeshLayout) return;  // a stream of the source has the bits that it had
    check("position_bits", "POSITION", bits.positionBits);
    check("normal_bits", "NORMAL", bits.normalBits);
    check("uv_bits", "TEXCOORD_0", bits.uvBits);
    check("light_map_uv_bits", "TEXCOORD_1", bits.lightMapUvBits);
}

/// Checks the figures of memory in the manifest, by which a budget is kept. Primitives that share vertices may count them once or several
/// times, and lines and points have no light map.
void checkMeshSize(const CookedAsset& asset, const formats::GltfScene& cooked, std::vector<verify::Violation>& violations) {
    std::uint64_t used = 0;
    for (const formats::TriangleMesh* primitive : cooked.triangleMeshes()) used += primitive->vertexCount();
    const auto all = std::max(used, static_cast<std::uint64_t>(cooked.vertexCount()));
    const auto expect = [&](const char* place, std::uint64_t found, std::uint64_t low, std::uint64_t high) {
        if (found < low || found > high)
            violations.push_back({place, fmt::format("{}", found),
                                  low == high ? fmt::format("{} of the file", low) : fmt::format("{} to {} of the file", low, high)});
    };
    const std::uint64_t perVertex = bytesOfVertex(asset.layout == kDracoMeshLayout, asset.basis.has_value());
    const auto triangles = static_cast<std::uint64_t>(cooked.triangleCount());
    expect("vertices", asset.vertices.value_or(0), used, all);
    expect("triangles", asset.triangles.value_or(0), triangles, triangles);
    expect("bytes_gpu", asset.bytesGpu.value_or(0), used * perVertex, all * perVertex);
}

/// The distances by which vertices of a mesh moved; `positionTexels` in texels of its light map.
struct MovedMesh {
    verify::MeshShift shift;
    double positionTexels = 0;
};

/// Shading errors of some strips.
struct MeshShadingErrors {
    verify::ErrorAccumulator energy;
    verify::VisiblePairs visible;

    MeshShadingErrors(double key, const verify::Viewing& viewing) : energy(key), visible(viewing) {}
    void merge(const MeshShadingErrors& other) {
        energy.merge(other.energy);
        visible.merge(other.visible);
    }
};

/// Returns the shading errors of a mesh whose vertices moved, and draws them over the light map.
Result<MeshShadingErrors> shadingErrors(LightMapSource& bake, const MovedMesh& moved, double key, const verify::Viewing& viewing,
                                        const ActionContext& context, Preview& preview) {
    const auto compareStrip = [&](int index) -> Result<MeshShadingErrors> {
        LC_TRY(strip, bake.stripWithMargin(index, 1, 2));
        MeshShadingErrors part(key, viewing);
        const int firstRow = bake.stripFirstRow(index), rowCount = bake.stripRows(index);
        verify::addMeshShiftErrors(*strip, firstRow, rowCount, moved.shift, key, part.energy,
                                   [&](int x, int y, const glm::vec3& lit, const glm::vec3& seen) { preview.set(x, y, lit, seen); });
        verify::addMeshShiftVisible(*strip, firstRow, rowCount, moved.shift, moved.positionTexels, part.visible);
        verify::addMeshShiftVisibleBound(*strip, firstRow, rowCount, moved.shift, moved.positionTexels, viewing, part.visible);
        return part;
    };
    MeshShadingErrors errors(key, viewing);
    const auto compared = foldInOrder<MeshShadingErrors>(bake.stripCount(), context, "verify " + context.action.asset, compareStrip,
                                                         [&](const MeshShadingErrors& part) { errors.merge(part); });
    if (!compared) return tl::make_unexpected(compared.error());
    return errors;
}

/// Returns the figures of a mesh. The places of the largest visible error and of its bound name the triangle of the source.
verify::ErrorFigures figuresOf(const MeshShadingErrors& errors, const std::vector<const formats::TriangleMesh*>& meshes, int width,
                               int height) {
    verify::ErrorFigures figures = errors.energy.figures();
    figures.visible = errors.visible.figures();
    if (figures.visible)
        for (verify::VisiblePlace* at : {&figures.visible->maxAt, &figures.visible->boundAt})
            if (at->isKnown()) verify::findTriangle(meshes, width, height, *at);
    return figures;
}

}  // namespace

Result<ActionOutcome> verifyMesh(const ActionContext& context) {
    const Stopwatch watch;
    LC_TRY(asset, upstreamAsset(context));
    LC_TRY(parameters, parametersOf<VisibleParameters>(context));
    LC_TRY(description, descriptionOf(*asset));
    LC_TRY(source, loadMesh(context.action.inputs, kMeshRole, description->places));
    LC_TRY(cooked, formats::GltfScene::load(context.upstreamFolder / asset->file.value_or("")));
    LC_TRY(moved, source->errorOf(*cooked));
    LC_TRY(opened, openLightMap(context, *description));
    LightMapSource& bake = **opened;
    if (asset->basis) LC_CHECK(verifyClusters(context, *asset, *cooked, moved->lightMapUv, bake));
    LC_TRY(survey, bake.survey(context));
    const double key = (*survey)->key.key();
    const auto meshes = source->triangleMeshes();
    const verify::MeshShift shift{moved->lightMapUv * bake.width(), moved->lightMapUv * bake.height(), moved->normalRadians};
    const double positionTexels = moved->position * verify::texelsPerUnit(meshes, bake.width(), bake.height());
    const verify::Viewing viewing = parameters->viewing((*survey)->key.displayKey(), bake.bt2020FromWorking());
    Preview preview(bake.width(), bake.height(), key);
    LC_TRY(errors, shadingErrors(bake, {shift, positionTexels}, key, viewing, context, preview));

    verify::StageError stage;
    stage.name = "quantize";
    stage.diffuse = figuresOf(*errors, meshes, bake.width(), bake.height());
    std::vector<verify::Violation> violations = violationsOf(*moved, shift, asset->quantization.value_or(MeshQuantization{}));
    // The seams of the light map were measured at the UVs of the source.
    Limits limits = parameters->limits;
    if (std::exchange(limits[Limit::Seam], {})) checkUvsAtSeams(*moved, shift, bake, violations);
    checkBits(*asset, *moved, violations);
    checkMeshSize(*asset, *cooked, violations);
    VerifyResult result = judged({stage}, limits, watch, std::move(violations));
    result.light.emplace().diffuseRms = errors->energy.referenceRms();
    result.meshError = {moved->position, moved->normalRadians, moved->lightMapUv};
    return outcomeWithPreview(std::move(result), preview, context);
}

}  // namespace lightcook::pipeline
