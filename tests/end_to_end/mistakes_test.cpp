// The table of mistakes.md, row by row: each mistake is made in a copy of the example scene, the row's command runs there, and
// exit code and message must be those of the row. With LIGHTCOOK_UPDATE_DOCS=1 the test writes the rows that differ into the table.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <functional>
#include <limits>

#include "formats/light_map.h"
#include "formats/plain_image.h"
#include "tests/end_to_end/result_table.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/unreal_fixture.h"
#include "tests/pipeline/lint/faults.h"
#include "tests/pipeline/shell.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::contentOf;
using formats::writeContent;

const ResultTable kTable(fs::path(LIGHTCOOK_SOURCE_DIR) / "tests/end_to_end/mistakes.md");

/// A copy of the example scene, to make a mistake in.
class ExampleCopy : public PlantedScene {
public:
    void append(const fs::path& file, const std::string& text) const { writeContent(*this / file, contentOf(*this / file) + text); }
    /// Keeps the first part of a file.
    void truncate(const fs::path& file, double share) const {
        fs::resize_file(*this / file, static_cast<std::uintmax_t>(share * static_cast<double>(fs::file_size(*this / file))));
    }
    /// Reduces the scene to its gradient, which cooks in a fraction of a second.
    void keepGradient(const std::string& output = "") const {
        writeContent(*this / "scene.toml", "schema = 1\nname = \"cornell\"\n\n[output]\n" + output +
                                               "\n\n[[gradient]]\nname = \"sky\"\nfile = \"clear_sky_256x1.exr\"\nexponents = [1, 16]\n");
    }
    /// Runs a command line of the program before the one of the row.
    void run(const std::string& commandLine) const {
        if (shell(commandLine) != 0) throw std::runtime_error(commandLine + ": " + contentOf(*this / "stderr"));
    }
    /// Returns the exit code; what is printed lies in the files stdout and stderr.
    int shell(const std::string& commandLine) const {
        return runShell(
            fmt::format("cd '{0}' && lightcook() {{ LIGHTCOOK_CACHE='{4}' '{1}' \"$@\"; }} && {2} </dev/null "
                        "{3}2>'{0}/stderr'",
                        path().string(), LIGHTCOOK_PROGRAM, commandLine, commandLine.find('>') == std::string::npos ? ">stdout " : "",
                        LIGHTCOOK_TEST_CACHE));
    }
};

struct Mistake {
    const char* what;     ///< first cell of the row
    const char* command;  ///< second cell
    std::function<void(const ExampleCopy& scene)> make;
};

void setProbeTexel(const ExampleCopy& scene, float value) {
    formats::Image<glm::vec4> strip(16, 96, glm::vec4(1));
    strip.at(3, 50).y = value;
    if (const auto written = formats::writeExr(scene / "cornell_probe0.exr", strip.view(), 3); !written)
        throw std::runtime_error(written.error().line());
}

/// Writes a light map of 16 x 16 texels with one other value of the first coefficient.
void writeLightMap(const ExampleCopy& scene, float value) {
    auto writer = formats::LightMapWriter::create(scene / "cornell_lightmap.exr", 16, 16);
    formats::Image<lighting::ShRgb> rows(16, 16);
    for (lighting::ShRgb& texel : rows.texels()) texel[0] = glm::vec3(1);
    rows.at(12, 7)[0].y = value;
    if (!writer || !writer->append(rows.view()) || !writer->commit()) throw std::runtime_error("cannot write the light map");
}

std::string bytesOf(std::uint32_t value) {
    std::string bytes;
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xff);
    return bytes;
}

void setBytes(const ExampleCopy& scene, const fs::path& file, std::size_t at, const std::string& bytes) {
    for (std::size_t i = 0; i < bytes.size(); ++i) formats::setByte(scene / file, at + i, bytes[i]);
}

/// Claims other extents in an EXR's header.
void claimExtent(const ExampleCopy& scene, const fs::path& file, std::uint32_t width, std::uint32_t height) {
    const std::string content = contentOf(scene / file);
    for (const std::string& name : {std::string("dataWindow\0box2i\0", 17), std::string("displayWindow\0box2i\0", 20)})
        setBytes(scene, file, content.find(name) + name.size() + 4, bytesOf(0) + bytesOf(0) + bytesOf(width - 1) + bytesOf(height - 1));
}

void emptyFolder(const ExampleCopy& scene) {
    fs::create_directory(scene / "out");
}

/// Writes a texture whose header claims 16384 x 16384 texels, in a file of a few bytes.
void writeBomb(const ExampleCopy& scene) {
    scene.run("lightcook encode cornell_probe0.exr big.ktx2 --format rgba16f --zstd");
    setBytes(scene, "big.ktx2", 20, bytesOf(16384) + bytesOf(16384));
    setBytes(scene, "big.ktx2", 96, bytesOf(0x80000000) + bytesOf(0));
}

constexpr int kPictureSide = 8;

