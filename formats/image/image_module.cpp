#include "formats/image/image_module.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <array>
#include <string_view>
#include <system_error>

#include "formats/file/one_line.h"
#include "formats/process.h"

namespace lightcook::formats {
namespace {

constexpr const char* kFileName = "lightcook_images.so";

/// The library beside the program, or where an installation puts it.
Result<std::filesystem::path> findModule() {
    LC_TRY(folder, programFolder());
    const std::array<std::filesystem::path, 2> places = {*folder / kFileName, folder->parent_path() / "lib/lightcook" / kFileName};
    std::error_code error;
    for (const std::filesystem::path& place : places)
        if (std::filesystem::exists(place, error)) return place;
    return failure(ErrorCode::Internal, kFileName,
                   fmt::format("found neither {} nor {}, expected the library that reads images", places[0].string(), places[1].string()));
}

Result<const ImageModule*> loadModule() {
    const Result<std::filesystem::path> file = findModule();
    if (!file) return tl::make_unexpected(file.error());
    const auto fault = [&file](std::string_view found) {
        return failure(ErrorCode::Internal, file->string(),
                       fmt::format("found {}, expected the library that reads images", quotedLine(found)));
    };
    // Never closed: OpenImageIO keeps state that outlives any one image.
    void* const library = dlopen(file->c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return fault(dlerror());
    const auto entry = reinterpret_cast<decltype(&lightcookImageModule)>(dlsym(library, "lightcookImageModule"));
    if (entry == nullptr) return fault(dlerror());
    const ImageModule* const module = entry();
    if (std::string_view(module->version) != LIGHTCOOK_VERSION)
        return fault(fmt::format("lightcook {} instead of {}", module->version, LIGHTCOOK_VERSION));
    return module;
}

}  // namespace

Result<const ImageModule*> imageModule() {
    static const Result<const ImageModule*> module = loadModule();
    return module;
}

}  // namespace lightcook::formats
