// WebGL2 in headless Chromium on SwiftShader, controlled by the DevTools protocol over two pipes. A fragment shader samples into a float
// texture, which is read back.
#pragma once

#include <memory>

#include "tests/samplers/device.h"

namespace lightcook::samplers {

/// One browser with one page.
class BrowserDevice : public Device {
public:
    /// Returns null with the reason in `whyNot`, if there is no Chromium, no WebGL2 or no float targets.
    static std::unique_ptr<BrowserDevice> create(std::string& whyNot);
    ~BrowserDevice() override;

    std::string name() const override;
    bool upload(int unit, const Ktx2& texture) override;
    std::vector<glm::vec4> run(const std::string& declarations, const std::string& body, std::span<const glm::vec4> places,
                               std::span<const glm::vec4> directions = {}, std::span<const float> table = {}) override;

private:
    class Page;
    explicit BrowserDevice(std::unique_ptr<Page> page);
    std::unique_ptr<Page> page_;
};

}  // namespace lightcook::samplers
