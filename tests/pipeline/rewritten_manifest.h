// Writes a manifest that a test changed, with the digests that a cook would have written: the checks behind the digests then meet the
// change.
#pragma once

#include "pipeline/document/json.h"
#include "pipeline/graph/digest.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/manifest/self_digest.h"
#include "pipeline/report/report.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {

inline void writeManifestAndDigests(const std::filesystem::path& folder, const Json& manifest) {
    const std::string text = withSelfDigest(manifest);
    formats::writeContent(folder / kManifestName, text);
    if (!std::filesystem::exists(folder / kReportName)) return;
    Json report = parseJson(formats::contentOf(folder / kReportName));
    for (Json& file : report["files"])
        if (file.at("file") == kManifestName) file["digest"] = digestOfText(text);
    formats::writeContent(folder / kReportName, withSelfDigest(report));
}

}  // namespace lightcook::pipeline
