#include "pipeline/cook/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <set>
#include <type_traits>

#include "formats/environment.h"
#include "formats/epic_light_maps.h"
#include "formats/gltf_scene.h"
#include "formats/light_map_layout.h"
#include "formats/nearest.h"
#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/cubemap/probe_use.h"
#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/assets/gltf/gltf.h"
#include "pipeline/assets/light_map/detailed_layout.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/light_map/joint_trial.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/trial.h"
#include "pipeline/assets/light_map/whole_errors.h"
#include "pipeline/assets/lut/lut.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/assets/rsrm/rsrm.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/assets/verification.h"
#include "pipeline/cook/contents.h"
#include "pipeline/cook/trial_actions.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/scene/checks.h"
#include "pipeline/scene/cubemap_layout.h"
#include "pipeline/scene/dominant_layout.h"
#include "pipeline/scene/rsrm_format.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

using Inputs = std::map<std::string, std::filesystem::path>;

/// Returns the bytes that something smaller saves; 0 if it is not smaller.
std::uint64_t savedBytes(std::uint64_t would, std::uint64_t is) {
    return would - std::min(is, would);
}

/// Returns the textures of a layout in a scene. "auto" counts as the layout "ratio".
std::vector<SkippedImages> imagesOf(const std::string& name, formats::Target target, const formats::DecodeLimits& decode) {
    const formats::LightMapLayoutInfo& layout =
        formats::info(formats::lightMapLayoutFromName(name).value_or(formats::LightMapLayout::Ratio));
    return texturesOf(layout, target, decode.filterOf(layout));
}

/// Returns the textures of a dominant light under a target.
std::vector<SkippedImages> dominantImages(formats::Target target) {
    std::vector<SkippedImages> images;
    for (const formats::PixelFormat format : dominantFormats(target)) images.push_back({format, 1});
    return images;
}

double texelsOf(const glm::ivec2& size) {
    return static_cast<double>(size.x) * size.y;
}

/// Returns the GPU memory of a cubemap with all its mips [bytes].
std::uint64_t cubemapBytes(int size, formats::Target target) {
    std::uint64_t bytes = 0;
    for (int side = size; side > 0; side /= 2) bytes += 6 * formats::bytesPerImage(formats::info(target).hdr, side, side);
    return bytes;
}

/// Returns the names without extension that the files of an asset may have.
std::vector<std::string> fileNames(const std::string& asset, AssetKind kind) {
    std::vector<std::string> names = {asset};
    for (const std::string& ending : info(kind).fileEndings()) names.push_back(asset + ending);
    return names;
}

/// GPU memory of the whole Cook-Torrance tables: three textures of 8 bytes a texel.
constexpr int kTableTexelBytes = 24;
constexpr int kTableRows = 16;

/// Plans the assets of a scene, kind by kind.
class ScenePlanner {
public:
    ScenePlanner(const Scene& scene, const Needs& needs, const PlanOptions& options) : scene_(scene), needs_(needs), options_(options) {
        textures_ = TextureSettings{scene.output.container, scene.output.zstd, scene.output.effort, scene.output.rdo};
        shading_ = shadingOf(scene, needs);
    }

    /// Call it once: it moves the plan out.
    formats::Result<Plan> plan() {
        for (const LightMapEntry& entry : scene_.lightMaps) planLightMap(entry);
        for (const ProbeEntry& entry : scene_.probes) planProbe(entry);
        for (const GradientEntry& entry : scene_.gradients) planGradient(entry);
        planTables();
        if (!takenName_.empty())
            return formats::failure(
                formats::ErrorCode::InvalidRequest, scene_.file,
                fmt::format("found two assets that would both write '{}', expected names that keep their files apart", takenName_));
        if (mistake_) return tl::make_unexpected(*mistake_);
        return std::move(plan_);
    }

    const std::vector<std::string>& knownNames() const { return knownNames_; }

private:
    /// parent  name or light map that the asset derives from
    template <class Parent>
    bool wanted(const std::string& asset, AssetKind kind, const Parent& parent) {
        const bool isWanted = wants(asset, kind, parent);
        knownNames_.push_back(asset);
        (isWanted ? plan_.wanted : plan_.unwanted).insert(asset);
        return isWanted;
    }
    bool wants(const std::string& asset, AssetKind kind, const std::string& parent) const {
        return isWanted(options_, asset, kind, parent);
    }
    /// The assets of a light map whose charts are packed anew are wanted together: textures and UVs of different packings do not match.
    bool wants(const std::string& asset, AssetKind kind, const LightMapEntry& entry) const {
        if (packedOf(entry) == nullptr || options_.assets) return isWanted(options_, asset, kind, entry.name);
        return (!options_.onlyKind || *options_.onlyKind == info(kind).name) && isAnyWanted(scene_, options_, entry);
    }

