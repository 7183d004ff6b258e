// Our own layouts as the peers are measured: through the cook's own actions, and back by the verifier.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/peer_layouts.h"

namespace lightcook::bench {

/// Names of the cook's layouts that keep light's directions and that no peer stands for already ("raw" is nine halfs).
std::vector<std::string> ourLayouts();

/// Cooks the bake in `file` with a layout for BC formats, as `lightcook cook` does, and opens it again from its bytes. `ideal` is the same
/// layout, with as many learned bases, in 16 bits a channel: they leave next to nothing but what the form itself loses. Throws
/// std::runtime_error where the cook refuses.
PeerMaps cookLayout(const Bake& bake, const std::filesystem::path& file, const std::string& layout, int effort);

}  // namespace lightcook::bench
