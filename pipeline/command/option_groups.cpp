#include "pipeline/command/option_groups.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "formats/bake_format.h"
#include "formats/gltf_scene.h"
#include "formats/light_map_conventions.h"
#include "formats/lmbake.h"
#include "formats/target.h"
#include "pipeline/document/byte_count.h"
#include "pipeline/scene/dominant_fit.h"
#include "pipeline/scene/dominant_layout.h"

namespace lightcook::pipeline {
namespace {

template <class Enum>
void addConvention(CLI::App& app, const char* name, std::string& value, const char* what) {
    const auto rows = formats::conventions<Enum>();
    value = rows.front().name;
    app.add_option(name, value, fmt::format("{} ({})", what, captionsOf(rows)))
        ->check(CLI::IsMember(formats::namesOf(rows)))
        ->capture_default_str();
}

}  // namespace

CLI::Option* addFileOption(CLI::App& app, const std::string& names, std::filesystem::path& file, const std::string& description) {
    return app.add_option(names, file, description)->type_name(kFilePlaceholder);
}

CLI::Option* addFilesOption(CLI::App& app, const std::string& names, std::vector<std::filesystem::path>& files,
                            const std::string& description) {
    return app.add_option(names, files, description)->type_name(kFilePlaceholder);
}

CLI::Option* addFolderOption(CLI::App& app, const std::string& names, std::filesystem::path& folder, const std::string& description) {
    return app.add_option(names, folder, description)->type_name(kFolderPlaceholder);
}

CLI::Option* addFoldersOption(CLI::App& app, const std::string& names, std::vector<std::filesystem::path>& folders,
                              const std::string& description) {
    return app.add_option(names, folders, description)->type_name(kFolderPlaceholder);
}

namespace {

/// A declaration is a validator of this name that accepts everything: CLI11 keeps nothing else of ours with an option.
constexpr std::array<std::pair<Written, const char*>, 3> kDeclarations = {{
    {Written::File, "writes a file"},
    {Written::FileOrFolder, "writes a file or a folder"},
    {Written::Folder, "writes a folder"},
}};

}  // namespace

CLI::Option* declareWritten(CLI::Option* option, Written written) {
    for (const auto& [each, name] : kDeclarations)
        if (each == written) option->check(CLI::Validator([](const std::string&) { return std::string(); }, "", name));
    return option;
}

Written writtenBy(CLI::Option& option) {
    for (const auto& [each, name] : kDeclarations) try {
            option.get_validator(name);
            return each;
        } catch (const CLI::OptionNotFound&) {  // the next one
        }
    return Written::No;
}

CLI::Option* addLobeOption(CLI::App& app, lighting::SpecularLobe& lobe, std::span<const formats::SpecularLobeInfo> lobes) {
    return app
        .add_option_function<std::string>(
            "--lobe",
            [&lobe, lobes](const std::string& name) {
                if (const auto* row = formats::findByName(lobes, name)) lobe = row->id;
            },
            fmt::format("Specular lobe of the engine's materials ({})", captionsOf(lobes)))
        ->check(CLI::IsMember(formats::namesOf(lobes)))
        ->default_str(std::string(formats::info(lobe).name));
}

void addEffortOption(CLI::App& app, std::optional<int>& effort) {
    app.add_option("--effort", effort, "Effort of the block encoders, 0 (fastest) to 9 (best); default: 5")->check(CLI::Range(0, 9));
}

CLI::Option* addFractionOption(CLI::App& app, const std::string& names, std::optional<double>& value, const std::string& description,
                               FractionRange range) {
    const auto convert = [range](std::string& text) {
        const auto fraction = parseFraction(text);
        if (fraction && (range.mayBeZero ? *fraction >= 0 : *fraction > 0) && *fraction <= range.highest) {
            text = fmt::format("{}", *fraction);
            return std::string();
        }
        const std::string highest = std::isfinite(range.highest) ? fmt::format(", at most {}", range.highest) : "";
        return fmt::format("found '{}', expected a fraction such as 0.02 or 2%, {} 0{}", text, range.mayBeZero ? "at least" : "above",
                           highest);
    };
    return app.add_option(names, value, description)->transform(CLI::Validator(convert, ""))->type_name(kFractionPlaceholder);
}

CLI::Option* addPercentOption(CLI::App& app, const std::string& names, std::optional<double>& value, const std::string& description) {
    const auto convert = [](std::string& text) {
        const auto number = parseFraction(text);
        if (!number || *number < 0) return fmt::format("found '{}', expected a percentage such as 2 or 2%, at least 0", text);
        text = fmt::format("{}", text.ends_with('%') ? 100 * *number : *number);
        return std::string();
    };
    return app.add_option(names, value, description)->transform(CLI::Validator(convert, ""))->type_name(kPercentPlaceholder);
}

void addRdoOption(CLI::App& app, std::optional<double>& rdo) {
    addFractionOption(app, "--rdo", rdo,
                      "Rate-distortion optimization of BC blocks: the fraction by which the error of a row of blocks may grow so that the "
                      "compressed file shrinks, such as 2%",
                      {kLargestRdo, true});
}

void addDominantFitOption(CLI::App& app, std::string& fit) {
    const auto check = [](const std::string& name) {
        return dominantFitFromName(name) != nullptr ? std::string()
                                                    : fmt::format("found '{}', expected {}", name, formats::listOfNames(allDominantFits()));
    };
    app.add_option("--fit", fit, fmt::format("How the light is found ({})", captionsOf(allDominantFits())))
        ->check(CLI::Validator(check, ""))
        ->type_name("NAME")
        ->capture_default_str();
}

void addDominantLayoutOption(CLI::App& app, std::string& layout) {
    // Without textures there is nothing to convert.
    std::vector<DominantLayoutInfo> layouts(allDominantLayouts().begin(), allDominantLayouts().end());
    std::erase_if(layouts, [](const DominantLayoutInfo& each) { return each.divisor == 0; });
    const std::span<const DominantLayoutInfo> rows = layouts;
    app.add_option("--layout", layout, fmt::format("Size and number of the textures ({})", captionsOf(rows)))
        ->check(CLI::IsMember(formats::namesOf(rows)))
        ->capture_default_str();
}

void addStrictOption(CLI::App& app, bool& strict) {
    app.add_flag("--strict", strict, "Treat warnings of lint that the scene file does not allow as errors (exit code 3)");
}

void addRepairOption(CLI::App& app, bool& repair) {
    app.add_flag("--repair", repair,
                 "Repair bad input values (NaN, infinite, negative energy) and count them, instead of refusing the file");
}

void addSourceOption(CLI::App& app, std::optional<std::string>& source) {
    app.add_option("--source", source,
                   "Colour space of the input, which is converted to lin_rec709. Default: stated, the primaries that the file states "
                   "(chromaticities of OpenEXR, PRIMARIES of Radiance), else lin_rec709")
        ->type_name("SPACE");
}

void addSamplesOption(CLI::App& app, std::optional<int>& samples) {
    app.add_option("--samples", samples, "Random places on the surface at which the verifier shades, per texel")
        ->check(CLI::Range(0, 1000000));
}

formats::Result<void> checkOption(const char* option, const Objection& objection) {
    if (!objection) return {};
    return formats::failure(formats::ErrorCode::InvalidRequest, option,
                            fmt::format("found {}, expected {}", objection->found, objection->expected));
}

void OutputOptions::addContainer(CLI::App& app) {
    app.add_option("--container", container_, "Container of the textures")->check(CLI::IsMember({"ktx2", "dds"}));
    app.add_flag("--zstd", zstd_, "Compress the textures inside KTX2 with Zstandard");
    app.add_option("--budget", budget_, "GPU memory of everything that is written, such as \"2 MiB\"; more ends with code 5")
        ->type_name(kSizePlaceholder);
}

void OutputOptions::addFormats(CLI::App& app) {
    app.add_option("--target", target_, fmt::format("Family of GPU formats ({})", captionsOf(formats::allTargets())))
        ->check(CLI::IsMember(formats::namesOf(formats::allTargets())));
    addContainer(app);
    addEffortOption(app, effort_);
    addRdoOption(app, rdo_);
}

void OutputOptions::addLayout(CLI::App& app) {
    app.add_option(
           "--max-visible", limits_[Limit::Visible],
           "Limit on the visible error of light maps and meshes, in just noticeable differences that 99 % keep; over it verification "
           "fails")
        ->type_name("NUMBER");
    addVisibleBound(app);
    app.add_option("--layout", layout_, "Layout of light maps; auto: the one that meets --max-error, --max-visible or --budget best")
        ->check(CLI::IsMember(lightMapLayoutChoices()));
    app.add_option("--objective", objective_,
                   fmt::format("What learned layouts of light maps and ratio minimize ({})", captionsOf(formats::allObjectives())))
        ->check(CLI::IsMember(formats::namesOf(formats::allObjectives())));
}

namespace {
void addErrorLimit(CLI::App& app, std::optional<double>& limit) {
    addFractionOption(app, "--max-error", limit, "Limit on rel_rms of diffuse and of specular; over it verification fails");
}
}  // namespace

void OutputOptions::addLimits(CLI::App& app) {
    addErrorLimit(app, limits_[Limit::Error]);
    app.add_option("--max-visible", limits_[Limit::Visible],
                   "Limit on the visible error, in just noticeable differences that 99 % keep; over it verification fails")
        ->type_name("NUMBER");
    addVisibleBound(app);
}

void OutputOptions::addVisibleBound(CLI::App& app) {
    app.add_option("--max-visible-bound", limits_[Limit::VisibleBound],
                   "Limit on the proven bound of the visible error, which no place, normal or view exceeds; over it verification fails")
        ->type_name("NUMBER");
}

void OutputOptions::addFiles(CLI::App& app) {
    addContainer(app);
    addLimits(app);
}

void OutputOptions::addTextures(CLI::App& app) {
    addFormats(app);
    addLimits(app);
}

void OutputOptions::addLightMap(CLI::App& app) {
    addFormats(app);
    addErrorLimit(app, limits_[Limit::Error]);
    addLayout(app);
}

void OutputOptions::addScene(CLI::App& app) {
    isOneAsset_ = false;
    addFormats(app);
    addFractionOption(app, "--max-error", limits_[Limit::Error],
                      "Limit on rel_rms of diffuse and of specular, of light maps and meshes; over it verification fails");
    addFractionOption(app, "--max-converter-error", limits_[Limit::ConverterError],
                      "Limit of dominant lights, cubemaps, tables and reflection maps, each on its own quantity");
    app.add_option("--max-converter-visible", limits_[Limit::ConverterVisible],
                   "Limit on the visible error of dominant lights, cubemaps, tables and reflection maps; over it verification fails")
        ->type_name("NUMBER");
    app.add_option("--max-converter-visible-bound", limits_[Limit::ConverterVisibleBound],
                   "Limit on the proven bound of the visible error of dominant lights, cubemaps, tables and reflection maps; over it "
                   "verification fails")
        ->type_name("NUMBER");
    app.add_option("--max-whole-visible", limits_[Limit::WholeVisible],
                   "Limit on the visible error of what a pixel shows of a light map and its dominant light together: their smallest "
                   "layouts within it are chosen; over it verification fails")
        ->type_name("NUMBER");
    addFractionOption(app, "--max-whole-error", limits_[Limit::WholeError],
                      "The same limit on rel_rms of what a pixel shows of them together");
    app.add_option("--max-seam", limits_[Limit::Seam],
                   "Limit on the seams that cooking adds where charts of a light map meet on its mesh, in just noticeable differences; "
                   "over it verification fails")
        ->type_name("NUMBER");
    addLayout(app);
}

formats::Result<void> OutputOptions::apply(CookOptions& options) const {
    if (!target_.empty()) options.target = formats::targetFromName(target_);
    if (!layout_.empty()) options.lightMapLayout = layout_;
    if (const auto* row = formats::findByName(formats::allObjectives(), objective_); row != nullptr) options.objective = row->id;
    if (!container_.empty()) options.container = container_ == "dds" ? formats::Container::Dds : formats::Container::Ktx2;
    for (const LimitInfo& limit : allLimits())
        if (const auto& given = limits_[limit.id]; given && !limit.isFraction)
            LC_CHECK(checkOption(optionOf(limit).c_str(), kVisibleLimit.objectionTo(*given)));
    options.limits = limits_;
    // A command of one asset holds that asset to its limits, of whatever kind it is.
    for (const LimitInfo& each : allLimits())
        if (isOneAsset_ && each.isOfConverters()) options.limits[each.id] = limits_[each.held];
    if (effort_ && options.target == formats::Target::Float)
        return formats::failure(formats::ErrorCode::InvalidRequest, "--effort",
                                "found it with --target float, whose texels are not encoded, expected --target bc or astc");
    if (effort_) options.effort = effort_;
    if (rdo_) options.rdo = rdo_;
    if (zstd_) options.zstd = true;
    if (budget_.empty()) return {};
    LC_TRY(bytes, parseByteCount(budget_, "--budget"));
    options.budgetBytes = *bytes;
    return {};
}

void ConventionOptions::add(CLI::App& app) {
    app.add_option("--bake", bake_, fmt::format("Bake format of the file ({}: as its channels, name and size say)", formats::kAutoBake))
        ->check(CLI::IsMember(formats::bakeNames()))
        ->capture_default_str();
    addConvention<formats::ShPhase>(app, "--phase", phase_, "Sign convention of the SH basis");
    addConvention<formats::ShFrame>(app, "--frame", frame_, "Frame of the coefficients");
    app.add_option("--axes", axes_, "Components of the file's vectors that are x, y and z of the mesh: for Unity --axes=-x,y,z")
        ->type_name("TEXT")
        ->capture_default_str();
    addConvention<formats::ShQuantity>(app, "--quantity", quantity_, "Quantity that the coefficients expand");
    addConvention<formats::LightUnits>(app, "--light-units", lightUnits_, "Units of the bake's light sources");
    addConvention<formats::LightEncoding>(app, "--encoding", encoding_, "Encoding of the colours of a picture of 8 or 16 bits");
    addConvention<formats::CoverageSource>(app, "--coverage", coverage_, "What says which texels lie inside charts");
    app.add_option("--image", image_, "Name or index of the image of a glTF that has light maps in several")->type_name("NAME");
    addFileOption(app, "--mesh", mesh_,
                  fmt::format("The glTF whose surfaces the bake lies on: for normals that the bake lacks, --coverage mesh, and {}",
                              fmt::join(formats::meshBakeNames(), ", ")));
    app.add_option(
           "--lmbake", lmbake_,
           fmt::format("Of a bake of Godot, the file that says where the nodes of the mesh lie; {}: TEXCOORD_1 says it. Default: the "
                       "file beside the bake, if there is one",
                       formats::kNoLmbake))
        ->type_name(kFilePlaceholder);
    app.add_option("--firefly-limit", fireflyLimit_,
                   "A texel that is brighter than this many times its brightest neighbour is a firefly and refused; 0: no check")
        ->capture_default_str();
}

/// Returns the lmbake of a bake; empty: it has none.
formats::Result<std::filesystem::path> ConventionOptions::lmbakeOf(const std::filesystem::path& bake, bool hasMeshes) const {
    const auto wrong = [](std::string detail) {
        return formats::failure(formats::ErrorCode::InvalidRequest, "--lmbake", std::move(detail));
    };
    const bool hasMesh = hasMeshes || !mesh_.empty();
    if (lmbake_ == formats::kNoLmbake) return std::filesystem::path();
    if (lmbake_.empty()) return hasMesh ? formats::lmbakeBeside(bake, bake_) : std::filesystem::path();
    if (!hasMesh) return wrong("found it without a mesh, expected --mesh FILE: its nodes are in the lmbake");
    if (!formats::mayTakeLmbake(bake_))
        return wrong(fmt::format("found it with --bake {}, expected a light map of Godot: {}", bake_,
                                 fmt::join(formats::lmbakeBakeNames(), " or ")));
    return std::filesystem::path(lmbake_);
}

formats::Result<void> ConventionOptions::apply(formats::LightMapDescription& description, const std::filesystem::path& bake,
                                               bool hasMeshes) const {
    const auto axes = formats::BakeAxes::fromName(axes_);
    if (!axes)
        return formats::failure(formats::ErrorCode::InvalidRequest, "--axes",
                                fmt::format("found \"{}\", expected {}", axes_, formats::BakeAxes::kExpected));
    description.axes = *axes;
    LC_TRY(lmbake, lmbakeOf(bake, hasMeshes));
    description.lmbake = *lmbake;
    description.bake = bake_;
    description.phase = *formats::conventionFromName<formats::ShPhase>(phase_);
    description.frame = *formats::conventionFromName<formats::ShFrame>(frame_);
    description.quantity = *formats::conventionFromName<formats::ShQuantity>(quantity_);
    description.lightUnits = *formats::conventionFromName<formats::LightUnits>(lightUnits_);
    description.encoding = *formats::conventionFromName<formats::LightEncoding>(encoding_);
    description.coverage = *formats::conventionFromName<formats::CoverageSource>(coverage_);
    description.image = image_;
    description.mesh = mesh_;
    description.fireflyLimit = fireflyLimit_;
    LC_CHECK(checkOption("--firefly-limit", kFireflyLimit.objectionTo(fireflyLimit_)));
    // A bake that has normals and coverage does not read its mesh, and would not tell.
    return mesh_.empty() ? formats::Result<void>() : formats::checkLightMapUvs(mesh_);
}

}  // namespace lightcook::pipeline
