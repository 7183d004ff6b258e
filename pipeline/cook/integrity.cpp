#include "pipeline/cook/integrity.h"

#include <fmt/format.h>

#include <optional>

#include "pipeline/graph/digest.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/self_digest.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Returns an error if a file has another digest.
std::optional<Error> checkFile(const std::filesystem::path& file, const std::string& expected) {
    const auto digest = digestOfFile(file);
    if (!digest) return Error{ErrorCode::Verification, file, "found no readable file, expected the one that was cooked"};
    if (*digest == expected) return {};
    return Error{ErrorCode::Verification, file, fmt::format("found content {}, expected {} as cooked", *digest, expected)};
}

}  // namespace

std::vector<Error> checkReportFiles(const StagedFolder& folder, const std::string& manifestText, const Report& report) {
    std::vector<Error> errors;
    if (!report.files) return errors;
    for (const auto& [file, expected] : *report.files) {
        if (file != kManifestName) {
            if (auto error = checkFile(folder.of(file) / file, expected)) errors.push_back(std::move(*error));
        } else if (digestOfText(manifestText) != expected) {
            errors.push_back({ErrorCode::Verification, folder.folder / kReportName,
                              fmt::format("found the report of manifest {}, expected that of {}", expected, digestOfText(manifestText))});
        }
    }
    return errors;
}

std::vector<Error> checkDigests(const std::filesystem::path& folder, const Manifest& manifest) {
    std::vector<Error> errors;
    const auto add = [&](const Result<void>& checked) {
        if (!checked) errors.push_back(checked.error());
        return checked.has_value();
    };
    const auto text = readFile(folder / kManifestName);
    if (!text) return {text.error()};
    add(checkSelfDigest(*text, folder / kManifestName));
    for (const FileRecord& file : filesOf(manifest)) {
        auto error = checkFile(folder / file.name, file.digest);
        if (!error) continue;
        for (const CookedAsset& asset : manifest.assets)
            for (const FileRecord& own : filesOf(asset))
                if (own.name == file.name) error->asset = asset.name;
        errors.push_back(std::move(*error));
    }
    std::error_code code;
    if (!std::filesystem::exists(folder / kReportName, code)) return errors;
    const auto reportText = readFile(folder / kReportName);
    if (!reportText) {
        errors.push_back(reportText.error());
        return errors;
    }
    if (!add(checkSelfDigest(*reportText, folder / kReportName))) return errors;
    const auto report = loadReport(folder / kReportName);
    if (!report) {
        errors.push_back(report.error());
        return errors;
    }
    for (Error& error : checkReportFiles(folder, *text, *report)) errors.push_back(std::move(error));
    return errors;
}

Result<std::map<std::string, std::filesystem::path>> unchangedSources(const CookedAsset& asset,
                                                                      const std::filesystem::path& sceneDirectory) {
    std::map<std::string, std::filesystem::path> sources;
    if (!asset.source.files) return sources;
    for (const auto& [role, entry] : *asset.source.files) {
        const std::filesystem::path path = sceneDirectory / entry.file;
        LC_TRY(digest, digestOfFile(path));
        if (*digest != entry.digest)
            return failure(
                ErrorCode::Verification, path,
                fmt::format("found content {}, expected {}: the source changed after {} was cooked", *digest, entry.digest, asset.name));
        sources[role] = path;
    }
    return sources;
}

}  // namespace lightcook::pipeline
