#include "tests/samplers/gl_device.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>

namespace lightcook::samplers {
namespace {

/// OpenGL's description of a format: compressed, or with texels of a type.
struct GlFormat {
    GLenum internal = 0;
    GLenum format = 0, type = 0;  ///< 0: compressed
};

/// Returns OpenGL's format for a VkFormat. Numbers of compressed formats are those of EXT_texture_compression_s3tc and
/// KHR_texture_compression_astc_ldr where glcorearb.h has none.
const GlFormat* glFormatOf(std::uint32_t vkFormat) {
    constexpr GLenum kDxt1 = 0x83F0, kDxt5 = 0x83F3, kAstc4x4 = 0x93B0;
    static const std::map<std::uint32_t, GlFormat> kFormats = {{131, {kDxt1}},
                                                               {137, {kDxt5}},
                                                               {139, {GL_COMPRESSED_RED_RGTC1}},
                                                               {140, {GL_COMPRESSED_SIGNED_RED_RGTC1}},
                                                               {141, {GL_COMPRESSED_RG_RGTC2}},
                                                               {142, {GL_COMPRESSED_SIGNED_RG_RGTC2}},
                                                               {143, {GL_COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT}},
                                                               {144, {GL_COMPRESSED_RGB_BPTC_SIGNED_FLOAT}},
                                                               {145, {GL_COMPRESSED_RGBA_BPTC_UNORM}},
                                                               {157, {kAstc4x4}},
                                                               {123, {GL_RGB9_E5, GL_RGB, GL_UNSIGNED_INT_5_9_9_9_REV}},
                                                               {122, {GL_R11F_G11F_B10F, GL_RGB, GL_UNSIGNED_INT_10F_11F_11F_REV}},
                                                               {97, {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT}},
                                                               {90, {GL_RGB16F, GL_RGB, GL_HALF_FLOAT}},
                                                               {70, {GL_R16, GL_RED, GL_UNSIGNED_SHORT}},
                                                               {77, {GL_RG16, GL_RG, GL_UNSIGNED_SHORT}},
                                                               {91, {GL_RGBA16, GL_RGBA, GL_UNSIGNED_SHORT}},
                                                               {37, {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE}},
                                                               {43, {GL_SRGB8_ALPHA8, GL_RGBA, GL_UNSIGNED_BYTE}}};
    const auto found = kFormats.find(vkFormat);
    return found == kFormats.end() ? nullptr : &found->second;
}

template <class Function>
Function glFunction(const char* name) {
    const auto function = reinterpret_cast<Function>(eglGetProcAddress(name));
    if (function == nullptr) throw std::runtime_error(std::string("no ") + name);
    return function;
}

struct Gl {
#define LIGHTCOOK_GL(Type, name) Type name = glFunction<Type>("gl" #name)
    LIGHTCOOK_GL(PFNGLGETSTRINGPROC, GetString);
    LIGHTCOOK_GL(PFNGLGETERRORPROC, GetError);
    LIGHTCOOK_GL(PFNGLENABLEPROC, Enable);
    LIGHTCOOK_GL(PFNGLPIXELSTOREIPROC, PixelStorei);
    LIGHTCOOK_GL(PFNGLGENTEXTURESPROC, GenTextures);
    LIGHTCOOK_GL(PFNGLDELETETEXTURESPROC, DeleteTextures);
    LIGHTCOOK_GL(PFNGLACTIVETEXTUREPROC, ActiveTexture);
    LIGHTCOOK_GL(PFNGLBINDTEXTUREPROC, BindTexture);
    LIGHTCOOK_GL(PFNGLTEXPARAMETERIPROC, TexParameteri);
    LIGHTCOOK_GL(PFNGLTEXIMAGE2DPROC, TexImage2D);
    LIGHTCOOK_GL(PFNGLTEXIMAGE3DPROC, TexImage3D);
    LIGHTCOOK_GL(PFNGLCOMPRESSEDTEXIMAGE2DPROC, CompressedTexImage2D);
    LIGHTCOOK_GL(PFNGLCOMPRESSEDTEXIMAGE3DPROC, CompressedTexImage3D);
    LIGHTCOOK_GL(PFNGLCREATESHADERPROC, CreateShader);
    LIGHTCOOK_GL(PFNGLSHADERSOURCEPROC, ShaderSource);
    LIGHTCOOK_GL(PFNGLCOMPILESHADERPROC, CompileShader);
    LIGHTCOOK_GL(PFNGLGETSHADERIVPROC, GetShaderiv);
    LIGHTCOOK_GL(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog);
    LIGHTCOOK_GL(PFNGLDELETESHADERPROC, DeleteShader);
    LIGHTCOOK_GL(PFNGLCREATEPROGRAMPROC, CreateProgram);
    LIGHTCOOK_GL(PFNGLATTACHSHADERPROC, AttachShader);
    LIGHTCOOK_GL(PFNGLLINKPROGRAMPROC, LinkProgram);
    LIGHTCOOK_GL(PFNGLGETPROGRAMIVPROC, GetProgramiv);
    LIGHTCOOK_GL(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog);
    LIGHTCOOK_GL(PFNGLUSEPROGRAMPROC, UseProgram);
    LIGHTCOOK_GL(PFNGLDELETEPROGRAMPROC, DeleteProgram);
    LIGHTCOOK_GL(PFNGLGENBUFFERSPROC, GenBuffers);
    LIGHTCOOK_GL(PFNGLDELETEBUFFERSPROC, DeleteBuffers);
    LIGHTCOOK_GL(PFNGLBINDBUFFERPROC, BindBuffer);
    LIGHTCOOK_GL(PFNGLBINDBUFFERBASEPROC, BindBufferBase);
    LIGHTCOOK_GL(PFNGLBUFFERDATAPROC, BufferData);
    LIGHTCOOK_GL(PFNGLGETBUFFERSUBDATAPROC, GetBufferSubData);
    LIGHTCOOK_GL(PFNGLDISPATCHCOMPUTEPROC, DispatchCompute);
    LIGHTCOOK_GL(PFNGLMEMORYBARRIERPROC, MemoryBarrier);
#undef LIGHTCOOK_GL
};

constexpr int kGroupSize = 64;

}  // namespace

Ktx2 readKtx2(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::vector<std::byte> bytes(std::filesystem::file_size(file));
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    constexpr unsigned char kIdentifier[] = {0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB, '\r', '\n', 0x1A, '\n'};
    if (!stream || bytes.size() < 104 || std::memcmp(bytes.data(), kIdentifier, 12) != 0)
        throw std::runtime_error(file.string() + " is no KTX2");
    const auto number32 = [&](std::size_t at) {
        std::uint32_t value = 0;
        std::memcpy(&value, bytes.data() + at, 4);
        return value;
    };
    const auto number64 = [&](std::size_t at) { return number32(at) | static_cast<std::uint64_t>(number32(at + 4)) << 32; };
    if (number32(44) != 0) throw std::runtime_error(file.string() + " is supercompressed");
    Ktx2 texture;
    texture.vkFormat = number32(12);
    texture.width = static_cast<int>(number32(20));
    texture.height = static_cast<int>(number32(24));
    texture.layerCount = static_cast<int>(number32(32));
    texture.faceCount = static_cast<int>(number32(36));
    texture.levelCount = static_cast<int>(number32(40));
    for (int level = 0; level < texture.levelCount; ++level) {
        const std::size_t entry = 80 + 24 * static_cast<std::size_t>(level);
        const std::uint64_t offset = number64(entry), length = number64(entry + 8);
        if (offset + length > bytes.size()) throw std::runtime_error(file.string() + " is cut short");
        texture.levels.emplace_back(bytes.begin() + static_cast<std::ptrdiff_t>(offset),
                                    bytes.begin() + static_cast<std::ptrdiff_t>(offset + length));
    }
    return texture;
}

struct GlDevice::State {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;
    std::unique_ptr<Gl> gl;
    std::map<int, GLuint> textures;  ///< by unit

