#include "pipeline/manifest/contract.h"

#include <fmt/format.h>

#include <algorithm>

#include "formats/gltf_light_map.h"
#include "formats/gpu_texture.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/gltf/gltf.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/textures.h"
#include "pipeline/document/json_difference.h"
#include "pipeline/graph/files.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;

/// Compares a manifest with the bytes of its files.
class Contract {
public:
    Contract(const std::filesystem::path& folder, const Manifest& manifest) : folder_(folder), manifest_(manifest) {}

    std::vector<Error> check() && {
        checkShader();
        for (const CookedAsset& asset : manifest_.assets) {
            const std::size_t first = errors_.size();
            if (asset.file) checkFileSize(*asset.file, asset.bytesDisk.value_or(0), asset.name);
            for (const CookedTexture& texture : asset.textures) checkTexture(asset, texture);
            if (asset.kind == AssetKind::LightMap) checkFilter(asset);
            for (std::size_t i = first; i < errors_.size(); ++i) errors_[i].asset = asset.name;
        }
        for (const GltfFile& gltf : manifest_.gltf) checkGltf(gltf);
        return std::move(errors_);
    }

private:
    void complain(formats::Subject place, const std::string& found, const std::string& expected) {
        errors_.push_back({ErrorCode::Verification, std::move(place), fmt::format("found {}, expected {}", found, expected)});
    }
    void expectEqual(const formats::Subject& place, const Json& found, const Json& expected) {
        if (found != expected) complain(place, found.dump(), expected.is_null() ? "no such member" : expected.dump());
    }
    /// what  goes before the path of a member
    void expectSame(const formats::Subject& place, const std::string& what, const Json& found, const Json& expected) {
        eachDifference(found, expected,
                       [&](const std::string& path, const Json& is, const Json& was) { expectEqual(place.at(what + path), is, was); });
    }

    void checkShader() {
        for (const CookedAsset& asset : manifest_.assets)
            if (asset.kind == AssetKind::LightMap && !formats::lightMapLayoutFromName(asset.layout))
                return;  // the verification of that asset reports it
        const std::filesystem::path file = folder_ / manifest_.shader.file;
        if (const auto text = readFile(file); !text || *text != shaderTextOf(manifest_.assets, manifest_.lobe))
            complain(file, "another shader", "the one that this version verifies with");
    }

    void checkFileSize(const std::string& file, std::uint64_t expected, const std::string& place) {
        std::error_code code;
        const auto bytes = std::filesystem::file_size(folder_ / file, code);
        if (!code) expectEqual(place + ", bytes_disk", expected, std::uint64_t{bytes});
    }

    /// Returns the size that a texture beside those of the layout must have.
    glm::ivec2 lookupSize(const CookedAsset& asset, const CookedTexture& texture) {
        if (texture.role == kIndexRole) return {indexWidth(asset.width), indexHeight(asset.height)};
        if (texture.role == formats::kCoverageRole) return formats::coverageSize(asset.width, asset.height);
        if (formats::isOfDetail(texture.role)) {
            const formats::DetailAtlas atlas{asset.detail ? static_cast<int>(asset.detail->tiles) : 0};
            return {atlas.width(), atlas.height()};
        }
        const auto layout = formats::lightMapLayoutFromName(asset.layout);
        const Json constants = asset.constants.value_or(Json());
        expectEqual(asset.name + ", constants/tables", constants.is_object() ? constants.value(kTablesRole, Json()) : Json(),
                    {{"file", texture.file}});
        const Json clusters = constants.is_object() ? constants.value("clusters", Json()) : Json();
        const bool isCount =
            clusters.is_array() && clusters.size() == 1 && clusters[0].is_number() && clusters[0] >= 0 && clusters[0] <= 256;
        return {layout ? formats::info(*layout).tableFactors() : 0, isCount ? clusters[0].get<int>() : 0};
    }

