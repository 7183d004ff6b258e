#include "cooked_scene.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#include <algorithm>
#include <fstream>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "lightcook/formats/api_formats.h"
#include "lightcook/formats/gltf_scene.h"
#include "lightcook/formats/gpu_texture.h"

namespace example {
namespace {

namespace formats = lightcook::formats;
using formats::PixelFormat;
using Json = nlohmann::json;

std::string readText(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    if (!stream) throw std::runtime_error(file.string() + ": cannot be read");
    return text.str();
}

Json readManifest(const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / "cooked.json";
    try {
        return Json::parse(readText(file));
    } catch (const Json::exception& fault) {
        throw std::runtime_error(file.string() + ": " + fault.what());
    }
}

template <class T>
T valueOf(formats::Result<T> result) {
    if (!result) throw std::runtime_error(result.error().line());
    return std::move(*result);
}

/// Format and type of texels that are not compressed.
struct Transfer {
    PixelFormat format;
    GLenum glFormat, glType;
};
constexpr Transfer kTransfers[] = {
    {PixelFormat::Rgb9e5, GL_RGB, GL_UNSIGNED_INT_5_9_9_9_REV},
    {PixelFormat::R11g11b10f, GL_RGB, GL_UNSIGNED_INT_10F_11F_11F_REV},
    {PixelFormat::Rgba16f, GL_RGBA, GL_HALF_FLOAT},
    {PixelFormat::Rgb16f, GL_RGB, GL_HALF_FLOAT},
    {PixelFormat::R16Unorm, GL_RED, GL_UNSIGNED_SHORT},
    {PixelFormat::Rg16Unorm, GL_RG, GL_UNSIGNED_SHORT},
    {PixelFormat::Rgba16Unorm, GL_RGBA, GL_UNSIGNED_SHORT},
    {PixelFormat::Rgba8Unorm, GL_RGBA, GL_UNSIGNED_BYTE},
};

/// Uploads one layer of a mip: array textures take it at a depth, plain ones have no depth.
void uploadImage(const Texture& texture, const formats::TextureShape& shape, formats::SubImage image,
                 const std::vector<std::byte>& texels) {
    const GLsizei width = shape.mipWidth(image.mip), height = shape.mipHeight(image.mip), size = static_cast<GLsizei>(texels.size());
    const GLenum internal = formats::apiFormats(shape.format).gl;
    const auto* transfer = std::ranges::find(kTransfers, shape.format, &Transfer::format);
    if (transfer == std::end(kTransfers)) {
        if (shape.isArray)
            glCompressedTextureSubImage3D(texture.name, image.mip, 0, 0, image.layer, width, height, 1, internal, size, texels.data());
        else
            glCompressedTextureSubImage2D(texture.name, image.mip, 0, 0, width, height, internal, size, texels.data());
    } else if (shape.isArray) {
        glTextureSubImage3D(texture.name, image.mip, 0, 0, image.layer, width, height, 1, transfer->glFormat, transfer->glType,
                            texels.data());
    } else {
        glTextureSubImage2D(texture.name, image.mip, 0, 0, width, height, transfer->glFormat, transfer->glType, texels.data());
    }
}

/// Loads a KTX2 or DDS file. Texels are numbers of a decode: no sRGB.
/// isFetched  true: the shader fetches single texels; false: it filters, as the errors in report.json assume
Texture loadTexture(const std::filesystem::path& file, bool isFetched) {
    const formats::TextureReader reader = valueOf(formats::TextureReader::open(file));
    const formats::TextureShape& shape = reader.shape();
    Texture texture{0, static_cast<std::uint32_t>(shape.isArray ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D)};
    glCreateTextures(texture.target, 1, &texture.name);
    const GLenum internal = formats::apiFormats(shape.format).gl;
    if (shape.isArray)
        glTextureStorage3D(texture.name, shape.mipCount, internal, shape.width, shape.height, shape.layerCount);
    else
        glTextureStorage2D(texture.name, shape.mipCount, internal, shape.width, shape.height);
    for (int mip = 0; mip < shape.mipCount; ++mip)
        for (int layer = 0; layer < shape.layerCount; ++layer)
            uploadImage(texture, shape, {mip, layer, 0}, valueOf(reader.readImage({mip, layer, 0})));
    // No other level than the first can be fetched of a texture whose filter has no mips.
    const bool hasMips = shape.mipCount > 1;
    const GLenum filtered = hasMips ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR, fetched = hasMips ? GL_NEAREST_MIPMAP_NEAREST : GL_NEAREST;
    glTextureParameteri(texture.name, GL_TEXTURE_MIN_FILTER, isFetched ? fetched : filtered);
    glTextureParameteri(texture.name, GL_TEXTURE_MAG_FILTER, isFetched ? GL_NEAREST : GL_LINEAR);
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) glTextureParameteri(texture.name, wrap, GL_CLAMP_TO_EDGE);
    if (glGetError() != GL_NO_ERROR) throw std::runtime_error(file.string() + ": this device has no such texture");
    return texture;
}

struct Vertex {
    glm::vec3 position, normal;
    glm::vec2 lightMapUv;
    float cluster;
};

std::vector<Vertex> verticesOf(const formats::GltfScene::Placed& placed, const std::filesystem::path& file) {
    const formats::MeshAttribute* positions = placed.mesh->find("POSITION");
    const formats::MeshAttribute* normals = placed.mesh->find("NORMAL");
    const formats::MeshAttribute* uvs = placed.mesh->find("TEXCOORD_1");
    const formats::MeshAttribute* clusters = placed.mesh->find(formats::kBasisAttribute);
    if (positions == nullptr || normals == nullptr || uvs == nullptr)
        throw std::runtime_error(file.string() + ": a primitive without POSITION, NORMAL or TEXCOORD_1");
    const glm::dmat3 normalMatrix = glm::transpose(glm::inverse(glm::dmat3(placed.worldFromMesh)));
    std::vector<Vertex> vertices(placed.mesh->vertexCount());
    for (std::size_t i = 0; i < vertices.size(); ++i)
        vertices[i] = {glm::vec3(placed.worldFromMesh * glm::dvec4(positions->at(i), 1.0)), glm::vec3(normalMatrix * normals->at(i)),
                       glm::vec2(uvs->at(i)), clusters == nullptr ? 0.0f : static_cast<float>(clusters->at(i).x)};
    return vertices;
}

/// Copies values to a new buffer.
template <class T>
GLuint bufferOf(const std::vector<T>& values) {
    GLuint buffer = 0;
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, static_cast<GLsizeiptr>(values.size() * sizeof(T)), values.data(), 0);
    return buffer;
}

