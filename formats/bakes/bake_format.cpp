#include "formats/bake_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <system_error>
#include <tuple>

#include "formats/bakes/bake_reader.h"
#include "formats/bakes/bakery.h"
#include "formats/bakes/deluxe.h"
#include "formats/bakes/file_set.h"
#include "formats/bakes/flat.h"
#include "formats/bakes/godot.h"
#include "formats/bakes/rnm.h"
#include "formats/bakes/sh4.h"
#include "formats/bakes/sh9.h"
#include "formats/bakes/sh_baker.h"
#include "formats/bakes/unity.h"
#include "formats/bakes/unreal.h"
#include "formats/epic_light_maps.h"
#include "formats/file/one_line.h"
#include "formats/unity_axes.h"
#include "formats/vocabulary.h"

namespace lightcook::formats {
namespace {

using Kind = BakeMatch::Kind;

constexpr std::string_view kTangents =
    "tangents are those of the mesh, or without TANGENT follow TEXCOORD_0; the y of the three directions points down a picture";

constexpr std::array kBakeFormats = {
    BakeFormatInfo{.name = "sh9",
                   .caption = "27 channels sh00.R, sh00.G, sh00.B to sh08.B: coefficient l * (l + 1) + m of bands 0, 1 and 2",
                   .content = kSh9Content,
                   .assumes = "",
                   .implied = {},
                   .match = matchSh9,
                   .filesBeside = nullptr,
                   .open = openSh9},
    BakeFormatInfo{.name = "sh-baker",
                   .caption =
                       "the coefficients of sh9 as sh-baker writes them: 27 channels L0.R to L22.B, nine files _L0 to _L22, or three "
                       "files _packed_0 to _packed_2",
                   .content = "L0.R .. L22.B, or files _L0 .. _L22 or _packed_0 .. _packed_2",
                   .assumes = "",
                   .implied = {},
                   .endings = kShBakerEndings,
                   .match = matchShBaker,
                   .filesBeside = filesBesideShBaker,
                   .open = openShBaker},
    BakeFormatInfo{.name = "flat",
                   .caption = "a picture R, G, B without directions: the exit radiance E / pi of a white surface, or under quantity "
                              "irradiance E itself; alpha is coverage",
                   .content = "R, G, B",
                   .assumes = "R, G, B are E / pi, or E if the quantity is irradiance; light comes evenly from everywhere",
                   .implied = {ShPhase::None, ShFrame::World, {}, {}},
                   .hasDirections = false,
                   .takesEncoding = true,
                   .takesLmbake = true,
                   .match = matchFlat,
                   .filesBeside = nullptr,
                   .open = openFlat},
    BakeFormatInfo{.name = "godot",
                   .caption =
                       "directional light map of Godot 4.4 and later, as the engine shows it: slices L0, y, z, x of R, G, B from top to "
                       "bottom; alpha is coverage",
                   .content = "R, G, B in four slices",
                   .assumes = "the light is what Godot's shader shows, which holds less than the radiance that was baked",
                   .implied = {ShPhase::None, ShFrame::World, ShQuantity::Radiance, {}},
                   .longestDirection = kLongestOfGodot,
                   .takesLmbake = true,
                   .match = matchGodot,
                   .filesBeside = filesBesideGodot,
                   .open = openGodot},
    BakeFormatInfo{.name = "godot-radiance",
                   .caption = "the same file as incident radiance: exact for even light, approximate for other",
                   .content = "R, G, B in four slices",
                   .assumes = "the light comes evenly from the upper hemisphere, as far as L0 and L1 do not say otherwise",
                   .implied = {ShPhase::None, ShFrame::World, ShQuantity::Radiance, {}},
                   .takesLmbake = true,
                   .match = matchGodot,
                   .filesBeside = filesBesideGodot,
                   .open = openGodotRadiance},
    BakeFormatInfo{.name = "bakery-sh",
                   .caption = "SH light map of Bakery: files _L0 (HDR), _L1x, _L1y and _L1z of one name, as the shader of Unity shows it",
                   .content = "files _L0, _L1x, _L1y and _L1z",
                   .assumes = kUnityAxes,
                   .implied = {ShPhase::None, ShFrame::World, ShQuantity::Radiance, {}},
                   .takesEncoding = true,
                   .endings = kBakeryEndings,
                   .match = matchBakerySh,
                   .filesBeside = filesBesideBakerySh,
                   .open = openBakerySh},
    BakeFormatInfo{.name = "bakery-mono-sh",
                   .caption = "MonoSH light map of Bakery: files _L0 (HDR) and _L1 (directions) of one name, as the engine shows it",
                   .content = "files _L0 and _L1",
                   .assumes = kUnityAxes,
                   .implied = {ShPhase::None, ShFrame::World, ShQuantity::Radiance, {}},
                   .takesEncoding = true,
                   .endings = kMonoEndings,
                   .match = matchBakeryMonoSh,
                   .filesBeside = filesBesideBakeryMonoSh,
                   .open = openBakeryMonoSh},
    BakeFormatInfo{.name = "unity-directional",
                   .caption = "directional light map of Unity: files _light and _dir (directions) of one name, as the engine shows it",
                   .content = "files _light and _dir",
                   .assumes = kUnityAxes,
                   .implied = {ShPhase::None, ShFrame::World, ShQuantity::Radiance, {}},
                   .takesEncoding = true,
                   .endings = kUnityEndings,
                   .match = matchUnityDirectional,
                   .filesBeside = filesBesideUnityDirectional,
                   .open = openUnityDirectional},
    BakeFormatInfo{.name = "bakery-dominant",
                   .caption = "light map of Bakery with dominant directions: files _final (HDR) and _dir (directions) of one name, as the "
                              "shader of Unity shows it",
                   .content = "files _final and _dir",
                   .assumes = kUnityAxes,
                   .implied = {ShPhase::None, ShFrame::World, ShQuantity::Radiance, {}},
                   .takesEncoding = true,
                   .endings = kDominantEndings,
                   .match = matchBakeryDominant,
                   .filesBeside = filesBesideBakeryDominant,
                   .open = openBakeryDominant},
    BakeFormatInfo{.name = "unreal-hq",
                   .caption = "high-quality light maps of Unreal in the glTF of its own exporter, as its glTF viewer shows them: without "
                              "directions",
                   .content = "a glTF with extension EPIC_lightmap_textures",
                   .assumes = "light comes evenly from everywhere: the exporter leaves out the constants of the directions, and Unreal's "
                              "factor without them, 0.6, stands for these",
                   .implied = {ShPhase::None, ShFrame::World, ShQuantity::Radiance, {}},
                   .match = matchUnrealHq,
                   .filesBeside = epicFilesBeside,
                   .open = nullptr,
                   .openGltf = openUnrealHq},
    BakeFormatInfo{.name = "bakery-rnm",
                   .caption = "RNM light map of Bakery: files _RNM0, _RNM1 and _RNM2 (HDR) of one name, in the tangent space of the mesh",
                   .content = "files _RNM0, _RNM1 and _RNM2",
                   .assumes = kTangents,
                   .implied = {ShPhase::None, ShFrame::World, ShQuantity::Radiance, {}},
                   .takesAxes = false,
                   .endings = kRnmEndings,
                   .match = matchBakeryRnm,
                   .filesBeside = filesBesideRnm,
                   .open = nullptr,
                   .openOnMesh = openBakeryRnm},
    BakeFormatInfo{
        .name = "source-rnm",
        .caption = "the same files as Source (Half-Life 2) shows the pages of a bumped surface: squares of the cosines as weights",
        .content = "files _RNM0, _RNM1 and _RNM2",
        .assumes = kTangents,
        .implied = {ShPhase::None, ShFrame::World, ShQuantity::Radiance, {}},
        .takesAxes = false,
        .endings = kRnmEndings,
        .match = matchSourceRnm,
        .filesBeside = filesBesideRnm,
        .open = nullptr,
        .openOnMesh = openSourceRnm},
    BakeFormatInfo{.name = "deluxe",
                   .caption =
                       "light map and direction map of q3map2 (Quake 3): files of one name and _deluxe, or pages lm_0000 (light) and "
                       "lm_0001 (directions), as ioquake3 shows them on the mesh",
                   .content = "a file and its directions _deluxe, or pages lm_0000 and lm_0001",
                   .assumes = "the axes of the directions are those of the mesh; Quake's own have z up",
                   .implied = {ShPhase::None, ShFrame::World, ShQuantity::Radiance, {}},
                   .takesEncoding = true,
                   .endings = kDeluxeEndings,
                   .match = matchDeluxe,
                   .filesBeside = filesBesideDeluxe,
                   .open = nullptr,
                   .openOnMesh = openDeluxe},
    BakeFormatInfo{.name = "sh4",
                   .caption = "12 channels sh00.R to sh03.B: bands 0 and 1 of sh9; band 2 is zero",
                   .content = kSh4Content,
                   .assumes = "",
                   .implied = {},
                   .match = matchSh4,
                   .filesBeside = nullptr,
                   .open = openSh4},
};

tl::unexpected<Error> wrongShape(const std::filesystem::path& file, std::string detail) {
    return failure(ErrorCode::WrongShape, file, std::move(detail));
}

/// Returns "R, G, B": what a file holds, for errors.
std::string heldBy(const ExrInfo& info) {
    std::vector<std::string> held = info.channels;
    // EXR files have their channels in alphabetical order.
    constexpr std::string_view kPictureChannels = "RGBA";
    const auto isColour = [&](const std::string& name) {
        return name.size() == 1 && kPictureChannels.find(name) != std::string_view::npos;
    };
    if (std::ranges::all_of(held, isColour))
        std::ranges::sort(held, {}, [&](const std::string& name) { return kPictureChannels.find(name); });
    return held.empty() ? "no channels" : oneLine(fmt::format("{}", fmt::join(held, ", ")));
}

/// Returns the layers of a file without R, G and B that have them: "Combined" of Combined.R, Combined.G and Combined.B.
std::vector<std::string> layersOf(const ExrInfo& info) {
    std::vector<std::string> layers;
    if (info.has("R")) return layers;
    for (const std::string& name : info.channels)
        if (name.size() > 2 && name.ends_with(".R")) {
            const std::string layer = name.substr(0, name.size() - 2);
            if (info.has(layer + ".G") && info.has(layer + ".B")) layers.push_back(layer);
        }
    return layers;
}

/// Returns true if the names of channels speak of SH.
bool mayHoldCoefficients(const ExrInfo& info) {
    return std::ranges::any_of(info.channels, [](const std::string& name) {
        return name.find("sh") != std::string::npos || name.find("SH") != std::string::npos;
    });
}

/// Returns what to do with a file whose channels belong to no format.
std::string guessOf(const ExrInfo& info) {
    if (isPicture(info)) return ". The six faces of a probe? A light map of this shape needs bake = \"flat\"";
    return mayHoldCoefficients(info) ? ". SH under other names? Rename the channels" : "";
}

tl::unexpected<Error> unknownFormat(const std::filesystem::path& file, const ExrInfo& info) {
    if (const auto layers = layersOf(info); !layers.empty() && !mayHoldCoefficients(info))
        return wrongShape(file, fmt::format("found R, G, B under {} {}, expected them without a layer: save one layer as R, G, B",
                                            layers.size() == 1 ? "layer" : "layers", oneLine(fmt::format("{}", fmt::join(layers, ", ")))));
    std::vector<std::string> known;
    for (const BakeFormatInfo& format : kBakeFormats) known.push_back(fmt::format("{} ({})", format.name, format.content));
    return failure(ErrorCode::UnknownBake, file,
                   fmt::format("found no light map, expected that of a bake format: {}; it holds {}{}", fmt::join(known, ", "),
                               heldBy(info), guessOf(info)));
}

struct Candidate {
    const BakeFormatInfo* format = nullptr;
    BakeMatch match;
};

tl::unexpected<Error> ambiguous(const std::filesystem::path& file, const std::vector<Candidate>& candidates) {
    std::vector<std::string> readings, choices;
    for (const Candidate& each : candidates) {
        readings.push_back(fmt::format("{} ({})", each.format->name, each.match.evidence));
        choices.push_back(fmt::format("bake = \"{}\"", each.format->name));
    }
    return wrongShape(file, fmt::format("found a file that could be {}, expected the scene file to choose: {}", fmt::join(readings, " or "),
                                        fmt::join(choices, " or ")));
}

/// Returns what is missing of the set that a file belongs to, of several the one that lacks fewest parts, with the formats of the others:
/// "found 1 of the 2 files of bake format ...". Empty: it belongs to none, or to a complete one.
std::string incompleteSetOf(const std::vector<Candidate>& candidates) {
    const Candidate* best = nullptr;
    std::vector<std::string_view> others;
    for (const Candidate& each : candidates) {
        if (each.match.kind == Kind::Certain) return "";
        if (each.match.kind != Kind::Partial) continue;
        const auto rank = [](const BakeMatch& match) { return std::tuple(match.numberCount, -match.missingCount); };
        const bool isBetter = best == nullptr || rank(each.match) > rank(best->match);
        if (best != nullptr) others.push_back(isBetter ? best->format->name : each.format->name);
        if (isBetter) best = &each;
    }
    if (best == nullptr) return "";
    if (others.empty()) return best->match.evidence;
    return fmt::format("{}; or it is one of {}", best->match.evidence, fmt::join(others, " or "));
}

/// Returns the candidate that a file without a named format is read as.
Result<Candidate> identify(const std::vector<Candidate>& candidates, const std::filesystem::path& file, const ExrInfo& info) {
    const Candidate* best = nullptr;
    std::vector<Candidate> possible;
    for (const Candidate& each : candidates) {
        if (each.match.kind == Kind::Possible) possible.push_back(each);
        if (each.match.kind == Kind::None || each.match.kind == Kind::OnlyNamed) continue;
        const auto rank = [](const BakeMatch& match) {
            return std::tuple(match.kind == Kind::Certain, match.numberCount, match.kind, -match.missingCount);
        };
        if (best == nullptr || rank(each.match) > rank(best->match)) best = &each;
    }
    if (best == nullptr) return unknownFormat(file, info);
    if (best->match.kind == Kind::Partial) return wrongShape(file, best->match.evidence);
    if (best->match.kind == Kind::Possible && possible.size() > 1) return ambiguous(file, possible);
    return *best;
}

/// Returns the file of a named format, or why it is not of that format.
Result<Candidate> asNamed(const BakeFormatInfo& format, const std::filesystem::path& file, const ExrInfo& info) {
    const BakeMatch match = format.match(file, info);
    if (match.kind == Kind::Partial || (match.kind == Kind::None && !match.evidence.empty())) return wrongShape(file, match.evidence);
    if (match.kind == Kind::None)
        return wrongShape(
            file, fmt::format("found no light map of bake format {}, expected {}; it holds {}", format.name, format.content, heldBy(info)));
    return Candidate{&format, match};
}

/// Replaces a convention by the implied one. Returns false if it has another value than the default, which the scene file must have set.
template <class Enum>
bool imply(Enum& convention, const std::optional<Enum>& implied) {
    const bool contradicts = implied && convention != conventions<Enum>().front().id && convention != *implied;
    convention = implied.value_or(convention);
    return !contradicts;
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

std::vector<std::string> encodedBakeNames() {
    std::vector<std::string> names;
    for (const BakeFormatInfo& format : kBakeFormats)
        if (format.takesEncoding) names.emplace_back(format.name);
    return names;
}

std::vector<std::string> gltfBakeNames() {
    std::vector<std::string> names;
    for (const BakeFormatInfo& format : kBakeFormats)
        if (format.openGltf != nullptr) names.emplace_back(format.name);
    return names;
}

std::vector<std::string> lmbakeBakeNames() {
    std::vector<std::string> names;
    for (const BakeFormatInfo& format : kBakeFormats)
        if (format.takesLmbake) names.emplace_back(format.name);
    return names;
}

std::vector<std::string> meshBakeNames() {
    std::vector<std::string> names;
    for (const BakeFormatInfo& format : kBakeFormats)
        if (format.needsMesh()) names.emplace_back(format.name);
    return names;
}

bool mayNeedMesh(const std::filesystem::path& file, std::string_view bake) {
    const auto exists = [](const std::filesystem::path& each) {
        std::error_code code;
        return std::filesystem::exists(each, code);
    };
    return std::ranges::any_of(kBakeFormats, [&](const BakeFormatInfo& format) {
        if (!format.needsMesh() || bake != kAutoBake) return format.needsMesh() && bake == format.name;
        const auto files = format.filesBeside(file);
        return !files.empty() && std::ranges::all_of(files, exists);
    });
}

std::filesystem::path leadingFile(const std::filesystem::path& file, std::string_view bake) {
    ExrInfo picture;
    picture.channels = {"B", "G", "R"};
    std::error_code code;
    if (!std::filesystem::exists(file, code)) return file;
    for (const BakeFormatInfo& format : kBakeFormats) {
        if (format.filesBeside == nullptr || (bake != kAutoBake && bake != format.name)) continue;
        const auto files = format.filesBeside(file);
        if (std::ranges::find(files, file) == files.end() || !std::filesystem::exists(files.front(), code)) continue;
        if (bake == format.name || format.match(file, picture).kind == Kind::Certain) return files.front();
    }
    return file;
}

std::string faultOfPictureSet(const std::filesystem::path& file, std::string_view bake) {
    ExrInfo picture;
    picture.width = picture.height = 1;
    picture.channels = {"B", "G", "R"};
    std::vector<Candidate> incomplete;
    for (const BakeFormatInfo& format : kBakeFormats) {
        if (format.filesBeside == nullptr || (bake != kAutoBake && bake != format.name)) continue;
        const auto files = format.filesBeside(file);
        if (std::ranges::find(files, file) == files.end()) continue;
        const BakeMatch match = format.match(file, picture);
        if (match.kind == Kind::Certain && format.takesEncoding)
            return fmt::format(
                "found {} of bake format {} with light in a picture of integers, expected encoding = \"none\" (linear), "
                "\"srgb\", \"rgbm\" or \"dldr\" (--encoding) for {}",
                match.evidence, format.name, files.front().filename().string());
        if (match.kind == Kind::Partial && files.front() != file) incomplete.push_back({&format, match});
    }
    return incompleteSetOf(incomplete);
}

std::string nameOfBake(const std::filesystem::path& file, std::string_view bake) {
    std::string stem = file.stem().string();
    const BakeFormatInfo* const format = findByName(allBakeFormats(), bake);
    std::size_t longest = 0;  // one ending may be that of another, or empty
    for (const std::string_view ending : format != nullptr ? format->endings : std::span<const std::string_view>())
        if (stem.size() > ending.size() && endsInAnyCase(stem, ending)) longest = std::max(longest, ending.size());
    stem.resize(stem.size() - longest);
    return stem;
}

std::vector<std::filesystem::path> bakeFilesBeside(const std::filesystem::path& file, std::string_view bake) {
    std::vector<std::filesystem::path> files;
    for (const BakeFormatInfo& format : kBakeFormats) {
        if (format.filesBeside == nullptr || (bake != kAutoBake && bake != format.name)) continue;
        for (std::filesystem::path& beside : format.filesBeside(file)) {
            std::error_code code;
            if (beside != file && std::filesystem::exists(beside, code)) files.push_back(std::move(beside));
        }
    }
    std::ranges::sort(files);
    files.erase(std::unique(files.begin(), files.end()), files.end());
    return files;
}

Result<void> checkBakeName(const std::string& bake, const Subject& subject) {
    if (bake == kAutoBake || findByName(allBakeFormats(), bake) != nullptr) return {};
    return failure(ErrorCode::InvalidRequest, subject.at("bake"),
                   fmt::format("found \"{}\", expected {}", oneLine(bake), fmt::join(bakeNames(), " or ")));
}

Result<BakeRecognition> findBakeFormat(const std::string& bake, const std::filesystem::path& file, const ExrInfo& info) {
    LC_CHECK(checkBakeName(bake, file));
    std::vector<Candidate> candidates;
    for (const BakeFormatInfo& format : kBakeFormats) candidates.push_back({&format, format.match(file, info)});
    const bool isNamed = bake != kAutoBake;
    const Result<Candidate> chosen = isNamed ? asNamed(*findByName(allBakeFormats(), bake), file, info) : identify(candidates, file, info);
    if (!chosen) return tl::make_unexpected(chosen.error());
    BakeRecognition recognition{
        chosen->format, chosen->match.evidence + (isNamed ? ", as named" : ""), chosen->match.kind == Kind::Certain, {}};
    for (const Candidate& each : candidates)
        if (each.format != chosen->format && (each.match.kind == Kind::Possible || each.match.kind == Kind::Certain))
            recognition.otherReadings.push_back(each.format->name);
    // A set that is complete, or a file whose channels are, is no part of another one.
    if (!isNamed && !recognition.isCertain)
        if (std::string set = incompleteSetOf(candidates); !set.empty()) recognition.incompleteSets.push_back(std::move(set));
    return recognition;
}

Result<void> checkEncoding(LightEncoding encoding, const BakeFormatInfo& format, const Subject& subject) {
    if (encoding == LightEncoding::Auto || encoding == LightEncoding::None || format.takesEncoding) return {};
    return failure(ErrorCode::InvalidRequest, subject.at("encoding"),
                   fmt::format("found \"{}\" for bake format {}, expected none: it is for {}", nameOfConvention(encoding), format.name,
                               fmt::join(encodedBakeNames(), ", ")));
}

Result<void> checkImage(const std::string& image, const BakeFormatInfo& format, const Subject& subject) {
    if (image.empty() || format.openGltf != nullptr) return {};
    return failure(ErrorCode::InvalidRequest, subject.at("image"),
                   fmt::format("found \"{}\" for bake format {}, expected none: it is for {}", oneLine(image), format.name,
                               fmt::join(gltfBakeNames(), ", ")));
}

Result<void> checkAxes(const BakeAxes& axes, const BakeFormatInfo& format, const Subject& subject) {
    if (axes.isIdentity() || format.takesAxes) return {};
    return failure(ErrorCode::InvalidRequest, subject.at("axes"),
                   fmt::format("found \"{}\" for bake format {}, expected none: its directions are relative to the surfaces of the mesh",
                               axes.name(), format.name));
}

Result<void> checkLmbake(const std::filesystem::path& lmbake, const BakeFormatInfo& format, const Subject& subject) {
    if (lmbake.empty() || format.takesLmbake) return {};
    return failure(ErrorCode::InvalidRequest, subject.at("lmbake"),
                   fmt::format("found {} beside a light map of bake format {}, expected none: it is for those of Godot, {}",
                               lmbake.filename().string(), format.name, fmt::join(lmbakeBakeNames(), ", ")));
}

Result<LightMapDescription> withImplied(LightMapDescription description, const BakeFormatInfo& format, const Subject& subject) {
    const BakeConventions& implied = format.implied;
    const auto refuse = [&](std::string_view key, std::string_view name) {
        return failure(ErrorCode::InvalidRequest, subject.at(key),
                       fmt::format("found another value than \"{}\", expected it: bake format {} implies that value", name, format.name));
    };
    if (!imply(description.phase, implied.phase)) return refuse("phase", nameOfConvention(description.phase));
    if (!imply(description.frame, implied.frame)) return refuse("frame", nameOfConvention(description.frame));
    if (!imply(description.quantity, implied.quantity)) return refuse("quantity", nameOfConvention(description.quantity));
    if (!imply(description.lightUnits, implied.lightUnits)) return refuse("light_units", nameOfConvention(description.lightUnits));
    return description;
}

}  // namespace lightcook::formats
