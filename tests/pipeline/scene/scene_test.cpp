#include "pipeline/scene/scene.h"
#include "pipeline/document/byte_count.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "pipeline/scene/checks.h"
#include "pipeline/scene/settings.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using testing::HasSubstr;

formats::Result<Scene> sceneFromText(const std::string& text) {
    const formats::TemporaryFolder folder;
    formats::writeContent(folder / "scene.toml", text);
    return readScene(folder / "scene.toml");
}

const std::string kHead = "schema = 1\nname = \"s\"\n";

void expectRefused(const std::string& text, const std::string& place, const std::string& found) {
    const auto scene = sceneFromText(text);
    ASSERT_FALSE(scene.has_value()) << text;
    EXPECT_EQ(scene.error().code, ErrorCode::InvalidRequest);
    EXPECT_THAT(scene.error().subject, HasSubstr(place.empty() ? "scene.toml" : "scene.toml:" + place));
    EXPECT_THAT(scene.error().detail, HasSubstr(found));
    EXPECT_EQ(scene.error().line().find('\n'), std::string::npos) << "one line";
}

TEST(ReadScene, AMessageLeavesOutTheMiddleOfALongValue) {
    std::string value;
    for (int i = 0; i < 5000; ++i) value += "\u00e9";
    const auto scene = sceneFromText(kHead + "lobe = \"" + value + "\"\n");
    ASSERT_FALSE(scene);
    EXPECT_LT(scene.error().detail.size(), 1100u);
    EXPECT_THAT(scene.error().detail, testing::StartsWith("found '\u00e9"));
    EXPECT_THAT(scene.error().detail, testing::HasSubstr("\u00e9 ... \u00e9")) << "whole characters";
    EXPECT_THAT(scene.error().detail, testing::EndsWith("expected one of: beckmann, ggx, phong, phong-power"));
}

TEST(ReadScene, TablesHaveASectionOfTheirOwn) {
    const auto scene = sceneFromText(kHead + R"toml(lobe = "ggx"
[tables]
views = 12
rows = 6
normalization = "halo3"
view_axis = "NoV"
roughness_axis = "sqrt(m)"
)toml");
    ASSERT_TRUE(scene.has_value()) << scene.error().line();
    EXPECT_EQ(scene->tables.viewCount, 12);
    EXPECT_EQ(viewCountOf(scene->tables), 12);
    EXPECT_EQ(scene->tables.roughnessCount, 6);
    EXPECT_EQ(scene->lobe, lighting::SpecularLobe::Ggx);
    EXPECT_EQ(scene->tables.normalization, "halo3");
    EXPECT_EQ(scene->tables.viewAxis, "NoV");
    EXPECT_EQ(scene->tables.roughnessAxis, "sqrt(m)");
    EXPECT_EQ(sceneFromText(kHead)->tables.viewAxis, "auto");
    expectRefused(kHead + "[tables]\nlobe = \"ggx\"\n", "4:1", "found the key 'lobe' in tables, expected it before the first table");
    for (const char* lobe : {"blinn", "GGX"}) {
        const auto other = sceneFromText(kHead + "lobe = \"" + lobe + "\"\n");
        ASSERT_FALSE(other);
        EXPECT_EQ(other.error().detail, fmt::format("found '{}' for lobe, expected one of: beckmann, ggx, phong, phong-power", lobe));
    }
    expectRefused(kHead + "[tables]\nrow = 3\n", "4:1", "nearest is 'rows'");
    expectRefused(kHead + "[tables]\nview_axes = \"NoV\"\n", "4:1", "nearest is 'view_axis'");
    expectRefused(kHead + "[tables]\nviews = 1\n", "4:9", "expected an integer from 2 to 1024");
    expectRefused(kHead + "[tables]\nrows = 2000\n", "4:8", "expected an integer from 1 to 1024");
    expectRefused(kHead + "[tables]\nview_axis = \"m\"\n", "4:13", "expected one of: ");
}

TEST(ReadScene, ASectionThatIsNoTableIsRefused) {
    for (const KeyTable& table : sceneKeyTables())
        if (!table.name.empty() && table.name.find('.') == std::string_view::npos) {
            expectRefused(fmt::format("{}{} = 3\n", kHead, table.name), "3:", "expected ");
            expectRefused(fmt::format("{}{} = [3]\n", kHead, table.name), "3:", "expected ");
            EXPECT_TRUE(!sceneFromText(fmt::format("{}{} = []\n", kHead, table.name)) || table.isArray) << table.name;
        }
    expectRefused(kHead + "output = 3\n", "3:10", "expected a table [output]");
}

