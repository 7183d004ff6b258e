#include "formats/bakes/unreal.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/epic_light_maps.h"
#include "tests/formats/light_map_fixture.h"
#include "tests/formats/unreal_fixture.h"

namespace lightcook::formats {
namespace {

using Json = nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kUnrealWidth = 40, kUnrealHeight = 24;
/// Two meshes in one image, with a row of padding around each.
constexpr UnrealRectangle kLeft = {1, 1, 18, 22}, kRight = {21, 1, 18, 20};

/// The right mesh is darker by a factor, so that its constants are others.
glm::dvec3 unrealLightAt(int x, int y) {
    return (x < 20 ? 1 : 0.01) * seededUnrealLight(x, y);
}

/// A glTF beside its image, level.gltf and "light map.png".
struct UnrealBake {
    TemporaryFolder folder;
    UnrealImage image{kUnrealWidth, kUnrealHeight};
    std::array<UnrealConstants, 2> constants = {image.encode(kLeft, unrealLightAt), image.encode(kRight, unrealLightAt)};
    Json gltf = unrealGltf(Json::array({{{"name", "HQ_Lightmap0"}, {"uri", "light%20map.png"}}}),
                           Json::array({unrealLightMap(image, kLeft, constants[0], 0), unrealLightMap(image, kRight, constants[1], 0)}));

