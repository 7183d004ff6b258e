#include "offscreen.h"

#define GL_GLEXT_PROTOTYPES
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>
#include <png.h>

#include <array>
#include <stdexcept>
#include <vector>

namespace example {

struct Offscreen::Egl {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;

    Egl() {
        // With libEGL's own table of drivers, this works on Mesa's llvmpipe and on GPUs alike.
        display = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
        if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) == EGL_FALSE)
            throw std::runtime_error("EGL has no surfaceless display (Debian: libegl1, libgl1-mesa-dri)");
        constexpr std::array<EGLint, 7> kVersion = {
            EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
        if (eglBindAPI(EGL_OPENGL_API) == EGL_TRUE) context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, kVersion.data());
        if (context == EGL_NO_CONTEXT || eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_FALSE) {
            eglTerminate(display);
            throw std::runtime_error("EGL gives no context of OpenGL 4.5 (Debian: libgl1-mesa-dri)");
        }
    }
    ~Egl() {
        eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(display, context);
        eglTerminate(display);
    }
    Egl(const Egl&) = delete;
    Egl& operator=(const Egl&) = delete;
};

Offscreen::Offscreen(int width, int height) : egl_(std::make_unique<Egl>()), width_(width), height_(height) {
    GLuint framebuffer = 0;
    std::array<GLuint, 2> buffers{};  // freed with the context
    glCreateFramebuffers(1, &framebuffer);
    glCreateRenderbuffers(2, buffers.data());
    glNamedRenderbufferStorage(buffers[0], GL_RGBA8, width, height);
    glNamedRenderbufferStorage(buffers[1], GL_DEPTH_COMPONENT32F, width, height);
    glNamedFramebufferRenderbuffer(framebuffer, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffers[0]);
    glNamedFramebufferRenderbuffer(framebuffer, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, buffers[1]);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, width, height);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) throw std::runtime_error("no framebuffer of this size");
}

Offscreen::~Offscreen() = default;

void Offscreen::writePng(const std::filesystem::path& file) const {
    const png_int_32 rowBytes = 3 * width_;
    std::vector<png_byte> pixels(static_cast<std::size_t>(rowBytes) * static_cast<std::size_t>(height_));
    glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(width_);
    image.height = static_cast<png_uint_32>(height_);
    image.format = PNG_FORMAT_RGB;
    // OpenGL's first row is the lowest: a negative stride begins with the last row.
    if (png_image_write_to_file(&image, file.c_str(), 0, pixels.data(), -rowBytes, nullptr) == 0)
        throw std::runtime_error(file.string() + ": " + image.message);
}

}  // namespace example
