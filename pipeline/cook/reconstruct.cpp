#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "formats/light_map.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

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

}  // namespace

Result<void> reconstructLightMap(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& output,
                                 const RunState& state) {
    const auto manifest = loadManifest(folder);
    if (!manifest) return tl::make_unexpected(manifest.error());
    const auto asset = findLightMap(*manifest, folder, name);
    if (!asset) return tl::make_unexpected(asset.error());
    const auto cooked = CookedLightMapReader::open(folder, **asset, {}, {}, 0);
    if (!cooked) return tl::make_unexpected(cooked.error());
    auto writer = formats::LightMapWriter::create(output, cooked->width(), cooked->height());
    if (!writer) return tl::make_unexpected(writer.error());
    for (int row = 0; row < cooked->height(); row += kChunkRows) {
        if (state.interrupted) return failure(ErrorCode::Interrupted, "reconstruct", "interrupted");
        const int rowCount = std::min(kChunkRows, cooked->height() - row);
        const auto texels = cooked->read(row, rowCount);
        if (!texels) return tl::make_unexpected(texels.error());
        if (auto appended = writer->append(cooked->verifier().reconstruct(*texels, row, rowCount).view()); !appended) return appended;
    }
    return writer->commit();
}

}  // namespace lightcook::pipeline
