#include "pipeline/manifest/contract.h"

#include <fmt/format.h>

#include "formats/gpu_texture.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/textures.h"
#include "pipeline/graph/files.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;

/// Holds a manifest against the table of asset kinds, the shader, the files and the sources.
class Contract {
public:
    Contract(const std::filesystem::path& folder, const Manifest& manifest) : folder_(folder), manifest_(manifest) {}

    std::vector<Error> check() && {
        checkShader();
        for (const CookedAsset& asset : manifest_.assets) {
            checkConventions(asset);
            checkColors(asset);
            checkLobe(asset);
            if (asset.kind == AssetKind::Cubemap)
                for (Error& error : checkCubemapConstants(asset)) errors_.push_back(std::move(error));
            if (asset.file) checkFileSize(*asset.file, asset.bytesDisk.value_or(0), asset.name);
            for (const CookedTexture& texture : asset.textures) checkTexture(asset, texture);
        }
        return std::move(errors_);
    }

private:
    void complain(std::string place, const std::string& found, const std::string& expected) {
        errors_.push_back({ErrorCode::Verification, std::move(place), fmt::format("found {}, expected {}", found, expected)});
    }
    void expectEqual(const std::string& place, const Json& found, const Json& expected) {
        if (found != expected) complain(place, found.dump(), expected.dump());
    }

    void checkShader() {
        for (const CookedAsset& asset : manifest_.assets)
            if (asset.kind == AssetKind::LightMap && !formats::lightMapLayoutFromName(asset.layout))
                return;  // the verification of that asset reports it
        const std::filesystem::path file = folder_ / manifest_.shader.file;
        if (const auto text = readFile(file); !text || *text != shaderTextOf(manifest_.assets, manifest_.lobe))
            complain(file.string(), "another shader", "the one that this version verifies with");
    }

    /// One scene, one lobe: of the tables, of the cubemap's prefilter, and of the surfaces that verification shades.
    void checkLobe(const CookedAsset& asset) {
        const std::string expected(formats::info(manifest_.lobe).name);
        if (asset.kind == AssetKind::Lut) expectEqual(asset.name + ", distribution", asset.distribution.value_or(""), expected);
        if (!formats::info(manifest_.lobe).distribution) return;  // tables alone have Phong lobes
        if (asset.kind == AssetKind::Cubemap && asset.constants)
            expectEqual(asset.name + ", constants/kernel", asset.constants->value("kernel", Json()), expected);
        const Json shading = asset.verify && asset.verify->is_object() ? asset.verify->value("shading", Json()) : Json();
        if (shading.is_object()) expectEqual(asset.name + ", verify/shading/lobe", shading.value("lobe", Json()), expected);
    }

    void checkConventions(const CookedAsset& asset) {
        const AssetConventions& expected = info(asset.kind).conventions;
        const auto check = [&](const char* key, const std::optional<std::string>& found, std::string_view value) {
            if (!value.empty())
                expectEqual(fmt::format("{}, {}", asset.name, key), found ? Json(*found) : Json(nullptr), std::string(value));
        };
        check("units", asset.units, expected.units);
        check("phase", asset.phase, expected.phase);
        check("frame", asset.frame, expected.frame);
    }

    /// Sources are converted to the working space that the manifest names.
    void checkColors(const CookedAsset& asset) {
        Json working;
        if (asset.source.description && asset.source.description->is_object())
            working = asset.source.description->value("color_working", Json());
        if (asset.source.colors) working = asset.source.colors->working;
        if (!working.is_null()) expectEqual(asset.name + ", color/working", manifest_.workingColor, working);
    }

    void checkFileSize(const std::string& file, std::uint64_t expected, const std::string& place) {
        std::error_code code;
        const auto bytes = std::filesystem::file_size(folder_ / file, code);
        if (!code) expectEqual(place + ", bytes_disk", expected, std::uint64_t{bytes});
    }