    /// Returns the display of the scene and the limits of an asset that is no light map.
    /// ofAsset  its own limits
    VisibleParameters visible(AssetKind kind, const Limits& ofAsset = {}) const {
        const double byDefault = kind == AssetKind::Cubemap ? kDefaultMaxCubemapError : kDefaultMaxError;
        return {scene_.display, converterLimits(scene_.output, byDefault, ofAsset)};
    }

    /// Notes the names of the files of an asset, which no other may have.
    void takeNames(const std::string& asset, AssetKind kind) {
        for (const std::string& name : fileNames(asset, kind))
            if (!fileNames_.insert(inLowerCase(name)).second && takenName_.empty()) takenName_ = name;
    }
    void addAsset(const std::string& asset, AssetKind kind) {
        takeNames(asset, kind);
        plan_.assets.push_back(asset);
    }

    /// Adds the actions that cook and verify an asset.
    /// dependencies  ids of actions that both wait for
    template <Described Parameters, Described VerifyParameters>
    void add(const std::string& asset, AssetKind kind, const Parameters& parameters, Inputs inputs,
             const VerifyParameters& verifyParameters, const Inputs& verifyInputs, const std::vector<std::string>& dependencies = {}) {
        addAsset(asset, kind);
        plan_.actions.push_back(
            {actionId(ActionStep::Cook, asset), std::string(info(kind).name), asset, toJson(parameters), std::move(inputs), dependencies});
        Action verify = verifyAction(asset, kind, verifyInputs, toJson(verifyParameters));
        verify.dependencies.insert(verify.dependencies.end(), dependencies.begin(), dependencies.end());
        plan_.actions.push_back(std::move(verify));
    }

    /// Returns the limits that a light map and its mesh are held to.
    Limits limitsOfMap(const LightMapEntry& entry) const {
        Limits limits = limitsOf(scene_.output, entry);
        if (options_.decisions.unlimited.contains(entry.name)) limits[Limit::Visible].reset();
        return limits;
    }

    void planLightMap(const LightMapEntry& entry) {
        if (entry.mesh && !mistake_)
            if (const auto uvs = formats::checkEpicUvs(entry.file, *entry.mesh, entry.description.image); !uvs) mistake_ = uvs.error();
        formats::LightMapDescription description = entry.description;
        description.repair = options_.repair;
        const LightMapReduction reduction = reductionOf(scene_, needs_, entry, lightMapLayoutFor(scene_, needs_, entry));
        std::string layout = reduction.layout;
        const std::optional<JointTrial> joint = jointTrialOf(entry, reduction);
        if (isAnyWanted(scene_, options_, entry)) plan_.lightMaps.push_back(entry.name);
        const bool isDecided = (layout != kAutoLayout && !joint) || options_.decisions.layouts.contains(entry.name);
        std::optional<double> detail;
        if (layout == kAutoLayout && isDecided) {
            const DetailedLayout chosen = DetailedLayout::ofName(options_.decisions.layouts.at(entry.name));
            if (!formats::lightMapLayoutFromName(chosen.layout)) {  // of a manifest that somebody wrote
                mistake_ = formats::Error{formats::ErrorCode::Verification, entry.name,
                                          fmt::format("found the layout '{}' in the decisions of its cook, expected one of lightcook's: "
                                                      "cook the scene again",
                                                      chosen.layout)};
                return;
            }
            layout = chosen.layout;
            detail = chosen.limit;
        } else if (scene_.output.detail == true && isDecided) {
            detail = limitsOfMap(entry)[Limit::Visible];
        }
        const bool mayBeLearned = !isDecided || hasLearnedBases(layout);
        const PackedLightMap* packed = packedOf(entry);
        const bool hasMesh = entry.mesh && (scene_.output.draco || mayBeLearned || packed != nullptr) &&
                             wanted(meshAssetName(scene_, entry), AssetKind::Mesh, entry);
        // A mesh whose vertices name clusters depends on its light map.
        const bool hasMap = wanted(entry.name, AssetKind::LightMap, entry) || (hasMesh && mayBeLearned);
        if (!mistake_ && ((hasMesh && scene_.output.draco) || (hasMap && entry.mesh && scene_.output.gltf)))
            if (const auto uvs = formats::checkAllLightMapUvs(*entry.mesh, description.places); !uvs) mistake_ = uvs.error();
        if ((hasMap || joint) && !isDecided) addTrial(entry, reduction, joint);
        if (hasMesh && !isDecided) takeNames(meshAssetName(scene_, entry), AssetKind::Mesh);
        if (hasMap && isDecided) addLightMap(entry, description, {layout, detail}, reduction);
        if (hasMap && isDecided && scene_.output.gltf && entry.mesh) addGltf(entry, description);
        planDominant(entry, description, reduction);
        if (hasMap && isDecided) addWhole(entry, reduction);
        if (hasMesh && isDecided && (scene_.output.draco || hasLearnedBases(layout) || packed != nullptr))
            addMesh(entry, description, layout);
        if (packed != nullptr)
            for (const std::string& asset : {entry.name, dominantNameOf(entry.name), meshAssetName(scene_, entry)})
                if (std::ranges::find(plan_.assets, asset) != plan_.assets.end()) plan_.packed[asset] = *packed;
    }

