#include "formats/gltf/primitive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <span>
#include <utility>

#include "formats/gltf/draco_mesh.h"
#include "formats/gltf/foreign_extensions.h"
#include "formats/gltf/light_map_uvs.h"
#include "formats/memory.h"

namespace lightcook::formats {
namespace {

/// Modes of glTF's primitives.
constexpr std::uint64_t kTriangles = 4, kTriangleStrip = 5, kTriangleFan = 6;

bool areTriangles(std::uint64_t mode) {
    return mode == kTriangles || mode == kTriangleStrip || mode == kTriangleFan;
}

bool hasMorphTargets(const Json& primitive) {
    return !primitive.value("targets", Json::array()).empty();
}

/// Returns the triangles of a strip or a fan with the winding that glTF 2.0 (3.7.2.1) gives them, without those that name a vertex twice,
/// which join strips.
std::vector<std::uint32_t> trianglesOf(std::uint64_t mode, const std::vector<std::uint32_t>& chain) {
    std::vector<std::uint32_t> triangles;
    for (std::size_t i = 0; i + 2 < chain.size(); ++i) {
        const std::size_t odd = i % 2;
        const std::array<std::uint32_t, 3> corners = mode == kTriangleStrip ? std::array{chain[i], chain[i + 1 + odd], chain[i + 2 - odd]}
                                                                            : std::array{chain[i + 1], chain[i + 2], chain[0]};
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
        triangles.insert(triangles.end(), corners.begin(), corners.end());
    }
    return triangles;
}

const Json* dracoExtension(const Json& primitive) {
    const auto extensions = primitive.find("extensions");
    if (extensions == primitive.end() || !extensions->is_object()) return nullptr;
    const auto draco = extensions->find(kDracoExtension);
    return draco == extensions->end() ? nullptr : &*draco;
}

/// Keeps the accessors that it has read, because primitives share them.
class PrimitiveReader {
public:
    explicit PrimitiveReader(const GltfDocument& document) : document_(document) {}

    std::vector<Primitive> readAll() {
        std::vector<Primitive> primitives;
        const Json meshes = document_.json().value("meshes", Json::array());
        for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh) {
            const Json list = meshes[mesh].value("primitives", Json::array());
            for (std::size_t index = 0; index < list.size(); ++index) primitives.push_back(read(list[index], mesh, index));
        }
        return primitives;
    }

private:
    Primitive read(const Json& json, std::size_t mesh, std::size_t index) {
        Primitive primitive;
        primitive.mesh = mesh;
        primitive.index = index;
        const std::string place = primitive.place();
        const std::uint64_t mode = document_.number(json, "mode", kTriangles, place);
        primitive.isTriangles = areTriangles(mode);
        primitive.canCompress = primitive.isTriangles && !hasMorphTargets(json) && !hasOrderedExtension(json);
        const Json attributes = json.value("attributes", Json::object());
        if (!attributes.contains("POSITION")) document_.fail(ErrorCode::WrongShape, place, "found no POSITION, expected one");
        bool isChain = mode != kTriangles && primitive.isTriangles;  // strip or fan
        if (const Json* draco = dracoExtension(json)) {
            isChain = false;  // Draco streams hold single triangles, also those of strips
            primitive.dracoView = document_.number(*draco, "bufferView", 0, place);
            readDraco(*draco, attributes, primitive);
        } else {
            for (const auto& [semantic, accessor] : attributes.items())
                primitive.geometry.attributes.push_back(shared(attributes, semantic, place));
            if (primitive.isTriangles) readIndices(json, primitive);
        }
        checkSize(primitive);
        check(attributes, primitive, isChain);
        if (isChain) primitive.geometry.indices = trianglesOf(mode, primitive.geometry.indices);
        primitive.vertexCount = primitive.geometry.vertexCount();
        // Drop unused vertices right away: scenes share one set of vertices between dozens of primitives.
        if (primitive.isTriangles) {
            primitive.usedVertices = usedVerticesOf(primitive.geometry);
            primitive.geometry = withoutUnusedVertices(primitive.geometry);
        }
        return primitive;
    }

