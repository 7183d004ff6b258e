#include "pipeline/lint/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "formats/bake_format.h"
#include "formats/light_map_conventions.h"
#include "formats/light_map_layout.h"
#include "formats/lmbake.h"
#include "formats/nearest.h"
#include "formats/vocabulary.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

// Thresholds, each with its reason. A warning needs a proof: what was found contradicts the scene, or no light and no surface has it, and
// what rounding, noise and filters of bakers do is below the threshold; light_map_facts.cpp has the tolerances of a texel. What may be
// right as it is is a note, and its threshold a figure of when to speak. docs/lab/pipeline.md has those of the public scenes.

/// Share of texels that may be lit from behind, or break the inequalities of the bands. None of a right bake does beyond the tolerances of
/// a texel; filters that mix texels across edges leave a few, and a wrong convention 6 % or more.
constexpr double kMostBehind = 0.005, kMostImpossible = 0.005;
/// The same of bands that no other reading of the file explains: noise of 5 % in each coefficient alone makes 2.6 %, another order of the
/// coefficients 30 % and more.
constexpr double kMostUnexplained = 0.05;
/// Share of lit texels whose band 1 may be longer than that of any light: none of a right bake. Directions that are not packed, or a white
/// picture, make nearly all of them longer.
constexpr double kMostTooDirected = 0.5;
/// A reading of the file explains a fault if it leaves at most this part of it. On the public scenes the right one leaves nothing, and of a
/// right bake every other one makes more of it.
constexpr double kExplained = 0.1;
/// Note: texels in black charts, a share of the covered ones and a number. Closed rooms are black and right.
constexpr double kMostBlack = 0.001;
constexpr std::int64_t kMostBlackTexels = 64;
/// Share of covered texels that may lack a normal: where channels of one file contradict each other, less than the rim of a chart.
constexpr double kMostWithoutNormal = 0.001;
/// Note: share of covered texels whose normal is far from unit length. A normal between those of vertices is shorter, and right.
constexpr double kMostOddNormals = 0.05;
/// Share of the normals that are no unit vectors, and would be as colours. Each is a contradiction; the rest is compressed or filtered.
constexpr double kEncodedNormals = 0.9;
/// Coverage beyond [0, 1]. Resampling with a Lanczos filter rings by 0.1 either way, in two directions by 0.21; samples that are counted or
/// 8 bits reach 2 or more.
constexpr double kMostCoverage = 1.25, kLeastCoverage = -0.25;
/// Note: shares of a probe's texels with a channel of exactly 1, its largest value: more than a highlight, and less than a painted image.
constexpr double kLeastClipped = 0.001, kMostClipped = 0.9;
/// Note: light that halves hold with their usual precision four octaves down and one up. A unit may be smaller or larger, and right.
constexpr double kDarkestKey = 1e-4, kBrightestKey = 3e4;
/// Shares of the texels that a mesh reads.
constexpr double kMostUncovered = 0.005;
/// Shares of the texels with light that the mesh may leave unread, and of the texels that it reads without light, in a map whose other UVs
/// explain these; and a number of texels, for maps of few.
constexpr double kMostUnread = 0.01, kMostUnfit = 0.01;
constexpr std::int64_t kMostUnreadTexels = 64;
/// Share of the light-map UV area that may lie on triangles without area in the world: slivers.
constexpr double kMostFlat = 0.5;
/// Note: time by which a mesh is newer. Copies and checkouts write the files of a scene in any order, and edits of materials too.
constexpr double kNewerHours = 1;
/// Note: difference of a probe's image and its SH. A sun that the image holds clipped, or between its texels, makes as much.
constexpr double kMostShDifference = 0.1;
/// Note: ratio of the mean radiances of light map and probes, either way, that scenes have. Rooms and probes elsewhere may differ by more.
constexpr double kUnitsRatio = 1.9;

/// Median ratio of traced light to that of its light map, either way. Of irradiance it lies in [0.68, 1.14] whatever the light
/// (verify::tracedRatio), and noise of a median is below the rest. Of highlights alone no bound is known, only that units differ by more.
constexpr double kTracedRatio = 1.5, kTracedSpecularRatio = 20;

