#include "formats/bakes/sh4.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "formats/bakes/sh9.h"
#include "formats/bakes/sh_channels.h"

namespace lightcook::formats {
namespace {

constexpr std::ptrdiff_t kNumbers = 12;  ///< of a texel

std::vector<std::string> sh4Channels() {
    std::vector<std::string> names = sh9Channels();
    names.resize(kNumbers);
    return names;
}

}  // namespace

BakeMatch matchSh4(const std::filesystem::path&, const ExrInfo& info) {
    const std::vector<std::string> all = sh9Channels();
    if (std::any_of(all.begin() + kNumbers, all.end(), [&](const std::string& name) { return info.has(name); })) return {};
    return matchChannels(info, sh4Channels(), "sh4", kSh4Content);
}

Result<std::unique_ptr<BakeReader>> openSh4(BakeImage image) {
    return openShChannels(std::move(image), sh4Channels());
}

}  // namespace lightcook::formats