    /// A light map has texture "coverage" where its texels are decoded before they are filtered, and only there.
    void checkFilter(const CookedAsset& asset) {
        const bool hasCoverage =
            std::ranges::any_of(asset.textures, [](const CookedTexture& texture) { return texture.role == formats::kCoverageRole; });
        expectEqual(asset.name + ", filter", asset.filter ? jsonOf(*asset.filter) : Json(),
                    jsonOf(hasCoverage ? formats::LightMapFilter::Decoded : formats::LightMapFilter::Hardware));
    }

    void checkTexture(const CookedAsset& asset, const CookedTexture& texture) {
        const std::string place = fmt::format("{}, texture {}", asset.name, texture.role);
        const bool isLookup = asset.kind == AssetKind::LightMap && isLookupRole(texture.role);
        const bool hasMips = asset.kind == AssetKind::LightMap && texture.mips > 1;
        const Sampler sampler{isLookup || asset.filter == formats::LightMapFilter::Decoded ? "nearest"
                              : hasMips                                                    ? "trilinear"
                                                                                           : std::string(info(asset.kind).filter),
                              "clamp"};
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
        const glm::ivec2 size =
            isLookup ? lookupSize(asset, texture) : formats::textureSize(asset.width, asset.height, texture.side.value_or(1));
        expectEqual(place + ", width of its asset", size.x, texture.width);
        expectEqual(place + ", height of its asset", size.y, texture.height);
        if (reader->container() != formats::Container::Ktx2) return;  // DDS has no metadata
        if (!reader->hasOwnTransfer())
            complain(place, "another transfer function in its data format descriptor",
                     fmt::format("that of {}, as cooked", formats::info(reader->shape().format).name));
        const auto metadata = reader->metadata().find(kMetadataKey);
        if (metadata == reader->metadata().end()) return complain(place, "no metadata", fmt::format("the key \"{}\"", kMetadataKey));
        expectSame(place, "metadata ", parseJson(metadata->second), metadataOf(asset, texture));
    }

    /// Returns the copy of the manifest's members inside a texture, which serves a loader without the manifest. Its constants are without
    /// learned tables and long lists.
    static Json metadataOf(const CookedAsset& asset, const CookedTexture& texture) {
        const bool isOfDetail = asset.detail && formats::isOfDetail(texture.role);
        const Json constants = isOfDetail ? asset.detail->constants : asset.constants.value_or(Json::object());
        Json kept = Json::object();
        for (const auto& [name, value] : constants.items())
            if (asset.kind != AssetKind::LightMap || (name != kTablesRole && value.size() <= kLargestMetadataConstant)) kept[name] = value;
        Json metadata = {{"kind", info(asset.kind).name}, {"layout", asset.layout}, {"role", texture.role}, {"constants", kept}};
        if (asset.distribution) metadata["distribution"] = *asset.distribution;
        if (asset.normalization) metadata["normalization"] = *asset.normalization;
        return metadata;
    }

    /// Checks the copy of the manifest's members inside a glTF with the light map bound, and the binding of its nodes.
    void checkGltf(const GltfFile& gltf) {
        const std::filesystem::path file = folder_ / gltf.file;
        const auto asset = std::ranges::find_if(
            manifest_.assets, [&](const CookedAsset& each) { return each.name == gltf.lightMap && each.kind == AssetKind::LightMap; });
        if (asset == manifest_.assets.end())
            return complain(file, fmt::format("the light map \"{}\"", gltf.lightMap), "one of the manifest");
        const auto expected = boundMapOf(*asset, manifest_.workingColor, manifest_.shader.file);
        if (!expected) return;  // the verification of that asset reports it
        const auto text = formats::boundLightMaps(file);
        if (!text) return errors_.push_back(text.error());
        Json maps = parseJson(*text);
        if (!maps.is_array() || maps.size() != 1 || !maps[0].is_object())
            return complain(file, fmt::format("{} light maps", maps.is_array() ? maps.size() : 0), "one");
        maps[0].erase("bound");  // the verification of the light map has it
        expectSame(file, "", maps[0], *expected);
        const auto wrong = formats::wrongBinding(file);
        if (!wrong) return errors_.push_back(wrong.error());
        if (*wrong) errors_.push_back({ErrorCode::Verification, file, **wrong});
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
