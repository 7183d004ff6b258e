#include "pipeline/cook/patch.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/light_map/kept_plan.h"
#include "pipeline/assets/light_map/whole_errors.h"
#include "pipeline/assets/results.h"
#include "pipeline/assets/verification.h"
#include "pipeline/document/json_difference.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Returns the first setting of a scene that differs from that of its last cook; empty if none does.
std::string changedSetting(const Json& before, const Json& now) {
    std::string changed;
    const auto note = [&](const std::string& path, const Json&, const Json&) {
        if (changed.empty()) changed = path;
    };
    eachDifference(before, now, note);
    eachDifference(now, before, note);
    return changed;
}

/// Returns true if the bake of a light map is no longer that of its cook. Fails if another file of its sources is not.
/// sources  folder that they are named relative to
Result<bool> isBakedAgain(const CookedAsset& asset, const std::filesystem::path& sources, DigestMemo& digests) {
    bool isAgain = false;
    for (const auto& [role, source] : asset.source.files.value_or(std::map<std::string, SourceFile>())) {
        const std::filesystem::path file = sources / source.file;
        if (const auto digest = digests.of(file); digest && *digest == source.digest) continue;
        if (!role.starts_with(kSourceRole))
            return failure(ErrorCode::Verification, asset.name, fmt::format("found another {}, expected other bakes alone", source.file));
        isAgain = true;
    }
    return isAgain;
}

}  // namespace

Result<Decisions> keptDecisions(const Scene& scene, const PlanOptions& options, const std::filesystem::path& folder, const PartCache& parts,
                                DigestMemo& digests) {
    const std::filesystem::path file = folder / kManifestName;
    LC_TRY(manifest, loadManifest(folder));
    if (manifest->isPreview || manifest->incomplete || manifest->cooks.size() != 1)
        return failure(ErrorCode::Verification, file, "found a folder that is no single whole cook, expected one");
    const CookRecord& last = manifest->cooks.front();
    if (const std::string changed = changedSetting(last.scene, scene.document); !changed.empty())
        return failure(ErrorCode::Verification, file, fmt::format("found another {}, expected the settings of this scene", changed));
    if (last.repair != options.repair || last.samples != options.samples)
        return failure(ErrorCode::Verification, file, "found another --repair or --samples, expected those of this cook");
    Decisions decisions = last.decisions;
    for (const LightMapEntry& entry : scene.lightMaps) {
        const auto asset = std::ranges::find(manifest->assets, entry.name, &CookedAsset::name);
        if (asset == manifest->assets.end() || asset->kind != AssetKind::LightMap) continue;
        LC_TRY(isAgain, isBakedAgain(*asset, folder / manifest->sceneDirectory, digests));
        if (!*isAgain) continue;
        if (isPacked(scene.output, entry))
            return failure(ErrorCode::Verification, entry.name, "found a bake whose charts are packed anew, expected one that keeps them");
        const auto plan = EncodingPlan::find(parts, asset->plan.value_or(""));
        if (!plan)
            return failure(ErrorCode::Verification, entry.name,
                           "found no plan of its last cook in the cache, expected that of this program's cook on this machine");
        decisions.kept[entry.name] = {*asset->plan, plan->key, plan->displayKey};
    }
    if (!decisions.kept.empty() && decisions.keptFrom.empty()) {
        LC_TRY(text, readFile(file));
        const Json whole = parseJson(*text);
        if (const auto digest = whole.find("digest"); digest != whole.end() && digest->is_string())
            decisions.keptFrom = digest->get<std::string>();
    }
    return decisions;
}

std::string whyRefuted(const Scene& scene, const Plan& plan, const ExecutionResult& result) {
    if (!plan.undecided.empty() || plan.openTables)
        return fmt::format("{}: found what its last cook did not decide, expected no more than that", scene.name);
    if (!result.errors.empty()) return result.errors.front().line();
    std::uint64_t bytes = 0;
    for (const Action& action : plan.actions) {
        const auto record = result.records.find(action.id);
        if (record == result.records.end()) continue;
        const Json& found = record->second.result;
        bool isKept = true;
        if (isOfStep(action.id, ActionStep::Verify)) {
            const auto verified = fromJson<VerifyResult>(found, action.id);
            isKept = verified && passes(*verified);
        } else if (isOfStep(action.id, ActionStep::Whole)) {
            const auto whole = fromJson<WholeFigures>(found, action.id);
            isKept = whole && areKept(whole->checks());
        } else if (isOfStep(action.id, ActionStep::Cook)) {
            if (const auto cooked = fromJson<CookResult>(found, action.id)) bytes += cooked->asset.totalBytesGpu();
        }
        if (!isKept) return fmt::format("{}: found a limit that is missed, expected all to be kept", action.asset);
    }
    if (scene.output.budgetBytes && bytes > *scene.output.budgetBytes)
        return fmt::format("{}: found {} bytes, expected at most the budget", scene.name, bytes);
    return "";
}

}  // namespace lightcook::pipeline
