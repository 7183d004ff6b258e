// The decode of a light map as in an engine's shader, generated from the manifest: constants, fetches, the layout's function.
#pragma once

#include <fmt/format.h>

#include <cctype>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/light_map_detail.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/manifest/manifest.h"

namespace lightcook::samplers {

inline std::string glslFloat(double value) {
    const std::string text = fmt::format("{:.9g}", value);
    return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}
inline std::string glslVector(const std::vector<float>& values, std::size_t first, int count) {
    std::string text = fmt::format("vec{}(", count);
    for (int i = 0; i < count; ++i)
        text += (i > 0 ? ", " : "") + glslFloat(static_cast<double>(values[first + static_cast<std::size_t>(i)]));
    return text + ")";
}

/// Generates the body of a shader that decodes one place of a map into `LcSh sh`.
class LayoutGlsl {
public:
    /// constants  those of the asset (pipeline::constantsOf)
    LayoutGlsl(const pipeline::Json& asset, pipeline::LightMapConstants constants)
        : info_(formats::info(formats::lightMapLayoutFromName(asset.at("layout").get<std::string>()).value())),
          constants_(std::move(constants)),
          mapSize_(fmt::format("vec2({}.0, {}.0)", asset.at("width").get<int>(), asset.at("height").get<int>())) {
        if (asset.contains("detail"))
            detail_ = std::make_shared<LayoutGlsl>(LayoutGlsl(asset.at("detail").at("constants").get<pipeline::LightMapConstants>()));
        for (const pipeline::Json& texture : asset.at("textures"))
            if (hasUnit(texture.at("role").get<std::string>())) units_.push_back(texture.at("role").get<std::string>());
    }
    /// Returns true for the textures that the shader reads, in the order of their units. Clusters come with the places, and tables apart.
    static bool hasUnit(const std::string& role) {
        return !pipeline::isLookupRole(role) || role == formats::kCoverageRole || formats::isOfDetail(role);
    }
    std::string samplers() const {
        std::string text;
        for (std::size_t unit = 0; unit < units_.size(); ++unit)
            text += fmt::format("layout(binding = {}) uniform sampler2DArray t_{};\n", unit, units_[unit]);
        return text;
    }
    /// Returns the values that `table` must hold.
    std::vector<float> tables() const {
        if (!info_.isLearned()) return {};
        std::vector<float> values = constants_.at("code");
        const std::vector<float>& residual = constants_.at("residual");
        values.insert(values.end(), residual.begin(), residual.end());
        return values;
    }
    std::string decode() const { return isMixed() ? decodeMixed() : decodeAtPlace(); }

private:
    enum class Kind { Number, Array, Vector };
    struct Constant {
        const char* name;
        Kind kind;
    };
    struct Array {
        const char *member, *role;
    };
    /// Generates the decode of detail.
    explicit LayoutGlsl(pipeline::LightMapConstants constants)
        : info_(formats::info(formats::kDetailLayout)), constants_(std::move(constants)), isDetail_(true) {}
    bool isMixed() const { return info_.isAlwaysDecoded || detail_; }
    /// Returns the decode of the covered texels around a place, and the mix of their light.
    std::string decodeMixed() const {
        return "LcQuad q = lcQuad(place.xy, " + mapSize_ +
               ");\nvec2 corners[4] = vec2[4](q.texel00, q.texel10, q.texel01, q.texel11);\nvec4 covered;\nLcSh lights[4];\n"
               "for (int corner = 0; corner < 4; ++corner) {\nvec2 at = corners[corner];\n"
               "covered[corner] = lcCovered(texelFetch(t_coverage, ivec3(lcCoverageTexel(at), 0), 0), at);\nivec2 texel = ivec2(at);\n" +
               decodeTexel() +
               "}\n"
               "LcSh sh = lcMix(lights[0], lights[1], lights[2], lights[3], lcCoveredQuad(q, covered).weights);\n";
    }
    /// Returns the decode of a texel, or of its detail, into `lights[corner]`.
    std::string decodeTexel() const {
        const std::string own = decodeAtPlace() + "lights[corner] = sh;\n";
        if (!detail_) return own;
        return "vec4 tile = texelFetch(t_coverage, ivec3(lcCoverageTexel(at), 1), 0);\nif (lcHasDetail(tile)) {\n"
               "texel = ivec2(lcDetailTexel(tile, at));\n" +
               detail_->decodeAtPlace() + "lights[corner] = sh;\n} else {\n" + own + "}\n";
    }
    /// Returns the decode of what fetch() reads.
    std::string decodeAtPlace() const {
        switch (info_.family) {
            case formats::LightMapFamily::Raw:
                return constants({{"range", Kind::Number}}) + texels({{"sh", "sh"}}) + call();
            case formats::LightMapFamily::Flat:
                if (info_.textures.size() > 1)
                    return constants({{"range", Kind::Number}, {"share", Kind::Number}}) +
                           result(fmt::format("lcLightMapFlat2({}, {}, k)", fetch("exit", "0"), fetch("second", "0")));
                return constants({{"range", Kind::Number}}) + result(fmt::format("lcLightMapFlat({}, k)", fetch("exit", "0")));
            case formats::LightMapFamily::Ratio:
            case formats::LightMapFamily::Sh4:
                return constants({{"range", Kind::Number}, {"scale", Kind::Array}, {"bias", Kind::Array}}) + texels({{"ratio", "ratio"}}) +
                       "t.l0 = " + fetch("l0", "0") + ";\n" + call();
            case formats::LightMapFamily::Godot:
                return texels({{"sh", "sh"}}) + callWithoutConstants();
            case formats::LightMapFamily::Bakery:
                return texels({}) + eachTexture() + callWithoutConstants();
            case formats::LightMapFamily::Hdr:
                return decodeHdr();
            case formats::LightMapFamily::Halo3:
                return constants({{"range", Kind::Array}}) + texels({{"first", "luvw_first"}, {"second", "luvw_second"}}) + call();
            case formats::LightMapFamily::Unreal:
                return constants({{"scale0", Kind::Vector}, {"add0", Kind::Vector}, {"scale1", Kind::Vector}, {"add1", Kind::Vector}}) +
                       texels({}) + eachTexture() + call();
            case formats::LightMapFamily::Lit:
                return constants({{"range", Kind::Number}, {"scale", Kind::Array}, {"bias", Kind::Array}}) + texels({{"rest", "rest"}}) +
                       eachTexture({"l0", "light", "direction"}) + call();
            case formats::LightMapFamily::Rnm:  // needs the tangents of a mesh
            case formats::LightMapFamily::Basis:
                break;
        }
        return decodeBasis();
    }