    /// Returns what a light map was repacked from; null for others.
    const PackedLightMap* packedOf(const LightMapEntry& entry) const {
        const auto packed = options_.packed.find(entry.name);
        return packed == options_.packed.end() ? nullptr : &packed->second;
    }

    /// Returns what is tried with a light map whose layout is chosen by what pixels show. Empty: neither a budget nor a limit asks for it,
    /// or the layout is given.
    std::optional<JointTrial> jointTrialOf(const LightMapEntry& entry, const LightMapReduction& reduction) const {
        if (!scene_.output.isChosenByWhole() || reduction.constantOf || reduction.layout != kAutoLayout) return std::nullopt;
        if (!wants(entry.name, AssetKind::LightMap, entry)) return std::nullopt;
        JointTrial joint;
        if (isDominantShown(entry, reduction)) joint.dominant = DominantTrial{entry.dominantFit, dominantLayoutOf(entry)};
        return joint;
    }

    /// Returns true if pixels show a dominant light of the map whose textures, if it has them, are as large as the map.
    bool isDominantShown(const LightMapEntry& entry, const LightMapReduction& reduction) const {
        return needs_.specular && reduction.hasDominant && wants(dominantNameOf(entry.name), AssetKind::Dominant, entry) &&
               (!reduction.isDominantConstant || dominantLayoutOf(entry) == kDerivedDominant);
    }

    /// Returns true if the shader derives the dominant light of a map.
    bool isDominantDerived(const LightMapEntry& entry, const LightMapReduction& reduction) const {
        return isDominantShown(entry, reduction) && dominantLayoutOf(entry) == kDerivedDominant;
    }

    std::optional<KeptMap> keptOf(const LightMapEntry& entry) const {
        const auto found = options_.decisions.kept.find(entry.name);
        return found == options_.decisions.kept.end() ? std::nullopt : std::optional(found->second);
    }

    /// Adds the verification of a light map and its dominant light together, where that chose their layouts, or nothing else verifies the
    /// light.
    void addWhole(const LightMapEntry& entry, const LightMapReduction& reduction) {
        const bool isDerived = isDominantDerived(entry, reduction);
        if (!scene_.output.isChosenByWhole() && !isDerived) return;
        if (reduction.constantOf || !wants(entry.name, AssetKind::LightMap, entry)) return;
        WholeVerifyParameters parameters{{shading_, scene_.display}, {}, isDerived, wholeLimits(scene_.output), keptOf(entry)};
        std::vector<std::string> dependencies = {actionId(ActionStep::Cook, entry.name)};
        if (isDominantShown(entry, reduction)) {
            parameters.fit = entry.dominantFit;
            const std::string dominant = dominantNameOf(entry.name);
            if (std::ranges::find(plan_.assets, dominant) != plan_.assets.end())
                dependencies.push_back(actionId(ActionStep::Cook, dominant));
        }
        plan_.actions.push_back({actionId(ActionStep::Whole, entry.name), kVerifyWholeKind, entry.name, toJson(parameters),
                                 bakeInputs(entry.file, entry.description), std::move(dependencies)});
    }

    void addTrial(const LightMapEntry& entry, const LightMapReduction& reduction, const std::optional<JointTrial>& joint) {
        plan_.undecided.push_back(entry.name);
        takeNames(entry.name, AssetKind::LightMap);
        const TrialParameters parameters =
            trialParametersOf(scene_, needs_, entry, reduction, options_.repair, joint, options_.areTrialsComplete);
        plan_.actions.push_back(trialAction(entry, parameters, joint));
    }