double share(std::int64_t part, std::int64_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

std::string percent(double value) {
    return fmt::format("{:.1f} %", 100 * value);
}

/// Returns a finding with the severity and the advice of its check.
Finding makeFinding(LintCheck check, const std::string& asset, const std::filesystem::path& file, ScenePlace place, std::string found,
                    std::map<std::string, double> figures) {
    Finding finding;
    finding.check = check;
    finding.asset = asset;
    finding.severity = info(check).severity;
    finding.file = file.string();
    finding.found = std::move(found);
    finding.figures = std::move(figures);
    finding.advice = info(check).advice;
    finding.place = std::move(place);
    return finding;
}

std::string rangeText(const std::array<double, 2>& range) {
    return range[0] == range[1] ? fmt::format("{:.3g}", range[0]) : fmt::format("{:.3g} to {:.3g}", range[0], range[1]);
}

/// Returns the assumptions for a material with extensions that are not read, without those that the scene file replaces.
std::vector<std::string> assumptionsOf(const UnreadMaterial& material, const std::vector<MaterialEntry>& entries) {
    MaterialEntry stated;
    for (const MaterialEntry& entry : entries) {
        if (entry.name != "*" && entry.name != material.name) continue;
        if (entry.specular) stated.specular = entry.specular;
        if (entry.m) stated.m = entry.m;
        if (entry.f0) stated.f0 = entry.f0;
    }
    std::vector<std::string> assumed;
    if (stated.specular.value_or(material.isSpecular)) {
        if (!stated.m) assumed.push_back("m = " + rangeText(material.m));
        if (!stated.f0) assumed.push_back("f0 = " + rangeText(material.f0));
    } else if (!stated.specular) {
        assumed.emplace_back("no specular light");
    }
    return assumed;
}

/// Returns what was found if light is too dark or too bright for 16-bit textures and screens: the rule of light maps and probes.
/// light  of a white surface, on average
/// mean   how the average was taken
std::optional<std::string> unusualExposure(std::string_view quantity, double light, std::string_view mean) {
    if (light >= kDarkestKey && light <= kBrightestKey) return {};
    return fmt::format("found {} of {:.3g} on average ({}), expected {} to {}", quantity, light, mean, kDarkestKey, kBrightestKey);
}

/// Findings of one light map, from which `file` and the first part of `key` are the same.
class LightMapJudge {
public:
    LightMapJudge(const Scene& scene, const LightMapEntry& entry, const LightMapFacts& facts)
        : scene_(scene), entry_(entry), facts_(facts) {}

    Findings judge() {
        for (const std::string& set : facts_.reading.incompleteSets)
            add(LintCheck::IncompleteSet, "file", fmt::format("{}; read as {}", set, facts_.reading.bake), {});
        judgeCoverage();
        if (facts_.covered > 0) {
            if (!hasEncodedNormals() && !judgeDirections()) judgeBands();
            judgeLight();
        }
        return std::move(findings_);
    }

private:
    void add(LintCheck check, const char* key, std::string found, std::map<std::string, double> figures) {
        findings_.push_back(
            makeFinding(check, entry_.name, entry_.file, {"light_map", entry_.name, key}, std::move(found), std::move(figures)));
    }

    void judgeCoverage() {
        if (facts_.hasCoverage && facts_.coverage.inside == 0)
            return add(LintCheck::NoCoverage, "file",
                       fmt::format("found coverage of at most {:.3g} in {} x {} texels, expected more than 0.5 inside charts",
                                   facts_.coverage.largest, facts_.width, facts_.height),
                       {{"largest_coverage", facts_.coverage.largest}});
        if (facts_.coverage.smallest < kLeastCoverage || facts_.coverage.largest > kMostCoverage)
            add(LintCheck::CoverageRange, "file",
                fmt::format("found coverage from {:.3g} to {:.3g}, expected 0 (outside charts) to 1 (inside)", facts_.coverage.smallest,
                            facts_.coverage.largest),
                {{"smallest_coverage", facts_.coverage.smallest}, {"largest_coverage", facts_.coverage.largest}});
        const double withoutNormal = share(facts_.coverage.withoutNormal, facts_.coverage.inside);
        if (facts_.hasNormals)
            judgeNormals(withoutNormal);
        else if (facts_.directional > 0 && mayBeFittedToNormals())
            add(LintCheck::MissingNormals, "mesh",
                fmt::format("found no normals, and light with a direction in {} of {} texels, expected a mesh or channels normal.X/Y/Z for "
                            "a layout that is fitted to the hemisphere of each",
                            facts_.directional, facts_.covered),
                {{"directional", static_cast<double>(facts_.directional)}});
        const double gaps = share(facts_.coverage.withoutNormal + facts_.black, facts_.coverage.inside);
        if (facts_.hasCoverage || facts_.covered == 0 || gaps <= kMostGapsWithoutCoverage) return;
        const std::string taken = facts_.hasNormals ? "; those with a normal count as covered" : "; all count as covered";
        add(LintCheck::MissingCoverage, "file",
            fmt::format("found no channel coverage.Y, and neither light nor normal in {} of {} texels{}", percent(gaps),
                        facts_.coverage.inside, taken),
            {{"gaps", gaps}});
    }

    /// Returns true if most normals n are stored as (n + 1) / 2. Some of these are shorter than 1/2, and count as none too.
    bool hasEncodedNormals() const {
        const auto normals = static_cast<double>(facts_.coverage.inside - facts_.coverage.withoutNormal);
        return facts_.coverage.encodedNormals > 0 && static_cast<double>(facts_.coverage.encodedNormals) >= kEncodedNormals * normals;
    }

    void judgeNormals(double withoutNormal) {
        if (hasEncodedNormals()) {
            const double encoded = share(facts_.coverage.encodedNormals, facts_.coverage.inside);
            return add(
                LintCheck::EncodedNormals, "file",
                fmt::format("found normals n of which 2 n - 1 has unit length in {} of {} texels inside charts, expected unit normals",
                            percent(encoded), facts_.coverage.inside),
                {{"share", encoded}});
        }
        // Normals that count as none have a check of their own.
        const std::int64_t normals = facts_.coverage.inside - facts_.coverage.withoutNormal;
        const double odd = share(facts_.coverage.oddNormals - facts_.coverage.withoutNormal, normals);
        if (odd > kMostOddNormals)
            add(LintCheck::NormalLength, "file",
                fmt::format("found normals far from unit length in {} of {} texels inside charts, expected unit normals", percent(odd),
                            normals),
                {{"share", odd}});
        if (withoutNormal == 1)
            add(LintCheck::ZeroNormals, "file",
                fmt::format("found a normal of zero, or shorter than 1/2, in all {} texels inside charts, expected unit normals",
                            facts_.coverage.inside),
                {{"share", withoutNormal}});
        else if (facts_.hasCoverage && withoutNormal > kMostWithoutNormal)
            add(LintCheck::SomeZeroNormals, "file",
                fmt::format("found a normal of zero, or shorter than 1/2, in {} of {} texels inside charts, expected unit normals",
                            percent(withoutNormal), facts_.coverage.inside),
                {{"share", withoutNormal}});
    }

    /// Returns the choice of axes that leaves the fewest texels lit from behind. Of equal ones, as of a map of floors alone: that of the
    /// file; or a rotation, as of a baker that is Z up, rather than a reflection, and x rather than -x.
    int bestAxes() const {
        const auto rank = [&](int choice) {
            const auto axes = formats::BakeAxes::choice(choice);
            return std::tuple(facts_.behind[static_cast<std::size_t>(choice)], choice != 0, !axes.isRotation(),
                              axes.name().starts_with('-'));
        };
        int best = 0;
        for (int choice = 1; choice < formats::BakeAxes::kChoices; ++choice)
            if (rank(choice) < rank(best)) best = choice;
        return best;
    }

    /// Returns true if light comes from behind.
    bool judgeDirections() {
        const auto behind = [&](std::size_t choice) { return share(facts_.behind[choice], facts_.directional); };
        const double found = behind(0), otherFrame = share(facts_.behindInOtherFrame, facts_.directional);
        if (found <= kMostBehind) return false;
        const double explained = std::max(kMostBehind, kExplained * found);
        const std::string what =
            fmt::format("found {} of {} texels lit from behind their normal, expected 0 %", percent(found), facts_.directional);
        // A convention that the bake format implies cannot be written into the scene.
        const formats::BakeConventions implied = impliedByFormat();
        const double otherPhase = behind(formats::BakeAxes::kPhaseChoice);
        const int best = bestAxes();
        const double leftByAxes = behind(static_cast<std::size_t>(best));
        const auto choice = formats::BakeAxes::choice(best);
        // The scene file turned the axes of the file already. It turns normals of the file too, and with them the fault.
        const std::string axes = facts_.hasMeshNormals ? fmt::format("axes = \"{}\"", entry_.description.axes.then(choice).name())
                                                       : fmt::format("({}) of the coefficients as x, y, z", choice.name());
        const auto with = [&](LintCheck check, const char* key, const std::string& reading, double left) {
            add(check, key, fmt::format("{}; {} it is {}", what, reading, percent(left)), {{"behind", found}, {"behind_otherwise", left}});
        };
        if (!implied.phase && otherPhase <= std::min(explained, otherFrame)) {
            const bool isNone = entry_.description.phase == formats::ShPhase::None;
            with(LintCheck::WrongPhase, "phase", fmt::format("with phase = \"{}\"", isNone ? "condon-shortley" : "none"), otherPhase);
        } else if (!implied.frame && otherFrame <= explained) {
            const bool isWorld = entry_.description.frame == formats::ShFrame::World;
            std::string reading = fmt::format("with frame = \"{}\"", isWorld ? "tangent" : "world");
            // Surfaces that all face up, of a baker that is Z up.
            if (takesAxes() && leftByAxes <= otherFrame) reading += fmt::format(", or with {},", axes);
            with(LintCheck::WrongFrame, "frame", reading, otherFrame);
        } else if (!takesAxes()) {
            add(LintCheck::LitFromBehind, "file", what, {{"behind", found}});
        } else if (leftByAxes <= explained) {
            with(LintCheck::WrongAxes, facts_.hasMeshNormals ? "axes" : "file", "with " + axes, leftByAxes);
        } else if (entry_.description.axes.then(choice).name() == entry_.description.axes.name()) {
            add(LintCheck::LitFromBehind, "file", what + "; no other axes leave less", {{"behind", found}});
        } else {
            with(LintCheck::LitFromBehind, "file", fmt::format("with {}, the best choice,", axes), leftByAxes);
        }
        return true;
    }

    /// Returns true if the map may get the layout of an engine, whose two bands are fitted to the light of the hemisphere about the normal.
    bool mayBeFittedToNormals() const {
        const auto isForEngine = [](const std::string& name) {
            const auto layout = formats::lightMapLayoutFromName(name);
            return layout && formats::info(*layout).isForEngine;
        };
        return isForEngine(layoutAsked(scene_.output)) || std::ranges::any_of(layoutsFor(scene_.output, entry_), isForEngine);
    }

    const formats::BakeFormatInfo* format() const { return formats::findByName(formats::allBakeFormats(), facts_.reading.bake); }
    formats::BakeConventions impliedByFormat() const { return format() == nullptr ? formats::BakeConventions{} : format()->implied; }
    bool takesAxes() const { return format() == nullptr || format()->takesAxes; }

    /// Returns false for a bake format whose light is a formula of an engine: its bands are fitted to that formula, and need not be those
    /// of any light.
    bool holdsBandsOfLight() const { return !impliedByFormat().quantity; }

    /// Looks for a map of which most has more directed light than there is.
    void judgeLengths() {
        const std::int64_t lit = facts_.covered - facts_.black;
        const double found = share(facts_.tooDirected, lit);
        if (found <= kMostTooDirected) return;
        add(LintCheck::ImpossibleDirections, "file",
            fmt::format("found a band 1 longer than that of light from a single direction in {} of {} lit texels, expected 0 %",
                        percent(found), lit),
            {{"impossible", found}});
    }

    void judgeBands() {
        if (!holdsBandsOfLight()) return judgeLengths();
        const BandFacts& bands = facts_.bands;
        const double found = share(bands.asDescribed, bands.texels);
        if (found <= kMostImpossible) return judgeLengths();
        const double otherQuantity = share(bands.otherQuantity, bands.texels), decoded = share(bands.decoded, bands.texels);
        const double explained = std::max(kMostImpossible, kExplained * found);
        const std::string what = fmt::format("found bands 1 and 2 that no light of a hemisphere has in {} of {} texels, expected 0 %",
                                             percent(found), bands.texels);
        if (std::min(otherQuantity, decoded) > explained) {
            if (found <= kMostUnexplained) return judgeLengths();
            add(LintCheck::ImpossibleBands, "file", what, {{"impossible", found}});
        } else if (otherQuantity <= decoded) {
            const bool isRadiance = entry_.description.quantity == formats::ShQuantity::Radiance;
            add(LintCheck::WrongQuantity, "quantity",
                fmt::format("{}; with quantity = \"{}\" it is {}", what, isRadiance ? "irradiance" : "radiance", percent(otherQuantity)),
                {{"impossible", found}, {"impossible_otherwise", otherQuantity}});
        } else {
            add(LintCheck::GammaCurve, "file", fmt::format("{}; with a curve of 2.2 undone it is {}", what, percent(decoded)),
                {{"impossible", found}, {"impossible_otherwise", decoded}});
        }
    }

    void judgeLight() {
        const ChartFacts& charts = facts_.charts;
        if (charts.rimFireflies > 0)
            add(LintCheck::RimFirefly, "firefly_limit",
                fmt::format(
                    "found {} texels at rims of charts above {} times their brightest neighbour, the brightest at ({}, {}) with {:.4g} "
                    "beside {:.4g}, expected none",
                    charts.rimFireflies, entry_.description.fireflyLimit, charts.worst.x, charts.worst.y, charts.worst.light,
                    charts.worst.brightest),
                {{"fireflies", static_cast<double>(charts.rimFireflies)},
                 {"light", charts.worst.light},
                 {"brightest_neighbour", charts.worst.brightest}});
        const double black = share(charts.blackTexels, facts_.covered);
        if (black > kMostBlack && charts.blackTexels > kMostBlackTexels)
            add(LintCheck::BlackCharts, "file",
                fmt::format("found {} of {} charts without any light, with {} of the covered texels, expected none", charts.blackCharts,
                            charts.charts, percent(black)),
                {{"black_charts", static_cast<double>(charts.blackCharts)}, {"black_share", black}});
        const bool isAllBlack = facts_.black == facts_.covered;
        // Another fault explains a strange average.
        if (findings_.empty() && !isAllBlack)
            if (auto found = unusualExposure("an exit radiance", facts_.key, "log-average of a white surface"))
                add(LintCheck::Exposure, "file", std::move(*found), {{"key", facts_.key}});
        if (findings_.empty() && !isAllBlack) judgeDisplay();
    }

    /// Compares grey of the map's key with black, as the display of the scene file shows both. If they differ by less than the limit on
    /// visible errors, black in place of the map would keep it.
    void judgeDisplay() {
        const lighting::DisplaySettings& settings = scene_.display;
        if (!settings.white && settings.stops == 0) return;
        const lighting::Display display = settings.of(facts_.key);
        const double nits = facts_.key * display.nitsPerUnit;
        const double limit = visibleLimit(scene_.output, entry_).value_or(1);
        const bool isBlack = lighting::visibleDifference(glm::dvec3(facts_.key), glm::dvec3(0), display) < std::max(limit, 1.0);
        if (!isBlack && nits <= lighting::kMostNits) return;
        findings_.push_back(
            makeFinding(LintCheck::DisplayExposure, entry_.name, scene_.file, {"display", "", settings.white ? "white" : "stops"},
                        fmt::format("found an average of light map '{}' shown at {:.3g} cd/m^2, expected {}", entry_.name, nits,
                                    isBlack ? fmt::format("light that is visible beside a black of {} cd/m^2{}", settings.black,
                                                          limit > 1 ? fmt::format(", by more than the limit of {:.3g}", limit) : "")
                                            : fmt::format("at most {} cd/m^2", lighting::kMostNits)),
                        {{"luminance", nits}}));
    }

    const Scene& scene_;
    const LightMapEntry& entry_;
    const LightMapFacts& facts_;
    Findings findings_;
};

}  // namespace

