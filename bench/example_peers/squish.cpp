// Example of a peer (bench/encoder_peer.h): libsquish, for BC1, BC3, BC4 and BC5.
#include <squish.h>

#include <iterator>
#include <string_view>

#include "bench/encoder_peer.h"

namespace {

struct Profile {
    const char* name;
    int flags;
};
constexpr Profile kProfiles[] = {
    {"range fit", squish::kColourRangeFit}, {"cluster fit", squish::kColourClusterFit}, {"iterative", squish::kColourIterativeClusterFit}};

/// Returns libsquish's number of a format, or 0.
int flagOf(std::string_view format) {
    if (format == "bc1") return squish::kDxt1;
    if (format == "bc3") return squish::kDxt5;
    if (format == "bc4") return squish::kBc4;
    if (format == "bc5") return squish::kBc5;
    return 0;
}

/// The profiles differ in how they fit colours: formats without colour have one.
int profileCount(int flag) {
    if (flag == 0) return 0;
    return flag == squish::kBc4 || flag == squish::kBc5 ? 1 : static_cast<int>(std::size(kProfiles));
}

}  // namespace

// NOLINTBEGIN(readability-identifier-naming): the names of the interface
extern "C" {

int32_t lightcook_peer_interface(void) {
    return LIGHTCOOK_PEER_INTERFACE;
}

const char* lightcook_peer_name(void) {
    return "libsquish";
}

const char* lightcook_peer_profile(const char* format, int32_t profile) {
    const int count = profileCount(flagOf(format));
    if (profile < 0 || profile >= count) return nullptr;
    return count == 1 ? "default" : kProfiles[profile].name;
}

int32_t lightcook_peer_texels(const char*) {
    return LIGHTCOOK_PEER_RGBA8;
}

int32_t lightcook_peer_encode(const char* format, int32_t profile, const void* texels, int32_t width, int32_t height, void* blocks) {
    if (!lightcook_peer_profile(format, profile)) return 1;
    squish::CompressImage(static_cast<const squish::u8*>(texels), width, height, blocks, flagOf(format) | kProfiles[profile].flags);
    return 0;
}
}
// NOLINTEND(readability-identifier-naming)
