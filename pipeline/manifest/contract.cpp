#include "pipeline/manifest/contract.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "formats/gltf_light_map.h"
#include "formats/gpu_texture.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/gltf/gltf.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/textures.h"
#include "pipeline/graph/files.h"
#include "pipeline/scene/cubemap_layout.h"
#include "pipeline/scene/up_axis.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;

/// Compares a manifest with the table of asset kinds, the shader, the files and the sources.
class Contract {
public:
    Contract(const std::filesystem::path& folder, const Manifest& manifest) : folder_(folder), manifest_(manifest) {}

    std::vector<Error> check() && {
        checkShader();
        for (const CookedAsset& asset : manifest_.assets) {
            const std::size_t first = errors_.size();
            checkConventions(asset);
            checkColors(asset);
            checkLobe(asset);
            checkKind(asset);
            if (asset.kind == AssetKind::Cubemap)
                for (Error& error : checkCubemapConstants(asset)) errors_.push_back(std::move(error));
            if (asset.file) checkFileSize(*asset.file, asset.bytesDisk.value_or(0), asset.name);
            for (const CookedTexture& texture : asset.textures) checkTexture(asset, texture);
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
        if (found != expected) complain(place, found.dump(), expected.dump());
    }

    void checkShader() {
        for (const CookedAsset& asset : manifest_.assets)
            if (asset.kind == AssetKind::LightMap && !formats::lightMapLayoutFromName(asset.layout))
                return;  // the verification of that asset reports it
        const std::filesystem::path file = folder_ / manifest_.shader.file;
        if (const auto text = readFile(file); !text || *text != shaderTextOf(manifest_.assets, manifest_.lobe))
            complain(file, "another shader", "the one that this version verifies with");
    }

    /// Checks that tables, cubemap prefilters and shaded surfaces have the one lobe of the scene.
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

    /// Checks the members that follow from the kind and the layout alone, and the memory of a texel, by which layouts are compared.
    void checkKind(const CookedAsset& asset) {
        const auto stated = [](const auto& member) { return member ? Json(*member) : Json(nullptr); };
        std::string_view quantity = info(asset.kind).quantity;
        if (asset.kind == AssetKind::Cubemap) {
            const CubemapLayoutInfo* const layout = cubemapLayoutFromName(asset.layout);
            quantity = layout != nullptr ? layout->quantity : std::string_view();
        }
        if (!quantity.empty()) expectEqual(asset.name + ", quantity", stated(asset.quantity), std::string(quantity));
        if (asset.kind == AssetKind::Rsrm && asset.axis) checkAxis(asset);
        const auto layout = formats::lightMapLayoutFromName(asset.layout);
        if (asset.kind != AssetKind::LightMap || !layout) return;  // the verification of the asset reports an unknown layout
        expectEqual(asset.name + ", decode_degree", stated(asset.decodeDegree), formats::info(*layout).decodeDegree);
        const double expected = bitsPerTexel(asset), found = asset.bitsPerTexel.value_or(0);
        constexpr double kRounding = 1e-9;
        if (!(std::abs(found - expected) <= kRounding * expected))
            complain(asset.name + ", bits_per_texel", fmt::format("{}", found), fmt::format("{} of its textures", expected));
    }

    /// Checks that the first column of a reflection map looks along the axis of its source, that of a painted gradient upwards.
    void checkAxis(const CookedAsset& asset) {
        const glm::dvec3 expected = glm::normalize(asset.source.axis.value_or(info(manifest_.up).direction)), found = *asset.axis;
        constexpr double kRounding = 1e-6;
        if (!(glm::distance(found, expected) <= kRounding))
            complain(asset.name + ", axis", fmt::format("{}, {}, {}", found.x, found.y, found.z),
                     fmt::format("{}, {}, {} of its source", expected.x, expected.y, expected.z));
    }

    /// Returns the GPU memory of a texel of a light map [bits]: bits of the pixel formats, times the share that mip levels add. The sizes
    /// are those of the manifest, which checkTexture() and the verification hold against the files.
    static double bitsPerTexel(const CookedAsset& asset) {
        const double texels = static_cast<double>(asset.width) * asset.height;
        double bits = 8.0 * static_cast<double>(asset.vertexBytes.value_or(0)) / texels;
        for (const CookedTexture& texture : asset.textures) {
            const auto bytes = 8.0 * static_cast<double>(texture.bytesGpu);
            const auto known = formats::pixelFormatFromName(texture.format);
            if (isLookupRole(texture.role) || !known) {
                bits += bytes / texels;
                continue;
            }
            const formats::PixelFormatInfo& format = formats::info(*known);
            const auto first = static_cast<double>(formats::bytesPerImage(*known, asset.width, asset.height));
            bits += bytes / first * format.bytesPerBlock / (format.blockWidth * format.blockHeight);
        }
        return bits;
    }

    /// Checks that blocks are those of the target, which says what a device must support.
    void checkTarget(const formats::PixelFormatInfo& format, const std::string& place) {
        if (format.blockWidth == 1) return;  // every device samples these
        const bool isAstc = format.name.starts_with("astc");
        const formats::Target expected = isAstc ? formats::Target::Astc : formats::Target::Bc;
        if (manifest_.target != formats::info(expected).name)
            complain(place + ", format", fmt::format("{} in a folder of target {}", format.name, manifest_.target), "blocks of the target");
    }

    /// Checks that sources are converted to the working space that the manifest names.
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

    /// Returns the size that a texture of an index or of tables must have.
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
        checkTarget(formats::info(reader->shape().format), place);
        expectEqual(place + ", bytes_gpu", texture.bytesGpu, std::uint64_t{reader->shape().gpuBytes()});
        const glm::ivec2 size = isLookup ? lookupSize(asset, texture) : glm::ivec2(asset.width, asset.height);
        expectEqual(place + ", width of its asset", size.x, texture.width);
        expectEqual(place + ", height of its asset", size.y, texture.height);
        if (reader->container() != formats::Container::Ktx2) return;  // DDS has no metadata
        if (!reader->hasOwnTransfer())
            complain(place, "another transfer function in its data format descriptor",
                     fmt::format("that of {}, as cooked", formats::info(reader->shape().format).name));
        const auto metadata = reader->metadata().find(kMetadataKey);
        if (metadata == reader->metadata().end()) return complain(place, "no metadata", fmt::format("the key \"{}\"", kMetadataKey));
        checkMetadata(parseJson(metadata->second), asset, texture, place);
    }