Findings judgeLightMap(const Scene& scene, const LightMapEntry& entry, const LightMapFacts& facts) {
    return LightMapJudge(scene, entry, facts).judge();
}

namespace {

/// Texels of a mesh and of its map that do not fit.
std::int64_t faultsOf(const MapMatch& match) {
    return match.unread + match.empty;
}

/// Returns the first change of the UVs that leaves a tenth of the texels that do not fit; null if none does, or if there are few.
const OtherUvs* explanationOf(const MeshFacts& facts) {
    const std::int64_t faults = faultsOf(facts.match);
    if (faults <= kMostUnreadTexels || share(faults, facts.match.read) <= kMostUnfit) return nullptr;
    const auto explains = [&](const OtherUvs& other) {
        return other.match.read > 0 && static_cast<double>(faultsOf(other.match)) <= kExplained * static_cast<double>(faults);
    };
    const auto found = std::ranges::find_if(facts.others, explains);
    return found == facts.others.end() ? nullptr : &*found;
}

/// Returns the finding of a mesh that reads other texels than those of its map that hold light; nothing if it does not.
/// isWholeMap  nothing else reads the map
std::optional<Finding> judgeFit(const LightMapEntry& entry, const MeshFacts& facts, bool isWholeMap) {
    const MapMatch& match = facts.match;
    if (match.read == 0) return std::nullopt;  // all UVs lie outside [0, 1]
    const bool isUnread = isWholeMap && match.unread > kMostUnreadTexels && share(match.unread, match.marked) > kMostUnread;
    const OtherUvs* const explanation = explanationOf(facts);
    // Texels without light are shadows, unless the same mesh at another place has none, or UVs that lie outside the map come into it.
    const bool isMoved = explanation != nullptr && (explanation->keepsArea || facts.outside > 0);
    if (!isUnread && !isMoved) return std::nullopt;
    const auto shares = [](const MapMatch& each) { return std::pair(share(each.unread, each.marked), share(each.empty, each.read)); };
    const auto [unread, empty] = shares(match);
    std::string found = fmt::format(
        "found {} of the {} texels of {} with light or coverage outside the mesh and a margin of {} texels, and neither in {} of the {} "
        "texels that the mesh reads, expected 0 %",
        percent(unread), match.marked, entry.file.filename().string(), match.margin, percent(empty), match.read);
    std::map<std::string, double> figures = {{"unread", unread}, {"empty", empty}};
    if (explanation != nullptr) {
        const auto [unreadThen, emptyThen] = shares(explanation->match);
        found += fmt::format("; with {} it is {} and {}", explanation->change, percent(unreadThen), percent(emptyThen));
        figures["unread_otherwise"] = unreadThen;
        figures["empty_otherwise"] = emptyThen;
    }
    const bool isFlipped = explanation != nullptr && explanation->change == kFlippedV;
    return makeFinding(isFlipped ? LintCheck::FlippedV : LintCheck::WrongMesh, entry.name, *entry.mesh, {"light_map", entry.name, "mesh"},
                       std::move(found), std::move(figures));
}

}  // namespace

