#include "bench/peer_layouts.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>

#include "bench/or_throw.h"
#include "pipeline/assets/textures.h"
#include "verify/light_map.h"
#include "verify/texture_unit.h"

namespace lightcook::bench {
namespace {

using compress::HdrMetric;
using formats::Image;
using formats::PixelFormat;
using lighting::ShRgb;

constexpr int kStripRows = 64;
constexpr std::size_t kLinearCount = 4;  ///< coefficients of bands 0 and 1
const float kSqrt3 = std::numbers::sqrt3_v<float>;

/// Calls work(firstRow, rowCount) for strips of whole blocks, on all threads.
template <class Work>
void forEachStripe(int height, Work work) {
    tbb::parallel_for(0, (height + kStripRows - 1) / kStripRows, [&](int index) {
        const int firstRow = index * kStripRows;
        work(firstRow, std::min(kStripRows, height - firstRow));
    });
}

/// Sets texels without significance to the mean of the significant ones of their block, as our own cook does. This favours the peers: at
/// chart edges the encoder of an engine gets texels that are harder to encode.
void fillBlocks(Image<glm::vec4>& texels, const Image<float>& significance) {
    constexpr int size = 4;
    for (int top = 0; top < texels.height(); top += size)
        for (int left = 0; left < texels.width(); left += size) {
            glm::vec4 sum(0);
            int count = 0;
            const auto visit = [&](const auto& act) {
                for (int y = top; y < std::min(top + size, texels.height()); ++y)
                    for (int x = left; x < std::min(left + size, texels.width()); ++x) act(texels.at(x, y), significance.at(x, y) > 0);
            };
            visit([&](const glm::vec4& texel, bool counts) {
                if (counts) sum += texel, ++count;
            });
            if (count == 0) continue;
            visit([&](glm::vec4& texel, bool counts) {
                if (!counts) texel = sum / static_cast<float>(count);
            });
        }
}

/// One texture of a layout. Its texels are a function of the bake's texel and of the decoded textures before it.
struct Texture {
    PixelFormat format = PixelFormat::Bc7;
    HdrMetric metric = HdrMetric::Log;
    float hdrScale = 1;
    std::function<glm::vec4(const ShRgb&, std::span<const glm::vec4>)> store;
};
struct TexelLayout {
    std::vector<Texture> textures;
    std::function<ShRgb(std::span<const glm::vec4>)> load;
};
constexpr std::size_t kMostTextures = 2 * lighting::kShCount;

/// Encodes a texture and returns its decoded texels.
Image<glm::vec4> throughBlocks(const Texture& texture, Image<glm::vec4> texels, const Image<float>& significance, int effort) {
    fillBlocks(texels, significance);
    compress::EncodeOptions options;
    options.effort = effort;
    options.hdrMetric = texture.metric;
    options.hdrScale = texture.hdrScale;
    compress::EncodeReport report;
    const std::vector<std::byte> bytes = pipeline::encodeImage(texture.format, texels.view(), significance.view(), options, report);
    const std::size_t rowBytes = formats::bytesPerBlockRow(texture.format, texels.width());
    const int blockHeight = formats::info(texture.format).blockHeight;
    forEachStripe(texels.height(), [&](int firstRow, int rowCount) {
        const auto strip = std::span(bytes).subspan(static_cast<std::size_t>(firstRow / blockHeight) * rowBytes,
                                                    static_cast<std::size_t>(formats::blocksDown(texture.format, rowCount)) * rowBytes);
        verify::decodeRows(texture.format, strip, texels.view().rows(firstRow, rowCount));
    });
    return texels;
}

double bitsOf(PixelFormat format) {
    const formats::PixelFormatInfo& facts = formats::info(format);
    return 8.0 * facts.bytesPerBlock / (facts.blockWidth * facts.blockHeight);
}

/// Runs every texel through the layout's store and load, with block compression between them (PeerMaps::seen) and without (ideal).
PeerMaps run(const TexelLayout& layout, const Bake& bake, int effort) {
    PeerMaps maps{0, Image<ShRgb>(bake.width(), bake.height()), Image<ShRgb>(bake.width(), bake.height())};
    std::vector<Image<glm::vec4>> decoded;
    std::array<glm::vec4, kMostTextures> texel{};
    const auto decodedAt = [&](int x, int y) {
        for (std::size_t t = 0; t < decoded.size(); ++t) texel[t] = decoded[t].at(x, y);
        return std::span<const glm::vec4>(texel).first(decoded.size());
    };
    for (const Texture& texture : layout.textures) {
        Image<glm::vec4> texels(bake.width(), bake.height(), glm::vec4(0, 0, 0, 1));
        for (int y = 0; y < bake.height(); ++y)
            for (int x = 0; x < bake.width(); ++x)
                if (bake.strip.covered.at(x, y) != 0) texels.at(x, y) = texture.store(bake.strip.sh.at(x, y), decodedAt(x, y));
        decoded.push_back(throughBlocks(texture, std::move(texels), bake.significance, effort));
        maps.bitsPerTexel += bitsOf(texture.format);
    }
    for (int y = 0; y < bake.height(); ++y)
        for (int x = 0; x < bake.width(); ++x) {
            if (bake.strip.covered.at(x, y) == 0) continue;
            maps.seen.at(x, y) = layout.load(decodedAt(x, y));
            for (std::size_t t = 0; t < layout.textures.size(); ++t)
                texel[t] = layout.textures[t].store(bake.strip.sh.at(x, y), std::span<const glm::vec4>(texel).first(t));
            maps.ideal.at(x, y) = layout.load(std::span<const glm::vec4>(texel).first(layout.textures.size()));
        }
    return maps;
}

/// Returns the divisor that brings the brightest coefficient well inside the range of a half. Engines use the exposure of the scene.
float hdrRange(const Bake& bake) {
    float largest = 0;
    for (int i = 0; i < lighting::kShCount; ++i) largest = std::max(largest, bake.measure.maximumAbsolute(i));
    return largest > 0 ? largest / 32768 : 1;
}
/// Returns the scale of HdrMetric::Log for textures divided by hdrRange(): above a tenth of the key errors count by their ratio, as in our
/// own layouts.
float logScale(const Bake& bake) {
    return std::max(1e-6f, 0.1f * static_cast<float>(bake.measure.key()) / hdrRange(bake));
}
Texture coefficientTexture(const Bake& bake, PixelFormat format, std::size_t coefficient) {
    const float range = hdrRange(bake);
    return {format, HdrMetric::Log, logScale(bake),
            [range, coefficient](const ShRgb& sh, std::span<const glm::vec4>) { return glm::vec4(sh[coefficient] / range, 1); }};
}

/// Returns a coefficient over coefficient 0, channel by channel; 0 where there is no light.
glm::vec3 ratioOf(const ShRgb& sh, std::size_t coefficient) {
    glm::vec3 ratio(0);
    for (int c = 0; c < 3; ++c)
        if (sh[0][c] > 0) ratio[c] = sh[coefficient][c] / sh[0][c];
    return ratio;
}

/// Measures band 0 in BC6H and three textures of band 1 over band 0 in `format`. Light that is nowhere negative keeps the ratio within
/// sqrt(3).
PeerMaps ratioLinear(const Bake& bake, int effort, PixelFormat format) {
    TexelLayout layout;
    layout.textures.push_back(coefficientTexture(bake, PixelFormat::Bc6hUf16, 0));
    for (std::size_t i = 1; i < kLinearCount; ++i)
        layout.textures.push_back({format, HdrMetric::Linear, 1, [i](const ShRgb& sh, std::span<const glm::vec4>) {
                                       const glm::vec3 unit = 0.5f + ratioOf(sh, i) / (2 * kSqrt3);
                                       return glm::vec4(glm::clamp(unit, 0.0f, 1.0f), 1);
                                   }});
    layout.load = [range = hdrRange(bake)](std::span<const glm::vec4> texels) {
        ShRgb sh{};
        sh[0] = range * glm::vec3(texels[0]);
        for (std::size_t i = 1; i < kLinearCount; ++i) sh[i] = sh[0] * (2 * kSqrt3) * (glm::vec3(texels[i]) - 0.5f);
        return sh;
    };
    return run(layout, bake, effort);
}
PeerMaps ratioLinearBc7(const Bake& bake, int effort) {
    return ratioLinear(bake, effort, PixelFormat::Bc7);
}
PeerMaps ratioLinearBc1(const Bake& bake, int effort) {
    return ratioLinear(bake, effort, PixelFormat::Bc1);
}

/// Measures Bakery's MonoSH: band 0 in BC6H, and one texture of band 1 over band 0 that the colours share. How the baker joins the colours
/// is not published. Here it is by luminance, which never leaves the range of the texture.
PeerMaps bakeryMono(const Bake& bake, int effort) {
    TexelLayout layout;
    layout.textures.push_back(coefficientTexture(bake, PixelFormat::Bc6hUf16, 0));
    layout.textures.push_back({PixelFormat::Bc7, HdrMetric::Linear, 1, [](const ShRgb& sh, std::span<const glm::vec4>) {
                                   const lighting::Sh luminance = lighting::luminance(sh, lighting::kRec709Luminance);
                                   glm::vec3 unit(0.5f);
                                   for (int i = 0; i < 3 && luminance[0] > 0; ++i)
                                       unit[i] += luminance[static_cast<std::size_t>(i) + 1] / (2 * kSqrt3 * luminance[0]);
                                   return glm::vec4(glm::clamp(unit, 0.0f, 1.0f), 1);
                               }});
    layout.load = [range = hdrRange(bake)](std::span<const glm::vec4> texels) {
        ShRgb sh{};
        sh[0] = range * glm::vec3(texels[0]);
        for (int i = 0; i < 3; ++i) sh[static_cast<std::size_t>(i) + 1] = 2 * kSqrt3 * (texels[1][i] - 0.5f) * sh[0];
        return sh;
    };
    return run(layout, bake, effort);
}

/// Measures the layout of Godot 4.4: all four images in BC6H unsigned, band 1 as clamp(L1 / (8 L0 + 1e-6) + 0.5, 0, 1).
PeerMaps godot(const Bake& bake, int effort) {
    TexelLayout layout;
    layout.textures.push_back(coefficientTexture(bake, PixelFormat::Bc6hUf16, 0));
    for (std::size_t i = 1; i < kLinearCount; ++i)
        layout.textures.push_back({PixelFormat::Bc6hUf16, HdrMetric::Linear, 1, [i](const ShRgb& sh, std::span<const glm::vec4>) {
                                       return glm::vec4(glm::clamp(sh[i] / (8.0f * sh[0] + 1e-6f) + 0.5f, 0.0f, 1.0f), 1);
                                   }});
    layout.load = [range = hdrRange(bake)](std::span<const glm::vec4> texels) {
        ShRgb sh{};
        sh[0] = range * glm::vec3(texels[0]);
        for (std::size_t i = 1; i < kLinearCount; ++i) sh[i] = 8.0f * sh[0] * (glm::vec3(texels[i]) - 0.5f);
        return sh;
    };
    return run(layout, bake, effort);
}

/// Unreal's two DXT5 images. The first holds the square roots of the colour over its largest channel, and log L in alpha. The second holds
/// one direction for all channels, and the residual of log L in alpha. L is the largest channel of the light of band 0, in units of the key
/// (the engine: of the exposure); its published black point is 2^-5.75. The direction is band 1 of the luminance over its band 0 and over
/// sqrt(3). The engine's max(0, ...) over directions is left out, because nine coefficients cannot express it.
struct UnrealForm {
    static constexpr float kBlack = 0.01858136f;
    float unit = 1;             ///< light of band 0 that is L = 1
    float low = 0, extent = 1;  ///< of log2 L over the map

