// Decides the layouts of light maps whose layout is "auto": by error or by budget, from their trials, and again after verification.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/layout_choice.h"
#include "pipeline/cook/plan.h"
#include "pipeline/graph/executor.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

class LayoutDecision {
public:
    /// open        plan with maps whose layout is not decided
    /// trials      records of the trials, and of the assets that were cooked with them
    /// materials   records of the meshes' materials
    static formats::Result<LayoutDecision> create(const Scene& scene, const Plan& open, const ExecutionResult& trials,
                                                  const ExecutionResult& materials);

    /// Returns the layout of each map: the cheapest within the error, or the best within the budget.
    std::map<std::string, std::string> choose() const;
    /// Notes the verified errors. Returns true if a map missed the bound that its trial had kept, since a trial of a part of a map may be
    /// too good: then choose() again.
    formats::Result<bool> isRefuted(const ExecutionResult& chosen, const std::map<std::string, std::string>& layouts);

private:
    explicit LayoutDecision(const Scene& scene) : scene_(scene) {}
    LayoutLimits limitsOf(const std::string& map) const;

    const Scene& scene_;
    LightMapCandidates candidates_;
    std::uint64_t otherBytes_ = 0;  ///< GPU memory of the other assets, meshes at their upper bound
};

/// Returns the light map that a mesh waits for; for another asset its own name.
const std::string& lightMapOf(const Plan& plan, const std::string& asset);

}  // namespace lightcook::pipeline