TEST(ReadScene, AnEmptyPathIsRefused) {
    expectRefused(kHead + "[[probe]]\nname = \"p\"\nfile = \"\"\n", "5:8", "found an empty path for probe.file, expected a path");
    expectRefused(kHead + "[[light_map]]\nname = \"m\"\nfile = \"m.exr\"\nmesh = \"\"\n", "6:8",
                  "found an empty path for light_map.mesh, expected a path");
}

TEST(ReadScene, TheFixedNamesAreUnderstood) {
    const auto scene = sceneFromText(R"(
schema = 1
name = "cornell"
[output]
target = "astc"
max_error = 0.02
budget = "2 MiB"
[color]
source = "acescg"
working = "lin_rec709"
[[light_map]]
name = "lightmap"
file = "maps/a.exr"
bake = "sh9"
phase = "condon-shortley"
frame = "tangent"
quantity = "irradiance"
light_units = "game"
mesh = "a.glb"
dominant_fit = "refined-ambient"
[[probe]]
name = "probe0"
file = "p.exr"
sh = "p.json"
[[probe]]
name = "probe1"
file = "q.exr"
size = 1024
layout = "prefiltered"
[[gradient]]
name = "sky"
file = "g.exr"
exponents = [1, 4, 16]
[[gradient]]
name = "sun"
file = "s.exr"
format = "rgb9e5"
[[material]]
name = "*"
normal_map = true
specular = false
m = [0.1, 0.5]
f0 = [0.04, 0.6]
)");
    ASSERT_TRUE(scene.has_value()) << scene.error().line();
    EXPECT_EQ(scene->output.target, Target::Astc);
    EXPECT_EQ(scene->output.limits[Limit::Error], 0.02);
    EXPECT_EQ(scene->output.budgetBytes, 2u << 20);
    ASSERT_EQ(scene->lightMaps.size(), 1u);
    EXPECT_EQ(scene->lightMaps[0].file, scene->directory / "maps/a.exr");
    EXPECT_EQ(scene->lightMaps[0].description.phase, formats::ShPhase::CondonShortley);
    EXPECT_EQ(scene->lightMaps[0].description.frame, formats::ShFrame::Tangent);
    EXPECT_EQ(scene->lightMaps[0].description.quantity, formats::ShQuantity::Irradiance);
    EXPECT_EQ(scene->lightMaps[0].description.lightUnits, formats::LightUnits::Game);
    EXPECT_EQ(scene->lightMaps[0].description.colors.source, "acescg");
    EXPECT_EQ(scene->lightMaps[0].mesh, scene->directory / "a.glb");
    EXPECT_EQ(scene->lightMaps[0].dominantFit, "refined-ambient");
    EXPECT_EQ(scene->probes[0].sh, scene->directory / "p.json");
    EXPECT_EQ(scene->probes[0].size, 128);
    EXPECT_TRUE(scene->probes[0].readLevelsOnly);
    EXPECT_EQ(scene->probes[0].layout, "pre-divided");
    EXPECT_EQ(scene->probes[1].size, 1024);
    EXPECT_EQ(scene->probes[1].readLevelsOnly, false);
    EXPECT_EQ(scene->probes[1].layout, "prefiltered");
    EXPECT_EQ(scene->gradients[0].exponents, (std::vector<double>{1, 4, 16}));
    EXPECT_EQ(scene->gradients[0].format, "");
    EXPECT_EQ(scene->gradients[1].format, "rgb9e5");
    EXPECT_EQ(scene->materials[0].specular, false);
    EXPECT_EQ(scene->materials[0].m->high, 0.5);
}

TEST(ReadScene, ALightMapMayBeEncoded) {
    const std::string map = kHead + "[[light_map]]\nname = \"a\"\nfile = \"a.png\"\n";
    EXPECT_EQ(sceneFromText(map)->lightMaps[0].description.encoding, formats::LightEncoding::Auto);
    EXPECT_EQ(sceneFromText(map + "encoding = \"none\"\n")->lightMaps[0].description.encoding, formats::LightEncoding::None);
    EXPECT_EQ(sceneFromText(map + "encoding = \"rgbm\"\n")->lightMaps[0].description.encoding, formats::LightEncoding::Rgbm);
    EXPECT_EQ(sceneFromText(map + "encoding = \"dldr\"\n")->lightMaps[0].description.encoding, formats::LightEncoding::Dldr);
    expectRefused(map + "encoding = \"rgbd\"\n", "6:12",
                  "found 'rgbd' for light_map.encoding, expected one of: auto, none, rgbm, dldr, srgb");
}

