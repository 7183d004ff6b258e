// Inputs as bakers, denoisers and converters damage them, each with its documented outcome: the rows of dirty_inputs.md.
//
// Each input is cooked as it is and with --repair. What cooks is verified. --repair changes nothing of an input that cooks without it; of
// others, where a row says which input they are repaired to, the textures are those of that input, byte for byte. What is refused leaves no
// output. With LIGHTCOOK_UPDATE_DOCS=1 the test writes the rows that differ.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "tests/end_to_end/result_table.h"
#include "tests/formats/exr_fixture.h"
#include "tests/formats/gltf/quad_scene.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/shell.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::ExrRecipe;

const ResultTable kTable(fs::path(LIGHTCOOK_SOURCE_DIR) / "tests/end_to_end/dirty_inputs.md");
constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();

// --- inputs ---------------------------------------------------------------------------------------------------------------------------

constexpr int kMapSide = 16;

/// Light that grows to the right, as an SH map. A chart leaves out the texels at the edge of the map.
/// up  coefficient of the direction that most light comes from
ExrRecipe lightMap(int width = kMapSide, int height = kMapSide, bool hasCoverage = true, int up = 2) {
    ExrRecipe map;
    map.width = width, map.height = height;
    for (int i = 0; i < 9; ++i)
        for (int colour = 0; colour < 3; ++colour)
            map.channels[fmt::format("sh{:02}.{}", i, "RGB"[colour])] = [=](int x, int y) {
                const float light = 1 + 0.25f * static_cast<float>(colour) + static_cast<float>(x) / static_cast<float>(width);
                const float slope = static_cast<float>(y) / static_cast<float>(height) - 0.4f;
                return light * (i == 0 ? 1 : i == up ? 0.9f : i < 4 ? 0.5f * slope : 0.1f * slope);
            };
    if (!hasCoverage) return map;
    map.channels["coverage.Y"] = [=](int x, int y) { return x > 0 && y > 0 && x < width - 1 && y < height - 1 ? 1.0f : 0.0f; };
    map.channels["normal.X"] = map.channels["normal.Y"] = [](int, int) { return 0.0f; };
    map.channels["normal.Z"] = [](int, int) { return 1.0f; };
    return map;
}

/// Returns the map with other values of its coefficients.
ExrRecipe changed(ExrRecipe map, const std::function<float(int coefficient, float value)>& change) {
    for (auto& [name, value] : map.channels)
        if (name.starts_with("sh"))
            value = [change, coefficient = name[3] - '0', before = value](int x, int y) { return change(coefficient, before(x, y)); };
    return map;
}

ExrRecipe without(ExrRecipe recipe, const std::string& channel) {
    std::erase_if(recipe.channels, [&](const auto& each) { return each.first.starts_with(channel); });
    return recipe;
}

/// A sky over a dark ground, as a panorama (height > 1) or as a gradient.
ExrRecipe sky(int width, int height) {
    ExrRecipe picture;
    picture.width = width, picture.height = height;
    for (int colour = 0; colour < 3; ++colour)
        picture.channels[std::string(1, "RGB"[colour])] = [=](int x, int y) {
            const double along = height > 1 ? (y + 0.5) / height : (x + 0.5) / width;
            return static_cast<float>(0.2 + (1 + 0.3 * colour) * std::max(0.0, std::cos(along * std::numbers::pi)));
        };
    return picture;
}

ExrRecipe poked(ExrRecipe recipe, const std::string& channel, int x, int y, float value) {
    formats::poke(recipe, channel, x, y, value);
    return recipe;
}

