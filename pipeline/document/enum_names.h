// Names of enumerations of formats/ as fields of documents: from their tables. Axes, which are no enumeration, as their text.
#pragma once

#include "formats/gpu_texture.h"
#include "formats/layout_cost.h"
#include "formats/light_map_conventions.h"
#include "formats/light_map_layout.h"
#include "formats/light_map_objective.h"
#include "formats/specular_lobe.h"
#include "formats/target.h"
#include "formats/vocabulary.h"
#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

template <>
struct EnumNames<formats::Target> {
    static std::vector<std::string> all() { return formats::namesOf(formats::allTargets()); }
};

template <>
struct EnumNames<formats::Objective> {
    static std::vector<std::string> all() { return formats::namesOf(formats::allObjectives()); }
};

template <>
struct EnumNames<formats::LightMapFilter> {
    static std::vector<std::string> all() { return formats::namesOf(formats::allLightMapFilters()); }
};

template <>
struct EnumNames<formats::LayoutCost> {
    static std::vector<std::string> all() { return formats::namesOf(formats::allLayoutCosts()); }
};

template <>
struct EnumNames<formats::Container> {
    static_assert(static_cast<int>(formats::Container::Ktx2) == 0 && static_cast<int>(formats::Container::Dds) == 1);
    static std::vector<std::string> all() { return {"ktx2", "dds"}; }
};

template <>
struct EnumNames<lighting::SpecularLobe> {
    static std::vector<std::string> all() { return formats::namesOf(formats::allSpecularLobes()); }
};

template <>
struct EnumNames<lighting::NormalDistribution> {
    static std::vector<std::string> all() { return formats::namesOf(formats::sceneLobes()); }
};

/// The conventions of a light map's file.
template <class Enum>
requires requires {
    formats::conventions<Enum>();
}
struct EnumNames<Enum> {
    static std::vector<std::string> all() { return formats::namesOf(formats::conventions<Enum>()); }
};

template <>
struct FieldText<formats::BakeAxes> {
    static std::string of(const formats::BakeAxes& axes) { return axes.name(); }
    static std::optional<formats::BakeAxes> from(const std::string& text) { return formats::BakeAxes::fromName(text); }
    static std::string expected() { return std::string(formats::BakeAxes::kExpected); }
};

}  // namespace lightcook::pipeline