TEST(ReadScene, ALightMapMayListItsImages) {
    const std::string map = kHead + "[[light_map]]\nname = \"a\"\n";
    const std::string rest = "sh01 = \"1.exr\", sh02 = \"2.exr\", sh03 = \"3.exr\" }\n";
    const auto scene = sceneFromText(map + "files = { sh00 = { R = \"r.exr\", G = \"g.exr\", B = \"b.exr\" }, " + rest);
    ASSERT_TRUE(scene) << scene.error().line();
    const LightMapEntry& entry = scene->lightMaps[0];
    EXPECT_EQ(entry.description.parts, (std::vector<std::string>{"sh00.B", "sh00.G", "sh00.R", "sh01", "sh02", "sh03"}));
    EXPECT_EQ(entry.description.partFiles.at("sh02"), scene->directory / "2.exr");
    EXPECT_EQ(entry.file, scene->directory / "r.exr");
    expectRefused(map + "files = { " + rest, "5:", "found no sh00, expected sh00 to sh03");
    expectRefused(map + "files = { sh00 = 3, " + rest, "5:18", "found the integer 3 for light_map.files.sh00, expected a path");
    expectRefused(map + "files = { sh00 = { X = \"x.exr\" }, " + rest, "5:", "found 'sh00.X'");
    expectRefused(map + "files = \"a.exr\"\n", "5:9", "expected a table");
    expectRefused(map + "file = \"a.exr\"\nfiles = { sh00 = \"0.exr\", " + rest, "6:9", "beside light_map.file");
    expectRefused(map + "bake = \"sh9\"\nfiles = { sh00 = \"0.exr\", " + rest, "6:9", "images of bake format sh4 beside bake = \"sh9\"");
    EXPECT_TRUE(sceneFromText(map + "bake = \"sh4\"\nfiles = { sh00 = \"0.exr\", " + rest));
}

TEST(ReadScene, TheBakeFormatIsNoLayout) {
    const std::string map = kHead + "[[light_map]]\nname = \"a\"\nfile = \"a.exr\"\n";
    EXPECT_EQ(sceneFromText(map)->lightMaps[0].description.bake, "auto");
    EXPECT_EQ(sceneFromText(map + "bake = \"sh9\"\n")->lightMaps[0].description.bake, "sh9");
    expectRefused(map + "bake = \"sh10\"\n", "6:8", "found 'sh10' for light_map.bake, expected one of: auto, sh9");
    expectRefused(map + "layout = \"sh9\"\n", "6:1",
                  "found unknown key 'layout' in light_map, expected one of its keys; nearest is 'layouts'");
    expectRefused(map + "bake = \"basis-4\"\n", "6:8",
                  "found the GPU layout 'basis-4' for light_map.bake, which is the bake format of the file, expected "
                  "light_map_layout = \"basis-4\" in [output], or layouts = [\"basis-4\"] here");
}

TEST(ReadScene, AnUnknownKeyIsRefusedWithItsPlaceAndTheNearestKnownOne) {
    expectRefused(kHead + "[output]\ntargt = \"bc\"\n", "4:1", "unknown key 'targt' in output");
    expectRefused(kHead + "[output]\ntargt = \"bc\"\n", "4:1", "nearest is 'target'");
    expectRefused(kHead + "[[light_map]]\nname = \"a\"\nfile = \"a.exr\"\nphse = \"none\"\n", "6:1", "nearest is 'phase'");
    expectRefused(kHead + "[[lightmap]]\nname = \"a\"\n", "3:", "nearest is 'light_map'");
    expectRefused(kHead + "[output]\ntarget = \"atsc\"\n", "4:10", "expected one of: bc, astc, float; nearest is 'astc'");
    expectRefused(kHead + "[display]\nbrightness = 1\n", "4:1", "in display, expected one of its keys: ");
}

