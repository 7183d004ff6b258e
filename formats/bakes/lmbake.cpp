// Reads a binary resource of Godot 4 as far as it says where meshes lie. All numbers are little-endian unless the header says otherwise:
//
//   "RSRC"  u32 big-endian, u32 -, u32 major and minor version of the engine, u32 version of the format
//           string class; u64 -; u32 flags; u64 -; string of a script class if flag 8; 11 x u32 -
//           u32 n, n strings: the string table; u32 n, n x (string class, string path, u64 if flag 2): files that it refers to
//           u32 n, n x (string path, u64 offset): resources inside, of which the last is the file's own
//   at its offset: string class; u32 n, n x (name, value)
//   string  u32 length with the final zero, bytes in UTF-8
//   name    u32 index in the string table; or with bit 31 a string
//   value   u32 type and what the type has; a node path has u16 names, u16 subnames (bit 15: absolute), and these names
//
//   "RSCC"  u32 method (2: Zstandard), u32 block size, u32 total size, the compressed sizes of total / block + 1 blocks, the blocks:
//           what follows the four letters of "RSRC"
//
// The property user_data is a list of four values a mesh: node path, rectangle, slice, number of a mesh of the node or -1.
// Properties that have their default, false, are left out.
// Source: godotengine/godot, core/io/resource_format_binary.cpp, core/io/file_access_compressed.cpp, scene/3d/lightmap_gi.cpp.
#include "formats/lmbake.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include "formats/bake_format.h"
#include "formats/bakes/godot.h"
#include "formats/container/zstd_stream.h"
#include "formats/file/file_bytes.h"
#include "formats/file/one_line.h"
#include "formats/light_map.h"
#include "formats/lower_extension.h"
#include "formats/vocabulary.h"

