// MODULE_fuzz, of the preset `fuzz`: LIGHTCOOK_FUZZ=texture formats_fuzz [libFuzzer's options] CORPUS...
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "tests/fuzz/target.h"

namespace {

const lightcook::fuzz::Target& chosenTarget() {
    const char* const name = std::getenv("LIGHTCOOK_FUZZ");
    for (const lightcook::fuzz::Target& target : lightcook::fuzz::targets())
        if (name != nullptr && target.name == name) return target;
    std::fputs("set LIGHTCOOK_FUZZ to one of:", stderr);
    for (const lightcook::fuzz::Target& target : lightcook::fuzz::targets())
        std::fprintf(stderr, " %.*s", static_cast<int>(target.name.size()), target.name.data());
    std::fputs("\n", stderr);
    std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {  // NOLINT(readability-identifier-naming)
    static const lightcook::fuzz::Target& target = chosenTarget();
    target.take({reinterpret_cast<const std::byte*>(data), size});
    return 0;
}
