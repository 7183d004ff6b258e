#include "pipeline/cook/contents.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "formats/light_map_layout.h"
#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/cubemap/probe_use.h"
#include "pipeline/assets/light_map/floor.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/results.h"
#include "pipeline/scene/dominant_layout.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

using Layout = formats::LightMapLayout;

/// Largest rel_rms of bands that are left out unasked, and its largest share of the limit.
constexpr double kInvisibleError = 0.005, kInvisibleShare = 0.25;

std::string_view nameOf(formats::LightMapLayout layout) {
    return formats::info(layout).name;
}

/// Returns the fit of the dominant light of a map; nothing where it is not cooked.
std::optional<std::string> dominantFitFor(const LightMapEntry& entry, bool isSpecular, const PlanOptions& options) {
    if (!isSpecular || (options.onlyKind && *options.onlyKind != info(AssetKind::Dominant).name)) return std::nullopt;
    if (entry.dominantLayout == kNoDominant) return std::nullopt;
    return entry.dominantFit;
}

Action contentAction(const Scene& scene, const LightMapEntry& entry, const verify::LightMapShading& shading, const PlanOptions& options) {
    LightMapContentParameters parameters{entry.description, shading, errorLimit(scene.output),
                                         dominantFitFor(entry, shading.specular, options)};
    parameters.description.repair = options.repair;
    return {actionId(ActionStep::Content, entry.name),
            kContentKind,
            entry.name,
            toJson(parameters),
            bakeInputs(entry.file, entry.description),
            {}};
}

/// Returns true if a light map may take a layout: the lists of layouts have it, and the engine can decode it.
bool mayTake(const Scene& scene, const LightMapEntry& entry, const formats::LightMapLayoutInfo& layout) {
    return formats::mayTake(layoutsFor(scene.output, entry), layout) && scene.output.decode.allow(layout);
}

/// Returns true if a light map may be cooked in a layout whose texels are decoded before they are filtered: it loses nothing at rims.
bool mayBeDecoded(const Scene& scene, const LightMapEntry& entry) {
    const auto asked = formats::lightMapLayoutFromName(layoutAsked(scene.output));
    const formats::DecodeLimits decode = decodeOf(scene, entry, false);
    return std::ranges::any_of(formats::allLightMapLayouts(), [&](const formats::LightMapLayoutInfo& layout) {
        const bool isTaken =
            asked ? *asked == layout.id : formats::isCandidate(layoutsFor(scene.output, entry), layout) && decode.allow(layout);
        return isTaken && decode.filterOf(layout) == formats::LightMapFilter::Decoded;
    });
}

/// Returns the action that measures the floor of a light map: of what a filter of the hardware loses at rims. Empty: no limit was given
/// that it could be above, or another filter may be taken.
std::optional<Action> floorAction(const Scene& scene, const LightMapEntry& entry, const verify::LightMapShading& shading,
                                  const PlanOptions& options) {
    if (!scene.output.limits[Limit::Error] && !askedVisibleLimit(scene.output, entry)) return std::nullopt;
    if (mayBeDecoded(scene, entry)) return std::nullopt;
    LightMapFloorParameters parameters{entry.description, shading, scene.display};
    parameters.description.repair = options.repair;
    return Action{actionId(ActionStep::Floor, entry.name),   kFloorKind, entry.name, toJson(parameters),
                  bakeInputs(entry.file, entry.description), {}};
}

/// Returns what to do about a floor.
std::string remedyOf(const Scene& scene, const LightMapEntry& entry) {
    const std::string pack = entry.mesh && !isPacked(scene.output, entry) ? ", or charts = \"pack\" lays them out anew" : "";
    return fmt::format(
        "take a layout that is decoded before the filter, such as lit-half, leave two texels or more between the charts of the "
        "bake{}, or raise the limit",
        pack);
}

