#include "formats/bakes/sh9.h"

#include <fmt/format.h>

#include <utility>

#include "formats/bakes/sh_channels.h"

namespace lightcook::formats {

std::string sh9Channel(int index) {
    return fmt::format("sh{:02}.{}", index / 3, "RGB"[index % 3]);
}

std::vector<std::string> sh9Channels() {
    std::vector<std::string> names;
    for (int index = 0; index < 3 * lighting::kShCount; ++index) names.push_back(sh9Channel(index));
    return names;
}

BakeMatch matchSh9(const std::filesystem::path&, const ExrInfo& info) {
    return matchChannels(info, sh9Channels(), "sh9", kSh9Content);
}

Result<std::unique_ptr<BakeReader>> openSh9(BakeImage image) {
    return openShChannels(std::move(image), sh9Channels());
}

}  // namespace lightcook::formats
