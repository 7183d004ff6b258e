// lightcook estimate: what the light maps of meshes will cost, before a bake.
#include "pipeline/estimate/estimate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <memory>

#include "atlas/pages.h"
#include "pipeline/command/command.h"
#include "pipeline/command/converter.h"
#include "pipeline/command/key_options.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/graph/cache.h"
#include "pipeline/graph/work_rates.h"
#include "pipeline/lint/judge.h"
#include "pipeline/report/words.h"
#include "pipeline/scene/lint_checks.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

/// Parts that a line or a kind of warnings names, at most.
constexpr std::size_t kMostNamed = 3;

struct EstimateCommand {
    EstimateOptions estimate;
    GivenKeys given;
    std::filesystem::path cache;
    JsonOutput json;
};

double shareOf(std::int64_t part, std::int64_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

/// Returns "1024 x 1024", or "3 x 4096 x 4096, 512 x 256".
std::string pageWords(const std::vector<EstimatedPage>& pages) {
    std::vector<std::string> words;
    for (std::size_t i = 0; i < pages.size();) {
        std::size_t end = i + 1;
        while (end < pages.size() && pages[end].width == pages[i].width && pages[end].height == pages[i].height) ++end;
        words.push_back(fmt::format("{}{} x {}", end - i > 1 ? fmt::format("{} of ", end - i) : "", pages[i].width, pages[i].height));
        i = end;
    }
    return fmt::format("{}", fmt::join(words, ", "));
}

/// Returns "0.4 s", "95 s" or "12 min".
std::string timeWords(double seconds) {
    constexpr double kMinutes = 120, kHours = 120 * 60;
    if (seconds < 10) return fmt::format("{:.1f} s", seconds);
    if (seconds < kMinutes) return fmt::format("{:.0f} s", seconds);
    return seconds < kHours ? fmt::format("{:.0f} min", seconds / 60) : fmt::format("{:.1f} h", seconds / 3600);
}

void printLayouts(Terminal& terminal, const Estimate& estimate) {
    terminal.say(fmt::format("{:<12} {:>10} {:>12} {:>10}", "layout", "bits/texel", "GPU memory", "cook time"));
    for (const EstimatedLayout& layout : estimate.layouts) {
        StyledLine line = {
            {Style::Plain, fmt::format("{:<12} {:>10.1f} {:>12} {:>9}{}", layout.layout, layout.bitsPerTexel, sizeWords(layout.bytesGpu),
                                       timeWords(layout.seconds), layout.isMeasuredHere ? " " : "*")}};
        if (layout.passed) line.push_back({*layout.passed ? Style::Good : Style::Bad, *layout.passed ? "  within the budget" : "  over"});
        terminal.say(line);
    }
    const bool isAnyElsewhere = !std::ranges::all_of(estimate.layouts, &EstimatedLayout::isMeasuredHere);
    terminal.say(fmt::format(
        "layout auto takes {}{} before that to choose{}", timeWords(estimate.trialSeconds), estimate.isTrialMeasuredHere ? "" : "*",
        isAnyElsewhere || !estimate.isTrialMeasuredHere ? "; *: as measured on a server with two cores, not yet on this machine" : ""));
}

void print(Terminal& terminal, const Estimate& estimate) {
    terminal.say(fmt::format("{}: {} ({}); {:.3g} million texels, {} read by filters, {} padding", counted(estimate.pages.size(), "page"),
                             pageWords(estimate.pages),
                             estimate.uvs == UvUse::Shared ? "the UVs of all nodes share one image" : "each node has an image of its own",
                             static_cast<double>(estimate.texels) * 1e-6, humanPercent(shareOf(estimate.readTexels, estimate.texels)),
                             humanPercent(shareOf(estimate.paddingTexels, estimate.texels))));
    std::vector<std::string> most;
    for (const EstimatedPart& part : estimate.parts) {
        if (most.size() == kMostNamed) break;
        most.push_back(fmt::format("{} ({}{})", part.name, humanPercent(shareOf(part.texels, estimate.readTexels)),
                                   part.density ? fmt::format(", {:.3g} texels a unit", *part.density) : ""));
    }
    terminal.say(fmt::format("most texels: {}", fmt::join(most, "; ")));
    printLayouts(terminal, estimate);
}

/// Calls say(part, text) for the parts with most of something, and once more for the others.
template <class Amount, class Say>
void sayOfParts(const std::vector<EstimatedPart>& parts, Amount amount, Say say) {
    std::vector<const EstimatedPart*> named;
    for (const EstimatedPart& part : parts)
        if (amount(part) > 0) named.push_back(&part);
    std::ranges::stable_sort(named, [&](const auto* a, const auto* b) { return amount(*a) > amount(*b); });
    for (std::size_t i = 0; i < named.size() && i < kMostNamed; ++i)
        say(*named[i], i + 1 == kMostNamed && named.size() > kMostNamed
                           ? fmt::format("; and {}", counted(named.size() - kMostNamed, "part") + " with fewer")
                           : std::string());
}

void warn(Terminal& terminal, const Estimate& estimate) {
    const auto overlap = [](const EstimatedPart& part) {
        return shareOf(part.sharedTexels, part.texels) > kMostShared ? part.sharedTexels : 0;
    };
    sayOfParts(estimate.parts, overlap, [&](const EstimatedPart& part, const std::string& others) {
        terminal.warning(part.name, fmt::format("found {} of its {} texels in two or more triangles, expected 0 %{}. {}",
                                                humanPercent(shareOf(part.sharedTexels, part.texels)), part.texels, others,
                                                info(LintCheck::UvOverlap).advice));
    });
    const auto small = [](const EstimatedPart& part) { return part.smallCharts; };
    sayOfParts(estimate.parts, small, [&](const EstimatedPart& part, const std::string& others) {
        terminal.note(part.name, fmt::format("found {} of {} too small for a padding of {}, which takes more texels than they do{}. Join "
                                             "them in the unwrap, or leave them out of the bake",
                                             part.smallCharts, counted(static_cast<std::uint64_t>(part.charts), "chart"),
                                             counted(static_cast<std::uint64_t>(estimate.padding), "texel"), others));
    });
    if (estimate.withoutUvs > 0)
        terminal.note(estimate.parts.front().name,
                      fmt::format("found {} without TEXCOORD_1: counted by area alone, the least that an unwrap of it takes",
                                  counted(static_cast<std::uint64_t>(estimate.withoutUvs), "surface")));
}

/// Runs the command. Returns the exit code.
int runEstimate(Session& session, EstimateCommand& command) {
    command.json.prepare(session);
    const auto settings = settingsOf(command.given);
    if (!settings) return command.json.finish(session, {}, {settings.error()});
    command.estimate.largestPage -= command.estimate.largestPage % atlas::kPageStep;
    command.estimate.target = settings->output.target;
    command.estimate.layout = formats::lightMapLayoutFromName(layoutAsked(settings->output));
    command.estimate.budgetBytes = settings->output.budgetBytes;
    const auto cache = cacheFolder(command.cache);
    if (!cache) return command.json.finish(session, {}, {cache.error()});
    command.estimate.rates = *cache / kRatesName;
    const auto estimate = estimateLightMaps(command.estimate, session.state);
    if (!estimate) return command.json.finish(session, {}, {estimate.error()});
    if (session.terminal.verbosity() != Verbosity::Quiet) print(session.terminal, *estimate);
    warn(session.terminal, *estimate);
    return command.json.finish(session, toJson(*estimate), estimate->errors);
}

}  // namespace

