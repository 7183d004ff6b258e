#include "pipeline/report/advice_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <map>

#include "formats/pixel_format.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/report/alternatives.h"
#include "pipeline/report/captions.h"
#include "pipeline/report/page_parts.h"

namespace lightcook::pipeline {
namespace {

/// An asset, its share of the memory, and its share of the squared error of the whole shading.
struct AssetShare {
    const Json* asset;
    std::uint64_t bytes;
    double memory, error;  ///< error: negative if the asset is no part of the whole shading
};

std::vector<AssetShare> sharesOf(const Json& report) {
    const auto used = static_cast<double>(count(member(member(report, "budget"), "used_bytes")));
    std::vector<AssetShare> shares;
    for (const Json& asset : list(report, "assets")) {
        const std::uint64_t bytes = count(member(asset, "bytes_gpu"));
        AssetShare share = {&asset, bytes, used > 0 ? static_cast<double>(bytes) / used : 0, -1};
        for (const Json& part : list(member(report, "whole"), "parts"))
            if (member(part, "asset") == member(asset, "name")) share.error = std::max(0.0, share.error) + number(member(part, "share"));
        shares.push_back(share);
    }
    return shares;
}

std::string nameOf(const Json& asset) {
    return fmt::format("{} '{}'", kindCaption(words(member(asset, "kind"))), words(member(asset, "name")));
}

/// Adds the asset that takes most memory for its error, and the one that makes most error for its memory.
void addProportions(const std::vector<AssetShare>& shares, std::vector<std::string>& advice) {
    constexpr double kLeastDifference = 0.1;
    const AssetShare *heavy = nullptr, *faulty = nullptr;
    for (const AssetShare& share : shares) {
        if (!(share.error >= 0)) continue;
        if (heavy == nullptr || share.memory - share.error > heavy->memory - heavy->error) heavy = &share;
        if (faulty == nullptr || share.error - share.memory > faulty->error - faulty->memory) faulty = &share;
    }
    const auto figures = [](const AssetShare& share) {
        return fmt::format("{} ({}): {} of the memory, {} of the squared error of the whole shading", nameOf(*share.asset),
                           humanBytes(share.bytes), humanPercent(share.memory), humanPercent(share.error));
    };
    if (heavy != nullptr && heavy->memory - heavy->error > kLeastDifference)
        advice.push_back(fmt::format("{}. Look here first to save memory.", figures(*heavy)));
    if (faulty != nullptr && faulty->error - faulty->memory > kLeastDifference)
        advice.push_back(fmt::format("{}. Look here first to reduce the error.", figures(*faulty)));
}

/// Adds the layouts beside the chosen one: the best of the smaller ones, the smallest of the better ones, and for a map over its limit
/// the smallest that keeps it.
void addLayouts(const Json& asset, std::vector<std::string>& advice) {
    const Alternatives alternatives(asset);
    const Json *chosen = alternatives.chosen, *cheaper = alternatives.cheaper, *better = alternatives.better, *kept = nullptr;
    if (chosen == nullptr) return;
    const ComparedError& error = alternatives.error;
    for (const Json& each : list(asset, "trial_candidates"))
        if (!isExcluded(each) && error.of(each) <= error.limit() && (kept == nullptr || bytesOfCandidate(each) < bytesOfCandidate(*kept)))
            kept = &each;
    const double share = number(member(asset, "trial_share"));
    const std::string where = share < 1 ? fmt::format("measured on {} of the map", humanPercent(share)) : "measured";
    const auto cost = [](const Json& candidate) {
        return fmt::format("{} fetches and {} operations a sample", groupedCount(count(member(candidate, "fetches"))),
                           groupedCount(count(member(candidate, "decode_ops"))));
    };
    const auto change = [&](const Json& candidate) {
        return fmt::format("the error ({}, {}) goes from {} to {}", error.name(), where, error.text(error.of(*chosen)),
                           error.text(error.of(candidate)));
    };
    if (cheaper != nullptr)
        advice.push_back(fmt::format(
            "{}: layout {} in place of {} saves {}; {}{}. {} in place of {}.", nameOf(asset), words(member(*cheaper, "layout")),
            words(member(*chosen, "layout")), humanBytes(bytesOfCandidate(*chosen) - bytesOfCandidate(*cheaper)), change(*cheaper),
            error.of(*cheaper) > error.limit() ? ", over the limit of " + error.text(error.limit()) : "", cost(*cheaper), cost(*chosen)));
    if (better != nullptr && bytesOfCandidate(*better) >= bytesOfCandidate(*chosen))
        advice.push_back(fmt::format("{}: layout {} costs {} more; {}. {}.", nameOf(asset), words(member(*better, "layout")),
                                     humanBytes(bytesOfCandidate(*better) - bytesOfCandidate(*chosen)), change(*better), cost(*better)));
    if (!passed(asset) && kept != nullptr && kept != chosen)
        advice.push_back(fmt::format("{} failed: the smallest layout that kept the limit of {} ({}) when it was tried is {}, {}.",
                                     nameOf(asset), error.text(error.limit()), error.name(), words(member(*kept, "layout")),
                                     humanBytes(bytesOfCandidate(*kept))));
}

/// Adds the layout that the scene's list lacks and the map would be better off with.
void addExcluded(const Json& asset, std::vector<std::string>& advice) {
    const Json& excluded = member(asset, "better_excluded");
    if (!excluded.is_object()) return;
    const double bytes = number(member(excluded, "bytes_saved"));
    const std::string memory = fmt::format("{} {}", bytes < 0 ? "costs" : "saves", humanBytes(static_cast<std::uint64_t>(std::abs(bytes))));
    advice.push_back(
        fmt::format("{}: with layout {} in the scene's layouts it {}{}; the error (rel_rms, in the trial) goes from {} to {}, "
                    "the visible error (p99) from {} to {}.",
                    nameOf(asset), words(member(excluded, "layout")), memory, bytes < 0 ? " more" : "",
                    humanPercent(number(member(excluded, "rel_rms"))), humanPercent(number(member(excluded, "rel_rms_then"))),
                    humanNumber(number(member(excluded, "visible"))), humanNumber(number(member(excluded, "visible_then")))));
}

/// Adds the texels of a light map that no chart uses. Those of a packed map are what blocks and filters need at the rims of its charts.
void addUnusedTexels(const Json& asset, std::vector<std::string>& advice) {
    constexpr double kLeastShare = 0.1;
    if (member(member(asset, "notes"), note_keys::kPacking).is_string()) return;
    if (member(asset, "ground_truth").is_object()) return;  // its values lie at texels of the bake: charts stay there
    std::uint64_t bytes = 0;
    std::uint64_t unused = 0;
    for (const Json& texture : list(asset, "textures")) {
        bytes += count(member(texture, "bytes_gpu"));
        unused += bytesOutsideCharts(asset, texture);
    }
    if (bytes == 0 || static_cast<double>(unused) < kLeastShare * static_cast<double>(bytes)) return;
    const bool hasMesh = member(asset, "charts").is_object();
    advice.push_back(
        fmt::format("{}: texels outside charts take {} of its textures: {}. {}charts = \"pack\" packs the light-map UVs of its "
                    "mesh anew, which saves up to that.",
                    nameOf(asset), humanPercent(static_cast<double>(unused) / static_cast<double>(bytes)), humanBytes(unused),
                    hasMesh ? "" : "Name its mesh in [[light_map]]: "));
}

/// Adds what the largest levels of cubemaps take: one sentence for those of one size that have as many levels which no material reads.
void addCubemapLevels(const std::vector<AssetShare>& shares, std::vector<std::string>& advice) {
    struct Group {
        std::vector<const Json*> cubemaps;
        std::uint64_t bytes = 0;
    };
    constexpr int kLeastWidth = 64;                                         // smaller levels are a few KiB
    std::map<std::pair<int, std::uint64_t>, Group, std::greater<>> groups;  // by width and unread levels
    for (const AssetShare& share : shares) {
        const Json &asset = *share.asset, &textures = list(asset, "textures");
        const auto width = static_cast<int>(count(member(asset, "width")));
        if (words(member(asset, "kind")) != "cubemap" || textures.size() != 1 || width < kLeastWidth) continue;
        const auto format = formats::pixelFormatFromName(words(member(textures[0], "format")));
        if (!format) continue;
        const std::uint64_t unread = count(member(member(asset, "notes"), note_keys::kUnreadLevels));
        const std::uint64_t bytes =
            unread > 0 ? count(member(member(asset, "notes"), note_keys::kUnreadBytes)) : 6 * formats::bytesPerImage(*format, width, width);
        if (bytes >= count(member(asset, "bytes_gpu"))) continue;
        Group& group = groups[{width, unread}];
        group.cubemaps.push_back(&asset);
        group.bytes += bytes;
    }
    for (const auto& [key, group] : groups) {
        const auto& [width, unread] = key;
        const bool isOne = group.cubemaps.size() == 1;
        const std::string names =
            isOne ? nameOf(*group.cubemaps[0])
                  : fmt::format("{} cubemaps, '{}' and others", group.cubemaps.size(), words(member(*group.cubemaps[0], "name")));
        const std::string whose = isOne ? "its" : "their", saved = humanBytes(group.bytes);
        if (unread > 0)
            advice.push_back(
                fmt::format("{}: no material is smooth enough to read {} {}. size = \"auto\" leaves {} out and saves {}. The other "
                            "levels may be encoded anew; their error keeps the same limits.",
                            names, whose, unread == 1 ? "largest level" : fmt::format("{} largest levels", unread),
                            unread == 1 ? "it" : "them", saved));
        else
            advice.push_back(
                fmt::format("{}: size = {} in place of {} saves {}, {} largest {}. The error of that was not measured: cook it, "
                            "and compare with report --baseline.",
                            names, width / 2, width, saved, whose, isOne ? "level" : "levels"));
    }
}

}  // namespace

std::uint64_t bytesOutsideCharts(const Json& asset, const Json& texture) {
    const double covered = number(member(member(asset, "notes"), note_keys::kCoveredTexels));
    const double texels = number(member(asset, "width")) * number(member(asset, "height"));
    if (words(member(asset, "kind")) != "light-map" || !(covered >= 0) || !(texels > 0) || covered >= texels) return 0;
    if (words(member(texture, "role")) == kTablesRole) return 0;
    return static_cast<std::uint64_t>(static_cast<double>(count(member(texture, "bytes_gpu"))) * (1 - covered / texels));
}

std::vector<std::string> adviceOf(const Json& report) {
    std::vector<std::string> advice;
    std::vector<AssetShare> shares = sharesOf(report);
    addProportions(shares, advice);
    std::ranges::stable_sort(shares, [](const AssetShare& a, const AssetShare& b) { return a.bytes > b.bytes; });
    for (const AssetShare& share : shares) {
        addLayouts(*share.asset, advice);
        addExcluded(*share.asset, advice);
        addUnusedTexels(*share.asset, advice);
    }
    addCubemapLevels(shares, advice);
    for (std::string& sentence : advice)
        if (!sentence.empty()) sentence[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence[0])));
    return advice;
}

Html adviceSection(const Json& report) {
    const std::vector<std::string> advice = adviceOf(report);
    if (advice.empty()) return {};
    Html lines;
    for (const std::string& sentence : advice) lines += element("li", text(sentence));
    return card("What limits what", element("ul", {{"class", "advice"}}, lines));
}

}  // namespace lightcook::pipeline
