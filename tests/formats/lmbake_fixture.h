// Files of Godot's LightmapGIData, written value by value: for tests of what lies where in a light map of Godot.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {

/// The bytes of a resource, in the order of the machine that wrote it.
class GodotBytes {
public:
    explicit GodotBytes(bool isBigEndian = false) : isBigEndian_(isBigEndian) {}

    GodotBytes& number(std::uint64_t value, int bytes) {
        for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> 8 * (isBigEndian_ ? bytes - 1 - i : i));
        return *this;
    }
    GodotBytes& u32(std::uint64_t value) { return number(value, 4); }
    GodotBytes& u64(std::uint64_t value) { return number(value, 8); }
    GodotBytes& real(double value, bool isDouble) {
        return isDouble ? u64(std::bit_cast<std::uint64_t>(value)) : u32(std::bit_cast<std::uint32_t>(static_cast<float>(value)));
    }
    GodotBytes& string(const std::string& value) {
        u32(value.size() + 1);
        text += value + '\0';
        return *this;
    }

    std::string text;

private:
    bool isBigEndian_;
};

struct GodotMesh {
    std::vector<std::string> path;
    double x = 0, y = 0, width = 1, height = 1;
    int slice = 0, subInstance = -1;
};

struct GodotBake {
    std::vector<GodotMesh> meshes;
    std::string resource = "LightmapGIData";
    bool isBigEndian = false, isDouble = false, hasNamesInTable = true;
    bool isPacked = true;  ///< its directions, as those of Godot 4.4 and later
    int minor = 4;         ///< version of Godot 4 that saved it

    /// Returns the bytes behind the letters "RSRC".
    /// before  number of bytes before them
    std::string content(std::size_t before) const {
        GodotBytes bytes(isBigEndian);
        bytes.u32(isBigEndian ? 1 : 0).u32(0).u32(4).u32(static_cast<std::uint64_t>(minor)).u32(6).string(resource).u64(0);
        bytes.u32(isDouble ? 1 + 2 + 4 : 1 + 2).u64(0x1234);
        for (int i = 0; i < 11; ++i) bytes.u32(0);
        std::vector<std::string> names = {"resource_name", "lightmap_textures", "uses_spherical_harmonics",
                                          "user_data",     "probe_data",        "_uses_packed_directional"};
        const std::size_t firstOfPaths = names.size();
        if (hasNamesInTable)
            for (const GodotMesh& mesh : meshes) names.insert(names.end(), mesh.path.begin(), mesh.path.end());
        bytes.u32(names.size());
        for (const std::string& name : names) bytes.string(name);
        bytes.u32(1).string("CompressedTexture2DArray").string("res://room.exr").u64(0x5678);  // the file that it refers to
        bytes.u32(1).string("local://1");
        const std::size_t offsetAt = bytes.text.size();
        bytes.u64(0);
        GodotBytes offset(isBigEndian);
        offset.u64(before + bytes.text.size());
        bytes.text.replace(offsetAt, 8, offset.text);
        bytes.string(resource).u32(isPacked ? 5 : 4);
        bytes.u32(1).u32(30).u32(1).u32(24).u32(3).u32(0);  // a list of one reference to a file
        bytes.u32(2).u32(2).u32(1);                         // true
        bytes.u32(4).u32(26).u32(0x80000003);               // probes, before the meshes
        bytes.u32(5).string("bounds").u32(15);
        for (int i = 0; i < 6; ++i) bytes.real(i, isDouble);
        bytes.u32(5).string("points").u32(35).u32(2);
        for (int i = 0; i < 6; ++i) bytes.real(i, isDouble);
        bytes.u32(5).string("bytes").u32(31).u32(5).text += std::string("abcde\0\0\0", 8);
        bytes.u32(3).u32(30).u32(4 * meshes.size());
        std::size_t name = firstOfPaths;
        for (const GodotMesh& mesh : meshes) {
            bytes.u32(22).number(mesh.path.size(), 2).number(0, 2);
            for (const std::string& part : mesh.path) {
                if (hasNamesInTable)
                    bytes.u32(name++);
                else
                    bytes.u32(0x80000000 | (part.size() + 1)).text += part + '\0';
            }
            bytes.u32(11).real(mesh.x, isDouble).real(mesh.y, isDouble).real(mesh.width, isDouble).real(mesh.height, isDouble);
            bytes.u32(3).u32(static_cast<std::uint32_t>(mesh.slice));
            bytes.u32(3).u32(static_cast<std::uint32_t>(mesh.subInstance));
        }
        if (isPacked) bytes.u32(5).u32(2).u32(1);
        return bytes.text + "RSRC";
    }

    std::string plain() const { return "RSRC" + content(4); }

    /// Returns the file with blocks of Zstandard: frames of a size in four bytes and one block of stored bytes (RFC 8878, 3.1.1).
    std::string compressed(std::uint32_t blockSize = 4096) const {
        const std::string whole = content(0);
        std::vector<std::string> frames;
        for (std::size_t at = 0; at <= whole.size(); at += blockSize) {
            const std::string part = whole.substr(at, blockSize);
            GodotBytes frame;
            frame.u32(0xFD2FB528).number(0xA0, 1).u32(part.size()).number(1 | part.size() << 3, 3).text += part;
            frames.push_back(frame.text);
        }
        GodotBytes bytes;
        bytes.text = "RSCC";
        bytes.u32(2).u32(blockSize).u32(whole.size());
        for (const std::string& frame : frames) bytes.u32(frame.size());
        for (const std::string& frame : frames) bytes.text += frame;
        return bytes.text + "RSCC";
    }

    void write(const std::filesystem::path& file) const { writeContent(file, plain()); }
};

}  // namespace lightcook::formats
