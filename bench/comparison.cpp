#include "bench/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/cpu_time.h"
#include "bench/markdown_table.h"
#include "compress/encode.h"

namespace lightcook::bench {
namespace {

using formats::PixelFormat;
using formats::Result;
using Json = nlohmann::ordered_json;
using Bytes = std::vector<std::byte>;

constexpr const char* kOurName = "lightcook";

/// An entry while one picture is measured: its best and total processor time [s], and its blocks.
struct Runner {
    ComparisonEntry* entry = nullptr;
    std::function<Result<void>(std::span<std::byte>)> encode;
    double best = std::numeric_limits<double>::infinity(), spent = 0;
    Bytes blocks;
};

std::vector<const ClassPicture*> ofClass(std::span<const ClassPicture> pictures, PictureClass pictureClass) {
    std::vector<const ClassPicture*> found;
    for (const ClassPicture& picture : pictures)
        if (picture.pictureClass == pictureClass) found.push_back(&picture);
    return found;
}

/// Runs one round of an encoder: at least once, and for about secondsRound.
Result<void> runRound(Runner& runner, double secondsRound) {
    double taken = 0;
    do {
        const double start = processSeconds();
        Result<void> status = runner.encode(runner.blocks);
        const double seconds = std::max(processSeconds() - start, 1e-9);
        if (!status) return status;
        runner.best = std::min(runner.best, seconds);
        taken += seconds;
    } while (taken < secondsRound);
    runner.spent += taken;
    return {};
}

struct PeerProfile {
    const PeerEncoder* peer;
    int profile;
};

/// Measures all entries on one picture.
/// peers  the profile of each entry after ours
Result<void> measurePicture(const ClassPicture& picture, const ComparisonOptions& options, std::span<const PeerProfile> peers,
                            Comparison& comparison) {
    const PixelFormat format = comparison.format;
    const formats::Image<glm::vec4> texels = texelsFor(picture, format);
    const int width = texels.width(), height = texels.height();
    std::map<const PeerEncoder*, PeerTexels> converted;
    std::vector<Runner> runners(comparison.entries.size());
    for (std::size_t i = 0; i < runners.size(); ++i) {
        Runner& runner = runners[i];
        runner.entry = &comparison.entries[i];
        runner.blocks.resize(formats::bytesPerImage(format, width, height));
        if (runner.entry->isOurs) {
            compress::EncodeOptions encode;
            encode.effort = options.efforts[i];
            encode.channelWeights = options.channelWeights;
            runner.encode = [format, encode, &texels](std::span<std::byte> blocks) -> Result<void> {
                compress::encodeRows(format, texels.view(), {}, encode, blocks, {});
                return {};
            };
            continue;
        }
        const auto& [peer, profile] = peers[i - options.efforts.size()];
        if (!converted.contains(peer)) {
            Result<PeerTexels> own = peer->convert(format, texels.view());
            if (!own) return tl::make_unexpected(std::move(own.error()));
            converted.emplace(peer, std::move(*own));
        }
        runner.encode = [format, peer = peer, profile = profile, &own = converted.at(peer)](std::span<std::byte> blocks) {
            return peer->encode(format, profile, own, blocks);
        };
    }
    for (int round = 0; round < options.rounds; ++round)
        for (Runner& runner : runners) {
            if (round > 0 && runner.spent > options.secondsEach) continue;
            if (Result<void> status = runRound(runner, options.secondsRound); !status) return status;
        }
    for (const Runner& runner : runners) {
        const Figures figures = measure(format, texels.view(), picture.significance.view(),
                                        decodedByVerifier(format, runner.blocks, width, height).view(), options.channelWeights);
        runner.entry->results.push_back({picture.name, 1e-6 * width * height / runner.best, figures});
    }
    return {};
}

/// Sets the means of an entry over the pictures.
void summarize(ComparisonEntry& entry, std::span<const ClassPicture* const> pictures) {
    double texels = 0, seconds = 0, db = 0;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const double size = 1e-6 * static_cast<double>(pictures[i]->texels.texels().size());
        texels += size;
        seconds += size / entry.results[i].mpixPerCpuSecond;
        db += entry.results[i].figures.psnrDb;
    }
    entry.mpixPerCpuSecond = texels / seconds;
    entry.db = db / static_cast<double>(pictures.size());
}

/// Returns the points of one encoder.
ScatterSeries seriesOf(const Comparison& comparison, const std::string& encoder) {
    ScatterSeries series{encoder, ScatterSeries::Style::Peer, {}};
    for (const ComparisonEntry& entry : comparison.entries)
        if (entry.encoder == encoder) {
            if (entry.isOurs) series.style = ScatterSeries::Style::Main;
            series.points.push_back(
                {1 / entry.mpixPerCpuSecond, entry.db, entry.profile,
                 fmt::format("{}, {} {}: {:.4g} Mpix/s, {:.3f} dB{}", encoder, entry.isOurs ? "effort" : "profile", entry.profile,
                             entry.mpixPerCpuSecond, entry.db, entry.isOnFront ? ", on the front" : "")});
        }
    return series;
}

ScatterPanel panelOf(const Comparison& comparison) {
    const formats::PixelFormatInfo& form = formats::info(comparison.format);
    ScatterPanel panel{
        fmt::format("{}, {}", form.name, info(comparison.pictureClass).name), form.isFloat ? "log2-PSNR, dB" : "PSNR, dB", {}};
    std::vector<std::string> names;
    for (const ComparisonEntry& entry : comparison.entries)
        if (std::find(names.begin(), names.end(), entry.encoder) == names.end()) names.push_back(entry.encoder);
    for (const std::string& name : names) panel.series.push_back(seriesOf(comparison, name));
    ScatterSeries front{"Pareto front", ScatterSeries::Style::Front, {}};
    for (const ComparisonEntry& entry : comparison.entries)
        if (entry.isOnFront) front.points.push_back({1 / entry.mpixPerCpuSecond, entry.db, "", ""});
    std::sort(front.points.begin(), front.points.end(),
              [](const ScatterPoint& a, const ScatterPoint& b) { return a.secondsPerMpix < b.secondsPerMpix; });
    panel.series.push_back(std::move(front));
    return panel;
}

Json toJson(const ComparisonEntry& entry) {
    Json json = {{"encoder", entry.encoder}, {"profile", entry.profile},    {"mpix_per_cpu_s", entry.mpixPerCpuSecond},
                 {"psnr_db", entry.db},      {"on_front", entry.isOnFront}, {"pictures", Json::array()}};
    for (const ComparisonResult& result : entry.results)
        json["pictures"].push_back({{"name", result.picture},
                                    {"mpix_per_cpu_s", result.mpixPerCpuSecond},
                                    {"psnr_db", result.figures.psnrDb},
                                    {"rel_rmse", result.figures.relRmse},
                                    {"p99_relative", result.figures.p99Relative}});
    return json;
}

}  // namespace

