// OpenGL without a window, and the picture that it drew.
#pragma once

#include <filesystem>
#include <memory>

namespace example {

/// A context of OpenGL 4.5 and a framebuffer with colour (RGBA, 8 bits, linear) and depth. All calls of OpenGL happen while it lives.
/// Throws std::runtime_error where EGL has no surfaceless display.
class Offscreen {
public:
    Offscreen(int width, int height);
    ~Offscreen();
    Offscreen(const Offscreen&) = delete;
    Offscreen& operator=(const Offscreen&) = delete;

    /// Writes the framebuffer as it is. Throws std::runtime_error with libpng's message.
    void writePng(const std::filesystem::path& file) const;

private:
    struct Egl;
    std::unique_ptr<Egl> egl_;
    int width_, height_;
};

}  // namespace example
