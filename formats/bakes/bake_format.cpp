#include "formats/bake_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "formats/bakes/bake_reader.h"
#include "formats/bakes/sh9.h"
#include "formats/file/one_line.h"
#include "formats/vocabulary.h"

namespace lightcook::formats {
namespace {

constexpr std::array kBakeFormats = {
    BakeFormatInfo{.name = "sh9",
                   .caption = "27 channels sh00.R, sh00.G, sh00.B to sh08.B: coefficient l * (l + 1) + m of bands 0, 1 and 2",
                   .channelCaption = "sh00.R .. sh08.B",
                   .channels = sh9Channels,
                   .implied = {},
                   .open = openSh9},
};

std::vector<std::string> missingChannels(const BakeFormatInfo& format, const ExrInfo& info) {
    std::vector<std::string> missing;
    for (const std::string& name : format.channels())
        if (!info.has(name)) missing.push_back(name);
    return missing;
}

tl::unexpected<Error> incomplete(const BakeFormatInfo& format, const std::vector<std::string>& missing, const std::string& subject) {
    const std::size_t count = format.channels().size();
    const std::string others = missing.size() == 1 ? " is missing" : fmt::format(" and {} more are missing", missing.size() - 1);
    return failure(ErrorCode::WrongShape, subject,
                   fmt::format("found {} of the {} channels of bake format {}, {}{}, expected {}", count - missing.size(), count,
                               format.name, missing.front(), others, format.channelCaption));
}

constexpr std::string_view kPictureChannels = "RGBA";

bool isPicture(const ExrInfo& info) {
    return !info.channels.empty() && std::ranges::all_of(info.channels, [](const std::string& name) {
        return name.size() == 1 && kPictureChannels.find(name) != std::string_view::npos;
    });
}

/// Returns the probable kind of a file without SH coefficients, and what to do with it.
std::string guessOf(const ExrInfo& info) {
    if (isPicture(info))
        return ". A flat light map or a picture? It has no directions: compress it with `lightcook encode`, or bake SH coefficients";
    const bool hasCoefficients = std::ranges::any_of(info.channels, [](const std::string& name) {
        return name.find("sh") != std::string::npos || name.find("SH") != std::string::npos;
    });
    return hasCoefficients ? ". SH under other names? Rename the channels" : "";
}

tl::unexpected<Error> unknownFormat(const ExrInfo& info, const std::string& subject) {
    std::vector<std::string> known, held = info.channels;
    for (const BakeFormatInfo& format : kBakeFormats) known.push_back(fmt::format("{} ({})", format.name, format.channelCaption));
    // EXR files have their channels in alphabetical order.
    if (isPicture(info)) std::ranges::sort(held, {}, [](const std::string& name) { return kPictureChannels.find(name); });
    return failure(ErrorCode::WrongShape, subject,
                   fmt::format("found no light map, expected the channels of a bake format: {}; it holds {}{}", fmt::join(known, ", "),
                               held.empty() ? "no channels" : oneLine(fmt::format("{}", fmt::join(held, ", "))), guessOf(info)));
}

/// The format of the most channels among those that the file has in full; else the one that it nearly has, whose error names the gap.
Result<const BakeFormatInfo*> identify(const ExrInfo& info, const std::string& subject) {
    const BakeFormatInfo* complete = nullptr;
    const BakeFormatInfo* partial = nullptr;
    std::size_t completeCount = 0, partialCount = 0;
    for (const BakeFormatInfo& format : kBakeFormats) {
        const std::size_t count = format.channels().size(), present = count - missingChannels(format, info).size();
        const bool isComplete = present == count;
        std::size_t& most = isComplete ? completeCount : partialCount;
        if (present <= most) continue;
        most = present;
        (isComplete ? complete : partial) = &format;
    }
    if (complete != nullptr) return complete;
    if (partial != nullptr) return incomplete(*partial, missingChannels(*partial, info), subject);
    return unknownFormat(info, subject);
}

}  // namespace

std::span<const BakeFormatInfo> allBakeFormats() {
    return kBakeFormats;
}

std::vector<std::string> bakeNames() {
    std::vector<std::string> names = namesOf(allBakeFormats());
    names.insert(names.begin(), std::string(kAutoBake));
    return names;
}

Result<void> checkBakeName(const std::string& bake, const std::string& subject) {
    if (bake == kAutoBake || findByName(allBakeFormats(), bake) != nullptr) return {};
    return failure(ErrorCode::InvalidRequest, subject + ", bake",
                   fmt::format("found \"{}\", expected {}", oneLine(bake), fmt::join(bakeNames(), " or ")));
}

Result<const BakeFormatInfo*> findBakeFormat(const std::string& bake, const ExrInfo& info, const std::string& subject) {
    if (const auto known = checkBakeName(bake, subject); !known) return tl::make_unexpected(known.error());
    if (bake == kAutoBake) return identify(info, subject);
    const BakeFormatInfo* format = findByName(allBakeFormats(), bake);
    const std::vector<std::string> missing = missingChannels(*format, info);
    if (missing.size() == format->channels().size()) return unknownFormat(info, subject);
    if (!missing.empty()) return incomplete(*format, missing, subject);
    return format;
}

LightMapDescription withImplied(LightMapDescription description, const BakeConventions& implied) {
    description.phase = implied.phase.value_or(description.phase);
    description.frame = implied.frame.value_or(description.frame);
    description.quantity = implied.quantity.value_or(description.quantity);
    description.lightUnits = implied.lightUnits.value_or(description.lightUnits);
    return description;
}

}  // namespace lightcook::formats
