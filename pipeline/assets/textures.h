// Textures of an asset: encodes images, writes them as files with their manifest entries, and opens these files again.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "compress/encode.h"
#include "formats/gpu_texture.h"
#include "formats/image.h"
#include "pipeline/assets/cooked_asset.h"
#include "pipeline/assets/results.h"
#include "pipeline/document/enum_names.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Settings of an asset's texture files: a parameter of every action that writes some.
struct TextureSettings {
    formats::Container container = formats::Container::Ktx2;
    bool zstd = false;
    int effort = 5;
    double rdo = 0;  ///< see compress::EncodeOptions

    compress::EncodeOptions encodeOptions() const;
    std::string_view extension() const { return container == formats::Container::Dds ? ".dds" : ".ktx2"; }
};
template <class Fields, Is<TextureSettings> Self>
void describe(Fields& fields, Self& settings) {
    fields.required("container", settings.container, "container of the files");
    fields.required("zstd", settings.zstd, "true for Zstandard supercompression");
    fields.required("effort", settings.effort, "effort of the encoders, 0 to 9");
    fields.required("rdo", settings.rdo, "largest growth of the error for blocks that repeat");
}

/// Encodes one image on the threads of the arena, in groups of block rows. Adds the clamped values to the report.
std::vector<std::byte> encodeImage(formats::PixelFormat format, formats::ImageView<const glm::vec4> texels,
                                   formats::ImageView<const float> significance, const compress::EncodeOptions& options,
                                   compress::EncodeReport& report);

/// Divides six faces that lie under each other (size x 6 size) by `range`, and encodes each of them as encodeImage does.
std::vector<std::vector<std::byte>> encodeFaces(formats::PixelFormat format, formats::ImageView<const glm::vec3> strip, float range,
                                                const compress::EncodeOptions& options, compress::EncodeReport& report);

/// Returns the metadata of a texture file, which serves a loader without the manifest: under one key, an object with the manifest's
/// members `kind`, `layout`, `role` and `constants`.
std::map<std::string, std::string> textureMetadata(const Json& members);
inline constexpr const char* kMetadataKey = "io.lightcook";

/// Writes a texture whose images are all in memory, mip by mip (outer) and layer or face by layer or face (inner).
formats::Result<void> writeTexture(const std::filesystem::path& file, const formats::TextureShape& shape, const TextureSettings& settings,
                                   const std::map<std::string, std::string>& metadata, const std::vector<std::vector<std::byte>>& images);

/// A texture of an asset, before it has texels.
struct TexturePlan {
    std::string role;
    std::string fileName;  ///< without the extension
    formats::TextureShape shape;
    Json constants;                ///< of the decode, as the metadata of the file holds them
    std::string_view filter = {};  ///< of its sampler; empty: that of the asset's kind
    int side = 1;                  ///< CookedTexture::side
};

/// Asset of a texture as the metadata of the file names it: with the words of the manifest.
struct TextureOwner {
    AssetKind kind;
    std::string layout;
    std::optional<std::string> distribution = {}, normalization = {};  ///< of tables
};

/// The texture files of one cook action: writes them into the action's folder and returns their manifest entries.
class AssetTextures {
public:
    AssetTextures(const ActionContext& context, const TextureSettings& settings, TextureOwner owner)
        : context_(context), settings_(settings), owner_(std::move(owner)) {}

    /// Creates a texture that the caller writes piece by piece. Returns its index.
    formats::Result<std::size_t> create(TexturePlan plan);
    formats::TextureWriter& writer(std::size_t index) { return outputs_.at(index).writer; }
    /// Writes a texture whose images are all in memory, in the order of writeTexture.
    formats::Result<void> write(TexturePlan plan, const std::vector<std::vector<std::byte>>& images);

    /// Commits every texture. `result` gets their manifest entries, sampled as the table of kinds says; the outcome gets their files.
    formats::Result<ActionOutcome> finish(CookResult result);

private:
    struct Output {
        TexturePlan plan;
        std::string file;
        formats::TextureWriter writer;
    };
    const ActionContext& context_;
    TextureSettings settings_;
    TextureOwner owner_;
    std::vector<Output> outputs_;
};

/// Opens the texture of a role of a cooked asset, and refuses a file that differs from its manifest entry.
formats::Result<formats::TextureReader> openTexture(const std::filesystem::path& folder, const CookedAsset& asset, const std::string& role);

/// Returns the power of two that HDR values are divided by before they are stored; 1 for black. It brings the largest value to 512 .. 1024,
/// so that neither the top of the half range nor its subnormals cost precision.
float hdrRange(float largest);

/// Returns the texels of an image as they lie in memory, row by row.
template <class Texel>
std::vector<std::byte> bytesOf(const formats::Image<Texel>& image) {
    const auto bytes = std::as_bytes(std::span(image.texels()));
    return {bytes.begin(), bytes.end()};
}

/// Returns RGB as RGBA with alpha 1.
formats::Image<glm::vec4> toRgba(formats::ImageView<const glm::vec3> image);

}  // namespace lightcook::pipeline
