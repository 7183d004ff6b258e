// KTX 2.0 containers (Khronos KTX File Format Specification 2.0), the part that textures of our formats need: header, level index, data
// format descriptor (Khronos Data Format 1.3, basic descriptor block), key-value data. No supercompression, or Zstandard by level.
#pragma once

#include <cstddef>
#include <vector>

#include "formats/container/texture_file.h"
#include "formats/file/file_bytes.h"

namespace lightcook::formats {

/// The data format descriptor of a format, its total size included. Bytes of the texel block are kept under supercompression, as
/// KTX-Software 5 writes them (older revisions of the specification wanted zeros there; both are read).
std::vector<std::byte> ktx2DataFormatDescriptor(PixelFormat format);

/// Lays an uncompressed file out: levels smallest first, each aligned to lcm(block bytes, 4).
Result<TextureFileLayout> layOutKtx2(const TextureShape& shape, const TextureFileOptions& options, const Subject& subject);
/// Everything before the first level: header, index, descriptor, key-values ("KTXwriter" and "KTXorientation" are ours), zero padding not
/// included. The level places of the layout are taken as they stand.
std::vector<std::byte> ktx2Prefix(const TextureFileLayout& layout);

/// Reads and checks everything but the texels.
Result<TextureFileLayout> readKtx2(const FileBytes& file);

}  // namespace lightcook::formats