Findings judgeMesh(const LightMapEntry& entry, const MeshFacts& facts, bool isWholeMap) {
    Findings findings;
    const auto add = [&](LintCheck check, std::string found, std::map<std::string, double> figures) {
        findings.push_back(
            makeFinding(check, entry.name, *entry.mesh, {"light_map", entry.name, "mesh"}, std::move(found), std::move(figures)));
    };
    const double outside = share(facts.outside, facts.vertices), uncovered = share(facts.uncovered, facts.read);
    const double flipped = share(facts.uncoveredIfFlipped, facts.read), shared = share(facts.shared, facts.read);
    auto fault = judgeFit(entry, facts, isWholeMap);
    // UVs that a change brings into the map need no unwrapping.
    const bool isExplained = fault && explanationOf(facts) != nullptr;
    if (outside > 0 && !isExplained)
        add(LintCheck::UvOutside,
            fmt::format("found {} of {} vertices with TEXCOORD_1 outside [0, 1], expected none", facts.outside, facts.vertices),
            {{"share", outside}});
    if (uncovered > kMostUncovered) {
        const std::string what = fmt::format("found {} of the {} texels that the mesh reads outside the charts of {}, expected 0 %",
                                             percent(uncovered), facts.read, entry.file.filename().string());
        const std::map<std::string, double> figures = {{"uncovered", uncovered}, {"uncovered_if_flipped", flipped}};
        const OtherUvs* const explanation = explanationOf(facts);
        if (flipped <= std::max(kMostUncovered, kExplained * uncovered))
            add(LintCheck::FlippedV, fmt::format("{}; with V upside down it is {}", what, percent(flipped)), figures);
        else if (explanation != nullptr)
            add(LintCheck::WrongMesh,
                fmt::format("{}; with {} it is {}", what, explanation->change,
                            percent(share(explanation->match.empty, explanation->match.read))),
                figures);
        else
            add(LintCheck::WrongMesh, what, figures);
    } else if (fault) {
        findings.push_back(std::move(*fault));
    }
    if (shared > kMostShared)
        add(LintCheck::UvOverlap,
            fmt::format("found {} of the {} texels that the mesh reads in two or more triangles, expected 0 %", percent(shared),
                        facts.read),
            {{"shared", shared}});
    if (facts.mostDrawn > 1)
        add(LintCheck::DrawnTwice, fmt::format("found a mesh that is drawn {} times, expected once", facts.mostDrawn),
            {{"nodes", static_cast<double>(facts.mostDrawn)}});
    const double flat = facts.uvArea > 0 ? facts.flatUvArea / facts.uvArea : 0;
    if (flat > kMostFlat)
        add(LintCheck::FlatTriangles,
            fmt::format("found {} of the area of light-map UVs on triangles without area in the world, expected 0 %", percent(flat)),
            {{"share", flat}});
    else if (const double lacking = share(facts.withoutNormal, facts.vertices); lacking > kMostWithoutNormal)
        add(LintCheck::MeshNormals,
            fmt::format("found a normal of zero, or shorter than 1/2, at {} of {} vertices, expected unit normals", percent(lacking),
                        facts.vertices),
            {{"share", lacking}});
    return findings;
}