    /// Returns the size that a texture must have that is fetched texel by texel.
    glm::ivec2 lookupSize(const CookedAsset& asset, const CookedTexture& texture) {
        if (texture.role == kIndexRole) return {indexWidth(asset.width), indexHeight(asset.height)};
        const auto layout = formats::lightMapLayoutFromName(asset.layout);
        const Json constants = asset.constants.value_or(Json());
        expectEqual(asset.name + ", constants/tables", constants.is_object() ? constants.value(kTablesRole, Json()) : Json(),
                    {{"file", texture.file}});
        const Json clusters = constants.is_object() ? constants.value("clusters", Json()) : Json();
        const bool isCount =
            clusters.is_array() && clusters.size() == 1 && clusters[0].is_number() && clusters[0] >= 0 && clusters[0] <= 256;
        return {layout ? formats::info(*layout).tableFactors() : 0, isCount ? clusters[0].get<int>() : 0};
    }

    void checkTexture(const CookedAsset& asset, const CookedTexture& texture) {
        const std::string place = fmt::format("{}, texture {}", asset.name, texture.role);
        const bool isLookup = asset.kind == AssetKind::LightMap && isLookupRole(texture.role);
        const bool hasMips = asset.kind == AssetKind::LightMap && texture.mips > 1;
        const Sampler sampler{isLookup ? "nearest" : hasMips ? "trilinear" : std::string(info(asset.kind).filter), "clamp"};
        expectEqual(place + ", sampler", toJson(texture.sampler), toJson(sampler));
        checkFileSize(texture.file, texture.bytesDisk, place);
        const auto reader = formats::TextureReader::open(folder_ / texture.file);
        if (!reader) {
            errors_.push_back(reader.error());
            return;
        }
        if (texture.isArray) expectEqual(place + ", array", *texture.isArray, reader->shape().isArray);
        if (texture.apiFormats)
            expectEqual(place + ", api_formats", toJson(*texture.apiFormats), toJson(formats::apiFormats(reader->shape().format)));
        expectEqual(place + ", bytes_gpu", texture.bytesGpu, std::uint64_t{reader->shape().gpuBytes()});
        const glm::ivec2 size = isLookup ? lookupSize(asset, texture) : glm::ivec2(asset.width, asset.height);
        expectEqual(place + ", width of its asset", size.x, texture.width);
        expectEqual(place + ", height of its asset", size.y, texture.height);
        if (const auto metadata = reader->metadata().find(kMetadataKey); metadata != reader->metadata().end())
            checkMetadata(parseJson(metadata->second), asset, texture, place);
    }

    /// Checks the copy of the manifest's members inside a texture, which serves a loader without the manifest. It has no learned tables.
    void checkMetadata(const Json& metadata, const CookedAsset& asset, const CookedTexture& texture, const std::string& place) {
        const Json copies = metadata.is_object() ? metadata.value("constants", Json()) : Json();
        if (!copies.is_object()) return complain(place, "metadata of another shape", "its layout and constants");
        const Json constants = asset.constants.value_or(Json::object());
        for (const auto& [name, value] : copies.items())
            expectEqual(fmt::format("{}, metadata constants/{}", place, name), value,
                        constants.is_object() ? constants.value(name, Json()) : Json());
        const auto check = [&](const char* key, const Json& expected) {
            expectEqual(fmt::format("{}, metadata {}", place, key), metadata.value(key, Json()), expected);
        };
        const auto orNull = [](const std::optional<std::string>& word) { return word ? Json(*word) : Json(nullptr); };
        check("kind", info(asset.kind).name);
        check("layout", asset.layout);
        check("role", texture.role);
        check("distribution", orNull(asset.distribution));
        check("normalization", orNull(asset.normalization));
    }

    const std::filesystem::path& folder_;
    const Manifest& manifest_;
    std::vector<Error> errors_;
};

}  // namespace

std::vector<Error> checkContract(const std::filesystem::path& folder, const Manifest& manifest) {
    return Contract(folder, manifest).check();
}

}  // namespace lightcook::pipeline