TEST(ReadScene, AKeyOfAnotherTableIsToldWhereItBelongs) {
    expectRefused(kHead + "[[light_map]]\nmax_error = 0.1\n", "4:1", "found the key 'max_error' in light_map, expected it in [output]");
    expectRefused("max_error = 0.1\n" + kHead, "1:1", "found the key 'max_error' in the scene, expected it in [output]");
    expectRefused(kHead + "[output]\nlobe = \"ggx\"\n", "4:1", "expected it before the first table");
    expectRefused(kHead + "[output]\nlayout = \"basis-4\"\n", "4:1", "expected one of its keys; nearest is 'layouts'");
}

TEST(ReadScene, WrongValuesAreRefusedWithFoundAndExpected) {
    expectRefused(kHead + "[[light_map]]\nname = \"a\"\nfile = \"a.exr\"\ndominant_fit = \"best\"\n",
                  "6:", "expected one of: explained, halo3, refined, refined-ambient");
    expectRefused(kHead + "[[light_map]]\nname = \"a\"\nfile = \"a.exr\"\ndominant_layout = \"third\"\n",
                  "6:", "expected one of: full, derived, none");
    expectRefused(kHead + "[[light_map]]\nname = \"a\"\nfile = \"a.exr\"\ndominant_layout = \"none\"\ndominant_fit = \"halo3\"\n", "7:16",
                  "found light_map.dominant_fit beside dominant_layout = \"none\", expected one of them");
    expectRefused(kHead + "[output]\ngltf = true\n[[light_map]]\nname = \"a\"\nfile = \"a.exr\"\n", "4:8",
                  "found output.gltf where no light map has a mesh, expected mesh = \"FILE\" in a [[light_map]]");
    for (const char* axes : {"x,y,y", "x,y", "north"})
        expectRefused(kHead + "[[light_map]]\nname = \"a\"\nfile = \"a.exr\"\naxes = \"" + axes + "\"\n", "6:8",
                      "expected x, y and z once each, with or without a minus");
    expectRefused(kHead + "[[light_map]]\nname = \"a\"\nfile = \"a.exr\"\nlmbake = \"a.lmbake\"\n", "6:10",
                  "found light_map.lmbake without a mesh for 'a'");
    for (const char* limit : {"0.5", "-1", "nan", "inf"})
        expectRefused(kHead + "[[light_map]]\nname = \"a\"\nfile = \"a.exr\"\nfirefly_limit = " + limit + "\n",
                      "6:", "expected a number from 1, or 0 for no check");
    expectRefused("schema = 2\nname = \"s\"\n", "1:", "found 2 for schema, expected schema = 1");
    expectRefused("name = \"s\"\n", "1:", "found no key 'schema'");
    expectRefused(kHead + "[output]\ntarget = \"etc2\"\n", "4:10", "found 'etc2' for output.target, expected one of: bc, astc, float");
    expectRefused(kHead + "[output]\nmax_error = -1\n", "4:", "found -1 for output.max_error");
    expectRefused(kHead + "[output]\nmax_error = nan\n", "4:", "expected a positive fraction");
    expectRefused(kHead + "[output]\nbudget = \"2 MiBs\"\n", "4:", "found '2 MiBs'");
    expectRefused(kHead + "[output]\neffort = 10\n", "4:", "found 10 for output.effort");
    expectRefused(kHead + "[output]\ntarget = \"float\"\neffort = 5\n", "5:", "found output.effort with target = \"float\"");
    expectRefused(kHead + "[output]\ncontainer = \"dds\"\nzstd = true\n", "5:", "DDS has no supercompression");
    expectRefused(kHead + "[[material]]\nname = \"*\"\nm = [0.5, 0.1]\n", "5:", "expected [low, high]");
    expectRefused(kHead + "[[gradient]]\nname = \"g\"\nfile = \"g.exr\"\naxis = [0, 0, 0]\n",
                  "6:", "a direction [x, y, z] other than zero");
    expectRefused(kHead + "[[gradient]]\nname = \"g\"\nfile = \"g.exr\"\nzones = 64\n", "6:", "zones without an axis");
    expectRefused(kHead + "[[gradient]]\nname = \"g\"\nfile = \"g.exr\"\naxis = [0, 1, 0]\nzones = 5000\n",
                  "7:", "expected an integer from 1 to 4096");
    expectRefused(kHead + "[[gradient]]\nname = \"g\"\nfile = \"g.exr\"\naxis = [0, 1, 0]\nencoding = \"srgb\"\n",
                  "7:", "painted gradients alone");
    expectRefused(kHead + "[[gradient]]\nname = \"g\"\nfile = \"g.exr\"\nformat = \"bc5\"\n",
                  "6:", "rgba8, bc7, bc4, bc6h, rgb9e5, rgba16f, auto");
    for (const char* size : {"15", "0", "-16", "100", "4096", "8"})
        expectRefused(kHead + "[[probe]]\nname = \"p\"\nfile = \"p.exr\"\nsize = " + size + "\n",
                      "6:", "expected a power of two from 16 to 2048");
    expectRefused(kHead + "[[probe]]\nname = \"p\"\nfile = \"p.exr\"\nlayout = \"plain\"\n", "6:", "pre-divided, prefiltered");
    expectRefused(kHead + "[[gradient]]\nname = \"g\"\nfile = \"g.exr\"\nexponents = [0.5]\n", "6:", "increasing Phong exponents");
    expectRefused(kHead + "[[light_map]]\nname = \"m\"\nfile = \"m.exr\"\ncoverage = \"mesh\"\n",
                  "6:", "found coverage \"mesh\" for a light map without a mesh");
    expectRefused(kHead + "[[probe]]\nname = \"../p\"\nfile = \"p.exr\"\n", "4:", "found the name '../p'");
    expectRefused(kHead + "[[probe]]\nname = \"p\"\nfile = 3\n", "5:", "found the integer 3 for probe.file, expected a path");
    expectRefused(kHead + "[output\n", "3:", "syntax error");
}

