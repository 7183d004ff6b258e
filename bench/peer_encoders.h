// Loads the texture encoders of other projects (peers) from shared objects with the interface of bench/encoder_peer.h.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/vec4.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/image.h"
#include "formats/pixel_format.h"

namespace lightcook::bench {

/// Texels converted to the type that an encoder reads.
struct PeerTexels {
    int type = 0;  ///< one of LIGHTCOOK_PEER_RGBA*
    int width = 0, height = 0;
    std::vector<std::byte> bytes;
};

/// A loaded shared object. Unloaded by its destructor.
class PeerEncoder {
public:
    /// Loads a file. The error names the file, and what it lacks.
    static formats::Result<PeerEncoder> load(const std::filesystem::path& file);
    PeerEncoder(PeerEncoder&&) noexcept;
    PeerEncoder& operator=(PeerEncoder&&) noexcept;
    ~PeerEncoder();

    const std::string& name() const;

    /// Returns the names of the profiles for a format, fastest first; none if the peer does not encode it.
    std::vector<std::string> profiles(formats::PixelFormat format) const;

    /// Converts texels to the type that the peer wants for a format. Fails if the peer names an unknown type.
    formats::Result<PeerTexels> convert(formats::PixelFormat format, formats::ImageView<const glm::vec4> texels) const;

    /// Encodes an image of whole blocks. Fails if the peer returns a failure.
    formats::Result<void> encode(formats::PixelFormat format, int profile, const PeerTexels& texels, std::span<std::byte> blocks) const;

private:
    struct Library;
    explicit PeerEncoder(std::unique_ptr<Library> library);
    std::unique_ptr<Library> library_;
};

/// Loads every file *.so of a folder, in the order of their names. A folder without any is an error.
formats::Result<std::vector<PeerEncoder>> loadPeerEncoders(const std::filesystem::path& folder);

}  // namespace lightcook::bench
