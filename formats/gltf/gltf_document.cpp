#include "formats/gltf/gltf_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <string_view>

#include "formats/file/file_bytes.h"
#include "formats/file/one_line.h"
#include "formats/gltf/node_placement.h"
#include "formats/json_structure.h"
#include "formats/read_file.h"

namespace lightcook::formats {
namespace {

constexpr std::uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;  // "glTF", "JSON", "BIN\0"
constexpr std::uint64_t kMostElements = std::uint64_t{1} << 28;
constexpr std::uint64_t kMostZeros = std::uint64_t{1} << 24;  // elements that no byte of the file stands for
/// Extensions of buffer views that hold their data compressed; the views themselves may have them uncompressed.
constexpr std::array<const char*, 2> kMeshoptExtensions = {"EXT_meshopt_compression", "KHR_meshopt_compression"};
constexpr std::size_t kMostBuffers = 1024;
constexpr std::size_t kDeepestJson = 256;    // real files stay below 20; writing JSON back recurses
constexpr std::size_t kDeepestNodes = 1024;  // the bones of a long chain are some hundred; engines recurse over them

int hexDigit(char c) {
    if ('0' <= c && c <= '9') return c - '0';
    if ('a' <= c && c <= 'f') return c - 'a' + 10;
    if ('A' <= c && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::string percentDecoded(std::string_view text) {
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%' && i + 2 < text.size() && hexDigit(text[i + 1]) >= 0 && hexDigit(text[i + 2]) >= 0) {
            decoded += static_cast<char>(16 * hexDigit(text[i + 1]) + hexDigit(text[i + 2]));
            i += 2;
        } else {
            decoded += text[i];
        }
    }
    return decoded;
}

int base64Digit(char c) {
    if ('A' <= c && c <= 'Z') return c - 'A';
    if ('a' <= c && c <= 'z') return c - 'a' + 26;
    if ('0' <= c && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;
    if (c == '/' || c == '_') return 63;
    return -1;
}

/// RFC 4648, both alphabets; false at a character that is neither a digit nor padding at the end.
bool decodeBase64(std::string_view text, std::vector<std::byte>& bytes) {
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    std::uint32_t bits = 0;
    int bitCount = 0;
    for (const char c : text) {
        const int digit = base64Digit(c);
        if (digit < 0) return false;
        bits = (bits << 6 | static_cast<std::uint32_t>(digit)) & 0xFFFFu;
        bitCount += 6;
        if (bitCount < 8) continue;
        bitCount -= 8;
        bytes.push_back(static_cast<std::byte>(bits >> bitCount & 0xFFu));
    }
    return true;
}

int componentCountOf(const std::string& type) {
    constexpr std::array<const char*, 4> kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    const auto found = std::find(kTypes.begin(), kTypes.end(), type);
    return found == kTypes.end() ? 0 : static_cast<int>(found - kTypes.begin()) + 1;
}

}  // namespace

GltfDocument::GltfDocument(const std::filesystem::path& file) : file_(file) {
    const auto bytes = readWholeFile(file);
    if (!bytes) throw GltfFault(bytes.error());
    fileBytes_ = bytes->size();
    read(*bytes);
}

GltfDocument::GltfDocument(const GltfDocument& source, std::span<const std::byte> glb)
    : file_(source.file_), fileBytes_(source.fileBytes_) {
    read(glb);
}

void GltfDocument::read(std::span<const std::byte> bytes) {
    parse(bytes);
    const Json asset = json_.is_object() && json_.contains("asset") ? json_["asset"] : Json();
    const std::string version = asset.is_object() ? asset.value("version", "") : "";
    if (!version.starts_with("2."))
        fail(ErrorCode::FormatUnsupported, "asset", fmt::format("found version \"{}\", expected 2.x", oneLine(version)));
    for (const char* name : kMeshoptExtensions) dropMeshopt(name);
    readBuffers();
}

/// Takes the uncompressed data of a document that has compressed data beside them, and refuses one without.
void GltfDocument::dropMeshopt(const char* name) {
    const auto failCompressed = [&](const std::string& place) {
        fail(
            ErrorCode::FormatUnsupported, place,
            fmt::format("found {}, expected plain or Draco geometry: `gltf-transform copy IN.glb OUT.glb` undoes it, and so does `gltfpack "
                        "-i IN.glb -o OUT.glb -noq -kn -km -kv`",
                        name));
    };
    const Json required = json_.value("extensionsRequired", Json::array());
    if (std::ranges::find(required, Json(name)) != required.end()) failCompressed("extensionsRequired");
    const auto drop = [&](Json& owner, const std::string& place) {
        const auto extensions = owner.find("extensions");
        if (extensions == owner.end() || !extensions->is_object() || !extensions->contains(name)) return;
        if (place.starts_with("buffer ") && !owner.contains("uri") && place != "buffer 0") failCompressed(place);
        extensions->erase(name);
        if (extensions->empty()) owner.erase("extensions");
    };
    for (const char* list : {"buffers", "bufferViews"}) {
        if (!json_.contains(list) || !json_[list].is_array()) continue;
        const std::string what = std::string(list).substr(0, std::string(list).size() - 1);
        for (std::size_t i = 0; i < json_[list].size(); ++i)
            if (json_[list][i].is_object()) drop(json_[list][i], fmt::format("{} {}", what, i));
    }
    const auto used = json_.find("extensionsUsed");
    if (used == json_.end() || !used->is_array()) return;
    std::erase(used->get_ref<Json::array_t&>(), Json(name));
    if (used->empty()) json_.erase("extensionsUsed");
}

void GltfDocument::fail(ErrorCode code, const std::string& place, const std::string& detail) const {
    throw GltfFault({code, Subject(file_).at(place), detail});
}

void GltfDocument::parse(std::span<const std::byte> bytes) {
    std::span<const std::byte> text = bytes;
    if (bytes.size() >= 12 && loadU32(bytes, 0) == kGlbMagic) {
        if (loadU32(bytes, 4) != 2)
            fail(ErrorCode::FormatUnsupported, "", fmt::format("found GLB version {}, expected 2", loadU32(bytes, 4)));
        if (loadU32(bytes, 8) > bytes.size()) {
            fail(ErrorCode::FileUnreadable, "",
                 fmt::format("found {} bytes, expected the {} of its header: truncated", bytes.size(), loadU32(bytes, 8)));
        }
        text = {};
        for (std::size_t at = 12; at + 8 <= loadU32(bytes, 8);) {
            const std::size_t length = loadU32(bytes, at);
            const std::uint32_t type = loadU32(bytes, at + 4);
            if (length > bytes.size() - at - 8) {
                fail(ErrorCode::FileUnreadable, "",
                     fmt::format("found a chunk of {} bytes, expected at most {}", length, bytes.size() - at - 8));
            }
            const auto content = bytes.subspan(at + 8, length);
            if (type == kJsonChunk && text.empty()) text = content;
            if (type == kBinaryChunk && glbBuffer_.empty()) glbBuffer_.assign(content.begin(), content.end());
            at += 8 + length;
        }
    }
    const auto* const first = reinterpret_cast<const char*>(text.data());
    // Bytes that are no text at all would be named by the first rule that they break.
    if (const std::size_t start = std::string_view(first, text.size()).find_first_not_of("\xEF\xBB\xBF \t\r\n");
        start == std::string_view::npos || first[start] != '{')
        fail(ErrorCode::FileUnreadable, "", "found no JSON object, expected a glTF 2.0 file");
    if (const auto fault = faultOfStructure({first, text.size()}, kDeepestJson))
        fail(ErrorCode::FileUnreadable, "", fmt::format("found {}, expected a glTF 2.0 file", *fault));
    json_ = Json::parse(first, first + text.size(), nullptr, false);
    if (!json_.is_object()) fail(ErrorCode::FileUnreadable, "", "found no JSON object, expected a glTF 2.0 file");
    if (const std::size_t depth = depthOfNodes(json_); depth > kDeepestNodes)
        fail(ErrorCode::FormatUnsupported, "", fmt::format("found nodes {} deep, expected at most {}", depth, kDeepestNodes));
}

Result<std::vector<std::byte>> GltfDocument::readBeside(const std::string& uri) const {
    if (const auto path = beside(uri)) return readWholeFile(*path);
    return failure(
        ErrorCode::FormatUnsupported, file_,
        fmt::format("found the file \"{}\", expected one in the folder of the glTF or below it: a glTF may come from anybody, and "
                    "names no other files. Copy it there, or pack all into one file: `gltf-transform copy IN.gltf OUT.glb`",
                    oneLine(uri)));
}

std::filesystem::path GltfDocument::pathOf(const std::string& uri) const {
    return file_.parent_path() / std::filesystem::path(percentDecoded(uri)).lexically_normal();
}

std::optional<std::filesystem::path> GltfDocument::beside(const std::string& uri) const {
    const std::filesystem::path path = std::filesystem::path(percentDecoded(uri)).lexically_normal();
    if (path.empty() || path.is_absolute() || *path.begin() == "..") return std::nullopt;
    return pathOf(uri);
}

GltfDocument GltfDocument::withoutBuffers(const std::filesystem::path& file) {
    GltfDocument document;
    document.file_ = file;
    const auto bytes = readWholeFile(file);
    if (!bytes) throw GltfFault(bytes.error());
    document.parse(*bytes);
    return document;
}

std::vector<std::filesystem::path> GltfDocument::filesBeside(std::span<const char* const> arrays) const {
    std::vector<std::filesystem::path> files;
    for (const char* array : arrays)
        for (const Json& entry : json_.value(array, Json::array())) {
            const std::string uri = entry.value("uri", "");
            if (uri.empty() || uri.starts_with("data:")) continue;
            const auto path = std::string_view(array) == "images" ? pathOf(uri) : beside(uri);
            std::error_code code;
            if (!path || !std::filesystem::is_regular_file(*path, code)) continue;
            if (std::find(files.begin(), files.end(), *path) == files.end()) files.push_back(*path);
        }
    return files;
}

std::vector<std::byte> GltfDocument::readUri(const std::string& uri, const std::string& place, const char* what) const {
    if (uri.starts_with("data:")) {
        const std::size_t comma = uri.find(',');
        std::vector<std::byte> bytes;
        if (comma == std::string::npos || !uri.substr(0, comma).ends_with(";base64") ||
            !decodeBase64(std::string_view(uri).substr(comma + 1), bytes)) {
            fail(ErrorCode::FileUnreadable, place, "found a data URI that is broken, expected base64");
        }
        return bytes;
    }
    auto bytes = readBeside(uri);
    if (!bytes && bytes.error().code != ErrorCode::FileUnreadable) fail(bytes.error().code, place, bytes.error().detail);
    if (!bytes) fail(ErrorCode::FileUnreadable, place, fmt::format("found no readable file \"{}\", expected {}", oneLine(uri), what));
    return std::move(*bytes);
}

void GltfDocument::readBuffers() {
    const Json buffers = json_.value("buffers", Json::array());
    if (buffers.size() > kMostBuffers)
        fail(ErrorCode::WrongShape, "buffers", fmt::format("found {} buffers, expected at most {}", buffers.size(), kMostBuffers));
    std::map<std::filesystem::path, SharedBytes> read;  // several buffers may be of one file
    for (std::size_t index = 0; index < buffers.size(); ++index) {
        const std::string place = fmt::format("buffer {}", index);
        const std::uint64_t byteLength = number(buffers[index], "byteLength", 0, place);
        SharedBytes bytes;
        if (buffers[index].contains("uri")) {
            const std::string uri = buffers[index]["uri"].get<std::string>();
            const auto file = uri.starts_with("data:") ? std::nullopt : beside(uri);
            if (file) bytes = read[*file];
            if (bytes == nullptr) {
                bytes = std::make_shared<std::vector<std::byte>>(readUri(uri, place, "the buffer"));
                if (file) {
                    read[*file] = bytes;
                    fileBytes_ += bytes->size();
                }
            }
        } else if (index == 0 && !glbBuffer_.empty()) {
            bytes = std::make_shared<std::vector<std::byte>>(std::move(glbBuffer_));
        } else {
            fail(ErrorCode::FileUnreadable, place, "found neither a uri nor a GLB chunk, expected one of them");
        }
        if (bytes->size() < byteLength) {
            fail(ErrorCode::FileUnreadable, place, fmt::format("found {} bytes, expected {}", bytes->size(), byteLength));
        }
        buffers_.push_back({std::move(bytes), byteLength});
    }
}

std::uint64_t GltfDocument::addBuffer(std::vector<std::byte> bytes) {
    json_["buffers"].push_back({{"byteLength", bytes.size()}});
    const std::size_t size = bytes.size();
    buffers_.push_back({std::make_shared<std::vector<std::byte>>(std::move(bytes)), size});
    return buffers_.size() - 1;
}

const Json& GltfDocument::array(const char* key) const {
    static const Json kEmpty = Json::array();
    const auto found = json_.find(key);
    if (found == json_.end()) return kEmpty;
    if (!found->is_array()) fail(ErrorCode::WrongShape, key, "found no JSON array, expected one");
    return *found;
}

const Json& GltfDocument::entry(const char* key, std::uint64_t index) const {
    const Json& entries = array(key);
    if (index >= entries.size())
        fail(ErrorCode::WrongShape, key, fmt::format("found a reference to entry {}, expected less than {}", index, entries.size()));
    const Json& result = entries[index];
    if (!result.is_object()) fail(ErrorCode::WrongShape, fmt::format("{}, entry {}", key, index), "found no JSON object, expected one");
    return result;
}

std::uint64_t GltfDocument::number(const Json& object, const char* key, std::uint64_t fallback, const std::string& place) const {
    if (!object.is_object()) fail(ErrorCode::WrongShape, place, "found no JSON object, expected one");
    const auto found = object.find(key);
    if (found == object.end()) return fallback;
    if (!found->is_number_unsigned()) {
        fail(ErrorCode::WrongShape, place, fmt::format("found {} = {}, expected a whole number from 0", key, oneLine(found->dump())));
    }
    return found->get<std::uint64_t>();
}

std::span<const std::byte> GltfDocument::bufferView(std::uint64_t index) const {
    const Json& view = entry("bufferViews", index);
    const std::string place = fmt::format("bufferView {}", index);
    const std::uint64_t buffer = number(view, "buffer", 0, place);
    if (buffer >= buffers_.size())
        fail(ErrorCode::WrongShape, place, fmt::format("found buffer {}, expected less than {}", buffer, buffers_.size()));
    const std::uint64_t offset = number(view, "byteOffset", 0, place), length = number(view, "byteLength", 0, place),
                        size = buffers_[buffer].length;
    if (offset > size || length > size - offset) {
        fail(ErrorCode::WrongShape, place,
             fmt::format("found bytes {} + {}, expected them within the {} of buffer {}", offset, length, size, buffer));
    }
    return std::span(*buffers_[buffer].bytes).subspan(offset, length);
}

std::vector<std::byte> GltfDocument::imageBytes(std::uint64_t index) const {
    const Json& image = entry("images", index);
    const std::string place = fmt::format("image {}", index);
    if (image.contains("bufferView")) {
        const auto bytes = bufferView(number(image, "bufferView", 0, place));
        return {bytes.begin(), bytes.end()};
    }
    if (!image.contains("uri")) fail(ErrorCode::WrongShape, place, "found neither a uri nor a bufferView, expected one of them");
    return readUri(image["uri"].get<std::string>(), place, "the image");
}

/// The bytes of a view from `offset` on, if `count` elements fit.
std::span<const std::byte> GltfDocument::part(std::uint64_t view, std::uint64_t offset, std::uint64_t count, std::uint64_t stride,
                                              std::uint64_t elementBytes, const std::string& place) const {
    const auto bytes = bufferView(view);
    const std::uint64_t room = bytes.size() - std::min<std::uint64_t>(offset, bytes.size());
    // count and stride are below 2^28 and 2^16 here: no overflow.
    if (count > 0 && (count - 1) * stride + elementBytes > room) {
        fail(ErrorCode::WrongShape, place,
             fmt::format("found {} elements of {} bytes, expected them within the {} bytes left in bufferView {}", count, elementBytes,
                         room, view));
    }
    return bytes.subspan(bytes.size() - room);
}

MeshAttribute GltfDocument::accessorType(std::uint64_t accessor, const std::string& semantic) const {
    const Json& json = entry("accessors", accessor);
    const std::string place = fmt::format("accessor {} ({})", accessor, semantic);
    MeshAttribute result;
    result.semantic = semantic;
    result.componentType = static_cast<ComponentType>(number(json, "componentType", 0, place));
    const std::string type = json.value("type", "");
    result.componentCount = componentCountOf(type);
    result.isNormalized = json.value("normalized", false);
    if (componentBytes(result.componentType) == 0 || result.componentCount == 0) {
        fail(ErrorCode::WrongShape, place,
             fmt::format("found component type {} and type \"{}\", expected those of vertices or indices",
                         static_cast<int>(result.componentType), oneLine(type)));
    }
    return result;
}

MeshAttribute GltfDocument::readAccessor(std::uint64_t accessor, const std::string& semantic) const {
    const std::string place = fmt::format("accessor {} ({})", accessor, semantic);
    MeshAttribute result = accessorType(accessor, semantic);
    const Json& json = entry("accessors", accessor);
    const std::uint64_t count = number(json, "count", 0, place);
    if (count < 1 || count > kMostElements)
        fail(ErrorCode::WrongShape, place, fmt::format("found {} elements, expected 1 to {}", count, kMostElements));
    const std::size_t elementBytes = result.bytesPerVertex();
    if (json.contains("bufferView")) {
        const std::uint64_t view = number(json, "bufferView", 0, place);
        const std::uint64_t stride = number(entry("bufferViews", view), "byteStride", elementBytes, fmt::format("bufferView {}", view));
        if (stride < elementBytes || stride > 0xFFFF)
            fail(ErrorCode::WrongShape, place, fmt::format("found a stride of {} bytes, expected at least {}", stride, elementBytes));
        const auto bytes = part(view, number(json, "byteOffset", 0, place), count, stride, elementBytes, place);
        result.values.resize(count * elementBytes);
        for (std::uint64_t i = 0; i < count; ++i)
            std::memcpy(result.values.data() + i * elementBytes, bytes.data() + i * stride, elementBytes);
    } else if (json.contains("sparse")) {
        if (count > kMostZeros)
            fail(ErrorCode::WrongShape, place,
                 fmt::format("found {} elements without a bufferView, expected at most {} zeros", count, kMostZeros));
        result.values.resize(count * elementBytes);  // zeros, says the specification
    } else {
        fail(ErrorCode::WrongShape, place, "found no bufferView, expected one");
    }
    if (json.contains("sparse")) applySparse(json["sparse"], result, place);
    return result;
}

void GltfDocument::applySparse(const Json& sparse, MeshAttribute& elements, const std::string& place) const {
    const std::uint64_t count = number(sparse, "count", 0, place);
    if (count > elements.vertexCount())
        fail(ErrorCode::WrongShape, place, fmt::format("found {} sparse elements, expected at most {}", count, elements.vertexCount()));
    const Json indices = sparse.value("indices", Json::object()), values = sparse.value("values", Json::object());
    MeshAttribute positions;
    positions.componentType = static_cast<ComponentType>(number(indices, "componentType", 0, place));
    positions.componentCount = 1;
    const std::size_t indexBytes = componentBytes(positions.componentType), valueBytes = elements.bytesPerVertex();
    if (indexBytes == 0) fail(ErrorCode::WrongShape, place, "found sparse indices of no known type, expected whole numbers");
    const auto from =
        part(number(indices, "bufferView", 0, place), number(indices, "byteOffset", 0, place), count, indexBytes, indexBytes, place);
    const auto with =
        part(number(values, "bufferView", 0, place), number(values, "byteOffset", 0, place), count, valueBytes, valueBytes, place);
    positions.values.assign(from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count * indexBytes));
    for (std::uint64_t i = 0; i < count; ++i) {
        const double target = positions.at(i).x;
        if (!(target >= 0 && target < static_cast<double>(elements.vertexCount()))) {
            fail(ErrorCode::WrongShape, place, fmt::format("found sparse index {}, expected less than {}", target, elements.vertexCount()));
        }
        std::memcpy(elements.values.data() + static_cast<std::size_t>(target) * valueBytes, with.data() + i * valueBytes, valueBytes);
    }
}

Error notGltf(const std::filesystem::path& file, const nlohmann::json::exception& exception) {
    return {ErrorCode::WrongShape, file, fmt::format("found JSON of another shape (\"{}\"), expected glTF 2.0", oneLine(exception.what()))};
}

Result<void> checkGlbSize(std::uint64_t bytes, const std::filesystem::path& file) {
    if (bytes <= std::numeric_limits<std::uint32_t>::max()) return {};
    return failure(ErrorCode::WrongShape, file, fmt::format("found {} bytes, expected less than 4 GiB in a GLB", bytes));
}

std::vector<std::byte> assembleGlb(const Json& json, std::span<const std::byte> buffer) {
    std::string text = json.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t binaryBytes = (buffer.size() + 3) / 4 * 4;
    std::vector<std::byte> glb;
    const auto append = [&glb](std::span<const std::byte> bytes) { glb.insert(glb.end(), bytes.begin(), bytes.end()); };
    appendU32(glb, kGlbMagic);
    appendU32(glb, 2);
    appendU32(glb, static_cast<std::uint32_t>(12 + 8 + text.size() + (buffer.empty() ? 0 : 8 + binaryBytes)));
    appendU32(glb, static_cast<std::uint32_t>(text.size()));
    appendU32(glb, kJsonChunk);
    append(std::as_bytes(std::span(text)));
    if (buffer.empty()) return glb;
    appendU32(glb, static_cast<std::uint32_t>(binaryBytes));
    appendU32(glb, kBinaryChunk);
    append(buffer);
    glb.resize(glb.size() + binaryBytes - buffer.size());
    return glb;
}

}  // namespace lightcook::formats
