#include "pipeline/lint/lint.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "formats/environment.h"
#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/lint/judge.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;
using Inputs = std::map<std::string, std::filesystem::path>;

std::string lightMapFactsId(const LightMapEntry& entry) {
    return actionId(ActionStep::LintLightMap, entry.name);
}

Action meshAction(const LightMapEntry& entry, const formats::LightMapDescription& description) {
    Inputs inputs = bakeInputs(entry.file, entry.description);
    inputs.merge(meshInputs(kMeshRole, *entry.mesh, entry.description.lmbake, formats::GltfFiles::Geometry));
    return {actionId(ActionStep::LintMesh, entry.name), kLintMeshKind,     entry.name,
            toJson(MeshLintParameters{description}),    std::move(inputs), {}};
}

Action probeAction(const Scene& scene, const ProbeEntry& entry, bool repair) {
    // The image is read as stored: checks look at its 8-bit levels, and at SH that the baker computed in its colours.
    formats::ColorSpaces colors = scene.colors;
    if (colors.source == formats::kStatedSource) colors.source = formats::ColorSpaces().source;  // values as the file has them
    colors.working = colors.source;
    Inputs inputs = environmentInputs(entry.file, colors);
    ProbeLintParameters parameters{colors, repair, {}};
    if (entry.sh) {
        inputs["sh"] = *entry.sh;
        parameters.probeFile = entry.file.filename().string();
    }
    return {actionId(ActionStep::LintProbe, entry.name), kLintProbeKind, entry.name, toJson(parameters), std::move(inputs), {}};
}

Action gradientAction(const Scene& scene, const GradientEntry& entry, bool repair) {
    const GradientLintParameters parameters{scene.colors, repair, entry.encoding, entry.axis.has_value()};
    return {actionId(ActionStep::LintGradient, entry.name),
            kLintGradientKind,
            entry.name,
            toJson(parameters),
            environmentInputs(entry.file, scene.colors),
            {}};
}

/// Judges the scene from the records that there are.
class SceneJudge {
public:
    SceneJudge(const Scene& scene, const std::map<std::string, ActionRecord>& records) : scene_(scene), records_(records) {}

    Result<Findings> judge() {
        std::vector<ProbeFacts> probes;
        for (const ProbeEntry& entry : scene_.probes)
            if (const auto facts = factsOf<ProbeFacts>(actionId(ActionStep::LintProbe, entry.name))) {
                Findings findings = judgeProbe(entry, *facts);
                if (findings.empty()) probes.push_back(*facts);  // others say nothing of the units
                add(std::move(findings));
                add(judgePrimaries(entry.name, entry.file, scene_.colors.source, facts->primaries));
            }
        for (const GradientEntry& entry : scene_.gradients)
            if (const auto facts = factsOf<GradientFacts>(actionId(ActionStep::LintGradient, entry.name))) {
                add(judgeGradient(entry, *facts));
                add(judgePrimaries(entry.name, entry.file, scene_.colors.source, facts->primaries));
            }
        for (const LightMapEntry& entry : scene_.lightMaps) judgeLightMapAndMesh(entry, probes);
        add(judgeSettings(scene_));
        add(judgeMaterials(scene_, materials()));
        if (mistake_) return tl::make_unexpected(*mistake_);
        return std::move(findings_);
    }

private:
    void judgeLightMapAndMesh(const LightMapEntry& entry, const std::vector<ProbeFacts>& probes) {
        const auto facts = factsOf<LightMapFacts>(lightMapFactsId(entry));
        if (!facts) return;
        Findings findings = judgeLightMap(scene_, entry, *facts);
        const auto isOf = [](LintCheck check) { return [check](const Finding& finding) { return finding.check == check; }; };
        const bool isOtherQuantity =
            std::ranges::any_of(findings, isOf(LintCheck::WrongQuantity)) || std::ranges::any_of(findings, isOf(LintCheck::GammaCurve));
        const bool lacksNormals = std::ranges::any_of(findings, isOf(LintCheck::SomeZeroNormals));
        Findings ofMesh = entry.mesh ? judgeMeshOf(entry, facts->covered > 0 && !lacksNormals) : Findings();
        // Charts of another mesh, or at other places, are black where the map has no light.
        const bool isMisplaced = std::ranges::any_of(ofMesh, [](const Finding& finding) {
            return finding.check == LintCheck::WrongMesh || finding.check == LintCheck::FlippedV || finding.check == LintCheck::NoLmbake;
        });
        if (isMisplaced) std::erase_if(findings, isOf(LintCheck::BlackCharts));
        add(std::move(findings));
        add(judgePrimaries(entry.name, entry.file, entry.description.colors.source, facts->primaries));
        add(judgeGroundTruth(entry, *facts));
        // A wrong quantity or curve changes the brightness too.
        if (!isOtherQuantity) add(judgeUnits(entry, *facts, probes));
        add(std::move(ofMesh));
    }

