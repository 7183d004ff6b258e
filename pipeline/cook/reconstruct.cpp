#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "formats/light_map.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/cook/cook.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/repack/chart_places.h"
#include "pipeline/repack/packed_reading.h"
#include "pipeline/repack/unpacked_bake.h"

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
    return failure(ErrorCode::InvalidRequest, folder.string(),
                   fmt::format("found no light map '{}', expected one of: {}", name, fmt::join(known, ", ")));
}

/// Appends the rows of a map of constant light: the cooked block repeats over it.
/// size  [texels of the output]
Result<void> appendConstant(const CookedLightMapReader& cooked, const glm::ivec2& size, formats::LightMapWriter& writer,
                            const RunState& state) {
    const auto texels = cooked.read(0, cooked.height());
    if (!texels) return tl::make_unexpected(texels.error());
    const auto block = cooked.verifier().reconstruct(*texels, 0, cooked.height());
    for (int row = 0; row < size.y; row += kChunkRows) {
        if (state.interrupted) return failure(ErrorCode::Interrupted, "reconstruct", "interrupted");
        formats::Image<lighting::ShRgb> rows(size.x, std::min(kChunkRows, size.y - row));
        for (int y = 0; y < rows.height(); ++y)
            for (int x = 0; x < size.x; ++x) rows.at(x, y) = block.at(x % block.width(), (row + y) % block.height());
        if (auto appended = writer.append(rows.view()); !appended) return appended;
    }
    return {};
}

/// Returns where the charts of a light map were packed to, from the mesh of the cook.
/// sceneFolder  that sources are relative to
Result<ChartPlaces> chartPlacesOf(const CookedAsset& asset, const UnpackedBake& bake, const std::filesystem::path& sceneFolder) {
    CookedAsset needed = asset;  // the bake is not read
    if (needed.source.files) std::erase_if(*needed.source.files, [](const auto& file) { return !file.first.starts_with(kMeshRole); });
    const auto sources = unchangedSources(needed, sceneFolder);
    if (!sources) return tl::make_unexpected(sources.error());
    const auto mesh = sources->find(kMeshRole);
    if (mesh == sources->end())
        return failure(ErrorCode::Verification, asset.name, "found packed charts without a mesh, expected the folder as cooked");
    const auto scene = formats::GltfScene::load(mesh->second);
    if (!scene) return tl::make_unexpected(scene.error());
    return ChartPlaces::create(*scene, mesh->second.string(), bake);
}

/// A cooked map whose charts were packed.
struct PackedMap {
    ChartPlaces charts;
    CookedLightMapReader cooked;
    std::optional<lighting::ShRgb> constant;  ///< of every texel
};

/// Opens a light map of the manifest.
Result<PackedMap> openPacked(const Manifest& manifest, const std::filesystem::path& folder, const CookedAsset& asset,
                             const UnpackedBake& unpacked) {
    const auto description = descriptionOf(asset);
    if (!description) return tl::make_unexpected(description.error());
    auto charts = chartPlacesOf(asset, unpacked, folder / manifest.sceneDirectory);
    if (!charts) return tl::make_unexpected(charts.error());
    auto cooked = CookedLightMapReader::open(folder, asset, {});
    if (!cooked) return tl::make_unexpected(cooked.error());
    PackedMap map{std::move(*charts), std::move(*cooked), {}};
    if (description->constantOf) {
        const auto texels = map.cooked.read(0, map.cooked.height());
        if (!texels) return tl::make_unexpected(texels.error());
        map.constant = map.cooked.verifier().reconstruct(*texels, 0, map.cooked.height()).at(0, 0);
    }
    return map;
}

/// Returns the maps that hold the charts of a packed light map: itself and, where its charts were split, the other.
Result<std::vector<PackedMap>> openPackedMaps(const Manifest& manifest, const std::filesystem::path& folder, const CookedAsset& lightMap) {
    std::vector<PackedMap> maps;
    for (const CookedAsset& asset : manifest.assets) {
        if (asset.kind != AssetKind::LightMap) continue;
        const auto unpacked = unpackedBakeOf(asset);
        if (!unpacked) return tl::make_unexpected(unpacked.error());
        if (!*unpacked) continue;
        const bool isPart = (*unpacked)->part && (*unpacked)->part->of == lightMap.name;
        if (asset.name != lightMap.name && !isPart) continue;
        auto map = openPacked(manifest, folder, asset, **unpacked);
        if (!map) return tl::make_unexpected(map.error());
        maps.push_back(std::move(*map));
    }
    return maps;
}

