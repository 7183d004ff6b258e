// Mutation tests of `verify`: each deliberate fault is put into a copy of a cooked scene and must be refused with the right exit code and
// word. A fault with stale digests is that of a bad disk. For a fault with rewritten digests, CookedCopy::rewriteDigests() writes every
// digest, size and constant as a cook with that fault would have, so that only the light or the shader's conventions can reveal it.
#include <gmock/gmock.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>
#include <span>

#include "formats/gltf_scene.h"
#include "formats/light_map.h"
#include "pipeline/report/exit_codes.h"
#include "tests/end_to_end/cooked_copy.h"
#include "tests/pipeline/small_scene.h"
#include "tests/soak/soak.h"

namespace lightcook::pipeline {
namespace {

using glm::vec3;
using glm::vec4;
using Images = std::vector<TexelImage>;

/// A scene, cooked once for all faults of a test.
class Cooked {
public:
    Cooked(const std::filesystem::path& scene, const std::string& layout, std::optional<std::string> onlyKind = {}) : scene_(scene) {
        CookOptions options;
        options.scene = scene;
        options.output = folder_ / "out";
        options.cache = LIGHTCOOK_TEST_CACHE;
        options.given.set("output.light_map_layout", layout);
        options.onlyKind = std::move(onlyKind);
        options.given.set("output.effort", 3);
        options.given.set("output.max_error", 0.02);
        const RunState state;
        const Outcome outcome = cookScene(options, state);
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    }
    CookedCopy copyOf(const std::string& asset) const { return {folder_ / "out", scene_.parent_path(), asset}; }

private:
    std::filesystem::path scene_;
    formats::TemporaryFolder folder_;
};

/// Digests of a copy with a fault: those of the cook (a bad disk), or those of the faulty files (a faulty cook).
enum class Digests { Stale, Rewritten };
struct Fault {
    const char* name;
    const char* asset;
    Digests digests;
    int code;          ///< exit code of `verify`
    const char* word;  ///< word that one of the errors must contain
    std::function<void(CookedCopy&)> apply;
};

/// time  of a soak, after which no further fault is tried
void expectCaught(const Cooked& cooked, const std::vector<Fault>& faults, const test::SoakTime* time = nullptr) {
    std::set<std::string> assets;
    for (const Fault& fault : faults) assets.insert(fault.asset);
    for (const std::string& asset : assets)
        for (const formats::Error& error : cooked.copyOf(asset).verify().errors) ADD_FAILURE() << "without any fault: " << error.line();
    int tried = 0;
    for (const Fault& fault : faults) {
        if (time != nullptr && tried > 0 && time->isOver()) break;
        ++tried;
        SCOPED_TRACE(fault.name);
        CookedCopy copy = cooked.copyOf(fault.asset);
        fault.apply(copy);
        if (fault.digests == Digests::Rewritten) copy.rewriteDigests();
        const Outcome outcome = copy.verify();
        if (outcome.errors.empty()) {
            ADD_FAILURE() << "not caught; "
                          << (outcome.report.is_object() ? outcome.report.at("assets")[0].at("stages").back().dump() : "");
            continue;
        }
        EXPECT_EQ(exitCode(outcome.errors.front().code), fault.code) << outcome.errors.front().line();
        std::string lines;
        for (const formats::Error& error : outcome.errors) lines += error.line() + "\n";
        EXPECT_THAT(lines, testing::HasSubstr(fault.word));
    }
    test::countInSoak(tried, "faults of cooked files");
}

// ---- ways to be wrong ----

using Texels = std::function<vec4(const vec4& texel)>;
/// Every texel of every image by itself.
void changeTexels(CookedCopy& copy, const std::string& role, const Texels& change) {
    copy.edit(role, [&](Images& images) {
        for (TexelImage& image : images)
            for (vec4& texel : image.texels()) texel = change(texel);
    });
}
/// Texel (x, y) of every image comes from where `from` says.
void moveTexels(CookedCopy& copy, const std::string& role, const std::function<glm::ivec2(int x, int y, int width, int height)>& from) {
    copy.edit(role, [&](Images& images) {
        for (TexelImage& image : images) {
            const TexelImage before = image.copy();
            for (int y = 0; y < image.height(); ++y)
                for (int x = 0; x < image.width(); ++x) {
                    const glm::ivec2 place = from(x, y, image.width(), image.height());
                    image.at(x, y) = before.at(place.x, place.y);
                }
        }
    });
}
void swapFiles(CookedCopy& copy, const char* a, const char* b) {
    std::swap(copy.texture(a)["file"], copy.texture(b)["file"]);
}
void swapImages(Images& images, std::size_t a, std::size_t b) {
    std::swap(images.at(a), images.at(b));
}
void multiply(Json& number, double factor) {
    if (number.is_array())
        for (Json& each : number) multiply(each, factor);
    else
        number = number.get<double>() * factor;
}
/// Changes one bit in the middle of a file.
void flipBit(const std::filesystem::path& file) {
    std::string content = formats::contentOf(file);
    content[content.size() / 2] = static_cast<char>(content[content.size() / 2] ^ 1);
    formats::writeContent(file, content);
}
void truncate(const std::filesystem::path& file) {
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
}

/// SH coefficients of a "ratio" map, changed and stored again, with the constants that the changed map asks for.
void changeSh(CookedCopy& copy, const std::function<lighting::ShRgb(const lighting::ShRgb& sh)>& change) {
    Images l0 = copy.texels("l0"), ratio = copy.texels("ratio");
    const auto range = copy.constants().at("range")[0].get<float>();
    const auto scale = copy.constants().at("scale").get<std::vector<float>>(), bias = copy.constants().at("bias").get<std::vector<float>>();
    for (std::size_t t = 0; t < l0[0].texels().size(); ++t) {
        lighting::ShRgb sh;
        sh[0] = range * vec3(l0[0].texels()[t]);
        for (std::size_t i = 0; i < 8; ++i) sh[i + 1] = sh[0] * (scale[i] * vec3(ratio[i].texels()[t]) + bias[i]);
        sh = change(sh);
        l0[0].texels()[t] = vec4(sh[0] / range, 1);
        for (std::size_t i = 0; i < 8; ++i) ratio[i].texels()[t] = vec4(sh[i + 1] / sh[0], 1);
    }
    for (std::size_t i = 0; i < 8; ++i) {
        float low = 0, high = 1e-3f;
        for (const vec4& t : ratio[i].texels()) low = std::min({low, t.x, t.y, t.z}), high = std::max({high, t.x, t.y, t.z});
        for (vec4& t : ratio[i].texels()) t = vec4((vec3(t) - low) / (high - low), 1);
        copy.constants()["scale"][i] = high - low;
        copy.constants()["bias"][i] = low;
    }
    copy.setTexels("l0", l0);
    copy.setTexels("ratio", ratio);
}

/// A block in the middle of a chart that is about as bright as the map is in the mean.
glm::ivec2 averageBlock(CookedCopy& copy) {
    const auto bake = valueOf(formats::LightMapReader::open(copy.sources() / "cornell_lightmap.exr", {}));
    const auto band = valueOf(bake.read(0, bake.height()));
    double squares = 0, count = 0;
    std::vector<std::pair<double, glm::ivec2>> blocks;
    for (int y = 0; y + 4 <= bake.height(); y += 4)
        for (int x = 0; x + 4 <= bake.width(); x += 4) {
            double sum = 0;
            int covered = 0;
            for (int i = 0; i < 16; ++i) {
                const vec3 dc = band.sh.at(x + i % 4, y + i / 4)[0];
                if (band.covered.at(x + i % 4, y + i / 4) == 0) continue;
                sum += static_cast<double>(glm::dot(dc, dc));
                ++covered;
            }
            squares += sum;
            count += covered;
            if (covered == 16) blocks.push_back({sum / 16, {x, y}});
        }
    return std::ranges::min_element(blocks, {}, [&](const auto& block) { return std::abs(block.first - squares / count); })->second;
}

constexpr double kPi = std::numbers::pi;

// ---- light maps: faults of SH conventions, layers and blocks ----

const std::vector<Fault>& ratioFaults() {
    static const std::vector<Fault> kFaults = {
        {"one bit of a texture", "map", Digests::Stale, 4, "map_l0.ktx2", [](CookedCopy& c) { flipBit(c.file("l0")); }},
        {"a truncated texture", "map", Digests::Stale, 4, "map_ratio.ktx2", [](CookedCopy& c) { truncate(c.file("ratio")); }},
        {"a texture gone", "map", Digests::Stale, 4, "map_l0.ktx2", [](CookedCopy& c) { std::filesystem::remove(c.file("l0")); }},
        {"one bit of the shader", "map", Digests::Stale, 4, kShaderName, [](CookedCopy& c) { flipBit(c.folder() / kShaderName); }},
        {"a manifest cut short", "map", Digests::Stale, 3, kManifestName, [](CookedCopy& c) { truncate(c.folder() / kManifestName); }},
        {"a truncated texture, digests rewritten", "map", Digests::Rewritten, 3, "map_ratio.ktx2",
         [](CookedCopy& c) { truncate(c.file("ratio")); }},
        {"red and blue swapped", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { changeTexels(c, "l0", [](const vec4& t) { return vec4(t.z, t.y, t.x, t.w); }); }},
        {"phase: coefficients 1, 3, 5, 7 negated", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             changeSh(c, [](lighting::ShRgb sh) {
                 for (const std::size_t i : {1u, 3u, 5u, 7u}) sh[i] = -sh[i];
                 return sh;
             });
         }},
        {"x and y of band 1 swapped", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             changeSh(c, [](lighting::ShRgb sh) {
                 std::swap(sh[1], sh[3]);
                 return sh;
             });
         }},
        {"m of band 2 reversed", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             changeSh(c, [](lighting::ShRgb sh) {
                 std::reverse(sh.begin() + 4, sh.end());
                 return sh;
             });
         }},
        {"light turned by 90 degrees about z", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             changeSh(c, [](const lighting::ShRgb& sh) {  // x to y, y to -x
                 return lighting::ShRgb{sh[0], sh[3], sh[2], -sh[1], -sh[4], sh[7], sh[6], -sh[5], -sh[8]};
             });
         }},
        {"band 2 lost", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             changeSh(c, [](lighting::ShRgb sh) {
                 std::fill(sh.begin() + 4, sh.end(), vec3(0));
                 return sh;
             });
         }},
        {"the division by pi twice", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { multiply(c.constants()["range"], 1 / kPi); }},
        {"convolved with the cosine already", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             changeSh(c, [](lighting::ShRgb sh) {
                 for (std::size_t i = 1; i < 9; ++i) sh[i] *= i < 4 ? 2.0f / 3 : 0.25f;
                 return sh;
             });
         }},
        {"the range of another map", "map", Digests::Rewritten, 4, "rel_rms", [](CookedCopy& c) { multiply(c.constants()["range"], 2); }},
        {"one scale of eight wrong", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { multiply(c.constants()["scale"][1], 1.25); }},
        {"a bias that is not finite", "map", Digests::Rewritten, 3, "number",
         [](CookedCopy& c) { c.constants()["bias"][3] = std::numeric_limits<float>::infinity(); }},
        {"a scale missing", "map", Digests::Rewritten, 3, "scale", [](CookedCopy& c) { c.constants()["scale"].erase(7); }},
        {"upside down", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { moveTexels(c, "l0", [](int x, int y, int, int h) { return glm::ivec2(x, h - 1 - y); }); }},
        {"the sRGB curve on linear data", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { changeTexels(c, "ratio", [](const vec4& t) { return vec4(glm::pow(vec3(t), vec3(1 / 2.2f)), t.w); }); }},
        {"called by another layout's name", "map", Digests::Rewritten, 3, "hdr-2", [](CookedCopy& c) { c.asset()["layout"] = "hdr-2"; }},
        {"called by no layout's name", "map", Digests::Rewritten, 3, "ratios", [](CookedCopy& c) { c.asset()["layout"] = "ratios"; }},
        {"another size in the manifest", "map", Digests::Rewritten, 4, "44", [](CookedCopy& c) { c.asset()["width"] = 44; }},
        {"no source to hold it against", "map", Digests::Rewritten, 3, "source",
         [](CookedCopy& c) { c.asset()["source"]["files"].erase("source"); }},
    };
    return kFaults;
}

