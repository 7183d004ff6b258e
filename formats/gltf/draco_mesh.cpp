#include "formats/gltf/draco_mesh.h"

#include <draco/attributes/attribute_octahedron_transform.h>
#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>

#include "formats/file/one_line.h"
#include "formats/gltf/draco_sources.h"
#include "formats/memory.h"
#include "formats/reader/reader_process.h"

namespace lightcook::formats {
namespace {

draco::DataType dracoType(ComponentType type) {
    switch (type) {
        case ComponentType::Int8:
            return draco::DT_INT8;
        case ComponentType::Uint8:
            return draco::DT_UINT8;
        case ComponentType::Int16:
            return draco::DT_INT16;
        case ComponentType::Uint16:
            return draco::DT_UINT16;
        case ComponentType::Uint32:
            return draco::DT_UINT32;
        case ComponentType::Float32:
            return draco::DT_FLOAT32;
    }
    return draco::DT_INVALID;
}

/// Returns the role by which Draco predicts values. Normals of integers (KHR_mesh_quantization) have none: Draco would take them for
/// octahedral coordinates, and not give them back. Readers of glTF find attributes by their ids.
draco::GeometryAttribute::Type dracoRole(const MeshAttribute& attribute) {
    if (attribute.semantic == "POSITION") return draco::GeometryAttribute::POSITION;
    if (attribute.semantic == "NORMAL") return attribute.isFloat() ? draco::GeometryAttribute::NORMAL : draco::GeometryAttribute::GENERIC;
    if (attribute.semantic.starts_with("TEXCOORD_")) return draco::GeometryAttribute::TEX_COORD;
    if (attribute.semantic.starts_with("COLOR_")) return draco::GeometryAttribute::COLOR;
    return draco::GeometryAttribute::GENERIC;
}

std::unique_ptr<draco::PointAttribute> dracoAttribute(const MeshAttribute& attribute) {
    auto result = std::make_unique<draco::PointAttribute>();
    result->Init(dracoRole(attribute), static_cast<std::int8_t>(attribute.componentCount), dracoType(attribute.componentType),
                 attribute.isNormalized, attribute.vertexCount());
    assert(static_cast<std::size_t>(result->byte_stride()) == attribute.bytesPerVertex());
    result->buffer()->Write(0, attribute.values.data(), attribute.values.size());
    return result;
}

/// Reads the head of a Draco stream, byte by byte.
class DracoHead {
public:
    explicit DracoHead(std::span<const std::byte> bytes) : bytes_(bytes) {}
    std::uint64_t byte() {
        if (bytes_.empty()) return 0;
        const auto value = std::to_integer<std::uint64_t>(bytes_.front());
        bytes_ = bytes_.subspan(1);
        return value;
    }
    /// Reads an integer of 7 bits a byte, the lowest first.
    std::uint64_t varint() {
        std::uint64_t value = 0;
        for (int shift = 0; shift < 35; shift += 7) {
            const std::uint64_t next = byte();
            value |= (next & 0x7f) << shift;
            if ((next & 0x80) == 0) break;
        }
        return value;
    }

private:
    std::span<const std::byte> bytes_;
};

/// Returns the memory that the counts at the head of a stream ask for, before Draco allocates it; 0 where the head has another form (older
/// streams and those with metadata), which the decoder judges itself.
std::uint64_t claimedMemory(std::span<const std::byte> bytes) {
    constexpr std::uint64_t kFaceBytes = 64, kPointBytes = 32;  // corner table, faces, maps from points to values
    constexpr std::size_t kHeadBytes = 11;
    if (bytes.size() < kHeadBytes || std::memcmp(bytes.data(), "DRACO", 5) != 0) return 0;
    DracoHead head(bytes.subspan(5));
    const std::uint64_t major = head.byte(), minor = head.byte(), kind = head.byte(), method = head.byte();
    const std::uint64_t flags = head.byte() | head.byte() << 8;
    if (major != 2 || minor < 2 || kind != draco::TRIANGULAR_MESH || flags != 0) return 0;
    if (method == draco::MESH_EDGEBREAKER_ENCODING) head.byte();  // kind of traversal
    const std::uint64_t first = head.varint(), second = head.varint();
    const auto [faces, points] = method == draco::MESH_EDGEBREAKER_ENCODING ? std::pair(second, first) : std::pair(first, second);
    return faces * kFaceBytes + points * kPointBytes;
}

tl::expected<std::unique_ptr<draco::Mesh>, std::string> decodeMesh(std::span<const std::byte> bytes, bool keepsLattices) try {
    if (const auto fits = checkMemory(claimedMemory(bytes), ""); !fits) return tl::make_unexpected(fits.error().detail);
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    if (keepsLattices)
        for (const auto type : {draco::GeometryAttribute::POSITION, draco::GeometryAttribute::NORMAL, draco::GeometryAttribute::TEX_COORD})
            decoder.SetSkipAttributeTransform(type);
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok()) return tl::make_unexpected(oneLine(mesh.status().error_msg_string()));
    return std::move(mesh).value();
} catch (const std::bad_alloc&) {
    return tl::make_unexpected(std::string("more values than there is memory for"));
} catch (const std::length_error&) {
    return tl::make_unexpected(std::string("more values than there is memory for"));
}

/// Copies one attribute, in the component type that glTF promises for it.
template <class Component>
bool copyValues(const draco::PointAttribute& from, std::uint32_t pointCount, MeshAttribute& to) {
    std::vector<Component> vertex(static_cast<std::size_t>(to.componentCount));
    std::byte* out = to.values.data();
    for (std::uint32_t point = 0; point < pointCount; ++point, out += to.bytesPerVertex()) {
        const draco::AttributeValueIndex index = from.mapped_index(draco::PointIndex(point));
        if (index.value() >= from.size()) return false;
        if (!from.ConvertValue<Component>(index, static_cast<std::int8_t>(to.componentCount), vertex.data())) return false;
        std::memcpy(out, vertex.data(), to.bytesPerVertex());
    }
    return true;
}

bool copyValues(const draco::PointAttribute& from, std::uint32_t pointCount, MeshAttribute& to) {
    switch (to.componentType) {
        case ComponentType::Int8:
            return copyValues<std::int8_t>(from, pointCount, to);
        case ComponentType::Uint8:
            return copyValues<std::uint8_t>(from, pointCount, to);
        case ComponentType::Int16:
            return copyValues<std::int16_t>(from, pointCount, to);
        case ComponentType::Uint16:
            return copyValues<std::uint16_t>(from, pointCount, to);
        case ComponentType::Uint32:
            return copyValues<std::uint32_t>(from, pointCount, to);
        case ComponentType::Float32:
            return copyValues<float>(from, pointCount, to);
    }
    return false;
}

}  // namespace

