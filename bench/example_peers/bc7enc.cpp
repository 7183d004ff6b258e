// Example of a peer (bench/encoder_peer.h): bc7enc 1.08, a program that npm ships (@gpu-tex-enc/bc), with the encoders bc7e (BC7) and
// rgbcx (BC1, BC3, BC4, BC5). The program is the file `bc7enc` beside this peer.
#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string_view>
#include <vector>

#include "bench/encoder_peer.h"
#include "bench/example_peers/mapped_program.h"

namespace {

using Texels = std::array<std::uint32_t, 16>;  // a block, RGBA8, rows from the top

/// Parameters of bc7e; only its own functions read and write them.
struct alignas(64) Bc7eParameters {
    std::array<std::byte, 4096> bytes;
};

constexpr const char* kBc7eProfiles[] = {"bc7e ultrafast", "bc7e veryfast", "bc7e fast",   "bc7e basic",
                                         "bc7e slow",      "bc7e veryslow", "bc7e slowest"};

struct ColourProfile {
    const char* name;
    unsigned level;
};
constexpr ColourProfile kColourProfiles[] = {{"rgbcx 0", 0}, {"rgbcx 2", 2}, {"rgbcx 5", 5}, {"rgbcx 10", 10}, {"rgbcx 18", 18}};

struct ValueProfile {
    const char* name;
    unsigned radius;  ///< how far endpoints are searched [codes]; 0: the encoder without a search
};
constexpr ValueProfile kValueProfiles[] = {{"rgbcx", 0}, {"rgbcx, search 1", 1}, {"rgbcx, search 5", 5}, {"rgbcx, search 16", 16}};
constexpr unsigned kBothModes = 3;  // of BC4: six and eight values

/// The encoders of the program, with their tables made.
struct Encoders {
    void (*encodeBc7)(std::uint32_t count, std::uint64_t* blocks, const std::uint32_t* texels, const void* parameters);
    void (*encodeBc1)(unsigned level, void* block, const std::uint8_t* texels, bool allowThreeColours, bool useBlackOfThreeColours,
                      const std::uint8_t* before);
    void (*encodeBc3)(unsigned level, void* block, const std::uint8_t* texels);
    void (*encodeBc4)(void* block, const std::uint8_t* values, unsigned stride);
    void (*searchBc4)(void* block, const std::uint8_t* values, unsigned stride, unsigned radius, unsigned modes,
                      const std::uint8_t* forced);
    std::array<Bc7eParameters, std::size(kBc7eProfiles)> bc7eParameters;

    explicit Encoders(const lightcook::bench::MappedProgram& program) {
        program.function<void()>("bc7e_compress_block_init")();
        for (std::size_t i = 0; i < bc7eParameters.size(); ++i) {
            const std::string profile = std::string_view(kBc7eProfiles[i]).substr(5).data();
            constexpr bool isPerceptual = false;
            program.function<void(void*, bool)>("bc7e_compress_block_params_init_" + profile)(&bc7eParameters[i], isPerceptual);
        }
        constexpr int kIdealDecoder = 0;
        program.function<void(int)>("_ZN5rgbcx4initENS_15bc1_approx_modeE")(kIdealDecoder);
        encodeBc7 = program.function<std::remove_pointer_t<decltype(encodeBc7)>>("bc7e_compress_blocks");
        encodeBc1 = program.function<std::remove_pointer_t<decltype(encodeBc1)>>("_ZN5rgbcx10encode_bc1EjPvPKhbbS2_");
        encodeBc3 = program.function<std::remove_pointer_t<decltype(encodeBc3)>>("_ZN5rgbcx10encode_bc3EjPvPKh");
        encodeBc4 = program.function<std::remove_pointer_t<decltype(encodeBc4)>>("_ZN5rgbcx10encode_bc4EPvPKhj");
        searchBc4 = program.function<std::remove_pointer_t<decltype(searchBc4)>>("_ZN5rgbcx13encode_bc4_hqEPvPKhjjjS2_");
    }

