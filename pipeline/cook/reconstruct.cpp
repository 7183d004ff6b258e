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

}  // namespace

Result<void> reconstructLightMap(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& output,
                                 int placesPerTexel, const RunState& state) {
    const auto manifest = loadManifest(folder);
    if (!manifest) return tl::make_unexpected(manifest.error());
    const auto asset = findLightMap(*manifest, folder, name);
    if (!asset) return tl::make_unexpected(asset.error());
    const auto cooked = CookedLightMapReader::open(folder, **asset, {}, {}, 0);
    if (!cooked) return tl::make_unexpected(cooked.error());
    const auto description = descriptionOf(**asset);
    if (!description) return tl::make_unexpected(description.error());
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