tl::expected<DracoMesh, std::string> encodeDraco(const TriangleMesh& mesh, std::span<const std::optional<Quantization>> quantization,
                                                 int speed) {
    assert(quantization.size() == mesh.attributes.size());
    draco::Mesh source;
    source.set_num_points(static_cast<draco::PointIndex::ValueType>(mesh.vertexCount()));
    source.SetNumFaces(mesh.triangleCount());
    for (std::size_t triangle = 0; triangle < mesh.triangleCount(); ++triangle) {
        const std::uint32_t* corner = &mesh.indices[3 * triangle];
        source.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(triangle)),
                       {draco::PointIndex(corner[0]), draco::PointIndex(corner[1]), draco::PointIndex(corner[2])});
    }
    DracoMesh result;
    for (const MeshAttribute& attribute : mesh.attributes) {
        result.uniqueIds.push_back(static_cast<int>(source.attribute(source.AddAttribute(dracoAttribute(attribute)))->unique_id()));
    }
    // Edgebreaker follows the surface by shared positions: without this every seam of a normal or a UV would be a hole.
    if (!source.DeduplicateAttributeValues()) return tl::make_unexpected(std::string("attribute values cannot be merged"));
    source.DeduplicatePointIds();

    draco::ExpertEncoder encoder(source);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetSpeedOptions(speed, speed);
    for (std::size_t i = 0; i < quantization.size(); ++i) {
        if (!quantization[i]) continue;
        const Quantization& lattice = *quantization[i];
        if (lattice.origin.empty()) {
            encoder.SetAttributeQuantization(static_cast<int>(i), lattice.bits);
        } else {
            encoder.SetAttributeExplicitQuantization(static_cast<int>(i), lattice.bits, static_cast<int>(lattice.origin.size()),
                                                     lattice.origin.data(), lattice.range);
        }
    }
    draco::EncoderBuffer buffer;
    if (const draco::Status status = encoder.EncodeToBuffer(&buffer); !status.ok())
        return tl::make_unexpected(oneLine(status.error_msg_string()));
    const auto bytes = std::as_bytes(std::span(buffer.data(), buffer.size()));
    result.bytes.assign(bytes.begin(), bytes.end());

    std::vector<DracoAttribute> attributes;
    for (std::size_t i = 0; i < mesh.attributes.size(); ++i) {
        const MeshAttribute& attribute = mesh.attributes[i];
        attributes.push_back(
            {attribute.semantic, result.uniqueIds[i], attribute.componentType, attribute.componentCount, attribute.isNormalized});
    }
    LC_TRY(decoded, decodeDracoHere(result.bytes, attributes));
    result.decoded = std::move(*decoded);
    return result;
}

