// A copy of one asset of a cooked scene, to be damaged: bytes as a bad disk would, or texels and manifest together as a cook with a fault
// in it would have written them.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <stdexcept>

#include "compress/encode.h"
#include "formats/gpu_texture.h"
#include "formats/light_map_detail.h"
#include "pipeline/assets/textures.h"
#include "pipeline/cook/cook.h"
#include "pipeline/document/json.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/rewritten_manifest.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {

using TexelImage = formats::Image<glm::vec4>;

template <class T>
T valueOf(formats::Result<T> result) {
    if (!result) throw std::runtime_error(result.error().line());
    return std::move(*result);
}

class CookedCopy {
public:
    /// cooked  the folder of a cook; sources: the scene's folder; asset: by name, the only one that the copy's manifest keeps
    CookedCopy(const std::filesystem::path& cooked, std::filesystem::path sources, const std::string& asset)
        : original_(cooked), sources_(std::move(sources)), manifest_(valueOf(readManifest(cooked))) {
        Json kept = Json::array();
        for (const Json& each : manifest_.at("assets"))
            if (each.at("name") == asset) kept.push_back(each);
        if (kept.size() != 1) throw std::runtime_error("no asset " + asset);
        manifest_["assets"] = std::move(kept);
        manifest_["cooks"][0]["assets"] = {asset};
        const Manifest whole = valueOf(loadManifest(cooked));
        std::vector<CookedAsset> left;
        for (const CookedAsset& each : whole.assets)
            if (each.name == asset) left.push_back(each);
        formats::writeContent(folder_ / kShaderName, shaderTextOf(left, whole.lobe));
        for (const FileRecord& file : filesOf(valueOf(loadManifest(cooked))))
            if (file.name != kShaderName) std::filesystem::copy_file(cooked / file.name, folder_ / file.name);
        rewriteDigests();
    }

    std::filesystem::path folder() const { return folder_.path(); }
    std::filesystem::path sources() const { return sources_; }
    std::filesystem::path original() const { return original_; }
    Json& manifest() { return manifest_; }
    Json& asset() { return manifest_["assets"][0]; }
    Json& constants() { return asset()["constants"]; }
    Json& texture(const std::string& role) {
        for (Json& each : asset()["textures"])
            if (each.at("role") == role) return each;
        throw std::runtime_error("no texture " + role);
    }
    std::filesystem::path file(const std::string& role) { return folder_ / texture(role).at("file").get<std::string>(); }

    /// Every image of a texture, mip by mip, layer by layer, face by face.
    std::vector<TexelImage> texels(const std::string& role) { return texelsOf(file(role)); }
    static std::vector<TexelImage> texelsOf(const std::filesystem::path& file) {
        const auto reader = valueOf(formats::TextureReader::open(file));
        std::vector<TexelImage> images;
        for (const formats::SubImage& image : imagesOf(reader.shape())) images.push_back(valueOf(verify::decodeImage(reader, image)));
        return images;
    }
    /// Encodes them again in the texture's own format.
    void setTexels(const std::string& role, const std::vector<TexelImage>& images) {
        const auto format = valueOf(formats::TextureReader::open(file(role))).shape().format;
        compress::EncodeOptions options;
        options.effort = 3;
        std::vector<std::vector<std::byte>> blocks;
        for (const TexelImage& image : images) {
            blocks.emplace_back(formats::bytesPerImage(format, image.width(), image.height()));
            compress::encodeRows(format, image.view(), {}, options, blocks.back(), {});
        }
        rewrite(role, &blocks);
    }
    using Edit = std::function<void(std::vector<TexelImage>& images)>;
    void edit(const std::string& role, const Edit& change) {
        std::vector<TexelImage> images = texels(role);
        change(images);
        setTexels(role, images);
    }
    /// Changes the bytes of one block of the first image: 4 x 4 texels from (x, y) on.
    void setBlock(const std::string& role, int x, int y, std::byte value) {
        auto reader = valueOf(formats::TextureReader::open(file(role)));
        std::vector<std::vector<std::byte>> blocks;
        for (const formats::SubImage& image : imagesOf(reader.shape())) blocks.push_back(valueOf(reader.readImage(image)));
        const auto format = reader.shape().format;
        const std::size_t size = static_cast<std::size_t>(formats::info(format).bytesPerBlock);
        const std::size_t at = static_cast<std::size_t>(y / 4) * formats::bytesPerBlockRow(format, reader.shape().width) +
                               static_cast<std::size_t>(x / 4) * size;
        std::fill_n(blocks[0].begin() + static_cast<std::ptrdiff_t>(at), size, value);
        rewrite(role, &blocks);
    }

