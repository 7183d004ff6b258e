#include "pipeline/command/outputs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <system_error>

#include "formats/epic_light_maps.h"
#include "formats/gltf_scene.h"
#include "formats/lower_extension.h"
#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/printing.h"
#include "pipeline/document/written_path.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/cooked_folder.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/ci_report.h"
#include "pipeline/report/collection.h"
#include "pipeline/report/exit_codes.h"
#include "pipeline/report/report.h"
#include "pipeline/scene/named_files.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::Result;

/// Extensions of files that the program reads or writes, and of what scripts name beside them. A folder may have any other, such as that
/// of "v1.2", "room.cooked" and, where no single texture can be written, "room.ktx2".
constexpr std::array<std::string_view, 26> kFileExtensions = {
    ".bin",   ".bmp", ".csv",   ".exr", ".glb", ".glsl",  ".gltf", ".hdr", ".htm",  ".html", ".jpeg", ".jpg",  ".json",
    ".jsonl", ".md",  ".ninja", ".pfm", ".png", ".sarif", ".tga",  ".tif", ".tiff", ".toml", ".txt",  ".webp", ".xml"};

/// Returns the absolute path without links, dots and a slash at its end.
std::filesystem::path plainPath(const std::filesystem::path& path) {
    std::error_code code;
    const std::filesystem::path plain = std::filesystem::weakly_canonical(std::filesystem::absolute(path, code), code);
    return plain.has_filename() ? plain : plain.parent_path();
}

bool isSamePlace(const std::filesystem::path& a, const std::filesystem::path& b) {
    std::error_code code;
    if (std::filesystem::equivalent(a, b, code) && !code) return true;
    const std::filesystem::path first = plainPath(a);
    return !first.empty() && first == plainPath(b);
}

/// Returns true for standard output, devices and pipes: nothing is lost where they are written twice.
bool isStream(const std::filesystem::path& path) {
    std::error_code code;
    return path == kStandardOutput || std::filesystem::is_other(path, code);
}

bool isDirectory(const std::filesystem::path& path) {
    std::error_code code;
    return std::filesystem::is_directory(path, code);
}

/// Returns the file that a path has in place of one of its folders; empty: none.
std::filesystem::path fileInPlaceOfFolder(const std::filesystem::path& path) {
    std::error_code code;
    for (std::filesystem::path each = path.parent_path(); !each.empty(); each = each.parent_path()) {
        if (std::filesystem::exists(each, code)) return isDirectory(each) ? std::filesystem::path() : each;
        if (each == each.parent_path()) break;
    }
    return {};
}

/// Longest name of a file that file systems take [bytes].
constexpr std::size_t kLongestFileName = 255;

/// Fails if no folder or file can be made at a path: a name in it is too long, or a symbolic link in place of a folder names nothing.
/// isFolder   the path itself is to become a folder
Result<void> checkCanBeMade(const std::filesystem::path& path, bool isFolder) {
    for (const std::filesystem::path& name : path)
        if (name.native().size() > kLongestFileName)
            return formats::failure(formats::ErrorCode::InvalidRequest, path,
                                    fmt::format("found a name of {} bytes, expected at most {}", name.native().size(), kLongestFileName));
    std::error_code code;
    for (std::filesystem::path each = isFolder ? path : path.parent_path(); !each.empty(); each = each.parent_path()) {
        if (std::filesystem::is_symlink(each, code) && !std::filesystem::exists(each, code))
            return formats::failure(formats::ErrorCode::InvalidRequest, each,
                                    "found a symbolic link to nothing, expected a folder, or no such name");
        if (each == each.parent_path()) break;
    }
    return {};
}

tl::unexpected<Error> samePlace(const std::string& output, const std::filesystem::path& path, const std::string& other) {
    return formats::failure(
        formats::ErrorCode::InvalidRequest, output,
        fmt::format("found the same {} as {} ({}), expected another one", isDirectory(path) ? "folder" : "file", other, path.string()));
}