TEST(Mutation, OfALightMapIsCaught) {
    const SmallScene scene(SmallScene::Parts::LightMap, sunAndSky, 24);
    expectCaught(Cooked(scene.sceneFile(), "ratio", "light-map"), ratioFaults());
}

/// Faults of a light map whose texels are decoded before they are filtered.
const std::vector<Fault>& litFaults() {
    static const std::vector<Fault> kFaults = {
        {"a texel less is covered", "map", Digests::Rewritten, 4, "coverage",
         [](CookedCopy& c) {
             Images coverage = c.texels("coverage");
             coverage[0].at(0, 0).x = 127.0f / 255;
             c.setTexels("coverage", coverage);
         }},
        {"no texel is covered", "map", Digests::Rewritten, 4, "coverage",
         [](CookedCopy& c) { changeTexels(c, "coverage", [](const vec4&) { return vec4(0); }); }},
        {"the light comes from the other side", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { changeTexels(c, "direction", [](const vec4& t) { return vec4(1 - t.x, 1 - t.y, t.z, t.w); }); }},
        {"half of the light", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { changeTexels(c, "light", [](const vec4& t) { return 0.5f * t; }); }},
        {"the rest with the other sign", "map", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { changeTexels(c, "rest", [](const vec4& t) { return vec4(1.0f - vec3(t), t.w); }); }},
        {"the hardware's filter in the manifest", "map", Digests::Rewritten, 4, "filter",
         [](CookedCopy& c) { c.asset()["filter"] = "hardware"; }},
        {"no filter in the manifest", "map", Digests::Rewritten, 4, "filter", [](CookedCopy& c) { c.asset().erase("filter"); }},
        {"another side in the manifest", "map", Digests::Rewritten, 4, "width of its asset",
         [](CookedCopy& c) { c.texture("rest")["side"] = 4; }},
        {"a side of nothing in the manifest", "map", Digests::Rewritten, 3, "side", [](CookedCopy& c) { c.texture("rest")["side"] = 0; }},
    };
    return kFaults;
}

