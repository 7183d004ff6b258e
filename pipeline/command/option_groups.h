// Options that several commands share, each defined once.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): name of the library
class App;
class Option;
}  // namespace CLI

namespace lightcook::pipeline {

struct KeyRow;

/// Placeholders of options, which help texts show. Shell completions offer files or folders for the first two.
inline constexpr const char* kFilePlaceholder = "FILE";
inline constexpr const char* kFolderPlaceholder = "FOLDER";
inline constexpr const char* kSizePlaceholder = "SIZE";
inline constexpr const char* kPercentPlaceholder = "PERCENT";
inline constexpr const char* kFractionPlaceholder = "FRACTION";
inline constexpr const char* kNumbersPlaceholder = "N,N,...";
inline constexpr const char* kNamesPlaceholder = "NAME,...";

/// Add an option that takes a file or a folder, one or several.
CLI::Option* addFileOption(CLI::App& app, const std::string& names, std::filesystem::path& file, const std::string& description);
CLI::Option* addFilesOption(CLI::App& app, const std::string& names, std::vector<std::filesystem::path>& files,
                            const std::string& description);
CLI::Option* addFolderOption(CLI::App& app, const std::string& names, std::filesystem::path& folder, const std::string& description);
CLI::Option* addFoldersOption(CLI::App& app, const std::string& names, std::vector<std::filesystem::path>& folders,
                              const std::string& description);

/// Returns the caption of a user's setting as the help of its option, with where its value comes from without the option.
/// what   in place of the caption; empty: that
std::string helpOf(const KeyRow& setting, std::string what = "");
/// Adds the option --cache.
/// what   the folder, for its help
void addCacheOption(CLI::App& app, std::filesystem::path& cache, const std::string& what = "Cache folder");

/// Ways in which a command writes a path of its command line. FileOrFolder: its extension says which.
enum class Written { No, File, FileOrFolder, Folder };
/// Declares that the command writes the path of an option, not only reads it: see CommandPaths. Returns the option.
CLI::Option* declareWritten(CLI::Option* option, Written written);
/// Returns how the command writes the path of an option; No unless declared.
Written writtenBy(CLI::Option& option);

/// Adds an option that takes a percentage: 2 or 2%. Refuses negative ones.
CLI::Option* addPercentOption(CLI::App& app, const std::string& names, std::optional<double>& value, const std::string& description);

void addStrictOption(CLI::App& app, bool& strict);
void addRepairOption(CLI::App& app, bool& repair);
void addSamplesOption(CLI::App& app, std::optional<int>& samples);

}  // namespace lightcook::pipeline