tl::expected<TriangleMesh, std::string> decodeDracoHere(std::span<const std::byte> bytes, std::span<const DracoAttribute> attributes) {
    LC_TRY(mesh, decodeMesh(bytes, false));
    TriangleMesh result;
    const std::uint32_t pointCount = (*mesh)->num_points();
    for (const DracoAttribute& wanted : attributes) {
        const draco::PointAttribute* found =
            wanted.uniqueId < 0 ? nullptr : (*mesh)->GetAttributeByUniqueId(static_cast<std::uint32_t>(wanted.uniqueId));
        if (found == nullptr) return tl::make_unexpected(fmt::format("no attribute {} for {}", wanted.uniqueId, wanted.semantic));
        if (found->num_components() != wanted.componentCount) {
            return tl::make_unexpected(fmt::format("{} components in attribute {}, where {} has {}", found->num_components(),
                                                   wanted.uniqueId, wanted.semantic, wanted.componentCount));
        }
        MeshAttribute& attribute = result.attributes.emplace_back();
        attribute.semantic = wanted.semantic;
        attribute.componentType = wanted.componentType;
        attribute.componentCount = wanted.componentCount;
        attribute.isNormalized = wanted.isNormalized;
        attribute.values.resize(attribute.bytesPerVertex() * pointCount);
        if (!copyValues(*found, pointCount, attribute))
            return tl::make_unexpected(fmt::format("values of {} that do not fit their type", wanted.semantic));
    }
    for (std::uint32_t face = 0; face < (*mesh)->num_faces(); ++face) {
        for (const draco::PointIndex& corner : (*mesh)->face(draco::FaceIndex(face))) {
            if (corner.value() >= pointCount)
                return tl::make_unexpected(fmt::format("a triangle with vertex {} of {}", corner.value(), pointCount));
            result.indices.push_back(corner.value());
        }
    }
    return result;
}

tl::expected<DracoLattices, std::string> dracoLatticesHere(std::span<const std::byte> bytes) {
    LC_TRY(mesh, decodeMesh(bytes, true));
    DracoLattices lattices;
    for (int index = 0; index < (*mesh)->num_attributes(); ++index) {
        const draco::PointAttribute& attribute = *(*mesh)->attribute(index);
        if (attribute.GetAttributeTransformData() == nullptr) continue;
        const int id = static_cast<int>(attribute.unique_id());
        draco::AttributeQuantizationTransform lattice;
        draco::AttributeOctahedronTransform octahedron;
        if (lattice.InitFromAttribute(attribute)) {
            lattices.bitsOfId[id] = lattice.quantization_bits();
            if (attribute.attribute_type() == draco::GeometryAttribute::POSITION)
                lattices.positionStep = static_cast<double>(lattice.range()) / (std::ldexp(1.0, lattice.quantization_bits()) - 1);
        } else if (octahedron.InitFromAttribute(attribute)) {
            lattices.bitsOfId[id] = octahedron.quantization_bits();
        }
    }
    return lattices;
}

tl::expected<TriangleMesh, std::string> decodeDraco(std::span<const std::byte> bytes, std::span<const DracoAttribute> attributes) {
    return areReadersChildren() ? decodeDracoInChild(bytes, attributes) : decodeDracoHere(bytes, attributes);
}

tl::expected<DracoLattices, std::string> dracoLattices(std::span<const std::byte> bytes) {
    return areReadersChildren() ? dracoLatticesInChild(bytes) : dracoLatticesHere(bytes);
}

}  // namespace lightcook::formats