TEST(Mutation, OfALightMapThatIsDecodedBeforeTheFilterIsCaught) {
    const SmallScene scene(SmallScene::Parts::LightMap, sunAndSky, 24);
    expectCaught(Cooked(scene.sceneFile(), "lit-half", "light-map"), litFaults());
}

/// Changes the second layer of texture "coverage", which says where detail lies: change(texels, indices of those with detail).
void changePlaces(CookedCopy& copy, const std::function<void(std::span<vec4> tiles, const std::vector<std::size_t>& detailed)>& change) {
    copy.edit("coverage", [&](Images& images) {
        std::vector<vec4>& tiles = images.at(1).texels();
        std::vector<std::size_t> detailed;
        for (std::size_t i = 0; i < tiles.size(); ++i)
            if (tiles[i].w > 0.5f) detailed.push_back(i);
        change(tiles, detailed);
    });
}
/// Faults of a map some of whose tiles have detail.
const std::vector<Fault>& detailFaults() {
    static const std::vector<Fault> kFaults = {
        {"no tile takes its detail", "map", Digests::Rewritten, 4, "visible",
         [](CookedCopy& c) {
             changePlaces(c, [](auto tiles, const auto& detailed) {
                 for (const std::size_t tile : detailed) tiles[tile] = vec4(0);
             });
         }},
        {"two tiles take the detail of each other", "map", Digests::Rewritten, 4, "visible",
         [](CookedCopy& c) {
             changePlaces(c, [](auto tiles, const auto& detailed) { std::swap(tiles[detailed.front()], tiles[detailed.back()]); });
         }},
        {"detail beyond its textures", "map", Digests::Rewritten, 4, "found detail of tile",
         [](CookedCopy& c) { changePlaces(c, [](auto tiles, const auto& detailed) { tiles[detailed.front()].x = 200.0f / 255; }); }},
        {"the range of other detail", "map", Digests::Rewritten, 4, "visible",
         [](CookedCopy& c) { multiply(c.asset()["detail"]["constants"]["range"], 2); }},
        {"detail in another layout", "map", Digests::Rewritten, 4, "expected lit",
         [](CookedCopy& c) { c.asset()["detail"]["layout"] = "ratio"; }},
        {"more tiles in the manifest", "map", Digests::Rewritten, 4, "width of its asset",
         [](CookedCopy& c) { c.asset()["detail"]["tiles"] = 100; }},
        {"no detail in the manifest", "map", Digests::Rewritten, 4, "detail_hdr", [](CookedCopy& c) { c.asset().erase("detail"); }},
    };
    return kFaults;
}

TEST(Mutation, OfALightMapWithDetailIsCaught) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    scene.writeSceneFile("light_map_layout = \"lit-half\"\ndetail = true\nmax_visible = 1.7");
    expectCaught(Cooked(scene.sceneFile(), "lit-half", "light-map"), detailFaults());
}

/// Rewrites the metadata of a texture of a copy.
void changeMetadata(CookedCopy& copy, const std::string& role, const std::function<void(std::map<std::string, std::string>&)>& change) {
    const std::filesystem::path file = copy.file(role);
    auto reader = valueOf(formats::TextureReader::open(file));
    formats::TextureFileOptions options;
    for (const auto& [key, value] : reader.metadata())
        if (!key.starts_with("KTX")) options.metadata[key] = value;
    change(options.metadata);
    const formats::TextureShape shape = reader.shape();
    std::vector<std::vector<std::byte>> blocks;
    for (int layer = 0; layer < shape.layerCount; ++layer) blocks.push_back(valueOf(reader.readImage({0, layer, 0})));
    auto writer = valueOf(formats::TextureWriter::create(file, shape, options));
    for (int layer = 0; layer < shape.layerCount; ++layer)
        ASSERT_TRUE(writer.writeBlockRows({0, layer, 0}, 0, blocks[static_cast<std::size_t>(layer)]));
    ASSERT_TRUE(writer.commit());
}
void changeFacts(CookedCopy& copy, const std::function<void(Json&)>& change) {
    changeMetadata(copy, "ratio", [&](auto& metadata) {
        Json facts = parseJson(metadata.at(kMetadataKey));
        change(facts);
        metadata[kMetadataKey] = facts.dump();
    });
}

TEST(Mutation, OfWhatALoaderReadsIsCaught) {
    // The texels are right: figures of the manifest, and copies of it inside a texture, are not.
    const SmallScene scene(SmallScene::Parts::LightMap, sunAndSky, 24);
    expectCaught(
        Cooked(scene.sceneFile(), "ratio", "light-map"),
        {{"one constant less", "map", Digests::Rewritten, 4, "metadata constants/scale",
          [](CookedCopy& c) { changeFacts(c, [](Json& facts) { facts["constants"].erase("scale"); }); }},
         {"one constant more", "map", Digests::Rewritten, 4, "metadata constants/gamma",
          [](CookedCopy& c) { changeFacts(c, [](Json& facts) { facts["constants"]["gamma"] = {2.2}; }); }},
         {"another phase beside the constants", "map", Digests::Rewritten, 4, "metadata phase",
          [](CookedCopy& c) { changeFacts(c, [](Json& facts) { facts["phase"] = "condon-shortley"; }); }},
         {"no metadata", "map", Digests::Rewritten, 4, kMetadataKey,
          [](CookedCopy& c) { changeMetadata(c, "ratio", [](auto& metadata) { metadata.erase(kMetadataKey); }); }},
         {"linear texels called sRGB", "map", Digests::Rewritten, 4, "transfer function",
          [](CookedCopy& c) {
              std::string content = formats::contentOf(c.file("ratio"));
              std::uint32_t descriptor = 0;
              std::memcpy(&descriptor, content.data() + 48, 4);
              content[descriptor + 14] = 2;
              formats::writeContent(c.file("ratio"), content);
          }},
         {"irradiance", "map", Digests::Rewritten, 4, "quantity", [](CookedCopy& c) { c.asset()["quantity"] = "irradiance"; }},
         {"blocks of another target", "map", Digests::Rewritten, 4, "target", [](CookedCopy& c) { c.manifest()["target"] = "astc"; }}});
}

