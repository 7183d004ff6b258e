// A program of OpenGL, and its uniforms by name.
#pragma once

#include <cstdint>
#include <glm/fwd.hpp>
#include <nlohmann/json.hpp>
#include <string>

namespace example {

/// Compiles and links. Throws std::runtime_error with the compiler's message. The program is freed with the context.
std::uint32_t makeProgram(const std::string& vertex, const std::string& fragment);

/// Sets every member of a uniform that is a struct to the value of its name in the manifest, whatever its type.
/// Throws std::runtime_error for a constant that the manifest does not have.
void setConstants(std::uint32_t program, const std::string& uniform, const nlohmann::json& constants);

}  // namespace example