/// The texels of a recipe, channel by channel.
struct Planes {
    explicit Planes(const ExrRecipe& source) : recipe(source) {
        for (const auto& [name, value] : source.channels)
            for (int y = 0; y < source.height; ++y)
                for (int x = 0; x < source.width; ++x) texels[name].push_back(value(x, y));
    }
    Imf::Header header(Imf::PixelType type = Imf::FLOAT, int sampling = 1) const {
        Imf::Header header(recipe.width, recipe.height);
        for (const auto& [name, values] : texels) header.channels().insert(name, Imf::Channel(type, sampling, sampling));
        return header;
    }
    template <class T>
    Imf::FrameBuffer buffer(Imf::PixelType type, const std::map<std::string, std::vector<T>>& values, int sampling = 1) const {
        Imf::FrameBuffer buffer;
        for (const auto& [name, plane] : values)
            buffer.insert(name, Imf::Slice::Make(type, plane.data(), {0, 0}, recipe.width, recipe.height, 0, 0, sampling, sampling));
        return buffer;
    }

    const ExrRecipe& recipe;
    std::map<std::string, std::vector<float>> texels = {};
};

void writeUint(const fs::path& file, const ExrRecipe& recipe) {
    const Planes planes(recipe);
    std::map<std::string, std::vector<unsigned>> values;
    for (const auto& [name, plane] : planes.texels)
        for (const float value : plane) values[name].push_back(static_cast<unsigned>(std::max(0.0f, value)));
    Imf::OutputFile output(file.c_str(), planes.header(Imf::UINT));
    output.setFrameBuffer(planes.buffer(Imf::UINT, values));
    output.writePixels(recipe.height);
}

/// Every other texel of every other row alone.
void writeSubsampled(const fs::path& file, const ExrRecipe& recipe) {
    const Planes planes(recipe);
    Imf::OutputFile output(file.c_str(), planes.header(Imf::FLOAT, 2));
    output.setFrameBuffer(planes.buffer(Imf::FLOAT, planes.texels, 2));
    output.writePixels(recipe.height);
}

void writeMipMapped(const fs::path& file, const ExrRecipe& recipe) {
    const Planes planes(recipe);
    Imf::Header header = planes.header();
    header.setTileDescription(Imf::TileDescription(8, 8, Imf::MIPMAP_LEVELS));
    Imf::TiledOutputFile output(file.c_str(), header);
    output.setFrameBuffer(planes.buffer(Imf::FLOAT, planes.texels));
    for (int level = 0; level < output.numLevels(); ++level)
        output.writeTiles(0, output.numXTiles(level) - 1, 0, output.numYTiles(level) - 1, level);
}

void writeParts(const fs::path& file, const ExrRecipe& recipe) {
    const Planes planes(recipe);
    std::vector<Imf::Header> headers(2, planes.header());
    for (std::size_t i = 0; i < 2; ++i) headers[i].setName(i == 0 ? "light" : "noise"), headers[i].setType(Imf::SCANLINEIMAGE);
    Imf::MultiPartOutputFile output(file.c_str(), headers.data(), 2);
    for (int i = 0; i < 2; ++i) {
        Imf::OutputPart part(output, i);
        part.setFrameBuffer(planes.buffer(Imf::FLOAT, planes.texels));
        part.writePixels(recipe.height);
    }
}

/// One sample a texel.
void writeDeep(const fs::path& file, const ExrRecipe& recipe) {
    const Planes planes(recipe);
    Imf::Header header = planes.header();
    header.setType(Imf::DEEPSCANLINE);
    header.compression() = Imf::ZIPS_COMPRESSION;
    const auto width = static_cast<std::size_t>(recipe.width), count = width * static_cast<std::size_t>(recipe.height);
    std::vector<unsigned> samples(count, 1);
    std::map<std::string, std::vector<const float*>> pointers;
    Imf::DeepFrameBuffer buffer;
    buffer.insertSampleCountSlice(
        Imf::Slice(Imf::UINT, reinterpret_cast<char*>(samples.data()), sizeof(unsigned), sizeof(unsigned) * width));
    for (const auto& [name, plane] : planes.texels) {
        for (const float& value : plane) pointers[name].push_back(&value);
        buffer.insert(name, Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers[name].data()), sizeof(float*),
                                           sizeof(float*) * width, sizeof(float)));
    }
    Imf::DeepScanLineOutputFile output(file.c_str(), header);
    output.setFrameBuffer(buffer);
    output.writePixels(recipe.height);
}

