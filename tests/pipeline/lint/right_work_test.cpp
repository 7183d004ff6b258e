// Right bakes of every kind of light, in halves and floats, in every unit and bake format that a test can write: lint warns of none of
// them. Each is the light of a sum of sources in front of the surface, as a baker without noise or filter has it.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>
#include <numbers>
#include <vector>

#include "formats/image/exr_file.h"
#include "lighting/sh.h"
#include "lighting/sphere.h"
#include "pipeline/cook/cook.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline::right_work {
namespace {

using glm::dvec3;
using testing::IsEmpty;

constexpr int kBakeSide = 48;

struct Ray {
    dvec3 towards;
    dvec3 light;  ///< radiance times solid angle
};
using Light = std::function<std::vector<Ray>(const dvec3& normal, const glm::dvec2& place)>;

/// A texel: a floor, a wall, a ceiling, and a pillar of eight sides whose normals are smooth, as modelling programs make them.
struct Surface {
    dvec3 face, shaded;
};
Surface surfaceAt(int x, int y) {
    const int half = kBakeSide / 2;
    if (y < half) return x < half ? Surface{{0, 1, 0}, {0, 1, 0}} : Surface{{0, 0, 1}, {0, 0, 1}};
    if (x < half) return {{0, -1, 0}, {0, -1, 0}};
    const double around = 2 * std::numbers::pi * (x - half + 0.5) / half, side = std::numbers::pi / 4;
    const double face = (std::floor(around / side) + 0.5) * side;
    return {{std::cos(face), 0, std::sin(face)}, {std::cos(around), 0, std::sin(around)}};
}

double seeded(int i) {
    return std::fmod(std::abs(std::sin(12.9898 * i + 4.1) * 43758.5453), 1.0);
}
dvec3 direction(int i, int count) {
    const double z = 1 - (2.0 * i + 1) / count, angle = i * std::numbers::pi * (3 - std::sqrt(5.0)), r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), z, r * std::sin(angle)};
}

std::vector<Ray> even(const dvec3&, const glm::dvec2&) {
    std::vector<Ray> rays;
    for (int i = 0; i < 512; ++i) rays.push_back({direction(i, 512), dvec3(0.02)});
    return rays;
}
std::vector<Ray> sky(const dvec3&, const glm::dvec2&) {
    std::vector<Ray> rays;
    for (int i = 0; i < 256; ++i) rays.push_back({direction(i, 512), dvec3(0.02, 0.025, 0.04)});
    return rays;
}
std::vector<Ray> sun(const dvec3&, const glm::dvec2&) {
    return {{glm::normalize(dvec3(0.9, 0.12, 0.41)), dvec3(20, 18, 15)}};
}
std::vector<Ray> sunAndSkyOf(const dvec3& normal, const glm::dvec2& place) {
    std::vector<Ray> rays = sky(normal, place);
    rays.push_back(sun(normal, place).front());
    return rays;
}
/// Small lamps over a street: each texel has the light of one, or of a few, over five decades.
std::vector<Ray> lamps(const dvec3&, const glm::dvec2& place) {
    std::vector<Ray> rays;
    for (int i = 0; i < 4; ++i) {
        const dvec3 offset(10 * (seeded(i) - place.x), 0.3 + 0.3 * seeded(i + 9), 10 * (seeded(i + 17) - place.y));
        const double distance = glm::length(offset);
        rays.push_back({offset / distance, dvec3(1, 0.7, 0.4) * std::pow(distance, -5.0)});
    }
    return rays;
}
std::vector<Ray> oneColour(const dvec3& normal, const glm::dvec2& place) {
    std::vector<Ray> rays = sunAndSkyOf(normal, place);
    for (Ray& ray : rays) ray.light *= dvec3(1, 0, 0);
    return rays;
}
/// Sixteen samples a texel, as of a preview.
std::vector<Ray> noise(const dvec3&, const glm::dvec2& place) {
    std::vector<Ray> rays;
    const int seed = static_cast<int>(9973 * place.x + 104729 * place.y);
    for (int i = 0; i < 16; ++i)
        rays.push_back({direction(static_cast<int>(4096 * seeded(seed + 31 * i)), 4096), dvec3(std::pow(seeded(seed + 7 * i), 4.0))});
    return rays;
}

struct LightCase {
    const char* name;
    Light light;
};
const std::vector<LightCase>& lights() {
    static const std::vector<LightCase> cases = {
        {"even", even},  {"sky", sky}, {"sun", sun}, {"sun and sky", sunAndSkyOf}, {"lamps", lamps}, {"one colour", oneColour},
        {"noise", noise}};
    return cases;
}

/// The rays in front of the surface at a texel.
std::vector<Ray> raysAt(const Light& light, int x, int y) {
    const Surface surface = surfaceAt(x, y);
    std::vector<Ray> rays = light(surface.face, {(x + 0.5) / kBakeSide, (y + 0.5) / kBakeSide});
    std::erase_if(rays, [&](const Ray& ray) { return glm::dot(ray.towards, surface.face) <= 0; });
    return rays;
}

