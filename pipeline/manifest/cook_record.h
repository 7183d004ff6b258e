// What cooked.json keeps of a cook, so that `verify` plans the same again: the scene with the options of the command line, what was read
// before the plan, and what trials decided.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>

#include "pipeline/assets/light_map/kept_map.h"
#include "pipeline/assets/needs.h"
#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

/// What trials decide before or between the actions of a plan.
struct Decisions {
    /// Layouts of light maps whose layout is "auto", by name. A map that is not here gets a trial instead.
    std::map<std::string, std::string> layouts = {};
    std::set<std::string> unlimited = {};      ///< light maps that are held to no default limit (LayoutDecision::unlimited)
    std::optional<int> tableViews = {};        ///< of tables whose views a budget chooses (areViewsOpen); absent: not chosen yet
    std::string keptFrom = {};                 ///< digest of the manifest that `cook --patch` took the decisions from; else empty
    std::map<std::string, KeptMap> kept = {};  ///< of light maps that were baked again since
};
template <class Fields, Is<Decisions> Self>
void describe(Fields& fields, Self& decisions) {
    fields.presentIf(!decisions.layouts.empty(), "layouts", decisions.layouts, "layouts that trials chose, by light map");
    fields.presentIf(!decisions.unlimited.empty(), "unlimited", decisions.unlimited,
                     "light maps that no layout keeps within the default limit: they are held to none");
    fields.optional("table_views", decisions.tableViews, "views of the Cook-Torrance tables that the budget leaves room for");
    fields.presentIf(!decisions.keptFrom.empty(), "kept_from", decisions.keptFrom,
                     "after `cook --patch`: `digest` of the manifest of the cook that these decisions are of");
    fields.presentIf(!decisions.kept.empty(), "kept", decisions.kept,
                     "after `cook --patch`: by light map that was baked again, what is kept of the bake before");
}

inline constexpr int kMostSamples = 1000000;  ///< of each texel: the most of --samples

struct CookRecord {
    Json scene;                    ///< its keys: Scene::document
    std::set<std::string> assets;  ///< that were asked for, with those that the plan left out
    bool repair = false;           ///< see CookOptions
    int samples = 1;               ///< see CookOptions
    Needs needs;
    Decisions decisions;
};
template <class Fields, Is<CookRecord> Self>
void describe(Fields& fields, Self& cook) {
    fields.required("scene", cook.scene, "keys of the scene file, with those of the command line in their place");
    fields.required("assets", cook.assets, "assets that were asked for");
    fields.required("repair", cook.repair, "true if unusable texels were replaced");
    fields.required("samples", cook.samples, between(0, kMostSamples), "random positions of each texel quad");
    fields.required("needs", cook.needs, "what materials, meshes and light maps ask for");
    fields.required("decisions", cook.decisions, "what trials decided");
}

}  // namespace lightcook::pipeline