/// Writes an EXR file of light of 1 everywhere.
void writeColours(const ExampleCopy& scene, const char* name) {
    const formats::Image<glm::vec4> texels(kPictureSide, kPictureSide, glm::vec4(1));
    if (const auto written = formats::writeExr(scene / name, texels.view(), 3); !written) throw std::runtime_error(written.error().line());
}

/// Writes a grey 8-bit picture.
/// channelCount  3 or 4: with alpha, which is 0 in texel (5, 2)
void writeGreyPng(const ExampleCopy& scene, const char* name, int channelCount) {
    formats::writePng(scene / name, kPictureSide, kPictureSide, channelCount,
                      [](int channel, int x, int y) { return channel == 3 && x == 5 && y == 2 ? 0 : 128; });
}

/// Writes level.gltf, with a light map of Unreal in each of its images.
/// change  of the document, before it is written
void writeUnrealGltf(const ExampleCopy& scene, int images, const std::function<void(nlohmann::json& gltf)>& change = nullptr) {
    nlohmann::json names = nlohmann::json::array(), maps = nlohmann::json::array();
    const formats::UnrealRectangle part = {1, 1, kPictureSide - 2, kPictureSide - 2};
    for (int i = 0; i < images; ++i) {
        formats::UnrealImage image(kPictureSide, kPictureSide);
        const formats::UnrealConstants constants = image.encode(part, formats::seededUnrealLight);
        const std::string name = fmt::format("HQ_Lightmap{}", i);
        image.writeTo(scene / (name + ".png"));
        names.push_back({{"name", name}, {"uri", name + ".png"}});
        maps.push_back(formats::unrealLightMap(image, part, constants, i));
    }
    nlohmann::json gltf = formats::unrealGltf(std::move(names), std::move(maps));
    if (change) change(gltf);
    writeContent(scene / "level.gltf", gltf.dump());
}

void nothing(const ExampleCopy&) {}

/// Leaves the cooked gradient, as the folder that the row's command then reads. It is cooked once for all rows; its manifest names the
/// sources by their places beside it.
void cookGradient(const ExampleCopy& scene) {
    static const ExampleCopy cooked = [] {
        ExampleCopy once;
        once.keepGradient();
        once.run("lightcook cook scene.toml -o out");
        return once;
    }();
    scene.keepGradient();
    fs::copy(cooked / "out", scene / "out", fs::copy_options::recursive);
}

/// Leaves the cooked gradient in two folders.
void cookTwice(const ExampleCopy& scene) {
    cookGradient(scene);
    fs::copy(scene / "out", scene / "copy", fs::copy_options::recursive);
}

/// Leaves the first rows of the light map covered: the others are not verified.
void keepFirstRows(const ExampleCopy& scene) {
    scene.editLightMap([](Channels& map) {
        for (int y = 24; y < map.height; ++y)
            for (int x = 0; x < map.width; ++x) map["coverage.Y"][map.index(x, y)] = 0;
    });
}

/// Cooks the gradient, and writes the budgets of one platform.
/// limits  lines of its table
void cookWithBudgets(const ExampleCopy& scene, const std::string& limits) {
    cookGradient(scene);
    writeContent(scene / "budgets.toml", "schema = 1\n\n[[platform]]\nname = \"handheld\"\n" + limits + "\n");
}

constexpr const char* kLint = "lightcook lint scene.toml --strict";