/// Returns the action that finds unused probes, if there are enough probes that a place may do without one.
std::optional<Action> probeUseAction(const Scene& scene) {
    ProbeUseParameters parameters;
    std::map<std::string, std::filesystem::path> inputs;
    for (const ProbeEntry& probe : scene.probes) {
        if (!probe.place.position && !probe.sh) continue;
        PlacedProbe placed{probe.name, {}, probe.file.filename().string(), probe.place.position};
        if (!placed.position) {
            placed.role = fmt::format("sh{}", parameters.probes.size());
            inputs[placed.role] = *probe.sh;
        }
        parameters.probes.push_back(std::move(placed));
    }
    std::set<std::filesystem::path> meshes;
    for (const LightMapEntry& entry : scene.lightMaps) {
        // Light maps without a mesh are surfaces whose place nobody knows.
        if (!entry.mesh) return std::nullopt;
        if (!meshes.insert(*entry.mesh).second) continue;
        parameters.meshes.push_back(fmt::format("mesh{}", parameters.meshes.size()));
        inputs.merge(meshInputs(parameters.meshes.back(), *entry.mesh, {}, formats::GltfFiles::Geometry));
    }
    if (parameters.probes.size() <= kProbesOfAPlace || parameters.meshes.empty()) return std::nullopt;
    return Action{kProbeUseId, kProbeUseKind, "probes", toJson(parameters), std::move(inputs), {}};
}

/// Returns true if bands of this error may be left out although nobody asked for it.
bool isInvisible(const std::optional<double>& error, const OutputSettings& output) {
    return error && *error <= std::min(kInvisibleError, kInvisibleShare * errorLimit(output));
}

/// Returns why a light map needs no more than a layout without some bands. Empty: they are seen, or no list has the layout.
/// error  without these bands
std::string whyEnough(const Scene& scene, const LightMapEntry& entry, Layout layout, std::string_view bands,
                      const std::optional<double>& error) {
    if (!isInvisible(error, scene.output) || !formats::mayTake(layoutsFor(scene.output, entry), formats::info(layout))) return "";
    return fmt::format("without {} the error is {:.2g} %", bands, 100 * *error);
}

/// Returns the layout of a map of constant light where nothing is tried: flat if no directions are needed; else raw, which holds the light
/// exactly, or under a budget ratio, in few bytes. Empty: the map may not take it.
std::optional<Layout> untriedLayout(const Scene& scene, const Needs& needs, const LightMapEntry& entry) {
    std::vector<Layout> choices;
    if (!needs.needsDirections()) choices.push_back(Layout::Flat);
    choices.push_back(scene.output.budgetBytes ? Layout::Ratio : Layout::Raw);
    const auto choice = std::ranges::find_if(choices, [&](Layout layout) { return mayTake(scene, entry, formats::info(layout)); });
    return choice == choices.end() ? std::nullopt : std::optional(*choice);
}

bool mayTakeLearned(const Scene& scene, const LightMapEntry& entry) {
    return std::ranges::any_of(formats::allLightMapLayouts(), [&](const formats::LightMapLayoutInfo& layout) {
        return layout.isLearned() && mayTake(scene, entry, layout);
    });
}

}  // namespace

std::vector<Action> planContents(const Scene& scene, const Needs& needs, const PlanOptions& options) {
    std::vector<Action> actions;
    const verify::LightMapShading shading = shadingOf(scene, needs);
    for (const LightMapEntry& entry : scene.lightMaps)
        if (isWanted(options, entry.name, AssetKind::LightMap, entry.name))
            if (auto floor = floorAction(scene, entry, shading, options)) actions.push_back(std::move(*floor));
    if (scene.output.keepUnused) return actions;
    for (const LightMapEntry& entry : scene.lightMaps)
        if (isAnyWanted(scene, options, entry)) actions.push_back(contentAction(scene, entry, shading, options));
    const auto isProbeWanted = [&](const ProbeEntry& entry) { return isWanted(options, entry.name, AssetKind::Cubemap, entry.name); };
    if (needs.specular && std::ranges::any_of(scene.probes, isProbeWanted))
        if (auto use = probeUseAction(scene)) actions.push_back(std::move(*use));
    return actions;
}

formats::Result<void> addContents(const ExecutionResult& contents, Needs& needs) {
    for (const auto& [id, record] : contents.records) {
        if (id == kProbeUseId) {
            LC_TRY(use, fromJson<ProbeUseResult>(record.result, id));
            needs.unusedProbes.insert(use->unused.begin(), use->unused.end());
            continue;
        }
        if (isOfStep(id, ActionStep::Floor)) continue;
        LC_TRY(content, fromJson<LightMapContent>(record.result, id));
        needs.contents.emplace(actionSubject(id, ActionStep::Content), *content);
    }
    return {};
}

