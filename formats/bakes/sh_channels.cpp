#include "formats/bakes/sh_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <optional>
#include <utility>

#include "formats/bakes/images_reader.h"

namespace lightcook::formats {
namespace {

class ShChannelReader final : public ImagesReader {
public:
    ShChannelReader(std::vector<BakeImage> images, std::vector<ShChannel> channels, SurfaceChannels surface)
        : ImagesReader(std::move(images), std::move(surface)), channels_(std::move(channels)) {}

    Result<RawStrip> read(int firstRow, int rowCount) const override {
        RawStrip raw = emptyStrip(rowCount);
        std::vector<std::vector<ExrPlane>> planes(images().size());
        for (std::size_t i = 0; i < channels_.size(); ++i) planes[channels_[i].image].push_back(planeOf(raw, channels_[i].channel, i));
        addSurface(raw, planes.front());
        for (std::size_t image = 0; image < images().size(); ++image) LC_CHECK(images()[image].readRows(firstRow, rowCount, planes[image]));
        return raw;
    }

    std::optional<StoredNumber> placeOf(std::size_t coefficient, int colour, int x, int y) const override {
        const std::size_t index = 3 * coefficient + static_cast<std::size_t>(colour);
        if (index >= channels_.size()) return std::nullopt;
        return StoredNumber{images()[channels_[index].image].subject(), channels_[index].channel, x, y};
    }

private:
    std::vector<ShChannel> channels_;
};

}  // namespace

BakeMatch matchChannels(const ExrInfo& info, const std::vector<std::string>& wanted, std::string_view format, std::string_view content) {
    std::vector<std::string> missing;
    for (const std::string& name : wanted)
        if (!info.has(name)) missing.push_back(name);
    const std::size_t present = wanted.size() - missing.size();
    if (present == 0) return {};
    if (missing.empty()) return {BakeMatch::Kind::Certain, static_cast<int>(present), fmt::format("channels {}", content)};
    const std::string others = missing.size() == 1 ? " is missing" : fmt::format(" and {} more are missing", missing.size() - 1);
    return {BakeMatch::Kind::Partial, static_cast<int>(present),
            fmt::format("found {} of the {} channels of bake format {}, {}{}, expected {}", present, wanted.size(), format, missing.front(),
                        others, content),
            static_cast<int>(missing.size())};
}

Result<std::unique_ptr<BakeReader>> openShChannels(std::vector<BakeImage> images, std::vector<ShChannel> channels,
                                                   const std::string& coverage) {
    assert(!images.empty() && channels.size() <= std::size_t{3} * lighting::kShCount);
    Result<SurfaceChannels> surface = SurfaceChannels::of(images.front(), coverage);
    if (!surface) return tl::make_unexpected(surface.error());
    return std::make_unique<ShChannelReader>(std::move(images), std::move(channels), std::move(*surface));
}

Result<std::unique_ptr<BakeReader>> openShChannels(BakeImage image, std::vector<std::string> names) {
    std::vector<ShChannel> channels;
    for (std::string& name : names) channels.push_back({0, std::move(name)});
    return openShChannels(onlyImage(std::move(image)), std::move(channels));
}

}  // namespace lightcook::formats