const std::vector<Mistake>& allMistakes() {
    static const std::vector<Mistake> mistakes = {
        // Command line
        {"the command is misspelt", "lightcook coock scene.toml", nothing},
        {"the scene file's name is misspelt", "lightcook cook scen.toml", nothing},
        {"a folder in place of a scene file", "lightcook cook .", nothing},
        {"a folder without a scene file", "lightcook cook out", emptyFolder},
        {"a bake in place of a scene file", "lightcook cook cornell_lightmap.exr", nothing},
        {"the output folder is a file", "lightcook cook scene.toml -o cornell.glb", nothing},
        {"an option is misspelt", "lightcook cook scene.toml --efort 3", nothing},
        {"an option without its value", "lightcook cook scene.toml --effort", nothing},
        {"an address of a remote cache without its scheme", "lightcook cook scene.toml --remote-cache cache.example.org", nothing},
        {"a password in the address of a remote cache", "lightcook cook scene.toml --remote-cache https://ci:secret@cache.example.org",
         nothing},
        {"an upload without a remote cache", "lightcook cook scene.toml --remote-upload", nothing},
        {"an empty file of credentials", "lightcook cook scene.toml --remote-cache http://localhost --remote-credentials secret",
         [](const ExampleCopy& scene) { writeContent(scene / "secret", ""); }},
        {"a script's variable that is not set, as a limit", "lightcook cook scene.toml --max-error ''", nothing},
        {"a value out of range", "lightcook cook scene.toml --effort 11", nothing},
        {"a limit that is no fraction", "lightcook cook scene.toml --max-error small", nothing},
        {"an option that the command has no use for", "lightcook rsrm clear_sky_256x1.exr out --layout raw", nothing},
        {"an option without effect beside another", "lightcook rsrm clear_sky_256x1.exr out --effort 3", nothing},
        {"an effort where nothing is encoded", "lightcook cook scene.toml --target float --effort 9", nothing},
        {"a metric for an encoder that has its own", "lightcook encode cornell_probe0.exr probe.ktx2 --format bc7 --metric log", nothing},
        {"weights for channels that are coded apart", "lightcook encode cornell_probe0.exr probe.ktx2 --format rgba16f --weights 1,2,1,1",
         nothing},
        {"a scale for a metric without one",
         "lightcook encode cornell_probe0.exr probe.ktx2 --format bc6h-uf16 --metric linear --metric-scale 0.1", nothing},
        {"a limit on packed charts where none are packed", "lightcook cook scene.toml --charts-max-visible 1", nothing},
        {"a size that is no decimal number", "lightcook cook scene.toml --budget 0x10000", nothing},
        {"a fraction of a byte", "lightcook cook scene.toml --budget 1.5", nothing},
        {"a pattern that matches no file", "lightcook info '*.ktx2'", nothing},
        {"a scene file that exists", "lightcook init .", nothing},
        {"a first scene of files that are not there", "lightcook init nowhere -o new.toml", nothing},
        {"a first scene of files that are no light", "lightcook init cornell_probes.json -o new.toml", nothing},
        {"a first scene of a file that is cut", "lightcook init cornell_lightmap.exr -o new.toml",
         [](const ExampleCopy& scene) { scene.truncate("cornell_lightmap.exr", 1e-4); }},
        {"a repacked bake in the folder of the bake", "lightcook repack cornell_lightmap.exr cornell.glb -o .", nothing},
        {"a repacked bake without its mesh", "lightcook repack cornell_lightmap.exr -o out", nothing},
        {"a repacked bake beyond visible limits", "lightcook repack cornell_lightmap.exr cornell.glb -o out --max-visible -1", nothing},
        {"a repacked bake of a mesh that is cut", "lightcook repack cornell_lightmap.exr cornell.glb -o out",
         [](const ExampleCopy& scene) { scene.truncate("cornell.glb", 0.5); }},
        {"a repacked bake of a mesh that is none", "lightcook repack cornell_lightmap.exr cornell_probes.json -o out", nothing},
        {"charts to pack without a mesh", "lightcook cook scene.toml --charts pack",
         [](const ExampleCopy& scene) { scene.replaceInScene("mesh = \"cornell.glb\"", ""); }},
        {"charts to split between maps", "lightcook cook scene.toml --charts split", nothing},
        {"charts with fewer texels beyond visible limits", "lightcook cook scene.toml --charts pack --charts-max-visible 101", nothing},
        {"charts to pack of light-map UVs outside the map", "lightcook cook scene.toml --charts pack", faults::uvsOutside},
        {"charts to pack of another mesh", "lightcook cook scene.toml --charts pack",
         [](const ExampleCopy& scene) { faults::editUvs(scene, [](glm::vec2& uv) { uv *= 0.5f; }); }},
        {"charts to pack that no light was baked for", "lightcook cook scene.toml --charts pack",
         [](const ExampleCopy& scene) {
             scene.editLightMap([](Channels& map) {
                 for (int y = 0; y < 128; ++y)
                     for (int x = 0; x < map.width; ++x) map["coverage.Y"][map.index(x, y)] = 0;
             });
         }},
        {"a light map beyond the largest page, before its bake", "lightcook estimate cornell.glb --texel-density 1000 -q", nothing},
        {"more memory than light maps may take, before their bake",
         "lightcook estimate cornell.glb --texel-density 20 --layout basis-4 --budget \"64 KiB\" -q", nothing},
        {"two documents on standard output", "lightcook lint scene.toml --json - --sarif -", nothing},
        {"decode to an 8-bit image", "lightcook decode probe.ktx2 probe.png",
         [](const ExampleCopy& scene) { scene.run("lightcook encode cornell_probe0.exr probe.ktx2 --format bc6h-uf16"); }},
        {"a format that there is not", "lightcook encode cornell_probe0.exr probe.ktx2 --format bc6", nothing},
        {"decode of something that is no texture", "lightcook decode cornell_probe0.exr probe.exr", nothing},
        {"a folder in place of an output file", "lightcook report out --json .", cookGradient},
        {"the name of a file for an output folder", "lightcook cubemap cornell_probe0.exr sh.json", nothing},
        {"a single DDS file for texels that need constants", "lightcook rsrm clear_sky_256x1.exr sky.dds", nothing},
        {"standard output is a full disk", "lightcook report out >/dev/full", cookGradient},
        {"verify of a folder that nothing was cooked to", "lightcook verify out", emptyFolder},
        {"verify of a preview", "lightcook verify out",
         [](const ExampleCopy& scene) {
             scene.keepGradient();
             scene.run("lightcook cook scene.toml -o out --preview -q");
         }},
        {"a scene file in place of the cooked folder", "lightcook view scene.toml", nothing},
        {"a file in place of the folder of a report", "lightcook report scene.toml", nothing},
        // Scene file
        {"a key is misspelt", "lightcook cook scene.toml", [](const ExampleCopy& scene) { scene.replaceInScene("target = ", "taget = "); }},
        {"a value that there is not", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("\"bc\"", "\"dxt\""); }},
        {"a target that there is not in a list of targets", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("target = \"bc\"", "targets = [\"bc\", \"atsc\"]"); }},
        {"one target twice", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("target = \"bc\"", "targets = [\"bc\", \"bc\"]"); }},
        {"a list of targets without any", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("target = \"bc\"", "targets = []"); }},
        {"a list of targets beside one target", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("target = \"bc\"", "target = \"bc\"\ntargets = [\"astc\"]"); }},
        {"settings of a target that is not cooked", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.keepGradient("targets = [\"bc\", \"astc\"]\n\n[target.float]\nbudget = \"1 MiB\""); }},
        {"a key of a target is misspelt", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.keepGradient("targets = [\"bc\", \"astc\"]\n\n[target.astc]\nbugdet = \"1 MiB\""); }},
        {"a target outside of its table", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("name = \"cornell\"", "name = \"cornell\"\ntarget = \"astc\""); }},
        {"several targets into the folder of one", "lightcook cook scene.toml -o out",
         [](const ExampleCopy& scene) { cookGradient(scene), scene.keepGradient("targets = [\"bc\", \"astc\"]"); }},
        {"the folder of several targets in place of one", "lightcook view out",
         [](const ExampleCopy& scene) {
             scene.keepGradient("targets = [\"bc\", \"astc\"]");
             scene.run("lightcook cook scene.toml -o out -q");
         }},
        {"a value of the wrong type", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("# effort = 5", "effort = \"high\""); }},
        {"an effort for texels that are not encoded", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) {
             scene.replaceInScene("\"bc\"", "\"float\"");
             scene.replaceInScene("# effort = 5", "effort = 9");
         }},
        {"a quotation mark is missing", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("\"cornell\"", "\"cornell"); }},
        {"a scene file of another version", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("schema = 1", "schema = 2"); }},
        {"a key that every asset needs is missing", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("name = \"probe0\"", ""); }},
        {"two assets with one name", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("\"probe0\"", "\"sky\""); }},
        {"a name of 300 letters", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("\"probe0\"", '"' + std::string(300, 'p') + '"'); }},
        {"a name that is a path", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("\"probe0\"", "\"rooms/probe0\""); }},
        {"a name that Windows reserves", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("\"probe0\"", "\"nul\""); }},
        {"a path that a 0 ends", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("clear_sky_256x1.exr", "clear_sky_256x1.exr\\u0000"); }},
        {"values nested 40,000 deep", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) {
             scene.append("scene.toml", fmt::format("\nx = {}{}\n", std::string(40000, '['), std::string(40000, ']')));
         }},
        {"a key of 40,000 parts", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) {
             std::string key = "x";
             while (key.size() < 80000) key += ".x";
             scene.append("scene.toml", "\n" + key + " = 1\n");
         }},
        {"a colour space that there is not", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("working = \"lin_rec709\"", "working = \"rec709\""); }},
        {"a lobe that there is not", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("schema = 1", "lobe = \"phong\"\nschema = 1"); }},
        {"a normal map without any tilt", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("normal_map = true", "normal_map = true\nnormal_map_tilt = 0"); }},
        {"a layout without the light that materials need", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) {
             scene.replaceInScene("# light_map_layout = \"auto\"", "light_map_layout = \"flat\"");
             scene.replaceInScene("\nspecular = true", "\nspecular = false");
         }},
        {"a layout that there is not in a list of layouts", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("# light_map_layout = \"auto\"", "layouts = [\"godod\"]"); }},
        {"a named layout that the list of layouts lacks", "lightcook cook scene.toml --layout ratio",
         [](const ExampleCopy& scene) { scene.replaceInScene("# light_map_layout = \"auto\"", "layouts = [\"godot\"]"); }},
        {"an image of a coefficient is missing from the list", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) {
             scene.replaceInScene("file = \"cornell_lightmap.exr\"", "files = { sh00 = \"a.exr\", sh01 = \"b.exr\", sh03 = \"c.exr\" }");
         }},
        {"images of coefficients beside one file", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) {
             scene.replaceInScene("file = \"cornell_lightmap.exr\"", "file = \"cornell_lightmap.exr\"\nfiles = { sh00 = \"a.exr\" }");
         }},
        {"Zstandard in a DDS file", "lightcook cook scene.toml --container dds --zstd", nothing},
        // Inputs
        {"the light map is missing", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { fs::remove(scene / "cornell_lightmap.exr"); }},
        {"the light map is truncated", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.truncate("cornell_lightmap.exr", 0.5); }},
        {"the light map is no EXR", "lightcook lightmap cornell_lightmap.exr out",
         [](const ExampleCopy& scene) {
             fs::copy_file(scene / "cornell.glb", scene / "cornell_lightmap.exr", fs::copy_options::overwrite_existing);
         }},
        {"a probe in place of the light map", "lightcook lightmap cornell_probe0.exr out", nothing},
        {"NaN in the light map", "lightcook lightmap cornell_lightmap.exr out",
         [](const ExampleCopy& scene) { writeLightMap(scene, std::numeric_limits<float>::quiet_NaN()); }},
        {"a negative mean of light", "lightcook lightmap cornell_lightmap.exr out",
         [](const ExampleCopy& scene) { writeLightMap(scene, -1); }},
        {"a firefly", "lightcook lightmap cornell_lightmap.exr out", [](const ExampleCopy& scene) { writeLightMap(scene, 1e6f); }},
        {"an infinite value in the probe", "lightcook cubemap cornell_probe0.exr out",
         [](const ExampleCopy& scene) { setProbeTexel(scene, std::numeric_limits<float>::infinity()); }},
        {"negative light in the probe", "lightcook cubemap cornell_probe0.exr out",
         [](const ExampleCopy& scene) { setProbeTexel(scene, -1); }},
        {"a probe of another shape", "lightcook cubemap clear_sky_256x1.exr out", nothing},
        {"an image in place of the gradient", "lightcook rsrm cornell_probe0.exr out", nothing},
        {"channels of integers", "lightcook rsrm clear_sky_256x1.exr out",
         [](const ExampleCopy& scene) { scene.replace("clear_sky_256x1.exr", std::string("R\0\2", 3), std::string("R\0\0", 3)); }},
        {"an EXR that claims 1,000,000 x 1", "lightcook rsrm clear_sky_256x1.exr out",
         [](const ExampleCopy& scene) { claimExtent(scene, "clear_sky_256x1.exr", 1000000, 1); }},
        {"an EXR that claims 65,536 x 65,536", "lightcook cubemap cornell_probe0.exr out",
         [](const ExampleCopy& scene) { claimExtent(scene, "cornell_probe0.exr", 65536, 65536); }},
        {"a texture that claims 16,384 x 16,384", "lightcook decode big.ktx2 big.exr", writeBomb},
        {"the list of probes lacks the probe", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replace("cornell_probes.json", "cornell_probe0.exr", "cornell_probe1.exr"); }},
        {"a list of probes nested 100,000 deep", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { writeContent(scene / "cornell_probes.json", std::string(100000, '[')); }},
        {"a mesh that is its own child", "lightcook cook scene.toml", faults::meshBelowItself},
        {"a mesh that no node draws", "lightcook cook scene.toml", faults::noNodes},
        {"a roughness of 5 in the glTF", "lightcook cook scene.toml", faults::roughnessOfFive},
        {"the mesh is truncated", "lightcook info cornell.glb", [](const ExampleCopy& scene) { scene.truncate("cornell.glb", 0.5); }},
        {"a glTF nested 100,000 deep", "lightcook info deep.gltf",
         [](const ExampleCopy& scene) {
             std::string text = R"({"asset":{"version":"2.0"},"nodes":[)";
             for (int i = 0; i < 100000; ++i) text += R"({"children":[)";
             writeContent(scene / "deep.gltf", text);
         }},
        {"a chain of 100,000 glTF nodes", "lightcook info chain.gltf",
         [](const ExampleCopy& scene) {
             std::string text = R"({"asset":{"version":"2.0"},"nodes":[)";
             for (int i = 1; i < 100000; ++i) text += fmt::format(R"({{"children":[{}]}},)", i);
             writeContent(scene / "chain.gltf", text + "{}]}");
         }},
        {"a FIFO in place of an input", "lightcook lightmap cornell_lightmap.exr out",
         [](const ExampleCopy& scene) {
             fs::remove(scene / "cornell_lightmap.exr");
             if (::mkfifo((scene / "cornell_lightmap.exr").c_str(), 0600) != 0) throw std::runtime_error("mkfifo");
         }},
        // Results
        {"a texture was changed after the cook", "lightcook verify out",
         [](const ExampleCopy& scene) { cookGradient(scene), scene.append("out/sky.ktx2", "x"); }},
        {"an input was changed after the cook", "lightcook verify out",
         [](const ExampleCopy& scene) { cookGradient(scene), scene.append("clear_sky_256x1.exr", "x"); }},
        {"an error above its limit", "lightcook cook scene.toml -o out",
         [](const ExampleCopy& scene) { scene.keepGradient("max_error = 1e-5\nmax_converter_error = 1e-5"); }},
        {"more bytes than the budget", "lightcook cook scene.toml -o out",
         [](const ExampleCopy& scene) { scene.keepGradient("budget = \"100\""); }},
        {"more bytes than the budget of one of two targets", "lightcook cook scene.toml -o out",
         [](const ExampleCopy& scene) { scene.keepGradient("targets = [\"bc\", \"astc\"]\n\n[target.bc]\nbudget = \"100\""); }},
        {"a visible error above its limit", "lightcook lightmap cornell_lightmap.exr out --layout basis-3 --max-visible 0.1",
         keepFirstRows},
        {"a proven bound of visible errors above its limit",
         "lightcook lightmap cornell_lightmap.exr out --layout basis-3 --max-visible-bound 1", keepFirstRows},
        {"an objective that does not exist", "lightcook cook scene.toml --objective seen", nothing},
        {"a limit on visible errors that is no number", "lightcook cook scene.toml --max-visible 0", nothing},
        {"the same limit for other assets that is no number", "lightcook cook scene.toml --max-converter-visible 0", nothing},
        {"candidates of a layout that is named", "lightcook cook scene.toml --layout ratio --keep-candidates", nothing},
        {"candidates of one asset", "lightcook cook scene.toml --keep-candidates --only probe0", nothing},
        {"a limit on seams that is no number", "lightcook cook scene.toml --max-seam 0", nothing},
        {"a limit on seams where no light map has a mesh", "lightcook cook scene.toml --max-seam 2",
         [](const ExampleCopy& scene) { scene.replaceInScene("mesh = \"cornell.glb\"", ""); }},
        {"a limit that no texture can keep", "lightcook cubemap cornell_probe0.exr out --max-error 0.001%", nothing},
        {"a report on a folder that failed", "lightcook report out",
         [](const ExampleCopy& scene) {
             scene.keepGradient("max_converter_error = 1e-5");
             if (scene.shell("lightcook cook scene.toml -o out") != 4) throw std::runtime_error("the cook passed");
         }},
        {"more bytes than the baseline allows", "lightcook report out --baseline old --fail-over 2%",
         [](const ExampleCopy& scene) {
             cookGradient(scene);
             fs::rename(scene / "out", scene / "old");
             scene.replaceInScene("[1, 16]", "[1, 4, 16]");
             scene.run("lightcook cook scene.toml -o out");
         }},
        // Reports
        {"a report on a folder that is missing", "lightcook report out other", cookGradient},
        {"a report on a folder that is no cooked one", "lightcook report out .", cookGradient},
        {"one scene twice in a report", "lightcook report out copy", cookTwice},
        {"a page and JSON on standard output", "lightcook report out --json - --html -", cookGradient},
        {"a key of a budgets file is misspelt", "lightcook report out --budgets budgets.toml",
         [](const ExampleCopy& scene) { cookWithBudgets(scene, "totl = \"1 MiB\""); }},
        {"an asset kind that there is not in a budgets file", "lightcook report out --budgets budgets.toml",
         [](const ExampleCopy& scene) { cookWithBudgets(scene, "kinds = { lightmap = \"1 MiB\" }"); }},
        {"a platform without a limit", "lightcook report out --budgets budgets.toml",
         [](const ExampleCopy& scene) { cookWithBudgets(scene, ""); }},
        {"a budgets file that is missing", "lightcook report out --budgets budgets.toml", cookGradient},
        {"a folder in place of a budgets file", "lightcook report out --budgets out", cookGradient},
        {"more bytes than a platform allows", "lightcook report out --budgets budgets.toml",
         [](const ExampleCopy& scene) { cookWithBudgets(scene, "scene = \"1 KiB\""); }},
        {"more bytes in all scenes than a platform allows", "lightcook report out copy --budgets budgets.toml",
         [](const ExampleCopy& scene) {
             cookWithBudgets(scene, "total = \"3 KiB\"");
             scene.replaceInScene("\"cornell\"", "\"second\"");
             scene.run("lightcook cook scene.toml -o copy");
         }},
        {"a history that is another file", "lightcook report out --history scene.toml", cookGradient},
        {"a cook with a history that is another file", "lightcook cook scene.toml -o out --history scene.toml",
         [](const ExampleCopy& scene) { scene.keepGradient(); }},
        {"a baseline that is no report", "lightcook report out --baseline scene.toml", cookGradient},
        {"a baseline of another scene", "lightcook report out --baseline other --fail-over 2%",
         [](const ExampleCopy& scene) {
             cookGradient(scene);
             scene.replaceInScene("\"cornell\"", "\"yard\"");
             scene.run("lightcook cook scene.toml -o other");
         }},
        {"verify of a folder that was moved away from its scene", "lightcook verify moved/out",
         [](const ExampleCopy& scene) {
             cookGradient(scene);
             fs::create_directory(scene / "moved");
             fs::rename(scene / "out", scene / "moved/out");
         }},
        // Bakes of several files, and of 8 bits
        {"an 8-bit light map without an encoding", "lightcook lightmap room.png out",
         [](const ExampleCopy& scene) { writeGreyPng(scene, "room.png", 4); }},
        {"an encoding of HDR values", "lightcook lightmap cornell_lightmap.exr out --encoding rgbm", nothing},
        {"RGBM without alpha", "lightcook lightmap room.png out --encoding rgbm",
         [](const ExampleCopy& scene) { writeGreyPng(scene, "room.png", 3); }},
        {"an encoding for a bake format without colours", "lightcook lightmap room.png out --bake godot --encoding dldr",
         [](const ExampleCopy& scene) { writeGreyPng(scene, "room.png", 3); }},
        {"a direction map of Unity that lost its alpha", "lightcook lightmap room_light.exr out",
         [](const ExampleCopy& scene) { writeColours(scene, "room_light.exr"), writeGreyPng(scene, "room_dir.png", 3); }},
        {"light without a direction in a bake of Unity", "lightcook lightmap room_light.exr out",
         [](const ExampleCopy& scene) { writeColours(scene, "room_light.exr"), writeGreyPng(scene, "room_dir.png", 4); }},
        {"files of two formats of Bakery", "lightcook lightmap room_L0.exr out",
         [](const ExampleCopy& scene) {
             writeColours(scene, "room_L0.exr");
             for (const char* name : {"room_L1.png", "room_L1x.png", "room_L1y.png", "room_L1z.png"}) writeGreyPng(scene, name, 3);
         }},
        {"a bake in tangent space without its mesh", "lightcook lightmap room_RNM0.exr out",
         [](const ExampleCopy& scene) {
             for (const char* name : {"room_RNM0.exr", "room_RNM1.exr", "room_RNM2.exr"}) writeColours(scene, name);
         }},
        {"two of the three maps of RNM", "lightcook lightmap room_RNM0.exr out --mesh cornell.glb",
         [](const ExampleCopy& scene) { writeColours(scene, "room_RNM0.exr"), writeColours(scene, "room_RNM1.exr"); }},
        {"a light map of Quake without its directions", "lightcook lightmap room.exr out --bake deluxe --mesh cornell.glb",
         [](const ExampleCopy& scene) { writeColours(scene, "room.exr"); }},
        {"a glTF without light maps", "lightcook lightmap cornell.glb out", nothing},
        {"one of several light maps of Unreal is not chosen", "lightcook lightmap level.gltf out",
         [](const ExampleCopy& scene) { writeUnrealGltf(scene, 2); }},
        {"a light map of Unreal that there is not", "lightcook lightmap level.gltf out --image HQ_Lightmap2",
         [](const ExampleCopy& scene) { writeUnrealGltf(scene, 2); }},
        {"an image of a glTF for an EXR file", "lightcook lightmap cornell_lightmap.exr out --image HQ_Lightmap0", nothing},
        {"an image of Unreal that the export left out", "lightcook lightmap level.gltf out",
         [](const ExampleCopy& scene) {
             writeUnrealGltf(scene, 1);
             fs::remove(scene / "HQ_Lightmap0.png");
         }},
        {"constants of Unreal that are missing", "lightcook lightmap level.gltf out",
         [](const ExampleCopy& scene) {
             writeUnrealGltf(
                 scene, 1, [](nlohmann::json& gltf) { gltf["extensions"]["EPIC_lightmap_textures"]["lightmaps"][0].erase("lightmapAdd"); });
         }},
        {"a mesh of Unreal with a rectangle of the light map", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) {
             writeUnrealGltf(scene, 1, [](nlohmann::json& gltf) {
                 gltf["nodes"][0]["mesh"] = 0;
                 gltf["meshes"] = {{{"primitives", nlohmann::json::array()}}};
             });
             writeContent(scene / "scene.toml",
                          "schema = 1\nname = \"level\"\n\n[output]\n\n[[light_map]]\nname = \"level\"\nfile = \"level.gltf\"\n"
                          "mesh = \"level.gltf\"\n");
         }},
        {"an lmbake of Godot beside another baker's light map",
         "lightcook lightmap cornell_lightmap.exr out --mesh cornell.glb --lmbake room.lmbake",
         [](const ExampleCopy& scene) { writeContent(scene / "room.lmbake", "RSRC"); }},
        {"axes that are no turn", "lightcook lightmap cornell_lightmap.exr out --axes x,y,y", nothing},
        {"output axes of a layout that is decoded in those of the mesh",
         "lightcook lightmap cornell_lightmap.exr out --layout ratio --output-axes=-x,y,z", nothing},
        // Bakes that look plausible: lint
        {"the light map has the other sign convention", kLint, faults::otherPhase},
        {"the light map has Y and Z swapped", kLint, faults::swappedAxes},
        {"the light map is in the other frame", kLint, faults::otherFrame},
        {"some normals point backwards", kLint, faults::someNormalsTurned},
        {"the light map holds irradiance", kLint, faults::irradiance},
        {"the scene file says irradiance, the light map holds radiance", kLint, faults::statedIrradiance},
        {"the light map is under a gamma curve", kLint, faults::gammaCurve},
        {"the light map states other primaries", kLint, faults::otherPrimaries},
        {"the probe is under a gamma curve", kLint, faults::gammaCurveOnProbe},
        {"coverage is nowhere above 0.5", "lightcook cook scene.toml", faults::coverageOfOneHalf},
        {"coverage is NaN", "lightcook cook scene.toml", faults::coverageOfNan},
        {"coverage from 0 to 255", "lightcook cook scene.toml", faults::coverageOf255},
        {"a chart without a whole number", "lightcook cook scene.toml", faults::chartOfOneHalf},
        {"all normals are zero", "lightcook cook scene.toml", faults::zeroNormals},
        {"normals as colours", "lightcook cook scene.toml", faults::encodedNormals},
        {"some normals are zero", kLint, faults::someZeroNormals},
        {"the mesh of another scene", kLint, faults::turnedUvs},
        {"V of the mesh is flipped", kLint, faults::flippedV},
        {"UVs outside the light map", kLint, faults::uvsOutside},
        {"UVs that overlap", kLint, faults::overlappingUvs},
        {"a mesh that two nodes draw", kLint, faults::drawnTwice},
        {"a mesh with a scale of 0", "lightcook cook scene.toml", faults::flatTriangles},
        {"a mesh with a scale of a million million", "lightcook cook scene.toml", faults::farTriangles},
        {"a material that no mesh has", kLint, faults::unknownMaterial},
        {"a limit above 1", kLint, faults::limitAboveOne},
        {"a number of mip levels", "lightcook cook scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("max_error = 0.02 ", "mips = 3\nmax_error = 0.02 "); }},
        {"a finding is allowed whose code is misspelt", "lightcook lint scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("schema = 1", "allow = [\"fliped-v\"]\nschema = 1"); }},
        {"an error is allowed", "lightcook lint scene.toml",
         [](const ExampleCopy& scene) { scene.replaceInScene("schema = 1", "allow = [\"no-coverage\"]\nschema = 1"); }},
    };
    return mistakes;
}