    /// Refuses files whose primitives share so much geometry that reading them all takes minutes, or more memory than there is.
    void checkSize(const Primitive& primitive) {
        constexpr std::uint64_t kStep = std::uint64_t{256} << 20, kMostSharing = 1024;
        const std::uint64_t before = geometryBytes_, most = 2 * kStep + kMostSharing * document_.fileBytes();
        for (const MeshAttribute& attribute : primitive.geometry.attributes) geometryBytes_ += attribute.values.size();
        if (geometryBytes_ > most)
            document_.fail(
                ErrorCode::WrongShape, primitive.place(),
                fmt::format("found primitives that hold {} MiB of vertices so far, expected at most {} MiB in a file of {} bytes",
                            geometryBytes_ >> 20, most >> 20, document_.fileBytes()));
        if (before / kStep == geometryBytes_ / kStep) return;
        if (const auto fits = checkMemory(2 * kStep, Subject(document_.file()).at(primitive.place())); !fits) throw GltfFault(fits.error());
    }

    static std::vector<std::uint32_t> usedVerticesOf(const TriangleMesh& mesh) {
        std::vector<bool> isUsed(mesh.vertexCount(), false);
        for (const std::uint32_t index : mesh.indices) isUsed[index] = true;
        std::vector<std::uint32_t> used;
        for (std::uint32_t vertex = 0; vertex < isUsed.size(); ++vertex)
            if (isUsed[vertex]) used.push_back(vertex);
        return used;
    }

    MeshAttribute shared(const Json& attributes, const std::string& semantic, const std::string& place) {
        const std::uint64_t accessor = document_.number(attributes, semantic.c_str(), 0, place);
        const auto found = read_.find(accessor);
        if (found == read_.end()) return read_.emplace(accessor, document_.readAccessor(accessor, semantic)).first->second;
        MeshAttribute copy = found->second;
        copy.semantic = semantic;
        return copy;
    }

    void readDraco(const Json& draco, const Json& attributes, Primitive& primitive) const {
        std::vector<DracoAttribute> wanted;
        const Json ids = draco.value("attributes", Json::object());
        for (const auto& [semantic, accessor] : attributes.items()) {
            const MeshAttribute type =
                document_.accessorType(document_.number(attributes, semantic.c_str(), 0, primitive.place()), semantic);
            if (!ids.contains(semantic)) {
                document_.fail(ErrorCode::FormatUnsupported, primitive.place(),
                               fmt::format("found {} outside the Draco stream, expected every attribute in it", semantic));
            }
            const std::uint64_t id = document_.number(ids, semantic.c_str(), 0, primitive.place());
            primitive.dracoIds[semantic] = static_cast<int>(std::min<std::uint64_t>(id, 0x7FFFFFFF));
            wanted.push_back({semantic, primitive.dracoIds[semantic], type.componentType, type.componentCount, type.isNormalized});
        }
        auto decoded = decodeDraco(document_.bufferView(*primitive.dracoView), wanted);
        if (!decoded) {
            document_.fail(ErrorCode::FileUnreadable, fmt::format("{}, bufferView {}", primitive.place(), *primitive.dracoView),
                           fmt::format("found \"{}\", expected a Draco mesh", decoded.error()));
        }
        primitive.geometry = std::move(*decoded);
    }

    void readIndices(const Json& json, Primitive& primitive) const {
        std::vector<std::uint32_t>& indices = primitive.geometry.indices;
        if (!json.contains("indices")) {
            for (std::uint32_t vertex = 0; vertex < primitive.geometry.vertexCount(); ++vertex) indices.push_back(vertex);
            return;
        }
        const MeshAttribute read = document_.readAccessor(document_.number(json, "indices", 0, primitive.place()), "indices");
        const bool isWhole = read.componentType == ComponentType::Uint8 || read.componentType == ComponentType::Uint16 ||
                             read.componentType == ComponentType::Uint32;
        if (!isWhole || read.componentCount != 1)
            document_.fail(ErrorCode::WrongShape, primitive.place(), "found indices of another type, expected unsigned scalars");
        const std::size_t bytes = read.bytesPerVertex();
        for (std::size_t i = 0; i < read.vertexCount(); ++i) {
            std::uint32_t index = 0;  // little-endian, as we are
            std::memcpy(&index, read.values.data() + i * bytes, bytes);
            indices.push_back(index);
        }
    }

