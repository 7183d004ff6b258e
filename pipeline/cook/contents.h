// Contents of a scene's files, read before the plan: light maps of constant light or of few bands, and probes that no surface uses.
#pragma once

#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/light_map.h"
#include "pipeline/assets/needs.h"
#include "pipeline/cook/plan.h"
#include "pipeline/graph/executor.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns the actions that read the contents of the assets that the options want, none of these if the scene keeps unused assets; and
/// those that measure the floors of light maps whose error is limited.
std::vector<Action> planContents(const Scene& scene, const Needs& needs, const PlanOptions& options);
/// Adds the results of these actions to the needs. Actions that failed say nothing: their assets are cooked in full.
formats::Result<void> addContents(const ExecutionResult& contents, Needs& needs);

/// Returns an error for each limit on the errors of a light map that is below the floor of its bake: no layout keeps it.
formats::Result<std::vector<formats::Error>> errorsOfFloors(const Scene& scene, const ExecutionResult& contents);

/// Settings of a light map's cook that follow from the content of its bake.
struct LightMapReduction {
    std::string layout;                    ///< a layout, or "auto"
    std::optional<glm::ivec2> constantOf;  ///< see formats::LightMapDescription
    bool hasDominant = true;               ///< false: the light is black, has no direction anywhere, or its fit is 0 everywhere
    bool isDominantConstant = false;       ///< the dominant light of every texel is that of the first
    bool isFlatTried = false;              ///< for "auto": directions may not be needed
    bool hasDirections = true;             ///< false: bands 1 and 2 are zero
    std::string why;                       ///< a lower order or a constant was chosen; empty: neither was
    std::string whyFlat, whySh4;           ///< for "auto": bands 1 and 2, or band 2, have no light that is seen; empty: they have
    /// Returns why the layout that "auto" chose may leave out bands. Empty: it leaves out none, or the materials do not need them.
    std::string whyWithoutBands(const std::string& chosen) const;
};
/// asked  the layout that the materials need: lightMapLayoutFor()
LightMapReduction reductionOf(const Scene& scene, const Needs& needs, const LightMapEntry& entry, const std::string& asked);
/// Returns the limits on the decode of a light map. The hardware's filter is the usual one where fetches are dear, where a sampler mixes
/// mip levels, and for constant light, which any filter shows.
formats::DecodeLimits decodeOf(const Scene& scene, const LightMapEntry& entry, bool isConstant);

}  // namespace lightcook::pipeline
