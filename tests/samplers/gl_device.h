// OpenGL on a software rasteriser, without a window: textures uploaded as a loader of an engine would, sampled by a compute shader. Nothing
// of formats/ or verify/ is used here, so that a mistake about a file or a block cannot confirm itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec4.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace samplers {

/// A KTX2 file as its header tells it, read anew from the specification: no supercompression.
struct Ktx2 {
    std::uint32_t vkFormat = 0;
    int width = 0, height = 0, layerCount = 0, faceCount = 1, levelCount = 1;  ///< layerCount 0: no array
    std::vector<std::vector<std::byte>> levels;                                ///< all layers and faces of each
};
/// Throws std::runtime_error.
Ktx2 readKtx2(const std::filesystem::path& file);

/// One context; textures live as long as it does.
class GlDevice {
public:
    /// Why there is none in `whyNot`, if there is none: no EGL library, no software rasteriser, an OpenGL below 4.5.
    static std::unique_ptr<GlDevice> create(std::string& whyNot);
    ~GlDevice();

    std::string name() const;
    /// Linear magnification, trilinear where there are mips, seamless cubemaps, clamped. The unit that the shader finds it under is `unit`;
    /// textures are sampler2DArray, cubemaps samplerCube. False where the format is none of this device's.
    bool upload(int unit, const Ktx2& texture);
    /// Runs `body` for every place. In it: `vec4 place`, `vec4 direction`, `float table[]`, and what it has to set: `vec4 result`.
    /// declarations  global GLSL text: samplers, constants, functions
    /// Throws std::runtime_error with the compiler's words.
    std::vector<glm::vec4> run(const std::string& declarations, const std::string& body, std::span<const glm::vec4> places,
                               std::span<const glm::vec4> directions = {}, std::span<const float> table = {});

private:
    struct State;
    explicit GlDevice(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace samplers