    explicit UnrealForm(const Bake& bake) {
        if (bake.measure.key() > 0) unit = static_cast<float>(bake.measure.key() / lighting::kShConstant);
        float high = logOf(0);
        low = logOf(bake.measure.maximumAbsolute(0));
        for (int y = 0; y < bake.height(); ++y)
            for (int x = 0; x < bake.width(); ++x)
                if (bake.strip.covered.at(x, y) != 0) {
                    const float value = logOf(largest(bake.strip.sh.at(x, y)));
                    low = std::min(low, value), high = std::max(high, value);
                }
        extent = std::max(high - low, 1e-3f);
    }
    static float largest(const ShRgb& sh) { return std::max({sh[0].x, sh[0].y, sh[0].z, 0.0f}); }
    float logOf(float light) const { return std::log2(light / unit + kBlack); }
    float unitLog(const ShRgb& sh) const { return (logOf(largest(sh)) - low) / extent; }

    glm::vec4 color(const ShRgb& sh) const {
        const float l = largest(sh);
        const glm::vec3 uvw = l > 0 ? glm::max(sh[0], 0.0f) / l : glm::vec3(1);
        return {glm::sqrt(uvw), unitLog(sh)};
    }
    glm::vec4 direction(const ShRgb& sh, const glm::vec4& color) const {
        const lighting::Sh luminance = lighting::luminance(sh, lighting::kRec709Luminance);
        glm::vec3 unitDirection(0.5f);
        for (int i = 0; i < 3 && luminance[0] > 0; ++i)
            unitDirection[i] += luminance[static_cast<std::size_t>(i) + 1] / (2 * kSqrt3 * luminance[0]);
        return glm::clamp(glm::vec4(unitDirection, 0.5f + 255 * (unitLog(sh) - color.w)), 0.0f, 1.0f);
    }
    ShRgb load(const glm::vec4& color, const glm::vec4& direction) const {
        const float logL = low + extent * (color.w + (direction.w - 0.5f) / 255);
        ShRgb sh{};
        sh[0] = std::max(0.0f, std::exp2(logL) - kBlack) * unit * glm::vec3(color) * glm::vec3(color);
        for (int i = 0; i < 3; ++i) sh[static_cast<std::size_t>(i) + 1] = 2 * kSqrt3 * (direction[i] - 0.5f) * sh[0];
        return sh;
    }
};

PeerMaps unreal(const Bake& bake, int effort) {
    const UnrealForm form(bake);
    TexelLayout layout;
    layout.textures.push_back(
        {PixelFormat::Bc3, HdrMetric::Linear, 1, [&](const ShRgb& sh, std::span<const glm::vec4>) { return form.color(sh); }});
    layout.textures.push_back({PixelFormat::Bc3, HdrMetric::Linear, 1,
                               [&](const ShRgb& sh, std::span<const glm::vec4> before) { return form.direction(sh, before[0]); }});
    layout.load = [&](std::span<const glm::vec4> texels) { return form.load(texels[0], texels[1]); };
    return run(layout, bake, effort);
}

/// Measures nine coefficients, one texture each.
PeerMaps nine(const Bake& bake, int effort, PixelFormat first, PixelFormat others) {
    TexelLayout layout;
    for (std::size_t i = 0; i < lighting::kShCount; ++i) layout.textures.push_back(coefficientTexture(bake, i == 0 ? first : others, i));
    layout.load = [range = hdrRange(bake)](std::span<const glm::vec4> texels) {
        ShRgb sh{};
        for (std::size_t i = 0; i < sh.size(); ++i) sh[i] = range * glm::vec3(texels[i]);
        return sh;
    };
    return run(layout, bake, effort);
}
PeerMaps nineBc6h(const Bake& bake, int effort) {
    return nine(bake, effort, PixelFormat::Bc6hUf16, PixelFormat::Bc6hSf16);
}
PeerMaps nineHalf(const Bake& bake, int effort) {
    return nine(bake, effort, PixelFormat::Rgba16f, PixelFormat::Rgba16f);
}

/// Returns the direction of the luminance of band 1, with the weights of the engine's shader; 0 if that is 0.
glm::vec3 dominantDirection(const ShRgb& sh) {
    const lighting::Sh luminance = lighting::luminance(sh, glm::vec3(0.212656f, 0.715158f, 0.0721856f));
    const glm::vec3 direction(luminance[3], luminance[1], luminance[2]);
    const float length = glm::length(direction);
    return length > 0 ? direction / length : glm::vec3(0);
}

/// Measures the Luvw form of Hu's talk: length L and unit colour of each value, square roots of L in both alphas, and a second texture of
/// residuals against the decoded first. Each texture is encoded for the error of its own numbers.
/// values    returns the values that are stored for the light of a texel
/// restored  returns the light of stored values
PeerMaps talkLuvw(const Bake& bake, int effort, std::size_t count, ShRgb (*values)(const ShRgb&), ShRgb (*restored)(const ShRgb&)) {
    std::array<float, lighting::kShCount> range{};
    for (int y = 0; y < bake.height(); ++y)
        for (int x = 0; x < bake.width(); ++x) {
            const ShRgb stored = values(bake.strip.sh.at(x, y));
            for (std::size_t i = 0; i < count && bake.strip.covered.at(x, y) != 0; ++i)
                range[i] = std::max(range[i], glm::length(stored[i]));
        }
    TexelLayout layout;
    for (std::size_t i = 0; i < count; ++i) {
        const auto lengthOf = [=](const glm::vec3& v) { return range[i] > 0 ? glm::length(v) / range[i] : 0; };
        const auto colorOf = [](const glm::vec3& v) { return glm::length(v) > 0 ? 0.5f + 0.5f * glm::normalize(v) : glm::vec3(0.5f); };
        layout.textures.push_back({PixelFormat::Bc3, HdrMetric::Linear, 1, [=](const ShRgb& sh, std::span<const glm::vec4>) {
                                       const glm::vec3 value = values(sh)[i];
                                       return glm::vec4(colorOf(value), std::sqrt(lengthOf(value)));
                                   }});
        layout.textures.push_back({PixelFormat::Bc3, HdrMetric::Linear, 1, [=](const ShRgb& sh, std::span<const glm::vec4> before) {
                                       const glm::vec3 value = values(sh)[i];
                                       const glm::vec4& first = before[2 * i];
                                       const glm::vec3 left = 0.5f + colorOf(value) - glm::vec3(first);
                                       const float length = first.w > 0 ? lengthOf(value) / first.w : 0;
                                       return glm::clamp(glm::vec4(left, length), 0.0f, 1.0f);
                                   }});
    }
    layout.load = [=](std::span<const glm::vec4> texels) {
        ShRgb stored{};
        for (std::size_t i = 0; i < count; ++i) {
            const glm::vec4 &first = texels[2 * i], &second = texels[2 * i + 1];
            stored[i] = range[i] * first.w * second.w * (2.0f * (glm::vec3(first) + glm::vec3(second)) - 2.0f);
        }
        return restored(stored);
    };
    return run(layout, bake, effort);
}

/// Returns bands 0 and 1 and, in the place of coefficient 4, the dominant intensity.
ShRgb withIntensity(const ShRgb& sh) {
    ShRgb stored = sh;
    std::fill(stored.begin() + kLinearCount, stored.end(), glm::vec3(0));
    stored[kLinearCount] = dominantIntensity(sh);
    return stored;
}
ShRgb withoutIntensity(const ShRgb& stored) {
    return withDominantLight(stored, stored[kLinearCount]);
}
ShRgb unchanged(const ShRgb& sh) {
    return sh;
}
PeerMaps talkLinear(const Bake& bake, int effort) {
    return talkLuvw(bake, effort, kLinearCount + 1, withIntensity, withoutIntensity);
}
PeerMaps talkQuadratic(const Bake& bake, int effort) {
    return talkLuvw(bake, effort, lighting::kShCount, unchanged, unchanged);
}

/// Measures bands 0 and 1 as the bake's own floats.
PeerMaps truncation(const Bake& bake, int) {
    PeerMaps maps{kLinearCount * 3 * 32.0, bake.strip.sh.copy(), {}};
    for (ShRgb& sh : maps.ideal.texels()) std::fill(sh.begin() + kLinearCount, sh.end(), glm::vec3(0));
    maps.seen = maps.ideal.copy();
    return maps;
}

}  // namespace

Image<ShRgb> throughPlan(const compress::LightMapPlan& plan, const formats::LightMapStrip& strip, int effort) {
    compress::EncodeOptions options;
    options.effort = effort;
    const verify::CookedLightMap map{std::string(formats::info(plan.layout).name), plan.constants, plan.width, plan.height};
    const auto verifier = orThrow(verify::LightMapVerifier::create(map, {}, {}, plan.key));
    Image<ShRgb> out(plan.width, plan.height);
    forEachStripe(plan.height, [&](int firstRow, int rowCount) {
        const auto rows = compress::encodeLightMapRows(plan, strip, firstRow, rowCount, options);
        verify::DecodedLightMapRows texels{firstRow, {}};
        for (std::size_t t = 0; t < rows.textures.size(); ++t) {
            auto& layers = texels.textures.emplace_back();
            const glm::ivec2 size = plan.textures[t].sizeFor(plan.width, rowCount);
            for (const auto& bytes : rows.textures[t].layers)
                verify::decodeRows(plan.textures[t].format, bytes, layers.emplace_back(size.x, size.y).view());
        }
        const Image<ShRgb> seen = verifier.reconstruct(texels, firstRow, rowCount);
        std::ranges::copy(seen.texels(), out.view().row(firstRow));
    });
    return out;
}

glm::vec3 dominantIntensity(const ShRgb& sh) {
    const glm::vec3 direction = dominantDirection(sh);
    if (direction == glm::vec3(0)) return direction;
    // The squares of the nine basis functions add up to 9 / (4 pi) in every direction.
    return glm::max(4 * std::numbers::pi_v<float> / 9 * lighting::evaluate(sh, direction), 0.0f);
}

ShRgb withDominantLight(const ShRgb& linear, const glm::vec3& intensity) {
    ShRgb sh = linear;
    const glm::vec3 direction = dominantDirection(linear);
    const ShRgb light = lighting::projectDirectional(direction, direction == glm::vec3(0) ? direction : intensity);
    std::copy(light.begin() + kLinearCount, light.end(), sh.begin() + kLinearCount);
    return sh;
}

Bake::Bake(formats::LightMapStrip whole) : strip(std::move(whole)), significance(strip.sh.width(), strip.sh.height(), 0) {
    measure.add(strip);
    std::ranges::transform(strip.covered.texels(), significance.texels().begin(), [](std::uint8_t c) { return c != 0 ? 1.0f : 0.0f; });
}

Bake readBake(const std::filesystem::path& file) {
    const auto reader = orThrow(formats::LightMapReader::open(file, {}));
    return Bake(orThrow(reader.read(0, reader.height())));
}

const std::vector<PeerLayout>& peerLayouts() {
    static const std::vector<PeerLayout> layouts = {
        {"unreal", "Unreal, high quality: log L and colour, one direction, 2 DXT5", unreal},
        {"bakery-mono-sh", "Bakery MonoSH: L0 BC6H, one L1/L0 for the colours in BC7", bakeryMono},
        {"l0-bc6h+l1-bc1", "Frostbite-style: L0 BC6H, 3 L1/L0 BC1", ratioLinearBc1},
        {"l0-bc6h+l1-bc7", "Frostbite-style, and Bakery SH: L0 BC6H, 3 L1/L0 BC7", ratioLinearBc7},
        {"godot-4.4", "Godot 4.4: L0 and 3 L1/(8 L0), 4 BC6H", godot},
        {"nine-bc6h", "nine coefficients, 9 BC6H, bands 1 and 2 signed", nineBc6h},
        {"halo3-linear-talk", "Halo 3 as shipped: 4 Luvw and dominant intensity, 10 DXT5, coded as the talk says", talkLinear},
        {"halo3-quadratic-talk", "Halo 3: nine Luvw, 18 DXT5, coded as the talk says", talkQuadratic},
        {"l1-truncation", "bands 0 and 1 in floats", truncation},
        {"nine-rgba16f", "nine coefficients in halfs", nineHalf},
    };
    return layouts;
}

}  // namespace lightcook::bench
