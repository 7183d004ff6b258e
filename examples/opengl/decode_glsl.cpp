// The names of the shader follow from the manifest: layout "unreal-hq" has structs LcUnrealHqTexels and LcUnrealHqConstants and
// function lcLightMapUnrealHq; texture "ratio" is member `ratio`, an array if the texture has layers; a constant is the member of its
// name. Learned layouts take the textures themselves.
#include "decode_glsl.h"

#include <cctype>
#include <stdexcept>

namespace example {
namespace {

using Json = nlohmann::json;

/// Returns "UnrealHq" for "unreal-hq".
std::string shaderName(const std::string& layout) {
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

std::string fetch(const Json& texture, const std::string& layer) {
    const std::string role = texture.at("role");
    return texture.at("array") ? "texture(map_" + role + ", vec3(uv, " + layer + "))" : "texture(map_" + role + ", uv)";
}

std::string fetchAll(const Json& texture) {
    const std::string member = memberOf(texture.at("role"));
    const int layers = texture.at("layers");
    if (layers == 1) return "  t." + member + " = " + fetch(texture, "0.0") + ";\n";
    return "  for (int i = 0; i < " + std::to_string(layers) + "; ++i) t." + member + "[i] = " + fetch(texture, "float(i)") + ";\n";
}

const Json* findTexture(const Json& lightMap, const std::string& role) {
    for (const Json& texture : lightMap.at("textures"))
        if (texture.at("role") == role) return &texture;
    return nullptr;
}

std::string learnedGlsl(const Json& lightMap, const std::string& codeCount) {
    std::string body;
    if (findTexture(lightMap, "index") != nullptr)
        body +=
            "  vec2 size = vec2(textureSize(map_l0, 0).xy);\n"
            "  cluster = lcBasisCluster(texture(map_index, lcBasisIndexUv(uv, size)), uv, size);\n";
    body += "  vec4 l0 = " + fetch(*findTexture(lightMap, "l0"), "0.0") + ";\n  LcSh sh = lcLightMapBasis" + codeCount + "From(l0, " +
            fetch(*findTexture(lightMap, "code"), "0.0") + ", map_tables, cluster, constants.range);\n";
    if (const Json* residual = findTexture(lightMap, "residual"))
        body += "  for (int i = 0; i < " + std::to_string(residual->at("layers").get<int>()) +
                "; ++i)\n    sh = lcLightMapBasisAddFrom(sh, l0, " + fetch(*residual, "float(i)") +
                ", map_tables, cluster, i, constants.range, constants.neutral);\n";
    return "struct Constants { float range, neutral; };\nuniform Constants constants;\nLcSh lightMapSh(vec2 uv, int cluster) {\n" + body +
           "  return sh;\n}\n";
}

std::string flatGlsl(const Json& lightMap, const std::string& layout) {
    const std::string name = shaderName(layout);
    std::string texels;
    for (const Json& texture : lightMap.at("textures")) texels += fetch(texture, "0.0") + ", ";
    return "uniform Lc" + name +
           "Constants constants;\nLcSh lightMapSh(vec2 uv, int cluster) {\n  LcSh sh;\n"
           "  for (int i = 0; i < 9; ++i) sh.c[i] = vec3(0.0);\n  sh.c[0] = lcLightMap" +
           name + "(" + texels + "constants) / 0.28209479;  // the first basis function\n  return sh;\n}\n";
}

std::string plainGlsl(const Json& lightMap, const std::string& layout, const std::string& include) {
    const std::string name = shaderName(layout);
    const bool hasConstants = include.find("struct Lc" + name + "Constants") != std::string::npos;
    std::string glsl = hasConstants ? "uniform Lc" + name + "Constants constants;\n" : "";
    glsl += "LcSh lightMapSh(vec2 uv, int cluster) {\n  Lc" + name + "Texels t;\n";
    for (const Json& texture : lightMap.at("textures")) glsl += fetchAll(texture);
    return glsl + "  return lcLightMap" + name + (hasConstants ? "(t, constants);\n}\n" : "(t);\n}\n");
}

}  // namespace

std::string decodeGlsl(const Json& lightMap, const std::string& include) {
    const std::string layout = lightMap.at("layout");
    if (layout == "rnm") throw std::runtime_error("layout rnm is relative to tangents of the mesh, which this example does not read");
    std::string samplers;
    for (const Json& texture : lightMap.at("textures"))
        samplers += std::string("uniform ") + (texture.at("array") ? "sampler2DArray" : "sampler2D") + " map_" +
                    texture.at("role").get<std::string>() + ";\n";
    if (layout == "flat" || layout == "flat-2") return samplers + flatGlsl(lightMap, layout);
    if (!layout.starts_with("basis-")) return samplers + plainGlsl(lightMap, layout, include);
    return samplers + learnedGlsl(lightMap, layout == "basis-3" ? "3" : "4");
}

}  // namespace example
