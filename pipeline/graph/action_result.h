// ActionResult of Bazel's Remote Execution API v2 (build/bazel/remote/execution/v2/remote_execution.proto), which caches of builds keep
// under ac/. Of its fields those that a cache looks at: the output files with their digests, and the exit code.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lightcook::pipeline {

struct OutputFile {
    std::string path, sha256;
    std::uint64_t bytes = 0;
    bool operator==(const OutputFile&) const = default;
};

/// Returns the message in protobuf's wire format.
std::string actionResultText(const std::vector<OutputFile>& files);
/// Returns the output files of a message in the wire format or in JSON. Nothing if it is damaged, has no output file, or is that of an
/// action that failed. Digests are 64 hexadecimal digits in lower case.
std::optional<std::vector<OutputFile>> readActionResult(const std::string& text);

}  // namespace lightcook::pipeline