Mesh uploadMesh(const std::vector<Vertex>& vertices, const std::vector<std::uint32_t>& indices, bool isDoubleSided) {
    Mesh mesh{0, static_cast<int>(indices.size()), isDoubleSided};
    glCreateVertexArrays(1, &mesh.vertexArray);
    glVertexArrayVertexBuffer(mesh.vertexArray, 0, bufferOf(vertices), 0, sizeof(Vertex));
    glVertexArrayElementBuffer(mesh.vertexArray, bufferOf(indices));
    const struct {
        GLint size;
        std::size_t offset;
    } attributes[] = {
        {3, offsetof(Vertex, position)}, {3, offsetof(Vertex, normal)}, {2, offsetof(Vertex, lightMapUv)}, {1, offsetof(Vertex, cluster)}};
    for (GLuint i = 0; i < std::size(attributes); ++i) {
        glEnableVertexArrayAttrib(mesh.vertexArray, i);
        glVertexArrayAttribFormat(mesh.vertexArray, i, attributes[i].size, GL_FLOAT, GL_FALSE, static_cast<GLuint>(attributes[i].offset));
        glVertexArrayAttribBinding(mesh.vertexArray, i, 0);
    }
    return mesh;
}

std::vector<Mesh> loadMeshes(const std::filesystem::path& file) {
    const formats::GltfScene scene = valueOf(formats::GltfScene::load(file));
    std::vector<Mesh> meshes;
    for (const formats::GltfScene::Placed& placed : scene.placedMeshes()) {
        std::vector<std::uint32_t> indices = placed.mesh->indices;
        // A node that mirrors turns the order of corners round (glTF 2.0, 3.7.4).
        if (glm::determinant(glm::dmat3(placed.worldFromMesh)) < 0)
            for (std::size_t i = 0; i + 2 < indices.size(); i += 3) std::swap(indices[i + 1], indices[i + 2]);
        meshes.push_back(uploadMesh(verticesOf(placed, file), indices, placed.isDoubleSided));
    }
    return meshes;
}

}  // namespace

CookedScene loadCookedScene(const std::filesystem::path& folder) {
    const Json manifest = readManifest(folder);
    CookedScene scene;
    scene.include = readText(folder / manifest.at("shader").at("file"));
    const Json& assets = manifest.at("assets");
    const auto lightMap = std::ranges::find_if(assets, [](const Json& asset) { return asset.at("kind") == "light-map"; });
    if (lightMap == assets.end()) throw std::runtime_error((folder / "cooked.json").string() + ": no light map");
    scene.lightMap = *lightMap;
    for (const Json& texture : scene.lightMap.at("textures")) {
        const bool isFetched = texture.at("sampler").at("filter") == "nearest";
        scene.textures[texture.at("role")] = loadTexture(folder / texture.at("file"), isFetched);
    }
    for (const Json& asset : assets)
        if (asset.at("kind") == "mesh" && asset.value("light_map", "") == scene.lightMap.at("name"))
            for (const Mesh& mesh : loadMeshes(folder / asset.at("file"))) scene.meshes.push_back(mesh);
    return scene;
}

}  // namespace example
