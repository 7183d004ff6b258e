#include "bench/peer_encoders.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <system_error>

#include "bench/encoder_peer.h"
#include "compress/texel/half.h"

namespace lightcook::bench {

namespace fs = std::filesystem;
using formats::ErrorCode, formats::failure, formats::PixelFormat, formats::Result;

struct PeerEncoder::Library {
    fs::path file;
    void* handle = nullptr;
    std::string name;
    decltype(&lightcook_peer_profile) profile = nullptr;
    decltype(&lightcook_peer_texels) texels = nullptr;
    decltype(&lightcook_peer_encode) encode = nullptr;

    Library() = default;
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;
    ~Library() {
        if (handle) ::dlclose(handle);
    }
    /// Sets a pointer to a function of the shared object. Returns false if it is missing.
    template <class Function>
    bool find(const char* symbol, Function& function) const {
        function = reinterpret_cast<Function>(::dlsym(handle, symbol));  // NOLINT: POSIX promises this conversion
        return function != nullptr;
    }
};

PeerEncoder::PeerEncoder(std::unique_ptr<Library> library) : library_(std::move(library)) {}
PeerEncoder::PeerEncoder(PeerEncoder&&) noexcept = default;
PeerEncoder& PeerEncoder::operator=(PeerEncoder&&) noexcept = default;
PeerEncoder::~PeerEncoder() = default;

Result<PeerEncoder> PeerEncoder::load(const fs::path& file) {
    auto library = std::make_unique<Library>();
    library->file = file;
    library->handle = ::dlopen(fs::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library->handle) {
        const char* reason = ::dlerror();
        return failure(ErrorCode::FileUnreadable, file,
                       fmt::format("the shared object does not load ({}); a peer is a *.so that exports the functions of encoder_peer.h",
                                   reason ? reason : "no reason given"));
    }
    const auto lacks = [&](const char* symbol) {
        return failure(
            ErrorCode::FormatUnsupported, file,
            fmt::format("found no function {}; a peer exports the five functions of bench/encoder_peer.h with C linkage", symbol));
    };
    decltype(&lightcook_peer_interface) interface = nullptr;
    decltype(&lightcook_peer_name) name = nullptr;
    if (!library->find("lightcook_peer_interface", interface)) return lacks("lightcook_peer_interface");
    if (!library->find("lightcook_peer_name", name)) return lacks("lightcook_peer_name");
    if (!library->find("lightcook_peer_profile", library->profile)) return lacks("lightcook_peer_profile");
    if (!library->find("lightcook_peer_texels", library->texels)) return lacks("lightcook_peer_texels");
    if (!library->find("lightcook_peer_encode", library->encode)) return lacks("lightcook_peer_encode");
    if (const std::int32_t version = interface(); version != LIGHTCOOK_PEER_INTERFACE)
        return failure(ErrorCode::FormatUnsupported, file,
                       fmt::format("found interface {}, expected {}; compile the peer with this bench/encoder_peer.h", version,
                                   LIGHTCOOK_PEER_INTERFACE));
    const char* const own = name();
    library->name = own && *own ? own : file.stem().string();
    return PeerEncoder(std::move(library));
}

const std::string& PeerEncoder::name() const {
    return library_->name;
}

std::vector<std::string> PeerEncoder::profiles(PixelFormat format) const {
    constexpr std::size_t kMost = 32;  // stops a peer that never returns NULL
    const std::string formatName(formats::info(format).name);
    std::vector<std::string> names;
    while (names.size() < kMost) {
        const char* const name = library_->profile(formatName.c_str(), static_cast<std::int32_t>(names.size()));
        if (!name) break;
        names.emplace_back(name);
    }
    return names;
}

Result<PeerTexels> PeerEncoder::convert(PixelFormat format, formats::ImageView<const glm::vec4> texels) const {
    const std::string formatName(formats::info(format).name);
    PeerTexels converted{library_->texels(formatName.c_str()), texels.width, texels.height, {}};
    const auto fill = [&](auto zero, const auto& valueOf) {
        using Value = decltype(zero);
        converted.bytes.resize(4 * sizeof(Value) * static_cast<std::size_t>(texels.width) * static_cast<std::size_t>(texels.height));
        std::byte* out = converted.bytes.data();
        for (int y = 0; y < texels.height; ++y)
            for (int x = 0; x < texels.width; ++x)
                for (int c = 0; c < 4; ++c) {
                    const Value value = valueOf(texels.row(y)[x][c]);
                    std::memcpy(out, &value, sizeof(value));
                    out += sizeof(value);
                }
    };
    const bool isSigned = formats::info(format).isSigned;
    switch (converted.type) {
        case LIGHTCOOK_PEER_RGBA32F:
            fill(0.0f, [](float value) { return value; });
            return converted;
        case LIGHTCOOK_PEER_RGBA16F:
            fill(std::uint16_t{0}, [](float value) { return compress::halfFromFloat(value); });
            return converted;
        case LIGHTCOOK_PEER_RGBA8:
            fill(std::uint8_t{0}, [isSigned](float value) {
                const float whole = std::round(std::clamp(value, isSigned ? -1.0f : 0.0f, 1.0f) * (isSigned ? 127.0f : 255.0f));
                return static_cast<std::uint8_t>(static_cast<int>(whole));
            });
            return converted;
        default:
            break;
    }
    return failure(
        ErrorCode::FormatUnsupported, library_->file,
        fmt::format("found texel type {} for {}, expected a LIGHTCOOK_PEER_RGBA* of bench/encoder_peer.h", converted.type, formatName));
}

Result<void> PeerEncoder::encode(PixelFormat format, int profile, const PeerTexels& texels, std::span<std::byte> blocks) const {
    const std::string formatName(formats::info(format).name);
    const std::int32_t status =
        library_->encode(formatName.c_str(), profile, texels.bytes.data(), texels.width, texels.height, blocks.data());
    if (status == 0) return {};
    return failure(ErrorCode::Internal, library_->file,
                   fmt::format("lightcook_peer_encode returned {} for {}, profile {}, {} x {} texels; repair the peer, or leave the format "
                               "out with --formats",
                               status, formatName, profile, texels.width, texels.height));
}

Result<std::vector<PeerEncoder>> loadPeerEncoders(const fs::path& folder) {
    std::error_code error;
    std::vector<fs::path> files;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
        if (entry->path().extension() == ".so") files.push_back(entry->path());
    if (error) return failure(ErrorCode::FileUnreadable, folder, error.message() + "; --peers takes a folder of shared objects");
    if (files.empty())
        return failure(ErrorCode::FileUnreadable, folder,
                       "found no *.so; build a peer into it, for example bench/example_peers (docs/guide/benchmark-peers.md)");
    std::sort(files.begin(), files.end());
    std::vector<PeerEncoder> peers;
    for (const fs::path& file : files) {
        Result<PeerEncoder> peer = PeerEncoder::load(file);
        if (!peer) return tl::make_unexpected(std::move(peer.error()));
        peers.push_back(std::move(*peer));
    }
    return peers;
}

}  // namespace lightcook::bench
