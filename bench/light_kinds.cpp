#include "bench/light_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/gtc/type_precision.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bench/or_throw.h"
#include "compress/texel/half.h"
#include "formats/image.h"
#include "formats/png.h"
#include "lighting/sh.h"
#include "lighting/sphere.h"

namespace lightcook::bench {
namespace {

using glm::dvec2;
using glm::dvec3;
using lighting::kShCount;

constexpr double kPi = std::numbers::pi;
const dvec3 kSunDirection = glm::normalize(dvec3(0.55, 0.74, 0.38));

/// Side of a chart and distance between charts [texels].
struct Charts {
    int side, gap;
};

struct PointLight {
    dvec3 position;
    dvec3 intensity;  ///< [radiance times square metres]
};

struct Recipe {
    LightKind kind;
    Charts charts{28, 4};
    bool isHalf = true;
    int coefficients = kShCount;
    double unit = 1;  ///< factor of all light
    dvec3 even{0};    ///< radiance from every direction
    double sky = 0, sun = 0;
    double bounce = 0;       ///< light from the middle of the room, which falls from one end to the other
    int samples = 0;         ///< of a Monte-Carlo estimate
    double estimated = 0;    ///< share of the light that is estimated
    bool isUniform = false;  ///< every texel has the normal and the light of the first
    std::vector<PointLight> lights = {};
};

std::vector<PointLight> nightLights() {
    // Five decades, a colour each; far below the ceiling, so that each has its own pool of light.
    return {{{-0.8, 0.6, -0.8}, {8, 5, 1.5}},      {{0.85, -0.7, -0.6}, {0.1, 0.4, 0.8}},  {{-0.7, -0.85, 0.8}, {0.05, 0.01, 0.002}},
            {{0.6, 0.9, 0.9}, {2e-3, 3e-3, 1e-3}}, {{0.9, -0.9, 0.3}, {4e-4, 4e-4, 4e-4}}, {{-0.9, 0.9, 0.4}, {8e-5, 2e-5, 6e-5}}};
}

const std::vector<Recipe>& recipes() {
    static const std::vector<Recipe> kRecipes = [] {
        Recipe room{.kind = {"room", "a lamp, its light from the walls, and the shadow of a pillar"}};
        room.even = dvec3(0.05);
        room.bounce = 0.2;
        room.lights.push_back({{0.2, 0.8, -0.1}, {1.2, 0.9, 0.5}});
        const auto roomIn = [&](LightKind kind, Charts charts, double unit) {
            Recipe other = room;
            other.kind = kind;
            other.charts = charts;
            other.unit = unit;
            other.isHalf = unit == 1;
            return other;
        };
        Recipe red{.kind = {"red", "light without green and blue"}};
        red.even = dvec3(0.02, 0, 0);
        red.lights.push_back({{0.2, 0.8, -0.1}, {1, 0, 0}});
        Recipe weak{.kind = {"weak-directions", "nearly even light, a twentieth of it estimated by 16 samples a texel"}};
        weak.even = dvec3(0.6, 0.55, 0.5);
        weak.bounce = 0.02;
        weak.samples = 16;
        weak.estimated = 0.05;
        Recipe noise{.kind = {"noise", "light of a sky and a room, estimated by 16 samples a texel"}};
        noise.even = dvec3(0.4);
        noise.sky = 0.5;
        noise.bounce = 0.3;
        noise.samples = 16;
        noise.estimated = 1;
        return std::vector<Recipe>{
            room,
            {.kind = {"even", "white light of radiance 1 from everywhere"}, .even = dvec3(1)},
            weak,
            {.kind = {"one-colour", "the same light and normal in every texel"}, .even = dvec3(0.3, 0.2, 0.1), .isUniform = true},
            red,
            {.kind = {"sky", "an overcast sky alone"}, .sky = 1},
            {.kind = {"sun", "a sun alone, black in its shadow"}, .sun = 5},
            {.kind = {"sun-and-sky", "a sun and an overcast sky"}, .sky = 0.8, .sun = 5},
            {.kind = {"night", "small lamps over five decades, no other light"}, .lights = nightLights()},
            noise,
            {.kind = {"four-coefficients", "nearly even light, bands 0 and 1 alone"},
             .coefficients = 4,
             .even = dvec3(0.5),
             .bounce = 0.05},
            roomIn({"close-charts", "the room in charts one texel apart"}, {7, 1}, 1),
            roomIn({"single-texels", "the room in charts of one texel"}, {1, 2}, 1),
            roomIn({"tiny", "the room in a unit of 1e6"}, room.charts, 1e-6),
            roomIn({"huge", "the room in a unit of 1e-6"}, room.charts, 1e6),
        };
    }();
    return kRecipes;
}

const Recipe& recipeOf(std::string_view kind) {
    const auto& all = recipes();
    const auto found = std::ranges::find(all, kind, [](const Recipe& recipe) { return recipe.kind.name; });
    if (found != all.end()) return *found;
    std::string names;
    for (const Recipe& recipe : all) names += fmt::format("{}{}", names.empty() ? "" : ", ", recipe.kind.name);
    throw std::runtime_error(fmt::format("no kind of light is called '{}'; the kinds are {}", kind, names));
}

/// Random numbers that depend on the texel and the seed alone.
class Random {
public:
    Random(int x, int y, std::uint32_t seed)
        : state_(mixed((std::uint64_t{static_cast<std::uint32_t>(y)} << 32 | static_cast<std::uint32_t>(x)) ^ mixed(seed + 1ull))) {}
    /// Returns a number in [0, 1).
    double next() { return static_cast<double>(mixed(state_ += 0x9E3779B97F4A7C15ull) >> 11) * 0x1p-53; }

private:
    /// SplitMix64: Steele, Lea and Flood 2014, Fast Splittable Pseudorandom Number Generators.
    static std::uint64_t mixed(std::uint64_t z) {
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
        return z ^ (z >> 31);
    }
    std::uint64_t state_;
};

struct SurfacePoint {
    dvec3 position, normal;
};

/// Returns the surface of a texel; none between charts.
std::optional<SurfacePoint> surfaceAt(const Charts& charts, int x, int y, int size) {
    const int pitch = charts.side + charts.gap;
    if (x % pitch >= charts.side || y % pitch >= charts.side) return std::nullopt;
    // Each chart is cut from another place of the walls, all at one scale: the whole map shows an area of 6 by 6 metres.
    const int chart = y / pitch * ((size + pitch - 1) / pitch) + x / pitch;
    const double texel = 6.0 / size, extent = std::min(charts.side * texel, 2.0);
    const double across = (2 - extent) * std::fmod(0.5 + 0.7548776662 * chart, 1) - 1 + texel * (x % pitch + 0.5);
    const double down = (2 - extent) * std::fmod(0.5 + 0.5698402910 * chart, 1) - 1 + texel * (y % pitch + 0.5);
    const int wall = chart % 6, axis = wall / 2;
    const double side = wall % 2 == 0 ? 1 : -1;
    SurfacePoint point{dvec3(0), dvec3(0)};
    point.position[axis] = -side;
    point.position[(axis + 1) % 3] = std::clamp(across, -1.0, 1.0);
    point.position[(axis + 2) % 3] = std::clamp(down, -1.0, 1.0);
    point.normal[axis] = side;
    // The charts of one wall are round: the normal turns with the place.
    if (wall == 5) {
        point.normal[(axis + 1) % 3] = -0.8 * point.position[(axis + 1) % 3];
        point.normal = glm::normalize(point.normal);
    }
    return point;
}

/// Returns true if the pillar, a box from the floor up to y = 0.2, lies between two places.
bool isHidden(const dvec3& from, const dvec3& to) {
    constexpr std::array<double, 3> kLow = {0.25, -1, -0.15}, kHigh = {0.55, 0.2, 0.15};
    double enter = 1e-6, leave = 1 - 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis);
        const double step = to[axis] - from[axis];
        if (std::abs(step) < 1e-12) {
            if (from[axis] < kLow[at] || from[axis] > kHigh[at]) return false;
            continue;
        }
        const double a = (kLow[at] - from[axis]) / step, b = (kHigh[at] - from[axis]) / step;
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter < leave;
}

using Coefficients = std::array<dvec3, kShCount>;

void addDirection(Coefficients& sh, const dvec3& direction, const dvec3& light) {
    const lighting::ShDouble basis = lighting::evaluateBasis(direction);
    for (std::size_t i = 0; i < basis.size(); ++i) sh[i] += basis[i] * light;
}

/// Light of one recipe.
class Light {
public:
    Light(const Recipe& recipe, std::uint32_t seed) : recipe_(recipe), seed_(seed) {}