class Mistakes : public testing::TestWithParam<Mistake> {};

TEST_P(Mistakes, EndAsTheTableSays) {
    const Mistake& mistake = GetParam();
    SCOPED_TRACE(mistake.what);
    const ExampleCopy scene;
    mistake.make(scene);
    const int code = scene.shell(mistake.command);
    const std::string errors = withoutDone(contentOf(scene / "stderr")), printed = errors.substr(0, errors.find('\n'));
    const Cells found = {mistake.what, mistake.command, printed, std::to_string(code)}, row = kTable.rowFor(found);
    ASSERT_EQ(row.size(), found.size()) << "tests/end_to_end/mistakes.md has no row for it; what is printed: " << errors;
    EXPECT_EQ(row[1], found[1]);
    EXPECT_TRUE(matches(printed, row[2])) << "found:    " << printed << "\nexpected: " << row[2];
    EXPECT_EQ(row[3], found[3]) << errors;
    EXPECT_NE(code, 0);
    // Several figures may be over their limits.
    if (code != 4) {
        EXPECT_EQ(errors, printed + "\n") << "one line for one mistake";
    }
    for (const auto& entry : fs::directory_iterator(scene.path()))
        EXPECT_FALSE(entry.path().filename().string().starts_with(".lightcook-")) << entry.path();
}