/// Writes maps whose charts were packed at the texels of their bake.
/// size  [texels of the output]
Result<void> writeUnpacked(const std::vector<PackedMap>& maps, const glm::ivec2& size, const std::filesystem::path& output,
                           int placesPerTexel, const RunState& state) {
    auto writer = formats::LightMapWriter::create(output, size.x, size.y);
    if (!writer) return tl::make_unexpected(writer.error());
    SharedObjects shared;
    const Action action{"", "", output.filename().string(), {}, {}, {}};
    const ActionContext context{action, {}, {}, {}, shared, state};
    const int rowsAtOnce = std::max(1, kPlacesAtOnce / size.x);
    for (int row = 0; row < size.y; row += rowsAtOnce) {
        formats::Image<lighting::ShRgb> rows(size.x, std::min(rowsAtOnce, size.y - row));
        std::vector<glm::dvec2> places;
        places.reserve(rows.texels().size());
        for (int y = row; y < row + rows.height(); ++y)
            for (int x = 0; x < size.x; ++x) places.push_back((glm::dvec2(x, y) + 0.5) / static_cast<double>(placesPerTexel) - 0.5);
        for (const PackedMap& map : maps) {
            const auto decoded =
                map.constant ? Result<std::vector<lighting::ShRgb>>() : decodedAt(places, {map.charts, map.cooked}, context);
            if (!decoded) return tl::make_unexpected(decoded.error());
            for (std::size_t i = 0; i < places.size(); ++i)
                if (map.charts.packed(places[i])) rows.texels()[i] = map.constant ? *map.constant : (*decoded)[i];
        }
        if (auto appended = writer->append(rows.view()); !appended) return appended;
    }
    return writer->commit();
}

}  // namespace

Result<void> reconstructLightMap(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& output,
                                 int placesPerTexel, const RunState& state) {
    const auto manifest = loadManifest(folder);
    if (!manifest) return tl::make_unexpected(manifest.error());
    const auto asset = findLightMap(*manifest, folder, name);
    if (!asset) return tl::make_unexpected(asset.error());
    const auto unpacked = unpackedBakeOf(**asset);
    if (!unpacked) return tl::make_unexpected(unpacked.error());
    const auto description = descriptionOf(**asset);
    if (!description) return tl::make_unexpected(description.error());
    if (*unpacked && (!description->constantOf || (*unpacked)->part)) {
        const auto maps = openPackedMaps(*manifest, folder, **asset);
        if (!maps) return tl::make_unexpected(maps.error());
        const ChartPacking& packing = (*unpacked)->packing;
        return writeUnpacked(*maps, placesPerTexel * glm::ivec2(packing.widthBefore, packing.heightBefore), output, placesPerTexel, state);
    }
    const auto cooked = CookedLightMapReader::open(folder, **asset, {});
    if (!cooked) return tl::make_unexpected(cooked.error());
    const glm::ivec2 size = placesPerTexel * description->constantOf.value_or(glm::ivec2(cooked->width(), cooked->height()));
    auto writer = formats::LightMapWriter::create(output, size.x, size.y);
    if (!writer) return tl::make_unexpected(writer.error());
    if (description->constantOf) {
        if (auto appended = appendConstant(*cooked, size, *writer, state); !appended) return appended;
        return writer->commit();
    }
    for (int row = 0; row < cooked->height(); row += kChunkRows) {
        if (state.interrupted) return failure(ErrorCode::Interrupted, "reconstruct", "interrupted");
        const int rowCount = std::min(kChunkRows, cooked->height() - row);
        // Places between texels need the row above, too; blocks are read in whole rows.
        const int firstRow = placesPerTexel > 1 ? std::max(0, row - kReadRows) : row;
        const auto texels = cooked->read(firstRow, row + rowCount + 1 - firstRow);
        if (!texels) return tl::make_unexpected(texels.error());
        const auto rows = cooked->verifier().reconstruct(*texels, row, rowCount, placesPerTexel);
        if (auto appended = writer->append(rows.view()); !appended) return appended;
    }
    return writer->commit();
}

}  // namespace lightcook::pipeline