    void encodeChannel(const ValueProfile& profile, const Texels& texels, int channel, std::byte* block) const {
        const auto* values = reinterpret_cast<const std::uint8_t*>(texels.data()) + channel;
        if (profile.radius == 0)
            encodeBc4(block, values, sizeof(std::uint32_t));
        else
            searchBc4(block, values, sizeof(std::uint32_t), profile.radius, kBothModes, nullptr);
    }
};

/// Returns the encoders, or null after a line on standard error that says what is wrong.
const Encoders* encoders() {
    static const std::unique_ptr<Encoders> loaded = []() -> std::unique_ptr<Encoders> {
        try {
            Dl_info peer{};
            static const char kHere = 0;
            dladdr(&kHere, &peer);
            const auto file = std::filesystem::path(peer.dli_fname).parent_path() / "bc7enc";
            return std::make_unique<Encoders>(lightcook::bench::MappedProgram(file.string()));
        } catch (const std::exception& error) {
            std::fprintf(stderr, "%s\n", error.what());
            return nullptr;
        }
    }();
    return loaded.get();
}

/// Returns the names of the profiles of a format.
std::vector<const char*> profilesOf(std::string_view format) {
    std::vector<const char*> names;
    if (format == "bc7") names.assign(std::begin(kBc7eProfiles), std::end(kBc7eProfiles));
    if (format == "bc1" || format == "bc3")
        for (const ColourProfile& each : kColourProfiles) names.push_back(each.name);
    if (format == "bc4" || format == "bc5")
        for (const ValueProfile& each : kValueProfiles) names.push_back(each.name);
    return names;
}

/// Encodes a row of blocks.
void encodeRow(std::string_view format, std::size_t profile, const std::vector<Texels>& row, std::byte* blocks) {
    const Encoders& use = *encoders();
    if (format == "bc7") {
        use.encodeBc7(static_cast<std::uint32_t>(row.size()), reinterpret_cast<std::uint64_t*>(blocks), row.front().data(),
                      &use.bc7eParameters[profile]);
        return;
    }
    const std::size_t bytes = format == "bc1" || format == "bc4" ? 8 : 16;
    for (const Texels& texels : row) {
        const auto* const values = reinterpret_cast<const std::uint8_t*>(texels.data());
        if (format == "bc1")
            use.encodeBc1(kColourProfiles[profile].level, blocks, values, true, false, nullptr);
        else if (format == "bc3")
            use.encodeBc3(kColourProfiles[profile].level, blocks, values);
        else
            use.encodeChannel(kValueProfiles[profile], texels, 0, blocks);
        if (format == "bc5") use.encodeChannel(kValueProfiles[profile], texels, 1, blocks + 8);
        blocks += bytes;
    }
}

}  // namespace

// NOLINTBEGIN(readability-identifier-naming): the names of the interface
extern "C" {

int32_t lightcook_peer_interface(void) {
    return LIGHTCOOK_PEER_INTERFACE;
}

const char* lightcook_peer_name(void) {
    return "bc7enc 1.08";
}

const char* lightcook_peer_profile(const char* format, int32_t profile) {
    const auto names = profilesOf(format);
    return profile >= 0 && static_cast<std::size_t>(profile) < names.size() ? names[static_cast<std::size_t>(profile)] : nullptr;
}

int32_t lightcook_peer_texels(const char*) {
    return LIGHTCOOK_PEER_RGBA8;
}

int32_t lightcook_peer_encode(const char* format, int32_t profile, const void* texels, int32_t width, int32_t height, void* blocks) {
    if (!lightcook_peer_profile(format, profile) || !encoders()) return 1;
    const auto* const source = static_cast<const std::uint32_t*>(texels);
    const auto across = static_cast<std::size_t>(width / 4);
    const std::string_view name = format;
    const std::size_t rowBytes = across * (name == "bc1" || name == "bc4" ? 8 : 16);
    std::vector<Texels> row(across);
    for (int y = 0; y < height; y += 4) {
        for (std::size_t x = 0; x < across; ++x)
            for (int line = 0; line < 4; ++line)
                std::copy_n(source + static_cast<std::size_t>(y + line) * static_cast<std::size_t>(width) + 4 * x, 4,
                            &row[x][4 * static_cast<std::size_t>(line)]);
        encodeRow(name, static_cast<std::size_t>(profile), row,
                  static_cast<std::byte*>(blocks) + static_cast<std::size_t>(y / 4) * rowBytes);
    }
    return 0;
}
}
// NOLINTEND(readability-identifier-naming)
