#include "pipeline/cook/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "formats/environment.h"
#include "formats/gltf_scene.h"
#include "formats/nearest.h"
#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/textures.h"

namespace lightcook::pipeline {
namespace {

constexpr int kCubemapSize = 128;           ///< the paper's
constexpr int kRsrmWidth = 256;             ///< the paper's
constexpr double kSmallestShadedM = 0.005;  ///< the smallest that verify::LightMapVerifier takes

using Inputs = std::map<std::string, std::filesystem::path>;

/// The mesh and what lies beside it.
Inputs meshInputs(const std::filesystem::path& mesh, formats::GltfFiles which = formats::GltfFiles::All) {
    Inputs inputs = {{kMeshRole, mesh}};
    int index = 0;
    for (const std::filesystem::path& beside : formats::gltfFilesBeside(mesh, which)) inputs[fmt::format("mesh_file{}", index++)] = beside;
    return inputs;
}

/// By the mesh's own name; where several light maps would share that, by the light map's too: each map's UVs are verified against it.
std::string meshAssetName(const Scene& scene, const LightMapEntry& entry) {
    const std::string name = entry.mesh->stem().string() + "_mesh";
    const auto sharing = std::count_if(scene.lightMaps.begin(), scene.lightMaps.end(),
                                       [&](const LightMapEntry& other) { return other.mesh && other.mesh->stem() == entry.mesh->stem(); });
    return sharing > 1 ? entry.name + "_" + name : name;
}

/// Names without extension that the files of an asset may have, under every layout.
std::vector<std::string> fileNames(const std::string& asset, const std::string& kind) {
    static const std::map<std::string, std::vector<std::string>> kEndings = {
        {"light-map", {"_l0", "_ratio", "_luvw_first", "_luvw_second", "_exit", "_sh", "_code", "_residual"}},
        {"dominant", {"_direction", "_intensity"}},
        {"lut", {"_c0236", "_d0236", "_cd78"}}};
    const auto endings = kEndings.find(kind);
    std::vector<std::string> names = {asset};
    if (endings != kEndings.end())
        for (const std::string& ending : endings->second) names.push_back(asset + ending);
    return names;
}

class Planner {
public:
    Planner(const Scene& scene, const Needs& needs, const PlanOptions& options) : scene_(scene), needs_(needs), options_(options) {
        textures_ = TextureSettings{scene.output.container, scene.output.zstd, scene.output.effort, scene.output.rdo}.toJson();
        shading_.specular = needs.specular;
        // A mirror (m = 0) has no area specular to shade: the verifier's smallest lobe stands for it.
        shading_.m = samplesOf({std::max(needs.m.low, kSmallestShadedM), std::max(needs.m.high, kSmallestShadedM)}, shading_.m);
        shading_.f0 = samplesOf(needs.f0, shading_.f0);
        if (!needs.normalMap && !needs.specular) shading_.normalCount = 1;
    }

    formats::Result<Plan> plan() && {
        for (const LightMapEntry& entry : scene_.lightMaps) planLightMap(entry);
        for (const ProbeEntry& entry : scene_.probes) planProbe(entry);
        for (const GradientEntry& entry : scene_.gradients) planGradient(entry);
        planTables();
        if (!takenName_.empty())
            return formats::failure(
                formats::ErrorCode::InvalidRequest, scene_.file.string(),
                fmt::format("found two assets that would both write '{}', expected names that keep their files apart", takenName_));
        if (mistake_) return tl::make_unexpected(*mistake_);
        return std::move(plan_);
    }

    const std::vector<std::string>& knownNames() const { return knownNames_; }

private:
    bool wanted(const std::string& asset, const std::string& kind, const std::string& parent) {
        knownNames_.push_back(asset);
        if (options_.onlyKind && *options_.onlyKind != kind) return false;
        return !options_.only || *options_.only == asset || *options_.only == parent;
    }

    /// Of a light map, a probe or a gradient: the file itself, and the colour configuration that it is read by.
    Inputs sourceOf(const std::filesystem::path& file) const {
        Inputs inputs = {{"source", file}};
        if (!scene_.colors.config.empty()) inputs[kColorConfigRole] = scene_.colors.config;
        return inputs;
    }