TEST(Mutation, OfALightMapOfTwoStagesIsCaught) {
    const SmallScene scene(SmallScene::Parts::LightMap), other(SmallScene::Parts::LightMap, grey);
    const Cooked cooked(scene.sceneFile(), "hdr-2", "light-map");
    const Cooked stranger(other.sceneFile(), "hdr-2", "light-map");
    expectCaught(
        cooked,
        {{"first and second texture swapped", "map", Digests::Rewritten, 4, "rel_rms", [](CookedCopy& c) { swapFiles(c, "sh", "second"); }},
         {"the second stage of a map upside down", "map", Digests::Rewritten, 4, "without it",
          [](CookedCopy& c) { moveTexels(c, "second", [](int x, int y, int, int h) { return glm::ivec2(x, h - 1 - y); }); }},
         {"the second stage's sign", "map", Digests::Rewritten, 4, "without it",
          [](CookedCopy& c) { multiply(c.constants()["share"], -1); }},
         {"a stale texture", "map", Digests::Stale, 4, "sh",
          [&](CookedCopy& c) {
              CookedCopy old = stranger.copyOf("map");
              std::filesystem::copy_file(old.file("sh"), c.file("sh"), std::filesystem::copy_options::overwrite_existing);
          }},
         {"the source baked again", "map", Digests::Stale, 4, "the source changed", [&](CookedCopy&) {
              std::filesystem::copy_file(other / "map.exr", scene / "map.exr", std::filesystem::copy_options::overwrite_existing);
          }}});
}

/// A filter on a chart reads the texels beside it, too. Random places of the surface miss some of them.
TEST(Mutation, OfATexelBesideAChartIsCaught) {
    constexpr int kSide = 32, kFirst = 8, kEnd = 24;  // the chart is a square
    const SmallScene scene(SmallScene::Parts::LightMap);
    auto writer = formats::LightMapWriter::create(scene / "map.exr", kSide, kSide, formats::SurfaceOutput::CoverageAndNormals);
    formats::Image<lighting::ShRgb> sh(kSide, kSide, lighting::ShRgb{});
    formats::Image<std::uint8_t> covered(kSide, kSide, 0);
    formats::Image<vec3> normal(kSide, kSide, vec3(0));
    for (int y = kFirst; y < kEnd; ++y)
        for (int x = kFirst; x < kEnd; ++x) {
            covered.at(x, y) = 1;
            normal.at(x, y) = vec3(0, 0, 1);
            sh.at(x, y) = shOf(sunAndSky, {(x + 0.5) / kSide, (y + 0.5) / kSide});
        }
    // Stored numbers are relative to the brightest texel of the map: this lamp, far from the rims.
    for (vec3& coefficient : sh.at(kSide / 2, kSide / 2)) coefficient *= 100.0f;
    (void)writer->append(sh.view(), {covered.view(), normal.view()});
    (void)writer->commit();
    std::vector<Fault> faults;
    for (const glm::ivec2 at : {glm::ivec2(kFirst - 1, kFirst - 1), glm::ivec2(kEnd, kFirst - 1), glm::ivec2(kFirst - 1, kEnd),
                                glm::ivec2(kEnd, kEnd), glm::ivec2(12, kFirst - 1), glm::ivec2(kEnd, 17), glm::ivec2(16, kEnd)})
        faults.push_back({"60000 beside the chart", "map", Digests::Rewritten, 4, "rim of a chart", [at](CookedCopy& c) {
                              c.edit("sh", [&](Images& images) {
                                  for (TexelImage& image : images) image.at(at.x, at.y) = vec4(60000);
                              });
                          }});
    const auto isOutside = [](int x, int y) { return x < kFirst || x >= kEnd || y < kFirst || y >= kEnd; };
    const auto fillOutside = [&](const char* name, const vec4& texel) {
        faults.push_back({name, "map", Digests::Rewritten, 4, "rel_rms", [&, texel](CookedCopy& c) {
                              c.edit("sh", [&](Images& images) {
                                  for (TexelImage& image : images)
                                      for (int y = 0; y < kSide; ++y)
                                          for (int x = 0; x < kSide; ++x)
                                              if (isOutside(x, y)) image.at(x, y) = texel;
                              });
                          }});
    };
    fillOutside("black padding", vec4(0));
    fillOutside("padding without the light of another unit", vec4(1e-4f));
    expectCaught(Cooked(scene.sceneFile(), "raw", "light-map"), faults);
}

TEST(Mutation, OfAFlatLightMapIsCaught) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    scene.writeSceneFile("", "[[material]]\nname = \"*\"\nnormal_map = false\nspecular = false\n");
    expectCaught(
        Cooked(scene.sceneFile(), "flat", "light-map"),
        {{"not divided by pi", "map", Digests::Rewritten, 4, "rel_rms", [](CookedCopy& c) { multiply(c.constants()["range"], kPi); }},
         {"left and right", "map", Digests::Rewritten, 4, "rel_rms",
          [](CookedCopy& c) { moveTexels(c, "exit", [](int x, int y, int w, int) { return glm::ivec2(w - 1 - x, y); }); }}});
}

TEST(Mutation, OfTheDivisorOfAProbeIsCaught) {
    // Texels and divisor agree in each of them: only the probe's own SH tells them apart.
    const SmallScene scene(SmallScene::Parts::All);
    expectCaught(Cooked(scene.sceneFile(), "ratio", "cubemap"),
                 {{"twice the divisor, half the range", "probe", Digests::Rewritten, 4, "windowed_sh",
                   [](CookedCopy& c) {
                       multiply(c.constants()["windowed_sh"], 2);
                       multiply(c.constants()["range"], 0.5);
                   }},
                  {"a window of another lambda", "probe", Digests::Rewritten, 4, "window",
                   [](CookedCopy& c) {
                       c.constants()["window"] = {1, 0.5, 0.1};
                   }},
                  {"another lambda", "probe", Digests::Rewritten, 4, "window", [](CookedCopy& c) { c.constants()["window_lambda"] = 5; }},
                  {"another epsilon", "probe", Digests::Rewritten, 4, "epsilon", [](CookedCopy& c) { c.constants()["epsilon"] = 0.5; }}});
}

// ---- the scene that ships with the program: learned layouts, dominant light, probe, sky, tables, mesh ----

/// The runs of a learned layout's index, block by block and back.
void changeClusters(CookedCopy& copy, const std::function<void(std::vector<int>& clusters)>& change) {
    const auto runs = copy.constants().at("index_runs").get<std::vector<int>>();
    std::vector<int> clusters;
    for (std::size_t i = 0; i < runs.size(); i += 2) clusters.insert(clusters.end(), static_cast<std::size_t>(runs[i + 1]), runs[i]);
    change(clusters);
    Json again = Json::array();
    for (std::size_t i = 0; i < clusters.size();) {
        std::size_t end = i;
        while (end < clusters.size() && clusters[end] == clusters[i]) ++end;
        again.push_back(clusters[i]);
        again.push_back(end - i);
        i = end;
    }
    copy.constants()["index_runs"] = again;
}