    void addLightMap(const LightMapEntry& entry, formats::LightMapDescription description, const DetailedLayout& detailed,
                     const LightMapReduction& reduction) {
        const std::string& layout = detailed.layout;
        description.constantOf = reduction.constantOf;
        std::optional<SceneView> visible;
        if (scene_.output.objective == formats::Objective::Visible && hasObjective(layout)) visible = SceneView{shading_, scene_.display};
        const auto kept = keptOf(entry);
        const LightMapVerifyParameters verification{shading_, options_.samples, scene_.display, limitsOfMap(entry), kept};
        Inputs verifyInputs = reduction.constantOf ? bakeInputs(entry.file, entry.description) : viewedInputs(entry);
        const PackedLightMap* packed = packedOf(entry);
        if (packed != nullptr && !reduction.constantOf) verifyInputs.merge(unpackedInputs(*packed));
        const formats::Target target = scene_.output.target;
        const formats::DecodeLimits decode = decodeOf(scene_, entry, reduction.constantOf.has_value());
        add(entry.name, AssetKind::LightMap,
            LightMapParameters{description, layout, target, textures_, visible, hasMips(scene_.output, entry),
                               decode.filterOf(formats::info(*formats::lightMapLayoutFromName(layout))), detailFor(entry, detailed, decode),
                               isDominantDerived(entry, reduction), kept},
            hasLearnedBases(layout) ? learnedInputsOf(entry) : bakeInputs(entry.file, entry.description), verification, verifyInputs);
        if (packed != nullptr) plan_.actions.back().parameters[kUnpackedKey] = toJson(packed->bake);
        const std::string asked = layoutAsked(scene_.output);
        const auto would = imagesOf(asked, target, decodeOf(scene_, entry, false)), is = imagesOf(layout, target, decode);
        if (reduction.constantOf)
            skip(entry.name, fmt::format("texels of light map '{}'", entry.name), reduction.why,
                 savedBytes(bytesOf(would, *reduction.constantOf), bytesOf(is, {kConstantSide, kConstantSide})),
                 {"light-map", texelsOf(*reduction.constantOf)});
        else if (const std::string why = reduction.why.empty() ? reduction.whyWithoutBands(layout) : reduction.why; !why.empty())
            skip(entry.name, fmt::format("bands of light map '{}'", entry.name), why, "light-map", entry.name, would, is);
        else if (formats::isFlat(layout) && asked != layout && asked != kAutoLayout)
            skip(entry.name, fmt::format("directional light map '{}'", entry.name),
                 "no material has a normal map or is specular: a flat exit-radiance map is enough", "light-map", entry.name, would, is);
    }

    /// Returns the detail of a light map; nothing where its decode allows none.
    std::optional<DetailParameters> detailFor(const LightMapEntry& entry, const DetailedLayout& detailed,
                                              const formats::DecodeLimits& decode) const {
        const formats::LightMapLayoutInfo& layout = formats::info(*formats::lightMapLayoutFromName(detailed.layout));
        if (!detailed.limit || hasMips(scene_.output, entry)) return std::nullopt;
        if (!formats::mayHaveDetail(layout, decode, formats::info(scene_.output.target))) return std::nullopt;
        return DetailParameters{{shading_, scene_.display}, *detailed.limit};
    }

    void planDominant(const LightMapEntry& entry, formats::LightMapDescription description, const LightMapReduction& reduction) {
        const std::string dominant = dominantNameOf(entry.name);
        if (!wanted(dominant, AssetKind::Dominant, entry)) return;
        const std::vector<SkippedImages> images = dominantImages(scene_.output.target);
        const auto leaveOut = [&](const char* why) {
            skip(dominant, "dominant light of '" + entry.name + "'", why, "dominant", entry.name, images, {});
        };
        if (!needs_.specular) return leaveOut("no material is specular");
        const auto content = needs_.contents.find(entry.name);
        const glm::ivec2 size =
            content == needs_.contents.end() ? glm::ivec2(0) : glm::ivec2(content->second.width, content->second.height);
        if (!reduction.hasDominant)
            return leaveOut(reduction.hasDirections ? "no single light explains enough of any texel: all specular light is area specular"
                                                    : "the light map has no directions");
        const std::string layout = dominantLayoutOf(entry);
        if (layout == kDerivedDominant) return leaveOut("the shader derives it from the light map's coefficients");
        if (layout == kNoDominant) return leaveOut("the scene file leaves it out");
        if (reduction.isDominantConstant) {
            description.constantOf = size;
            skip(dominant, "texels of the dominant light of '" + entry.name + "'", "every covered texel has the same light and normal",
                 savedBytes(bytesOf(images, size), bytesOf(images, {kConstantSide, kConstantSide})), {"dominant", texelsOf(size)});
        }
        const DominantParameters parameters{description, entry.dominantFit, scene_.output.target, textures_, entry.name};
        Limits limits = visible(AssetKind::Dominant).limits;
        if (scene_.output.isChosenByWhole() && !scene_.output.limits[Limit::ConverterError]) limits[Limit::Error].reset();
        add(dominant, AssetKind::Dominant, parameters, bakeInputs(entry.file, entry.description),
            DominantVerifyParameters{{shading_, scene_.display}, limits},
            description.constantOf ? bakeInputs(entry.file, entry.description) : tracedInputs(entry));
    }