/// Returns the document of --json of a command that failed.
/// facts   that it found; null: none
Json failureDocument(Json facts, const std::vector<Error>& errors) {
    Json list = Json::array();
    for (const Error& error : errors) list.push_back(toJson(DocumentError::of(error)));
    if (facts.is_null()) facts = Json::object();
    if (!facts.is_object()) facts = {{"results", std::move(facts)}};
    facts["passed"] = false;
    facts["exit_code"] = exitCode(errors.front().code);
    facts["errors"] = std::move(list);
    return facts;
}

/// Returns the report of a scene, or that of several targets.
Json reportOf(const std::vector<Outcome>& outcomes) {
    if (outcomes.size() == 1) return outcomes.front().report;
    std::vector<CookedFolder> folders;
    Json all = Json::array();
    for (const Outcome& outcome : outcomes) {
        if (!outcome.report.is_object()) continue;
        all.push_back(outcome.report);
        if (auto report = fromJson<Report>(outcome.report, kReportName))
            folders.push_back({outcome.output, outcome.report, std::move(*report), outcome.output.filename(), outcome.errors});
    }
    if (folders.empty()) return all.empty() ? Json() : all;  // of previews, which are no reports
    return toJson(makeCollection(folders));
}

/// Returns an error of a target that says so, unless it is one of the inputs.
Error ofTarget(const Outcome& outcome, Error error) {
    if (isOfTarget(error)) error.subject = fmt::format("{}, {}", outcome.output.filename().string(), error.subject);
    return error;
}

}  // namespace

CommandPaths CommandPaths::of(CLI::App& command) {
    CommandPaths paths;
    if (const auto info = std::ranges::find(allCommands(), command.get_name(), &CommandInfo::name); info != allCommands().end()) {
        paths.isReport_ = info->folder == FolderUse::Reports || info->folder == FolderUse::CooksAndReports;
        paths.isCook_ = info->folder == FolderUse::Cooks || info->folder == FolderUse::CooksAndReports;
    }
    for (CLI::Option* option : command.get_options()) {
        const std::string type = option->get_type_name();
        if (!type.starts_with(kFilePlaceholder) && !type.starts_with(kFolderPlaceholder)) continue;
        const Written written = writtenBy(*option);
        for (const std::string& path : option->results())
            (written == Written::No ? paths.inputs_ : paths.outputs_).push_back({option->get_name(), path, written});
    }
    const auto isRefused = [](const Path& output) { return output.written == Written::Folder && output.path == kStandardOutput; };
    std::erase_if(paths.outputs_, [&](const Path& output) { return isStream(output.path) && !isRefused(output); });
    return paths;
}

Result<void> CommandPaths::check() const {
    for (const Path& input : inputs_)
        if (const std::string fault = faultOfInput(input.path.string(), input.path); !fault.empty())
            return formats::failure(formats::ErrorCode::InvalidRequest, input.name, fault);
    for (const Path& output : outputs_)
        if (const std::string fault = faultOfHome(output.path.string()); !fault.empty())
            return formats::failure(formats::ErrorCode::InvalidRequest, output.name, fault);
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        const Path& output = outputs_[i];
        LC_CHECK(check(output));
        for (std::size_t before = 0; before < i; ++before)
            if (isSamePlace(output.path, outputs_[before].path)) return samePlace(output.name, output.path, outputs_[before].name);
    }
    return {};
}