const std::vector<Fault>& basisFaults() {
    static const std::vector<Fault> kFaults = {
        {"one block black", "lightmap", Digests::Rewritten, 4, "block",
         [](CookedCopy& c) {
             const glm::ivec2 at = averageBlock(c);
             c.setBlock("l0", at.x, at.y, std::byte{0});
         }},
        {"one block of a reserved mode", "lightmap", Digests::Rewritten, 4, "block",
         [](CookedCopy& c) {
             const glm::ivec2 at = averageBlock(c);
             c.setBlock("l0", at.x, at.y, std::byte{0x5b});
         }},
        {"one row off", "lightmap", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             for (const char* role : {"l0", "code", "residual"})
                 moveTexels(c, role, [](int x, int y, int, int) { return glm::ivec2(x, std::max(y - 1, 0)); });
         }},
        {"the index one block off", "lightmap", Digests::Rewritten, 4, "found",
         [](CookedCopy& c) {
             changeClusters(c, [](std::vector<int>& clusters) { std::rotate(clusters.begin(), clusters.begin() + 1, clusters.end()); });
         }},
        {"one run too long", "lightmap", Digests::Rewritten, 3, "index_runs",
         [](CookedCopy& c) { multiply(c.constants()["index_runs"][1], 2); }},
        {"a cluster that is not there", "lightmap", Digests::Rewritten, 3, "index_runs",
         [](CookedCopy& c) { c.constants()["index_runs"][0] = 255; }},
        {"the tables of two clusters swapped", "lightmap", Digests::Rewritten, 4, "found",
         [](CookedCopy& c) {
             moveTexels(c, "tables", [](int x, int y, int, int) { return glm::ivec2(x, x < 120 && y < 2 ? 1 - y : y); });
         }},
        {"the residual's tables negated", "lightmap", Digests::Rewritten, 4, "without it",
         [](CookedCopy& c) {
             c.edit("tables", [](std::vector<TexelImage>& images) {
                 for (int y = 0; y < images[0].height(); ++y)
                     for (int x = 120; x < images[0].width(); ++x) images[0].at(x, y) *= -1.0f;
             });
         }},
        {"tables of another width", "lightmap", Digests::Rewritten, 4, "tables", [](CookedCopy& c) { swapFiles(c, "tables", "l0"); }},
        {"a constant that names another file of tables", "lightmap", Digests::Rewritten, 4, "constants/tables",
         [](CookedCopy& c) { c.constants()["tables"]["file"] = "lightmap_l0.ktx2"; }},
        {"a texture that is no array by the manifest", "lightmap", Digests::Rewritten, 4, "array",
         [](CookedCopy& c) { c.texture("l0")["array"] = true; }},
        {"a format of another number", "lightmap", Digests::Rewritten, 4, "api_formats",
         [](CookedCopy& c) { c.texture("l0")["api_formats"]["metal"] = 150; }},
        {"a neutral code a quarter too small", "lightmap", Digests::Rewritten, 4, "found",
         [](CookedCopy& c) { multiply(c.constants()["neutral"], 0.75); }},
    };
    return kFaults;
}

/// Faults of every texel, whose verification takes the longest.
const std::vector<Fault>& wholeBasisFaults() {
    static const std::vector<Fault> kFaults = {
        {"every cluster the next one", "lightmap", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             const int count = c.constants().at("clusters")[0].get<int>();
             changeClusters(c, [&](std::vector<int>& clusters) {
                 for (int& cluster : clusters) cluster = (cluster + 1) % count;
             });
         }},
        {"the table by coefficients instead of monomials", "lightmap", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             constexpr int kMonomials = 15, kCoefficients = 8;
             moveTexels(c, "tables", [](int x, int y, int, int) {
                 return x < kMonomials * kCoefficients ? glm::ivec2(x % kMonomials * kCoefficients + x / kMonomials, y) : glm::ivec2(x, y);
             });
         }},
        {"code and residual swapped", "lightmap", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { swapFiles(c, "code", "residual"); }},
    };
    return kFaults;
}

const std::vector<Fault>& dominantFaults() {
    static const std::vector<Fault> kFaults = {
        {"the dominant direction negated", "lightmap_dominant", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             multiply(c.constants()["direction_scale"], -1);
             multiply(c.constants()["direction_bias"], -1);
             multiply(c.constants()["residual_scale"], 1);
         }},
        {"the direction's axes turned", "lightmap_dominant", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { changeTexels(c, "direction", [](const vec4& t) { return vec4(t.y, t.z, t.x, t.w); }); }},
        {"a direction of unsigned range", "lightmap_dominant", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             c.constants()["direction_scale"] = 1.0;
             c.constants()["direction_bias"] = 0.0;
         }},
        {"an intensity multiplied by pi", "lightmap_dominant", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { multiply(c.constants()["intensity_range"], kPi); }},
        {"direction and residual swapped", "lightmap_dominant", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { swapFiles(c, "direction", "residual"); }},
        {"the residual of a map seen in a mirror", "lightmap_dominant", Digests::Rewritten, 4, "without it",
         [](CookedCopy& c) { moveTexels(c, "residual", [](int x, int y, int w, int) { return glm::ivec2(w - 1 - x, y); }); }},
        {"the residual's sign", "lightmap_dominant", Digests::Rewritten, 4, "without it",
         [](CookedCopy& c) { multiply(c.constants()["residual_scale"], -1); }},
    };
    return kFaults;
}

