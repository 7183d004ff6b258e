#include "formats/color.h"

#include <OpenColorIO/OpenColorIO.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <initializer_list>
#include <optional>
#include <set>
#include <vector>

#include "formats/file/one_line.h"
#include "formats/image/exr_file.h"
#include "formats/image/out_of_memory.h"
#include "formats/image/radiance_file.h"
#include "formats/nearest.h"

namespace OCIO = OCIO_NAMESPACE;

namespace lightcook::formats {
namespace {

/// CIE xy of the three primaries and of white.
struct Chromaticities {
    glm::dvec2 red, green, blue, white;
};
constexpr glm::dvec2 kWhiteD65{0.3127, 0.3290};
constexpr glm::dvec2 kWhiteAces{0.32168, 0.33767};  // SMPTE ST 2065-1: near D60, not on the daylight locus

constexpr Chromaticities kRec709{{0.640, 0.330}, {0.300, 0.600}, {0.150, 0.060}, kWhiteD65};   // ITU-R BT.709, sRGB too
constexpr Chromaticities kRec2020{{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, kWhiteD65};  // ITU-R BT.2020
constexpr Chromaticities kP3D65{{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, kWhiteD65};    // SMPTE EG 432-1
constexpr Chromaticities kAp0{{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}, kWhiteAces};    // SMPTE ST 2065-1
constexpr Chromaticities kAp1{{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, kWhiteAces};     // ACEScg, Academy S-2014-004

glm::dvec3 xyzFromXy(const glm::dvec2& xy) {
    return {xy.x / xy.y, 1.0, (1.0 - xy.x - xy.y) / xy.y};
}

/// Columns are the XYZ of the primaries, scaled so that equal amounts of the three make white with Y = 1 (SMPTE RP 177).
glm::dmat3 xyzFromRgb(const Chromaticities& space) {
    // A primary may have y = 0, so its column starts as (x, y, z) and not as XYZ with Y = 1.
    const auto column = [](const glm::dvec2& xy) { return glm::dvec3(xy.x, xy.y, 1.0 - xy.x - xy.y); };
    const glm::dmat3 unscaled(column(space.red), column(space.green), column(space.blue));
    const glm::dvec3 amounts = glm::inverse(unscaled) * xyzFromXy(space.white);
    return {unscaled[0] * amounts.x, unscaled[1] * amounts.y, unscaled[2] * amounts.z};
}

/// Bradford's linear adaptation: cone responses scaled by the ratio of the whites' (Lam 1985; the same matrix is in ICC.1 annex E).
glm::dmat3 adaptedFromWhite(const glm::dvec2& source, const glm::dvec2& destination) {
    if (source == destination) return glm::dmat3(1.0);
    const glm::dmat3 coneFromXyz = glm::transpose(glm::dmat3(0.8951, 0.2664, -0.1614,  //
                                                             -0.7502, 1.7135, 0.0367,  //
                                                             0.0389, -0.0685, 1.0296));
    const glm::dvec3 ratio = (coneFromXyz * xyzFromXy(destination)) / (coneFromXyz * xyzFromXy(source));
    const glm::dmat3 scale(ratio.x, 0, 0, 0, ratio.y, 0, 0, 0, ratio.z);
    return glm::inverse(coneFromXyz) * scale * coneFromXyz;
}

/// Returns XYZ under D65 from a space.
glm::dmat3 xyzD65From(const Chromaticities& space) {
    return adaptedFromWhite(space.white, kWhiteD65) * xyzFromRgb(space);
}

/// Returns linear BT.2020 from XYZ under D65.
glm::dmat3 bt2020FromXyz() {
    return glm::inverse(xyzFromRgb(kRec2020));
}

/// Returns the largest absolute difference of an entry.
double largestDifference(const glm::dmat3& a, const glm::dmat3& b) {
    double largest = 0;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) largest = std::max(largest, std::abs(a[column][row] - b[column][row]));
    return largest;
}

OCIO::MatrixTransformRcPtr matrixTransform(const glm::dmat3& matrix) {
    std::array<double, 16> rows{};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) rows[static_cast<std::size_t>(4 * row + column)] = matrix[column][row];
    }
    rows[15] = 1.0;
    OCIO::MatrixTransformRcPtr transform = OCIO::MatrixTransform::Create();
    transform->setMatrix(rows.data());
    return transform;
}

/// The sRGB curve (IEC 61966-2-1) and a plain power, known only so that spaces that use them can be refused by name.
OCIO::TransformRcPtr decodeSrgb() {
    OCIO::ExponentWithLinearTransformRcPtr transform = OCIO::ExponentWithLinearTransform::Create();
    transform->setGamma({2.4, 2.4, 2.4, 1.0});
    transform->setOffset({0.055, 0.055, 0.055, 0.0});
    return transform;
}
OCIO::TransformRcPtr decodePower(double gamma) {
    OCIO::ExponentTransformRcPtr transform = OCIO::ExponentTransform::Create();
    transform->setValue({gamma, gamma, gamma, 1.0});
    return transform;
}

constexpr const char* kXyz = "lin_ciexyzd65";
constexpr const char* kAcesInterchange = "aces_interchange";  ///< role of OpenColorIO configs: ACES2065-1

struct OurSpace {
    const char* name;
    std::initializer_list<const char*> aliases;
    Chromaticities chromaticities;
};
const std::array<OurSpace, 5>& ourLinearSpaces() {
    static const std::array<OurSpace, 5> spaces = {{
        {"lin_rec709", {"lin_srgb", "lin_rec709_srgb"}, kRec709},
        {"acescg", {"lin_ap1"}, kAp1},
        {"aces2065-1", {"lin_ap0", "aces2065_1"}, kAp0},
        {"lin_rec2020", {}, kRec2020},
        {"lin_p3d65", {}, kP3D65},
    }};
    return spaces;
}

void addSpace(OCIO::Config& config, const char* name, std::initializer_list<const char*> aliases, const char* encoding,
              const OCIO::ConstTransformRcPtr& xyzFromSpace) {
    OCIO::ColorSpaceRcPtr space = OCIO::ColorSpace::Create();
    space->setName(name);
    for (const char* alias : aliases) space->addAlias(alias);
    space->setEncoding(encoding);
    if (xyzFromSpace) space->setTransform(xyzFromSpace, OCIO::COLORSPACE_DIR_TO_REFERENCE);
    config.addColorSpace(space);
}

/// Returns the built-in config, in which every space is defined relative to CIE XYZ under D65.
OCIO::ConstConfigRcPtr makeOurConfig() {
    OCIO::ConfigRcPtr config = OCIO::Config::Create();
    config->setVersion(2, 0);
    addSpace(*config, kXyz, {"cie_xyz_d65"}, "scene-linear", nullptr);
    for (const OurSpace& space : ourLinearSpaces())
        addSpace(*config, space.name, space.aliases, "scene-linear", matrixTransform(xyzD65From(space.chromaticities)));
    const auto addEncoded = [&config](const char* name, std::initializer_list<const char*> aliases, const OCIO::TransformRcPtr& decode) {
        OCIO::GroupTransformRcPtr group = OCIO::GroupTransform::Create();
        group->appendTransform(decode);
        group->appendTransform(matrixTransform(xyzFromRgb(kRec709)));
        addSpace(*config, name, aliases, "sdr-video", group);
    };
    addEncoded("srgb_texture", {"srgb", "srgb_rec709"}, decodeSrgb());
    addEncoded("g22_rec709", {}, decodePower(2.2));
    addEncoded("g24_rec709", {"rec1886_rec709"}, decodePower(2.4));
    config->setRole(OCIO::ROLE_SCENE_LINEAR, "lin_rec709");
    config->setRole(OCIO::ROLE_DEFAULT, "lin_rec709");
    return config;
}

const OCIO::ConstConfigRcPtr& ourConfig() {
    static const OCIO::ConstConfigRcPtr config = [] {
        OCIO::SetLoggingLevel(OCIO::LOGGING_LEVEL_NONE);  // messages of OpenColorIO reach the user as an Error only
        return makeOurConfig();
    }();
    return config;
}

std::string configName(const ColorSpaces& spaces) {
    return spaces.config.empty() ? std::string("the built-in config") : spaces.config.string();
}

Result<OCIO::ConstConfigRcPtr> openConfig(const ColorSpaces& spaces) {
    const OCIO::ConstConfigRcPtr& ours = ourConfig();
    if (spaces.config.empty()) return ours;
    try {
        OCIO::ClearAllCaches();  // it keeps the files that a configuration refers to, which may have changed
        return OCIO::Config::CreateFromFile(spaces.config.c_str());
    } catch (const std::exception& exception) {
        throwIfOutOfMemory(exception);
        return failure(ErrorCode::FileUnreadable, spaces.config,
                       fmt::format("found {}, expected an OpenColorIO config file", quotedLine(exception.what())));
    }
}

std::vector<std::string> knownNames(const OCIO::Config& config) {
    std::vector<std::string> names;
    for (int i = 0; i < config.getNumColorSpaces(OCIO::SEARCH_REFERENCE_SPACE_ALL, OCIO::COLORSPACE_ALL); ++i) {
        names.emplace_back(config.getColorSpaceNameByIndex(OCIO::SEARCH_REFERENCE_SPACE_ALL, OCIO::COLORSPACE_ALL, i));
        const OCIO::ConstColorSpaceRcPtr space = config.getColorSpace(names.back().c_str());
        for (std::size_t alias = 0; alias < space->getNumAliases(); ++alias) names.emplace_back(space->getAlias(alias));
    }
    return names;
}

/// Finds the space of a name, alias or role. Refuses spaces for data.
Result<OCIO::ConstColorSpaceRcPtr> findSpace(const OCIO::Config& config, const std::string& name, const ColorSpaces& spaces) {
    const std::string subject = fmt::format("colour space '{}'", oneLine(name));
    OCIO::ConstColorSpaceRcPtr space = config.getColorSpace(name.c_str());
    if (!space) {
        return failure(
            ErrorCode::ColorSpace, subject,
            fmt::format("found no such space in {}, expected one it knows{}", configName(spaces), nearestHint(name, knownNames(config))));
    }
    if (space->isData()) {
        return failure(ErrorCode::ColorSpace, subject,
                       fmt::format("found a space for data without primaries in {}, expected a colour space", configName(spaces)));
    }
    return space;
}

using Conversion = OCIO::ConstCPUProcessorRcPtr;

Conversion conversionBetween(const OCIO::Config& config, const OCIO::ConstColorSpaceRcPtr& from, const OCIO::ConstColorSpaceRcPtr& to) {
    return config.getProcessor(from, to)->getOptimizedCPUProcessor(OCIO::BIT_DEPTH_F32, OCIO::BIT_DEPTH_F32, OCIO::OPTIMIZATION_LOSSLESS);
}

glm::vec3 apply(const Conversion& conversion, glm::vec3 color) {
    conversion->applyRGB(&color.x);
    return color;
}

/// The conversion's matrix: its action on the three unit colours.
glm::mat3 matrixOf(const Conversion& conversion) {
    return {apply(conversion, {1, 0, 0}), apply(conversion, {0, 1, 0}), apply(conversion, {0, 0, 1})};
}

/// Returns, in words, the first probe x at which a conversion f differs from its matrix: f(x) != matrix x. Empty if there is none.
/// Probes: scaled unit colours, from the toe of encoding curves to far above 1 and below 0, then sums.
std::optional<std::string> whyNotLinear(const Conversion& conversion) {
    const glm::dmat3 matrix = matrixOf(conversion);
    double norm = 0;
    for (int column = 0; column < 3; ++column) norm = std::max(norm, glm::length(matrix[column]));

    std::vector<glm::vec3> probes = {glm::vec3(0)};
    for (const float scale : {0.001f, 0.18f, 0.5f, 2.0f, 100.0f, 50000.0f, -0.01f, -1.0f}) {
        for (int channel = 0; channel < 3; ++channel) {
            glm::vec3 probe(0);
            probe[channel] = scale;
            probes.push_back(probe);
        }
        probes.push_back(scale * glm::vec3(1.0f, 0.75f, 0.25f));
        probes.push_back(scale * glm::vec3(0.25f, 1.0f, -0.5f));
    }
    for (const glm::vec3& probe : probes) {
        const glm::dvec3 found = apply(conversion, probe);
        const glm::dvec3 expected = matrix * glm::dvec3(probe);
        // A 3 x 3 product in float errs by some 4 epsilon = 5e-7 of |matrix| |x|; 1e-5 leaves room for vectorised powers of 1 in configs.
        const double tolerance = 1e-5 * norm * glm::length(glm::dvec3(probe)) + 1e-9;
        const double error = glm::length(found - expected);
        if (error <= tolerance) continue;  // false for NaN, which is not linear either
        return fmt::format("found ({}, {}, {}) made from ({}, {}, {}), expected ({:.6g}, {:.6g}, {:.6g}) by proportion", found.x, found.y,
                           found.z, probe.x, probe.y, probe.z, expected.x, expected.y, expected.z);
    }
    return std::nullopt;
}

tl::unexpected<Error> notLinear(const std::string& what, const std::string& why) {
    return failure(ErrorCode::ColorSpace, what + " is not linear",
                   why + ": SH coefficients, cubemaps and gradients only keep their meaning under linear conversions");
}

/// Sets what is known of the spaces: of the working space Y of each primary under its white, and BT.2020 from it; BT.2020 from the source
/// space. From the table above, else from the config's interchange role, else from its default luma coefficients, which do not tell the
/// last.
void describeSpaces(LinearConversion& conversion, const OCIO::Config& config, const OCIO::ConstColorSpaceRcPtr& working, bool isOurs) {
    const auto rowY = [](const glm::dmat3& xyz) { return glm::vec3(xyz[0].y, xyz[1].y, xyz[2].y); };
    const std::string name = working->getName();
    const auto setBt2020 = [&conversion](const glm::dmat3& bt2020FromWorking) {
        conversion.bt2020FromWorking = bt2020FromWorking;
        conversion.bt2020FromSource = bt2020FromWorking * glm::dmat3(conversion.workingFromSource);
    };
    if (isOurs) {
        setBt2020(matrixOf(conversionBetween(config, working, config.getColorSpace("lin_rec2020"))));
        conversion.luminanceWeights = {0, 1, 0};  // XYZ itself; other spaces outside the table are not linear and were refused
        for (const OurSpace& space : ourLinearSpaces())
            if (name == space.name) conversion.luminanceWeights = rowY(xyzFromRgb(space.chromaticities));
        return;
    }
    if (config.hasRole(kAcesInterchange)) {
        const glm::dmat3 xyzFromWorking =
            xyzFromRgb(kAp0) * glm::dmat3(matrixOf(conversionBetween(config, working, config.getColorSpace(kAcesInterchange))));
        conversion.luminanceWeights = rowY(xyzFromWorking);
        setBt2020(bt2020FromXyz() * adaptedFromWhite(kAp0.white, kWhiteD65) * xyzFromWorking);
        return;
    }
    std::array<double, 3> weights{};
    config.getDefaultLumaCoefs(weights.data());
    conversion.luminanceWeights = {weights[0], weights[1], weights[2]};
}

/// Tests each space against the linear reference of the config. The error then names the space at fault, and two encoded spaces do not pass
/// because their curves cancel.
Result<void> requireLinearSpaces(const OCIO::Config& config, const ColorSpaces& spaces,
                                 std::initializer_list<OCIO::ConstColorSpaceRcPtr> used) {
    const OCIO::ConstColorSpaceRcPtr reference = config.getColorSpace(spaces.config.empty() ? kXyz : OCIO::ROLE_SCENE_LINEAR);
    if (!reference) return {};
    for (const OCIO::ConstColorSpaceRcPtr& space : used) {
        if (const auto why = whyNotLinear(conversionBetween(config, space, reference))) {
            return notLinear(fmt::format("colour space '{}'", space->getName()), *why);
        }
    }
    return {};
}

LinearConversion packed(const glm::mat3& workingFromSource) {
    LinearConversion result;
    float distance = 0;
    for (int column = 0; column < 3; ++column) {
        for (int row = 0; row < 3; ++row) {
            distance = std::max(distance, std::abs(workingFromSource[column][row] - (column == row ? 1.0f : 0.0f)));
        }
    }
    result.isIdentity = distance <= 1e-6f;
    if (!result.isIdentity) result.workingFromSource = workingFromSource;
    return result;
}

/// Returns the conversion from the primaries that a file states.
Result<LinearConversion> statedConversion(const ColorSpaces& spaces, const std::optional<StatedChromaticities>& stated) {
    const std::string subject = fmt::format("colour space '{}'", kStatedSource);
    if (!spaces.config.empty())
        return failure(ErrorCode::ColorSpace, subject,
                       fmt::format("found it with {}, expected the name of a space in it", spaces.config.string()));
    const ColorSpaces usual{ColorSpaces().source, spaces.working, {}};
    Result<LinearConversion> conversion = linearConversion(usual);
    if (!conversion || !stated) return conversion;
    const auto primaries = statedPrimaries(*stated, *conversion);
    if (!primaries)
        return failure(ErrorCode::ColorSpace, subject,
                       fmt::format("found the primaries and white ({:.4g}), which no space has, expected those of a colour space: name it "
                                   "instead",
                                   fmt::join(*stated, ", ")));
    if (!primaries->space.empty()) return linearConversion({primaries->space, spaces.working, {}});
    const glm::dmat3 bt2020FromStated = *bt2020FromChromaticities(*stated);
    const LinearConversion own = packed(glm::mat3(glm::inverse(conversion->bt2020FromWorking) * bt2020FromStated));
    conversion->workingFromSource = own.workingFromSource;
    conversion->isIdentity = own.isIdentity;
    conversion->bt2020FromSource = bt2020FromStated;
    return conversion;
}

}  // namespace

Result<LinearConversion> linearConversion(const ColorSpaces& spaces, const std::optional<StatedChromaticities>& stated) {
    if (spaces.source == kStatedSource) return statedConversion(spaces, stated);
    LC_TRY(config, openConfig(spaces));
    const std::string subject = fmt::format("colour conversion '{}' -> '{}'", oneLine(spaces.source), oneLine(spaces.working));
    try {
        LC_TRY(source, findSpace(**config, spaces.source, spaces));
        LC_TRY(working, findSpace(**config, spaces.working, spaces));
        if (const auto linear = requireLinearSpaces(**config, spaces, {*source, *working}); !linear) {
            return tl::make_unexpected(linear.error());
        }
        const Conversion conversion = conversionBetween(**config, *source, *working);
        if (const auto why = whyNotLinear(conversion)) return notLinear(subject, *why);
        LinearConversion result = packed(matrixOf(conversion));
        describeSpaces(result, **config, *working, spaces.config.empty());
        return result;
    } catch (const std::exception& exception) {
        throwIfOutOfMemory(exception);
        return failure(ErrorCode::ColorSpace, subject,
                       fmt::format("found {} in {}, expected a conversion that OpenColorIO can make", quotedLine(exception.what()),
                                   configName(spaces)));
    }
}

std::vector<std::filesystem::path> filesOfConversion(const ColorSpaces& spaces) {
    const auto config = openConfig(spaces);
    if (!config || spaces.config.empty()) return {};
    std::set<std::filesystem::path> files;
    const auto add = [&](const OCIO::ConstColorSpaceRcPtr& from, const OCIO::ConstColorSpaceRcPtr& to) {
        const OCIO::ConstProcessorMetadataRcPtr metadata = (*config)->getProcessor(from, to)->getProcessorMetadata();
        for (int i = 0; i < metadata->getNumFiles(); ++i) files.emplace(metadata->getFile(i));
    };
    try {
        const auto source = findSpace(**config, spaces.source, spaces), working = findSpace(**config, spaces.working, spaces);
        if (!source || !working) return {};
        add(*source, *working);
        if ((*config)->hasRole(kAcesInterchange)) add(*working, (*config)->getColorSpace(kAcesInterchange));  // see describeSpaces
    } catch (const std::exception& exception) {
        throwIfOutOfMemory(exception);
        return {};
    }
    return {files.begin(), files.end()};
}

Result<void> checkColorSpace(const std::string& name, const std::filesystem::path& config) {
    // The names of nearly all scenes need no OpenColorIO.
    const auto isNamed = [&name](const OurSpace& space) { return name == space.name; };
    if (config.empty() && (name == kStatedSource || std::ranges::any_of(ourLinearSpaces(), isNamed))) return {};
    const auto conversion = linearConversion({name, name, config});
    if (conversion || conversion.error().code != ErrorCode::ColorSpace) return {};
    return tl::make_unexpected(conversion.error());
}

std::optional<glm::dmat3> bt2020FromChromaticities(const StatedChromaticities& chromaticities) {
    const auto xy = [&](std::size_t index) { return glm::dvec2(chromaticities.at(2 * index), chromaticities.at(2 * index + 1)); };
    const Chromaticities space{xy(0), xy(1), xy(2), xy(3)};
    // CIE XYZ itself, whose equal amounts are the white E.
    const bool isXyz = space.red == glm::dvec2(1, 0) && space.green == glm::dvec2(0, 1) && space.blue == glm::dvec2(0);
    const glm::dmat3 matrix = isXyz ? bt2020FromXyz() : bt2020FromXyz() * xyzD65From(space);
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            if (!std::isfinite(matrix[column][row])) return std::nullopt;
    return matrix;
}

std::optional<StatedPrimaries> statedPrimaries(const StatedChromaticities& chromaticities, const LinearConversion& conversion) {
    const auto stated = bt2020FromChromaticities(chromaticities);
    if (!stated || !conversion.bt2020FromSource) return std::nullopt;
    StatedPrimaries primaries{chromaticities, "", largestDifference(*stated, *conversion.bt2020FromSource)};
    for (const OurSpace& space : ourLinearSpaces())
        if (largestDifference(*stated, bt2020FromXyz() * xyzD65From(space.chromaticities)) <= kSamePrimaries) primaries.space = space.name;
    if (largestDifference(*stated, bt2020FromXyz()) <= kSamePrimaries) primaries.space = kXyz;
    return primaries;
}

std::optional<StatedChromaticities> statedChromaticities(const std::filesystem::path& image) {
    if (const Result<ExrReader> exr = ExrReader::open(image)) return exr->info().chromaticities;
    return radianceChromaticities(image);
}

std::optional<StatedPrimaries> statedPrimaries(const std::filesystem::path& image, const ColorSpaces& spaces) {
    const std::optional<StatedChromaticities> stated = statedChromaticities(image);
    if (!stated) return std::nullopt;
    const Result<LinearConversion> conversion = linearConversion(spaces, stated);
    return conversion ? statedPrimaries(*stated, *conversion) : std::nullopt;
}

}  // namespace lightcook::formats