Result<void> CommandPaths::check(const Path& output) const {
    const bool isFolder = output.written == Written::Folder || (output.written == Written::FileOrFolder && !output.path.has_extension());
    if (output.written == Written::Folder && output.path == kStandardOutput)
        return formats::failure(formats::ErrorCode::InvalidRequest, output.name,
                                "found -, expected a folder: its files are not printed. ./- is a folder of that name");
    LC_CHECK(checkCanBeMade(output.path, isFolder));
    if (const std::filesystem::path file = fileInPlaceOfFolder(output.path); !file.empty())
        return formats::failure(formats::ErrorCode::InvalidRequest, output.path,
                                fmt::format("found the file {} in place of a folder, expected a folder or nothing", file.string()));
    if (output.written == Written::File && isDirectory(output.path))
        return formats::failure(formats::ErrorCode::InvalidRequest, output.path, "found a folder, expected the name of a file to write");
    if (output.written == Written::Folder) LC_CHECK(checkFolderName(output.path));
    for (const Path& input : inputs_) {
        if (isSamePlace(output.path, input.path)) return samePlace(output.name, output.path, input.name);
        if (formats::isGltfFile(input.path))
            for (const std::filesystem::path& beside : formats::gltfFilesBeside(input.path))
                if (isSamePlace(output.path, beside)) return samePlace(output.name, output.path, "a file of " + input.path.string());
        if (!isDirectory(input.path)) continue;
        for (const std::filesystem::path& folder : targetFolders(input.path)) LC_CHECK(checkCooked(output, folder));
        LC_CHECK(checkSources(output, input.path));
    }
    for (const Path& other : outputs_)
        if (&other != &output && (other.written != Written::File || isDirectory(other.path))) LC_CHECK(checkCooked(output, other.path));
    return {};
}

bool CommandPaths::isReportOf(const Path& output, const std::filesystem::path& folder) const {
    if (!isReport_) return false;
    // A report of several folders, or with a baseline or budgets, has more than the report of the cook.
    const auto isAdded = [](const Path& input) { return input.name == "--baseline" || input.name == "--budgets"; };
    if (std::ranges::count(inputs_, "folder", &Path::name) > 1 || std::ranges::any_of(inputs_, isAdded)) return false;
    return (output.name == "--json" && isSamePlace(output.path, folder / kReportName)) ||
           (output.name == "--html" && isSamePlace(output.path, folder / kReportHtmlName));
}

Result<void> CommandPaths::checkCooked(const Path& output, const std::filesystem::path& folder) const {
    const std::filesystem::path outer = plainPath(folder), inner = plainPath(output.path);
    if (std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first != outer.end()) return {};
    if (isReportOf(output, folder)) return {};
    std::error_code code;
    const bool isCooked = isCook_ || std::filesystem::exists(folder / kManifestName, code);
    for (const char* name : {kReportName, kReportHtmlName})
        if (isCooked && isSamePlace(output.path, folder / name))
            return samePlace(output.name, output.path, "the report of the output folder");
    std::vector<std::filesystem::path> files = {kManifestName, kShaderName};
    if (const auto manifest = loadManifest(folder))
        for (const FileRecord& record : filesOf(*manifest)) files.emplace_back(record.name);
    if (const auto report = loadReport(folder / kReportName))
        for (const std::string& picture : picturesOf(report->assets)) files.emplace_back(picture);
    for (const std::filesystem::path& file : files)
        if (isSamePlace(output.path, folder / file)) return samePlace(output.name, output.path, kCookedFile);
    return {};
}

Result<void> CommandPaths::checkSources(const Path& output, const std::filesystem::path& folder) const {
    std::error_code code;
    if (!std::filesystem::exists(output.path, code)) return {};  // it replaces nothing
    const auto manifest = loadManifest(folder);
    if (!manifest) return {};
    std::vector<std::filesystem::path> sources;  // relative to the scene's folder
    if (manifest->sceneFile) sources.emplace_back(*manifest->sceneFile);
    for (const CookedAsset& asset : manifest->assets) {
        if (!asset.source.files) continue;
        for (const auto& [role, source] : *asset.source.files) sources.emplace_back(source.file);
    }
    std::vector<std::filesystem::path> sceneFolders = {folder / manifest->sceneDirectory};
    for (const Path& input : inputs_)
        if (input.name == "--sources") sceneFolders.push_back(input.path);
    for (const std::filesystem::path& sceneFolder : sceneFolders)
        for (const std::filesystem::path& source : sources)
            if (isSamePlace(output.path, sceneFolder / source)) return samePlace(output.name, output.path, "a source of the cooked folder");
    return {};
}

Result<void> CommandPaths::checkAgainst(const std::vector<std::filesystem::path>& inputs, const std::string& what) {
    for (const Path& output : outputs_)
        for (const std::filesystem::path& input : inputs)
            if (isSamePlace(output.path, input)) return refuse(samePlace(output.name, output.path, what));
    return {};
}

