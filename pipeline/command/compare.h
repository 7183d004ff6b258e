// lightcook compare: differences of two images, textures, light maps or cooked scenes.
#pragma once

#include <filesystem>
#include <vector>

#include "formats/error.h"
#include "formats/light_map.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// The differences of two files or folders.
struct Comparison {
    Json figures;
    std::vector<formats::Error> changed;  ///< of cooked scenes: an error for each file that does not match its own manifest
};

/// Compares two files or folders of one kind. The figures are
///   - of images or textures of one size: {"rmse","rel_rmse","log2_psnr_db","max_abs","channels","images"}, over the channels that both
///     have, and over all mips, layers and faces of textures
///   - of light maps: the errors of shaded light (compare_light_maps.h)
///   - of cooked scenes: bytes and errors of each asset. An asset is "same" if these figures, its constants and the contents of its files
///     are. "different_files" names the files of another content, "changed_since_cook" has the lines of `changed`.
/// Fails for conventions beside files that are no light maps.
/// ofA, ofB  conventions of the files, if they are light maps
formats::Result<Comparison> compareFiles(const std::filesystem::path& a, const std::filesystem::path& b, const RunState& state,
                                         const formats::LightMapDescription& ofA = {}, const formats::LightMapDescription& ofB = {});

}  // namespace lightcook::pipeline
