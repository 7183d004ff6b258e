// lightcook-read: decodes files for lightcook behind walls. It finds a socket as descriptor 3.
#include <sys/stat.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "formats/image/image_module.h"
#include "formats/reader/decoders.h"
#include "formats/reader/one_file.h"
#include "formats/reader/reader_server.h"

namespace lightcook::formats {
namespace {

Result<void> prepare(ReaderFamily family) {
    if (family == ReaderFamily::Files) return {};
    // Libraries that compute with threads would start those when they are loaded, and a fork has none of them.
    for (const char* const name : {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"}) ::setenv(name, "1", 1);
    LC_TRY(module, imageModule());
    return {};
}

constexpr ReaderProgram kProgram = {{decodeExrBehindWall, decodeImageBehindWall, decodeDracoBehindWall, measureDracoBehindWall},
                                    prepare,
                                    [](const ForeignInput& input) { allowOneFile(input.path, input.descriptor); }};

int run(int argc, const char* const* argv) {
    struct stat status {};
    const auto family = argc == 2 ? std::ranges::find(kFamilyNames, std::string_view(argv[1])) : kFamilyNames.end();
    if (family == kFamilyNames.end() || ::fstat(kServerSocket, &status) != 0 || !S_ISSOCK(status.st_mode)) {
        std::fputs("lightcook-read " LIGHTCOOK_VERSION " decodes files for lightcook, which starts it\n", stderr);
        return 2;
    }
    return serveReaders(static_cast<ReaderFamily>(family - kFamilyNames.begin()), kProgram);
}

}  // namespace
}  // namespace lightcook::formats

int main(int argc, char** argv) {
    return lightcook::formats::run(argc, argv);
}
