#include "formats/bakes/coefficient_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/bake_format.h"
#include "formats/bakes/bake_image.h"
#include "formats/bakes/sh9.h"
#include "formats/bakes/sh_channels.h"
#include "formats/bakes/surface_channels.h"
#include "formats/file/one_line.h"
#include "formats/nearest.h"
#include "formats/plain_image.h"
#include "formats/vocabulary.h"

namespace lightcook::formats {
namespace {

constexpr std::size_t kOfOrder1 = 4;  ///< coefficients

std::string coefficientName(std::size_t index) {
    return fmt::format("sh{:02}", index);
}

/// Returns the names that a list may have: of coefficients, and of their colours.
std::vector<std::string> knownNames() {
    std::vector<std::string> names = sh9Channels();
    for (std::size_t index = 0; index < lighting::kShCount; ++index) names.push_back(coefficientName(index));
    return names;
}

/// Channels of an image that are light: not of the surface, nor alpha.
std::vector<std::string> lightChannels(const ExrInfo& info) {
    std::vector<std::string> channels;
    for (const std::string& name : info.channels)
        if (name != "A" && std::ranges::find(kSurfaceChannels, name) == kSurfaceChannels.end()) channels.push_back(name);
    return channels;
}

/// Returns the channel of an image that holds one colour of one coefficient.
Result<std::string> onlyChannel(const BakeImage& image, const std::string& name) {
    const std::vector<std::string> channels = lightChannels(image.info());
    if (channels.size() == 1) return channels.front();
    return failure(
        ErrorCode::WrongShape, image.subject(),
        fmt::format("found the channels {}, expected one channel, since the scene names it as {}. An image of R, G and B? Name it "
                    "as {} alone",
                    oneLine(fmt::format("{}", fmt::join(channels, ", "))), name, name.substr(0, name.find('.'))));
}

/// Opens images and notes the channel of each number.
class FilesOpener {
public:
    explicit FilesOpener(const std::map<std::string, std::filesystem::path>& files) : files_(files) {}

    Result<std::unique_ptr<BakeReader>> open() {
        for (std::size_t index = 0; index < lighting::kShCount; ++index) LC_CHECK(add(coefficientName(index)));
        return openShChannels(std::move(images_), std::move(channels_), "A");
    }

private:
    Result<void> add(const std::string& coefficient) {
        if (const auto whole = files_.find(coefficient); whole != files_.end()) return addWhole(whole->second);
        for (const char colour : {'R', 'G', 'B'}) {
            const std::string name = fmt::format("{}.{}", coefficient, colour);
            const auto part = files_.find(name);
            if (part == files_.end()) return {};
            LC_CHECK(addImage(part->second));
            const Result<std::string> channel = onlyChannel(images_.back(), name);
            if (!channel) return tl::make_unexpected(channel.error());
            channels_.push_back({images_.size() - 1, *channel});
        }
        return {};
    }
    Result<void> addWhole(const std::filesystem::path& file) {
        LC_CHECK(addImage(file));
        for (const char colour : {'R', 'G', 'B'}) {
            if (!images_.back().info().has(std::string(1, colour)))
                return failure(ErrorCode::WrongShape, images_.back().subject(),
                               fmt::format("found no channel {}, expected R, G and B", colour));
            channels_.push_back({images_.size() - 1, std::string(1, colour)});
        }
        return {};
    }
    Result<void> addImage(const std::filesystem::path& file) {
        Result<BakeImage> image = BakeImage::open(file);
        if (!image && image.error().code == ErrorCode::FormatUnsupported && isPictureFile(file))
            return failure(ErrorCode::FormatUnsupported, file,
                           "found a picture of integers, expected OpenEXR or Radiance HDR: coefficients have no encoding");
        if (!image) return tl::make_unexpected(image.error());
        images_.push_back(std::move(*image));
        const ExrInfo &first = images_.front().info(), &info = images_.back().info();
        if (info.width == first.width && info.height == first.height) return {};
        return failure(ErrorCode::WrongShape, file,
                       fmt::format("found {} x {} texels, expected {} x {} as {} has", info.width, info.height, first.width, first.height,
                                   images_.front().file().filename().string()));
    }

    const std::map<std::string, std::filesystem::path>& files_;
    std::vector<BakeImage> images_;
    std::vector<ShChannel> channels_;
};

}  // namespace

Result<const BakeFormatInfo*> bakeFormatOfFiles(std::span<const std::string> names, const Subject& subject) {
    const auto refuse = [&](std::string detail) { return failure(ErrorCode::InvalidRequest, subject, std::move(detail)); };
    const auto has = [&](const std::string& name) { return std::ranges::find(names, name) != names.end(); };
    const std::vector<std::string> known = knownNames();
    for (const std::string& name : names)
        if (std::ranges::find(known, name) == known.end())
            return refuse(fmt::format("found '{}', expected coefficients sh00 to sh08 or their colours, as sh00.R; nearest is '{}'",
                                      oneLine(name), nearestName(name, known)));
    std::optional<std::size_t> last;
    for (std::size_t index = 0; index < lighting::kShCount; ++index)
        for (const std::string& name : names)
            if (name.starts_with(coefficientName(index))) last = index;
    const std::size_t count = last.value_or(0) < kOfOrder1 ? kOfOrder1 : lighting::kShCount;
    for (std::size_t index = 0; index < count; ++index) {
        const std::string name = coefficientName(index);
        const auto colours = std::ranges::count_if(names, [&](const std::string& each) { return each.starts_with(name + "."); });
        if (has(name) && colours == 0) continue;
        if (has(name)) return refuse(fmt::format("found {} beside one of its colours, expected one of both", name));
        if (colours == 0)
            return refuse(fmt::format("found no {}, expected sh00 to sh03 (bands 0 and 1) or sh00 to sh08 (bands 0 to 2)", name));
        if (colours < 3) return refuse(fmt::format("found {} of the colours of {}, expected R, G and B", colours, name));
    }
    return findByName(allBakeFormats(), count == kOfOrder1 ? "sh4" : "sh9");
}

Result<std::unique_ptr<BakeReader>> openCoefficientFiles(const std::map<std::string, std::filesystem::path>& files) {
    return FilesOpener(files).open();
}

}  // namespace lightcook::formats