TEST(ReadScene, BooleansAreNoNumbers) {
    expectRefused("schema = true\nname = \"s\"\n", "1:10", "found true (a boolean) for schema, expected schema = 1");
    expectRefused(kHead + "[output]\neffort = true\n", "4:10", "found true (a boolean) for output.effort, expected an integer from 0 to 9");
    expectRefused(kHead + "[output]\nmax_error = true\n", "4:13", "found true (a boolean) for output.max_error");
    expectRefused(kHead + "[output]\nmax_visible = false\n", "4:15", "found false (a boolean) for output.max_visible");
    expectRefused(kHead + "[[probe]]\nname = \"p\"\nfile = \"p.exr\"\nsize = true\n", "6:8", "found true (a boolean) for probe.size");
    expectRefused(kHead + "[[probe]]\nname = \"p\"\nfile = \"p.exr\"\nposition = [1, true, 2]\n", "6:16",
                  "found true (a boolean) in probe.position");
}

TEST(ReadScene, ThePlaceOfAProbeIsRefusedByItsValue) {
    const std::string probe = kHead + "[[probe]]\nname = \"p\"\nfile = \"p.exr\"\n";
    expectRefused(probe + "radius = -1\n", "6:10", "found -1 for probe.radius, expected a positive radius");
    expectRefused(probe + "radius = inf\n", "6:10", "found inf for probe.radius, expected a positive radius");
    expectRefused(probe + "box = [0, 0, 0, 1, -2, 1]\n", "6:7",
                  "found [0, 0, 0, 1, -2, 1] for probe.box, expected the corners [x, y, z, X, Y, Z] of a box, the lowest first");
}

TEST(ReadScene, SettingsThatNoFileCanHaveAreRefused) {
    expectRefused(kHead + "[output]\ntarget = \"astc\"\ncontainer = \"dds\"\n", "5:13",
                  "found container dds with target astc, expected container ktx2: DDS has no ASTC formats");
    EXPECT_TRUE(sceneFromText(kHead + "[output]\ntarget = \"float\"\ncontainer = \"dds\"\n"));
    expectRefused(kHead + "[color]\nsource = \"\"\n", "4:10", "found an empty text for color.source, expected the name of a colour space");
    expectRefused(kHead + "[color]\nworking = \"\"\n", "4:11", "found an empty text for color.working");
}