const std::vector<Fault>& probeFaults() {
    static const std::vector<Fault> kFaults = {
        {"a face in a mirror", "probe0", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             c.edit("cubemap", [](Images& images) {
                 for (std::size_t mip = 0; mip < images.size(); mip += 6)
                     for (int y = 0; y < images[mip].height(); ++y)
                         std::ranges::reverse(std::span(&images[mip].at(0, y), static_cast<std::size_t>(images[mip].width())));
             });
         }},
        {"faces +X and -X swapped", "probe0", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             c.edit("cubemap", [](Images& images) {
                 for (std::size_t mip = 0; mip < images.size(); mip += 6) swapImages(images, mip, mip + 1);
             });
         }},
        {"every mip filtered as the one before it", "probe0", Digests::Rewritten, 4, "found",
         [](CookedCopy& c) {
             c.edit("cubemap", [](Images& images) {
                 for (std::size_t i = images.size() - 1; i >= 6; --i)
                     for (int y = 0; y < images[i].height(); ++y)
                         for (int x = 0; x < images[i].width(); ++x) {
                             vec4 sum(0);
                             for (int part = 0; part < 4; ++part) sum += images[i - 6].at(2 * x + part % 2, 2 * y + part / 2);
                             images[i].at(x, y) = 0.25f * sum;
                         }
             });
         }},
        {"a small level half as bright", "probe0", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             c.edit("cubemap", [](Images& images) {
                 for (std::size_t i = 3 * 6; i < 4 * 6; ++i)
                     for (vec4& texel : images[i].texels()) texel *= 0.5f;
             });
         }},
        {"red and blue of a small level swapped", "probe0", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             c.edit("cubemap", [](Images& images) {
                 for (std::size_t i = 3 * 6; i < 4 * 6; ++i)
                     for (vec4& texel : images[i].texels()) std::swap(texel.x, texel.z);
             });
         }},
        {"not divided by its own area specular", "probe0", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             for (std::size_t i = 1; i < 9; ++i) c.constants()["windowed_sh"][i] = {0, 0, 0};
         }},
        {"the phase of the divisor", "probe0", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             for (const int i : {1, 3, 5, 7}) multiply(c.constants()["windowed_sh"][static_cast<std::size_t>(i)], -1);
         }},
        {"a divisor that is negative somewhere", "probe0", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             for (std::size_t i = 1; i < 9; ++i) multiply(c.constants()["windowed_sh"][i], 8);
         }},
        {"the band factors of the next mip", "probe0", Digests::Rewritten, 4, "found",
         [](CookedCopy& c) {
             Json& mips = c.constants()["mips"];
             for (std::size_t i = 0; i + 1 < mips.size(); ++i) mips[i]["bands"] = Json(mips[i + 1]["bands"]);
         }},
        {"roughness not squared", "probe0", Digests::Rewritten, 4, "perceptual_roughness",
         [](CookedCopy& c) {
             for (Json& mip : c.constants()["mips"]) mip["perceptual_roughness"] = mip["m"];
         }},
        {"the range of another probe", "probe0", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) { multiply(c.constants()["range"], 0.5); }},
        {"a level with 1.3 times its light", "probe0", Digests::Rewritten, 4, "rel_rms",
         [](CookedCopy& c) {
             c.edit("cubemap", [](Images& images) {
                 for (std::size_t i = 2 * 6; i < 3 * 6; ++i)
                     for (vec4& texel : images[i].texels()) texel *= 1.3f;
             });
         }},
    };
    return kFaults;
}

const std::vector<Fault>& skyAndTableFaults() {
    static const std::vector<Fault> kFaults = {
        {"rows one exponent up", "sky", Digests::Rewritten, 4, "row",
         [](CookedCopy& c) { moveTexels(c, "rsrm", [](int x, int y, int, int h) { return glm::ivec2(x, std::min(y + 1, h - 1)); }); }},
        {"south for north", "sky", Digests::Rewritten, 4, "row",
         [](CookedCopy& c) { moveTexels(c, "rsrm", [](int x, int y, int w, int) { return glm::ivec2(w - 1 - x, y); }); }},
        {"an axis that points down", "sky", Digests::Rewritten, 4, "axis", [](CookedCopy& c) { multiply(c.asset()["axis"], -1); }},
        {"half a zone off", "sky", Digests::Rewritten, 4, "row",
         [](CookedCopy& c) {
             c.edit("rsrm", [](Images& images) {
                 for (int y = 0; y < images[0].height(); ++y)
                     for (int x = 0; x + 1 < images[0].width(); ++x)
                         images[0].at(x, y) = 0.5f * (images[0].at(x, y) + images[0].at(x + 1, y));
             });
         }},
        {"one texel two codes off", "sky", Digests::Rewritten, 4, "row 3, texel 100",
         [](CookedCopy& c) {
             c.edit("rsrm", [](Images& images) { images[0].at(100, 3).y += images[0].at(100, 3).y < 0.5f ? 0.01f : -0.01f; });
         }},
        {"the colour over pi", "sky", Digests::Rewritten, 4, "row", [](CookedCopy& c) { multiply(c.constants()["color"], 1 / kPi); }},
        {"exponents that were not used", "sky", Digests::Rewritten, 4, "row",
         [](CookedCopy& c) { multiply(c.constants()["exponents"][2], 1.1); }},
        {"a row missing", "sky", Digests::Rewritten, 4, "rows", [](CookedCopy& c) { c.constants()["exponents"].erase(3); }},
        {"view and roughness swapped", "specular", Digests::Rewritten, 4, "texture",
         [](CookedCopy& c) {
             for (const char* role : {"c0236", "d0236", "cd78"})
                 moveTexels(c, role, [](int x, int y, int, int h) { return glm::ivec2(y, std::min(x, h - 1)); });
         }},
        {"grazing for facing", "specular", Digests::Rewritten, 4, "texture",
         [](CookedCopy& c) {
             for (const char* role : {"c0236", "d0236", "cd78"})
                 moveTexels(c, role, [](int x, int y, int w, int) { return glm::ivec2(w - 1 - x, y); });
         }},
        {"C and D swapped", "specular", Digests::Rewritten, 4, "texture", [](CookedCopy& c) { swapFiles(c, "c0236", "d0236"); }},
        {"four times the light, as Halo 3 has it", "specular", Digests::Rewritten, 4, "texture",
         [](CookedCopy& c) {
             for (const char* role : {"c0236", "d0236", "cd78"})
                 for (const char* part : {"_scale", "_bias"}) multiply(c.constants()[role + std::string(part)], 4);
         }},
        {"one texel of 192", "specular", Digests::Rewritten, 4, "texture c0236, channel 1",
         [](CookedCopy& c) { c.edit("c0236", [](Images& images) { images[0].at(4, 3).y += 0.001f; }); }},
        {"an axis scaled for texel edges", "specular", Digests::Rewritten, 4, "axis of NoV, coordinate",
         [](CookedCopy& c) {
             c.constants()["view"]["scale"] = 1.0;
             c.constants()["view"]["offset"] = 0.0;
         }},
        {"the cosine axis called a sine", "specular", Digests::Rewritten, 4, "texture",
         [](CookedCopy& c) { c.constants()["view"]["of"] = "sin(theta_v)"; }},
    };
    return kFaults;
}