Findings judgeLmbake(const LightMapEntry& entry, const MeshFacts& facts) {
    Findings findings;
    const auto add = [&](LintCheck check, const std::vector<std::string>& names, std::string_view what, const char* expected) {
        if (names.empty()) return;
        findings.push_back(makeFinding(check, entry.name, entry.description.lmbake, {"light_map", entry.name, "lmbake"},
                                       fmt::format("found {}; expected {}", countOfNames(names, what), expected),
                                       {{"count", static_cast<double>(names.size())}}));
    };
    const std::string mesh = entry.mesh->filename().string();
    add(LintCheck::UnplacedNodes, facts.unplaced, fmt::format("node(s) of {} without a rectangle", mesh),
        "one for each that has TEXCOORD_1");
    add(LintCheck::UnreadRectangles, facts.unread, fmt::format("rectangle(s) without a node of {}", mesh), "a node for each");
    return findings;
}

bool fits(const LightMapEntry& entry, const MeshFacts& facts, bool isWholeMap) {
    return judgeMesh(entry, facts, isWholeMap).empty() && explanationOf(facts) == nullptr;
}

Findings judgeGodot(const LightMapEntry& entry, bool isFitting) {
    const formats::LightMapDescription& description = entry.description;
    if (!description.parts.empty() || !description.lmbake.empty() || description.hasNoLmbake || !description.places.empty()) return {};
    const std::filesystem::path missing = formats::lmbakeOfImport(entry.file), split = formats::lmbakeOfSplitBake(entry.file);
    if (split.empty() && (missing.empty() || isFitting)) return {};
    const std::string found =
        split.empty() ? fmt::format("found a map that Godot imports as slices (2d_array_texture), without {}", missing.filename().string())
                      : fmt::format("found one of the files that Godot split a bake into, whose slices {} counts through all of them",
                                    split.filename().string());
    return {makeFinding(LintCheck::NoLmbake, entry.name, entry.file, {"light_map", entry.name, "file"},
                        fmt::format("{}, expected the rectangles of the nodes of {} in this map", found, entry.mesh->filename().string()),
                        {})};
}

