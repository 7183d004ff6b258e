// Draws a cooked folder with plain OpenGL 4.5, as an engine would, and writes a PNG.
//   lightcook_opengl COOKED_FOLDER OUT.png [--size 960 720] [--eye X Y Z] [--target X Y Z] [--fov DEGREES] [--exposure FACTOR]
//     [--frames N] [--one-texel]
// Read main(), then cooked_scene.cpp (files to GPU memory) and decode_glsl.cpp (which function of the shader include is called with what).
#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec3.hpp>

#include "cooked_scene.h"
#include "decode_glsl.h"
#include "offscreen.h"
#include "program.h"

namespace {

using Vector = std::array<float, 3>;

struct Options {
    std::string folder, picture;
    std::array<int, 2> size = {960, 720};
    Vector eye = {2.75f, 2.75f, 13}, target = {2.75f, 2.75f, 2.75f};
    float fovDegrees = 34;  ///< from the lower to the upper edge
    float exposure = 1;
    int frames = 1;
    bool isOneTexel = false;  ///< of the texels that filter "decoded" mixes, the shader decodes one at random
};

constexpr const char* kVertexShader = R"(#version 450
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 lightMapUv;
layout(location = 3) in float cluster;
uniform mat4 clipFromWorld;
out vec3 worldNormal;
out vec2 uv;
flat out int basis;
void main() {
  worldNormal = normal;
  uv = lightMapUv;
  basis = int(cluster);
  gl_Position = clipFromWorld * vec4(position, 1.0);
}
)";

/// Follows lightcook.glsl and the decode: light of a white Lambert surface, times the exposure, by the curve of sRGB.
constexpr const char* kShade = R"(
in vec3 worldNormal;
in vec2 uv;
flat in int basis;
uniform float exposure;
out vec4 colour;
void main() {
  LcSh sh = lightMapSh(uv, basis);
  vec3 light = exposure * max(lcExitRadiance(sh, normalize(worldNormal)), 0.0);
  vec3 shown = clamp(light, 0.0, 1.0);
  colour = vec4(mix(12.92 * shown, 1.055 * pow(shown, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, shown)), 1.0);
}
)";

Options parse(int argc, char** argv) {
    Options options;
    CLI::App app("Draws a cooked folder with OpenGL");
    app.add_option("folder", options.folder, "Folder that `lightcook cook` wrote")->required();
    app.add_option("picture", options.picture, "PNG to write")->required();
    app.add_option("--size", options.size, "Width and height [pixels]")->check(CLI::Range(1, 16384))->capture_default_str();
    app.add_option("--eye", options.eye, "Position of the camera")->capture_default_str();
    app.add_option("--target", options.target, "The camera looks here")->capture_default_str();
    app.add_option("--fov", options.fovDegrees, "From the lower to the upper edge [degrees]")
        ->check(CLI::Range(1, 170))
        ->capture_default_str();
    app.add_option("--exposure", options.exposure, "Factor of the light")->capture_default_str();
    app.add_option("--frames", options.frames, "Frames to draw; of several, the shortest time is printed [milliseconds]")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    app.add_flag(
        "--one-texel", options.isOneTexel,
        "Decode one of the four texels around a place at random, as a shader with a temporal filter may. The picture is the last frame");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& fault) {
        std::exit(app.exit(fault));
    }
    return options;
}

glm::mat4 clipFromWorld(const Options& options) {
    const float aspect = static_cast<float>(options.size[0]) / static_cast<float>(options.size[1]);
    return glm::perspective(glm::radians(options.fovDegrees), aspect, 0.05f, 1000.0f) *
           glm::lookAt(glm::make_vec3(options.eye.data()), glm::make_vec3(options.target.data()), glm::vec3(0, 1, 0));
}

/// Binds each texture to a unit of its own, and tells the sampler of its role.
void bindTextures(GLuint program, const example::CookedScene& scene) {
    GLuint unit = 0;
    for (const auto& [role, texture] : scene.textures) {
        glBindTextureUnit(unit, texture.name);
        glProgramUniform1i(program, glGetUniformLocation(program, ("map_" + role).c_str()), static_cast<GLint>(unit));
        ++unit;
    }
}

/// Returns the time until the frame is finished [milliseconds].
double drawFrame(const example::CookedScene& scene, GLuint program, int frame) {
    glProgramUniform1i(program, glGetUniformLocation(program, "frame"), frame);  // no effect where no texel is taken at random
    glFinish();
    const auto start = std::chrono::steady_clock::now();
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    for (const example::Mesh& mesh : scene.meshes) {
        if (mesh.isDoubleSided)
            glDisable(GL_CULL_FACE);
        else
            glEnable(GL_CULL_FACE);
        glBindVertexArray(mesh.vertexArray);
        glDrawElements(GL_TRIANGLES, mesh.indexCount, GL_UNSIGNED_INT, nullptr);
    }
    glFinish();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

void draw(const Options& options) {
    const example::Offscreen screen(options.size[0], options.size[1]);
    const example::CookedScene scene = example::loadCookedScene(options.folder);
    const std::string decode = example::decodeGlsl(scene.lightMap, scene.include, options.isOneTexel);
    const GLuint program = example::makeProgram(kVertexShader, "#version 450\n" + scene.include + decode + kShade);
    bindTextures(program, scene);
    example::setConstants(program, "constants", scene.lightMap.value("constants", nlohmann::json::object()));
    if (scene.lightMap.contains("detail")) example::setConstants(program, "detailConstants", scene.lightMap.at("detail").at("constants"));
    glProgramUniformMatrix4fv(program, glGetUniformLocation(program, "clipFromWorld"), 1, GL_FALSE, glm::value_ptr(clipFromWorld(options)));
    glProgramUniform1f(program, glGetUniformLocation(program, "exposure"), options.exposure);

    glClearColor(0, 0, 0, 1);
    glEnable(GL_DEPTH_TEST);
    glUseProgram(program);
    double shortest = HUGE_VAL;
    for (int frame = 0; frame < options.frames; ++frame) shortest = std::min(shortest, drawFrame(scene, program, frame));
    if (options.frames > 1) std::printf("%s: %.3f ms\n", scene.lightMap.at("layout").get<std::string>().c_str(), shortest);
    screen.writePng(options.picture);
}

}  // namespace

int main(int argc, char** argv) {
    const Options options = parse(argc, argv);
    try {
        draw(options);
    } catch (const std::exception& fault) {
        std::fprintf(stderr, "lightcook_opengl: %s\n", fault.what());
        return 1;
    }
    return 0;
}