/// The example's mesh written anew into the copy.
void writeMesh(CookedCopy& copy, const std::filesystem::path& source, const formats::DracoOptions& options) {
    const auto scene = valueOf(formats::GltfScene::load(source));
    (void)valueOf(scene.writeDraco(copy.folder() / copy.asset().at("file").get<std::string>(), options));
}
/// The same, of a source whose JSON or buffer was changed first. The buffer begins where the GLB's second chunk does.
void writeMeshOf(CookedCopy& copy, const std::function<void(Json& json, std::span<float> buffer)>& change) {
    const std::string glb = formats::contentOf(copy.sources() / "cornell.glb");
    std::uint32_t jsonSize = 0, binarySize = 0;
    std::memcpy(&jsonSize, glb.data() + 12, 4);
    std::memcpy(&binarySize, glb.data() + 20 + jsonSize, 4);
    Json json = Json::parse(glb.substr(20, jsonSize));
    std::vector<float> buffer(binarySize / 4);
    std::memcpy(buffer.data(), glb.data() + 28 + jsonSize, buffer.size() * 4);
    change(json, buffer);
    std::string text = json.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string changed = "glTF" + std::string(16, '\0') + text + std::string(8, '\0');
    const std::uint32_t sizes[] = {2, static_cast<std::uint32_t>(28 + text.size() + 4 * buffer.size()),
                                   static_cast<std::uint32_t>(text.size()), 0x4E4F534A};
    std::memcpy(changed.data() + 4, sizes, 16);
    const std::uint32_t binary[] = {static_cast<std::uint32_t>(4 * buffer.size()), 0x004E4942};
    std::memcpy(changed.data() + 20 + text.size(), binary, 8);
    changed.append(reinterpret_cast<const char*>(buffer.data()), 4 * buffer.size());
    formats::writeContent(copy.folder() / "changed.glb", changed);
    writeMesh(copy, copy.folder() / "changed.glb", {});
}
/// Calls change(values of a vertex) for every vertex of an attribute of every primitive.
void changeAttribute(Json& json, std::span<float> buffer, const char* semantic, int components, const std::function<void(float*)>& change) {
    std::set<std::uint64_t> done;
    for (const Json& mesh : json.at("meshes"))
        for (const Json& primitive : mesh.at("primitives")) {
            const auto index = primitive.at("attributes").at(semantic).get<std::uint64_t>();
            if (!done.insert(index).second) continue;
            const Json& accessor = json.at("accessors")[index];
            const Json& view = json.at("bufferViews")[accessor.at("bufferView").get<std::size_t>()];
            const std::size_t stride = view.value("byteStride", std::size_t{0}) / 4;
            const std::size_t first = (view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0})) / 4;
            for (std::size_t i = 0; i < accessor.at("count").get<std::size_t>(); ++i)
                change(&buffer[first + i * (stride > 0 ? stride : static_cast<std::size_t>(components))]);
        }
}