void writeChroma(const fs::path& file) {
    Imf::RgbaOutputFile output(file.c_str(), Imf::Header(kMapSide, kMapSide), Imf::WRITE_YC);
    const std::vector<Imf::Rgba> texels(kMapSide * kMapSide, Imf::Rgba(0.5f, 0.25f, 1));
    output.setFrameBuffer(texels.data(), 1, kMapSide);
    output.writePixels(kMapSide);
}

// --- rows -----------------------------------------------------------------------------------------------------------------------------

/// A folder with an input and the scene file that names it.
class Scene {
public:
    fs::path operator/(const fs::path& name) const { return folder_ / name; }
    void write(const ExrRecipe& recipe) const { formats::writeRecipe(folder_ / "input.exr", recipe); }
    /// Without specular light: its tables take ten times as long as the light map.
    void writeSceneFile(const std::string& asset) const {
        const std::string head = "schema = 1\nname = \"dirty\"\n[output]\nlight_map_layout = \"ratio\"\neffort = 0\n";
        const bool isMap = asset.starts_with("[[light_map]]");
        formats::writeContent(folder_ / "scene.toml", head + asset + (isMap ? "[[material]]\nname = \"*\"\nspecular = false\n" : ""));
    }
    int run(const std::string& arguments) const {
        return runShell(fmt::format("cd '{}' && LIGHTCOOK_CACHE='{}' '{}' {} </dev/null >stdout 2>stderr", folder_.path().string(),
                                    LIGHTCOOK_TEST_CACHE, LIGHTCOOK_PROGRAM, arguments));
    }
    /// Returns what was printed on standard error, in one line without the program's name.
    std::string printed() const {
        std::string line = withoutDone(formats::contentOf(folder_ / "stderr"));
        for (std::size_t at = 0; (at = line.find("lightcook: ", at)) != std::string::npos;) line.erase(at, 11);
        if (line.ends_with('\n')) line.pop_back();
        for (std::size_t at = 0; (at = line.find('\n', at)) != std::string::npos;) line.replace(at, 1, " / ");
        return line;
    }
    /// Returns the names and contents of the textures in a folder.
    std::map<std::string, std::string> textures(const char* output) const {
        std::map<std::string, std::string> textures;
        for (const auto& entry : fs::directory_iterator(folder_ / output))
            if (entry.path().extension() == ".ktx2") textures[entry.path().filename()] = formats::contentOf(entry.path());
        return textures;
    }

private:
    formats::TemporaryFolder folder_;
};

struct Row {
    std::string what;  ///< first cell
    std::function<void(const Scene&)> write;
    /// Input that --repair makes of it. Empty: the row is refused with --repair too, or it needs none.
    std::function<void(const Scene&)> writeRepaired = {};
    bool isSoak = false;
};

constexpr const char* kMapEntry = "[[light_map]]\nname = \"map\"\nfile = \"input.exr\"\n";
constexpr const char* kProbeEntry = "[[probe]]\nname = \"probe\"\nfile = \"input.exr\"\nsize = 16\n";
constexpr const char* kGradientEntry = "[[gradient]]\nname = \"sky\"\nfile = \"input.exr\"\nexponents = [1, 16]\n";

std::function<void(const Scene&)> input(const ExrRecipe& recipe, const char* entry = kMapEntry) {
    return [=](const Scene& scene) { scene.write(recipe), scene.writeSceneFile(entry); };
}

std::function<void(const Scene&)> input(void (*write)(const fs::path&, const ExrRecipe&), const char* entry = kMapEntry) {
    return [=](const Scene& scene) {
        write(scene / "input.exr", entry == kMapEntry ? lightMap() : sky(16, entry == kProbeEntry ? 8 : 1));
        scene.writeSceneFile(entry);
    };
}

struct Value {
    const char* name;
    float value;
};
constexpr Value kValues[] = {{"NaN", kNan}, {"+infinity", kInfinity}, {"-infinity", -kInfinity}, {"-1", -1}, {"1e-40", 1e-40f},
                             {"1e6", 1e6f}, {"1e30", 1e30f}};