    std::string dominantLayoutOf(const LightMapEntry& entry) const {
        return entry.dominantLayout.value_or(std::string(usualDominantLayout(layoutAsked(scene_.output), entry.dominantFit)));
    }

    /// Returns the inputs of a verification with traced light, which no cook reads.
    Inputs tracedInputs(const LightMapEntry& entry) const {
        Inputs inputs = bakeInputs(entry.file, entry.description);
        if (entry.groundTruth) inputs[kGroundTruthRole] = *entry.groundTruth;
        return inputs;
    }

    /// Returns the inputs of a light map's verification: traced light, and the mesh for seams and views of the worst places.
    Inputs viewedInputs(const LightMapEntry& entry) const {
        Inputs inputs = tracedInputs(entry);
        std::error_code code;
        if (entry.mesh && std::filesystem::exists(*entry.mesh, code))
            inputs.merge(meshInputs(kSurfaceRole, *entry.mesh, entry.description.lmbake, formats::GltfFiles::Geometry));
        return inputs;
    }

    void addMesh(const LightMapEntry& entry, const formats::LightMapDescription& description, const std::string& layout) {
        const std::string asset = meshAssetName(scene_, entry);
        const Inputs inputs = meshInputs(kMeshRole, *entry.mesh, entry.description.lmbake);
        Inputs verifyInputs = bakeInputs(entry.file, entry.description);
        verifyInputs.insert(inputs.begin(), inputs.end());
        VisibleParameters visible{scene_.display, limitsOfMap(entry)};
        visible.limits[Limit::Error] = errorLimit(scene_.output);
        const MeshParameters parameters{description, scene_.output.draco, visible, entry.name};
        std::vector<std::string> dependencies;
        if (hasLearnedBases(layout)) dependencies = {actionId(ActionStep::Cook, entry.name)};
        add(asset, AssetKind::Mesh, parameters, scene_.output.draco ? verifyInputs : inputs, visible, verifyInputs, dependencies);
        plan_.meshes[asset] = entry.name;
    }

    /// Adds the scene as glTF with a light map bound to it, and with the first probe that the scene uses.
    void addGltf(const LightMapEntry& entry, const formats::LightMapDescription& description) {
        if (!fileNames_.insert(inLowerCase(gltfNameOf(entry.name))).second && takenName_.empty()) takenName_ = gltfNameOf(entry.name);
        GltfParameters parameters{description, kShaderName, options_.repair};
        Inputs inputs = bakeInputs(entry.file, entry.description);
        inputs.merge(meshInputs(kMeshRole, *entry.mesh, entry.description.lmbake));
        const auto probe = std::ranges::find_if(scene_.probes, [&](const auto& each) { return !needs_.unusedProbes.contains(each.name); });
        if (probe != scene_.probes.end()) {
            parameters.probe = {probe->name, scene_.colors, probe->file.filename().string()};
            for (const auto& [role, file] : environmentInputs(probe->file, scene_.colors))
                if (!isColorConfigRole(role)) inputs["probe-" + role] = file;
            if (probe->sh) inputs[kProbeShRole] = *probe->sh;
        }
        plan_.actions.push_back({actionId(ActionStep::Gltf, entry.name),
                                 kGltfKind,
                                 entry.name,
                                 toJson(parameters),
                                 std::move(inputs),
                                 {actionId(ActionStep::Cook, entry.name), actionId(ActionStep::Verify, entry.name)}});
    }

    void planProbe(const ProbeEntry& entry) {
        if (!wanted(entry.name, AssetKind::Cubemap, entry.name)) return;
        const auto leaveOut = [&](std::string why) {
            skip(entry.name, "cubemap '" + entry.name + "'", std::move(why), cubemapBytes(entry.size, scene_.output.target),
                 {"cubemap", static_cast<double>(entry.size) * entry.size});
        };
        if (!needs_.specular) return leaveOut("no material is specular");
        if (needs_.unusedProbes.contains(entry.name))
            return leaveOut(fmt::format("no place of the meshes has it among the {} nearest probes", kProbesOfAPlace));
        CubemapVerifyParameters verification{visible(AssetKind::Cubemap, entry.limits), {}};
        const int firstLevel = firstLevelOf(entry);
        verification.unreadLevels = unreadLevelsOf(needs_, entry.size) - firstLevel;
        if (firstLevel > 0) verification.smoothest = needs_.m.low;
        CubemapParameters parameters{.colors = scene_.colors,
                                     .target = scene_.output.target,
                                     .textures = textures_,
                                     .size = entry.size,
                                     .firstLevel = firstLevel,
                                     .layout = entry.layout,
                                     .repair = options_.repair,
                                     .lobe = shading_.lobe,
                                     .probeFile = {},
                                     .place = entry.place};
        Inputs inputs = environmentInputs(entry.file, scene_.colors);
        if (entry.sh) {
            inputs["sh"] = *entry.sh;
            parameters.probeFile = entry.file.filename().string();
        }
        add(entry.name, AssetKind::Cubemap, parameters, inputs, verification, inputs);
    }