    void add(const std::string& asset, const std::string& kind, Json parameters, Inputs inputs, Json verifyParameters,
             Inputs verifyInputs) {
        for (const std::string& name : fileNames(asset, kind))
            if (!fileNames_.insert(name).second && takenName_.empty()) takenName_ = name;
        plan_.assets.push_back(asset);
        plan_.actions.push_back({"cook/" + asset, kind, asset, std::move(parameters), std::move(inputs), {}});
        const bool holdsLight = kind == "light-map" || kind == "mesh";
        verifyParameters["max_error"] =
            holdsLight ? scene_.output.maxError : std::max(scene_.output.maxError, scene_.output.maxConverterError);
        plan_.actions.push_back(verifyAction(asset, kind, verifyInputs, std::move(verifyParameters)));
    }

    void planLightMap(const LightMapEntry& entry) {
        formats::LightMapDescription description = entry.description;
        description.repair = options_.repair;
        std::string layout = lightMapLayoutFor(scene_, needs_);
        const std::string target(formats::info(scene_.output.target).name);
        const bool isDecided = layout != kAutoLayout || options_.layouts.contains(entry.name);
        if (layout == kAutoLayout && isDecided) layout = options_.layouts.at(entry.name);
        const bool mayBeLearned = !isDecided || hasLearnedBases(layout);
        const bool hasMesh =
            entry.mesh && (scene_.output.draco || mayBeLearned) && wanted(meshAssetName(scene_, entry), "mesh", entry.name);
        // A mesh that bears the clusters of its light map is not cooked without it.
        const bool isWanted = wanted(entry.name, "light-map", entry.name) || (hasMesh && mayBeLearned);
        if (isWanted && !isDecided) {
            plan_.undecided.push_back(entry.name);
            plan_.actions.push_back(
                {"trial/" + entry.name,
                 "light-map-trial",
                 entry.name,
                 {{"description", toJson(description)}, {"target", target}, {"textures", textures_}, {"shading", toJson(shading_)}},
                 lightMapInputs(entry, mayBeLearned),
                 {}});
        } else if (isWanted) {
            add(entry.name, "light-map",
                {{"description", toJson(description)}, {"layout", layout}, {"target", target}, {"textures", textures_}},
                lightMapInputs(entry, mayBeLearned), {{"shading", toJson(shading_)}, {"samples", options_.samples}}, tracedInputs(entry));
            if (layout == "flat" && layoutAsked(scene_.output) != "flat")
                skip(fmt::format("directional light map '{}'", entry.name),
                     "no material has a normal map or is specular: a flat exit-radiance map is enough", entry.name,
                     bitsOf(layoutAsked(scene_.output)) - bitsOf(layout));
        }
        const std::string dominant = entry.name + "_dominant";
        if (wanted(dominant, "dominant", entry.name)) {
            if (needs_.specular)
                add(dominant, "dominant",
                    {{"description", toJson(description)}, {"fit", entry.dominantFit}, {"target", target}, {"textures", textures_}},
                    sourceOf(entry.file), {{"shading", toJson(shading_)}}, tracedInputs(entry));
            else
                skip("dominant light of '" + entry.name + "'", "no material is specular", entry.name, 2 * bitsOf("flat"));
        }
        if (hasMesh && isDecided && (scene_.output.draco || hasLearnedBases(layout))) addMesh(entry, description, layout);
    }

    /// Where bases are learned, no two may meet on an island of the mesh: it counts as an input, if it is there.
    Inputs lightMapInputs(const LightMapEntry& entry, bool mayBeLearned) const {
        Inputs inputs = sourceOf(entry.file);
        std::error_code code;
        if (mayBeLearned && entry.mesh && std::filesystem::exists(*entry.mesh, code))
            inputs.merge(meshInputs(*entry.mesh, formats::GltfFiles::Geometry));
        return inputs;
    }

    /// Traced light is looked at by the verifier alone.
    Inputs tracedInputs(const LightMapEntry& entry) const {
        Inputs inputs = sourceOf(entry.file);
        if (entry.groundTruth) inputs[kGroundTruthRole] = *entry.groundTruth;
        return inputs;
    }

