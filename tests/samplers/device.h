// An independent sampler: uploads textures as an engine's loader does, and runs a shader at many places. It uses nothing of formats/ or
// verify/, so that a misunderstanding of a file or a block cannot confirm itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <vector>

namespace lightcook::samplers {

/// A KTX2 file, read by a second implementation of the specification, without supercompression.
struct Ktx2 {
    std::uint32_t vkFormat = 0;
    int width = 0, height = 0, layerCount = 0, faceCount = 1, levelCount = 1;  ///< layerCount 0: not an array
    std::vector<std::vector<std::byte>> levels;                                ///< all layers and faces of each
};
/// Throws std::runtime_error.
Ktx2 readKtx2(const std::filesystem::path& file);

/// A device. Textures live as long as the device.
class Device {
public:
    virtual ~Device() = default;
    virtual std::string name() const = 0;
    /// Uploads a texture with linear magnification, trilinear if it has mips, clamped, seamless for cubemaps. Returns false if the device
    /// does not support the format. unit  0 to 11, the unit of the shader's sampler: sampler2DArray, or samplerCube for cubemaps
    virtual bool upload(int unit, const Ktx2& texture) = 0;
    /// Runs `body` for every place. It reads `vec4 place`, `vec4 direction` and `TABLE(i)`, the i-th number of the table, and sets
    /// `vec4 result`.
    /// declarations  global GLSL text: samplers ("layout(binding = 0) uniform sampler2DArray name;"), constants, functions
    /// Throws std::runtime_error with the compiler's message.
    virtual std::vector<glm::vec4> run(const std::string& declarations, const std::string& body, std::span<const glm::vec4> places,
                                       std::span<const glm::vec4> directions = {}, std::span<const float> table = {}) = 0;
};

}  // namespace lightcook::samplers