    /// isComparable  the map has coverage; without any, a mesh has nothing to be compared with, and texels without a normal count as
    ///               uncovered
    Findings judgeMeshOf(const LightMapEntry& entry, bool isComparable) {
        const auto mesh = factsOf<MeshFacts>(actionId(ActionStep::LintMesh, entry.name));
        const auto isSameMap = [&](const LightMapEntry& other) { return other.file == entry.file; };
        const bool isCompared = mesh && mesh->hasUvs && isComparable, isWholeMap = std::ranges::count_if(scene_.lightMaps, isSameMap) == 1;
        Findings findings = judgeGodot(entry, isCompared && fits(entry, *mesh, isWholeMap));
        const auto addAll = [&](Findings more) { std::move(more.begin(), more.end(), std::back_inserter(findings)); };
        if (mesh) {
            // A map that Godot placed nodes in is compared with the nodes when their places are known.
            if (isCompared && findings.empty()) addAll(judgeMesh(entry, *mesh, isWholeMap));
            addAll(judgeLmbake(entry, *mesh));
            addAll(judgePlaces(entry, withoutAnyPlace(entry)));
            addAll(judgeExtensions(scene_, entry, mesh->unreadMaterials));
        }
        addAll(judgeAge(entry));
        return findings;
    }

    /// Returns the nodes that have a place in none of the light maps of a mesh: for the first of these maps, and only if all have places.
    std::vector<std::string> withoutAnyPlace(const LightMapEntry& entry) {
        std::optional<std::vector<std::string>> common;
        for (const LightMapEntry& other : scene_.lightMaps) {
            if (other.mesh != entry.mesh) continue;
            if (!common && &other != &entry) return {};  // not the first
            const auto mesh = factsOf<MeshFacts>(actionId(ActionStep::LintMesh, other.name));
            if (!mesh || other.description.places.empty()) return {};
            if (!common) common = mesh->withoutPlace;
            std::erase_if(*common,
                          [&](const std::string& node) { return std::ranges::find(mesh->withoutPlace, node) == mesh->withoutPlace.end(); });
        }
        return common.value_or(std::vector<std::string>());
    }

    std::vector<MaterialRecord> materials() {
        std::vector<MaterialRecord> all;
        for (const LightMapEntry& entry : scene_.lightMaps) {
            if (!entry.mesh) continue;
            const auto facts = factsOf<MaterialsResult>(actionId(ActionStep::Materials, entry.mesh->string()));
            if (!facts) return {};  // a mesh that could not be read may have any name
            all.insert(all.end(), facts->materials.begin(), facts->materials.end());
        }
        return all;
    }

    template <class Facts>
    std::optional<Facts> factsOf(const std::string& id) {
        const auto record = records_.find(id);
        if (record == records_.end()) return std::nullopt;
        auto facts = fromJson<Facts>(record->second.result, id);
        if (facts) return std::move(*facts);
        mistake_ = facts.error();
        return std::nullopt;
    }

    void add(Findings findings) { std::move(findings.begin(), findings.end(), std::back_inserter(findings_)); }

    const Scene& scene_;
    const std::map<std::string, ActionRecord>& records_;
    Findings findings_;
    std::optional<formats::Error> mistake_;  ///< a record of another shape
};

/// Adds the line of the scene file: of the key, or else of its table.
void addLine(const Scene& scene, Finding& finding) {
    const auto line = scene.lines.find(finding.place.section, finding.place.name, finding.place.key);
    if (!line) return;
    finding.sceneFile = scene.file.string();
    finding.line = line;
}

void allow(const Scene& scene, Finding& finding) {
    for (const Allowance& each : scene.allowances)
        if (each.check == finding.check && (each.asset.empty() || each.asset == finding.asset)) finding.allowed = each.reason;
}

}  // namespace

std::vector<Action> planLint(const Scene& scene, bool repair, const std::optional<std::set<std::string>>& assets) {
    const auto isMeant = [&](const std::string& name) { return !assets || assets->contains(name); };
    std::vector<Action> actions;
    for (const LightMapEntry& entry : scene.lightMaps) {
        if (!isMeant(entry.name)) continue;
        formats::LightMapDescription description = entry.description;
        description.repair = description.repair || repair;
        description.outputAxes = {};  // findings are in the axes of the mesh
        Inputs inputs = bakeInputs(entry.file, entry.description);
        if (entry.groundTruth) inputs[kGroundTruthRole] = *entry.groundTruth;  // a file that is missing is an error
        actions.push_back({lightMapFactsId(entry),
                           kLintLightMapKind,
                           entry.name,
                           toJson(LightMapLintParameters{description, entry.file.filename().string()}),
                           std::move(inputs),
                           {}});
        if (entry.mesh) actions.push_back(meshAction(entry, description));
    }
    for (const ProbeEntry& entry : scene.probes)
        if (isMeant(entry.name)) actions.push_back(probeAction(scene, entry, repair));
    for (const GradientEntry& entry : scene.gradients)
        if (isMeant(entry.name)) actions.push_back(gradientAction(scene, entry, repair));
    return actions;
}

Result<std::vector<Finding>> judgeScene(const Scene& scene, const std::map<std::string, ActionRecord>& records, bool isStrict) {
    LC_TRY(findings, SceneJudge(scene, records).judge());
    for (Finding& finding : *findings) {
        addLine(scene, finding);
        allow(scene, finding);
        if (isStrict && !finding.allowed && !finding.isNote()) finding.severity = LintSeverity::Error;
    }
    return findings;
}

std::vector<BakeReading> readingsOf(const Scene& scene, const std::map<std::string, ActionRecord>& records) {
    std::vector<BakeReading> readings;
    for (const LightMapEntry& entry : scene.lightMaps) {
        const auto record = records.find(lightMapFactsId(entry));
        if (record == records.end()) continue;
        if (auto facts = fromJson<LightMapFacts>(record->second.result, record->first)) readings.push_back(std::move(facts->reading));
    }
    return readings;
}

}  // namespace lightcook::pipeline
