// A cooked light map, opened again.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/gpu_texture.h"
#include "formats/light_map.h"
#include "pipeline/assets/cooked_asset.h"
#include "pipeline/assets/light_map/detail_reader.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

class LightMapSource;

/// Settings of the verifier that a cooked light map is read with: see verify::LightMapVerifier::create.
struct VerifierSettings {
    verify::LightMapShading shading = {};
    verify::LightMapSampling sampling = {};
    double key = 0;
    std::optional<verify::Viewing> viewing = {};

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.shading, self.sampling, self.key, self.viewing);
    }
};

/// Reads and decodes a cooked light map from its manifest entry and the files beside it.
class CookedLightMapReader {
public:
    static formats::Result<CookedLightMapReader> open(const std::filesystem::path& folder, const CookedAsset& asset,
                                                      const VerifierSettings& settings);
    /// Opens a mip level, 1 or more, as a light map of its own.
    /// clusterOfTexel  of a learned layout: the cluster of each texel of the level (mips.h)
    static formats::Result<CookedLightMapReader> openMip(const std::filesystem::path& folder, const CookedAsset& asset, int mip,
                                                         std::vector<std::uint8_t> clusterOfTexel, const VerifierSettings& settings);
    const verify::LightMapVerifier& verifier() const { return verifier_; }
    /// Returns a digest of all that the verifier was created with.
    const std::string& verifierDigest() const { return verifierDigest_; }
    /// The map has a texture "coverage": its filter is LightMapFilter::Decoded.
    bool hasCoverage() const { return coverage_.has_value(); }
    int width() const { return width_; }
    int height() const { return height_; }
    /// Decodes texels from firstRow (a multiple of kRowAlignment) on: at least rowCount rows, as far as the map has them.
    formats::Result<verify::DecodedLightMapRows> read(int firstRow, int rowCount) const;
    /// Returns a digest of all that read() decodes.
    formats::Result<std::string> digestOfRows(int firstRow, int rowCount) const;

private:
    CookedLightMapReader(verify::LightMapVerifier verifier, std::string verifierDigest, std::vector<formats::TextureReader> textures,
                         std::optional<formats::TextureReader> coverage, std::optional<DetailReader> detail, int width, int height, int mip)
        : verifier_(std::move(verifier)),
          verifierDigest_(std::move(verifierDigest)),
          textures_(std::move(textures)),
          coverage_(std::move(coverage)),
          detail_(std::move(detail)),
          width_(width),
          height_(height),
          mip_(mip) {}
    /// The blocks of some rows of a texture.
    struct BlockRows {
        glm::ivec2 size{0};                          ///< of their texels
        std::vector<std::vector<std::byte>> layers;  ///< whole rows of blocks
    };
    formats::Result<BlockRows> readBlocks(std::size_t texture, int firstRow, int rowCount) const;
    formats::Result<BlockRows> readCoverageBlocks(int firstRow, int rowCount) const;
    formats::Result<formats::Image<std::uint8_t>> readCoverage(int firstRow, int rowCount) const;
    /// map  without formats
    static formats::Result<CookedLightMapReader> openMap(const std::filesystem::path& folder, const CookedAsset& asset, int mip,
                                                         verify::CookedLightMap map, const VerifierSettings& settings);
    verify::LightMapVerifier verifier_;
    std::string verifierDigest_;
    std::vector<formats::TextureReader> textures_;
    std::optional<formats::TextureReader> coverage_;  ///< of a map whose filter is LightMapFilter::Decoded
    std::optional<DetailReader> detail_;              ///< of a map that has detail: of level 0
    int width_, height_, mip_;
};

/// A strip of a bake beside what was cooked of it.
struct CookedStrip {
    int firstRow = 0, rowCount = 0;
    formats::LightMapStrip reference;      ///< with the row below
    verify::DecodedLightMapRows texels;    ///< with the row below
    formats::Image<lighting::ShRgb> seen;  ///< light of the texel centres
};
/// Reads strip `index` of the bake, and the texels that were cooked of it.
formats::Result<CookedStrip> readStrip(LightMapSource& bake, const CookedLightMapReader& cooked, int index);

/// Returns the clusters of the blocks of a learned layout, row by row, from its texture "index", as the shader decodes it. Empty for other
/// layouts, and where a mesh names the clusters.
formats::Result<std::vector<std::uint8_t>> clustersOfBlocks(const std::filesystem::path& folder, const CookedAsset& asset);

/// Returns those of the manifest, and the factors "code" and "residual" of a learned layout from its texture "tables".
formats::Result<LightMapConstants> constantsOf(const std::filesystem::path& folder, const CookedAsset& asset);

}  // namespace lightcook::pipeline