CommandFunction defineEstimate(CLI::App& app) {
    const auto command = std::make_shared<EstimateCommand>();
    EstimateOptions& estimate = command->estimate;
    addFilesOption(app, "meshes", estimate.meshes, "glTF files of the scene, whose TEXCOORD_1 are light-map UVs")->required();
    app.add_option("--texel-density", estimate.texelDensity, "Texels for a unit of length of the scene, such as a metre")
        ->type_name("NUMBER")
        ->check(CLI::Range(0.001, 100000.0))
        ->required();
    app.add_option("--padding", estimate.padding, "Texels between charts")->check(CLI::Range(0, 64))->capture_default_str();
    app.add_option("--largest-page", estimate.largestPage, "Largest side of a light map that the baker or the engine takes [texels]")
        ->check(CLI::Range(64, kLargestPage))
        ->capture_default_str();
    addKeyOptions(
        app, command->given,
        std::vector<KeyOption>{{"output.target"},
                               {"output.light_map_layout", "", {}, "Layout of the light maps. Default: all are listed"},
                               {"output.budget", "", {}, "GPU memory of all light maps, such as \"64 MiB\"; more is exit code 5"}});
    addCacheOption(app, command->cache, "Cache folder, which has the times of earlier cooks");
    command->json.add(app, "the estimate");
    app.footer(R"(estimate needs no bake. It takes light-map UVs as they are, and scales them to the density: one image if the
nodes share it, or an image for each node, as engines give it, packed into pages. A mesh without light-map
UVs counts by its area. Memory is that of the layouts' textures; time is that of earlier cooks on this
machine, or, marked by *, as it was measured elsewhere.

An image larger than the largest page ends with exit code 3: a baker fails there when all light is computed.
Over --budget, with every layout or with that of --layout, ends with exit code 5. Texels that two triangles
share and charts that are smaller than their padding are named with their mesh.)");
    return [command](Session& session) { return runEstimate(session, *command); };
}

}  // namespace lightcook::pipeline
