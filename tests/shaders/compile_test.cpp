// Every shared source, and every include that an engine may get, goes through glslangValidator as GLSL 4.50, as GLSL ES 3.00 and as HLSL.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "formats/light_map_layout.h"
#include "shaders/include.h"

namespace lightcook {
namespace {

enum class Dialect { Glsl450, GlslEs300, Hlsl };

bool hasGlslang() {
    return std::system("command -v glslangValidator > /dev/null 2>&1") == 0;
}

/// Wraps the shared text into a fragment shader of the dialect; body computes a vec3 called `result`.
std::string fragmentShader(Dialect dialect, const std::string& shared, const std::string& body) {
    switch (dialect) {
        case Dialect::Glsl450:
            return "#version 450\n" + shared + "layout(location = 0) out vec4 color;\nvoid main() {\nvec3 result;\n" + body +
                   "color = vec4(result, 1.0);\n}\n";
        case Dialect::GlslEs300:
            return "#version 300 es\n" + shared + "out vec4 color;\nvoid main() {\nvec3 result;\n" + body +
                   "color = vec4(result, 1.0);\n}\n";
        case Dialect::Hlsl:
            break;
    }
    return "#define LIGHTCOOK_HLSL\n" + shared + "float4 main() : SV_Target {\nvec3 result;\n" + body + "return float4(result, 1.0);\n}\n";
}

/// Returns the declaration of a texture with the tables of a learned layout.
std::string tablesDeclaration(Dialect dialect) {
    if (dialect == Dialect::Hlsl) return "Texture2D<float4> tables : register(t0);\n";
    return dialect == Dialect::Glsl450 ? "layout(binding = 0) uniform sampler2D tables;\n" : "uniform highp sampler2D tables;\n";
}

class Compile : public testing::TestWithParam<Dialect> {
protected:
    void SetUp() override {
        if (!hasGlslang()) GTEST_SKIP() << "glslangValidator is not installed (Debian: glslang-tools)";
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        std::string name = test->name();
        std::ranges::replace(name, '/', '_');
        folder_ = std::filesystem::temp_directory_path() / ("lightcook_shaders_" + name + "_" + std::to_string(getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    /// Returns glslang's messages; empty if the shader compiles.
    std::string errors(const std::string& shared, const std::string& body) const {
        const std::filesystem::path source = folder_ / "shader.frag", log = folder_ / "log.txt";
        std::ofstream(source) << fragmentShader(GetParam(), shared, body);
        std::string command = "glslangValidator -S frag ";
        if (GetParam() == Dialect::Hlsl) command += "-D -V -e main -o '" + (folder_ / "out.spv").string() + "' ";
        if (GetParam() == Dialect::Glsl450) command += "-V -o '" + (folder_ / "out.spv").string() + "' ";
        command += "'" + source.string() + "' > '" + log.string() + "' 2>&1";
        if (std::system(command.c_str()) == 0) return {};
        std::ostringstream said;
        said << std::ifstream(log).rdbuf();
        return said.str();
    }

private:
    std::filesystem::path folder_;
};

const std::string kNothing = "result = lcGrey(1.0);\n";

std::string textOf(std::string_view name) {
    for (const shaders::ShaderSource& source : shaders::allSources())
        if (source.name == name) return std::string(source.text);
    ADD_FAILURE() << "no source " << name;
    return {};
}

/// Returns code that decodes a layout and shades with it.
std::string useOf(const std::string& layout) {
    if (layout == "flat") return "LcFlatConstants k; k.range = 2.0;\nresult = lcLightMapFlat(vec4(0.1, 0.2, 0.3, 1.0), k);\n";
    if (layout == "flat-2")
        return "LcFlat2Constants k; k.range = 2.0; k.share = 0.125;\n"
               "result = lcLightMapFlat2(vec4(0.1, 0.2, 0.3, 1.0), vec4(0.2, 0.1, 0.3, 1.0), k);\n";
    if (layout.starts_with("basis")) {
        const std::string count = layout == "basis-3" ? "3" : "4";
        return "LcBasisFirst" + count + " b;\nLcBasisResidual r;\nfor (int i = 0; i < " + (count == "3" ? "80" : "120") +
               "; ++i) { b.v[i] = lcGrey(0.1); }\nfor (int i = 0; i < 36; ++i) { r.v[i] = lcGrey(0.01); }\n"
               "vec4 one = vec4(0.5, 0.5, 0.5, 1.0);\none.x = lcBasisIndexUv(vec2(0.3, 0.4), vec2(40.0, 72.0)).x + 0.1 * "
               "float(lcBasisCluster(one, vec2(0.3, 0.4), vec2(40.0, 72.0)));\nLcSh sh = lcLightMapBasis" +
               count +
               "(one, one, b, 2.0);\nsh = lcLightMapBasisAdd(sh, one, one, r, 2.0, 0.5);\n"
               "LcBasisQuad q = lcBasisQuad(one, one, one, one, one, 2.0);\nLcSh mixed = lcMixBasis" +
               count +
               "(q, one, one, one, one, b);\nmixed = lcMixBasisAdd(mixed, q, one, one, one, one, r, 0.5);\n"
               "result = lcExitRadiance(sh, vec3(0.0, 0.0, 1.0)) + lcExitRadiance(mixed, vec3(0.0, 0.0, 1.0));\n";
    }
    const std::string one = "vec4(0.5, 0.5, 0.5, 1.0)";
    if (layout.starts_with("lit"))
        return "LcLitTexels t;\nLcLitConstants k;\nt.l0 = t.light = t.direction = " + one +
               ";\nk.range = 2.0;\nfor (int i = 0; i < 8; ++i) { t.rest[i] = " + one +
               "; k.scale[i] = 2.0; k.bias[i] = -1.0; }\nLcSh whole = lcLightMapLit(t, k);\n"
               "LcSh dimmed = lcLightMapLitDimmed(t, k, lcGrey(0.5));\nLcQuad q = lcQuad(vec2(0.3, 0.4), vec2(40.0, 72.0));\n"
               "vec4 bits = vec4(lcCoverageTexel(q.texel11), lcQuadTexel(q, 0.3));\n"
               "if (lcHasDetail(bits)) { bits.x = lcDetailTexel(bits, q.texel00).x; }\n"
               "q = lcCoveredQuad(q, vec4(lcCovered(bits, q.texel00), lcCovered(bits, q.texel10), lcCovered(bits, q.texel01), "
               "lcCovered(bits, q.texel11)));\nLcSh sh = lcMix(whole, dimmed, dimmed, whole, q.weights);\n"
               "result = lcExitRadiance(sh, lcLitDirection(t.direction)) + lcLitIntensity(t.light, k);\n";
    std::string type;
    for (std::size_t at = 0; at < layout.size(); ++at)
        if (layout[at] != '-')
            type += at == 0 || layout[at - 1] == '-' ? static_cast<char>(std::toupper(static_cast<unsigned char>(layout[at]))) : layout[at];
    const formats::LightMapFamily family = formats::info(formats::lightMapLayoutFromName(layout).value()).family;
    const bool isRnm = family == formats::LightMapFamily::Rnm;
    const bool hasConstants = family != formats::LightMapFamily::Godot && family != formats::LightMapFamily::Bakery && !isRnm;
    std::string body = "Lc" + type + "Texels t;\n" + (hasConstants ? "Lc" + type + "Constants k;\n" : "");
    if (layout == "godot") body += "for (int i = 0; i < 4; ++i) { t.sh[i] = " + one + "; }\n";
    if (layout == "mono-sh") body += "t.l0 = " + one + ";\nt.l1 = " + one + ";\n";
    if (layout == "bakery") body += "t.l0 = t.l1x = t.l1y = t.l1z = " + one + ";\n";
    if (isRnm) body += "t.rnm0 = t.rnm1 = t.rnm2 = " + one + ";\n";
    if (layout == "raw") body += "for (int i = 0; i < 9; ++i) { t.sh[i] = " + one + "; }\nk.range = 2.0;\n";
    if (layout.starts_with("hdr"))
        body +=
            "for (int i = 0; i < 9; ++i) { t.sh[i] = " + one + "; }\nk.range = 2.0;\nfor (int i = 0; i < 8; ++i) { k.bias[i] = -1.0; }\n";
    if (layout == "hdr-2") body += "for (int i = 0; i < 9; ++i) { t.second[i] = " + one + "; }\nk.share = 0.0625;\n";
    if (layout == "halo3")
        body += "for (int i = 0; i < 9; ++i) { t.first[i] = " + one + "; t.second[i] = " + one +
                "; k.range[i] = 2.0; }\nLcSh first = lcLightMapHalo3First(t, k);\nt.first[0] = vec4(first.c[8].x, 0.5, 0.5, 1.0);\n";
    if (layout == "ratio" || layout == "sh4")
        body += "t.l0 = " + one + ";\nk.range = 2.0;\nfor (int i = 0; i < " + (layout == "sh4" ? "3" : "8") +
                "; ++i) { t.ratio[i] = " + one + "; k.scale[i] = 2.0; k.bias[i] = -1.0; }\n";
    if (layout == "unreal-hq")
        body += "t.lightmap0 = " + one + ";\nt.lightmap1 = " + one + ";\nk.scale0 = k.add0 = k.scale1 = k.add1 = " + one +
                ";\nvec3 shown = lcUnrealHqExitRadiance(t, k, vec3(0.6, 0.0, 0.8));\nt.lightmap0.x = shown.x;\n";
    if (!hasConstants)
        body += "vec3 shown = lc" + type + "ExitRadiance(t, vec3(0.6, 0.0, 0.8));\nt." +
                (layout == "godot" ? "sh[0]"
                 : isRnm           ? "rnm0"
                                   : "l0") +
                ".x = shown.x;\n";
    const std::string arguments = hasConstants ? "(t, k);\n"
                                  : isRnm      ? "(t, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));\n"
                                               : "(t);\n";
    return body + "LcSh sh = lcLightMap" + type + arguments +
           "LcFrame f = lcViewFrame(vec3(0.0, 0.0, 1.0), vec3(0.6, 0.0, 0.8));\n"
           "result = lcExitRadiance(lcLocalSh(sh, f.x, f.y, f.z), vec3(0.0, 0.0, 1.0));\n";
}

TEST_P(Compile, EachSourceWithOnlyThePreludeAndHarmonicsBeforeIt) {
    for (const shaders::ShaderSource& source : shaders::allSources()) {
        std::string text = textOf("prelude.glsl");
        if (source.name != "prelude.glsl") text += textOf("sh.glsl");
        if (source.name != "prelude.glsl" && source.name != "sh.glsl") text += std::string(source.text);
        EXPECT_EQ(errors(text, kNothing), "") << source.name;
    }
}

TEST_P(Compile, TheIncludeOfEveryLayoutDecodesAndShades) {
    for (const formats::LightMapLayoutInfo& row : formats::allLightMapLayouts()) {
        const std::string layout(row.name);
        const std::vector<std::string> layouts = {layout};
        EXPECT_EQ(errors(shaders::shaderInclude(formats::lightMapFamilies(layouts)), useOf(layout)), "") << layout;
    }
}

TEST_P(Compile, LearnedLayoutsDecodeFromTheTextureOfTheirTables) {
    const std::vector<std::string> families = {"basis"};
    const std::string shared = shaders::shaderInclude(families) + tablesDeclaration(GetParam());
    for (const char* count : {"3", "4"})
        EXPECT_EQ(
            errors(shared, "vec4 one = vec4(0.5, 0.5, 0.5, 1.0);\nLcSh sh = lcLightMapBasis" + std::string(count) +
                               "From(one, one, tables, 7, 2.0);\nsh = lcLightMapBasisAddFrom(sh, one, one, tables, 7, 1, 2.0, "
                               "0.5);\nLcBasisQuad q = lcBasisQuad(one, one, one, one, one, 2.0);\nLcSh mixed = lcMixBasis" +
                               count +
                               "From(q, one, one, one, one, tables, 7);\nmixed = lcMixBasisAddFrom(mixed, q, one, one, one, one, tables, "
                               "7, 1, 0.5);\nresult = lcExitRadiance(sh, vec3(0.0, 0.0, 1.0)) + mixed.c[8];\n"),
            "");
}

TEST_P(Compile, TheIncludeOfAllLayoutsMayBeIncludedTwice) {
    const std::string text =
        shaders::shaderInclude(formats::namesOf(std::span<const formats::LightMapFamilyInfo>(formats::kLightMapFamilies)));
    EXPECT_EQ(errors(text + text, useOf("ratio")), "");
}

TEST_P(Compile, TheIncludeOfASceneWithGgxHasItsDistribution) {
    const std::vector<std::string> families = {"ratio"};
    const std::string text = shaders::shaderInclude(families, shaders::Distribution::Ggx);
    EXPECT_TRUE(text.ends_with(shaders::shaderInclude(families))) << "one definition, and the same text";
    EXPECT_EQ(errors(text + text,
                     "result = lcDominantSpecular(vec3(0.0, 0.0, 1.0), vec3(0.0, 0.6, 0.8), lcGrey(1.0), vec3(0.0, 0.0, 1.0), "
                     "0.3, lcGrey(0.04));\n#ifndef LIGHTCOOK_GGX\n#error GGX is not defined\n#endif\n"),
              "");
}

TEST_P(Compile, AMistakeIsNoticed) {
    EXPECT_NE(errors(textOf("prelude.glsl"), "result = lcNoSuchFunction(1.0);\n"), "");
}

std::string dialectName(const testing::TestParamInfo<Dialect>& tested) {
    constexpr std::array names = {"Glsl450", "GlslEs300", "Hlsl"};
    return names[static_cast<std::size_t>(tested.param)];
}
INSTANTIATE_TEST_SUITE_P(Dialects, Compile, testing::Values(Dialect::Glsl450, Dialect::GlslEs300, Dialect::Hlsl), dialectName);

TEST(ShaderInclude, HoldsOnlyTheFamiliesAskedForInOneOrder) {
    const std::vector<std::string> ratio = {"ratio"}, both = {"ratio", "halo3", "ratio"}, turned = {"halo3", "ratio"};
    EXPECT_NE(shaders::shaderInclude(ratio).find("lcLightMapRatio"), std::string::npos);
    EXPECT_EQ(shaders::shaderInclude(ratio).find("lcLightMapHalo3"), std::string::npos);
    EXPECT_EQ(shaders::shaderInclude(both), shaders::shaderInclude(turned));
    EXPECT_NE(shaders::shaderInclude({}).find("lcCookTorrance"), std::string::npos);
}

TEST(ShaderSources, HaveOneForEachFamilyOfLightMapLayouts) {
    for (const formats::LightMapFamilyInfo& family : formats::kLightMapFamilies)
        EXPECT_TRUE(shaders::hasLightMapFamily(family.name)) << family.name;
    const auto count =
        std::ranges::count_if(shaders::allSources(), [](const auto& source) { return source.name.starts_with("light_map_"); });
    EXPECT_EQ(static_cast<std::size_t>(count), formats::kLightMapFamilies.size());
    for (const char* unknown : {"", "basis-4", "sh5"}) EXPECT_FALSE(shaders::hasLightMapFamily(unknown)) << unknown;
}

TEST(ShaderSources, AreIncludedByTheCppHeaderInTheSameOrder) {
    std::ifstream header(std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "shaders/lightcook_cpp.h");
    const std::string prefix = "#include \"shaders/";
    std::vector<std::string> included, embedded;
    for (std::string line; std::getline(header, line);)
        if (line.starts_with(prefix)) included.push_back(line.substr(prefix.size(), line.size() - prefix.size() - 1));
    for (const shaders::ShaderSource& source : shaders::allSources()) embedded.emplace_back(source.name);
    EXPECT_EQ(included, embedded);
}

}  // namespace
}  // namespace lightcook
