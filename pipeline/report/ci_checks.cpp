#include "pipeline/report/ci_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pipeline/assets/light_map/unpacked_bake.h"
#include "pipeline/graph/version.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {
namespace {

CiRule ruleOf(const Failure& failure, const Verdict& verdict) {
    if (failure.seam) return CiRule::Seam;
    if (!failure.shading)  // a broken law, or a limit on a light map and its dominant light together
        return failure.visible ? CiRule::VisibleError : failure.relRms ? CiRule::SpecularError : CiRule::LocalError;
    const bool isDiffuse = *failure.shading == "diffuse";
    const auto stage = std::ranges::find(verdict.stages, failure.stage, &verify::StageError::name);
    if (stage != verdict.stages.end() && !isFinite(isDiffuse ? stage->diffuse : stage->specular)) return CiRule::FiniteFigures;
    if (failure.visible) return CiRule::VisibleError;
    return isDiffuse ? CiRule::DiffuseError : CiRule::SpecularError;
}

/// Returns the facts of a failure without its texts.
Json propertiesOf(const Failure& failure) {
    Json properties = toJson(failure);
    for (const char* key : {"subject", "detail", "message"}) properties.erase(key);
    return properties;
}

class RunBuilder {
public:
    explicit RunBuilder(const CiInputs& inputs) : inputs_(inputs) {
        if (inputs.report.is_object())
            if (auto report = fromJson<Report>(inputs.report, kReportName)) report_ = std::move(*report);
        if (auto manifest = loadManifest(inputs.folder)) manifest_ = std::move(*manifest);
        if (const std::filesystem::path file = sceneFile(); !file.empty())
            if (auto scenes = readScenes(file)) {
                const auto isCooked = [&](const Scene& each) {
                    return manifest_ && formats::info(each.output.target).name == manifest_->target;
                };
                const auto cooked = std::ranges::find_if(*scenes, isCooked);
                scene_ = std::move(cooked == scenes->end() ? scenes->front() : *cooked);
            }
    }

    CiRun build() && {
        run_.title =
            fmt::format("{} {} {}", kToolName, inputs_.command, (inputs_.sceneFile.empty() ? inputs_.folder : inputs_.sceneFile).string());
        run_.scene = report_ ? report_->scene : manifest_ ? manifest_->scene : scene_ ? scene_->name : "scene";
        run_.isLinted = inputs_.findings != nullptr;
        if (run_.isLinted) run_.lint = *inputs_.findings;
        run_.scenePlace = lineOf("");
        addSceneSuite();
        if (manifest_)
            for (const CookedAsset& asset : manifest_->assets) addSuite(asset);
        if (report_)
            for (const ReportRow& row : report_->assets)
                for (const Failure& failure : row.failures) addFailure(row, failure);
        for (const formats::Error& error : inputs_.errors) addError(error);
        return std::move(run_);
    }

private:
    std::filesystem::path sceneDirectory() const {
        if (!inputs_.sources.empty() || !manifest_) return inputs_.sources;
        return (inputs_.folder / manifest_->sceneDirectory).lexically_normal();
    }

    std::filesystem::path sceneFile() const {
        if (!inputs_.sceneFile.empty()) return inputs_.sceneFile;
        return manifest_ && manifest_->sceneFile ? sceneDirectory() / *manifest_->sceneFile : std::filesystem::path();
    }

    /// Returns the line of a key or table of the scene file; without one the first line of the scene file or the manifest.
    SourceLine lineOf(std::string_view section, std::string_view name = "", std::string_view key = "") const {
        if (!scene_) return {inputs_.sceneFile.empty() ? inputs_.folder / kManifestName : inputs_.sceneFile, 1};
        return {scene_->file, scene_->lines.find(section, name, key).value_or(1)};
    }

    /// Returns the name of the scene file's entry that an asset was cooked from. The tables have none.
    std::string entryOf(const CookedAsset& asset) const {
        if (asset.kind == AssetKind::Lut) return "";
        return asset.lightMap.value_or(asset.name);
    }