void markFront(std::vector<ComparisonEntry>& entries) {
    for (ComparisonEntry& entry : entries)
        entry.isOnFront = std::none_of(entries.begin(), entries.end(), [&](const ComparisonEntry& other) {
            return other.mpixPerCpuSecond >= entry.mpixPerCpuSecond && other.db >= entry.db &&
                   (other.mpixPerCpuSecond > entry.mpixPerCpuSecond || other.db > entry.db);
        });
}

Result<std::vector<Comparison>> compareEncoders(PixelFormat format, std::span<const PeerEncoder> peers,
                                                std::span<const ClassPicture> pictures, const ComparisonOptions& options) {
    const bool isWeighted = options.channelWeights != ComparisonOptions().channelWeights;
    if (isWeighted && formats::info(format).channelCount < 3) return std::vector<Comparison>();
    std::vector<ComparisonEntry> entries;
    for (const int effort : options.efforts) entries.push_back({kOurName, std::to_string(effort), true, {}});
    std::vector<PeerProfile> profiles;
    for (const PeerEncoder& peer : peers) {
        const std::vector<std::string> names = peer.profiles(format);
        for (std::size_t i = 0; i < names.size(); ++i) {
            entries.push_back({peer.name(), names[i], false, {}});
            profiles.push_back({&peer, static_cast<int>(i)});
        }
    }
    std::vector<Comparison> comparisons;
    if (profiles.empty()) return comparisons;
    for (const PictureClassInfo& each : allPictureClasses()) {
        const std::vector<const ClassPicture*> suited = ofClass(pictures, each.pictureClass);
        if (suited.empty() || !suits(each.content, format)) continue;
        Comparison comparison{format, each.pictureClass, entries};
        for (const ClassPicture* picture : suited)
            if (const Result<void> status = measurePicture(*picture, options, profiles, comparison); !status)
                return tl::make_unexpected(status.error());
        for (ComparisonEntry& entry : comparison.entries) summarize(entry, suited);
        markFront(comparison.entries);
        comparisons.push_back(std::move(comparison));
    }
    return comparisons;
}

std::string comparisonPage(std::span<const Comparison> comparisons, std::span<const ClassPicture> pictures) {
    std::vector<ScatterPanel> panels;
    for (const Comparison& comparison : comparisons) panels.push_back(panelOf(comparison));
    std::vector<std::string> notes = {
        "Further up is better, further left is faster. Numbers at our points are efforts, names at the others profiles. "
        "Rings mark the Pareto front: no other setting is as fast and as good.",
        "All encoders ran in one process on the same pixels, in turn; the time is the least processor time of the rounds, one thread. "
        "Decoding for the error is by the verifier's own decoders.",
        "Float formats: 20 log10(1 / rms(log2(1+x') - log2(1+x))). Others: PSNR, against texels rounded to bytes. Texels outside charts "
        "repeat their nearest neighbour inside, and do not count."};
    for (const PictureClassInfo& each : allPictureClasses()) {
        std::string names;
        for (const ClassPicture* picture : ofClass(pictures, each.pictureClass)) names += (names.empty() ? "" : ", ") + picture->name;
        if (!names.empty()) notes.push_back(fmt::format("Pictures, {}: {}.", each.name, names));
    }
    return scatterPage("Block encoders beside others: run time against error", notes, panels);
}

std::string comparisonJson(std::span<const Comparison> comparisons) {
    Json json = Json::array();
    for (const Comparison& comparison : comparisons) {
        Json entries = Json::array();
        for (const ComparisonEntry& entry : comparison.entries) entries.push_back(toJson(entry));
        json.push_back({{"format", formats::info(comparison.format).name},
                        {"class", info(comparison.pictureClass).name},
                        {"encoders", std::move(entries)}});
    }
    return json.dump(1) + "\n";
}

void printComparison(const Comparison& comparison) {
    fmt::print("\n{}, {}\n\n", formats::info(comparison.format).name, info(comparison.pictureClass).name);
    printTableHead({"encoder", "profile", ">Mpix/s", ">dB", "front"});
    for (const ComparisonEntry& entry : comparison.entries)
        printTableRow("{} | {} | {:.4g} | {:.3f} | {}", entry.encoder, entry.profile, entry.mpixPerCpuSecond, entry.db,
                      entry.isOnFront ? "yes" : "");
}

}  // namespace lightcook::bench