Findings judgePlaces(const LightMapEntry& entry, const std::vector<std::string>& nodes) {
    if (nodes.empty()) return {};
    return {makeFinding(LintCheck::NodesWithoutMap, entry.name, *entry.mesh, {"light_map", entry.name, "place"},
                        fmt::format("found {}, expected one for each that has TEXCOORD_1", countOfNames(nodes, "node(s) without a place")),
                        {{"count", static_cast<double>(nodes.size())}})};
}

Findings judgePrimaries(const std::string& asset, const std::filesystem::path& file, const std::string& source,
                        const std::optional<formats::StatedPrimaries>& primaries) {
    if (source == formats::kStatedSource || !primaries || primaries->difference <= formats::kSamePrimaries) return {};
    const auto& [xy, space, difference] = *primaries;
    return {makeFinding(
        LintCheck::WrongPrimaries, asset, file, {"color", "", "source"},
        fmt::format("found the primaries ({:.4g}, {:.4g}), ({:.4g}, {:.4g}), ({:.4g}, {:.4g}) and white ({:.4g}, {:.4g}){}, expected "
                    "those of the source space {}",
                    xy[0], xy[1], xy[2], xy[3], xy[4], xy[5], xy[6], xy[7], space.empty() ? "" : fmt::format(", as {} has", space), source),
        {{"difference", difference}})};
}