Result<void> CommandPaths::checkAgainstScene(const Scene& scene, const std::filesystem::path& cooked) {
    LC_CHECK(checkAgainst(filesNamedBy(scene), "an input of the scene"));
    if (cooked.empty()) return {};
    for (const Path& output : outputs_) {
        if (output.written != Written::Folder && isSamePlace(output.path, cooked))
            return refuse(samePlace(output.name, output.path, "the output folder"));
        if (auto checked = checkCooked(output, cooked); !checked) return refuse(tl::make_unexpected(checked.error()));
    }
    return {};
}

Result<void> checkIsFile(const char* option, const std::filesystem::path& file) {
    if (file != kStandardOutput) return {};
    return formats::failure(formats::ErrorCode::InvalidRequest, option, "found -, expected the name of a file: it is not printed");
}

Result<void> checkFolderName(const std::filesystem::path& folder, const std::string& otherwise) {
    const std::string extension = formats::lowerExtension(folder);
    std::error_code code;
    if (std::ranges::find(kFileExtensions, extension) == kFileExtensions.end() || std::filesystem::exists(folder, code)) return {};
    return formats::failure(formats::ErrorCode::InvalidRequest, folder,
                            fmt::format("found the extension '{}' of a file, expected a folder, such as {}{}{}", extension,
                                        (folder.parent_path() / folder.stem()).string(), otherwise.empty() ? "" : ", ", otherwise));
}

Result<FoldersOfFile> FoldersOfFile::make(const std::filesystem::path& file) {
    std::vector<std::filesystem::path> missing;
    std::error_code code;
    for (std::filesystem::path each = file.parent_path(); !each.empty() && !std::filesystem::exists(each, code); each = each.parent_path())
        missing.push_back(each);
    FoldersOfFile made(std::move(missing));  // removes the first ones if a later one fails
    LC_CHECK(makeFolder(file.parent_path()));
    return made;
}

FoldersOfFile::~FoldersOfFile() {
    for (const std::filesystem::path& folder : made_) ::rmdir(folder.c_str());  // not if it holds anything
}

void JsonOutput::add(CLI::App& app, const std::string& what) {
    declareWritten(addFileOption(app, "--json", file_, fmt::format("Write {} as JSON; - is standard output", what)), Written::File);
}

bool JsonOutput::isStandardOutput() const {
    return file_ == kStandardOutput;
}

void JsonOutput::prepare(Session& session) const {
    if (isStandardOutput()) session.terminal.keepOutputForData();
}

Result<void> JsonOutput::write(Session& session, Json facts, const std::vector<Error>& errors) const {
    session.hasWrittenDocuments = true;
    if (!isGiven() || (session.paths.isRefused() && !isStandardOutput())) return {};
    if (!errors.empty()) facts = failureDocument(std::move(facts), errors);
    return session.write(file_, textOf(facts) + "\n");
}

int JsonOutput::finish(Session& session, Json facts, std::vector<Error> errors) const {
    if (auto written = write(session, std::move(facts), errors); !written) errors.push_back(written.error());
    return session.finish(errors);
}

int JsonOutput::finish(Session& session, const Result<Json>& facts) const {
    return facts ? finish(session, *facts, {}) : finish(session, {}, {facts.error()});
}

void CiOutputs::add(CLI::App& app) {
    json_.add(app, "the report");
    declareWritten(addFileOption(app, "--junit", junit_, "Write every check as JUnit XML; - is standard output"), Written::File);
    declareWritten(addFileOption(app, "--sarif", sarif_, "Write the failures as SARIF 2.1.0; - is standard output"), Written::File);
}

Result<void> CiOutputs::prepare(Session& session) const {
    const int count = (json_.isStandardOutput() ? 1 : 0) + (junit_ == kStandardOutput ? 1 : 0) + (sarif_ == kStandardOutput ? 1 : 0);
    if (count > 1)
        return formats::failure(formats::ErrorCode::InvalidRequest, "--json, --junit, --sarif",
                                fmt::format("found - for {} of them, expected one document on standard output", count));
    if (count == 1) session.terminal.keepOutputForData();
    return {};
}

