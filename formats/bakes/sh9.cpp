#include "formats/bakes/sh9.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "formats/bakes/sh_channels.h"

namespace lightcook::formats {
namespace {

constexpr std::ptrdiff_t kOfBands01 = 12;  ///< channels

}  // namespace

std::string sh9Channel(int index) {
    return fmt::format("sh{:02}.{}", index / 3, "RGB"[index % 3]);
}

std::vector<std::string> sh9Channels() {
    std::vector<std::string> names;
    for (int index = 0; index < 3 * lighting::kShCount; ++index) names.push_back(sh9Channel(index));
    return names;
}

BakeMatch matchSh9(const std::filesystem::path&, const ExrInfo& info) {
    const std::vector<std::string> all = sh9Channels();
    BakeMatch match = matchChannels(info, all, "sh9", kSh9Content);
    // Without a channel of band 2 the file is nearer to sh4.
    const bool hasBand2 = std::any_of(all.begin() + kOfBands01, all.end(), [&](const std::string& name) { return info.has(name); });
    if (!hasBand2) match.numberCount /= 2;
    return match;
}

Result<std::unique_ptr<BakeReader>> openSh9(BakeImage image) {
    return openShChannels(std::move(image), sh9Channels());
}

}  // namespace lightcook::formats
