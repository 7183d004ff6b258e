// Writing and reading the textures of an asset: images to encoded files, with the manifest entry of each.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "compress/encode.h"
#include "formats/gpu_texture.h"
#include "formats/image.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// How the textures of an asset are written: part of the parameters of every action that writes some.
struct TextureSettings {
    formats::Container container = formats::Container::Ktx2;
    bool zstd = false;
    int effort = 5;
    double rdo = 0;  ///< see compress::EncodeOptions

    compress::EncodeOptions encodeOptions() const;

    Json toJson() const;
    static TextureSettings fromJson(const Json& json);
    std::string_view extension() const { return container == formats::Container::Dds ? ".dds" : ".ktx2"; }
};

/// The format of HDR colours for a target: 16-bit floats for "float", ASTC for "astc", BC6H for "bc".
formats::PixelFormat hdrFormat(const std::string& target);

/// What a sampler has to do, for the manifest.
struct Sampler {
    std::string filter = "linear";  ///< linear or trilinear
    std::string wrap = "clamp";
};

/// The manifest's entry of one texture file. Its digest joins it when the manifest is put together.
Json textureEntry(const std::string& role, const std::string& file, const formats::TextureShape& shape, std::size_t fileBytes,
                  const Sampler& sampler);

/// Encodes one image over the threads of the arena, by groups of block rows. Reports what had to be clamped.
std::vector<std::byte> encodeImage(formats::PixelFormat format, formats::ImageView<const glm::vec4> texels,
                                   formats::ImageView<const float> significance, const compress::EncodeOptions& options,
                                   compress::EncodeReport& report);

/// The six faces of a level that lie under each other, size x 6 size, divided by range: each encoded as encodeImage does.
std::vector<std::vector<std::byte>> encodeFaces(formats::PixelFormat format, formats::ImageView<const glm::vec3> strip, float range,
                                                const compress::EncodeOptions& options, compress::EncodeReport& report);

/// What a loader needs to decode a texture, for inside its file, in case the manifest gets lost.
std::map<std::string, std::string> textureMetadata(const Json& facts);

formats::Result<formats::TextureWriter> createTexture(const std::filesystem::path& file, const formats::TextureShape& shape,
                                                      const TextureSettings& settings, const std::map<std::string, std::string>& metadata);
/// Writes a texture whose images are all in memory, mip by mip (outer) and layer or face by layer or face (inner).
formats::Result<void> writeTexture(const std::filesystem::path& file, const formats::TextureShape& shape, const TextureSettings& settings,
                                   const std::map<std::string, std::string>& metadata, const std::vector<std::vector<std::byte>>& images);

/// A texture of an asset whose images are all in memory, in the order of writeTexture.
struct WholeTexture {
    std::string role;
    std::string name;  ///< of its file, without the extension
    formats::TextureShape shape;
    std::vector<std::vector<std::byte>> images;
    Sampler sampler;
};
/// Writes it into the action's folder, with facts as its metadata, and names it in `outcome`. Returns its manifest entry.
formats::Result<Json> packTexture(const ActionContext& context, const WholeTexture& texture, const TextureSettings& settings,
                                  const Json& facts, ActionOutcome& outcome);

/// The texture of a role in an asset's manifest entry, opened and held against what the entry says of it.
formats::Result<formats::TextureReader> openTexture(const std::filesystem::path& folder, const Json& asset, const std::string& role);

/// What HDR values are divided by before they are stored: a power of two that brings the largest to 512 .. 1024, so that neither the top of
/// a half nor its subnormals cost precision. 1 for black.
float hdrRange(float largest);

/// The texels of an image as they lie in memory, row by row.
template <class Texel>
std::vector<std::byte> bytesOf(const formats::Image<Texel>& image) {
    const auto bytes = std::as_bytes(std::span(image.texels()));
    return {bytes.begin(), bytes.end()};
}

/// Channels of an image as RGBA, missing ones 0, alpha 1.
formats::Image<glm::vec4> toRgba(formats::ImageView<const glm::vec3> image);

}  // namespace lightcook::pipeline
