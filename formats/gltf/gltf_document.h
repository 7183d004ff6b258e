// A glTF file as its JSON and its buffers. The structure is checked where it is read. JSON that is not geometry is kept as it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/gltf/triangle_mesh.h"

namespace lightcook::formats {

/// Keeps the order of keys, so that a scene written back differs only where it must.
using Json = nlohmann::ordered_json;

/// Thrown by the checks of the structure of a document; GltfScene turns it into a Result.
struct GltfFault : std::exception {
    Error error;

    explicit GltfFault(Error what) : error(std::move(what)) {}
    const char* what() const noexcept override { return error.detail.c_str(); }
};

class GltfDocument {
public:
    /// Throws GltfFault.
    explicit GltfDocument(const std::filesystem::path& file);
    /// Reads a GLB in memory that was made of `source`: paths, those in errors too, are relative to the same file. Throws GltfFault.
    GltfDocument(const GltfDocument& source, std::span<const std::byte> glb);
    /// Reads the JSON alone; throws GltfFault.
    static GltfDocument withoutBuffers(const std::filesystem::path& file);
    /// See gltfFilesBeside; throws GltfFault.
    /// arrays  of the document whose entries' files are meant: "buffers", "images"
    std::vector<std::filesystem::path> filesBeside(std::span<const char* const> arrays) const;

    const Json& json() const { return json_; }
    /// Returns the JSON to be changed in memory. Whoever changes it reads the document anew.
    Json& changedJson() { return json_; }
    /// Adds a buffer in memory, and returns its index.
    std::uint64_t addBuffer(std::vector<std::byte> bytes);
    const std::filesystem::path& file() const { return file_; }
    /// Returns the size of the file and of the buffers beside it; for a document in memory, that of its source.
    std::size_t fileBytes() const { return fileBytes_; }

    [[noreturn]] void fail(ErrorCode code, const std::string& place, const std::string& detail) const;
    /// Returns a top-level array such as "accessors"; an empty one if the document has none.
    const Json& array(const char* key) const;
    /// Returns entry `index` of such an array.
    const Json& entry(const char* key, std::uint64_t index) const;
    /// Returns a member that is a whole number from 0; `fallback` if it is absent.
    std::uint64_t number(const Json& object, const char* key, std::uint64_t fallback, const std::string& place) const;

    std::span<const std::byte> bufferView(std::uint64_t index) const;
    /// Returns the encoded bytes of an entry of "images": of a buffer view, a data URI or a file.
    std::vector<std::byte> imageBytes(std::uint64_t index) const;
    /// Reads the file that a uri names.
    Result<std::vector<std::byte>> readBeside(const std::string& uri) const;
    /// Returns the path of the file that a uri names.
    std::filesystem::path pathOf(const std::string& uri) const;
    /// Returns the same; nothing if it lies outside the folder of the document. The user wrote the path of the document, but somebody else
    /// may have written what is in it: "/etc/passwd" as a buffer. Pictures of materials may lie elsewhere, as exporters leave them: what
    /// begins as no picture is not taken.
    std::optional<std::filesystem::path> beside(const std::string& uri) const;
    /// Returns the component type and count that the accessor declares, without values.
    MeshAttribute accessorType(std::uint64_t accessor, const std::string& semantic) const;
    /// Returns the elements of an accessor, packed, with sparse elements applied. Errors name the use of the accessor by `semantic`.
    MeshAttribute readAccessor(std::uint64_t accessor, const std::string& semantic) const;

private:
    GltfDocument() = default;
    void read(std::span<const std::byte> bytes);
    void parse(std::span<const std::byte> bytes);
    void dropMeshopt(const char* name);
    void readBuffers();
    /// what  for errors: "the buffer"
    std::vector<std::byte> readUri(const std::string& uri, const std::string& place, const char* what) const;
    void applySparse(const Json& sparse, MeshAttribute& elements, const std::string& place) const;
    std::span<const std::byte> part(std::uint64_t view, std::uint64_t offset, std::uint64_t count, std::uint64_t stride,
                                    std::uint64_t elementBytes, const std::string& place) const;

    std::filesystem::path file_;
    std::size_t fileBytes_ = 0;
    Json json_;
    std::vector<std::byte> glbBuffer_;
    using SharedBytes = std::shared_ptr<const std::vector<std::byte>>;
    struct Buffer {
        SharedBytes bytes;
        std::uint64_t length = 0;  ///< of its first bytes
    };
    std::vector<Buffer> buffers_;
};

/// Returns the error for JSON whose members have other types than glTF gives them.
Error notGltf(const std::filesystem::path& file, const nlohmann::json::exception& exception);

/// Returns what work() returns, or the error that it throws: GltfFault, or that of JSON of another shape.
/// file  for errors
template <class Work>
auto resultOf(const std::filesystem::path& file, Work work) -> Result<decltype(work())> {
    try {
        return work();
    } catch (const GltfFault& fault) {
        return tl::make_unexpected(fault.error);
    } catch (const nlohmann::json::exception& exception) {
        return tl::make_unexpected(notGltf(file, exception));
    }
}

/// Calls visit(integer) for every "bufferView" member below `json`, also in extensions of any name. Skips "extras", which belong to the
/// user, and the list of buffer views itself.
template <class JsonOrConst, class Visit>
void visitBufferViews(JsonOrConst& json, Visit visit) {
    if (json.is_object()) {
        for (auto& [key, value] : json.items()) {
            if (key == "extras" || key == "bufferViews") continue;
            if (key == "bufferView" && value.is_number_integer()) {
                visit(value);
            } else {
                visitBufferViews(value, visit);
            }
        }
    } else if (json.is_array()) {
        for (auto& value : json) visitBufferViews(value, visit);
    }
}

/// Fails for a GLB whose size does not fit the 32 bits that its header has for it.
/// file  for the error
Result<void> checkGlbSize(std::uint64_t bytes, const std::filesystem::path& file);

/// Returns the bytes of a GLB file with one buffer. checkGlbSize() says whether they are one.
std::vector<std::byte> assembleGlb(const Json& json, std::span<const std::byte> buffer);

}  // namespace lightcook::formats