TEST(ReadScene, ColourSpacesThatNoneHasAreRefusedWhereTheyAreWritten) {
    expectRefused(kHead + "[color]\nsource = \"lin_rec708\"\n", "4:10, color.source, colour space 'lin_rec708'",
                  "found no such space in the built-in config, expected one it knows; nearest is 'lin_rec709'");
    expectRefused(kHead + "[color]\nsource = \"acescg\"\nworking = \"asescg\"\n", "5:11, color.working, colour space 'asescg'",
                  "nearest is 'acescg'");
    expectRefused(kHead + "[color]\nworking = \"srgb\"\n", "4:11, color.working, colour space 'srgb_texture' is not linear",
                  "by proportion");
    EXPECT_TRUE(sceneFromText(kHead + "[color]\nsource = \"lin_ap1\"\nworking = \"lin_rec2020\"\n")) << "an alias";
    EXPECT_TRUE(sceneFromText(kHead + "[color]\nsource = \"plate\"\nconfig = \"none.ocio\"\n")) << "the config is an input of the cook";
}

double converterErrorOf(const OutputSettings& output) {
    return converterLimits(output, kDefaultMaxError)[Limit::Error].value_or(0);
}

TEST(ReadScene, FractionsMayBePercentages) {
    const auto scene = sceneFromText(kHead + "[output]\nmax_error = \"2%\"\nmax_converter_error = \"0.5 %\"\nrdo = \"1.5%\"\n");
    ASSERT_TRUE(scene.has_value()) << scene.error().line();
    EXPECT_DOUBLE_EQ(scene->output.limits[Limit::Error].value_or(0), 0.02);
    EXPECT_DOUBLE_EQ(converterErrorOf(scene->output), 0.005) << "a limit that is given is the limit, also below max_error";
    EXPECT_DOUBLE_EQ(scene->output.rdo, 0.015);
    expectRefused(kHead + "[output]\nmax_error = \"0.02\"\n", "4:13", "found the string '0.02'");
    expectRefused(kHead + "[output]\nmax_error = \"-2%\"\n", "4:13", "expected a positive fraction: 0.02, or \"2%\"");
    for (const auto& [text, value] : {std::pair("0.02", 0.02), std::pair("2%", 0.02), std::pair("2 %", 0.02), std::pair("1e-3", 1e-3)})
        EXPECT_EQ(parseFraction(text), value) << text;
    for (const char* text : {"", "%", "2%%", "two", "2 % ", "nan", "inf", "0.02x", " %"}) EXPECT_FALSE(parseFraction(text)) << text;
}

TEST(ReadScene, ALimitOfConvertersIsTheirOwn) {
    const auto limitOf = [](const std::string& output) { return converterErrorOf(sceneFromText(kHead + "[output]\n" + output)->output); };
    EXPECT_EQ(limitOf(""), 0.1);
    EXPECT_EQ(limitOf("max_error = 0.01"), 0.1);
    EXPECT_EQ(limitOf("max_error = 0.3"), 0.3);
    EXPECT_EQ(limitOf("max_error = 0.3\nmax_converter_error = 0.05"), 0.05);
}

TEST(ReadScene, KeepsTheLinesOfTablesAndKeys) {
    const auto scene = sceneFromText(kHead +
                                     "\n[output]\nmax_error = 0.1\n\n[[light_map]]\nname = \"a\"\nfile = \"a.exr\"\n\n[[light_map]]\n"
                                     "name = \"b\"\nfile = \"b.exr\"\n");
    ASSERT_TRUE(scene.has_value()) << scene.error().line();
    EXPECT_EQ(scene->lines.find(""), 1);
    EXPECT_EQ(scene->lines.find("", "", "name"), 2);
    EXPECT_EQ(scene->lines.find("output"), 4);
    EXPECT_EQ(scene->lines.find("output", "", "max_error"), 5);
    EXPECT_EQ(scene->lines.find("output", "", "budget"), 4) << "the table of a key that is not there";
    EXPECT_EQ(scene->lines.find("light_map", "a"), 7);
    EXPECT_EQ(scene->lines.find("light_map", "b", "file"), 13);
    EXPECT_FALSE(scene->lines.find("probe", "c"));
}

TEST(ReadScene, TwoAssetsOfOneNameAreRefused) {
    expectRefused(kHead + "[[probe]]\nname = \"a\"\nfile = \"a.exr\"\n[[gradient]]\nname = \"a\"\nfile = \"b.exr\"\n", "7:8",
                  "found the name 'a' twice, expected a name of its own for every light map, probe and gradient: the first is in line 4");
}

std::string probeNamed(const std::string& name) {
    return "[[probe]]\nname = \"" + name + "\"\nfile = \"" + name + ".exr\"\n";
}