    void check(const Json& attributes, const Primitive& primitive, bool isChain) const {
        const TriangleMesh& geometry = primitive.geometry;
        for (const MeshAttribute& attribute : geometry.attributes) {
            const std::string place =
                fmt::format("accessor {} ({} of {})", attributes[attribute.semantic].dump(), attribute.semantic, primitive.place());
            if (attribute.vertexCount() != geometry.vertexCount()) {
                document_.fail(ErrorCode::WrongShape, place,
                               fmt::format("found {} vertices, expected {} as in {}", attribute.vertexCount(), geometry.vertexCount(),
                                           geometry.attributes.front().semantic));
            }
            const int components = attribute.semantic == "POSITION" || attribute.semantic == "NORMAL" ? 3
                                   : attribute.semantic.starts_with("TEXCOORD_")                      ? 2
                                                                                                      : attribute.componentCount;
            if (attribute.componentCount != components) {
                document_.fail(ErrorCode::WrongShape, place,
                               fmt::format("found {} components, expected {}", attribute.componentCount, components));
            }
            if (mustBeFinite(attribute)) checkFinite(attribute, place);
        }
        if (!isChain && geometry.indices.size() % 3 != 0) {
            document_.fail(ErrorCode::WrongShape, primitive.place(),
                           fmt::format("found {} indices, expected a multiple of 3", geometry.indices.size()));
        }
        for (std::size_t i = 0; i < geometry.indices.size(); ++i) {
            if (geometry.indices[i] < geometry.vertexCount()) continue;
            document_.fail(ErrorCode::WrongShape, fmt::format("{}, index {}", primitive.place(), i),
                           fmt::format("found vertex {}, expected less than {}", geometry.indices[i], geometry.vertexCount()));
        }
    }

    void checkFinite(const MeshAttribute& attribute, const std::string& place) const {
        for (std::size_t vertex = 0; vertex < attribute.vertexCount(); ++vertex) {
            const glm::dvec3 value = attribute.at(vertex);
            if (std::isfinite(value.x) && std::isfinite(value.y) && std::isfinite(value.z)) continue;
            const std::array components = {value.x, value.y, value.z};
            const std::span found(components.data(), static_cast<std::size_t>(attribute.componentCount));  // 2 or 3: see check
            document_.fail(ErrorCode::ValueNotFinite, fmt::format("{}, vertex {}", place, vertex),
                           fmt::format("found ({}), expected finite values", fmt::join(found, ", ")));
        }
    }

    const GltfDocument& document_;
    std::map<std::uint64_t, MeshAttribute> read_;
    std::uint64_t geometryBytes_ = 0;  ///< of the primitives so far, with what they share
};

/// Calls visit(primitive, json) for each triangle primitive. Reads no buffers: of the primitive only the place is known.
template <class Visit>
void visitTriangles(const GltfDocument& document, Visit visit) {
    Primitive primitive;
    const Json meshes = document.json().value("meshes", Json::array());
    for (primitive.mesh = 0; primitive.mesh < meshes.size(); ++primitive.mesh) {
        const Json list = meshes[primitive.mesh].value("primitives", Json::array());
        for (primitive.index = 0; primitive.index < list.size(); ++primitive.index)
            if (const Json& json = list[primitive.index]; areTriangles(document.number(json, "mode", kTriangles, primitive.place())))
                visit(primitive, json);
    }
}

}  // namespace

std::set<std::uint64_t> meshesWithLightMapUvs(const GltfDocument& document) {
    std::set<std::uint64_t> meshes;
    visitTriangles(document, [&](const Primitive& primitive, const Json& json) {
        if (hasLightMapUvs(document, json)) meshes.insert(primitive.mesh);
    });
    return meshes;
}

std::set<std::uint64_t> meshesWithoutLightMapUvs(const GltfDocument& document) {
    std::set<std::uint64_t> meshes;
    visitTriangles(document, [&](const Primitive& primitive, const Json& json) {
        if (!hasLightMapUvs(document, json)) meshes.insert(primitive.mesh);
    });
    return meshes;
}

std::string freeUv(const std::vector<Primitive>& primitives) {
    for (int set = 2;; ++set) {
        std::string name = fmt::format("TEXCOORD_{}", set);
        const auto has = [&](const Primitive& primitive) { return primitive.isTriangles && primitive.geometry.find(name) != nullptr; };
        if (std::ranges::none_of(primitives, has)) return name;
    }
}

bool mustBeFinite(const MeshAttribute& attribute) {
    return attribute.isFloat() &&
           (attribute.semantic == "POSITION" || attribute.semantic == "NORMAL" || attribute.semantic.starts_with("TEXCOORD_"));
}

std::vector<Primitive> readPrimitives(const GltfDocument& document) {
    return PrimitiveReader(document).readAll();
}

}  // namespace lightcook::formats
