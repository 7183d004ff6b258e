// Measures our own layouts like those of other engines: cooks with the actions of the program and decodes with the verifier.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/peer_layouts.h"

namespace lightcook::bench {

/// Returns the layouts that keep directions of light and that no peer layout equals: "raw" is the peer "nine-rgba16f".
std::vector<std::string> ourLayouts();

/// Cooks the bake in `file` with a layout for BC formats, as `lightcook cook` does, and decodes the cooked bytes. `ideal` is the same
/// layout in 16 bits a channel, with the same number of learned bases, so that nearly all of its error is that of the layout's form.
/// Throws std::runtime_error if the cook fails.
PeerMaps cookLayout(const Bake& bake, const std::filesystem::path& file, const std::string& layout, int effort);

}  // namespace lightcook::bench