    /// Returns the first level of a probe's chain that is cooked. Levels that no material reads are reported as skipped or, if they are
    /// cooked all the same, noted for the report.
    int firstLevelOf(const ProbeEntry& entry) {
        const int unread = unreadLevelsOf(needs_, entry.size), size = entry.size >> unread;
        if (unread == 0) return 0;
        const std::uint64_t bytes = cubemapBytes(entry.size, scene_.output.target) - cubemapBytes(size, scene_.output.target);
        if (scene_.output.keepUnused || !entry.readLevelsOnly) {
            // The note advises size = "auto". Beside that, keep_unused asked for the unread levels.
            if (!entry.readLevelsOnly) plan_.notes[entry.name] = {{note_keys::kUnreadLevels, unread}, {note_keys::kUnreadBytes, bytes}};
            return 0;
        }
        skip(entry.name, fmt::format("{} of {} levels of cubemap '{}'", unread, lastCubemapLevel(entry.size) + 1, entry.name),
             fmt::format("materials use m from {}, which reads no level larger than {} x {}", needs_.m.low, size, size), bytes,
             {"cubemap", static_cast<double>(entry.size) * entry.size - static_cast<double>(size) * size});
        return unread;
    }

    /// Returns the GPU memory of a reflection map [bytes]; if the cook chooses the format, that of rgba8.
    static std::uint64_t rsrmBytes(const GradientEntry& entry, std::size_t rows) {
        const RsrmFormatInfo* const format = rsrmFormatFromName(entry.format);
        return formats::bytesPerImage((format != nullptr ? *format : info(RsrmFormat::Rgba8)).pixels, kRsrmWidth, static_cast<int>(rows));
    }

    /// Returns the exponents whose rows the materials need, and reports the others as skipped. Empty: nothing is needed.
    std::vector<double> neededExponents(const GradientEntry& entry) {
        std::vector<double> exponents = entry.exponents;
        if (needs_.specular) return withoutUnusedExponents(entry);
        std::erase_if(exponents, [](double exponent) { return exponent != 1; });
        const double rowTexels = static_cast<double>(kRsrmWidth) * static_cast<double>(entry.exponents.size() - exponents.size());
        const std::uint64_t saved = rsrmBytes(entry, entry.exponents.size()) - (exponents.empty() ? 0 : rsrmBytes(entry, exponents.size()));
        if (exponents.empty())
            skip(entry.name, "RSRM '" + entry.name + "'", "no material is specular, and no row of exponent 1 was asked for", saved,
                 {"rsrm", rowTexels});
        else if (exponents.size() < entry.exponents.size())
            skip(entry.name, "specular rows of RSRM '" + entry.name + "'", "no material is specular", saved, {"rsrm", rowTexels});
        return exponents;
    }

    /// Returns the exponents up to the sharpest that a material reads, and reports the others as skipped.
    std::vector<double> withoutUnusedExponents(const GradientEntry& entry) {
        std::vector<double> exponents = entry.exponents;
        if (!needs_.isRoughnessKnown || scene_.output.keepUnused) return exponents;
        const double sharpest = largestExponentFor(needs_, exponents);
        std::erase_if(exponents, [&](double exponent) { return exponent > sharpest; });
        if (const std::size_t unused = entry.exponents.size() - exponents.size(); unused > 0)
            skip(entry.name, fmt::format("{} of {} rows of RSRM '{}'", unused, entry.exponents.size(), entry.name),
                 fmt::format("materials use m from {}, which reads exponents up to {}", needs_.m.low, sharpest),
                 rsrmBytes(entry, entry.exponents.size()) - rsrmBytes(entry, exponents.size()),
                 {"rsrm", static_cast<double>(kRsrmWidth) * static_cast<double>(unused)});
        return exponents;
    }

    void planGradient(const GradientEntry& entry) {
        if (!wanted(entry.name, AssetKind::Rsrm, entry.name)) return;
        const std::vector<double> exponents = neededExponents(entry);
        if (exponents.empty()) return;
        RsrmParameters parameters{
            .colors = scene_.colors,
            .exponents = exponents,
            .width = kRsrmWidth,
            .formats = entry.dither ? std::vector{std::string(info(RsrmFormat::Rgba8).name)}
                                    : rsrmFormatsToTry(entry.format, scene_.output.target, kRsrmWidth, static_cast<int>(exponents.size())),
            .limit = visible(AssetKind::Rsrm).limits[Limit::Error].value_or(kNoErrorLimit),
            .dither = entry.dither,
            .textures = textures_,
            .repair = options_.repair,
            .axis = entry.axis,
            .zones = {},
            .encoding = {},
            .north = glm::normalize(entry.axis.value_or(info(scene_.up).direction))};
        if (entry.axis)
            parameters.zones = entry.zones;
        else
            parameters.encoding = entry.encoding;
        const Inputs inputs = environmentInputs(entry.file, scene_.colors);
        add(entry.name, AssetKind::Rsrm, parameters, inputs, visible(AssetKind::Rsrm, entry.limits), inputs);
    }