    SourceLine lineOf(const CookedAsset& asset) const {
        const std::string_view section = info(asset.kind).sceneSection;
        if (!scene_) return lineOf(section);
        const std::string entry = entryOf(asset);
        // Tables without a section of their own exist because of the materials.
        if (!scene_->lines.find(section, entry) && !scene_->materials.empty()) return lineOf("material", scene_->materials.front().name);
        return lineOf(section, entry, asset.kind == AssetKind::Mesh ? "mesh" : "");
    }

    const ReportRow* rowOf(const std::string& asset) const {
        if (!report_) return nullptr;
        const auto row = std::ranges::find(report_->assets, asset, &ReportRow::name);
        return row == report_->assets.end() ? nullptr : &*row;
    }

    void addSceneSuite() {
        CiSuite suite{kSceneSuite, "", lineOf(""), {{CiRule::UnchangedFiles, true, 0, {}}}};
        for (const CiRuleInfo& rule : allCiRules())
            if (!rule.isOfAsset) suite.checks.push_back({rule.id, rule.id != CiRule::MemoryBudget || report_, 0, {}});
        run_.suites.push_back(std::move(suite));
    }

    void addSuite(const CookedAsset& asset) {
        CiSuite suite{asset.name, std::string(info(asset.kind).name), lineOf(asset), {}};
        const ReportRow* row = rowOf(asset.name);
        for (const CiRuleInfo& rule : allCiRules())
            if (rule.isOfAsset) suite.checks.push_back({rule.id, row != nullptr || rule.id == CiRule::UnchangedFiles, 0, {}});
        // One measurement gives all figures; its time is that of the first check that needs them.
        if (row != nullptr) checkOf(suite, CiRule::FiniteFigures).seconds = row->verifySeconds;
        run_.suites.push_back(std::move(suite));
    }

    static CiCheck& checkOf(CiSuite& suite, CiRule rule) { return *std::ranges::find(suite.checks, rule, &CiCheck::rule); }

    CiSuite* suiteOf(const std::string& asset) {
        const auto suite =
            std::find_if(run_.suites.begin() + 1, run_.suites.end(), [&](const CiSuite& each) { return each.name == asset; });
        return suite == run_.suites.end() ? nullptr : &*suite;
    }

    /// Adds an error to the check that it is about.
    void addError(const formats::Error& error) {
        if (run_.reasonNotDone.empty()) run_.reasonNotDone = error.line();
        // Findings of lint have results of their own, and build() adds the failures of the report.
        if (error.code == formats::ErrorCode::Implausible ? run_.isLinted : error.code == formats::ErrorCode::OverLimit && report_) return;
        CiSuite* suite = suiteOf(error.asset);
        CiRule rule = pipeline::ruleOf(error.code);
        if (suite != nullptr && error.file.empty() && rule != CiRule::Fault) rule = CiRule::Contract;
        if (suite == nullptr || !info(rule).isOfAsset) suite = &run_.suites.front();
        CiCheck& check = checkOf(*suite, rule);
        check.isDone = true;
        check.findings.push_back(
            {error.line(), "", Json::object(), placeOf(error, rule == CiRule::MemoryBudget ? lineOf("output", "", "budget") : suite->at)});
    }

    /// Returns the line that an error names, or the line of the scene file that names its file; else `otherwise`.
    SourceLine placeOf(const formats::Error& error, const SourceLine& otherwise) const {
        if (error.lineNumber) return {error.file, *error.lineNumber};
        const auto line = scene_ ? scene_->lines.findFile(error.file) : std::nullopt;
        return line ? SourceLine{scene_->file, *line} : otherwise;
    }

    void addFailure(const ReportRow& row, const Failure& failure) {
        CiSuite* suite = suiteOf(row.name);
        if (suite == nullptr) suite = &run_.suites.front();
        const CiRule rule = suite->kind.empty() ? CiRule::UnchangedFiles : ruleOf(failure, row.verdict);
        CiCheck& check = checkOf(*suite, rule);
        check.isDone = true;
        check.findings.push_back({failure.message, failure.stage, propertiesOf(failure), suite->at});
    }

    const CiInputs& inputs_;
    std::optional<Report> report_;
    std::optional<Manifest> manifest_;
    std::optional<Scene> scene_;
    CiRun run_;
};

}  // namespace

CiRun ciRun(const CiInputs& inputs) {
    return RunBuilder(inputs).build();
}

}  // namespace lightcook::pipeline
