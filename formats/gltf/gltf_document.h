// A glTF file as its JSON and its buffers, checked where it is read, and written back as a GLB. What the JSON says beyond geometry is
// carried along untouched.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/gltf/triangle_mesh.h"

namespace lightcook::formats {

/// Keeps the order of keys, so that writing back changes nothing that was not meant.
using Json = nlohmann::ordered_json;

/// How the many checks of a document's structure leave it; GltfScene turns them into a Result.
struct GltfFault : std::exception {
    Error error;

    explicit GltfFault(Error what) : error(std::move(what)) {}
    const char* what() const noexcept override { return error.detail.c_str(); }
};

class GltfDocument {
public:
    /// Throws GltfFault.
    explicit GltfDocument(const std::filesystem::path& file);
    /// See gltfFilesBeside; throws GltfFault.
    /// arrays  of the document whose entries' files are meant: "buffers", "images"
    static std::vector<std::filesystem::path> filesBeside(const std::filesystem::path& file, std::span<const char* const> arrays);

    const Json& json() const { return json_; }
    const std::filesystem::path& file() const { return file_; }
    std::size_t fileBytes() const { return fileBytes_; }  ///< of the file and of the buffers beside it

    [[noreturn]] void fail(ErrorCode code, const std::string& place, const std::string& detail) const;
    /// Entry `index` of a top-level array such as "accessors".
    const Json& entry(const char* array, std::uint64_t index) const;
    /// A member that is a whole number from 0; `fallback` where it is absent.
    std::uint64_t number(const Json& object, const char* key, std::uint64_t fallback, const std::string& place) const;

    std::span<const std::byte> bufferView(std::uint64_t index) const;
    /// The file that a relative uri names.
    Result<std::vector<std::byte>> readBeside(const std::string& uri) const;
    std::filesystem::path beside(const std::string& uri) const;
    /// Component type and count as the accessor declares them, without values.
    MeshAttribute accessorType(std::uint64_t accessor, const std::string& semantic) const;
    /// The elements of an accessor, sparse ones applied, packed; `semantic` also tells its use in errors.
    MeshAttribute readAccessor(std::uint64_t accessor, const std::string& semantic) const;

private:
    GltfDocument() = default;
    void parse(std::span<const std::byte> bytes);
    void readBuffers();
    std::vector<std::byte> readUri(const std::string& uri, const std::string& place);
    void applySparse(const Json& sparse, MeshAttribute& elements, const std::string& place) const;
    std::span<const std::byte> part(std::uint64_t view, std::uint64_t offset, std::uint64_t count, std::uint64_t stride,
                                    std::uint64_t elementBytes, const std::string& place) const;

    std::filesystem::path file_;
    std::size_t fileBytes_ = 0;
    Json json_;
    std::vector<std::byte> glbBuffer_;
    std::vector<std::vector<std::byte>> buffers_;
};

/// Calls visit(integer) for every "bufferView" member below `json`, extensions of any name included; "extras" are the user's own.
/// The list of buffer views itself is not a reference.
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

/// The bytes of a GLB file with one buffer.
std::vector<std::byte> assembleGlb(const Json& json, std::span<const std::byte> buffer);
/// The whole file, if it is there.
Result<std::vector<std::byte>> readWholeFile(const std::filesystem::path& file);

}  // namespace lightcook::formats