    void planTables() {
        if ((scene_.lightMaps.empty() && scene_.materials.empty()) || !wanted(kTablesName, AssetKind::Lut, kTablesName)) return;
        const TableSettings& tables = scene_.tables;
        const bool doesBudgetChoose = areViewsOpen(tables, scene_.output), areOpen = doesBudgetChoose && !options_.decisions.tableViews;
        const int viewCount = doesBudgetChoose ? options_.decisions.tableViews.value_or(kLeastViewCount) : viewCountOf(tables);
        const auto skipRows = [&](std::string what, std::string why, int rows) {
            const int texels = rows * viewCount;
            skip(kTablesName, std::move(what), std::move(why), static_cast<std::uint64_t>(texels * kTableTexelBytes),
                 {"lut", static_cast<double>(texels)});
        };
        if (!needs_.specular) return skipRows("Cook-Torrance tables", "no material is specular", kTableRows);
        const TableRows rows = tableRowsFor(needs_);
        if (const int unused = kTableRows - rows.count; unused > 0 && !tables.roughnessCount)
            skipRows(fmt::format("{} of {} roughness rows of the Cook-Torrance tables", unused, kTableRows),
                     fmt::format("materials use m from {} to {} only", needs_.m.low, needs_.m.high), unused);
        if (areOpen) {
            const auto bytesWith = [&](int views) {
                return static_cast<std::uint64_t>(tables.roughnessCount.value_or(rows.count) * views * kTableTexelBytes);
            };
            plan_.openTables = TableBytes{bytesWith(kLeastViewCount), bytesWith(kFineViewCount)};
            return addAsset(kTablesName, AssetKind::Lut);
        }
        add(kTablesName, AssetKind::Lut,
            LutParameters{.lobe = scene_.lobe,
                          .normalization = tables.normalization,
                          .viewCount = viewCount,
                          .roughnessCount = tables.roughnessCount.value_or(rows.count),
                          .minimumM = tables.roughnessCount ? needs_.m.low : rows.minimumM(),
                          .maximumM = tables.roughnessCount ? needs_.m.high : rows.maximumM(),
                          .viewAxis = tables.viewAxis,
                          .roughnessAxis = tables.roughnessAxis,
                          .f0 = {needs_.f0.low, needs_.f0.high},
                          .format = std::string(formats::info(formats::info(scene_.output.target).table).name),
                          .textures = textures_},
            {}, LutVerifyParameters{shading_, visible(AssetKind::Lut, tables.limits)}, {});
    }

    void skip(std::string asset, std::string what, std::string why, std::uint64_t bytes, SkippedWork work) {
        plan_.skipped.push_back(
            {.what = std::move(what), .why = std::move(why), .asset = std::move(asset), .bytesSaved = bytes, .work = std::move(work)});
    }
    /// Reports images of a light map's size as skipped. A size that is not known yet is filled in when the map was cooked.
    void skip(std::string asset, std::string what, std::string why, std::string kind, std::string lightMap,
              std::vector<SkippedImages> images, std::vector<SkippedImages> instead) {
        if (const auto known = needs_.contents.find(lightMap); known != needs_.contents.end()) {
            const glm::ivec2 size(known->second.width, known->second.height);
            return skip(std::move(asset), std::move(what), std::move(why), savedBytes(bytesOf(images, size), bytesOf(instead, size)),
                        {std::move(kind), texelsOf(size)});
        }
        plan_.skipped.push_back({.what = std::move(what),
                                 .why = std::move(why),
                                 .asset = std::move(asset),
                                 .work = {std::move(kind), 0},
                                 .lightMap = std::move(lightMap),
                                 .images = std::move(images),
                                 .instead = std::move(instead)});
    }

    const Scene& scene_;
    const Needs& needs_;
    const PlanOptions& options_;
    TextureSettings textures_;
    verify::LightMapShading shading_;
    Plan plan_;
    std::set<std::string> fileNames_;  ///< in lower case: Windows and macOS do not tell the case of letters apart
    std::vector<std::string> knownNames_;
    std::string takenName_;                  ///< the first that two assets would use
    std::optional<formats::Error> mistake_;  ///< the first thing asked for that cannot be
};

}  // namespace

