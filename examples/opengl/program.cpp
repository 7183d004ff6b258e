#include "program.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#include <array>
#include <stdexcept>
#include <vector>

namespace example {
namespace {

GLuint compile(GLenum stage, const std::string& text) {
    const GLuint shader = glCreateShader(stage);
    const char* source = text.c_str();
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    GLint isGood = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &isGood);
    std::array<char, 4000> message{};
    glGetShaderInfoLog(shader, static_cast<GLsizei>(message.size()), nullptr, message.data());
    if (isGood == 0) throw std::runtime_error(message.data());
    return shader;
}

/// The numbers of a constant: the manifest has some single ones as arrays of one.
std::vector<float> numbersOf(const nlohmann::json& value) {
    return value.is_array() ? value.get<std::vector<float>>() : std::vector<float>{value.get<float>()};
}

void setUniform(GLuint program, GLint location, GLenum type, GLsizei count, const std::vector<float>& numbers) {
    if (type == GL_FLOAT) glProgramUniform1fv(program, location, count, numbers.data());
    if (type == GL_FLOAT_VEC3) glProgramUniform3fv(program, location, count, numbers.data());
    if (type == GL_FLOAT_VEC4) glProgramUniform4fv(program, location, count, numbers.data());
}

}  // namespace

std::uint32_t makeProgram(const std::string& vertex, const std::string& fragment) {
    const GLuint program = glCreateProgram();
    for (const GLuint shader : {compile(GL_VERTEX_SHADER, vertex), compile(GL_FRAGMENT_SHADER, fragment)}) {
        glAttachShader(program, shader);
        glDeleteShader(shader);  // lives as long as the program
    }
    glLinkProgram(program);
    GLint isGood = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &isGood);
    std::array<char, 4000> message{};
    glGetProgramInfoLog(program, static_cast<GLsizei>(message.size()), nullptr, message.data());
    if (isGood == 0) throw std::runtime_error(message.data());
    return program;
}

void setConstants(std::uint32_t program, const std::string& uniform, const nlohmann::json& constants) {
    const std::string prefix = uniform + ".";
    GLint uniformCount = 0;
    glGetProgramiv(program, GL_ACTIVE_UNIFORMS, &uniformCount);
    for (GLint i = 0; i < uniformCount; ++i) {
        std::array<char, 256> text{};
        GLint count = 0;
        GLenum type = 0;
        glGetActiveUniform(program, static_cast<GLuint>(i), static_cast<GLsizei>(text.size()), nullptr, &count, &type, text.data());
        const std::string name = text.data();  // arrays: "constants.scale[0]"
        if (!name.starts_with(prefix)) continue;
        const std::string key = name.substr(prefix.size(), name.find('[') - prefix.size());
        if (!constants.contains(key)) throw std::runtime_error("cooked.json: no constant \"" + key + "\", which the shader reads");
        setUniform(program, glGetUniformLocation(program, name.c_str()), type, count, numbersOf(constants.at(key)));
    }
}

}  // namespace example