namespace lightcook::formats {
namespace {

constexpr std::string_view kResourceClass = "LightmapGIData", kUserData = "user_data";
constexpr std::string_view kDirectionalProperty = "uses_spherical_harmonics", kPackedProperty = "_uses_packed_directional";
/// Largest size of the resource, and of all node paths together. Probes take 200 bytes each, meshes less.
constexpr std::uint64_t kMostResourceBytes = std::uint64_t{64} << 20;
/// Godot's block size is 4096. Each block costs a call of the decoder.
constexpr std::uint32_t kLeastBlockBytes = 1024, kMostBlockBytes = 1u << 24;
constexpr std::uint32_t kZstdMethod = 2;
constexpr std::uint32_t kNewestFormat = 6;
/// Minor version of Godot 4 that packs directions. It may have saved an older bake again, of which the values tell.
constexpr std::uint32_t kFirstThatPacks = 4;
/// Lists within lists, as deep as no resource of Godot has them.
constexpr int kDeepestList = 32;
/// Layers of an array texture that a device may have, at most.
constexpr int kMostSlices = 2048;
/// Overhang of a rectangle over its slice that rounding explains.
constexpr double kSliceTolerance = 1e-4;

/// Thrown where a file is damaged; readLmbake() turns it into a Result.
struct ResourceDamage {
    ErrorCode code;
    std::string place, detail;
};

/// Numbers of the types of values.
enum class ValueType : std::uint32_t {
    Nil = 1,
    Bool = 2,
    Int = 3,
    Float = 4,
    String = 5,
    Vector2 = 10,
    Rect2 = 11,
    Vector3 = 12,
    Plane = 13,
    Quaternion = 14,
    Box = 15,
    Basis = 16,
    Transform = 17,
    Transform2 = 18,
    Color = 20,
    NodePath = 22,
    Rid = 23,
    Object = 24,
    Dictionary = 26,
    Array = 30,
    Bytes = 31,
    Ints = 32,
    Floats = 33,
    Strings = 34,
    Vector3s = 35,
    Colors = 36,
    Vector2s = 37,
    Int64 = 40,
    Double = 41,
    Callable = 42,
    Signal = 43,
    StringName = 44,
    IntVector2 = 45,
    IntRect2 = 46,
    IntVector3 = 47,
    Int64s = 48,
    Doubles = 49,
    Vector4 = 50,
    IntVector4 = 51,
    Projection = 52,
    Vector4s = 53
};

/// A type whose values are numbers of a fixed count, or lists of elements that are.
struct NumberType {
    ValueType type;
    int bytes = 0;  ///< fixed ones
    int reals = 0;  ///< of 4 bytes, or of 8 if the file says so
    bool isList = false;
};
constexpr std::array kNumberTypes = {
    NumberType{ValueType::Nil},
    NumberType{ValueType::Bool, 4},
    NumberType{ValueType::Int, 4},
    NumberType{ValueType::Float, 0, 1},
    NumberType{ValueType::Vector2, 0, 2},
    NumberType{ValueType::Rect2, 0, 4},
    NumberType{ValueType::Vector3, 0, 3},
    NumberType{ValueType::Plane, 0, 4},
    NumberType{ValueType::Quaternion, 0, 4},
    NumberType{ValueType::Box, 0, 6},
    NumberType{ValueType::Basis, 0, 9},
    NumberType{ValueType::Transform, 0, 12},
    NumberType{ValueType::Transform2, 0, 6},
    NumberType{ValueType::Color, 16},
    NumberType{ValueType::Rid, 4},
    NumberType{ValueType::Ints, 4, 0, true},
    NumberType{ValueType::Floats, 4, 0, true},
    NumberType{ValueType::Vector3s, 0, 3, true},
    NumberType{ValueType::Colors, 16, 0, true},
    NumberType{ValueType::Vector2s, 0, 2, true},
    NumberType{ValueType::Int64, 8},
    NumberType{ValueType::Double, 8},
    NumberType{ValueType::Callable},
    NumberType{ValueType::Signal},
    NumberType{ValueType::IntVector2, 8},
    NumberType{ValueType::IntRect2, 16},
    NumberType{ValueType::IntVector3, 12},
    NumberType{ValueType::Int64s, 8, 0, true},
    NumberType{ValueType::Doubles, 8, 0, true},
    NumberType{ValueType::Vector4, 0, 4},
    NumberType{ValueType::IntVector4, 16},
    NumberType{ValueType::Projection, 0, 16},
    NumberType{ValueType::Vector4s, 0, 4, true},
};

/// Reads the bytes of a resource in order.
class ResourceReader {
public:
    explicit ResourceReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    /// start  of the header: behind the letters "RSRC", if the bytes have them
    Lmbake read(std::size_t start) {
        at_ = start;
        readHeader();
        (void)text();
        Lmbake found;
        bool hasUsers = false;
        for (std::uint32_t left = u32(); left > 0; --left) {
            const std::string_view property = name();
            if (property == kUserData) {
                found.users = readUsers();
                hasUsers = true;
            } else if (property == kDirectionalProperty || property == kPackedProperty) {
                (property == kPackedProperty ? found.isPacked : found.isDirectional) = readBool(std::string(property));
            } else {
                skipValue(0);
            }
        }
        if (!hasUsers) fail("", fmt::format("found no property {}, expected that of a bake", kUserData));
        found.isPacked = found.isPacked || engineMinor_ >= kFirstThatPacks;
        return found;
    }

private:
    [[noreturn]] static void fail(std::string place, std::string detail, ErrorCode code = ErrorCode::FileUnreadable) {
        throw ResourceDamage{code, std::move(place), std::move(detail)};
    }

    void readHeader() {
        isBigEndian_ = u32() != 0;
        (void)u32();
        const std::uint32_t major = u32();
        engineMinor_ = u32();
        const std::uint32_t format = u32();
        const std::string found = oneLine(text());
        if (found != kResourceClass)
            fail("", fmt::format("found a resource of class \"{}\" (Godot {}), expected {} of Godot 4", found, major, kResourceClass),
                 ErrorCode::FormatUnsupported);
        if (format > kNewestFormat || format < 3)
            fail("", fmt::format("found format {} of Godot's resources, expected 3 to {}", format, kNewestFormat),
                 ErrorCode::FormatUnsupported);
        (void)u64();
        const std::uint32_t flags = u32();
        constexpr std::uint32_t kUids = 2, kDoubles = 4, kScriptClass = 8;
        realBytes_ = (flags & kDoubles) != 0 ? 8 : 4;
        (void)u64();
        if ((flags & kScriptClass) != 0) (void)text();
        constexpr std::size_t kReserved = 11;
        take(4 * kReserved);
        const std::uint32_t names = u32();
        for (std::uint32_t i = 0; i < names; ++i) names_.push_back(text());
        const std::uint32_t outside = u32();
        for (std::uint32_t i = 0; i < outside; ++i) {
            (void)text();
            (void)text();
            if ((flags & kUids) != 0) (void)u64();
        }
        const std::uint32_t inside = u32();
        std::optional<std::uint64_t> own;
        for (std::uint32_t i = 0; i < inside; ++i) {
            (void)text();
            own = u64();
        }
        if (!own) fail("", "found no resource inside, expected one");
        if (*own >= bytes_.size()) fail("", fmt::format("found the resource at byte {}, expected it below {}", *own, bytes_.size()));
        at_ = static_cast<std::size_t>(*own);
    }