/// Their files would be one on Windows and macOS.
TEST(ReadScene, NamesThatDifferInCaseAloneAreRefused) {
    expectRefused(kHead + probeNamed("Room") + "[[gradient]]\nname = \"room\"\nfile = \"b.exr\"\n", "7:8",
                  "found the names 'Room' in line 4 and 'room', expected names that differ in more than the case of letters");
    expectRefused(kHead + probeNamed("p1") + probeNamed("P1"), "7:8", "found the names 'p1' in line 4 and 'P1'");
    expectRefused(kHead + probeNamed("Specular"), "4:8", "found the reserved name 'Specular', expected another one");
    EXPECT_TRUE(sceneFromText(kHead + probeNamed("Room") + probeNamed("Room2")));
}

TEST(ReadScene, NamesThatWindowsReservesAreRefused) {
    for (const char* name : {"con", "NUL", "aux", "Prn", "com1", "LPT9", "nul.v2", "com3.exr", "room."}) {
        expectRefused(kHead + probeNamed(name), "4:8",
                      fmt::format("found the name '{}', expected another one: Windows has no files", name));
        expectRefused(fmt::format("schema = 1\nname = \"{}\"\n", name), "2:8", "Windows");
    }
    for (const char* name : {"console", "com", "com0", "com10", "lpt", "nul_1", "room.con", "a.b"})
        EXPECT_TRUE(sceneFromText(kHead + probeNamed(name))) << name;
}

/// The system would open the file of the part before it. Line ends and the like may stand in names.
TEST(ReadScene, PathsWithACharacterZeroAreRefused) {
    expectRefused(kHead + "[[probe]]\nname = \"p\"\nfile = \"p.exr\\u0000\"\n", "5:8",
                  std::string("found a character 0 in the path 'p.exr") + '\0' + "' for probe.file, expected none");
    expectRefused(kHead + "[[probe]]\nname = \"p\"\nfile = \"p.exr\"\nsh = \"a\\u0000b.json\"\n", "6:6", "for probe.sh, expected none");
    expectRefused(kHead + "[[light_map]]\nname = \"m\"\nfiles = { sh00 = \"a.exr\", sh01 = \"b\\u0000.exr\" }\n",
                  "5:", "for light_map.files.sh01, expected none");
    EXPECT_TRUE(sceneFromText(kHead + "[[probe]]\nname = \"p\"\nfile = \"caf\u00e9\\n1.exr\"\n"));
    // What another system or a shell would take for a folder is none here.
    const char* const home = std::getenv("HOME");
    expectRefused(kHead + "[[probe]]\nname = \"p\"\nfile = \"~/p.exr\"\n", "5:8",
                  fmt::format("expected the folder itself: {}/p.exr", home != nullptr && *home != 0 ? home : "/home/NAME"));
    EXPECT_TRUE(sceneFromText(kHead + "[[probe]]\nname = \"p\"\nfile = \"./~/p.exr\"\n"));
    expectRefused(kHead + "[[probe]]\nname = \"p\"\nfile = 'maps\\p.exr'\n", "5:8", "expected '/' between folders: maps/p.exr");
    expectRefused(kHead + "[[probe]]\nname = \"p\"\nfile = \"maps\\p.exr\"\n", "5:", "write '/' between the folders of a path");
}

/// Squares of the components would be 0 or infinite.
TEST(ReadScene, AnAxisOfAnyLengthIsADirection) {
    const auto axisOf = [](const std::string& axis) {
        const auto scene = sceneFromText(kHead + "[[gradient]]\nname = \"g\"\nfile = \"g.exr\"\naxis = " + axis + "\n");
        EXPECT_TRUE(scene) << (scene ? "" : scene.error().line());
        return scene ? *scene->gradients.at(0).axis : glm::dvec3(0);
    };
    EXPECT_EQ(axisOf("[1e-300, 0, 0]"), glm::dvec3(1, 0, 0));
    EXPECT_EQ(axisOf("[0, -5e-324, 0]"), glm::dvec3(0, -1, 0));
    for (const char* diagonal : {"[1e200, 1e200, 0]", "[1e308, 1e308, 0]", "[3, 3, 0]"}) {
        const glm::dvec3 axis = axisOf(diagonal);
        EXPECT_NEAR(axis.x, std::sqrt(0.5), 1e-15) << diagonal;
        EXPECT_NEAR(axis.y, std::sqrt(0.5), 1e-15) << diagonal;
        EXPECT_EQ(axis.z, 0) << diagonal;
    }
}

