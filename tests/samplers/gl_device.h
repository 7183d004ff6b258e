// OpenGL 4.5 on Mesa's software rasterizer, without a window: a compute shader samples.
#pragma once

#include <memory>

#include "tests/samplers/device.h"

namespace lightcook::samplers {

/// One context.
class GlDevice : public Device {
public:
    /// Returns null with the reason in `whyNot`, if there is no EGL library, no software rasterizer, or only an OpenGL below 4.5.
    static std::unique_ptr<GlDevice> create(std::string& whyNot);
    ~GlDevice() override;

    std::string name() const override;
    bool upload(int unit, const Ktx2& texture) override;
    std::vector<glm::vec4> run(const std::string& declarations, const std::string& body, std::span<const glm::vec4> places,
                               std::span<const glm::vec4> directions = {}, std::span<const float> table = {}) override;

private:
    struct State;
    explicit GlDevice(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace lightcook::samplers