/// Sets the coefficients of a texel to zero: all, or those of a colour.
ExrRecipe blackened(ExrRecipe map, int x, int y, const std::string& colours = "RGB") {
    for (int i = 0; i < 9; ++i)
        for (const char colour : colours) formats::poke(map, fmt::format("sh{:02}.{}", i, colour), x, y, 0);
    return map;
}

/// Gives a texel the mean of its covered neighbours.
ExrRecipe smoothed(ExrRecipe map, int x, int y) {
    const ExrRecipe before = map;
    for (const auto& [name, value] : before.channels) {
        if (!name.starts_with("sh")) continue;
        float sum = 0, count = 0;
        for (int v = y - 1; v <= y + 1; ++v)
            for (int u = std::max(0, x - 1); u <= x + 1; ++u) {
                if ((u == x && v == y) || (before.channels.contains("coverage.Y") && before.channels.at("coverage.Y")(u, v) == 0)) continue;
                sum += value(u, v);
                ++count;
            }
        formats::poke(map, name, x, y, sum / count);
    }
    return map;
}

/// Returns what --repair makes of sh00.G = value, or of another coefficient; nothing if a band is scaled.
std::optional<ExrRecipe> repaired(const ExrRecipe& map, bool isDirection, float value, int x, int y, bool isRim) {
    if (std::isnan(value) || value == -kInfinity || (isDirection && value == kInfinity)) return blackened(map, x, y);
    if (isDirection || value == 1e-40f) return std::nullopt;
    if (value < 0) return blackened(map, x, y, "G");
    if (isRim && value == kInfinity) return poked(blackened(map, x, y, "G"), "sh00.G", x, y, 65504);
    return smoothed(map, x, y);
}

/// One value at one texel of a light map.
void addTexels(std::vector<Row>& rows) {
    struct Place {
        const char* name;
        int x, y;
        bool isRim, isInside;
    };
    const ExrRecipe whole = lightMap(), bare = lightMap(kMapSide, kMapSide, false);
    const auto add = [&](const ExrRecipe& map, const std::string& what, const Place& place, const std::string& channel,
                         const Value& value) {
        Row row{fmt::format("{}, {} {} {}", what, channel, value.name, place.name),
                input(poked(map, channel, place.x, place.y, value.value))};
        const bool isKept = !place.isInside || (place.isRim && value.value == 1e6f);
        const auto expected = isKept ? std::nullopt : repaired(map, channel[3] != '0', value.value, place.x, place.y, place.isRim);
        if (expected) row.writeRepaired = input(*expected);
        // The rest of the matrix is in CI for its corners alone.
        row.isSoak = (!place.isInside && !std::isnan(value.value)) || value.value == -kInfinity ||
                     (place.isRim && (value.value == -1 || value.value == 1e-40f));
        rows.push_back(row);
    };
    for (const Place& place : {Place{"inside a chart", 7, 6, false, true}, Place{"at the rim of a chart", 1, 6, true, true},
                               Place{"outside charts", 0, 6, false, false}})
        for (const Value& value : kValues) add(whole, "light map", place, "sh00.G", value);
    for (const Value& value : kValues)
        if (!(value.value < 1)) add(whole, "light map", {"inside a chart", 7, 6, false, true}, "sh03.G", value);
    for (const Value& value : kValues)
        add(bare, "light map without coverage", {"at the edge of the map", 0, 6, true, true}, "sh00.G", value);
    for (const char* channel : {"coverage.Y", "normal.Z"})
        for (const Value& each : {Value{"NaN", kNan}, Value{"+infinity", kInfinity}, Value{"-1", -1}, Value{"0", 0}}) {
            rows.push_back(
                {fmt::format("light map, {} {} inside a chart", channel, each.name), input(poked(whole, channel, 7, 6, each.value))});
            if (!std::isfinite(each.value)) rows.back().writeRepaired = input(poked(whole, "coverage.Y", 7, 6, 0));
        }
}

