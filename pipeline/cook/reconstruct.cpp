#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "formats/light_map.h"
#include "pipeline/assets/light_map/chart_places.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/packed_reading.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/unpacked_bake.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/cook/cook.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Rows of a texture can be read from a multiple of this on.
constexpr int kReadRows = 16;

/// Returns the light map of a name.
Result<const CookedAsset*> findLightMap(const Manifest& manifest, const std::filesystem::path& folder, const std::string& name) {
    std::vector<std::string> known;
    for (const CookedAsset& asset : manifest.assets) {
        if (asset.kind != AssetKind::LightMap) continue;
        if (asset.name == name) return &asset;
        known.push_back(asset.name);
    }
    return failure(ErrorCode::InvalidRequest, folder,
                   fmt::format("found no light map '{}', expected one of: {}", name, fmt::join(known, ", ")));
}

/// Opens the bake of a light map, also of one whose charts were packed. Fails unless it lies where it was cooked from, unchanged.
/// sceneFolder  that its files are relative to
Result<LightMapSource*> openBake(LightMapSources& bakes, const CookedAsset& asset, const std::optional<UnpackedBake>& unpacked,
                                 const std::filesystem::path& sceneFolder) {
    LC_TRY(description, unpacked ? Result<formats::LightMapDescription>(unpacked->description) : descriptionOf(asset));
    description->constantOf = {};
    LC_TRY(sources, unchangedSources(asset, sceneFolder));
    const auto source = sources->find(kSourceRole);
    if (source == sources->end()) return failure(ErrorCode::Verification, asset.name, "found no source, expected the bake");
    return bakes.open(source->second, withFiles(std::move(*description), *sources));
}

/// Writes the rows of a light map, beside the coverage and the normals of its bake at the nearest texels if these are known.
class ReconstructionWriter {
public:
    /// bake  null: the coefficients alone are written
    static Result<ReconstructionWriter> create(const std::filesystem::path& output, const glm::ivec2& size, int placesPerTexel,
                                               LightMapSource* bake) {
        const auto surface = bake != nullptr ? formats::SurfaceOutput::CoverageAndNormals : formats::SurfaceOutput::None;
        LC_TRY(writer, formats::LightMapWriter::create(output, size.x, size.y, surface));
        return ReconstructionWriter(std::move(*writer), placesPerTexel, bake);
    }

    Result<void> append(formats::ImageView<const lighting::ShRgb> rows) {
        if (bake_ == nullptr) return writer_.append(rows);
        formats::Image<std::uint8_t> covered(rows.width, rows.height);
        formats::Image<glm::vec3> normal(rows.width, rows.height);
        for (int y = 0; y < rows.height; ++y) {
            const int row = (firstRow_ + y) / placesPerTexel_;
            LC_TRY(chunk, bake_->chunk(row / kChunkRows));
            for (int x = 0; x < rows.width; ++x) {
                const glm::ivec2 texel(x / placesPerTexel_, row - (*chunk)->firstRow);
                covered.at(x, y) = (*chunk)->covered.at(texel.x, texel.y);
                normal.at(x, y) = (*chunk)->normal.at(texel.x, texel.y);
            }
        }
        firstRow_ += rows.height;
        return writer_.append(rows, {covered.view(), normal.view()});
    }
    Result<void> commit() { return writer_.commit(); }

private:
    ReconstructionWriter(formats::LightMapWriter writer, int placesPerTexel, LightMapSource* bake)
        : writer_(std::move(writer)), placesPerTexel_(placesPerTexel), bake_(bake) {}

    formats::LightMapWriter writer_;
    int placesPerTexel_;
    LightMapSource* bake_;
    int firstRow_ = 0;
};

/// Appends the rows of a map of constant light: the cooked block repeats over it.
/// size  [texels of the output]
Result<void> appendConstant(const CookedLightMapReader& cooked, const glm::ivec2& size, ReconstructionWriter& writer,
                            const RunState& state) {
    LC_TRY(texels, cooked.read(0, cooked.height()));
    const auto block = cooked.verifier().reconstruct(*texels, 0, cooked.height());
    for (int row = 0; row < size.y; row += kChunkRows) {
        if (state.interrupted) return failure(ErrorCode::Interrupted, "reconstruct", "interrupted");
        formats::Image<lighting::ShRgb> rows(size.x, std::min(kChunkRows, size.y - row));
        for (int y = 0; y < rows.height(); ++y)
            for (int x = 0; x < size.x; ++x) rows.at(x, y) = block.at(x % block.width(), (row + y) % block.height());
        LC_CHECK(writer.append(rows.view()));
    }
    return {};
}

/// Returns where the charts of a light map were packed to, from the mesh of the cook.
/// sceneFolder  that sources are relative to
Result<ChartPlaces> chartPlacesOf(const CookedAsset& asset, const UnpackedBake& bake, const std::filesystem::path& sceneFolder) {
    CookedAsset needed = asset;  // the bake is not read
    if (needed.source.files) std::erase_if(*needed.source.files, [](const auto& file) { return !file.first.starts_with(kMeshRole); });
    LC_TRY(sources, unchangedSources(needed, sceneFolder));
    const auto mesh = sources->find(kMeshRole);
    if (mesh == sources->end())
        return failure(ErrorCode::Verification, asset.name, "found packed charts without a mesh, expected the folder as cooked");
    LC_TRY(scene, loadMesh(*sources, kMeshRole, bake.description.places));
    return ChartPlaces::create(*scene, mesh->second, bake);
}

