// What formats needs OpenImageIO for, behind a library of its own. OpenImageIO brings some 250 shared libraries with it (video, fonts,
// volumes, databases): merely linking it cost every command 0.15 s and 120 MiB before main() ran, also those that never read an image.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "formats/environment.h"
#include "formats/error.h"
#include "formats/image.h"

namespace lightcook::formats {

/// The functions of the module, safe from several threads.
struct ImageModule {
    const char* version;  ///< of the lightcook it was built with; another one's functions may look different
    /// R, G and B of any image as stored; refuses files without the three.
    Result<Image<glm::vec3>> (*readRgb)(const std::filesystem::path& file);
    /// As environment.h describes them.
    Result<PlainImage> (*readImage)(const std::filesystem::path& file);
    Result<std::vector<std::byte>> (*encodePng)(ImageView<const glm::u8vec3> texels);
};

/// Loads lightcook_images.so at the first call: from the folder of the running program, else from ../lib/lightcook seen from there. Safe
/// from several threads; an Error says where it was sought, or why it does not load.
Result<const ImageModule*> imageModule();

}  // namespace lightcook::formats

/// What the module exports.
extern "C" const lightcook::formats::ImageModule* lightcookImageModule();