const std::vector<Fault>& meshFaults() {
    static const std::vector<Fault> kFaults = {
        {"one bit of the mesh", "cornell_mesh", Digests::Stale, 4, "cornell_mesh.glb",
         [](CookedCopy& c) { flipBit(c.folder() / "cornell_mesh.glb"); }},
        {"light-map UVs one texel off", "cornell_mesh", Digests::Rewritten, 4, "light-map UVs",
         [](CookedCopy& c) {
             writeMeshOf(c, [](Json& json, std::span<float> buffer) {
                 changeAttribute(json, buffer, "TEXCOORD_1", 2, [](float* uv) { uv[0] += 1.0f / 256; });
             });
         }},
        {"V from below", "cornell_mesh", Digests::Rewritten, 4, "light-map UVs",
         [](CookedCopy& c) {
             writeMeshOf(c, [](Json& json, std::span<float> buffer) {
                 changeAttribute(json, buffer, "TEXCOORD_1", 2, [](float* uv) { uv[1] = 1 - uv[1]; });
             });
         }},
        {"Draco with 8 bits of light-map UV", "cornell_mesh", Digests::Rewritten, 4, "light-map UVs",
         [](CookedCopy& c) { writeMesh(c, c.sources() / "cornell.glb", {.lightMapUvBits = 8}); }},
        {"Draco with 6 bits of position", "cornell_mesh", Digests::Rewritten, 4, "positions",
         [](CookedCopy& c) { writeMesh(c, c.sources() / "cornell.glb", {.positionBits = 6}); }},
        {"the axes of normals turned", "cornell_mesh", Digests::Rewritten, 4, "normals",
         [](CookedCopy& c) {
             writeMeshOf(c, [](Json& json, std::span<float> buffer) {
                 changeAttribute(json, buffer, "NORMAL", 3, [](float* n) { std::swap(n[0], n[1]), std::swap(n[1], n[2]); });
             });
         }},
        {"the normals' frame turned: a rotated node", "cornell_mesh", Digests::Rewritten, 4, "nodes",
         [](CookedCopy& c) { writeMeshOf(c, [](Json& json, std::span<float>) {
                                 json["nodes"][0]["rotation"] = {0.5, 0.5, 0.5, 0.5};
                             }); }},
        {"a material that wants other light", "cornell_mesh", Digests::Rewritten, 4, "materials",
         [](CookedCopy& c) {
             writeMeshOf(c, [](Json& json, std::span<float>) { json["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 0.1; });
         }},
        {"winding reversed", "cornell_mesh", Digests::Rewritten, 4, "cornell_mesh.glb",
         [](CookedCopy& c) {
             writeMeshOf(c, [](Json& json, std::span<float> buffer) {
                 changeAttribute(json, buffer, "POSITION", 3, [](float* p) { p[0] = -p[0]; });
             });
         }},
        {"vertices that take no memory", "cornell_mesh", Digests::Rewritten, 4, "bytes_gpu",
         [](CookedCopy& c) { c.asset()["bytes_gpu"] = 1; }},
        {"three vertices", "cornell_mesh", Digests::Rewritten, 4, "vertices", [](CookedCopy& c) { c.asset()["vertices"] = 3; }},
        {"one triangle", "cornell_mesh", Digests::Rewritten, 4, "triangles", [](CookedCopy& c) { c.asset()["triangles"] = 1; }},
        {"more bits than the positions have", "cornell_mesh", Digests::Rewritten, 4, "quantization/position_bits",
         [](CookedCopy& c) { c.asset()["quantization"]["position_bits"] = 13; }},
        {"bits of normals", "cornell_mesh", Digests::Rewritten, 4, "quantization/normal_bits",
         [](CookedCopy& c) { c.asset()["quantization"].erase("normal_bits"); }},
        {"bits of UVs", "cornell_mesh", Digests::Rewritten, 4, "quantization/light_map_uv_bits",
         [](CookedCopy& c) { c.asset()["quantization"]["light_map_uv_bits"] = 1; }},
        {"an honest manifest of a coarse mesh", "cornell_mesh", Digests::Rewritten, 4, "texels",
         [](CookedCopy& c) {
             writeMesh(c, c.sources() / "cornell.glb", {.lightMapUvBits = 6});
             c.asset()["quantization"]["light_map_uv_bits"] = 6;
         }},
    };
    return kFaults;
}

/// Right texels, and a manifest or a shader that makes an engine shade them wrongly.
const std::vector<Fault>& contractFaults() {
    static const std::vector<Fault> kFaults = {
        {"a shader without its division by pi", "sky", Digests::Rewritten, 4, kShaderName,
         [](CookedCopy& c) {
             std::string text = formats::contentOf(c.folder() / kShaderName);
             const std::string bands = "vec3(1.0f, 0.66666667f, 0.25f)";
             formats::writeContent(c.folder() / kShaderName, text.replace(text.find(bands), bands.size(), "vec3(3.1f, 2.1f, 0.78f)"));
         }},
        {"the other phase in the manifest", "probe0", Digests::Rewritten, 4, "phase",
         [](CookedCopy& c) { c.asset()["phase"] = "condon-shortley"; }},
        {"game units in the manifest", "lightmap_dominant", Digests::Rewritten, 4, "units",
         [](CookedCopy& c) { c.asset()["units"] = "game"; }},
        {"a sampler that repeats", "lightmap_dominant", Digests::Rewritten, 4, "sampler",
         [](CookedCopy& c) { c.texture("direction")["sampler"]["wrap"] = "repeat"; }},
        {"a smaller size for the budget", "sky", Digests::Rewritten, 4, "bytes_gpu",
         [](CookedCopy& c) { c.texture("rsrm")["bytes_gpu"] = 512; }},
        {"another working space", "sky", Digests::Rewritten, 4, "color",
         [](CookedCopy& c) { c.manifest()["color"]["working"] = "acescg"; }},
        {"tables said to be Halo 3's", "specular", Digests::Rewritten, 4, "normalization",
         [](CookedCopy& c) { c.asset()["normalization"] = "halo3"; }},
    };
    return kFaults;
}

const std::filesystem::path kShippedScene = std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "examples/cornell/scene.toml";

TEST(Mutation, OfAMeshIsCaught) {
    expectCaught(Cooked(kShippedScene, "ratio", "mesh"), meshFaults());
}

/// Returns the first fault of a list and each that is `step` behind the one before.
std::vector<Fault> everyNth(const std::vector<Fault>& faults, std::size_t step) {
    std::vector<Fault> chosen;
    for (std::size_t i = 0; i < faults.size(); i += step) chosen.push_back(faults[i]);
    return chosen;
}

TEST(Mutation, OfTheSceneThatShipsIsCaught) {
    const Cooked cooked(kShippedScene, "basis-8");
    for (const auto* faults : {&basisFaults(), &dominantFaults(), &probeFaults(), &skyAndTableFaults(), &contractFaults()})
        expectCaught(cooked, everyNth(*faults, 6));
    // Constants inside a texture that another manifest had: the one fault that keeps its stale metadata.
    CookedCopy copy = cooked.copyOf("sky");
    multiply(copy.constants()["color"], 1.0001);
    copy.rewriteDigests(false);
    const Outcome outcome = copy.verify();
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_THAT(outcome.errors.front().line(), testing::HasSubstr("metadata constants/color"));
}

TEST(Mutation, MetadataOfATextureIsThatOfTheManifest) {
    const Cooked cooked(kShippedScene, "basis-8");
    std::set<std::string> kinds;
    for (const char* name : {"lightmap", "lightmap_dominant", "probe0", "sky", "specular"}) {
        CookedCopy copy = cooked.copyOf(name);
        const Json asset = copy.asset();
        kinds.insert(asset.at("kind"));
        for (const Json& texture : asset.at("textures")) {
            SCOPED_TRACE(texture.at("file"));
            const auto reader = valueOf(formats::TextureReader::open(copy.folder() / texture.at("file").get<std::string>()));
            const Json metadata = parseJson(reader.metadata().at(kMetadataKey));
            for (const char* member : {"kind", "layout", "distribution", "normalization"})
                EXPECT_EQ(metadata.value(member, Json()), asset.value(member, Json())) << member;
            EXPECT_EQ(metadata.at("role"), texture.at("role"));
        }
    }
    EXPECT_EQ(kinds, (std::set<std::string>{"cubemap", "dominant", "light-map", "lut", "rsrm"}));
}

TEST(MutationOfAssetsSoak, OfTheSceneThatShipsIsCaught) {
    const Cooked cooked(kShippedScene, "basis-8");
    const test::SoakTime time;
    std::vector<Fault> all;
    for (const auto* faults :
         {&basisFaults(), &wholeBasisFaults(), &dominantFaults(), &probeFaults(), &skyAndTableFaults(), &contractFaults()})
        all.insert(all.end(), faults->begin(), faults->end());
    std::ranges::shuffle(all, std::mt19937_64(test::soakSeed()));
    expectCaught(cooked, all, &time);
}

/// Places of all numbers below a value.
void numbersOf(const Json& value, const Json::json_pointer& place, std::vector<Json::json_pointer>& found) {
    if (value.is_number()) found.push_back(place);
    if (value.is_object())
        for (const auto& [name, each] : value.items()) numbersOf(each, place / name, found);
    if (value.is_array())
        for (std::size_t i = 0; i < value.size(); ++i) numbersOf(value[i], place / i, found);
}

/// Returns the largest error that a report of one asset states.
double statedError(const Outcome& outcome) {
    const Json& error = outcome.report.at("assets").at(0).at("stages").back().at("error");
    return std::max(error.at("diffuse").at("rel_rms").get<double>(), error.at("specular").at("rel_rms").get<double>());
}

/// Every number that a loader is told, a quarter more (of 0.01 at least), in manifest and textures alike: it is refused, or the report
/// states another error.
void expectConstantsCaught(const Cooked& cooked, const std::string& asset, const test::SoakTime& time) {
    std::vector<Json::json_pointer> places;
    numbersOf(cooked.copyOf(asset).constants(), Json::json_pointer(), places);
    ASSERT_FALSE(places.empty()) << asset;
    const double right = statedError(cooked.copyOf(asset).verify());
    int tried = 0;
    for (const Json::json_pointer& place : places) {
        if (tried > 0 && time.isOver()) break;
        ++tried;
        CookedCopy copy = cooked.copyOf(asset);
        Json& number = copy.constants()[place];
        const Json before = number;
        if (number.is_number_integer())
            number = number.get<std::int64_t>() + 1;
        else
            number = number.get<double>() + 0.25 * std::max(std::abs(number.get<double>()), 0.01);
        copy.rewriteDigests();
        const Outcome outcome = copy.verify();
        EXPECT_TRUE(!outcome.errors.empty() || statedError(outcome) != right)
            << asset << place << ": " << before << " -> " << copy.constants()[place];
    }
    test::countInSoak(tried, "faults of cooked files");
}

class MutationSoak : public testing::TestWithParam<const char*> {};
TEST_P(MutationSoak, OfEachConstantOfALayoutIsCaught) {
    const SmallScene scene(SmallScene::Parts::LightMap, sunAndSky, 24);
    expectConstantsCaught(Cooked(scene.sceneFile(), GetParam(), "light-map"), "map", test::SoakTime());
}
INSTANTIATE_TEST_SUITE_P(Layouts, MutationSoak, testing::Values("raw", "basis-8", "hdr", "hdr-2", "hdr-rgb9e5", "halo3", "lit-half"));
TEST(MutationOfAssetsSoak, OfEachConstantIsCaught) {
    const SmallScene scene(SmallScene::Parts::All, sunAndSky, 24);
    const Cooked cooked(scene.sceneFile(), "ratio");
    const test::SoakTime time;
    for (const char* asset : {"map", "map_dominant", "specular", "probe", "sky"}) expectConstantsCaught(cooked, asset, time);
}

}  // namespace
}  // namespace lightcook::pipeline
