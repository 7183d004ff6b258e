// What a second opinion is asked of: textures uploaded as a loader of an engine would, and a shader run at many places. Nothing of formats/
// or verify/ is used here, so that a mistake about a file or a block cannot confirm itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <vector>

namespace lightcook::samplers {

/// A KTX2 file as its header tells it, read anew from the specification: no supercompression.
struct Ktx2 {
    std::uint32_t vkFormat = 0;
    int width = 0, height = 0, layerCount = 0, faceCount = 1, levelCount = 1;  ///< layerCount 0: no array
    std::vector<std::vector<std::byte>> levels;                                ///< all layers and faces of each
};
/// Throws std::runtime_error.
Ktx2 readKtx2(const std::filesystem::path& file);

/// Textures live as long as the device does.
class Device {
public:
    virtual ~Device() = default;
    virtual std::string name() const = 0;
    /// Linear magnification, trilinear where there are mips, seamless cubemaps, clamped. The unit that the shader finds it under is `unit`,
    /// 0 to 11; textures are sampler2DArray, cubemaps samplerCube. False where the format is none of this device's.
    virtual bool upload(int unit, const Ktx2& texture) = 0;
    /// Runs `body` for every place. In it: `vec4 place`, `vec4 direction`, `TABLE(i)`, the i-th number of the table, and what it has to
    /// set: `vec4 result`.
    /// declarations  global GLSL text: samplers ("layout(binding = 0) uniform sampler2DArray name;"), constants, functions
    /// Throws std::runtime_error with the compiler's words.
    virtual std::vector<glm::vec4> run(const std::string& declarations, const std::string& body, std::span<const glm::vec4> places,
                                       std::span<const glm::vec4> directions = {}, std::span<const float> table = {}) = 0;
};

}  // namespace lightcook::samplers