    bool readBool(std::string place) {
        if (type() != ValueType::Bool) fail(std::move(place), "found another value, expected true or false");
        return u32() != 0;
    }

    std::vector<LmbakeUser> readUsers() {
        if (type() != ValueType::Array) fail(std::string(kUserData), "found no list, expected one");
        constexpr std::uint32_t kShared = 0x80000000, kValues = 4;
        const std::uint32_t count = u32() & ~kShared;
        if (count % kValues != 0) fail(std::string(kUserData), fmt::format("found {} values, expected {} for each mesh", count, kValues));
        std::vector<LmbakeUser> users;
        for (std::uint32_t i = 0; i < count / kValues; ++i) users.push_back(readUser(fmt::format("mesh {}", i)));
        return users;
    }

    LmbakeUser readUser(const std::string& place) {
        const auto expect = [&](ValueType expected, const char* what) {
            if (const ValueType found = type(); found != expected)
                fail(place, fmt::format("found a value of type {}, expected {}", static_cast<std::uint32_t>(found), what));
        };
        LmbakeUser user;
        expect(ValueType::NodePath, "a node path");
        user.path = nodePath();
        if (user.path.empty()) fail(place, "found an empty node path, expected a node");
        expect(ValueType::Rect2, "a rectangle");
        for (int i = 0; i < 4; ++i) user.rectangle[i] = real();
        expect(ValueType::Int, "a slice");
        user.slice = static_cast<std::int32_t>(u32());
        expect(ValueType::Int, "the number of a mesh");
        user.subInstance = static_cast<std::int32_t>(u32());
        const glm::dvec4& at = user.rectangle;
        for (int axis = 0; axis < 2; ++axis)
            if (!(at[axis] >= -kSliceTolerance && at[axis + 2] > 0 && at[axis] + at[axis + 2] <= 1 + kSliceTolerance))
                fail(fmt::format("{} '{}'", place, oneLine(user.name())),
                     fmt::format("found a rectangle at ({}, {}) of {} x {}, expected a part of the slice, within [0, 1]", at.x, at.y, at.z,
                                 at.w));
        if (user.slice < 0 || user.slice >= kMostSlices)
            fail(fmt::format("{} '{}'", place, oneLine(user.name())),
                 fmt::format("found slice {}, expected 0 to {}", user.slice, kMostSlices - 1));
        return user;
    }

    std::vector<std::string> nodePath() {
        const std::uint16_t nameCount = u16();
        const std::uint16_t subnames = u16() & 0x7FFF;
        std::vector<std::string> path;
        for (int i = 0; i < nameCount; ++i) {
            path.emplace_back(name());
            // A name may be that of a long string, which the file holds once.
            pathBytes_ += sizeof(std::string) + path.back().size();
            if (pathBytes_ > kMostResourceBytes)
                fail("", fmt::format("found node paths of more than {} bytes, expected less", kMostResourceBytes));
        }
        for (int i = 0; i < subnames; ++i) (void)name();
        return path;
    }

    void skipValue(int depth) {
        if (depth > kDeepestList) fail("", fmt::format("found lists {} deep, expected at most {}", depth, kDeepestList));
        const ValueType found = type();
        const auto row = std::ranges::find(kNumberTypes, found, &NumberType::type);
        if (row != kNumberTypes.end()) {
            const std::uint64_t count = row->isList ? u32() : 1;
            return take(count * static_cast<std::uint64_t>(row->bytes + row->reals * realBytes_));
        }
        constexpr std::uint32_t kShared = 0x80000000;
        switch (found) {
            case ValueType::String:
            case ValueType::StringName:
                (void)text();
                return;
            case ValueType::NodePath:
                (void)nodePath();
                return;
            case ValueType::Object:
                return skipObject();
            case ValueType::Dictionary:
                for (std::uint64_t left = 2 * std::uint64_t{u32() & ~kShared}; left > 0; --left) skipValue(depth + 1);
                return;
            case ValueType::Array:
                for (std::uint32_t left = u32() & ~kShared; left > 0; --left) skipValue(depth + 1);
                return;
            case ValueType::Bytes:
                return take((std::uint64_t{u32()} + 3) / 4 * 4);
            case ValueType::Strings:
                for (std::uint32_t left = u32(); left > 0; --left) (void)text();
                return;
            default:
                fail(fmt::format("byte {}", at_ - 4),
                     fmt::format("found a value of type {}, expected one of Godot's", static_cast<std::uint32_t>(found)));
        }
    }