std::string nameOf(const testing::TestParamInfo<Mistake>& info) {
    std::string name;
    bool isWordStart = true;
    for (const char c : std::string(info.param.what)) {
        if (std::isalnum(static_cast<unsigned char>(c)) != 0)
            name += isWordStart ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
        isWordStart = std::isalnum(static_cast<unsigned char>(c)) == 0;
    }
    return name;
}

/// Every sixth finding of lint, whose faults tests/pipeline/lint plants too, and all other rows; or the rest, for the soak.
std::vector<Mistake> rowsOf(bool isSoak) {
    std::vector<Mistake> rows;
    int findings = 0;
    for (const Mistake& mistake : allMistakes())
        if ((mistake.command == std::string_view(kLint) && findings++ % 6 != 0) == isSoak) rows.push_back(mistake);
    return rows;
}
INSTANTIATE_TEST_SUITE_P(Table, Mistakes, testing::ValuesIn(rowsOf(false)), nameOf);
INSTANTIATE_TEST_SUITE_P(Soak, Mistakes, testing::ValuesIn(rowsOf(true)), nameOf);

TEST(MistakesTable, HasARowForEachTestAndNoOther) {
    std::vector<std::string> tested, written;
    for (const Mistake& mistake : allMistakes()) tested.emplace_back(mistake.what);
    for (const auto& [what, row] : kTable.rows()) written.push_back(what);
    EXPECT_THAT(written, testing::UnorderedElementsAreArray(tested));
    EXPECT_GE(written.size(), 40u);
}

}  // namespace
}  // namespace lightcook::pipeline