float asHalf(double value) {
    return glm::unpackHalf1x16(glm::packHalf1x16(static_cast<float>(value)));
}

/// Sums over the rays of a texel: of their light, and of their light times their direction.
struct Sums {
    dvec3 light{0};
    std::array<dvec3, 3> linear{};  ///< by axis
};
Sums sumsOf(const std::vector<Ray>& rays) {
    Sums sums;
    for (const Ray& ray : rays) {
        sums.light += ray.light;
        for (int axis = 0; axis < 3; ++axis) sums.linear[static_cast<std::size_t>(axis)] += ray.light * ray.towards[axis];
    }
    return sums;
}

class RightBake {
public:
    std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
    /// Writes channels; texel  their values
    template <class Texel>
    void writeExr(const std::string& name, int height, std::vector<std::string> channels, Texel&& texel) const {
        std::vector<float> rows;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < kBakeSide; ++x) {
                const std::vector<float> values = texel(x, y);
                rows.insert(rows.end(), values.begin(), values.end());
            }
        const auto stride = static_cast<std::ptrdiff_t>(channels.size()) * kBakeSide;
        auto writer = formats::ExrWriter::create(folder_ / name, kBakeSide, height, std::move(channels), formats::ExrLayout::ScanLines);
        ASSERT_TRUE(writer && writer->append(rows.data(), stride, height) && writer->commit());
    }
    /// Returns the codes of the findings under --strict, notes in brackets.
    std::vector<std::string> findings(const std::string& keys) const {
        formats::writeContent(folder_ / "scene.toml", "schema = 1\nname = \"right\"\n[[light_map]]\nname = \"map\"\n" + keys + "\n");
        const RunState state;
        const Outcome outcome = lintScene({folder_ / "scene.toml", folder_ / "cache", true, false}, state);
        std::vector<std::string> codes;
        for (const Finding& finding : outcome.findings)
            codes.push_back(fmt::format(fmt::runtime(finding.isNote() ? "[{}]" : "{}"), info(finding.check).name));
        for (const formats::Error& error : outcome.errors) codes.push_back(error.line());
        return codes;
    }

private:
    formats::TemporaryFolder folder_;
};

std::vector<std::string> shChannelsAndSurface(int count) {
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i)
        for (const char colour : {'R', 'G', 'B'}) names.push_back(fmt::format("sh{:02}.{}", i, colour));
    for (const char* name : {"coverage.Y", "normal.X", "normal.Y", "normal.Z"}) names.emplace_back(name);
    return names;
}

/// Writes coefficients, as halves or floats.
void writeSh(const RightBake& bake, const Light& light, int count, double unit, bool isHalf) {
    bake.writeExr("room.exr", kBakeSide, shChannelsAndSurface(count), [&](int x, int y) {
        std::array<dvec3, lighting::kShCount> sh{};
        for (const Ray& ray : raysAt(light, x, y)) {
            const lighting::ShDouble basis = lighting::evaluateBasis(ray.towards);
            for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += unit * basis[i] * ray.light;
        }
        std::vector<float> values;
        for (int i = 0; i < count; ++i)
            for (int c = 0; c < 3; ++c) {
                const double value = sh[static_cast<std::size_t>(i)][c];
                values.push_back(isHalf ? asHalf(value) : static_cast<float>(value));
            }
        values.push_back(1);
        for (int axis = 0; axis < 3; ++axis) values.push_back(asHalf(surfaceAt(x, y).shaded[axis]));
        return values;
    });
}

TEST(LintRightWork, CoefficientsOfAnyLightHaveNoFinding) {
    for (const auto& [name, light] : lights())
        for (const bool isHalf : {false, true})
            for (const int count : {9, 4}) {
                SCOPED_TRACE(fmt::format("{}, {}, {} coefficients", name, isHalf ? "halves" : "floats", count));
                const RightBake bake;
                writeSh(bake, light, count, 1, isHalf);
                EXPECT_THAT(bake.findings("file = \"room.exr\"\nfirefly_limit = 0"), IsEmpty());
            }
}

/// Halves below 6e-5 have fewer bits, so that light of one lamp lies far over the border of what light can be.
TEST(LintRightWork, CoefficientsInAnyUnitHaveNoWarning) {
    for (const auto& [name, light] : lights())
        for (const double unit : {1e-7, 1e-6, 1e-5, 1e-3, 100.0}) {
            SCOPED_TRACE(fmt::format("{} times {}", name, unit));
            const RightBake bake;
            writeSh(bake, light, 9, unit, true);
            EXPECT_THAT(bake.findings("file = \"room.exr\"\nfirefly_limit = 0"), testing::Each(testing::StartsWith("[")));
        }
}

