// The names of the shader follow from the manifest: layout "unreal-hq" has structs LcUnrealHqTexels and LcUnrealHqConstants and
// function lcLightMapUnrealHq; texture "ratio" is member `ratio`, an array if the texture has layers; a constant is the member of its
// name. Learned layouts take the textures themselves. With filter "decoded" the function decodes four texels, and their light is mixed;
// those of learned layouts are mixed first. A map with detail has some of those texels in layout "lit".
#include "decode_glsl.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <stdexcept>

namespace example {
namespace {

using Json = nlohmann::json;

/// Returns "UnrealHq" for "unreal-hq", and "Lit" for "lit-half", whose smaller texture has the texels of "lit".
std::string shaderName(std::string_view layout) {
    for (const std::string_view size : {"-half", "-quarter"})
        if (layout.ends_with(size)) layout.remove_suffix(size.size());
    std::string name;
    bool isFirst = true;
    for (const char letter : layout) {
        if (letter != '-') name += isFirst ? static_cast<char>(std::toupper(static_cast<unsigned char>(letter))) : letter;
        isFirst = letter == '-';
    }
    return name;
}

/// Returns the member of a texture: those of halo3 have "luvw_" before it.
std::string memberOf(const std::string& role) {
    constexpr std::string_view kPrefix = "luvw_";
    return role.starts_with(kPrefix) ? role.substr(kPrefix.size()) : role;
}

const Json* findTexture(const Json& lightMap, const std::string& role) {
    for (const Json& texture : lightMap.at("textures"))
        if (texture.at("role") == role) return &texture;
    return nullptr;
}

constexpr std::array<const char*, 4> kCorners = {"00", "10", "01", "11"};  // of an LcQuad

/// GLSL of the texels that a decode reads. Filter "hardware": filtered at `vec2 uv`. Filter "decoded": that of the map's texel `ivec2
/// texel` of mip `int level`.
class Fetches {
public:
    explicit Fetches(const Json& lightMap) : lightMap_(lightMap) {}
    bool isDecoded() const { return lightMap_.value("filter", "hardware") == "decoded"; }
    std::string one(const std::string& role, const std::string& layer = "0", const std::string& texel = "texel") const {
        const Json& texture = *findTexture(lightMap_, role);
        const std::string name = "map_" + role;
        const bool isArray = texture.at("array");
        if (!isDecoded()) return isArray ? "texture(" + name + ", vec3(uv, " + layer + "))" : "texture(" + name + ", uv)";
        const int side = texture.value("side", 1);  // of the square of the map's texels that reads one of its texels
        const std::string at = side > 1 ? texel + " / " + std::to_string(side) : texel;
        return "texelFetch(" + name + ", " + (isArray ? "ivec3(" + at + ", " + layer + ")" : at) + ", level)";
    }
    /// Returns those of the four texels of `LcQuad q`, as arguments of a function.
    std::string four(const std::string& role, const std::string& layer = "0") const {
        std::string texels;
        for (const std::string corner : kCorners) texels += one(role, layer, "ivec2(q.texel" + corner + ")") + ", ";
        return texels;
    }
    /// Returns statements that set the member of a texture.
    std::string all(const Json& texture) const {
        const std::string role = texture.at("role"), member = memberOf(role);
        const int layers = texture.at("layers");
        if (layers == 1) return "  t." + member + " = " + one(role) + ";\n";
        return "  for (int i = 0; i < " + std::to_string(layers) + "; ++i) t." + member + "[i] = " + one(role, "i") + ";\n";
    }

private:
    const Json& lightMap_;
};

/// Declarations, and the body of a function with `int cluster` and the place of Fetches, which returns the light there.
struct Decode {
    std::string declarations, body;
};

/// Returns true for the textures beside those of a layout that decodes four texels.
bool isBeside(const std::string& role) {
    return role == "coverage" || role.starts_with("detail_");
}

bool isLearned(const Json& lightMap) {
    return lightMap.at("layout").get<std::string>().starts_with("basis-");
}
std::string codeCountOf(const Json& lightMap) {
    return lightMap.at("layout") == "basis-3" ? "3" : "4";
}

/// Returns statements that set `cluster` to that of a place of the map, where a texture has it. They declare `size`, of the map.
std::string clusterGlsl(const Json& lightMap, const std::string& place) {
    if (findTexture(lightMap, "index") == nullptr) return "";
    return "  vec2 size = vec2(textureSize(map_l0, 0).xy), place = " + place +
           ";\n  cluster = lcBasisCluster(texture(map_index, lcBasisIndexUv(place, size)), place, size);\n";
}
std::string clusterOfTexel(const Json& lightMap, const std::string& texel) {
    return clusterGlsl(lightMap, "(" + texel + " + 0.5) * exp2(float(level)) / size");
}

/// Returns the beginning of a statement that adds each layer `i` of the residual to `sh`.
std::string eachLayer(const Json& residual) {
    return "  for (int i = 0; i < " + std::to_string(residual.at("layers").get<int>()) + "; ++i)\n    sh = ";
}

Decode learnedDecode(const Json& lightMap, const Fetches& fetches) {
    std::string body = fetches.isDecoded() ? clusterOfTexel(lightMap, "vec2(texel)") : clusterGlsl(lightMap, "uv");
    body += "  vec4 l0 = " + fetches.one("l0") + ";\n  LcSh sh = lcLightMapBasis" + codeCountOf(lightMap) + "From(l0, " +
            fetches.one("code") + ", map_tables, cluster, constants.range);\n";
    if (const Json* residual = findTexture(lightMap, "residual"))
        body += eachLayer(*residual) + "lcLightMapBasisAddFrom(sh, l0, " + fetches.one("residual", "i") +
                ", map_tables, cluster, i, constants.range, constants.neutral);\n";
    return {"struct Constants { float range, neutral; };\nuniform Constants constants;\n", body + "  return sh;\n"};
}

Decode flatDecode(const Json& lightMap, const Fetches& fetches, const std::string& name) {
    std::string texels;
    for (const char* role : {"exit", "second"})
        if (findTexture(lightMap, role) != nullptr) texels += fetches.one(role) + ", ";
    return {"uniform Lc" + name + "Constants constants;\n",
            "  LcSh sh;\n  for (int i = 0; i < 9; ++i) sh.c[i] = vec3(0.0);\n  sh.c[0] = lcLightMap" + name + "(" + texels +
                "constants) / 0.28209479;  // the first basis function\n  return sh;\n"};
}

Decode plainDecode(const Json& lightMap, const Fetches& fetches, const std::string& name, const std::string& include) {
    const bool hasConstants = include.find("struct Lc" + name + "Constants") != std::string::npos;
    std::string body = "  Lc" + name + "Texels t;\n";
    for (const Json& texture : lightMap.at("textures"))
        if (!isBeside(texture.at("role"))) body += fetches.all(texture);
    return {hasConstants ? "uniform Lc" + name + "Constants constants;\n" : "",
            body + "  return lcLightMap" + name + (hasConstants ? "(t, constants);\n" : "(t);\n")};
}

Decode decodeOf(const Json& lightMap, const Fetches& fetches, const std::string& include) {
    const std::string layout = lightMap.at("layout");
    if (isLearned(lightMap)) return learnedDecode(lightMap, fetches);
    if (layout == "flat" || layout == "flat-2") return flatDecode(lightMap, fetches, shaderName(layout));
    return plainDecode(lightMap, fetches, shaderName(layout), include);
}

/// Returns a function with the light of a texel of the textures of detail.
std::string detailGlsl() {
    const auto fetch = [](const std::string& texture, const std::string& layer) {
        return "texelFetch(map_detail_" + texture + ", ivec3(texel, " + layer + "), 0);\n";
    };
    return "uniform LcLitConstants detailConstants;\nLcSh lightMapDetail(ivec2 texel) {\n  LcLitTexels t;\n  t.l0 = " + fetch("hdr", "0") +
           "  t.light = " + fetch("hdr", "1") + "  t.direction = " + fetch("ldr", "0") +
           "  for (int i = 0; i < 8; ++i) t.rest[i] = " + fetch("ldr", "i + 1") + "  return lcLightMapLit(t, detailConstants);\n}\n";
}

/// Returns the statements of lightMapTexel() that come before the decode of the map's own texel.
std::string choiceGlsl() {
    return "  vec4 tile = texelFetch(map_coverage, ivec3(lcCoverageTexel(vec2(texel)), 1), 0);\n"
           "  if (lcHasDetail(tile)) return lightMapDetail(ivec2(lcDetailTexel(tile, vec2(texel))));\n";
}

/// Returns the number of mip levels of a light map. Textures of clusters and tables have one.
int mipCount(const Json& lightMap) {
    int count = 0;
    for (const Json& texture : lightMap.at("textures")) count = std::max(count, texture.at("mips").get<int>());
    return count;
}

/// randomOfPixel(), in [0, 1): interleaved gradient noise (Jimenez 2014, Next Generation Post Processing in Call of Duty: Advanced
/// Warfare), which differs most between neighbours, moved by the golden ratio from frame to frame.
constexpr const char* kRandomGlsl =
    "uniform int frame;\nfloat randomOfPixel() {\n"
    "  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));\n"
    "  return fract(noise + 0.61803399 * float(frame));\n}\n";

/// Returns statements that return the light of `LcQuad q`, mixed texel by texel.
std::string mixOfLight() {
    std::string decoded;
    for (const std::string corner : kCorners) decoded += "lightMapTexel(ivec2(q.texel" + corner + "), level, cluster), ";
    return "  return lcMix(" + decoded + "q.weights);\n";
}

/// Returns the same for a learned layout, whose texels are mixed before the factors are read. Detail is no such texel.
std::string mixOfLearned(const Json& lightMap, const Fetches& fetches) {
    std::string body = clusterOfTexel(lightMap, "lcQuadTexel(q, 0.5)");
    const bool hasDetail = lightMap.contains("detail");
    if (hasDetail)
        body +=
            "  vec2 texels[4] = vec2[4](q.texel00, q.texel10, q.texel01, q.texel11);\n  LcSh detail;\n"
            "  for (int i = 0; i < 9; ++i) detail.c[i] = vec3(0.0);\n  for (int k = 0; k < 4; ++k) {\n"
            "    vec4 tile = texelFetch(map_coverage, ivec3(lcCoverageTexel(texels[k]), 1), 0);\n    if (!lcHasDetail(tile)) continue;\n"
            "    LcSh light = lightMapDetail(ivec2(lcDetailTexel(tile, texels[k])));\n"
            "    for (int i = 0; i < 9; ++i) detail.c[i] += q.weights[k] * light.c[i];\n    q.weights[k] = 0.0;\n  }\n"
            "  if (q.weights == vec4(0.0)) return detail;\n";
    body += "  LcBasisQuad light = lcBasisQuad(" + fetches.four("l0") + "q.weights, constants.range);\n  LcSh sh = lcMixBasis" +
            codeCountOf(lightMap) + "From(light, " + fetches.four("code") + "map_tables, cluster);\n";
    if (const Json* residual = findTexture(lightMap, "residual"))
        body += eachLayer(*residual) + "lcMixBasisAddFrom(sh, light, " + fetches.four("residual", "i") +
                "map_tables, cluster, i, constants.neutral);\n";
    if (hasDetail) body += "  for (int i = 0; i < 9; ++i) sh.c[i] += detail.c[i];\n";
    return body + "  return sh;\n";
}

/// Returns lightMapSh() of filter "decoded": the light of the covered texels around a place (filter.glsl), in the two levels that a
/// trilinear sampler would take. light: statements that return that of `LcQuad q`.
std::string filterGlsl(const Json& lightMap, const std::string& light) {
    const std::string size =
        "vec2(" + std::to_string(lightMap.at("width").get<int>()) + ", " + std::to_string(lightMap.at("height").get<int>()) + ")";
    std::string covered;
    for (const std::string corner : kCorners)
        covered += (covered.empty() ? "isCovered(q.texel" : ", isCovered(q.texel") + corner + ", level)";
    const std::string at =
        findTexture(lightMap, "coverage")->at("array") ? "ivec3(lcCoverageTexel(texel), 0)" : "ivec2(lcCoverageTexel(texel))";
    return "float isCovered(vec2 texel, int level) {\n  return lcCovered(texelFetch(map_coverage, " + at +
           ", level), texel);\n}\n"
           "LcSh lightMapLevel(vec2 uv, int level, int cluster) {\n  LcQuad q = lcQuad(uv, " +
           size + " * exp2(-float(level)));\n  q = lcCoveredQuad(q, vec4(" + covered + "));\n" + light +
           "}\n"
           "LcSh lightMapSh(vec2 uv, int cluster) {\n  vec2 across = dFdx(uv) * " +
           size + ", down = dFdy(uv) * " + size +
           ";\n  float level = clamp(0.5 * log2(max(max(dot(across, across), dot(down, down)), 1.0)), 0.0, " +
           std::to_string(mipCount(lightMap) - 1) +
           ".0), share = fract(level);\n  LcSh sh = lightMapLevel(uv, int(level), cluster);\n  if (share <= 0.0) return sh;\n"
           "  LcSh next = lightMapLevel(uv, int(level) + 1, cluster);\n"
           "  for (int i = 0; i < 9; ++i) sh.c[i] = mix(sh.c[i], next.c[i], share);\n  return sh;\n}\n";
}

}  // namespace

std::string decodeGlsl(const Json& lightMap, const std::string& include, bool isOneTexel) {
    if (lightMap.at("layout") == "rnm")
        throw std::runtime_error("layout rnm is relative to tangents of the mesh, which this example does not read");
    std::string glsl;
    for (const Json& texture : lightMap.at("textures"))
        glsl += std::string("uniform ") + (texture.at("array") ? "sampler2DArray" : "sampler2D") + " map_" +
                texture.at("role").get<std::string>() + ";\n";
    const Fetches fetches(lightMap);
    if (isOneTexel && !fetches.isDecoded()) throw std::runtime_error("--one-texel: the sampler filters this light map, not the shader");
    const Decode decode = decodeOf(lightMap, fetches, include);
    const bool hasDetail = lightMap.contains("detail");
    glsl += decode.declarations + (hasDetail ? detailGlsl() : "");
    if (!fetches.isDecoded()) return glsl + "LcSh lightMapSh(vec2 uv, int cluster) {\n" + decode.body + "}\n";
    if (isLearned(lightMap) && !isOneTexel) return glsl + filterGlsl(lightMap, mixOfLearned(lightMap, fetches));
    glsl += "LcSh lightMapTexel(ivec2 texel, int level, int cluster) {\n" + (hasDetail ? choiceGlsl() : "") + decode.body + "}\n";
    if (!isOneTexel) return glsl + filterGlsl(lightMap, mixOfLight());
    return glsl + kRandomGlsl + filterGlsl(lightMap, "  return lightMapTexel(ivec2(lcQuadTexel(q, randomOfPixel())), level, cluster);\n");
}

}  // namespace example