    Coefficients at(const SurfacePoint& point, int x, int y) {
        Coefficients sh{};
        if (recipe_.estimated < 1) addSmooth(sh, point);
        for (dvec3& coefficient : sh) coefficient *= 1 - recipe_.estimated;
        if (recipe_.estimated > 0) addSamples(sh, point, x, y);
        if (recipe_.sun > 0 && glm::dot(kSunDirection, point.normal) > 0 && !isHidden(point.position, point.position + 4.0 * kSunDirection))
            addDirection(sh, kSunDirection, recipe_.sun * dvec3(1, 0.9, 0.75));
        for (const PointLight& light : recipe_.lights) {
            const dvec3 toLight = light.position - point.position;
            if (glm::dot(toLight, point.normal) <= 0 || isHidden(point.position, light.position)) continue;
            const double square = glm::dot(toLight, toLight);
            addDirection(sh, toLight / std::sqrt(square), light.intensity / square);
        }
        for (std::size_t i = 0; i < sh.size(); ++i)
            sh[i] = i < static_cast<std::size_t>(recipe_.coefficients) ? recipe_.unit * sh[i] : dvec3(0);
        return sh;
    }

private:
    static dvec3 skyRadiance(const dvec3& direction) {
        return dvec3(0.8, 0.9, 1) * (std::max(direction.y, 0.0) > 0 ? (1 + 2 * direction.y) / 3 : 0);
    }
    /// Returns the share of the sky that reaches a place: more further up.
    static double openness(const dvec3& position) { return 0.7 + 0.3 * position.y; }
    dvec3 bounceAt(const dvec3& position) const { return recipe_.bounce * (1 + 0.8 * position.x) * dvec3(1, 0.8, 0.7); }
    static dvec3 toMiddle(const SurfacePoint& point) {
        return glm::normalize(glm::mix(point.normal, glm::normalize(-point.position), 0.5));
    }