formats::Result<std::vector<formats::Error>> errorsOfFloors(const Scene& scene, const ExecutionResult& contents) {
    constexpr double kSure = 0.9;  // a floor is a sample, and another layout may lose a little less than raw
    std::vector<formats::Error> errors;
    for (const LightMapEntry& entry : scene.lightMaps) {
        const auto record = contents.records.find(actionId(ActionStep::Floor, entry.name));
        if (record == contents.records.end()) continue;
        LC_TRY(floor, fromJson<LightMapFloor>(record->second.result, record->second.id));
        const auto hold = [&](const char* key, const std::optional<double>& limit, double found, const std::string& words) {
            if (!limit || *limit >= kSure * found) return;
            const std::string at =
                floor->texel ? fmt::format(", most at texel ({:.0f}, {:.0f})", (*floor->texel)[0], (*floor->texel)[1]) : "";
            errors.push_back(
                {formats::ErrorCode::Verification, entry.name,
                 fmt::format("found {} = {:.4g}, expected at least {}, the floor of this bake: {:.2g} % of its surface lies at "
                             "rims of charts, where a filter reads texels outside them, and no layout that it reads errs less there{}; {}",
                             key, *limit, words, 100 * floor->rimShare, at, remedyOf(scene, entry))});
            errors.back().asset = entry.name;
        };
        hold("max_error", scene.output.limits[Limit::Error], floor->relRms, fmt::format("{:.4g}", floor->relRms));
        hold("max_visible", askedVisibleLimit(scene.output, entry), floor->visible, fmt::format("{:.3g}", floor->visible));
    }
    return errors;
}

formats::DecodeLimits decodeOf(const Scene& scene, const LightMapEntry& entry, bool isConstant) {
    formats::DecodeLimits limits = scene.output.decode;
    if (isConstant || hasMips(scene.output, entry) || scene.output.cost == formats::LayoutCost::Fetches)
        limits.preferred = formats::LightMapFilter::Hardware;
    else if (limitsOf(scene.output, entry)[Limit::VisibleBound])  // a sampler's tolerance counts in the bound
        limits.preferred = formats::LightMapFilter::Decoded;
    return limits;
}

LightMapReduction reductionOf(const Scene& scene, const Needs& needs, const LightMapEntry& entry, const std::string& asked) {
    LightMapReduction reduction;
    reduction.layout = asked;
    reduction.isFlatTried = asked == kAutoLayout && !needs.needsDirections();
    const auto found = needs.contents.find(entry.name);
    if (found == needs.contents.end()) return reduction;
    const LightMapContent& content = found->second;
    const bool isAuto = asked == kAutoLayout;
    reduction.hasDirections = content.errorOfOrder0 != 0.0;
    reduction.hasDominant = !content.isBlack && reduction.hasDirections && content.hasDominant;
    reduction.isDominantConstant = content.isConstant && content.hasOneNormal;
    const std::string whyFlat = whyEnough(scene, entry, Layout::Flat, "bands 1 and 2", content.errorOfOrder0);
    const std::string whySh4 = whyEnough(scene, entry, Layout::Sh4, "band 2", content.errorOfOrder1);
    const std::optional<Layout> untried = isAuto ? untriedLayout(scene, needs, entry) : std::nullopt;
    const bool mayBeLearned = isAuto ? !untried && mayTakeLearned(scene, entry) : hasLearnedBases(asked);
    // The light of a layout in tangent space differs from surface to surface.
    if (content.isConstant && !mayBeLearned && !entry.description.takesTangents) {
        // One block takes too few bytes to trade for those of other assets. It is tried like any map where limits on the errors of light
        // maps choose, but not where a budget or a limit on the whole shading does.
        const OutputSettings& output = scene.output;
        const bool isTried = !output.isWholeLimited() && (!output.budgetBytes || isErrorLimited(output, entry));
        if (untried && !isTried) reduction.layout = nameOf(*untried);
        reduction.isFlatTried = isAuto && (reduction.isFlatTried || content.errorOfOrder0);
        reduction.constantOf = {content.width, content.height};
        reduction.why = fmt::format("all {} covered texels hold the same light: one block of {} x {} texels is enough", content.covered,
                                    kConstantSide, kConstantSide);
        return reduction;
    }
    if (!isAuto) return reduction;
    if (content.errorOfOrder0) reduction.isFlatTried = true;
    if (needs.needsDirections()) reduction.whyFlat = whyFlat;
    reduction.whySh4 = whySh4;
    return reduction;
}

std::string LightMapReduction::whyWithoutBands(const std::string& chosen) const {
    if (formats::isFlat(chosen)) return whyFlat;
    return chosen == nameOf(formats::LightMapLayout::Sh4) ? whySh4 : "";
}

}  // namespace lightcook::pipeline