    ~State() {
        if (display == EGL_NO_DISPLAY) return;
        eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
        eglTerminate(display);
    }
};

std::unique_ptr<GlDevice> GlDevice::create(std::string& whyNot) {
    // Software rendering on every machine: the test checks agreement with one known implementation.
    ::setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
    auto state = std::make_unique<State>();
    const auto getDisplay = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
    if (getDisplay != nullptr) state->display = getDisplay(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
    if (state->display == EGL_NO_DISPLAY || eglInitialize(state->display, nullptr, nullptr) == EGL_FALSE) {
        state->display = EGL_NO_DISPLAY;
        whyNot = "EGL has no surfaceless display (Debian: libegl1, libgl1-mesa-dri)";
        return nullptr;
    }
    constexpr std::array<EGLint, 7> kAttributes = {
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    if (eglBindAPI(EGL_OPENGL_API) == EGL_TRUE)
        state->context = eglCreateContext(state->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, kAttributes.data());
    if (state->context == EGL_NO_CONTEXT || eglMakeCurrent(state->display, EGL_NO_SURFACE, EGL_NO_SURFACE, state->context) == EGL_FALSE) {
        whyNot = "EGL gives no context of OpenGL 4.5 (Debian: libgl1-mesa-dri)";
        return nullptr;
    }
    state->gl = std::make_unique<Gl>();
    state->gl->Enable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
    state->gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    return std::unique_ptr<GlDevice>(new GlDevice(std::move(state)));
}

GlDevice::GlDevice(std::unique_ptr<State> state) : state_(std::move(state)) {}
GlDevice::~GlDevice() = default;

std::string GlDevice::name() const {
    const auto text = [&](GLenum what) { return std::string(reinterpret_cast<const char*>(state_->gl->GetString(what))); };
    return text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
}

bool GlDevice::upload(int unit, const Ktx2& texture) {
    Gl& gl = *state_->gl;
    const GlFormat* format = glFormatOf(texture.vkFormat);
    if (format == nullptr) return false;
    while (gl.GetError() != GL_NO_ERROR) {
    }
    GLuint& name = state_->textures[unit];
    if (name != 0) gl.DeleteTextures(1, &name);
    gl.GenTextures(1, &name);
    const bool isCube = texture.faceCount == 6;
    const GLenum target = isCube ? GL_TEXTURE_CUBE_MAP : GL_TEXTURE_2D_ARRAY;
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl.BindTexture(target, name);
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) gl.TexParameteri(target, wrap, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER, texture.levelCount > 1 ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
    gl.TexParameteri(target, GL_TEXTURE_MAX_LEVEL, texture.levelCount - 1);
    const int layers = std::max(texture.layerCount, 1);
    for (int level = 0; level < texture.levelCount; ++level) {
        const std::vector<std::byte>& bytes = texture.levels[static_cast<std::size_t>(level)];
        const int width = std::max(texture.width >> level, 1), height = std::max(texture.height >> level, 1);
        const auto internal = static_cast<GLint>(format->internal);
        const std::size_t faceBytes = bytes.size() / static_cast<std::size_t>(texture.faceCount);
        for (int face = 0; face < texture.faceCount; ++face) {
            const std::byte* data = bytes.data() + static_cast<std::size_t>(face) * faceBytes;
            const GLenum faceTarget = GL_TEXTURE_CUBE_MAP_POSITIVE_X + static_cast<GLenum>(face);
            const auto size = static_cast<GLsizei>(faceBytes);
            if (isCube && format->format == 0)
                gl.CompressedTexImage2D(faceTarget, level, format->internal, width, height, 0, size, data);
            else if (isCube)
                gl.TexImage2D(faceTarget, level, internal, width, height, 0, format->format, format->type, data);
            else if (format->format == 0)
                gl.CompressedTexImage3D(target, level, format->internal, width, height, layers, 0, size, data);
            else
                gl.TexImage3D(target, level, internal, width, height, layers, 0, format->format, format->type, data);
        }
    }
    return gl.GetError() == GL_NO_ERROR;
}

std::vector<glm::vec4> GlDevice::run(const std::string& declarations, const std::string& body, std::span<const glm::vec4> places,
                                     std::span<const glm::vec4> directions, std::span<const float> table) {
    Gl& gl = *state_->gl;
    const std::string text = "#version 450\nlayout(local_size_x = " + std::to_string(kGroupSize) +
                             ") in;\nlayout(std430, binding = 0) readonly buffer Places { vec4 places[]; };\n"
                             "layout(std430, binding = 1) readonly buffer Directions { vec4 directions[]; };\n"
                             "layout(std430, binding = 2) writeonly buffer Results { vec4 results[]; };\n"
                             "layout(std430, binding = 3) readonly buffer Table { float table[]; };\n#define TABLE(at) table[at]\n" +
                             declarations +
                             "\nvoid main() {\nuint index = gl_GlobalInvocationID.x;\nif (index >= uint(places.length())) return;\n"
                             "vec4 place = places[index];\nvec4 direction = directions[min(index, uint(directions.length()) - 1u)];\n"
                             "vec4 result = vec4(0.0);\n" +
                             body + "\nresults[index] = result;\n}\n";
    const char* source = text.c_str();
    std::array<char, 4000> words{};
    GLint good = 0;
    const GLuint shader = gl.CreateShader(GL_COMPUTE_SHADER);
    gl.ShaderSource(shader, 1, &source, nullptr);
    gl.CompileShader(shader);
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
    gl.GetShaderInfoLog(shader, static_cast<GLsizei>(words.size()), nullptr, words.data());
    if (good == 0) throw std::runtime_error(words.data());
    const GLuint program = gl.CreateProgram();
    gl.AttachShader(program, shader);
    gl.LinkProgram(program);
    gl.GetProgramiv(program, GL_LINK_STATUS, &good);
    gl.GetProgramInfoLog(program, static_cast<GLsizei>(words.size()), nullptr, words.data());
    if (good == 0) throw std::runtime_error(words.data());

    const std::vector<glm::vec4> none(1);
    const std::vector<float> noTable(1);
    if (directions.empty()) directions = none;
    if (table.empty()) table = noTable;
    std::vector<glm::vec4> results(places.size());
    std::array<GLuint, 4> buffers{};
    gl.GenBuffers(4, buffers.data());
    const auto fill = [&](GLuint index, const void* data, std::size_t bytes) {
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, index, buffers[index]);
        gl.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
    };
    fill(0, places.data(), places.size_bytes());
    fill(1, directions.data(), directions.size_bytes());
    fill(3, table.data(), table.size_bytes());
    fill(2, results.data(), results.size() * sizeof(glm::vec4));  // last, so that it stays bound for reading
    gl.UseProgram(program);
    gl.DispatchCompute(static_cast<GLuint>((places.size() + kGroupSize - 1) / kGroupSize), 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(results.size() * sizeof(glm::vec4)), results.data());
    const GLenum error = gl.GetError();
    gl.DeleteBuffers(4, buffers.data());
    gl.DeleteProgram(program);
    gl.DeleteShader(shader);
    if (error != GL_NO_ERROR) throw std::runtime_error("OpenGL error " + std::to_string(error));
    return results;
}

}  // namespace lightcook::samplers
