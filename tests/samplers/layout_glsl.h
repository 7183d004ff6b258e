// The decode of a light map as an engine's shader would hold it: the manifest's constants as text, the fetches, the layout's function.
#pragma once

#include <fmt/format.h>

#include <map>
#include <string>
#include <vector>

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

/// The body of a shader that decodes one place of a map into `LcSh sh`: the manifest's constants as text, the fetches, the layout's
/// function.
class LayoutGlsl {
public:
    explicit LayoutGlsl(const pipeline::Json& asset)
        : layout_(asset.at("layout").get<std::string>()),
          constants_(asset.at("constants").get<std::map<std::string, std::vector<float>>>()) {
        for (const pipeline::Json& texture : asset.at("textures")) units_.push_back(texture.at("role").get<std::string>());
    }
    std::string samplers() const {
        std::string text;
        for (std::size_t unit = 0; unit < units_.size(); ++unit)
            text += fmt::format("layout(binding = {}) uniform sampler2DArray t_{};\n", unit, units_[unit]);
        return text;
    }
    /// What `table` has to hold.
    std::vector<float> tables() const {
        if (!layout_.starts_with("basis")) return {};
        std::vector<float> values = constants_.at("code");
        const std::vector<float>& residual = constants_.at("residual");
        values.insert(values.end(), residual.begin(), residual.end());
        return values;
    }
    std::string decode() const {
        if (layout_ == "flat")
            return constant("LcFlatConstants", {{"range", 0}}) + result(fmt::format("lcLightMapFlat({}, k)", fetch("exit", "0")));
        if (layout_ == "raw")
            return constant("LcRawConstants", {{"range", 0}}) + texels("LcRawTexels", {{"sh", "sh", 9}}) + sh("lcLightMapRaw(t, k)");
        if (layout_ == "ratio" || layout_ == "zh3") {
            const bool isZonal = layout_ == "zh3";
            const int count = isZonal ? 4 : 8;
            const std::string name = isZonal ? "Zh3" : "Ratio";
            return constant("Lc" + name + "Constants",
                            {{"range", 0}, {"scale", count}, {"bias", count}, {"luminance", isZonal ? -3 : 1000}}) +
                   texels("Lc" + name + "Texels", {{"ratio", "ratio", count}}) + "t.l0 = " + fetch("l0", "0") + ";\n" +
                   sh("lcLightMap" + name + "(t, k)");
        }
        if (layout_ == "luvw" || layout_ == "luvw-linear") {
            const bool isLinear = layout_ != "luvw";
            const int count = isLinear ? 5 : 9;
            const std::string name = isLinear ? "LuvwLinear" : "Luvw";
            return constant("Lc" + name + "Constants",
                            {{"range", count}, {"span", count}, {"neutral", -4}, {"root", 0}, {"luminance", isLinear ? -3 : 1000}}) +
                   texels("Lc" + name + "Texels", {{"first", "luvw_first", count}, {"second", "luvw_second", count}}) +
                   sh("lcLightMap" + name + "(t, k)");
        }
        return decodeBasis();
    }

private:
    struct Constant {
        const char* name;
        int count;  ///< 0: a number, n: an array of them, -n: a vector, 1000: not there
    };
    struct Array {
        const char *member, *role;
        int count;
    };
    std::string constant(const std::string& type, const std::vector<Constant>& members) const {
        std::string text = type + " k;\n";
        for (const Constant& each : members) {
            if (each.count == 1000) continue;
            const std::vector<float>& values = constants_.at(each.name);
            if (each.count <= 0)
                text += fmt::format("k.{} = {};\n", each.name,
                                    each.count == 0 ? glslFloat(static_cast<double>(values[0])) : glslVector(values, 0, -each.count));
            for (int i = 0; i < each.count; ++i)
                text += fmt::format("k.{}[{}] = {};\n", each.name, i, glslFloat(static_cast<double>(values[static_cast<std::size_t>(i)])));
        }
        return text;
    }
    static std::string fetch(const std::string& role, const std::string& layer) {
        return fmt::format("textureLod(t_{}, vec3(place.xy, {}), 0.0)", role, layer);
    }
    static std::string texels(const std::string& type, const std::vector<Array>& arrays) {
        std::string text = type + " t;\n";
        for (const Array& each : arrays)
            text += fmt::format("for (int i = 0; i < {}; ++i) t.{}[i] = {};\n", each.count, each.member, fetch(each.role, "i"));
        return text;
    }
    /// place.z is the cluster.
    std::string decodeBasis() const {
        const bool isFirst3 = layout_ == "basis-3";
        const auto clusters = static_cast<std::size_t>(constants_.at("clusters")[0]);
        const std::string type = isFirst3 ? "LcBasisFirst3" : "LcBasisFirst4",
                          range = glslFloat(static_cast<double>(constants_.at("range")[0])),
                          neutral = glslFloat(static_cast<double>(constants_.at("neutral")[0]));
        std::string text = type + " first;\n" + readTable("first", 0, isFirst3 ? 80 : 120);
        text +=
            fmt::format("LcSh sh = lcLightMapBasis{}({}, {}, first, {});\n", isFirst3 ? 3 : 4, fetch("l0", "0"), fetch("code", "0"), range);
        const std::size_t layers = constants_.at("residual").size() / (clusters * 108);
        for (std::size_t layer = 0; layer < layers; ++layer) {
            const std::string name = fmt::format("residual{}", layer);
            text += "LcBasisResidual " + name + ";\n" + readTable(name, constants_.at("code").size() + layer * clusters * 108, 36);
            text += fmt::format("sh = lcLightMapBasisAdd(sh, {}, {}, {}, {}, {});\n", fetch("l0", "0"),
                                fetch("residual", std::to_string(layer)), name, range, neutral);
        }
        return text;
    }
    /// The tables of place.z, the cluster; all of them lie in `table`, the residual's after the code's.
    static std::string readTable(const std::string& name, std::size_t first, std::size_t size) {
        return fmt::format(
            "for (int i = 0; i < {1}; ++i) {{\nint at = {2} + 3 * ({1} * int(place.z) + i);\n"
            "{0}.v[i] = vec3(TABLE(at), TABLE(at + 1), TABLE(at + 2));\n}}\n",
            name, size, first);
    }
    static std::string sh(const std::string& call) { return "LcSh sh = " + call + ";\n"; }
    static std::string result(const std::string& call) {
        return "LcSh sh;\nfor (int i = 0; i < 9; ++i) sh.c[i] = lcGrey(0.0);\nsh.c[0] = " + call + " / 0.28209479;\n";
    }

    std::string layout_;
    std::map<std::string, std::vector<float>> constants_;
    std::vector<std::string> units_;
};

}  // namespace lightcook::samplers