    /// Returns the layout's part of the shader's names: "MonoSh" for "mono-sh". The layouts "lit" differ in a size alone.
    std::string shaderName() const {
        std::string name;
        bool isFirst = true;
        for (const char c : info_.family == formats::LightMapFamily::Lit ? std::string_view("lit") : info_.name) {
            if (c != '-') name += isFirst ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
            isFirst = c == '-';
        }
        return name;
    }
    int layerCount(std::string_view role) const {
        const auto* const row = formats::findByName(info_.textures, role);
        return row == nullptr ? 0 : row->layerCount;
    }
    std::string constants(const std::vector<Constant>& members) const {
        std::string text = "Lc" + shaderName() + "Constants k;\n";
        for (const Constant& each : members) {
            const std::vector<float>& values = constants_.at(each.name);
            if (each.kind == Kind::Number) text += fmt::format("k.{} = {};\n", each.name, glslFloat(static_cast<double>(values[0])));
            if (each.kind == Kind::Vector)
                text += fmt::format("k.{} = {};\n", each.name, glslVector(values, 0, static_cast<int>(values.size())));
            for (std::size_t i = 0; i < values.size() && each.kind == Kind::Array; ++i)
                text += fmt::format("k.{}[{}] = {};\n", each.name, i, glslFloat(static_cast<double>(values[i])));
        }
        return text;
    }
    /// Returns a filtered texel of `place`, or the one that `texel` of the map reads.
    std::string fetch(const std::string& role, const std::string& layer) const {
        if (isDetail_) {
            const auto* const texture = formats::findByName(info_.textures, role);
            const int first = role == "light" || role == "rest" ? 1 : 0;
            return fmt::format("texelFetch(t_detail_{}, ivec3(texel, {} + {}), 0)",
                               texture->role == formats::TexelRole::Hdr ? "hdr" : "ldr", first, layer);
        }
        if (isMixed())
            return fmt::format("texelFetch(t_{}, ivec3(texel / {}, {}), 0)", role, formats::findByName(info_.textures, role)->side, layer);
        return fmt::format("textureLod(t_{}, vec3(place.xy, {}), 0.0)", role, layer);
    }
    std::string texels(const std::vector<Array>& arrays) const {
        std::string text = "Lc" + shaderName() + "Texels t;\n";
        for (const Array& each : arrays)
            text += fmt::format("for (int i = 0; i < {}; ++i) t.{}[i] = {};\n", layerCount(each.role), each.member, fetch(each.role, "i"));
        return text;
    }
    std::string decodeHdr() const {
        const bool hasSecond = layerCount("second") > 0;
        std::vector<Constant> members = {{"range", Kind::Number}, {"bias", Kind::Array}};
        std::vector<Array> arrays = {{"sh", "sh"}};
        if (hasSecond) {
            members.push_back({"share", Kind::Number});
            arrays.push_back({"second", "second"});
        }
        return constants(members) + texels(arrays) + call();
    }
    /// Returns the decode of a learned layout; place.z is the cluster.
    std::string decodeBasis() const {
        const int codeCount = info_.codeCount;
        const auto clusters = static_cast<std::size_t>(constants_.at("clusters")[0]);
        const std::string type = fmt::format("LcBasisFirst{}", codeCount),
                          range = glslFloat(static_cast<double>(constants_.at("range")[0])),
                          neutral = glslFloat(static_cast<double>(constants_.at("neutral")[0]));
        std::string text = type + " first;\n" + readTable("first", 0, codeCount == 3 ? 80 : 120);
        text += fmt::format("LcSh sh = lcLightMapBasis{}({}, {}, first, {});\n", codeCount, fetch("l0", "0"), fetch("code", "0"), range);
        const std::size_t layers = constants_.at("residual").size() / (clusters * 108);
        for (std::size_t layer = 0; layer < layers; ++layer) {
            const std::string name = fmt::format("residual{}", layer);
            text += "LcBasisResidual " + name + ";\n" + readTable(name, constants_.at("code").size() + layer * clusters * 108, 36);
            text += fmt::format("sh = lcLightMapBasisAdd(sh, {}, {}, {}, {}, {});\n", fetch("l0", "0"),
                                fetch("residual", std::to_string(layer)), name, range, neutral);
        }
        return text;
    }
    /// Reads the table of cluster place.z. `table` holds those of the code, then those of the residual.
    static std::string readTable(const std::string& name, std::size_t first, std::size_t size) {
        return fmt::format(
            "for (int i = 0; i < {1}; ++i) {{\nint at = {2} + 3 * ({1} * int(place.z) + i);\n"
            "{0}.v[i] = vec3(TABLE(at), TABLE(at + 1), TABLE(at + 2));\n}}\n",
            name, size, first);
    }
    /// Fetches textures of one layer, each the texel member of its name.
    std::string eachTexture(const std::vector<std::string>& roles) const {
        std::string text;
        for (const std::string& role : roles) text += fmt::format("t.{} = {};\n", role, fetch(role, "0"));
        return text;
    }
    std::string eachTexture() const { return eachTexture(formats::namesOf(info_.textures)); }
    std::string callWithoutConstants() const { return "LcSh sh = lcLightMap" + shaderName() + "(t);\n"; }
    std::string call() const { return "LcSh sh = lcLightMap" + shaderName() + "(t, k);\n"; }
    static std::string result(const std::string& call) {
        return "LcSh sh;\nfor (int i = 0; i < 9; ++i) sh.c[i] = lcGrey(0.0);\nsh.c[0] = " + call + " / 0.28209479;\n";
    }

    const formats::LightMapLayoutInfo& info_;
    pipeline::LightMapConstants constants_;
    std::string mapSize_;  ///< GLSL
    std::vector<std::string> units_;
    std::shared_ptr<const LayoutGlsl> detail_;  ///< of a map that has it
    bool isDetail_ = false;
};

}  // namespace lightcook::samplers