    void skipObject() {
        constexpr std::uint32_t kEmpty = 0, kByPath = 1, kInside = 2, kOutside = 3;
        const std::uint32_t kind = u32();
        if (kind == kByPath) {
            (void)text();
            (void)text();
        } else if (kind == kInside || kind == kOutside) {
            (void)u32();
        } else if (kind != kEmpty) {
            fail(fmt::format("byte {}", at_ - 4), fmt::format("found a reference of kind {}, expected 0 to 3", kind));
        }
    }

    std::string_view name() {
        constexpr std::uint32_t kInline = 0x80000000;
        const std::uint32_t index = u32();
        if ((index & kInline) != 0) return text(index & ~kInline);
        if (index >= names_.size()) fail("", fmt::format("found name {}, expected less than {}", index, names_.size()));
        return names_[index];
    }

    ValueType type() { return static_cast<ValueType>(u32()); }
    std::string_view text() { return text(u32()); }
    /// length  with the final zero
    std::string_view text(std::uint32_t length) {
        const std::size_t first = at_;
        take(length);
        const auto* const characters = reinterpret_cast<const char*>(bytes_.data() + first);
        return {characters, std::find(characters, characters + length, '\0')};
    }

    double real() { return realBytes_ == 8 ? std::bit_cast<double>(u64()) : std::bit_cast<float>(u32()); }
    std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
    std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
    std::uint64_t u64() { return number(8); }
    std::uint64_t number(std::size_t bytes) {
        const std::size_t first = at_;
        take(bytes);
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < bytes; ++i)
            value = value << 8 | std::to_integer<std::uint64_t>(bytes_[first + (isBigEndian_ ? i : bytes - 1 - i)]);
        return value;
    }
    void take(std::uint64_t bytes) {
        if (bytes > bytes_.size() - at_)
            fail(fmt::format("byte {}", at_),
                 fmt::format("found {} bytes up to the end, expected {}: truncated", bytes_.size() - at_, bytes));
        at_ += static_cast<std::size_t>(bytes);
    }

    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
    bool isBigEndian_ = false;
    int realBytes_ = 4;
    std::uint32_t engineMinor_ = 0;        ///< of Godot 4
    std::vector<std::string_view> names_;  ///< the string table
    std::uint64_t pathBytes_ = 0;
};

/// Decompresses a file that begins with "RSCC".
Result<std::vector<std::byte>> decompressedResource(const FileBytes& file) {
    const Subject subject(file.path());
    const auto damaged = [&](std::string detail) { return failure(ErrorCode::FileUnreadable, subject, std::move(detail)); };
    constexpr std::uint64_t kHeader = 16;
    if (file.size() < kHeader) return damaged(fmt::format("found {} bytes, expected the {} of a header", file.size(), kHeader));
    std::vector<std::byte> header(kHeader);
    LC_CHECK(file.readAt(0, header));
    const std::uint32_t method = loadU32(header, 4), block = loadU32(header, 8), total = loadU32(header, 12);
    if (method != kZstdMethod)
        return failure(ErrorCode::FormatUnsupported, subject,
                       fmt::format("found compression {} of Godot, expected 2 (Zstandard) or none: save it without compression", method));
    if (block < kLeastBlockBytes || block > kMostBlockBytes)
        return damaged(fmt::format("found blocks of {} bytes, expected {} to {}", block, kLeastBlockBytes, kMostBlockBytes));
    if (total > kMostResourceBytes)
        return damaged(fmt::format("found {} bytes when decompressedResource, expected at most {}", total, kMostResourceBytes));
    const std::uint64_t blocks = total / block + 1, tableBytes = 4 * blocks;
    if (file.size() - kHeader < tableBytes)
        return damaged(fmt::format("found {} bytes, expected the sizes of {} blocks: truncated", file.size(), blocks));
    std::vector<std::byte> table(tableBytes), bytes;
    LC_CHECK(file.readAt(kHeader, table));
    std::uint64_t offset = kHeader + tableBytes;
    for (std::uint64_t i = 0; i < blocks; ++i) {
        const std::uint32_t length = loadU32(table, 4 * i);
        if (length > file.size() - offset)
            return damaged(fmt::format("found {} bytes left for block {}, expected {}: truncated", file.size() - offset, i, length));
        const std::uint64_t size = std::min<std::uint64_t>(block, total - i * block);
        if (size > 0) {
            LC_TRY(part, zstdDecompress(file, offset, length, size, subject.at(fmt::format("block {}", i))));
            bytes.insert(bytes.end(), part->begin(), part->end());
        }
        offset += length;
    }
    return bytes;
}

}  // namespace