    /// Adds light that every texel sees, by its integral. Even light over a hemisphere has 2 pi, pi and 0 in its three bands.
    void addSmooth(Coefficients& sh, const SurfacePoint& point) {
        sh[0] += 2 * kPi * lighting::kShConstant * recipe_.even;
        const dvec3 linear = kPi * lighting::kShLinear * dvec3(point.normal.y, point.normal.z, point.normal.x);
        for (int i = 0; i < 3; ++i) sh[static_cast<std::size_t>(1 + i)] += linear[i] * recipe_.even;
        addDirection(sh, toMiddle(point), bounceAt(point.position));
        if (recipe_.sky == 0) return;
        if (point.normal != skyNormal_) {
            constexpr int kDirections = 512;
            sky_ = {};
            skyNormal_ = point.normal;
            for (int i = 0; i < kDirections; ++i) {
                const dvec3 direction = lighting::fibonacciSphere(i, kDirections);
                if (glm::dot(direction, point.normal) > 0) addDirection(sky_, direction, 4 * kPi / kDirections * skyRadiance(direction));
            }
        }
        for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += recipe_.sky * openness(point.position) * sky_[i];
    }
    /// Adds the share that a Monte-Carlo estimate has, with light from the middle of the room as a wide lobe.
    void addSamples(Coefficients& sh, const SurfacePoint& point, int x, int y) const {
        const glm::dmat3 frame = lighting::worldFromTangentFrame(point.normal);
        const dvec3 middle = toMiddle(point);
        Random random(x, y, seed_);
        for (int i = 0; i < recipe_.samples; ++i) {
            const double z = random.next(), angle = 2 * kPi * random.next(), radius = std::sqrt(1 - z * z);
            const dvec3 direction = frame * dvec3(radius * std::cos(angle), radius * std::sin(angle), z);
            const double towards = std::max(0.0, glm::dot(direction, middle));
            const dvec3 radiance = recipe_.even + recipe_.sky * openness(point.position) * skyRadiance(direction) +
                                   towards * towards * bounceAt(point.position);
            addDirection(sh, direction, recipe_.estimated * 2 * kPi / recipe_.samples * radiance);
        }
    }

