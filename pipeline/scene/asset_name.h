// Names of assets and scenes that are made from names of files: `init` and the converters of one asset give the same.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace lightcook::pipeline {

/// Returns a name that an asset or a scene may have: that of a file without its extension, as far as it may. Other letters become '_', and
/// one more '_' stands before a name that begins with '.' or that Windows reserves. Of a name in another script, without a Latin letter,
/// digits and signs are kept after `otherwise`.
/// otherwise  kind of the asset, such as "probe"
std::string assetNameOf(const std::filesystem::path& file, std::string_view otherwise);

/// Returns the name of a light map: that of its file, without the ending that the files of its bake format have (formats::nameOfBake).
/// bake  name of the bake format that it was recognised as
std::string lightMapNameOf(const std::filesystem::path& file, std::string_view bake);

}  // namespace lightcook::pipeline