std::vector<Error> CiOutputs::write(Session& session, const std::string& command, const std::vector<Outcome>& outcomes,
                                    const std::filesystem::path& sceneFile, const std::filesystem::path& sources) const {
    std::vector<Error> errors;
    for (const Outcome& outcome : outcomes)
        for (const Error& error : outcome.errors) formats::addOnce(errors, outcomes.size() == 1 ? error : ofTarget(outcome, error));
    const auto keep = [&](const Result<void>& written) {
        if (!written) errors.push_back(written.error());
    };
    keep(json_.write(session, reportOf(outcomes), errors));
    if (junit_.empty() && sarif_.empty()) return errors;
    std::vector<CiRun> runs;
    for (const Outcome& outcome : outcomes) {
        runs.push_back(ciRun(
            {command, outcome.output, sceneFile, sources, outcome.report, outcome.errors, outcome.isLinted ? &outcome.findings : nullptr}));
        if (outcomes.size() > 1) runs.back().scene += "." + outcome.output.filename().string();
    }
    const auto isWritten = [&](const std::filesystem::path& file) {
        return !file.empty() && (file == kStandardOutput || !session.paths.isRefused());
    };
    if (isWritten(junit_)) keep(session.write(junit_, junitReport(runs)));
    if (isWritten(sarif_)) keep(session.write(sarif_, sarifReport(runs)));
    return errors;
}

FailureDocuments FailureDocuments::of(CLI::App& command) {
    FailureDocuments documents;
    documents.command_ = command.get_name();
    for (const CLI::Option* option : command.get_options()) {
        if (option->results().empty()) continue;
        const std::string name = option->get_name();
        if (name == "--json" || name == "--junit" || name == "--sarif") documents.files_.emplace_back(name, option->results().back());
        if (option->get_positional() && documents.input_.empty()) documents.input_ = option->results().front();
    }
    return documents;
}

void FailureDocuments::write(const std::vector<Error>& errors, Terminal& terminal) const {
    bool isOutputUsed = false;
    for (const auto& [option, file] : files_) {
        if (file == kStandardOutput && std::exchange(isOutputUsed, true)) continue;
        const std::string text = textOf(option, errors);
        if (file == kStandardOutput)
            terminal.data(text);
        else if (auto written = writeFile(file, text, OutputLink::Follow); !written)
            terminal.error(written.error());
    }
}

std::string FailureDocuments::textOf(const std::string& option, const std::vector<Error>& errors) const {
    if (option == "--json") return pipeline::textOf(failureDocument({}, errors)) + "\n";
    const bool isFolder = command_ == "verify";
    const Json none;
    const CiRun run = ciRun({command_, isFolder ? input_ : "", isFolder ? "" : input_, {}, none, errors, nullptr});
    return option == "--junit" ? junitReport(run) : sarifReport(run);
}

void keepFindingsOnce(std::vector<Outcome>& outcomes) {
    std::set<std::string> known;
    for (Outcome& outcome : outcomes)
        std::erase_if(outcome.findings, [&](const Finding& finding) { return !known.insert(toJson(finding).dump()).second; });
}

void printCook(Session& session, const Outcome& outcome) {
    printFindings(session.terminal, outcome.findings);
    if (!outcome.report.is_object()) return;
    const auto report = fromJson<Report>(outcome.report, kReportName);
    if (!report) return;
    printClampedLight(session.terminal, *report);
    printRepairs(session.terminal, *report);
    if (report->assets.empty() && outcome.errors.empty()) printSkipped(session.terminal, *report);
    if (session.terminal.verbosity() == Verbosity::Quiet) return;
    if (session.terminal.isInteractive()) printReport(session.terminal, *report);
    printSummary(session.terminal, *report, outcome);
}

int finishCook(Session& session, const JsonOutput& json, Outcome outcome) {
    if (auto written = json.write(session, outcome.report, outcome.errors); !written) outcome.errors.push_back(written.error());
    printCook(session, outcome);
    return session.finish(outcome.errors);
}

}  // namespace lightcook::pipeline
