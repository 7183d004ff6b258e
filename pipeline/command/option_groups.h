// Options that several commands share, each defined once.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/light_map.h"
#include "formats/specular_lobe.h"
#include "pipeline/cook/cook.h"
#include "pipeline/scene/checks.h"

namespace CLI {  // NOLINT(readability-identifier-naming): name of the library
class App;
class Option;
}  // namespace CLI

namespace lightcook::pipeline {

/// Placeholders of options, which help texts show. Shell completions offer files or folders for the first two.
inline constexpr const char* kFilePlaceholder = "FILE";
inline constexpr const char* kFolderPlaceholder = "FOLDER";
inline constexpr const char* kSizePlaceholder = "SIZE";
inline constexpr const char* kPercentPlaceholder = "PERCENT";
inline constexpr const char* kFractionPlaceholder = "FRACTION";

/// Returns "none: no Condon-Shortley signs; condon-shortley: ..." for the rows of a table.
template <class Row>
std::string captionsOf(std::span<const Row> rows) {
    std::string text;
    for (const Row& row : rows) text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", row.name, row.caption);
    return text;
}

/// Add an option that takes a file or a folder, one or several.
CLI::Option* addFileOption(CLI::App& app, const std::string& names, std::filesystem::path& file, const std::string& description);
CLI::Option* addFilesOption(CLI::App& app, const std::string& names, std::vector<std::filesystem::path>& files,
                            const std::string& description);
CLI::Option* addFolderOption(CLI::App& app, const std::string& names, std::filesystem::path& folder, const std::string& description);
CLI::Option* addFoldersOption(CLI::App& app, const std::string& names, std::vector<std::filesystem::path>& folders,
                              const std::string& description);

/// Ways in which a command writes a path of its command line. FileOrFolder: its extension says which.
enum class Written { No, File, FileOrFolder, Folder };
/// Declares that the command writes the path of an option, not only reads it: see CommandPaths. Returns the option.
CLI::Option* declareWritten(CLI::Option* option, Written written);
/// Returns how the command writes the path of an option; No unless declared.
Written writtenBy(CLI::Option& option);

/// Adds an option that takes a fraction: 0.02 or 2%. Refuses others by name, unless 0 < value <= highest; 0 is allowed where
/// `mayBeZero`.
struct FractionRange {
    double highest = HUGE_VAL;
    bool mayBeZero = false;
};
CLI::Option* addFractionOption(CLI::App& app, const std::string& names, std::optional<double>& value, const std::string& description,
                               FractionRange range = {});

/// Adds an option that takes a percentage: 2 or 2%. Refuses negative ones.
CLI::Option* addPercentOption(CLI::App& app, const std::string& names, std::optional<double>& value, const std::string& description);

/// Adds --fit: the fit of a dominant light.
void addDominantFitOption(CLI::App& app, std::string& fit);
/// Adds --layout: size and number of the textures of a dominant light.
void addDominantLayoutOption(CLI::App& app, std::string& layout);

/// Options that override the scene file's [output]. A command has those that act on what it writes.
class OutputOptions {
public:
    /// Adds all: for commands that cook a whole scene.
    void addScene(CLI::App& app);
    /// Adds those of addTextures and --layout: for a light map.
    void addLightMap(CLI::App& app);
    /// Adds --target, --effort, --rdo and those of addFiles: for commands that write compressed textures.
    void addTextures(CLI::App& app);
    /// Adds --container, --zstd, --budget and --max-error: for commands that write textures of fixed formats.
    void addFiles(CLI::App& app);

    /// Copies what was given on the command line to `options`.
    formats::Result<void> apply(CookOptions& options) const;

private:
    void addFormats(CLI::App& app);
    void addContainer(CLI::App& app);
    void addLayout(CLI::App& app);
    /// Adds --max-error, --max-visible and --max-visible-bound of a command of one asset, which is no light map.
    void addLimits(CLI::App& app);
    void addVisibleBound(CLI::App& app);

    std::string target_, layout_, objective_, container_, budget_;
    Limits limits_;
    std::optional<double> rdo_;
    std::optional<int> effort_;
    bool zstd_ = false, isOneAsset_ = true;
};

/// --bake, --phase, --frame, --axes, --quantity, --light-units, --encoding, --image, --mesh, --lmbake and --firefly-limit: the conventions
/// of a baked light map.
class ConventionOptions {
public:
    void add(CLI::App& app);
    /// Copies the conventions to `description`, and finds the lmbake beside a bake of Godot. Fails for values that the scene file does not
    /// take, and for a file that is no mesh with light-map UVs.
    /// hasMeshes  the command has meshes beside --mesh
    formats::Result<void> apply(formats::LightMapDescription& description, const std::filesystem::path& bake, bool hasMeshes = false) const;

private:
    formats::Result<std::filesystem::path> lmbakeOf(const std::filesystem::path& bake, bool hasMeshes) const;

    std::string bake_ = std::string(formats::kAutoBake), phase_, frame_, quantity_, lightUnits_, encoding_, coverage_, image_,
                axes_ = formats::BakeAxes().name(), lmbake_;
    std::filesystem::path mesh_;
    double fireflyLimit_ = formats::LightMapDescription{}.fireflyLimit;
};

/// Adds --lobe, with the names of `lobes`.
CLI::Option* addLobeOption(CLI::App& app, lighting::SpecularLobe& lobe, std::span<const formats::SpecularLobeInfo> lobes);
void addEffortOption(CLI::App& app, std::optional<int>& effort);
void addRdoOption(CLI::App& app, std::optional<double>& rdo);
void addStrictOption(CLI::App& app, bool& strict);
void addRepairOption(CLI::App& app, bool& repair);
/// Adds --source, the colour space of the input. Empty: what the file states.
void addSourceOption(CLI::App& app, std::optional<std::string>& source);
void addSamplesOption(CLI::App& app, std::optional<int>& samples);

/// Returns the objection to an option's value as an error of the command line.
formats::Result<void> checkOption(const char* option, const Objection& objection);

}  // namespace lightcook::pipeline