std::string LmbakeUser::name() const {
    std::string text = fmt::format("{}", fmt::join(path, "/"));
    if (subInstance >= 0) text += fmt::format(", mesh {}", subInstance);
    return text;
}

int Lmbake::sliceCount() const {
    int count = 0;
    for (const LmbakeUser& user : users) count = std::max(count, user.slice + 1);
    return count;
}

Result<Lmbake> readLmbake(const std::filesystem::path& file) {
    LC_TRY(opened, FileBytes::openForReading(file));
    const Subject subject(file);
    if (opened->size() > kMostResourceBytes)
        return failure(ErrorCode::FileUnreadable, subject,
                       fmt::format("found {} bytes, expected at most {}", opened->size(), kMostResourceBytes));
    constexpr std::size_t kLetters = 4;
    std::vector<std::byte> bytes(std::min<std::uint64_t>(opened->size(), kLetters));
    LC_CHECK(opened->readAt(0, bytes));
    const std::string letters(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const bool isCompressed = letters == "RSCC";
    if (!isCompressed && letters != "RSRC")
        return failure(
            ErrorCode::FileUnreadable, subject,
            fmt::format("found no binary resource of Godot, expected a file of class {} that begins with RSRC or RSCC", kResourceClass));
    if (isCompressed) {
        LC_TRY(plain, decompressedResource(*opened));
        bytes = std::move(*plain);
    } else {
        bytes.resize(opened->size());
        LC_CHECK(opened->readAt(0, bytes));
    }
    try {
        return ResourceReader(bytes).read(isCompressed ? 0 : kLetters);
    } catch (const ResourceDamage& damage) {
        return failure(damage.code, subject.at(damage.place), damage.detail);
    }
}

bool mayTakeLmbake(std::string_view bake) {
    const BakeFormatInfo* const format = findByName(allBakeFormats(), bake);
    return format == nullptr || format->takesLmbake;
}

bool isLmbakeFile(const std::filesystem::path& file) {
    return lowerExtension(file) == ".lmbake";
}

std::filesystem::path lmbakeOfImport(const std::filesystem::path& lightMap) {
    if (!importedSlices(lightMap)) return {};
    std::filesystem::path file = lightMap;
    return file.replace_extension(".lmbake");
}

std::filesystem::path lmbakeOfSplitBake(const std::filesystem::path& lightMap) {
    const std::string stem = lightMap.stem().string();
    const std::size_t end = stem.find_last_not_of("0123456789");
    if (end == std::string::npos || end + 1 == stem.size() || stem[end] != '_') return {};
    const std::filesystem::path file = lightMap.parent_path() / (stem.substr(0, end) + ".lmbake");
    std::error_code code;
    return std::filesystem::is_regular_file(file, code) ? file : std::filesystem::path();
}

std::filesystem::path lmbakeBeside(const std::filesystem::path& lightMap, const std::string& bake) {
    std::filesystem::path file = lightMap;
    file.replace_extension(".lmbake");
    std::error_code code;
    if (!mayTakeLmbake(bake) || !std::filesystem::is_regular_file(file, code)) return {};
    LightMapDescription description;
    description.bake = bake;
    const auto known = LightMapReader::recognize(lightMap, description);
    // A light map that cannot be read has an error of its own, which says why.
    return known && known->format->takesLmbake ? file : std::filesystem::path();
}

}  // namespace lightcook::formats
