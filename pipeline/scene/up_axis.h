// The axis of world space that points up.
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <string_view>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

enum class UpAxis { Y, Z, X };

struct UpAxisInfo {
    UpAxis id;
    std::string_view name;     ///< value of the scene file's `up_axis`, and of the manifest
    std::string_view caption;  ///< for documents
    glm::dvec3 direction;
};

/// Returns every axis, in the order of the enumeration.
std::span<const UpAxisInfo> allUpAxes();
const UpAxisInfo& info(UpAxis axis);

template <>
struct EnumNames<UpAxis> {
    static std::vector<std::string> all();
};

}  // namespace lightcook::pipeline
