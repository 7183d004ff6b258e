// The decoders of draco_mesh.h, in this process and behind a wall.
#pragma once

#include "formats/gltf/draco_mesh.h"

namespace lightcook::formats {

tl::expected<TriangleMesh, std::string> decodeDracoHere(std::span<const std::byte> bytes, std::span<const DracoAttribute> attributes);
tl::expected<TriangleMesh, std::string> decodeDracoInChild(std::span<const std::byte> bytes, std::span<const DracoAttribute> attributes);
tl::expected<DracoLattices, std::string> dracoLatticesHere(std::span<const std::byte> bytes);
tl::expected<DracoLattices, std::string> dracoLatticesInChild(std::span<const std::byte> bytes);

}  // namespace lightcook::formats