    /// Returns the constants that the metadata of a texture holds: those of a light map are without learned tables and long lists.
    static Json metadataConstants(const CookedAsset& asset) {
        Json constants = asset.constants.value_or(Json::object());
        if (asset.kind != AssetKind::LightMap || !constants.is_object()) return constants;
        Json kept = Json::object();
        for (const auto& [name, value] : constants.items())
            if (name != kTablesRole && value.size() <= kLargestMetadataConstant) kept[name] = value;
        return kept;
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
        const Json maps = parseJson(*text);
        if (!maps.is_array() || maps.size() != 1 || !maps[0].is_object())
            return complain(file, fmt::format("{} light maps", maps.is_array() ? maps.size() : 0), "one");
        for (const auto& [name, value] : maps[0].items())
            if (name != "bound" && !expected->contains(name)) complain(formats::Subject(file).at(name), "it", "no such member");
        for (const auto& [name, value] : expected->items()) {
            const Json found = maps[0].value(name, Json());
            const formats::Subject place = formats::Subject(file).at(name);
            if (name != "constants" || !found.is_object() || found.size() != value.size())
                expectEqual(place, found, value);
            else  // each by itself: all together are a long line
                for (const auto& [constant, numbers] : value.items())
                    expectEqual(place.text + "/" + constant, found.value(constant, Json()), numbers);
        }
        const auto wrong = formats::wrongBinding(file);
        if (!wrong) return errors_.push_back(wrong.error());
        if (*wrong) errors_.push_back({ErrorCode::Verification, file, **wrong});
    }

    /// Checks the copy of the manifest's members inside a texture, which serves a loader without the manifest. It has no learned tables.
    void checkMetadata(const Json& metadata, const CookedAsset& asset, const CookedTexture& texture, const std::string& place) {
        const Json copies = metadata.is_object() ? metadata.value("constants", Json()) : Json();
        if (!copies.is_object()) return complain(place, "metadata of another shape", "its layout and constants");
        const Json constants = metadataConstants(asset);
        if (!constants.is_object()) return;  // the verification of the asset reports it
        for (const auto& [name, value] : constants.items())
            expectEqual(fmt::format("{}, metadata constants/{}", place, name), copies.value(name, Json()), value);
        for (const auto& [name, value] : copies.items())
            if (!constants.contains(name))
                complain(fmt::format("{}, metadata constants/{}", place, name), value.dump(), "no such constant");
        constexpr std::array<std::string_view, 6> kMembers = {"kind", "layout", "role", "constants", "distribution", "normalization"};
        for (const auto& [name, value] : metadata.items())
            if (std::ranges::find(kMembers, name) == kMembers.end())
                complain(fmt::format("{}, metadata {}", place, name), value.dump(), "no such member");
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