Findings judgeProbe(const ProbeEntry& entry, const ProbeFacts& facts) {
    const auto finding = [&](LintCheck check, const char* key, std::string found, std::map<std::string, double> figures) {
        return Findings{makeFinding(check, entry.name, entry.file, {"probe", entry.name, key}, std::move(found), std::move(figures))};
    };
    if (facts.largest == 0) return finding(LintCheck::BlackProbe, "file", "found no light in the whole image, expected some", {});
    if (facts.isEightBit)
        return finding(LintCheck::EightBitProbe, "file",
                       fmt::format("found only 256 levels and values up to {:.3g}, expected radiance without a bound", facts.largest),
                       {{"largest", facts.largest}});
    if (facts.largest == 1 && facts.atLargest >= kLeastClipped && facts.atLargest <= kMostClipped)
        return finding(
            LintCheck::ClippedProbe, "file",
            fmt::format("found a largest value of 1, in {} of the texels, expected radiance without a bound", percent(facts.atLargest)),
            {{"share", facts.atLargest}});
    if (!facts.shDifference || *facts.shDifference <= kMostShDifference) {
        // Another fault explains a strange average.
        if (auto found = unusualExposure("a radiance", facts.meanRadiance, "mean over the sphere"))
            return finding(LintCheck::Exposure, "file", std::move(*found), {{"mean_radiance", facts.meanRadiance}});
        return {};
    }
    const double decoded = facts.shDifferenceDecoded.value_or(HUGE_VAL);
    const std::string what =
        fmt::format("found SH of the image that differ from those of {} by {}, expected at most {}",
                    entry.sh.value_or("").filename().string(), percent(*facts.shDifference), percent(kMostShDifference));
    if (decoded <= kMostShDifference)
        return finding(LintCheck::GammaCurve, "file", fmt::format("{}; with a curve of 2.2 undone it is {}", what, percent(decoded)),
                       {{"difference", *facts.shDifference}, {"difference_otherwise", decoded}});
    return finding(LintCheck::ProbeSh, "sh", what, {{"difference", *facts.shDifference}});
}

Findings judgeGradient(const GradientEntry& entry, const GradientFacts& facts) {
    if (facts.largest > 0) return {};
    return {makeFinding(LintCheck::BlackGradient, entry.name, entry.file, {"gradient", entry.name, "file"},
                        "found no light in the whole gradient, expected some", {})};
}

Findings judgeUnits(const LightMapEntry& entry, const LightMapFacts& facts, const std::vector<ProbeFacts>& probes) {
    double ofProbes = 0;
    for (const ProbeFacts& probe : probes) ofProbes += probe.meanRadiance / static_cast<double>(probes.size());
    if (!(ofProbes > 0) || !(facts.meanRadiance > 0)) return {};
    const double ratio = facts.meanRadiance / ofProbes;
    const bool isGame = entry.description.lightUnits == formats::LightUnits::Game;
    const double otherwise = isGame ? ratio / std::numbers::pi : ratio * std::numbers::pi;
    const auto distance = [](double value) { return std::abs(std::log(value)); };
    if (distance(ratio) <= std::log(kUnitsRatio) || distance(otherwise) > std::log(kUnitsRatio)) return {};
    return {makeFinding(LintCheck::LightUnits, entry.name, entry.file, {"light_map", entry.name, "light_units"},
                        fmt::format("found a mean radiance of {:.3g} in the light map and of {:.3g} in {} probe{}, a ratio of {:.2f}; with "
                                    "light_units = \"{}\" it is {:.2f}",
                                    facts.meanRadiance, ofProbes, probes.size(), probes.size() == 1 ? "" : "s", ratio,
                                    isGame ? "radiometric" : "game", otherwise),
                        {{"ratio", ratio}, {"ratio_otherwise", otherwise}})};
}