    const Recipe& recipe_;
    std::uint32_t seed_;
    dvec3 skyNormal_{0};
    Coefficients sky_{};
};

struct Texel {
    Coefficients sh{};
    dvec3 normal{0};
    bool isCovered = false;
};

/// Calls work(x, y, texel) for every texel, row by row.
template <class Work>
void forEachTexel(const Recipe& recipe, int size, std::uint32_t seed, Work&& work) {
    Light light(recipe, seed);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            Texel texel;
            if (const auto point = surfaceAt(recipe.charts, x, y, size)) {
                const SurfacePoint shown = recipe.isUniform ? *surfaceAt(recipe.charts, 0, 0, size) : *point;
                texel = {light.at(shown, x, y), shown.normal, true};
            }
            work(x, y, texel);
        }
}

/// Bytes of a file, in little-endian order.
class Bytes {
public:
    template <class T>
    void put(T value) {
        static_assert(std::endian::native == std::endian::little && std::is_trivially_copyable_v<T>);
        bytes_.append(std::bit_cast<std::array<char, sizeof(T)>>(value).data(), sizeof(T));
    }
    void put(std::string_view text) { bytes_.append(text).push_back('\0'); }
    std::size_t size() const { return bytes_.size(); }
    const std::string& text() const { return bytes_; }

private:
    std::string bytes_;
};

/// An OpenEXR file of scan lines without compression, whose channels are in the order of their names. Source: OpenEXR File Layout, in the
/// documentation of OpenEXR.
class ExrBytes {
public:
    struct Channel {
        std::string name;
        bool isHalf;
    };

    ExrBytes(std::vector<Channel> channels, int size) : channels_(std::move(channels)) {
        assert(std::ranges::is_sorted(channels_, {}, &Channel::name));
        file_.put(std::uint32_t{20000630});
        file_.put(std::uint32_t{2});
        Bytes list;
        std::uint32_t texelBytes = 0;
        for (const Channel& channel : channels_) {
            list.put(std::string_view(channel.name));
            for (const std::uint32_t value : {channel.isHalf ? 1u : 2u, 0u, 1u, 1u}) list.put(value);
            texelBytes += channel.isHalf ? 2 : 4;
        }
        list.put('\0');
        attribute("channels", "chlist", list);
        attribute("compression", "compression", '\0');
        const std::array<std::int32_t, 4> window = {0, 0, size - 1, size - 1};
        attribute("dataWindow", "box2i", window);
        attribute("displayWindow", "box2i", window);
        attribute("lineOrder", "lineOrder", '\0');
        attribute("pixelAspectRatio", "float", 1.0f);
        attribute("screenWindowCenter", "v2f", std::array<float, 2>{});
        attribute("screenWindowWidth", "float", 1.0f);
        file_.put('\0');
        rowBytes_ = texelBytes * static_cast<std::uint32_t>(size);
        const std::uint64_t first = file_.size() + 8ull * static_cast<std::uint64_t>(size);
        for (int y = 0; y < size; ++y) file_.put(first + static_cast<std::uint64_t>(y) * (8ull + rowBytes_));
    }
    /// Appends row y.
    /// values  [channel][x]
    void append(int y, const std::vector<std::vector<float>>& values) {
        file_.put(static_cast<std::int32_t>(y));
        file_.put(rowBytes_);
        for (std::size_t channel = 0; channel < channels_.size(); ++channel)
            for (const float value : values[channel]) {
                if (channels_[channel].isHalf)
                    file_.put(compress::halfFromFloat(value));
                else
                    file_.put(value);
            }
    }
    const std::string& text() const { return file_.text(); }

private:
    void attribute(std::string_view name, std::string_view type, const Bytes& value) {
        file_.put(name);
        file_.put(type);
        file_.put(static_cast<std::uint32_t>(value.size()));
        for (const char byte : value.text()) file_.put(byte);
    }
    template <class T>
    void attribute(std::string_view name, std::string_view type, const T& value) {
        Bytes bytes;
        bytes.put(value);
        attribute(name, type, bytes);
    }

    std::vector<Channel> channels_;
    std::uint32_t rowBytes_ = 0;
    Bytes file_;
};