    UnrealBake() { image.writeTo(folder / "light map.png"); }
    Json& lightMap(std::size_t i) { return gltf["extensions"]["EPIC_lightmap_textures"]["lightmaps"][i]; }
    std::filesystem::path write() const {
        writeContent(folder / "level.gltf", gltf.dump());
        return folder / "level.gltf";
    }
    std::string png() const { return contentOf(folder / "light map.png"); }
};

/// Decodes a texel as Unreal's shader does without directions.
glm::dvec3 shownByUnreal(const std::array<int, 4>& above, const std::array<int, 4>& below, const UnrealConstants& constants) {
    double logL = above[3] / 255.0;
    logL += below[3] / 255.0 * (1.0 / 255) - 0.5 / 255;
    logL = logL * constants.scale.w + constants.add.w;
    const double luminance = std::exp2(logL) - 0.01858136;
    glm::dvec3 shown(0);
    for (int c = 0; c < 3; ++c) {
        const double root = above.at(static_cast<std::size_t>(c)) / 255.0;
        shown[c] = std::max(0.0, luminance) * 0.6 * (root * root * constants.scale[c] + constants.add[c]);
    }
    return shown;
}

std::string base64(std::string_view bytes) {
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

LightMapDescription imageNamed(const std::string& image) {
    LightMapDescription description;
    description.image = image;
    return description;
}

TEST(UnrealHq, ATexelShadesAsTheShaderShowsItWithoutDirections) {
    const UnrealBake bake;
    const LightMapStrip strip = readAll(bake.write());
    ASSERT_EQ(strip.sh.width(), kUnrealWidth);
    ASSERT_EQ(strip.sh.height(), kUnrealHeight);
    constexpr double kBlackPoint = 0.0186;  // logarithms tell less light apart less well
    double fromShader = 0, fromLight = 0, brightest = 0;
    const std::array<UnrealRectangle, 2> parts = {kLeft, kRight};
    for (std::size_t i = 0; i < parts.size(); ++i)
        for (int y = parts.at(i).y; y < parts.at(i).y + parts.at(i).height; ++y)
            for (int x = parts.at(i).x; x < parts.at(i).x + parts.at(i).width; ++x) {
                ASSERT_EQ(strip.covered.at(x, y), 1);
                for (std::size_t k = 1; k < 9; ++k) ASSERT_EQ(strip.sh.at(x, y)[k], glm::vec3(0));
                const glm::dvec3 shader = shownByUnreal(bake.image.upper(x, y), bake.image.lower(x, y), bake.constants.at(i)),
                                 light = 0.6 * unrealLightAt(x, y);
                for (int c = 0; c < 3; ++c) {
                    const double shown = exitRadianceOfOrder1(strip.sh.at(x, y), c, glm::normalize(glm::dvec3(x, y, 3)));
                    fromShader = std::max(fromShader, std::abs(shown - shader[c]) / std::max({shader.x, shader.y, shader.z}));
                    fromLight = std::max(fromLight, std::abs(shown - light[c]) / (std::max({light.x, light.y, light.z}) + kBlackPoint));
                    brightest = std::max(brightest, shown);
                }
            }
    RecordProperty("from_shader", fmt::format("{:.2g}", fromShader));
    RecordProperty("from_light", fmt::format("{:.2g}", fromLight));
    EXPECT_LT(fromShader, 1e-5) << "of the texel's own brightness";
    EXPECT_LT(fromLight, 0.02) << "what eight bits take from the light that was encoded";
    EXPECT_GT(brightest, 10);
}

TEST(UnrealHq, TexelsOutsideTheRectanglesOfTheMeshesAreNotCovered) {
    UnrealBake bake;
    const LightMapStrip strip = readAll(bake.write());
    for (int y = 0; y < kUnrealHeight; ++y)
        for (int x = 0; x < kUnrealWidth; ++x) {
            const auto isIn = [&](const UnrealRectangle& part) {
                return part.x <= x && x < part.x + part.width && part.y <= y && y < part.y + part.height;
            };
            ASSERT_EQ(strip.covered.at(x, y) != 0, isIn(kLeft) || isIn(kRight)) << x << ", " << y;
        }
    // A rectangle of the whole image covers all of it: the file does not say which texels lie in charts.
    EXPECT_TRUE(LightMapReader::open(bake.write(), {})->hasCoverage());
    bake.lightMap(0)["coordinateScaleBias"] = {1, 1, 0, 0};
    bake.gltf["extensions"]["EPIC_lightmap_textures"]["lightmaps"].erase(1);
    bake.gltf["nodes"].erase(1);
    EXPECT_FALSE(LightMapReader::open(bake.write(), {})->hasCoverage());
}

TEST(UnrealHq, ATexelIsNamedByTheImageThatHasItsLight) {
    const UnrealBake bake;
    const auto reader = LightMapReader::open(bake.write(), {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_THAT(reader->placeOf(0, 1, 3, 4).text, testing::EndsWith("level.gltf, image 0, channel A, texel (3, 4)"));
}

TEST(UnrealHq, TheImageMayLieInAFileADataUriOrABuffer) {
    UnrealBake bake;
    const LightMapStrip strip = readAll(bake.write());
    const auto expectSame = [&](const std::filesystem::path& file, const char* what) {
        const LightMapStrip other = readAll(file);
        EXPECT_TRUE(other.sh.texels() == strip.sh.texels()) << what;
    };
    const std::string png = bake.png();
    bake.gltf["images"][0] = {{"uri", "data:image/png;base64," + base64(png)}};
    expectSame(bake.write(), "data URI");
    bake.gltf["images"][0] = {{"bufferView", 0}, {"mimeType", "image/png"}};
    bake.gltf["bufferViews"] = Json::array({{{"buffer", 0}, {"byteOffset", 8}, {"byteLength", png.size()}}});
    bake.gltf["buffers"] = Json::array({{{"byteLength", 8 + png.size()}}});
    writeContent(bake.folder / "level.glb", glbOf(bake.gltf.dump(), "padding." + png));
    expectSame(bake.folder / "level.glb", "buffer of a GLB");
}

/// PNG files may name a curve. The bytes are logarithms and roots, which no curve may change.
TEST(UnrealHq, ACurveThatThePngNamesIsNotApplied) {
    UnrealBake bake;
    const LightMapStrip strip = readAll(bake.write());
    constexpr std::size_t kAfterHeader = 8 + 25;
    for (const std::string& chunk :
         {pngChunk("sRGB", std::string(1, '\0')), pngChunk("gAMA", bigEndian(100000)), pngChunk("gAMA", bigEndian(45455))}) {
        writeContent(bake.folder / "curve.png", bake.png().insert(kAfterHeader, chunk));
        bake.gltf["images"][0]["uri"] = "curve.png";
        EXPECT_TRUE(readAll(bake.write()).sh.texels() == strip.sh.texels()) << chunk.substr(4, 4);
    }
}

TEST(UnrealHq, TheExtensionSaysWhatTheFileIs) {
    const UnrealBake bake;
    const std::filesystem::path file = bake.write();
    const auto reader = LightMapReader::open(file, {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "unreal-hq");
    EXPECT_TRUE(reader->recognition().isCertain);
    EXPECT_EQ(reader->recognition().evidence, "extension EPIC_lightmap_textures of the glTF");
    EXPECT_THAT(reader->recognition().otherReadings, IsEmpty());
    EXPECT_THAT(std::string(reader->recognition().format->assumes), HasSubstr("constants of the directions"));
    EXPECT_THAT(bakeFilesBeside(file, kAutoBake), ElementsAre(bake.folder / "light map.png"));
    EXPECT_THAT(bakeFilesBeside(file, "flat"), IsEmpty());
    LightMapDescription description;
    description.bake = "flat";
    EXPECT_THAT(refusal(file, description).line(),
                HasSubstr("found no light map of bake format flat, expected R, G, B; it holds EPIC_lightmap_textures"));
    description = {};
    description.encoding = LightEncoding::Rgbm;
    EXPECT_THAT(refusal(file, description).line(), HasSubstr("found \"rgbm\" for bake format unreal-hq, expected none"));
    description = {};
    description.bake = "unreal-hq";
    const MapFile other(seededMap(4, 4));
    EXPECT_THAT(refusal(other.path, description).line(), HasSubstr("expected a glTF with extension EPIC_lightmap_textures; it holds"));
    EXPECT_THAT(refusal(other.path, imageNamed("a")).line(),
                HasSubstr(", image: found \"a\" for bake format sh9, expected none: it is for unreal-hq"));
}

TEST(UnrealHq, OneOfSeveralImagesIsChosenByNameOrIndex) {
    UnrealBake bake;
    UnrealImage dark(8, 4);
    const UnrealRectangle whole = {0, 0, 8, 4};
    const UnrealConstants constants = dark.encode(whole, [](int x, int y) { return 0.001 * seededUnrealLight(x, y); });
    dark.writeTo(bake.folder / "dark.png");
    bake.gltf["images"].push_back({{"name", "HQ_Lightmap1"}, {"uri", "dark.png"}});
    bake.gltf["images"].push_back({{"name", "BaseColor"}, {"uri", "absent.png"}});
    bake.gltf["textures"].push_back({{"source", 1}});
    bake.gltf["extensions"]["EPIC_lightmap_textures"]["lightmaps"].push_back(unrealLightMap(dark, whole, constants, 1));
    const Error error = refusal(bake.write());
    EXPECT_EQ(error.code, ErrorCode::InvalidRequest);
    EXPECT_THAT(error.line(), testing::EndsWith("level.gltf: found 2 light maps, expected one of them: image = \"HQ_Lightmap0\" or "
                                                "image = \"HQ_Lightmap1\""));
    EXPECT_THAT(*epicImageNames(bake.write()), ElementsAre("HQ_Lightmap0", "HQ_Lightmap1"));
    EXPECT_EQ(readAll(bake.write(), imageNamed("HQ_Lightmap0")).sh.width(), kUnrealWidth);
    for (const char* name : {"HQ_Lightmap1", "1"}) EXPECT_EQ(readAll(bake.write(), imageNamed(name)).sh.width(), 8);
    for (const char* name : {"BaseColor", "2", "HQ"}) {
        const Error unknown = refusal(bake.write(), imageNamed(name));
        EXPECT_EQ(unknown.code, ErrorCode::InvalidRequest);
        EXPECT_THAT(unknown.line(),
                    HasSubstr(fmt::format("level.gltf, image: found \"{}\", expected a light map of the glTF: image = ", name)));
    }
    bake.gltf["images"][1]["name"] = "HQ_Lightmap0";
    EXPECT_THAT(*epicImageNames(bake.write()), ElementsAre("0", "1")) << "images that share a name";
    bake.gltf["images"][0].erase("name");
    bake.gltf["images"][1]["name"] = "0";
    EXPECT_THAT(*epicImageNames(bake.write()), ElementsAre("0", "1")) << "names that are missing, or numbers";
    EXPECT_EQ(readAll(bake.write(), imageNamed("0")).sh.width(), kUnrealWidth);
}

TEST(UnrealHq, FaultsOfTheExtensionAreNamed) {
    struct Fault {
        std::function<void(UnrealBake& bake)> make;
        const char* line;
        ErrorCode code = ErrorCode::WrongShape;
    };
    const std::vector<Fault> faults = {
        {[](UnrealBake& bake) { bake.gltf.erase("extensions"); },
         "level.gltf: found a glTF without light maps of Unreal, expected extension EPIC"},
        {[](UnrealBake& bake) { bake.gltf["extensions"]["EPIC_lightmap_textures"] = Json::object(); }, "found no list of lightmaps"},
        {[](UnrealBake& bake) {
             bake.lightMap(1)["texture"]["extensions"]["KHR_texture_transform"]["offset"] = {0.5, 0};
         },
         "lightmaps[1]: found KHR_texture_transform on the texture, expected the rectangle in coordinateScaleBias alone"},
        {[](UnrealBake& bake) { bake.lightMap(1) = 3; }, "EPIC_lightmap_textures, lightmaps[1]: found no JSON object"},
        {[](UnrealBake& bake) { bake.lightMap(1).erase("texture"); }, "lightmaps[1]: found no texture, expected one. Did Unreal's export"},
        {[](UnrealBake& bake) { bake.lightMap(1)["texture"]["index"] = 7; },
         "textures: found a reference to entry 7, expected less than 1"},
        {[](UnrealBake& bake) { bake.lightMap(1)["texture"]["index"] = -1; }, "lightmaps[1]: found index = -1, expected a whole number"},
        {[](UnrealBake& bake) { bake.gltf["textures"][0]["source"] = 7; }, "images: found a reference to entry 7, expected less than 1"},
        {[](UnrealBake& bake) { bake.gltf["textures"][0].erase("source"); },
         "textures, entry 0: found no source, expected an image in PNG"},
        {[](UnrealBake& bake) { bake.gltf["nodes"][1]["extensions"]["EPIC_lightmap_textures"]["lightmap"] = 2; },
         "nodes, entry 1: found lightmap 2 of EPIC_lightmap_textures, expected less than 2"},
        {[](UnrealBake& bake) { bake.lightMap(1).erase("lightmapScale"); },
         "lightmaps[1]: found no lightmapScale, expected four numbers from -50 to 50"},
        {[](UnrealBake& bake) {
             bake.lightMap(1)["lightmapAdd"] = {1, 2, 3};
         },
         "found lightmapAdd = [1,2,3], expected four numbers"},
        {[](UnrealBake& bake) { bake.lightMap(1)["lightmapAdd"][2] = nullptr; }, "null,"},
        {[](UnrealBake& bake) {
             bake.lightMap(1)["lightmapScale"] = {1, 2, 3, 1e200};
         },
         "found lightmapScale = [1,2,3,1e+200]"},
        {[](UnrealBake& bake) {
             bake.lightMap(1)["coordinateScaleBias"] = {1, 1, 0.5, 0};
         },
         "found coordinateScaleBias = [1,1,0.5,0], expected [scale x, scale y, bias x, bias y] of a part of the image, within [0, 1]"},
        {[](UnrealBake& bake) {
             bake.lightMap(1)["coordinateScaleBias"] = {0, 1, 0, 0};
         },
         "found coordinateScaleBias = [0,1,0,0]"},
        {[](UnrealBake& bake) { bake.lightMap(1)["coordinateScaleBias"] = bake.lightMap(0)["coordinateScaleBias"]; },
         "lightmaps[1]: found texel (1, 1) in a rectangle of lightmaps[0] too, with another lightmapScale or lightmapAdd"},
        {[](UnrealBake& bake) { bake.gltf["images"][0].erase("uri"); }, "image 0: found neither a uri nor a bufferView"},
        {[](UnrealBake& bake) { bake.gltf["images"][0]["uri"] = "absent.png"; },
         "image 0: found no readable file \"absent.png\", expected the image", ErrorCode::FileUnreadable},
        {[](UnrealBake& bake) { bake.gltf["images"][0]["uri"] = "data:image/png;base64,!"; }, "image 0: found a data URI that is broken",
         ErrorCode::FileUnreadable},
        {[](UnrealBake& bake) { bake.gltf["images"][0]["uri"] = "level.gltf"; }, "image 0: found an image of another kind, expected PNG",
         ErrorCode::FormatUnsupported},
        {[](UnrealBake& bake) { bake.gltf["images"][0]["uri"] = 5; }, "found JSON of another shape"},
        {[](UnrealBake& bake) { bake.image.writeTo(bake.folder / "light map.png", 3); },
         "image 0: found 3 channels, expected R, G, B and A: the logarithm of the light is in alpha"},
        {[](UnrealBake& bake) { writePng(bake.folder / "light map.png", 8, 7, 4, [](int, int, int) { return 9; }); },
         "image 0: found a height of 7 texels, expected an even one"},
        {[](UnrealBake& bake) { writeContent(bake.folder / "light map.png", bake.png().substr(0, 900)); },
         "level.gltf, image 0: found a damaged PNG (\"it ends too early\"), expected a whole image file", ErrorCode::FileUnreadable},
        {[](UnrealBake& bake) { setByte(bake.folder / "light map.png", 900, 'x'); },
         "image 0: found a damaged PNG (\"IDAT: incorrect data check\")", ErrorCode::FileUnreadable},
    };
    for (const Fault& fault : faults) {
        UnrealBake bake;
        fault.make(bake);
        const Error error = refusal(bake.write());
        EXPECT_EQ(error.code, fault.code) << error.line();
        EXPECT_THAT(error.line(), AllOf(HasSubstr("level.gltf"), HasSubstr(fault.line), testing::Not(HasSubstr("\n"))));
    }
}

TEST(UnrealHq, HostileFilesAreRefusedQuickly) {
    UnrealBake bake;
    const auto refusalOf = [&](const std::string& text) {
        writeContent(bake.folder / "hostile.gltf", text);
        const auto start = std::chrono::steady_clock::now();
        const Error error = refusal(bake.folder / "hostile.gltf");
        EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
        return error.line();
    };
    EXPECT_THAT(refusalOf(R"({"asset":{"version":"2.0"},"extensions":)" + std::string(100000, '[')),
                HasSubstr("nested more than 256 deep"));
    EXPECT_THAT(refusalOf(R"({"lightmapScale":[NaN]})"), HasSubstr("found no JSON object, expected a glTF 2.0 file"));
    EXPECT_THAT(refusalOf(""), HasSubstr("hostile.gltf"));
    // A rectangle of the whole image for each of 10,000 meshes, and as many images as meshes.
    const Json first = bake.lightMap(0);
    Json& lightMaps = bake.gltf["extensions"]["EPIC_lightmap_textures"]["lightmaps"];
    Json many = Json::array(), images = Json::array(), textures = Json::array();
    for (int i = 0; i < 10000; ++i) {
        many.push_back(first);
        many.back()["coordinateScaleBias"] = {1 - 1e-9 * i, 1, 0, 0};
        images.push_back(bake.gltf["images"][0]);
        textures.push_back({{"source", i}});
    }
    lightMaps = many;
    EXPECT_THAT(refusalOf(bake.gltf.dump()), HasSubstr("expected at most 16 times the 40 x 24 of the light map"));
    for (int i = 0; i < 10000; ++i) lightMaps[static_cast<std::size_t>(i)]["texture"]["index"] = i;
    bake.gltf["images"] = images;
    bake.gltf["textures"] = textures;
    EXPECT_THAT(refusalOf(bake.gltf.dump()), AllOf(HasSubstr("found 10000 light maps"), HasSubstr("or 9992 more")));
    // A PNG of a few bytes that claims 65536 x 65536 texels.
    std::string header = bigEndian(65536) + bigEndian(65536);
    for (const int byte : {8, 6, 0, 0, 0}) header += static_cast<char>(byte);
    writeContent(bake.folder / "light map.png", "\x89PNG\r\n\x1a\n" + pngChunk("IHDR", header) + pngChunk("IEND", ""));
    lightMaps = Json::array({first});
    bake.gltf.erase("nodes");
    testing::internal::CaptureStderr();
    EXPECT_THAT(refusalOf(bake.gltf.dump()),
                HasSubstr("image 0: found a damaged PNG (\"IEND: out of place\"), expected a whole image file"));
    // The same with a chunk of texels, which are far too few.
    writeContent(bake.folder / "light map.png",
                 "\x89PNG\r\n\x1a\n" + pngChunk("IHDR", header) + pngChunk("IDAT", "few") + pngChunk("IEND", ""));
    EXPECT_THAT(refusalOf(bake.gltf.dump()), HasSubstr("image 0: found"));
    // And chunks in another order.
    writeContent(bake.folder / "light map.png",
                 "\x89PNG\r\n\x1a\n" + pngChunk("IDAT", "few") + pngChunk("IHDR", header) + pngChunk("IEND", ""));
    EXPECT_THAT(refusalOf(bake.gltf.dump()),
                HasSubstr("image 0: found a damaged PNG (\"IDAT: Missing IHDR before IDAT\"), expected a whole image file"));
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "no library prints a line of its own";
}

TEST(UnrealHq, AMeshWithUvsOfItsOwnIsRefused) {
    UnrealBake bake;
    const std::filesystem::path other = bake.folder / "map.exr";
    const auto check = [&](const std::filesystem::path& lightMap) {
        const auto checked = checkEpicUvs(lightMap, bake.write(), "");
        return checked ? std::string() : checked.error().line();
    };
    const std::filesystem::path level = bake.folder / "level.gltf";
    EXPECT_EQ(check(level), "") << "nodes that draw nothing";
    for (Json& node : bake.gltf["nodes"]) node["mesh"] = 0;
    EXPECT_THAT(check(level), AllOf(HasSubstr("level.gltf, node 0 'Wall_0': found coordinateScaleBias [0.45, 0.9166666666666666, 0.025, "),
                                    HasSubstr("expected [1, 1, 0, 0]. Remove `mesh`; or write these UVs over the whole light map into "
                                              "TEXCOORD_1")));
    EXPECT_EQ(check(other), "") << "a light map whose UVs are TEXCOORD_1";
    for (std::size_t i = 0; i < 2; ++i) bake.lightMap(i)["coordinateScaleBias"] = {1, 1, 0, 0};
    EXPECT_EQ(check(level), "");
    bake.lightMap(1)["texture"].erase("texCoord");
    EXPECT_THAT(check(level), HasSubstr("node 1 'Wall_1': found texCoord 0 of a node of `mesh`, expected 1"));
    bake.gltf["nodes"][1].erase("extensions");
    EXPECT_THAT(check(level), HasSubstr("node 1 'Wall_1': found no light map of a node of `mesh`, expected one for every node that draws"));
    bake.gltf.erase("extensions");
    bake.gltf["nodes"][0].erase("extensions");
    EXPECT_EQ(check(level), "") << "a mesh that was prepared";
}

}  // namespace
}  // namespace lightcook::formats