Findings judgeGroundTruth(const LightMapEntry& entry, const LightMapFacts& facts) {
    if (!entry.groundTruth || !facts.tracedRatio) return {};
    const double ratio = *facts.tracedRatio, most = facts.isTracedSpecular ? kTracedSpecularRatio : kTracedRatio;
    if (ratio >= 1 / most && ratio <= most) return {};
    const auto isNear = [&](double factor) { return std::abs(std::log(ratio / factor)) <= std::log(kTracedRatio); };
    const char* const factor = isNear(std::numbers::pi) ? ", about pi" : isNear(std::numbers::inv_pi) ? ", about 1 / pi" : "";
    return {makeFinding(LintCheck::GroundTruthUnits, entry.name, *entry.groundTruth, {"light_map", entry.name, "ground_truth"},
                        fmt::format("found traced light {:.3g} times that of {} at the median of its values{}, expected {:.2g} to {:.2g} "
                                    "times",
                                    ratio, entry.file.filename().string(), factor, 1 / most, most),
                        {{"ratio", ratio}})};
}

Findings judgeSettings(const Scene& scene) {
    Findings findings;
    const std::filesystem::path file = scene.file.empty() ? "command line" : scene.file;
    const auto check = [&](const char* key, double limit) {
        if (limit <= 1) return;
        findings.push_back(makeFinding(LintCheck::LimitAboveOne, "", file, {"output", "", key},
                                       fmt::format("found {} = {}, which is {:.0f} %, expected a fraction below 1: for {} %, {}", key,
                                                   limit, 100 * limit, limit, limit / 100),
                                       {{"limit", limit}}));
    };
    check("max_error", errorLimit(scene.output));
    // Without a value of its own it follows max_error.
    if (const double limit = scene.output.limits[Limit::ConverterError].value_or(0); limit != errorLimit(scene.output))
        check("max_converter_error", limit);
    check("max_whole_error", scene.output.limits[Limit::WholeError].value_or(0));
    return findings;
}

/// Returns "3.5 hours", "12 days" or "56 years".
std::string ageWords(double hours) {
    constexpr double kHoursOfDay = 24, kHoursOfYear = 24 * 365.25;
    if (hours < 2 * kHoursOfDay) return fmt::format("{:.1f} hours", hours);
    if (hours < 2 * kHoursOfYear) return fmt::format("{:.0f} days", hours / kHoursOfDay);
    return fmt::format("{:.0f} years", hours / kHoursOfYear);
}

Findings judgeAge(const LightMapEntry& entry) {
    if (!entry.mesh) return {};
    std::error_code meshFault, bakeFault;
    const auto mesh = std::filesystem::last_write_time(*entry.mesh, meshFault);
    const auto bake = std::filesystem::last_write_time(entry.file, bakeFault);
    if (meshFault || bakeFault) return {};
    const double hours = std::chrono::duration<double, std::ratio<3600>>(mesh - bake).count();
    if (hours <= kNewerHours) return {};
    return {makeFinding(
        LintCheck::StaleBake, entry.name, *entry.mesh, {"light_map", entry.name, "mesh"},
        fmt::format("found a mesh {} newer than {}, expected the bake of this mesh", ageWords(hours), entry.file.filename().string()),
        {{"hours", hours}})};
}

Findings judgeMaterials(const Scene& scene, const std::vector<MaterialRecord>& materials) {
    if (materials.empty()) return {};
    std::vector<std::string> names;
    for (const MaterialRecord& material : materials) names.push_back(material.name);
    Findings findings;
    for (const MaterialEntry& entry : scene.materials) {
        if (entry.name == "*" || std::ranges::find(names, entry.name) != names.end()) continue;
        findings.push_back(makeFinding(LintCheck::UnknownMaterial, "", scene.file, {"material", entry.name, "name"},
                                       fmt::format("found [[material]] '{}', expected one of the {} materials of the meshes{}", entry.name,
                                                   names.size(), formats::nearestHint(entry.name, names)),
                                       {{"materials", static_cast<double>(names.size())}}));
    }
    return findings;
}

Findings judgeExtensions(const Scene& scene, const LightMapEntry& entry, const std::vector<UnreadMaterial>& materials) {
    Findings findings;
    for (const UnreadMaterial& material : materials) {
        const std::vector<std::string> assumed = assumptionsOf(material, scene.materials);
        if (assumed.empty()) continue;
        findings.push_back(
            makeFinding(LintCheck::MaterialExtension, entry.name, *entry.mesh, {"light_map", entry.name, "mesh"},
                        fmt::format("found {} in material {} '{}', which lightcook does not read; assumed: {}",
                                    fmt::join(material.extensions, ", "), material.index, material.name, fmt::join(assumed, ", ")),
                        {{"material", static_cast<double>(material.index)}}));
    }
    return findings;
}

}  // namespace lightcook::pipeline
