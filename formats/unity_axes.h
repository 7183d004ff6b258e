// What is assumed of the bakes that are in the axes of Unity's world: `info` says it, and a first scene file writes the axes of a mesh.
#pragma once

#include <string_view>

namespace lightcook::formats {

inline constexpr std::string_view kUnityAxes = "the axes are those of the world that was baked, which is left-handed in Unity";

}  // namespace lightcook::formats
