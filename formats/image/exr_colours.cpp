#include "formats/image/exr_colours.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>

#include "formats/file/one_line.h"

namespace lightcook::formats {
namespace {

constexpr std::string_view kColourNames = "RGBA";
constexpr std::size_t kMostShown = 16;

std::string listOf(const std::vector<std::string>& names) {
    std::vector<std::string> shown;
    for (std::size_t i = 0; i < std::min(names.size(), kMostShown); ++i) shown.push_back(oneLine(names[i]));
    return fmt::format("{}{}", fmt::join(shown, ", "),
                       names.size() > kMostShown ? fmt::format(" and {} more", names.size() - kMostShown) : "");
}

/// Returns the colours among the channels of a layer. Empty: it has neither colours nor grey.
/// prefix  of the layer's channels: "beauty.", or nothing
std::optional<ExrColours> coloursOfLayer(const ExrInfo& info, const std::string& prefix) {
    const auto find = [&](char name) {
        for (const int step : {0, 'a' - 'A'})
            if (const std::string channel = prefix + static_cast<char>(name + step); info.has(channel)) return channel;
        return std::string();
    };
    ExrColours colours;
    for (std::size_t i = 0; i < kColourNames.size(); ++i) colours.channels[i] = find(kColourNames[i]);
    if (colours.channels[0].empty() && colours.channels[1].empty() && colours.channels[2].empty()) {
        const bool isChroma = info.has(prefix + "RY") || info.has(prefix + "BY"), isXyz = !find('X').empty();
        colours.channels[0] = isChroma || isXyz ? "" : find('Y');
        if (colours.channels[0].empty()) return std::nullopt;
        colours.isGrey = true;
    }
    return colours;
}

/// Returns the colours of the only layer that has some. Empty: none has.
Result<std::optional<ExrColours>> coloursOfLayers(const ExrInfo& info, const Subject& subject) {
    std::map<std::string, ExrColours> found;
    std::vector<std::string> layers;
    for (const std::string& channel : info.channels) {
        const std::size_t dot = channel.rfind('.');
        if (dot == std::string::npos || found.contains(channel.substr(0, dot + 1))) continue;
        if (auto colours = coloursOfLayer(info, channel.substr(0, dot + 1))) {
            found.emplace(channel.substr(0, dot + 1), std::move(*colours));
            layers.push_back(channel.substr(0, dot));
        }
    }
    if (found.empty()) return std::optional<ExrColours>();
    if (found.size() == 1) return std::optional(found.begin()->second);
    return failure(
        ErrorCode::WrongShape, subject,
        fmt::format("found the layers {0}, expected the channels R, G and B, or those of one layer. Take one out: oiiotool in.exr "
                    "--ch R={2}.R,G={2}.G,B={2}.B -o out.exr{1}",
                    listOf(layers), info.channels.size() > 8 ? ". A light map? Compress it with `lightcook lightmap`" : "",
                    oneLine(layers.front())));
}

}  // namespace

int ExrColours::channelCount() const {
    return static_cast<int>(std::ranges::count_if(channels, [](const std::string& name) { return !name.empty(); }));
}

Result<ExrColours> exrColours(const ExrInfo& info, const Subject& subject) {
    std::optional<ExrColours> colours = coloursOfLayer(info, "");
    if (!colours && info.channels.size() == 1) {
        colours.emplace();
        const bool isAlpha = info.channels.front() == "A" || info.channels.front() == "a";
        colours->channels[isAlpha ? 3 : 0] = info.channels.front();
        colours->isGrey = !isAlpha;
    }
    if (!colours) {
        LC_TRY(ofLayer, coloursOfLayers(info, subject));
        colours = std::move(*ofLayer);
    }
    if (!colours)
        return failure(ErrorCode::WrongShape, subject,
                       fmt::format("found the channel{} {}, expected R, G and B, or Y for grey", info.channels.size() == 1 ? "" : "s",
                                   listOf(info.channels)));
    for (const std::string& channel : info.channels)
        if (std::ranges::find(colours->channels, channel) == colours->channels.end()) colours->ignored.push_back(channel);
    return *colours;
}

}  // namespace lightcook::formats
