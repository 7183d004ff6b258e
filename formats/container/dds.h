// DDS containers: the 124-byte header and its DX10 extension (Microsoft, "DDS file layout", "DDS_HEADER_DXT10").
#pragma once

#include <cstddef>
#include <vector>

#include "formats/container/texture_file.h"
#include "formats/file/file_bytes.h"

namespace lightcook::formats {

/// Lays a file out: layer by layer, face by face, each with all its mips, largest first. DDS tells an array of one texture from no array
/// as little as DXGI does: it reads back as no array. Refused: formats without a DXGI number (ASTC, rgb16f), and Zstandard.
Result<TextureFileLayout> layOutDds(const TextureShape& shape, const TextureFileOptions& options, const Subject& subject);
/// The header: legacy FourCC DXT1 and DXT5 for BC1 and BC3 that are not arrays (OpenImageIO 2.4 reads those in no other way), DX10
/// otherwise.
std::vector<std::byte> ddsPrefix(const TextureShape& shape);

/// Reads and checks everything but the texels. Takes dwMipMapCount with or without its flag, and the six faces of a cubemap from dwCaps2 or
/// from miscFlag. The size of the file decides between the shapes that a header may mean. A longer or shorter file is refused,
/// since the images of cubemaps and arrays would lie in other places.
Result<TextureFileLayout> readDds(const FileBytes& file);

}  // namespace lightcook::formats