void writeFile(const std::filesystem::path& file, const char* bytes, std::size_t size) {
    std::ofstream out(file, std::ios::binary);
    out.write(bytes, static_cast<std::streamsize>(size));
    out.close();
    if (!out) throw std::runtime_error(fmt::format("cannot write {}", file.string()));
}

}  // namespace

std::span<const LightKind> lightKinds() {
    static const std::vector<LightKind> kKinds = [] {
        std::vector<LightKind> kinds;
        for (const Recipe& recipe : recipes()) kinds.push_back(recipe.kind);
        return kinds;
    }();
    return kKinds;
}

void writeLightKind(const std::filesystem::path& file, std::string_view kind, int size, std::uint32_t seed) {
    const Recipe& recipe = recipeOf(kind);
    std::vector<ExrBytes::Channel> channels = {{"coverage.Y", true}, {"normal.X", false}, {"normal.Y", false}, {"normal.Z", false}};
    for (int i = 0; i < recipe.coefficients; ++i)
        for (const char colour : {'B', 'G', 'R'}) channels.push_back({fmt::format("sh{:02}.{}", i, colour), recipe.isHalf});
    std::vector<std::vector<float>> row(channels.size(), std::vector<float>(static_cast<std::size_t>(size)));
    ExrBytes exr(channels, size);
    forEachTexel(recipe, size, seed, [&](int x, int y, const Texel& texel) {
        const auto at = static_cast<std::size_t>(x);
        row[0][at] = texel.isCovered ? 1.0f : 0.0f;
        for (std::size_t axis = 0; axis < 3; ++axis) row[1 + axis][at] = static_cast<float>(texel.normal[static_cast<int>(axis)]);
        for (std::size_t channel = 4; channel < row.size(); ++channel)
            row[channel][at] = static_cast<float>(texel.sh[(channel - 4) / 3][2 - static_cast<int>((channel - 4) % 3)]);
        if (x + 1 == size) exr.append(y, row);
    });
    writeFile(file, exr.text().data(), exr.text().size());
}

void writeUnityLightKind(const std::filesystem::path& folder, std::string_view stem, std::string_view kind, int size, std::uint32_t seed) {
    const Recipe& recipe = recipeOf(kind);
    ExrBytes exr({{"B", true}, {"G", true}, {"R", true}}, size);
    std::vector<std::vector<float>> row(3, std::vector<float>(static_cast<std::size_t>(size)));
    formats::Image<glm::u8vec4> directions(size, size);
    forEachTexel(recipe, size, seed, [&](int x, int y, const Texel& texel) {
        // Exit radiance E(n) / pi of order 1 is Y0 sh0 + 2/3 Y1 . sh1, and Unity's D (n . d + 0.5) / w. All channels share d: that of their
        // sum.
        dvec3 direction(0);
        double grey = 0;
        for (int c = 0; c < 3; ++c) {
            grey += lighting::kShConstant * texel.sh[0][c];
            direction += 2.0 / 3 * lighting::kShLinear * dvec3(texel.sh[3][c], texel.sh[1][c], texel.sh[2][c]);
        }
        dvec3 d = grey > 0 ? 0.5 * direction / grey : dvec3(0);
        if (const double length = glm::length(d); length > 0.5) d *= 0.5 / length;
        const auto code = [](double value) { return static_cast<std::uint8_t>(std::clamp(std::round(255 * value), 0.0, 255.0)); };
        const double w = std::clamp(glm::dot(texel.normal, d) + 0.5, 1.0 / 255, 1.0);
        directions.at(x, y) = {code(d.x + 0.5), code(d.y + 0.5), code(d.z + 0.5), code(w)};
        for (int c = 0; c < 3; ++c)
            row[static_cast<std::size_t>(2 - c)][static_cast<std::size_t>(x)] =
                static_cast<float>(2 * w * lighting::kShConstant * texel.sh[0][c]);
        if (x + 1 == size) exr.append(y, row);
    });
    writeFile(folder / fmt::format("{}_light.exr", stem), exr.text().data(), exr.text().size());
    const std::vector<std::byte> png = orThrow(formats::encodePng(directions.view()));
    writeFile(folder / fmt::format("{}_dir.png", stem), reinterpret_cast<const char*>(png.data()), png.size());
}

}  // namespace lightcook::bench
