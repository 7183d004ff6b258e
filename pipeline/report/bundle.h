// The pages, embedded in the program: what `npm run build` in viewer/ leaves in viewer/dist.
#pragma once

#include <span>
#include <string_view>

namespace lightcook::pipeline {

struct BundledFile {
    std::string_view path;  ///< relative to the page: "index.html"
    std::string_view bytes;
};

/// Returns the files of the page of `lightcook view`. None in a build without it (-DLIGHTCOOK_VIEWER=OFF).
std::span<const BundledFile> viewerBundle();

/// Returns the page of a report, with a comment at the place of its title, its table without scripts, and its data: `<!--title-->`,
/// `<!--table-->`, `<!--data-->`. A build without the pages has one without style and script.
std::string_view reportTemplate();

}  // namespace lightcook::pipeline
