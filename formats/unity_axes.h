// Bakes of Unity and Bakery are assumed to be in the axes of Unity's world. `info` says so, and `init` writes the axes of a mesh.
#pragma once

#include <string_view>

namespace lightcook::formats {

inline constexpr std::string_view kUnityAxes = "the axes are those of the world that was baked, which is left-handed in Unity";

}  // namespace lightcook::formats