/// Appends a map whose charts were packed, at the texels of its bake.
/// size  [texels of the output]
Result<void> appendUnpacked(const ChartPlaces& charts, const CookedLightMapReader& cooked, const glm::ivec2& size, int placesPerTexel,
                            ReconstructionWriter& writer, const RunState& state) {
    SharedObjects shared;
    const Action action{"", "", "reconstruct", {}, {}, {}};
    const ActionContext context{action, {}, {}, {}, shared, state};
    const int rowsAtOnce = std::max(1, kPlacesAtOnce / size.x);
    for (int row = 0; row < size.y; row += rowsAtOnce) {
        formats::Image<lighting::ShRgb> rows(size.x, std::min(rowsAtOnce, size.y - row));
        std::vector<glm::dvec2> places;
        places.reserve(rows.texels().size());
        for (int y = row; y < row + rows.height(); ++y)
            for (int x = 0; x < size.x; ++x) places.push_back((glm::dvec2(x, y) + 0.5) / static_cast<double>(placesPerTexel) - 0.5);
        LC_TRY(decoded, decodedAt(places, {charts, cooked}, context));
        for (std::size_t i = 0; i < places.size(); ++i)
            if (charts.packed(places[i])) rows.texels()[i] = (*decoded)[i];
        LC_CHECK(writer.append(rows.view()));
    }
    return {};
}

/// Appends a map at its own texels, or at places between them.
Result<void> appendTexels(const CookedLightMapReader& cooked, int placesPerTexel, ReconstructionWriter& writer, const RunState& state) {
    for (int row = 0; row < cooked.height(); row += kChunkRows) {
        if (state.interrupted) return failure(ErrorCode::Interrupted, "reconstruct", "interrupted");
        const int rowCount = std::min(kChunkRows, cooked.height() - row);
        // Places between texels need the row above, too; blocks are read in whole rows.
        const int firstRow = placesPerTexel > 1 ? std::max(0, row - kReadRows) : row;
        LC_TRY(texels, cooked.read(firstRow, row + rowCount + 1 - firstRow));
        const auto rows = cooked.verifier().reconstruct(*texels, row, rowCount, placesPerTexel);
        LC_CHECK(writer.append(rows.view()));
    }
    return {};
}

/// Returns the bake if it says anything of the surface, and null with a warning if it is not there. A bake of another size is that of
/// another map.
/// size  of the bake as cooked [texels]
LightMapSource* surfaceOf(const Result<LightMapSource*>& bake, const glm::ivec2& size, const std::filesystem::path& output,
                          const RunState& state) {
    const bool isSame = bake && glm::ivec2((*bake)->width(), (*bake)->height()) == size;
    if (isSame) return (*bake)->hasCoverage() || (*bake)->hasNormals() ? *bake : nullptr;
    if (state.warning)
        state.warning(output.string(), fmt::format("wrote no coverage and no normals, which are those of the bake: {}",
                                                   bake ? "its size is another one than when it was cooked" : bake.error().line()));
    return nullptr;
}

}  // namespace

Result<void> reconstructLightMap(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& output,
                                 int placesPerTexel, const RunState& state) {
    LC_TRY(manifest, loadManifest(folder));
    LC_TRY(asset, findLightMap(*manifest, folder, name));
    if (formats::isInTangentSpace((*asset)->layout))
        return failure(
            ErrorCode::InvalidRequest, fmt::format("light map '{}'", (*asset)->name),
            fmt::format("found layout {}, expected one that stores SH coefficients: what it shows is a function of the normal in "
                        "tangent space, which no coefficients have",
                        (*asset)->layout));
    LC_TRY(unpacked, unpackedBakeOf(**asset));
    LC_TRY(description, descriptionOf(**asset));
    const bool isUnpacked = *unpacked && !description->constantOf;
    LC_TRY(cooked, CookedLightMapReader::open(folder, **asset, {}));
    const glm::ivec2 size = isUnpacked ? glm::ivec2((*unpacked)->packing.widthBefore, (*unpacked)->packing.heightBefore)
                                       : description->constantOf.value_or(glm::ivec2(cooked->width(), cooked->height()));
    LightMapSources bakes;
    LightMapSource* const bake = surfaceOf(openBake(bakes, **asset, *unpacked, folder / manifest->sceneDirectory), size, output, state);
    LC_TRY(writer, ReconstructionWriter::create(output, placesPerTexel * size, placesPerTexel, bake));
    const auto append = [&]() -> Result<void> {
        if (!isUnpacked && description->constantOf) return appendConstant(*cooked, placesPerTexel * size, *writer, state);
        if (!isUnpacked) return appendTexels(*cooked, placesPerTexel, *writer, state);
        LC_TRY(charts, chartPlacesOf(**asset, **unpacked, folder / manifest->sceneDirectory));
        return appendUnpacked(*charts, *cooked, placesPerTexel * size, placesPerTexel, *writer, state);
    };
    LC_CHECK(append());
    return writer->commit();
}

}  // namespace lightcook::pipeline