std::string dominantNameOf(const std::string& lightMap) {
    return lightMap + "_dominant";
}

std::vector<SkippedImages> texturesOf(const formats::LightMapLayoutInfo& layout, formats::Target target, formats::LightMapFilter filter) {
    std::vector<SkippedImages> images;
    for (const formats::LightMapTextureInfo& texture : layout.textures)
        images.push_back({formats::formatFor(texture.role, formats::info(target)), texture.layerCount, texture.side});
    if (filter == formats::LightMapFilter::Decoded) images.push_back({.format = formats::PixelFormat::Rgba8Unorm, .isCoverage = true});
    return images;
}

std::uint64_t bytesOf(const std::vector<SkippedImages>& images, const glm::ivec2& size) {
    std::uint64_t bytes = 0;
    for (const SkippedImages& each : images) {
        const glm::ivec2 texels = each.isCoverage ? formats::coverageSize(size.x, size.y) : formats::textureSize(size.x, size.y, each.side);
        bytes += static_cast<std::uint64_t>(each.layers) * formats::bytesPerImage(each.format, texels.x, texels.y);
    }
    return bytes;
}

bool isWanted(const PlanOptions& options, const std::string& asset, AssetKind kind, const std::string& parent) {
    if (options.assets) return options.assets->contains(asset);
    if (options.onlyKind && *options.onlyKind != info(kind).name) return false;
    return !options.only || *options.only == asset || *options.only == parent;
}

bool isAnyWanted(const Scene& scene, const PlanOptions& options, const LightMapEntry& entry) {
    return isWanted(options, entry.name, AssetKind::LightMap, entry.name) ||
           isWanted(options, dominantNameOf(entry.name), AssetKind::Dominant, entry.name) ||
           (entry.mesh && isWanted(options, meshAssetName(scene, entry), AssetKind::Mesh, entry.name));
}

std::string meshAssetName(const Scene& scene, const LightMapEntry& entry) {
    const auto isSharing = [&](const LightMapEntry& other) { return other.mesh && other.mesh->stem() == entry.mesh->stem(); };
    const std::string name = entry.mesh->stem().string() + "_mesh";
    return std::ranges::count_if(scene.lightMaps, isSharing) > 1 ? entry.name + "_" + name : name;
}

std::vector<Action> planNeeds(const Scene& scene) {
    std::vector<Action> actions;
    std::set<std::filesystem::path> meshes;
    for (const LightMapEntry& entry : scene.lightMaps)
        if (entry.mesh && meshes.insert(*entry.mesh).second)
            actions.push_back({actionId(ActionStep::Materials, entry.mesh->string()),
                               kMaterialsKind,
                               entry.mesh->filename().string(),
                               Json::object(),
                               meshInputs(kMeshRole, *entry.mesh, entry.description.lmbake),
                               {}});
    return actions;
}

Action verifyAction(const std::string& asset, AssetKind kind, const RoleFiles& sources, Json parameters) {
    return {
        actionId(ActionStep::Verify, asset), std::string(kVerifyKindPrefix).append(info(kind).name), asset, std::move(parameters), sources,
        {actionId(ActionStep::Cook, asset)}};
}

const Action& actionOf(const Plan& plan, const std::string& id) {
    return *std::ranges::find(plan.actions, id, &Action::id);
}

RoleFiles sourcesOf(const Plan& plan, const std::string& asset) {
    if (const auto packed = plan.packed.find(asset); packed != plan.packed.end()) return packed->second.sources;
    RoleFiles sources = actionOf(plan, actionId(ActionStep::Verify, asset)).inputs;
    const Inputs& ofCook = actionOf(plan, actionId(ActionStep::Cook, asset)).inputs;
    sources.insert(ofCook.begin(), ofCook.end());
    return sources;
}

std::set<std::string> inputsOf(const Scene& scene, std::set<std::string> assets) {
    for (const LightMapEntry& entry : scene.lightMaps)
        if (assets.contains(dominantNameOf(entry.name))) assets.insert(entry.name);
    return assets;
}

formats::Result<Plan> planScene(const Scene& scene, const Needs& needs, const PlanOptions& options) {
    ScenePlanner planner(scene, needs, options);
    LC_TRY(planned, planner.plan());
    const Plan& plan = *planned;
    if (options.only && plan.assets.empty() && plan.skipped.empty() && plan.undecided.empty())
        return formats::failure(
            formats::ErrorCode::InvalidRequest, "--only",
            fmt::format("found '{}', expected one of the assets of the scene: {}{}", *options.only, fmt::join(planner.knownNames(), ", "),
                        formats::nearestHint(*options.only, planner.knownNames())));
    return planned;
}

}  // namespace lightcook::pipeline