    void addMesh(const LightMapEntry& entry, const formats::LightMapDescription& description, const std::string& layout) {
        const std::string asset = meshAssetName(scene_, entry);
        const Inputs inputs = meshInputs(*entry.mesh);
        Inputs verifyInputs = sourceOf(entry.file);
        verifyInputs.insert(inputs.begin(), inputs.end());
        add(asset, "mesh", {{"description", toJson(description)}, {"draco", scene_.output.draco}, {"max_error", scene_.output.maxError}},
            scene_.output.draco ? verifyInputs : inputs, Json::object(), verifyInputs);
        plan_.meshes[asset] = entry.name;
        if (!hasLearnedBases(layout)) return;
        plan_.actions[plan_.actions.size() - 2].dependencies.push_back("cook/" + entry.name);
        plan_.actions.back().dependencies.push_back("cook/" + entry.name);
    }

    /// Of a probe: where it is one of six files, the others too.
    Inputs sourceOfProbe(const std::filesystem::path& file) const {
        Inputs inputs = sourceOf(file);
        std::error_code code;
        for (const std::filesystem::path& face : formats::faceFiles(file))
            if (face != file && std::filesystem::exists(face, code)) inputs["source-" + face.stem().string()] = face;
        return inputs;
    }

    void planProbe(const ProbeEntry& entry) {
        if (!wanted(entry.name, "cubemap", entry.name)) return;
        if (!needs_.specular) {
            // Eight levels of six BC6H faces: 4/3 of a byte a texel.
            skip("cubemap '" + entry.name + "'", "no material is specular", std::uint64_t{131072}, estimatedSeconds("cubemap", 0.131));
            return;
        }
        Json parameters = {{"colors", toJson(scene_.colors)},
                           {"target", std::string(formats::info(scene_.output.target).name)},
                           {"textures", textures_},
                           {"size", kCubemapSize},
                           {"repair", options_.repair}};
        Inputs inputs = sourceOfProbe(entry.file);
        if (entry.sh) {
            inputs["sh"] = *entry.sh;
            parameters["probe_file"] = entry.file.filename().string();  // by which the SH is found in that file
        }
        add(entry.name, "cubemap", std::move(parameters), inputs, Json::object(), sourceOfProbe(entry.file));
    }

    static std::uint64_t rsrmBytes(const GradientEntry& entry, std::size_t rows) {
        const std::size_t blockRows = (rows + 3) / 4;
        return entry.format == "rgba8" ? rows * kRsrmWidth * 4 : blockRows * (kRsrmWidth / 4) * (entry.format == "bc7" ? 16 : 8);
    }

    void planGradient(const GradientEntry& entry) {
        if (!wanted(entry.name, "rsrm", entry.name)) return;
        std::vector<double> exponents = entry.exponents;
        if (!needs_.specular) {
            std::erase_if(exponents, [](double exponent) { return exponent != 1; });
            if (exponents.empty()) {
                skip("RSRM '" + entry.name + "'", "no material is specular, and no row of exponent 1 was asked for",
                     rsrmBytes(entry, entry.exponents.size()), 0);
                return;
            }
            if (exponents.size() < entry.exponents.size())
                skip("specular rows of RSRM '" + entry.name + "'", "no material is specular",
                     rsrmBytes(entry, entry.exponents.size()) - rsrmBytes(entry, exponents.size()), 0);
        }
        if (const std::string why = whyNotRsrm(entry, scene_.output.target); !why.empty() && !mistake_)
            mistake_ = {formats::ErrorCode::InvalidRequest, fmt::format("gradient '{}'", entry.name), why};
        Json parameters = {{"colors", toJson(scene_.colors)}, {"exponents", exponents}, {"width", kRsrmWidth},
                           {"format", entry.format},          {"dither", entry.dither}, {"textures", textures_},
                           {"repair", options_.repair}};
        if (entry.axis) {
            parameters["axis"] = {entry.axis->x, entry.axis->y, entry.axis->z};
            parameters["zones"] = entry.zones;
        } else {
            parameters["encoding"] = entry.encoding;
        }
        add(entry.name, "rsrm", std::move(parameters), sourceOf(entry.file), Json::object(), sourceOf(entry.file));
    }