TEST(ReadScene, TwoTablesOfOneMaterialAreRefused) {
    const std::string any = "[[material]]\nname = \"*\"\nspecular = true\n", gold = "[[material]]\nname = \"gold\"\n";
    EXPECT_TRUE(sceneFromText(kHead + any + gold));
    EXPECT_TRUE(sceneFromText(kHead + gold + "[[material]]\nname = \"Gold\"\n")) << "names of a glTF may differ in case";
    expectRefused(kHead + any + gold + any, "9:8",
                  "found the material '*' twice, expected one table [[material]] of that name: the first is in line 3");
    expectRefused(kHead + gold + gold, "6:8", "found the material 'gold' twice");
}

TEST(ReadScene, AnAllowanceNamesAnAssetOfTheScene) {
    const auto allowing = [](const std::string& asset, const std::string& assets) {
        return "allow = [{ code = \"missing-coverage\", asset = \"" + asset + "\" }]\n" + kHead + assets;
    };
    const std::string map = "[[light_map]]\nname = \"lobby1\"\nfile = \"a.exr\"\n";
    const std::string assets = map + probeNamed("hall") + "[[gradient]]\nname = \"sky\"\nfile = \"g.exr\"\n";
    for (const char* known : {"lobby1", "hall", "sky"}) {
        const auto scene = sceneFromText(allowing(known, assets));
        ASSERT_TRUE(scene) << scene.error().line();
        EXPECT_EQ(scene->allowances.at(0).asset, known);
    }
    EXPECT_EQ(sceneFromText(allowing("", assets))->allowances.at(0).asset, "") << "all of them";
    expectRefused(allowing("lobby", assets), "1:47",
                  "found the asset 'lobby' in allow, expected a light map, probe or gradient of this scene; nearest is 'lobby1'");
    expectRefused(allowing("lobby1_dominant", assets), "1:47", "nearest is 'lobby1'");
    expectRefused(allowing("lobby", "[[material]]\nname = \"*\"\n"), "1:47", "of this scene, which has none");
}

TEST(ReadScene, AMissingFileIsABadSceneFile) {
    const auto scene = readScene("/nowhere/scene.toml");
    ASSERT_FALSE(scene.has_value());
    EXPECT_EQ(scene.error().code, ErrorCode::InvalidRequest);
    EXPECT_THAT(scene.error().subject, HasSubstr("/nowhere/scene.toml"));
}

TEST(ParseByteCount, UnitsAreWhatTheySay) {
    EXPECT_EQ(parseByteCount("4096", ""), 4096u);
    EXPECT_EQ(parseByteCount("2 MiB", ""), 2u << 20);
    EXPECT_EQ(parseByteCount("1.5 GB", ""), 1'500'000'000u);
    EXPECT_EQ(parseByteCount("512KiB", ""), 512u << 10);
    for (const char* bad : {"", "MiB", "-1", "1 mib", "1e30 GiB", "nan", "2 MiB x"})
        EXPECT_FALSE(parseByteCount(bad, "budget").has_value()) << bad;
}

TEST(ParseByteCount, NumbersAreDecimalAndBytesWhole) {
    for (const char* bad : {"0x10000", "0x1p4", "1e2KiB", "1e3", "+1", "inf", "infinity", "1.2.3", "."})
        EXPECT_FALSE(parseByteCount(bad, "budget").has_value()) << bad;
    for (const char* bad : {"1.5", "0.1 B", "0.0001 KiB"}) {
        const auto bytes = parseByteCount(bad, "budget");
        ASSERT_FALSE(bytes.has_value()) << bad;
        EXPECT_THAT(bytes.error().line(), HasSubstr("expected a whole number of bytes"));
    }
    EXPECT_FALSE(parseByteCount(std::string(400, '9'), "").has_value());
    EXPECT_EQ(parseByteCount("1.3 MiB", ""), 1363148u) << "never more than the text says";
    EXPECT_EQ(parseByteCount("2.007 kB", ""), 2007u);
    EXPECT_EQ(parseByteCount("3.0", ""), 3u);
    EXPECT_EQ(parseByteCount("0", ""), 0u);
    EXPECT_EQ(parseByteCount("9007199254740991", ""), 9007199254740991u);
}

}  // namespace
}  // namespace lightcook::pipeline