/// Whole light maps.
void addMaps(std::vector<Row>& rows) {
    const auto even = [](float value) { return changed(lightMap(), [=](int i, float) { return i == 0 ? value : 0; }); };
    for (const Value& each :
         {Value{"black", 0}, Value{"constant, 1", 1}, Value{"constant, 1e-40", 1e-40f}, Value{"constant, 1e-30", 1e-30f},
          Value{"constant, 65504", 65504}, Value{"constant, 1e30", 1e30f}, Value{"NaN everywhere", kNan}})
        rows.push_back({fmt::format("light map, {}", each.name), input(even(each.value))});
    for (const glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(1, 7), glm::ivec2(7, 1), glm::ivec2(3, 5)})
        rows.push_back({fmt::format("light map of {} x {} texels", size.x, size.y), input(lightMap(size.x, size.y, false))});
    rows.push_back({"light map of 1 x 1 texels, NaN", input(poked(lightMap(1, 1, false), "sh00.G", 0, 0, kNan))});
    rows.push_back({"light map of 211 x 97 texels", input(lightMap(211, 97))});
    rows.push_back({"light map of 1031 x 521 texels", [](const Scene& scene) {
                        ExrRecipe picture = sky(1031, 521);
                        picture.isHalf = true;
                        scene.write(picture);
                        scene.writeSceneFile(std::string(kMapEntry) + "bake = \"flat\"\n");
                    }});
    rows.back().isSoak = true;
    rows.push_back({"light map without sh03.G", input(without(lightMap(), "sh03.G"))});
    rows.push_back({"light map without sh04 to sh08", [](const Scene& scene) {
                        ExrRecipe map = lightMap();
                        for (int i = 4; i < 9; ++i) map = without(map, fmt::format("sh{:02}", i));
                        input(map)(scene);
                    }});
    rows.push_back({"light map without normal.Y", input(without(lightMap(), "normal.Y"))});
    rows.push_back({"light map without coverage and normals", input(lightMap(kMapSide, kMapSide, false))});
    ExrRecipe half = lightMap(), tiles = lightMap(), halfTiles = lightMap();
    half.isHalf = halfTiles.isHalf = tiles.isTiled = halfTiles.isTiled = true;
    tiles.tileExtent = halfTiles.tileExtent = 5;
    rows.push_back({"light map of halves", input(half)});
    rows.push_back({"light map in tiles of 5 x 5", input(tiles)});
    rows.push_back({"light map of halves in tiles of 5 x 5", input(halfTiles)});
    rows.push_back({"light map in tiles with mip levels", input(writeMipMapped)});
    rows.push_back({"light map of integers (UINT)", input(writeUint)});
    rows.push_back({"light map whose channels have a texel in four", input(writeSubsampled)});
    rows.push_back({"light map of two parts", input(writeParts)});
    rows.push_back({"deep light map", input(writeDeep)});
    rows.push_back({"light map of luminance and chroma", [](const Scene& scene) {
                        writeChroma(scene / "input.exr");
                        scene.writeSceneFile(kMapEntry);
                    }});
}

void addEnvironments(std::vector<Row>& rows) {
    for (const char* entry : {kProbeEntry, kGradientEntry}) {
        const char* name = entry == kProbeEntry ? "probe" : "gradient";
        const ExrRecipe picture = sky(16, entry == kProbeEntry ? 8 : 1);
        const int y = entry == kProbeEntry ? 2 : 0;
        const auto even = [&](float value) {
            ExrRecipe all = picture;
            for (auto& [channel, each] : all.channels) each = [=](int, int) { return value; };
            return all;
        };
        for (const auto& [what, value] : kValues) {
            rows.push_back({fmt::format("{}, G {} at a texel", name, what), input(poked(picture, "G", 5, y, value), entry)});
            if (value == kInfinity)
                rows.back().writeRepaired = input(poked(picture, "G", 5, y, 65504), entry);
            else if (!(value >= 0))
                rows.back().writeRepaired = input(poked(poked(poked(picture, "R", 5, y, 0), "G", 5, y, 0), "B", 5, y, 0), entry);
            rows.back().isSoak = value == -kInfinity;
        }
        for (const Value& each :
             {Value{"black", 0}, Value{"constant, 1", 1}, Value{"constant, 1e-40", 1e-40f}, Value{"constant, 1e30", 1e30f}})
            rows.push_back({fmt::format("{}, {}", name, each.name), input(even(each.value), entry)});
        rows.push_back({fmt::format("{} without B", name), input(without(picture, "B"), entry)});
        ExrRecipe half = picture;
        half.isHalf = true;
        rows.push_back({fmt::format("{} of halves", name), input(half, entry)});
        rows.push_back({fmt::format("{} of integers (UINT)", name), input(writeUint, entry)});
        rows.push_back({fmt::format("{} of two parts", name), input(writeParts, entry)});
        rows.push_back({fmt::format("deep {}", name), input(writeDeep, entry)});
        rows.push_back({fmt::format("{} of 1 x 1 texels", name), input(sky(1, 1), entry)});
    }
    rows.push_back({"probe of 2 x 1 texels", input(sky(2, 1), kProbeEntry)});
}

