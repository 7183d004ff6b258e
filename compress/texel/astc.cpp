#include "compress/texel/astc.h"

#include <astcenc.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace lightcook::compress {
namespace {

using formats::ImageView;
using formats::PixelFormat;

/// Quality of libastcenc, 0 .. 100, for each effort; its presets are 0, 10, 60, 98, 99 and 100. Not every higher quality is better on
/// light; these are, in every format (tests/quality). 80 instead of 60 takes 40 % more time and gains 1.8 dB in HDR blocks of 4 x 4.
constexpr std::array<float, 10> kQuality = {0, 8, 15, 40, 60, 80, 90, 95, 99, 100};

struct ContextFree {
    void operator()(astcenc_context* context) const { astcenc_context_free(context); }
};
using Context = std::unique_ptr<astcenc_context, ContextFree>;

void check(astcenc_error status) {
    // The arguments are correct by construction, so only allocation can fail.
    if (status != ASTCENC_SUCCESS) throw std::runtime_error(std::string("libastcenc: ") + astcenc_get_error_string(status));
}

Context createContext(const formats::PixelFormatInfo& format, int effort, const std::array<float, 4>& channelWeights) {
    astcenc_config config;
    const auto blockWidth = static_cast<unsigned>(format.blockWidth), blockHeight = static_cast<unsigned>(format.blockHeight);
    check(astcenc_config_init(format.isFloat ? ASTCENC_PRF_HDR_RGB_LDR_A : ASTCENC_PRF_LDR, blockWidth, blockHeight, 1,
                              kQuality[static_cast<std::size_t>(effort)], 0, &config));
    config.cw_r_weight = channelWeights[0];
    config.cw_g_weight = channelWeights[1];
    config.cw_b_weight = channelWeights[2];
    config.cw_a_weight = channelWeights[3];
    astcenc_context* raw = nullptr;
    check(astcenc_context_alloc(&config, 1, &raw));
    return Context(raw);
}

/// Number of contexts that a thread keeps. It exceeds the number of textures of any light-map layout, whose strips alternate between
/// textures with channel weights of their own. A context takes about 4 MiB.
constexpr std::size_t kKeptContexts = 16;

/// Returns this thread's context for a format and options. Creating a context takes far longer than encoding a row of blocks, so each
/// thread keeps the last ones that it used. Results do not depend on earlier calls.
astcenc_context* contextFor(const formats::PixelFormatInfo& format, const EncodeOptions& options) {
    using Key = std::tuple<PixelFormat, int, std::array<float, 4>>;
    static thread_local std::vector<std::pair<Key, Context>> contexts;  // the last used one is the last element
    const int effort = std::clamp(options.effort, 0, 9);
    const Key key{format.format, effort, options.channelWeights};
    const auto known = std::find_if(contexts.begin(), contexts.end(), [&key](const auto& each) { return each.first == key; });
    if (known != contexts.end()) {
        std::rotate(known, known + 1, contexts.end());
    } else {
        Context created = createContext(format, effort, options.channelWeights);
        if (contexts.size() == kKeptContexts) contexts.erase(contexts.begin());
        contexts.emplace_back(key, std::move(created));
    }
    return contexts.back().second.get();
}

/// Replaces texels of significance 0 by the nearest significant texel of their block. The mean of the block instead would add a colour:
/// 0.3, 0.7 and 0.8 dB worse on light maps in blocks of 4, 6 and 8.
void fillFreeTexels(ImageView<glm::vec4> texels, ImageView<const float> significance, int blockWidth, int blockHeight) {
    struct Place {
        int x, y;
    };
    std::vector<Place> counting, free;
    for (int blockY = 0; blockY < texels.height; blockY += blockHeight)
        for (int blockX = 0; blockX < texels.width; blockX += blockWidth) {
            counting.clear(), free.clear();
            for (int y = blockY; y < std::min(blockY + blockHeight, texels.height); ++y)
                for (int x = blockX; x < std::min(blockX + blockWidth, texels.width); ++x)
                    (significance.at(x, y) > 0 ? counting : free).push_back({x, y});
            if (counting.empty()) continue;
            for (const Place& place : free) {
                const auto distance = [&place](const Place& other) {
                    return (other.x - place.x) * (other.x - place.x) + (other.y - place.y) * (other.y - place.y);
                };
                const auto nearest = std::min_element(counting.begin(), counting.end(),
                                                      [&](const Place& a, const Place& b) { return distance(a) < distance(b); });
                texels.at(place.x, place.y) = texels.at(nearest->x, nearest->y);
            }
        }
}

}  // namespace

void encodeAstc(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance, const EncodeOptions& options,
                std::span<std::byte> out, ImageView<glm::vec4> decoded) {
    const formats::PixelFormatInfo& formatInfo = formats::info(format);
    formats::Image<glm::vec4> source(texels.width, texels.height);
    for (int y = 0; y < texels.height; ++y) std::copy_n(texels.row(y), texels.width, source.view().row(y));
    if (significance.texels) fillFreeTexels(source.view(), significance, formatInfo.blockWidth, formatInfo.blockHeight);

    void* slice = source.texels().data();
    astcenc_image image{static_cast<unsigned>(texels.width), static_cast<unsigned>(texels.height), 1, ASTCENC_TYPE_F32, &slice};
    const astcenc_swizzle swizzle{ASTCENC_SWZ_R, ASTCENC_SWZ_G, ASTCENC_SWZ_B, ASTCENC_SWZ_A};
    astcenc_context* context = contextFor(formatInfo, options);
    auto* bytes = reinterpret_cast<std::uint8_t*>(out.data());
    check(astcenc_compress_image(context, &image, &swizzle, bytes, out.size(), 0));
    check(astcenc_compress_reset(context));
    if (!decoded.texels) return;
    check(astcenc_decompress_image(context, bytes, out.size(), &image, &swizzle, 0));
    check(astcenc_decompress_reset(context));
    for (int y = 0; y < texels.height; ++y) std::copy_n(source.view().row(y), texels.width, decoded.row(y));
}

}  // namespace lightcook::compress
