// The example scene in a folder of its own, with faults planted in its light map, mesh, probe or scene file.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <glm/vec2.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/image/exr_file.h"
#include "pipeline/cook/cook.h"
#include "tests/formats/exr_attribute.h"
#include "tests/formats/gltf/glb.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/example_folder.h"

namespace lightcook::pipeline {

/// The channels of an EXR file by name, as floats.
struct Channels {
    int width = 0, height = 0;
    std::map<std::string, std::vector<float>> values;

    static Channels read(const std::filesystem::path& file) {
        const auto reader = formats::ExrReader::open(file);
        Channels channels{reader->info().width, reader->info().height, {}};
        std::vector<formats::ExrPlane> planes;
        for (const std::string& name : reader->info().channels) {
            std::vector<float>& texels = channels.values[name];
            texels.resize(static_cast<std::size_t>(channels.width) * static_cast<std::size_t>(channels.height));
            planes.push_back({name, texels.data(), 1, channels.width});
        }
        (void)reader->readRows(0, channels.height, planes);
        return channels;
    }
    bool write(const std::filesystem::path& file) const {
        std::vector<std::string> names;
        for (const auto& [name, texels] : values) names.push_back(name);
        auto writer = formats::ExrWriter::create(file, width, height, names, formats::ExrLayout::ScanLines);
        std::vector<float> rows;
        rows.reserve(values.size() * values.begin()->second.size());
        for (std::size_t i = 0; i < values.begin()->second.size(); ++i)
            for (const auto& [name, texels] : values) rows.push_back(texels[i]);
        return writer && writer->append(rows.data(), static_cast<std::ptrdiff_t>(names.size()) * width, height) && writer->commit();
    }

    std::vector<float>& operator[](const std::string& name) { return values.at(name); }
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
    /// Calls edit(value) for every coefficient of every texel, with the number of the coefficient.
    void forEachCoefficient(const std::function<void(int, float&)>& edit) {
        for (int i = 0; i < 9; ++i)
            for (const char channel : {'R', 'G', 'B'})
                for (float& value : values.at("sh0" + std::to_string(i) + "." + channel)) edit(i, value);
    }
};

/// A GLB with one buffer.
struct Glb {
    nlohmann::json json;
    std::string binary;

    static Glb read(const std::filesystem::path& file) {
        const std::string bytes = formats::contentOf(file);
        const auto word = [&](std::size_t at) {
            std::uint32_t value = 0;
            std::memcpy(&value, bytes.data() + at, 4);
            return static_cast<std::size_t>(value);
        };
        const std::size_t jsonBytes = word(12), binaryAt = 20 + jsonBytes;
        return {nlohmann::json::parse(bytes.substr(20, jsonBytes)), bytes.substr(binaryAt + 8, word(binaryAt))};
    }
    void write(const std::filesystem::path& file) const { formats::writeContent(file, formats::glbOf(json.dump(), binary)); }

    /// Calls edit(uv) for each light-map UV of the file, once.
    void forEachUv(const std::function<void(glm::vec2&)>& edit) {
        std::map<std::size_t, bool> done;
        for (const auto& mesh : json["meshes"])
            for (const auto& primitive : mesh["primitives"]) {
                const auto accessor = primitive["attributes"]["TEXCOORD_1"].get<std::size_t>();
                if (std::exchange(done[accessor], true)) continue;
                const nlohmann::json& info = json["accessors"][accessor];
                const nlohmann::json& view = json["bufferViews"][info["bufferView"].get<std::size_t>()];
                const std::size_t first = view.value("byteOffset", std::size_t{0}) + info.value("byteOffset", std::size_t{0});
                const std::size_t stride = view.value("byteStride", sizeof(glm::vec2));
                for (std::size_t i = 0; i < info["count"].get<std::size_t>(); ++i) {
                    glm::vec2 uv;
                    std::memcpy(&uv, binary.data() + first + i * stride, sizeof uv);
                    edit(uv);
                    std::memcpy(binary.data() + first + i * stride, &uv, sizeof uv);
                }
            }
    }
};

class PlantedScene {
public:
    PlantedScene() { std::filesystem::copy(exampleFolder(), folder_.path(), std::filesystem::copy_options::recursive); }
    std::filesystem::path operator/(const std::filesystem::path& name) const { return folder_ / name; }
    const std::filesystem::path& path() const { return folder_.path(); }

    void editLightMap(const std::function<void(Channels&)>& edit) const { editExr("cornell_lightmap.exr", edit); }
    /// Lets a file state its primaries.
    void statePrimaries(const std::array<float, 8>& xy, const char* name = "cornell_lightmap.exr") const {
        editExr(name, [](Channels&) {});  // as scan lines
        const std::filesystem::path file = folder_ / name;
        formats::writeContent(file, formats::withChromaticities(formats::contentOf(file), xy));
    }
    void editProbe(const std::function<void(Channels&)>& edit) const { editExr("cornell_probe0.exr", edit); }
    void editGradient(const std::function<void(Channels&)>& edit) const { editExr("clear_sky_256x1.exr", edit); }
    void editMesh(const std::function<void(Glb&)>& edit) const {
        Glb glb = Glb::read(folder_ / "cornell.glb");
        edit(glb);
        glb.write(folder_ / "cornell.glb");
    }
    /// Replaces a text of a file that occurs in it.
    void replace(const std::filesystem::path& file, const std::string& what, const std::string& with) const {
        std::string text = formats::contentOf(folder_ / file);
        const std::size_t at = text.find(what);
        if (at == std::string::npos) throw std::invalid_argument(file.string() + " holds no '" + what + "'");
        formats::writeContent(folder_ / file, text.replace(at, what.size(), with));
    }
    void replaceInScene(const std::string& what, const std::string& with) const { replace("scene.toml", what, with); }

    Outcome lint(bool strict = false) const {
        const RunState state;
        return lintScene({folder_ / "scene.toml", LIGHTCOOK_TEST_CACHE, strict, false}, state);
    }

private:
    void editExr(const char* name, const std::function<void(Channels&)>& edit) const {
        Channels channels = Channels::read(folder_ / name);
        edit(channels);
        if (!channels.write(folder_ / name)) throw std::runtime_error(name);
    }
    formats::TemporaryFolder folder_;
};

}  // namespace lightcook::pipeline