/// Light of the brightness of a directional light map of Godot: rays count as 1/4 in L0, and by their direction in L1.
TEST(LintRightWork, ADirectionalBakeOfGodotHasNoFinding) {
    for (const auto& [name, light] : lights()) {
        SCOPED_TRACE(name);
        const RightBake bake;
        bake.writeExr("room.exr", 4 * kBakeSide, {"R", "G", "B"}, [&, &light = light](int x, int y) {
            const Sums sums = sumsOf(raysAt(light, x, y % kBakeSide));
            const int slice = y / kBakeSide;
            std::vector<float> values;
            for (int c = 0; c < 3; ++c) {
                const double first = sums.light[c] / 4;
                constexpr std::array kAxes = {0, 1, 2, 0};  // of slices L0, y, z, x
                const double component = sums.linear[static_cast<std::size_t>(kAxes[static_cast<std::size_t>(slice)])][c];
                values.push_back(asHalf(slice == 0 ? first : std::clamp(component / (8 * first + 1e-6) + 0.5, 0.0, 1.0)));
            }
            return values;
        });
        formats::writeContent(bake / "room.exr.import", "importer=\"2d_array_texture\"\nslices/horizontal=1\nslices/vertical=4\n");
        for (const char* format : {"godot", "godot-radiance"})
            EXPECT_THAT(bake.findings(fmt::format("file = \"room.exr\"\nbake = \"{}\"\nfirefly_limit = 0", format)),
                        testing::Each("[missing-coverage]"))
                << format;
    }
}

/// The formats of Bakery and Unity, directions in 8 bits.
TEST(LintRightWork, BakesForUnityHaveNoFinding) {
    const auto byteOf = [](double share) { return static_cast<int>(std::lround(255 * std::clamp(share, 0.0, 1.0))); };
    for (const auto& [name, light] : lights()) {
        SCOPED_TRACE(name);
        const auto at = [&, &light = light](int x, int y) { return sumsOf(raysAt(light, x, y)); };
        const auto grey = [](const dvec3& colour) { return colour.x + colour.y + colour.z; };
        const auto towards = [&](int axis, int x, int y) {  // mean direction, at most 1 long
            const Sums sums = at(x, y);
            const double all = grey(sums.light);
            return all > 0 ? grey(sums.linear[static_cast<std::size_t>(axis)]) / all : 0.0;
        };
        const RightBake bake;
        for (const char* file : {"sh_L0.exr", "mono_L0.exr", "unity_light.exr", "level_final.exr"})
            bake.writeExr(file, kBakeSide, {"R", "G", "B"}, [&](int x, int y) {
                const dvec3 colour = at(x, y).light / 4.0;
                return std::vector<float>{asHalf(colour.x), asHalf(colour.y), asHalf(colour.z)};
            });
        for (int axis = 0; axis < 3; ++axis)
            formats::writePng(bake / fmt::format("sh_L1{}.png", "xyz"[axis]), kBakeSide, kBakeSide, 3, [&](int c, int x, int y) {
                const Sums sums = at(x, y);
                return byteOf(sums.light[c] > 0 ? sums.linear[static_cast<std::size_t>(axis)][c] / (2 * sums.light[c]) + 0.5 : 0.5);
            });
        formats::writePng(bake / "mono_L1.png", kBakeSide, kBakeSide, 3,
                          [&](int axis, int x, int y) { return byteOf(towards(axis, x, y) / 2 + 0.5); });
        const auto direction = [&](int channel, int x, int y) {
            if (channel < 3) return byteOf(towards(channel, x, y) / 2 + 0.5);
            double facing = 0.5;
            for (int axis = 0; axis < 3; ++axis) facing += surfaceAt(x, y).shaded[axis] * towards(axis, x, y) / 2;
            return std::max(byteOf(facing), 1);
        };
        for (const char* file : {"unity_dir.png", "level_dir.png"}) formats::writePng(bake / file, kBakeSide, kBakeSide, 4, direction);
        for (const char* file : {"sh_L0.exr", "mono_L0.exr", "unity_light.exr", "level_final.exr"})
            EXPECT_THAT(bake.findings(fmt::format("file = \"{}\"\nfirefly_limit = 0", file)), testing::Each("[missing-coverage]")) << file;
    }
}

TEST(LintRightWork, AColourAloneIsNoIncompleteSetOfUnity) {
    const RightBake bake;
    for (const char* file : {"Lightmap-0_comp_light.exr", "level_LMA1_final.exr"}) {
        bake.writeExr(file, kBakeSide, {"R", "G", "B"}, [](int x, int y) { return std::vector<float>(3, 0.1f + 0.01f * float(x + y)); });
        EXPECT_THAT(bake.findings(fmt::format("file = \"{}\"", file)), IsEmpty()) << file;
    }
}

/// Wrong work beside the right: what the checks are for is found in the same bakes.
TEST(LintRightWork, AWrongConventionOfTheSameBakesIsFound) {
    for (const auto& [name, light] : lights()) {
        if (name == std::string("even")) continue;  // it has the same light under each
        SCOPED_TRACE(name);
        const RightBake bake;
        writeSh(bake, light, 9, 1, true);
        for (const char* key : {"phase = \"condon-shortley\"", "quantity = \"irradiance\""})
            EXPECT_THAT(bake.findings(fmt::format("file = \"room.exr\"\nfirefly_limit = 0\n{}", key)), testing::Not(IsEmpty())) << key;
    }
}

}  // namespace
}  // namespace lightcook::pipeline::right_work
