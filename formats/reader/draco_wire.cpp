// Streams of Draco behind the wall: both sides of it. The stream goes to the reader as a file in memory; the mesh comes back in pieces of
// kPieceBytes: its indices, then the values of each attribute.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "formats/gltf/draco_sources.h"
#include "formats/memory.h"
#include "formats/reader/decoders.h"
#include "formats/reader/reader_process.h"
#include "formats/system_calls.h"

namespace lightcook::formats {
namespace {

constexpr const char* kSubject = "Draco mesh";  // whoever asks knows its file

Result<std::vector<std::byte>> contentOf(int file) {
    struct stat status {};
    if (::fstat(file, &status) != 0) return failure(ErrorCode::FileUnreadable, kSubject, std::strerror(errno));
    std::vector<std::byte> content(static_cast<std::size_t>(status.st_size));
    for (std::size_t done = 0; done < content.size();) {
        const ssize_t count =
            retried([&] { return ::pread(file, content.data() + done, content.size() - done, static_cast<off_t>(done)); });
        if (count <= 0) return failure(ErrorCode::FileUnreadable, kSubject, "a stream that ends too early");
        done += static_cast<std::size_t>(count);
    }
    return content;
}

void putAttributes(WireWriter& out, std::span<const DracoAttribute> attributes) {
    out.put(static_cast<std::uint32_t>(attributes.size()));
    for (const DracoAttribute& each : attributes) {
        out.put(std::string_view(each.semantic));
        out.put(each.uniqueId);
        out.put(each.componentType);
        out.put(each.componentCount);
        out.put(each.isNormalized);
    }
}

std::vector<DracoAttribute> getAttributes(WireReader& in) {
    std::vector<DracoAttribute> attributes(in.get<std::uint32_t>());
    for (DracoAttribute& each : attributes) {
        each.semantic = in.text();
        each.uniqueId = in.get<int>();
        each.componentType = in.get<ComponentType>();
        each.componentCount = in.get<int>();
        each.isNormalized = in.get<bool>();
    }
    return attributes;
}

/// Starts a reader of a stream, and opens it.
struct OpenStream {
    ReaderProcess reader;
    std::unique_ptr<WireReader> description;
};
tl::expected<OpenStream, std::string> openStream(ForeignKind kind, std::span<const std::byte> bytes, const WireWriter& arguments) {
    const Descriptor file = makeMemoryFile(bytes);
    if (!file.isOpen()) return tl::make_unexpected(std::string(std::strerror(errno)));
    auto reader = ReaderProcess::start(kind, file.number(), kSubject);
    if (!reader) return tl::make_unexpected(reader.error().line());
    auto description = reader->open(arguments);
    if (!description) return tl::make_unexpected(description.error().detail);
    return OpenStream{std::move(*reader), std::move(*description)};
}

class DracoBehindWall : public ForeignDecoder {
public:
    explicit DracoBehindWall(const ForeignInput& input) : input_(input) {}
    Result<void> open(WireReader& arguments, WireWriter& description) override {
        LC_TRY(stream, contentOf(input_.descriptor));
        auto mesh = decodeDracoHere(*stream, getAttributes(arguments));
        if (!mesh) return failure(ErrorCode::FileUnreadable, kSubject, mesh.error());
        mesh_ = std::move(*mesh);
        description.put(static_cast<std::uint64_t>(mesh_.indices.size()));
        description.put(static_cast<std::uint64_t>(mesh_.vertexCount()));
        parts_ = {std::as_bytes(std::span(mesh_.indices))};
        for (const MeshAttribute& each : mesh_.attributes) parts_.emplace_back(each.values);
        return {};
    }
    Result<void> read(WireReader& arguments, std::span<std::byte> out) override {
        const auto part = parts_.at(arguments.get<std::uint32_t>());
        const auto offset = arguments.get<std::uint64_t>(), bytes = arguments.get<std::uint64_t>();
        std::ranges::copy(part.subspan(offset, bytes), out.begin());
        return {};
    }

private:
    ForeignInput input_;
    TriangleMesh mesh_;
    std::vector<std::span<const std::byte>> parts_;
};

class DracoLatticesBehindWall : public ForeignDecoder {
public:
    explicit DracoLatticesBehindWall(const ForeignInput& input) : input_(input) {}
    Result<void> open(WireReader& /*arguments*/, WireWriter& description) override {
        LC_TRY(stream, contentOf(input_.descriptor));
        const auto lattices = dracoLatticesHere(*stream);
        if (!lattices) return failure(ErrorCode::FileUnreadable, kSubject, lattices.error());
        description.put(lattices->positionStep);
        description.put(static_cast<std::uint32_t>(lattices->bitsOfId.size()));
        for (const auto& [id, bits] : lattices->bitsOfId) {
            description.put(id);
            description.put(bits);
        }
        return {};
    }
    Result<void> read(WireReader& /*arguments*/, std::span<std::byte> /*out*/) override { return {}; }

private:
    ForeignInput input_;
};

/// Reads one part of a mesh, whose size is known.
Result<void> readPart(ReaderProcess& reader, std::uint32_t part, std::span<std::byte> out) {
    for (std::size_t offset = 0; offset < out.size();) {
        const std::size_t bytes = std::min(kPieceBytes, out.size() - offset);
        WireWriter request;
        request.put(part);
        request.put(static_cast<std::uint64_t>(offset));
        request.put(static_cast<std::uint64_t>(bytes));
        LC_TRY(piece, reader.read(request, bytes));
        std::memcpy(out.data() + offset, piece->data(), bytes);
        offset += bytes;
    }
    return {};
}

}  // namespace

tl::expected<TriangleMesh, std::string> decodeDracoInChild(std::span<const std::byte> bytes, std::span<const DracoAttribute> attributes) {
    WireWriter arguments;
    putAttributes(arguments, attributes);
    LC_TRY(stream, openStream(ForeignKind::DracoMesh, bytes, arguments));
    ReaderProcess& reader = stream->reader;
    const auto indexCount = stream->description->get<std::uint64_t>(), vertexCount = stream->description->get<std::uint64_t>();
    std::size_t bytesPerVertex = 0;
    for (const DracoAttribute& each : attributes)
        bytesPerVertex += componentBytes(each.componentType) * static_cast<std::size_t>(each.componentCount);
    constexpr std::uint64_t kMost = std::uint64_t{1} << 32;
    if (!stream->description->isWhole() || indexCount > 3 * kMost || indexCount % 3 != 0 || vertexCount > kMost)
        return tl::make_unexpected(reader.senseless().value().detail);
    if (const auto fits = checkMemory(indexCount * sizeof(std::uint32_t) + vertexCount * bytesPerVertex, ""); !fits)
        return tl::make_unexpected(fits.error().detail);
    TriangleMesh mesh;
    mesh.indices.resize(indexCount);
    Result<void> read = readPart(reader, 0, std::as_writable_bytes(std::span(mesh.indices)));
    for (const DracoAttribute& each : attributes) {
        MeshAttribute& attribute = mesh.attributes.emplace_back();
        attribute.semantic = each.semantic;
        attribute.componentType = each.componentType;
        attribute.componentCount = each.componentCount;
        attribute.isNormalized = each.isNormalized;
        attribute.values.resize(attribute.bytesPerVertex() * vertexCount);
        if (read) read = readPart(reader, static_cast<std::uint32_t>(mesh.attributes.size()), attribute.values);
    }
    if (!read) return tl::make_unexpected(read.error().detail);
    if (!attributes.empty() && std::ranges::any_of(mesh.indices, [&](std::uint32_t index) { return index >= vertexCount; }))
        return tl::make_unexpected(reader.senseless().value().detail);
    return mesh;
}

tl::expected<DracoLattices, std::string> dracoLatticesInChild(std::span<const std::byte> bytes) {
    LC_TRY(stream, openStream(ForeignKind::DracoLattices, bytes, {}));
    WireReader& description = *stream->description;
    DracoLattices lattices;
    lattices.positionStep = description.get<double>();
    for (auto left = description.get<std::uint32_t>(); left > 0 && description.hasMore(); --left) {
        const int id = description.get<int>();
        lattices.bitsOfId[id] = description.get<int>();
    }
    if (!description.isWhole() || !(lattices.positionStep >= 0)) return tl::make_unexpected(stream->reader.senseless().value().detail);
    return lattices;
}

std::unique_ptr<ForeignDecoder> decodeDracoBehindWall(const ForeignInput& input) {
    return std::make_unique<DracoBehindWall>(input);
}
std::unique_ptr<ForeignDecoder> measureDracoBehindWall(const ForeignInput& input) {
    return std::make_unique<DracoLatticesBehindWall>(input);
}

}  // namespace lightcook::formats