/// Light maps on two quads, one over each half of the map.
void addMeshes(std::vector<Row>& rows) {
    const auto add = [&](const char* what, const std::function<void(formats::QuadScene&)>& change,
                         const formats::Quad& second = {"b", {0.5, 0}, {1, 1}}) {
        rows.push_back({what, [=](const Scene& scene) {
                            formats::QuadScene mesh;
                            mesh.add({"a", {0, 0}, {0.5, 1}});
                            mesh.add(second);
                            change(mesh);
                            mesh.write(scene / "mesh.glb");
                            scene.write(lightMap(kMapSide, kMapSide, false, 1));
                            scene.writeSceneFile(std::string(kMapEntry) + "mesh = \"mesh.glb\"\n");
                        }});
    };
    /// Sets a number of the first attribute of its kind: accessor 0 has the positions of mesh a, 1 its normals, 3 its light-map UVs.
    const auto set = [](formats::QuadScene& mesh, std::size_t accessor, std::size_t first, std::size_t count, float value) {
        const auto& view = mesh.json["bufferViews"][mesh.json["accessors"][accessor]["bufferView"].get<std::size_t>()];
        for (std::size_t i = first; i < first + count; ++i)
            std::memcpy(mesh.binary.data() + view["byteOffset"].get<std::size_t>() + 4 * i, &value, sizeof value);
    };
    add("mesh without faults", [](auto&) {});
    add("mesh with overlapping charts", [](auto&) {}, {"b", {0, 0}, {0.5, 1}});
    add("mesh without TEXCOORD_1", [](auto& mesh) {
        for (auto& each : mesh.json["meshes"]) each["primitives"][0]["attributes"].erase("TEXCOORD_1");
    });
    add("mesh of which one node lacks TEXCOORD_1", [](auto&) {}, {"b", {0.5, 0}, {1, 1}, false});
    add("mesh with a triangle without area", [=](auto& mesh) { set(mesh, 0, 6, 3, 0); });
    add("mesh of which all triangles are without area", [=](auto& mesh) {
        for (const std::size_t accessor : {0u, 5u}) set(mesh, accessor, 0, 12, 0);
    });
    add("mesh with a triangle without area in UV", [=](auto& mesh) { set(mesh, 3, 4, 2, 0); });
    add("mesh with a normal of zero", [=](auto& mesh) { set(mesh, 1, 0, 3, 0); });
    add("mesh of which all normals are zero", [=](auto& mesh) {
        for (const std::size_t accessor : {1u, 6u}) set(mesh, accessor, 0, 12, 0);
    });
    add("mesh with a position of NaN", [=](auto& mesh) { set(mesh, 0, 0, 1, kNan); });
    add("mesh with a position of 1e30", [=](auto& mesh) { set(mesh, 0, 3, 1, 1e30f); });
    add("mesh with a normal of NaN", [=](auto& mesh) { set(mesh, 1, 0, 1, kNan); });
    add("mesh with a light-map UV of NaN", [=](auto& mesh) { set(mesh, 3, 0, 1, kNan); });
    add("mesh with a light-map UV of 1e30", [=](auto& mesh) { set(mesh, 3, 0, 1, 1e30f); });
    add("mesh without nodes", [](auto& mesh) { mesh.json["nodes"] = nlohmann::json::array(); });
}