    void planTables() {
        if ((scene_.lightMaps.empty() && scene_.materials.empty()) || !wanted("specular", "lut", "specular")) return;
        const TableSettings& tables = scene_.tables;
        if (!needs_.specular) {
            skip("Cook-Torrance tables", "no material is specular", static_cast<std::uint64_t>(16 * tables.viewCount * 24),
                 estimatedSeconds("lut", 16 * tables.viewCount * 1e-6));
            return;
        }
        const TableRows rows = tableRowsFor(needs_);
        if (rows.count < 16 && !tables.roughnessCount)
            skip(fmt::format("{} of 16 roughness rows of the Cook-Torrance tables", 16 - rows.count),
                 fmt::format("materials use m from {} to {} only", needs_.m.low, needs_.m.high),
                 static_cast<std::uint64_t>((16 - rows.count) * tables.viewCount * 24),
                 estimatedSeconds("lut", (16 - rows.count) * tables.viewCount * 1e-6));
        add("specular", "lut",
            {{"lobe", tables.lobe},
             {"normalization", tables.normalization},
             {"view_count", tables.viewCount},
             {"roughness_count", tables.roughnessCount.value_or(rows.count)},
             {"minimum_m", tables.roughnessCount ? needs_.m.low : rows.minimumM()},
             {"maximum_m", tables.roughnessCount ? needs_.m.high : rows.maximumM()},
             {"view_axis", tables.viewAxis},
             {"roughness_axis", tables.roughnessAxis},
             {"f0", {needs_.f0.low, needs_.f0.high}},
             {"textures", textures_}},
            {}, {{"shading", toJson(shading_)}}, {});
    }

    void skip(std::string what, std::string why, std::uint64_t bytes, double seconds) {
        plan_.skipped.push_back({std::move(what), std::move(why), bytes, seconds});
    }

    void skip(std::string what, std::string why, std::string lightMap, double bitsPerTexel) {
        plan_.skipped.push_back({std::move(what), std::move(why), 0, 0, std::move(lightMap), bitsPerTexel});
    }
    /// Bits a texel of a layout under the scene's target: nine coefficients or one value, in blocks of 8 bits or halves of 64.
    double bitsOf(const std::string& layout) const {
        static const std::map<std::string, double> kTextures = {{"flat", 1},    {"luvw", 18},    {"luvw-linear", 10}, {"ratio", 9},
                                                                {"zh3", 5},     {"raw", 9},      {"basis-3", 1.5},    {"basis-4", 2},
                                                                {"basis-8", 3}, {"basis-12", 4}, {"basis-16", 5},     {kAutoLayout, 9}};
        const double textures = kTextures.at(layout);
        return textures * (scene_.output.target == Target::Float || layout == "raw" ? 64 : 8);
    }

    const Scene& scene_;
    const Needs& needs_;
    const PlanOptions& options_;
    Json textures_;
    verify::LightMapShading shading_;
    Plan plan_;
    std::vector<std::string> knownNames_;
    std::set<std::string> fileNames_;
    std::string takenName_;                  ///< the first that two assets would use
    std::optional<formats::Error> mistake_;  ///< the first thing asked for that cannot be
};

}  // namespace

std::vector<Action> planNeeds(const Scene& scene) {
    std::vector<Action> actions;
    std::set<std::filesystem::path> meshes;
    for (const LightMapEntry& entry : scene.lightMaps)
        if (entry.mesh && meshes.insert(*entry.mesh).second)
            actions.push_back({"materials/" + entry.mesh->string(),
                               "materials",
                               entry.mesh->filename().string(),
                               Json::object(),
                               meshInputs(*entry.mesh),
                               {}});
    return actions;
}

bool hasLearnedBases(const std::string& layout) {
    return layout.starts_with("basis-");
}

Action verifyAction(const std::string& asset, const std::string& kind, const std::map<std::string, std::filesystem::path>& sources,
                    Json parameters) {
    return {"verify/" + asset, "verify-" + kind, asset, std::move(parameters), sources, {"cook/" + asset}};
}

formats::Result<Plan> planScene(const Scene& scene, const Needs& needs, const PlanOptions& options) {
    Planner planner(scene, needs, options);
    auto planned = std::move(planner).plan();
    if (!planned) return planned;
    const Plan& plan = *planned;
    if (options.only && plan.assets.empty() && plan.skipped.empty() && plan.undecided.empty())
        return formats::failure(formats::ErrorCode::InvalidRequest, "--only",
                                fmt::format("found '{}', expected an asset of the scene; nearest is '{}'", *options.only,
                                            formats::nearestName(*options.only, planner.knownNames())));
    return planned;
}

}  // namespace lightcook::pipeline
