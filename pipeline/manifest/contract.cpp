#include "pipeline/manifest/contract.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "formats/gpu_texture.h"
#include "formats/light_map_layout.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/json_shape.h"
#include "shaders/include.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;

/// Conventions of the shared shaders, by kind of asset. "frame" of a table is the shader's own; its lobe and
/// normalization are what its verification integrates.
const std::map<std::string, std::map<std::string, std::string>>& conventions() {
    static const std::map<std::string, std::map<std::string, std::string>> kConventions = {
        {"light-map", {{"units", "radiometric"}, {"phase", "none"}, {"frame", "world"}}},
        {"dominant", {{"units", "radiometric"}, {"frame", "world"}}},
        {"cubemap", {{"units", "radiometric"}, {"phase", "none"}, {"frame", "world"}}},
        {"lut", {{"phase", "none"}, {"frame", "z the normal, the view in the x-z plane"}}},
        {"rsrm", {{"units", "radiometric"}}},
        {"mesh", {}}};
    return kConventions;
}

class Contract {
public:
    Contract(const std::filesystem::path& folder, const Json& manifest) : folder_(folder), manifest_(manifest) {}

    std::vector<Error> check() && {
        checkShader();
        for (const Json& asset : manifest_.at("assets")) {
            checkConventions(asset);
            checkColors(asset);
            if (asset.at("kind") == "cubemap") checkRoughness(asset);
            if (asset.contains("file")) checkFileSize(asset, asset.at("name").get<std::string>());
            for (const Json& texture : asset.at("textures")) checkTexture(asset, texture);
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
        std::vector<std::string> layouts;
        for (const Json& asset : manifest_.at("assets"))
            if (asset.at("kind") == "light-map") layouts.push_back(asset.at("layout").get<std::string>());
        for (const std::string& layout : layouts)
            if (!formats::lightMapLayoutFromName(layout)) return;  // the verification of that asset names it
        const std::filesystem::path file = folder_ / manifest_.at("shader").at("file").get<std::string>();
        if (const auto text = readFile(file); !text || *text != shaders::shaderInclude(formats::lightMapFamilies(layouts)))
            complain(file.string(), "another shader", "the one that this version verifies by");
    }
    void checkConventions(const Json& asset) {
        for (const auto& [key, value] : conventions().at(asset.at("kind").get<std::string>()))
            expectEqual(fmt::format("{}, {}", asset.at("name").get<std::string>(), key), asset.value(key, Json()), value);
    }

    /// Sources were converted to the space that the manifest names.
    void checkColors(const Json& asset) {
        const Json& source = asset.at("source");
        Json working;
        if (source.contains("description")) working = source.at("description").value("color_working", Json());
        if (source.contains("colors")) working = source.at("colors").value("working", Json());
        if (!working.is_null())
            expectEqual(asset.at("name").get<std::string>() + ", color/working", manifest_.at("color").at("working"), working);
    }

    /// An engine picks the mip by perceptual roughness; the kernel was filtered with its square.
    void checkRoughness(const Json& asset) {
        const std::string name = asset.at("name").get<std::string>();
        const Json& constants = asset.at("constants");
        expectEqual(name + ", constants/kernel", constants.value("kernel", Json()), "beckmann");
        int mip = 0;
        for (const Json& each : constants.at("mips")) {
            const double perceptual = each.at("perceptual_roughness").get<double>(), m = each.at("m").get<double>();
            if (!(std::abs(perceptual * perceptual - m) <= 1e-6))
                complain(fmt::format("{}, constants/mips/{}", name, mip), fmt::format("perceptual_roughness {} with m {}", perceptual, m),
                         "m to be its square");
            ++mip;
        }
    }

    void checkFileSize(const Json& entry, const std::string& place) {
        std::error_code code;
        const auto bytes = std::filesystem::file_size(folder_ / entry.at("file").get<std::string>(), code);
        if (!code) expectEqual(place + ", bytes_disk", entry.at("bytes_disk").get<std::uint64_t>(), std::uint64_t{bytes});
    }

    void checkTexture(const Json& asset, const Json& texture) {
        const std::string place = fmt::format("{}, texture {}", asset.at("name").get<std::string>(), texture.at("role").get<std::string>());
        const Json sampler = {{"filter", asset.at("kind") == "cubemap" ? "trilinear" : "linear"}, {"wrap", "clamp"}};
        expectEqual(place + ", sampler", texture.value("sampler", Json()), sampler);
        checkFileSize(texture, place);
        const auto reader = formats::TextureReader::open(folder_ / texture.at("file").get<std::string>());
        if (!reader) {
            errors_.push_back(reader.error());
            return;
        }
        expectEqual(place + ", bytes_gpu", texture.at("bytes_gpu").get<std::uint64_t>(), std::uint64_t{reader->shape().gpuBytes()});
        for (const char* key : {"width", "height"}) expectEqual(place + ", " + key + " of its asset", asset.at(key), texture.at(key));
        if (const auto told = reader->metadata().find("io.lightcook"); told != reader->metadata().end())
            checkMetadata(parseJson(told->second), asset, place);
    }

    /// What the texture says of itself, in case the manifest gets lost: learned tables it leaves out.
    void checkMetadata(const Json& told, const Json& asset, const std::string& place) {
        if (told.is_discarded() || !told.is_object() || !told.contains("constants") || !told.at("constants").is_object())
            return complain(place, "metadata of another shape", "its layout and constants");
        for (const auto& [name, value] : told.at("constants").items())
            expectEqual(fmt::format("{}, metadata constants/{}", place, name), value, asset.at("constants").value(name, Json()));
        if (asset.at("kind") == "light-map" && told.contains("layout"))
            expectEqual(place + ", metadata layout", told.at("layout"), asset.at("layout"));
        if (asset.at("kind") == "lut")
            for (const char* key : {"distribution", "normalization"})
                expectEqual(fmt::format("{}, metadata {}", place, key), told.value(key, Json()), asset.value(key, Json()));
    }

    const std::filesystem::path& folder_;
    const Json& manifest_;
    std::vector<Error> errors_;
};

}  // namespace

std::vector<Error> checkContract(const std::filesystem::path& folder, const Json& manifest) {
    return Contract(folder, manifest).check();
}

}  // namespace lightcook::pipeline