const std::vector<Row>& allRows() {
    static const std::vector<Row> rows = [] {
        std::vector<Row> made;
        addTexels(made), addMaps(made), addEnvironments(made), addMeshes(made);
        return made;
    }();
    return rows;
}

// --- test -----------------------------------------------------------------------------------------------------------------------------

class DirtyInputs : public testing::TestWithParam<Row> {};

/// Cooks, and appends what was printed and the exit code to the cells.
int cook(const Scene& scene, const std::string& output, const char* option, Cells& cells) {
    const int code = scene.run(fmt::format("cook scene.toml -o {} {}", output, option));
    std::string printed = scene.printed();
    EXPECT_TRUE(code == 0 || code == 3 || code == 4) << code << ' ' << printed;
    if (code == 0) {
        printed = printed.empty() ? "cooks and verifies" : "cooks and verifies; " + printed;
    } else {
        EXPECT_THAT(printed, testing::ContainsRegex("^(warning: .* / )*error: [^/]")) << "findings, and one line for the fault";
    }
    if (code == 3) {
        EXPECT_FALSE(fs::exists(scene / output));
    }
    cells.push_back(printed);
    cells.push_back(std::to_string(code));
    return code;
}

TEST_P(DirtyInputs, EndAsTheTableSays) {
    const Row& row = GetParam();
    const Scene scene;
    row.write(scene);
    Cells found = {row.what};
    const int plain = cook(scene, "plain", "", found), repaired = cook(scene, "repaired", "--repair", found);
    if (plain == 0 && repaired == 0) {
        EXPECT_EQ(scene.textures("plain"), scene.textures("repaired")) << "repaired what is no fault";
        EXPECT_EQ(found[1], found[3]);
    }
    if (repaired == 0) {
        EXPECT_EQ(scene.run("verify repaired"), 0) << scene.printed();
    }
    if (found[3] == found[1]) found[3] = "the same";
    const Cells written = kTable.rowFor(found);
    ASSERT_EQ(written.size(), found.size()) << "dirty_inputs.md has no such row; what is printed: " << testing::PrintToString(found);
    for (std::size_t i = 1; i < found.size(); ++i)
        EXPECT_TRUE(matches(found[i], written[i])) << "found:    " << found[i] << "\nexpected: " << written[i];
    if (row.writeRepaired) {
        row.writeRepaired(scene);
        ASSERT_EQ(scene.run("cook scene.toml -o expected"), 0) << scene.printed();
        EXPECT_EQ(scene.textures("repaired"), scene.textures("expected")) << "repaired to something else";
    }
}

std::string nameOf(const testing::TestParamInfo<Row>& info) {
    std::string name;
    for (const char c : info.param.what)
        name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : c == '+' ? 'p' : c == '-' ? 'm' : '_';
    return name;
}
std::vector<Row> rowsOf(bool isSoak) {
    std::vector<Row> rows;
    std::ranges::copy_if(allRows(), std::back_inserter(rows), [=](const Row& row) { return row.isSoak == isSoak; });
    return rows;
}
INSTANTIATE_TEST_SUITE_P(Table, DirtyInputs, testing::ValuesIn(rowsOf(false)), nameOf);
INSTANTIATE_TEST_SUITE_P(Soak, DirtyInputs, testing::ValuesIn(rowsOf(true)), nameOf);

TEST(DirtyInputsTable, HasARowForEachInputAndNoOther) {
    std::vector<std::string> tested, written;
    for (const Row& row : allRows()) tested.push_back(row.what);
    for (const auto& [what, cells] : kTable.rows()) written.push_back(what);
    EXPECT_THAT(written, testing::UnorderedElementsAreArray(tested));
}

}  // namespace
}  // namespace lightcook::pipeline