    /// Manifest, sizes, digests and the constants inside textures as a cook would have written them for these files.
    void rewriteDigests(bool withMetadata = true) {
        for (Json& each : asset()["textures"]) {
            if (withMetadata) rewrite(each.at("role"), nullptr);
            stamp(each);
            each["bytes_disk"] = std::filesystem::file_size(folder_ / each.at("file").get<std::string>());
        }
        if (asset().contains("file")) {
            stamp(asset());
            asset()["bytes_disk"] = std::filesystem::file_size(folder_ / asset().at("file").get<std::string>());
        }
        stamp(manifest_["shader"]);
        writeManifest();
    }
    void writeManifest() const { writeManifestAndDigests(folder_.path(), manifest_); }

    Outcome verify() const {
        const RunState state;
        return verifyCooked({folder_.path(), sources_, {}}, state);
    }

private:
    static std::vector<formats::SubImage> imagesOf(const formats::TextureShape& shape) {
        std::vector<formats::SubImage> images;
        for (int mip = 0; mip < shape.mipCount; ++mip)
            for (int layer = 0; layer < shape.layerCount; ++layer)
                for (int face = 0; face < shape.faceCount; ++face) images.push_back({mip, layer, face});
        return images;
    }
    void stamp(Json& entry) const {
        const auto digest = digestOfFile(folder_ / entry.at("file").get<std::string>());
        if (digest) entry["digest"] = *digest;
    }
    /// New blocks, if there are some, and the constants of the manifest as it is.
    void rewrite(const std::string& role, const std::vector<std::vector<std::byte>>* blocks) {
        auto reader = formats::TextureReader::open(file(role));
        if (!reader) return;  // damaged on purpose
        std::vector<std::vector<std::byte>> own;
        formats::TextureFileOptions options;
        options.container = reader->container();
        for (const auto& [key, value] : reader->metadata())
            if (!key.starts_with("KTX")) options.metadata[key] = value;
        const auto before = options.metadata;
        if (const auto entry = options.metadata.find(kMetadataKey); entry != options.metadata.end()) {
            Json facts = parseJson(entry->second);
            const Json decode = formats::isOfDetail(role) ? asset().value("detail", Json::object()) : asset();
            const Json known = decode.value("constants", Json::object());
            for (auto& [name, value] : facts["constants"].items())
                if (known.contains(name)) value = known.at(name);
            entry->second = facts.dump();
        }
        if (blocks == nullptr) {
            if (options.metadata == before) return;
            for (const formats::SubImage& image : imagesOf(reader->shape())) own.push_back(valueOf(reader->readImage(image)));
            blocks = &own;
        }
        auto writer = valueOf(formats::TextureWriter::create(file(role), reader->shape(), options));
        std::size_t index = 0;
        for (const formats::SubImage& image : imagesOf(reader->shape()))
            if (auto written = writer.writeBlockRows(image, 0, blocks->at(index++)); !written)
                throw std::runtime_error(written.error().line());
        if (auto written = writer.commit(); !written) throw std::runtime_error(written.error().line());
    }

    std::filesystem::path original_, sources_;
    Json manifest_;
    formats::TemporaryFolder folder_;
};

}  // namespace lightcook::pipeline
