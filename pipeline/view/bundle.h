// The page of `lightcook view`, embedded in the program: what `npm run build` in viewer/ leaves in viewer/dist.
#pragma once

#include <span>
#include <string_view>

namespace lightcook::pipeline {

struct BundledFile {
    std::string_view path;  ///< relative to the page: "index.html"
    std::string_view bytes;
};

/// Returns the files of the page. None in a build without it (-DLIGHTCOOK_VIEWER=OFF).
std::span<const BundledFile> viewerBundle();

}  // namespace lightcook::pipeline
