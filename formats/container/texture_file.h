// The description that KTX2 and DDS files share: shape, place of every image in the file, metadata.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "formats/gpu_texture.h"

namespace lightcook::formats {

/// Largest extent and array length that we read or write. Sizes of whole textures then stay below 2^56 bytes: 64-bit sums cannot overflow.
inline constexpr int kMaxTextureExtent = 65536;
inline constexpr int kMaxTextureLayers = 65536;

/// Fails unless extent, mips, layers and faces are in range and agree: cube faces are square. `subject` names the file in the error.
Result<void> checkShape(const TextureShape& shape, const Subject& subject);

/// Returns the size of all layers and faces of one mip [bytes], uncompressed.
std::uint64_t levelBytes(const TextureShape& shape, int mip);
/// Returns the size of all mips of one layer and face [bytes].
std::uint64_t mipChainBytes(const TextureShape& shape);

/// Place of one mip level in a KTX2 file. A DDS file stores whole mip chains, one for each layer and face, and has a single place for all.
struct LevelPlace {
    std::uint64_t offset = 0;  ///< [bytes] from the start of the file
    std::uint64_t length = 0;  ///< [bytes] in the file
    std::uint64_t uncompressedLength = 0;
};

/// Describes a container file that is read or about to be written.
struct TextureFileLayout {
    Container container = Container::Ktx2;
    TextureShape shape;
    bool zstd = false;
    std::map<std::string, std::string> metadata;
    std::vector<LevelPlace> levels;
    bool hasOwnTransfer = true;  ///< see TextureReader
    bool hasBc1Alpha = false;    ///< see TextureReader

    std::uint64_t fileBytes() const;
    /// Start of an image: in the file or, with zstd, in its uncompressed level.
    std::uint64_t imageOffset(SubImage image) const;
};

}  // namespace lightcook::formats
