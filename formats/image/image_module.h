// The functions that need OpenImageIO, in a shared library that is loaded at first use. OpenImageIO depends on some 250 shared libraries
// (video, fonts, volumes, databases): linking it cost every command 0.15 s and 120 MiB before main() ran.
#pragma once

#include <cstdint>
#include <filesystem>

#include "formats/error.h"
#include "formats/plain_image.h"

namespace lightcook::formats {

/// The functions of the module, safe from several threads.
struct ImageModule {
    const char* version;  ///< version of lightcook that the module was built with; the functions of another version may differ
    /// See plain_image.h.
    /// progress   called now and then while a file is read; null: nobody asks
    Result<PlainImage> (*readImage)(const std::filesystem::path& file, void (*progress)());
    /// See memory.h, of which the module has a copy.
    void (*limitAvailableMemory)(std::uint64_t bytes);
};

/// Loads lightcook_images.so at the first call, from the folder of the running program, else from ../lib/lightcook relative to it. Safe
/// from several threads. The error says where it was searched, or why it does not load.
Result<const ImageModule*> imageModule();

/// Reads an image by the module, in a child process if readers are such (foreign_files.h).
Result<PlainImage> readImageByModule(const std::filesystem::path& file);

}  // namespace lightcook::formats

/// The one function that the module exports.
extern "C" const lightcook::formats::ImageModule* lightcookImageModule();
