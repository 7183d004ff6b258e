// Random shadings (place, normal, view, roughness, F0) between the texels of the public scenes, by a sampler that uses all of its
// tolerance, each compared with the bound of its quad. Filtered and shaded here, vectorized and on all cores. The soak also reports how far
// the bounds are above the largest error that a dense search finds.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>
#include <numeric>

#include "lighting/brdf.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "tests/formats/light_map_layouts.h"
#include "tests/soak/soak.h"
#include "tests/verify/cooked_light_map.h"
#include "tests/verify/on_all_cores.h"
#include "tests/verify/public_scenes.h"
#include "verify/assets/random.h"
#include "verify/light_map/layouts.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using lighting::ShDouble;
using test::Cooked;
using test::medianOf;
using test::onAllCores;
using test::SceneAndLayout;
using verify::Random;

constexpr std::size_t kCount = lighting::kShCount, kLanes = 16;
constexpr double kLowM = 0.1, kHighM = 0.5, kLowF0 = 0.04, kHighF0 = 0.6;

ShDouble normalRow(const glm::dvec3& normal) {
    ShDouble row = lighting::evaluateBasis(normal);
    for (std::size_t k = 0; k < kCount; ++k) row[k] *= lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[k])];
    return row;
}

lighting::AreaSpecularKernel kernelAt(double NoV, double m) {
    return lighting::integrateAreaSpecular(NoV, m, lighting::NormalDistribution::Beckmann, lighting::CookTorranceNormalization::Energy, 48);
}
ShDouble atF0(const lighting::AreaSpecularKernel& kernel, double f0) {
    ShDouble sum;
    for (std::size_t k = 0; k < kCount; ++k) sum[k] = f0 * kernel.c[k] + (1 - f0) * kernel.d[k];
    return sum;
}
/// Rotates a row to a random frame: any normal, any view around it.
ShDouble turned(const ShDouble& row, Random& random) {
    const glm::dvec3 normal = random.direction(), tangent = glm::normalize(glm::cross(normal, random.direction()));
    return lighting::ShRotation(glm::dmat3(tangent, glm::cross(normal, tangent), normal)).apply(row);
}

/// Factors of the nine coefficients of light, in the world frame: [coefficient][row].
class Shadings {
public:
    static constexpr std::size_t kRows = 1 << 15;
    static const Shadings& get() {
        static const Shadings kShadings;
        return kShadings;
    }
    std::array<std::vector<float>, kCount> diffuse, specular;
    static ShDouble rowOf(const std::array<std::vector<float>, kCount>& rows, std::size_t at) {
        ShDouble row;
        for (std::size_t k = 0; k < kCount; ++k) row[k] = static_cast<double>(rows[k][at]);
        return row;
    }

private:
    Shadings() {
        for (auto* rows : {&diffuse, &specular})
            for (auto& row : *rows) row.resize(kRows);
        constexpr std::size_t kKernels = 2048;
        onAllCores(kKernels, [&](std::size_t index) {
            Random random(100 + index);
            const double m = kLowM + (kHighM - kLowM) * random.next(),
                         NoV = std::max(1e-3, index % 8 == 0 ? 0.01 * random.next() : random.next());
            const auto kernel = kernelAt(NoV, m);
            for (std::size_t at = index; at < kRows; at += kKernels) {
                const double f0 =
                    random.next() < 0.3 ? (random.next() < 0.5 ? kLowF0 : kHighF0) : kLowF0 + (kHighF0 - kLowF0) * random.next();
                const ShDouble glossy = turned(atF0(kernel, f0), random), white = normalRow(random.direction());
                for (std::size_t k = 0; k < kCount; ++k) {
                    specular[k][at] = static_cast<float>(glossy[k]);
                    diffuse[k][at] = static_cast<float>(white[k]);
                }
            }
        });
    }
};

/// A place between four texels, with the decode of one corner.
struct Quad {
    int x, y;
};

/// Error and reference of the three channels.
struct Light {
    shaders::LcSh error, reference;
};

/// A cooked map and its quads.
class Map {
public:
    Map(const std::filesystem::path& file, LightMapLayout layout, int effort) : cooked_(cook(file, layout, effort)) {
        const auto any = verify::layouts::layoutOf(cooked_.map);
        layout_ = *any;
        for (int y = 0; y + 1 < cooked_.map.height; ++y)
            for (int x = 0; x + 1 < cooked_.map.width; ++x)
                if (covered(x, y) && covered(x + 1, y) && covered(x, y + 1) && covered(x + 1, y + 1)) quads.push_back({x, y});
        for (std::size_t t = 0; t < cooked_.texels.textures.size(); ++t) {
            const verify::FormatTolerance tolerance = verify::toleranceOf(cooked_.map.formats[t]);
            for (std::size_t layer = 0; layer < cooked_.texels.textures[t].size(); ++layer) {
                layers_.push_back(&cooked_.texels.textures[t][layer]);
                spans_.push_back(&cooked_.texels.spans[t][layer]);
                formats_.push_back(tolerance);
            }
        }
        verify::LightMapShading shading;
        shading.m = {kLowM, kHighM};
        shading.f0 = {kLowF0, kHighF0};
        shading.normalCount = shading.viewCount = 1;
        verifier_ = std::make_unique<verify::LightMapVerifier>(cooked_.verifier(shading, {}));
        verify::CookedLightMap ideal = cooked_.map;
        ideal.formats.clear();
        ideal_ = std::make_unique<verify::LightMapVerifier>(
            std::move(*verify::LightMapVerifier::create(ideal, shading, verify::LightMapSampling{}, cooked_.key)));
    }
    verify::LightMapVerifier::QuadBound bound(const Quad& quad) const {
        return verifier_->boundQuad(cooked_.texels, cooked_.reference, quad.x, quad.y);
    }
    verify::LightMapVerifier::QuadBound idealBound(const Quad& quad) const {
        return ideal_->boundQuad(cooked_.texels, cooked_.reference, quad.x, quad.y);
    }
    double key() const { return cooked_.key; }

    /// Returns the light at a place, in units of the key, if the sampler's fractions are off by `shift` texels and its filtered values by
    /// perturb(layer, channel), in [-1, 1], of the tolerance.
    template <class Tolerance>
    Light lightAt(const Quad& quad, int corner, const glm::vec2& place, const glm::vec2& shift, Tolerance&& perturb) const {
        Light light;
        const auto perKey = static_cast<float>(1 / cooked_.key);
        const glm::vec2 seen = glm::clamp(place + shift, 0.0f, 1.0f);
        std::visit(
            [&]<class Layout>(const Layout& layout) {
                if (cooked_.map.filter == formats::LightMapFilter::Decoded) {
                    for (std::size_t k = 0; k < kCount; ++k)
                        light.error.c[k] = blend(quad, place, [&](int x, int y) { return test::lightOfTexel(cooked_, layout, x, y).c[k]; });
                    return;
                }
                verify::layouts::Texels<Layout::kLayers> texels{};
                for (std::size_t layer = 0; layer < texels.size(); ++layer) {
                    const auto& image = *layers_[layer];
                    texels[layer] = blend(quad, seen, [&](int x, int y) { return image.at(x, y); });
                    const glm::vec4 most = mostAt(layer, quad);
                    for (int channel = 0; channel < 4; ++channel) texels[layer][channel] += perturb(layer, channel) * most[channel];
                }
                light.error = verify::layouts::decodeAt(layout, quad.x + corner % 2, quad.y + corner / 2).decode(texels);
            },
            layout_);
        for (std::size_t k = 0; k < kCount; ++k) {
            light.reference.c[k] = perKey * blend(quad, place, [&](int x, int y) { return cooked_.reference.sh.at(x, y)[k]; });
            light.error.c[k] = perKey * light.error.c[k] - light.reference.c[k];
        }
        return light;
    }
    std::size_t layerCount() const { return layers_.size(); }
    std::vector<Quad> quads;

private:
    static Cooked cook(const std::filesystem::path& file, LightMapLayout layout, int effort) {
        const auto reader = formats::LightMapReader::open(file, {});
        EXPECT_TRUE(reader.has_value());
        auto band = reader->read(0, reader->height());
        EXPECT_TRUE(band.has_value());
        return test::cook(std::move(*band), layout, formats::Target::Bc, effort);
    }
    bool covered(int x, int y) const { return cooked_.reference.covered.at(x, y) != 0; }
    template <class Get>
    static auto blend(const Quad& q, const glm::vec2& p, Get&& get) {
        return (1 - p.y) * ((1 - p.x) * get(q.x, q.y) + p.x * get(q.x + 1, q.y)) +
               p.y * ((1 - p.x) * get(q.x, q.y + 1) + p.x * get(q.x + 1, q.y + 1));
    }
    /// Returns the tolerance of a filtered value of the layer in the quad.
    glm::vec4 mostAt(std::size_t layer, const Quad& quad) const {
        const verify::FormatTolerance& tolerance = formats_[layer];
        glm::vec4 span(0), largest(0);
        for (int i = 0; i < 4; ++i) {
            const int x = quad.x + i % 2, y = quad.y + i / 2;
            largest = glm::max(largest, glm::abs(layers_[layer]->at(x, y)));
            if (tolerance.hasSpans()) span = glm::max(span, spans_[layer]->at(x / 4, y / 4));
        }
        // The tolerance of each texel, then that of the filter.
        return tolerance.decoded + tolerance.perSpan * span + tolerance.absolute + tolerance.relative * largest;
    }

    Cooked cooked_;
    verify::layouts::Layout layout_;
    std::vector<const formats::Image<glm::vec4>*> layers_, spans_;
    std::vector<verify::FormatTolerance> formats_;
    std::unique_ptr<verify::LightMapVerifier> verifier_, ideal_;
};

/// Shades light by kLanes * count rows from `first` on. Returns the largest local error.
float shadedMost(const Light& light, const std::array<std::vector<float>, kCount>& rows, std::size_t first, std::size_t count) {
    float most[kLanes] = {};
    for (int channel = 0; channel < 3; ++channel)
        for (std::size_t at = first; at < first + count * kLanes; at += kLanes) {
            float error[kLanes] = {}, reference[kLanes] = {};
            for (std::size_t k = 0; k < kCount; ++k) {
                const float e = light.error.c[k][channel], r = light.reference.c[k][channel];
                const float* row = rows[k].data() + at;
                for (std::size_t lane = 0; lane < kLanes; ++lane) {
                    error[lane] += e * row[lane];
                    reference[lane] += r * row[lane];
                }
            }
            for (std::size_t lane = 0; lane < kLanes; ++lane)
                most[lane] = std::max(most[lane],
                                      std::abs(error[lane]) / (std::abs(reference[lane]) + static_cast<float>(lighting::kLocalErrorFloor)));
        }
    return *std::max_element(most, most + kLanes);
}

struct Tally {
    std::int64_t shadings = 0, above = 0;
    double nearest = 0, seconds = 0;
};

/// Shades random quads: several places of each, with several shadings of each kind.
Tally shadeAtRandom(const Map& map, std::int64_t shadings, std::uint64_t seed) {
    constexpr std::size_t kPlacesAQuad = 256, kGroups = 2;
    constexpr std::int64_t kAQuad = static_cast<std::int64_t>(kPlacesAQuad * kGroups * kLanes * 2);
    const Shadings& rows = Shadings::get();
    const auto start = std::chrono::steady_clock::now();
    std::atomic<std::int64_t> above{0}, done{0};
    std::atomic<double> nearest{0};
    onAllCores(static_cast<std::size_t>((shadings + kAQuad - 1) / kAQuad), [&](std::size_t index) {
        Random random(seed * 1000003 + index);
        const Quad quad = map.quads[static_cast<std::size_t>(random.next() * static_cast<double>(map.quads.size()))];
        const auto bound = map.bound(quad);
        double worst = 0;
        for (std::size_t i = 0; i < kPlacesAQuad; ++i) {
            const auto number = [&] { return static_cast<float>(random.next()); };
            const glm::vec2 place(number(), number()), shift = (2.0f * glm::vec2(number(), number()) - 1.0f) / 256.0f;
            // An ideal sampler, one with random errors, and one with the largest errors.
            const int kind = static_cast<int>(i % 3);
            const Light light = map.lightAt(quad, random.below(4), place, kind == 0 ? glm::vec2(0) : shift, [&](std::size_t, int) {
                const float offset = 2 * number() - 1;
                return kind == 0 ? 0 : kind == 1 ? offset : offset < 0 ? -1.0f : 1.0f;
            });
            const auto first = [&] {
                return static_cast<std::size_t>(random.below(static_cast<int>(Shadings::kRows / kLanes - kGroups))) * kLanes;
            };
            const double diffuse = static_cast<double>(shadedMost(light, rows.diffuse, first(), kGroups));
            const double specular = static_cast<double>(shadedMost(light, rows.specular, first(), kGroups));
            if (!(diffuse <= bound.diffuse) || !(specular <= bound.specular)) ++above;
            if (bound.diffuse > 0) worst = std::max(worst, diffuse / bound.diffuse);
            if (bound.specular > 0) worst = std::max(worst, specular / bound.specular);
        }
        done += kAQuad;
        double before = nearest;
        while (before < worst && !nearest.compare_exchange_weak(before, worst)) {
        }
    });
    return {done, above, nearest, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()};
}

// ---- tightness ----

double localError(const Light& light, const ShDouble& row) {
    double most = 0;
    for (int channel = 0; channel < 3; ++channel) {
        double error = 0, reference = 0;
        for (std::size_t k = 0; k < kCount; ++k) {
            error += row[k] * static_cast<double>(light.error.c[k][channel]);
            reference += row[k] * static_cast<double>(light.reference.c[k][channel]);
        }
        most = std::max(most, std::abs(error) / (std::abs(reference) + lighting::kLocalErrorFloor));
    }
    return most;
}

/// Searches the largest error of a quad: alternately over places and shadings, and over the sampler's tolerance.
template <class Perturb>
class Search {
public:
    Search(const Map& map, const Quad& quad, const std::array<std::vector<float>, kCount>& rows, Perturb perturb, Random& random)
        : map_(map), quad_(quad), rows_(rows), perturb_(perturb), random_(random), tolerance_(4 * map.layerCount(), 0.0f) {}

    struct Found {
        double ideal = 0, free = 0;
    };
    Found run() {
        for (int corner = 0; corner < 4; ++corner)
            for (int y = 0; y < 5; ++y)
                for (int x = 0; x < 5; ++x) tryRows(corner, glm::vec2(x, y) / 4.0f);
        climb(300);
        const double ideal = best_.most;
        for (int round = 0; round < 4; ++round) {
            useTolerance();
            for (int y = 0; y < 3; ++y)
                for (int x = 0; x < 3; ++x) tryRows(best_.corner, glm::vec2(x, y) / 2.0f);
            climb(150);
        }
        useTolerance();
        return {ideal, best_.most};
    }

private:
    struct Candidate {
        double most = 0;
        int corner = 0;
        glm::vec2 place{0};
        ShDouble row{};
    };
    Light lightAt(const Candidate& candidate) const {
        return map_.lightAt(quad_, candidate.corner, candidate.place, shift_,
                            [&](std::size_t layer, int channel) { return tolerance_[4 * layer + static_cast<std::size_t>(channel)]; });
    }
    void tryRows(int corner, const glm::vec2& place) {
        const Light light = lightAt({0, corner, place, {}});
        for (std::size_t first = 0; first < 2048; first += kLanes) {
            if (static_cast<double>(shadedMost(light, rows_, first, 1)) <= best_.most) continue;
            for (std::size_t at = first; at < first + kLanes; ++at) {
                const ShDouble row = Shadings::rowOf(rows_, at);
                const double most = localError(light, row);
                if (most > best_.most) best_ = {most, corner, place, row};
            }
        }
    }
    void climb(int steps) {
        double reach = 0.5;
        for (int step = 0; step < steps; ++step, reach *= std::pow(0.01, 1.0 / steps)) {
            Candidate next = best_;
            const auto off = [&] { return static_cast<float>(reach * (random_.next() - 0.5)); };
            next.place = glm::clamp(next.place + glm::vec2(off(), off()), 0.0f, 1.0f);
            next.row = perturb_(next.row, reach);
            next.most = localError(lightAt(next), next.row);
            if (next.most > best_.most) best_ = next;
        }
    }
    void useTolerance() {
        const auto tryBoth = [&](float& offset, float most) {
            for (const float way : {-most, most}) {
                const float before = std::exchange(offset, way);
                const double found = localError(lightAt(best_), best_.row);
                if (found > best_.most)
                    best_.most = found;
                else
                    offset = before;
            }
        };
        tryBoth(shift_.x, 1.0f / 256);
        tryBoth(shift_.y, 1.0f / 256);
        for (float& offset : tolerance_) tryBoth(offset, 1);
    }

    const Map& map_;
    const Quad& quad_;
    const std::array<std::vector<float>, kCount>& rows_;
    Perturb perturb_;
    Random& random_;
    Candidate best_;
    glm::vec2 shift_{0};
    std::vector<float> tolerance_;
};

struct Tightness {
    double diffuseIdeal, diffuse, specularIdeal, specular;
};
Tightness tightness(const Map& map, std::size_t quadCount) {
    std::vector<std::array<double, 4>> ratios(quadCount);
    const Shadings& rows = Shadings::get();
    onAllCores(quadCount, [&](std::size_t index) {
        Random random(77 + index);
        const Quad quad = map.quads[static_cast<std::size_t>(random.next() * static_cast<double>(map.quads.size()))];
        const auto bound = map.bound(quad), ideal = map.idealBound(quad);
        const auto small = [&](double reach) {
            const glm::dvec3 axis = random.direction();
            const double angle = reach * (random.next() - 0.5), c = std::cos(angle), s = std::sin(angle);
            glm::dmat3 turn(0);
            for (int i = 0; i < 3; ++i) {
                glm::dvec3 e(0);
                e[i] = 1;
                turn[i] = c * e + s * glm::cross(axis, e) + (1 - c) * glm::dot(axis, e) * axis;
            }
            return lighting::ShRotation(turn);
        };
        const auto turn = [&](const ShDouble& row, double reach) { return small(reach).apply(row); };
        const auto diffuse = Search(map, quad, rows.diffuse, turn, random).run(),
                   specular = Search(map, quad, rows.specular, turn, random).run();
        ratios[index] = {ideal.diffuse / diffuse.ideal, bound.diffuse / diffuse.free, ideal.specular / specular.ideal,
                         bound.specular / specular.free};
    });
    const auto median = [&](std::size_t which) {
        std::vector<double> values;
        for (const auto& each : ratios)
            if (std::isfinite(each[which])) values.push_back(each[which]);
        return medianOf(std::move(values));
    };
    return {median(0), median(1), median(2), median(3)};
}

// ---- the tests ----

/// Shades at random and returns the count. A bound far above all errors would always hold: `nearest` is at least a tenth of it.
std::int64_t expectWithinTheBound(const Map& map, const std::string& name, std::int64_t shadings, std::uint64_t seed) {
    const Tally tally = shadeAtRandom(map, shadings, seed);
    EXPECT_EQ(tally.above, 0) << name;
    EXPECT_GT(tally.nearest, 0.1) << name;
    fmt::print("{:20} {:.3g} shadings, {:.1f} s, {:.3g} a second, {} above, nearest {:.2f} of its bound\n", name,
               static_cast<double>(tally.shadings), tally.seconds, static_cast<double>(tally.shadings) / tally.seconds, tally.above,
               tally.nearest);
    return tally.shadings;
}

class MagnifiedScenes : public testing::TestWithParam<SceneAndLayout> {
protected:
    void SetUp() override {
        if (!std::filesystem::exists(test::lightMapOf(scene_))) GTEST_SKIP() << "the shared scenes are not here";
    }
    const std::string scene_ = std::get<0>(GetParam());
    const LightMapLayout layout_ = std::get<1>(GetParam());
    const std::string name_ = fmt::format("{:8} {:11}", scene_, formats::info(layout_).name);
};
TEST_P(MagnifiedScenes, NoShadingExceedsTheBoundOfItsQuad) {
    expectWithinTheBound(Map(test::lightMapOf(scene_), layout_, 1), name_, 2'000'000, 23);
}
INSTANTIATE_TEST_SUITE_P(Scenes, MagnifiedScenes,
                         testing::Combine(testing::Values("cornell", "interior"),
                                          testing::Values(LightMapLayout::Ratio, LightMapLayout::Basis4)),
                         test::nameOfSceneAndLayout);

using MagnifiedScenesSoak = MagnifiedScenes;
TEST_P(MagnifiedScenesSoak, NoShadingExceedsTheBoundOfItsQuad) {
    const Map map(test::lightMapOf(scene_), layout_, 3);
    test::repeatInSoak("shadings", 5'000'000, [&](std::uint64_t seed) { expectWithinTheBound(map, name_, 5'000'000, seed); });
}
INSTANTIATE_TEST_SUITE_P(Scenes, MagnifiedScenesSoak,
                         testing::Combine(testing::ValuesIn(test::kPublicScenes), testing::ValuesIn(test::directionalLayouts())),
                         test::nameOfSceneAndLayout);

class TightBoundsSoak : public testing::TestWithParam<SceneAndLayout> {};
TEST_P(TightBoundsSoak, AreNotFarAboveTheWorstThatASearchFinds) {
    const auto& [scene, layout] = GetParam();
    if (!std::filesystem::exists(test::lightMapOf(scene))) GTEST_SKIP() << "the shared scenes are not here";
    const Map map(test::lightMapOf(scene), layout, 3);
    const Tightness median = tightness(map, 200);
    fmt::print("tight {:8} {:11} diffuse {:.2f}, with tolerance {:.2f}; specular {:.2f}, with tolerance {:.2f}\n", scene,
               formats::info(layout).name, median.diffuseIdeal, median.diffuse, median.specularIdeal, median.specular);
    EXPECT_LE(median.diffuse, 3);
    EXPECT_LE(median.specular, 6);
}
INSTANTIATE_TEST_SUITE_P(Scenes, TightBoundsSoak,
                         testing::Combine(testing::ValuesIn(test::kPublicScenes),
                                          testing::Values(LightMapLayout::Ratio, LightMapLayout::Sh4, LightMapLayout::Basis3,
                                                          LightMapLayout::Basis4, LightMapLayout::Basis8, LightMapLayout::Basis16,
                                                          LightMapLayout::Godot, LightMapLayout::MonoSh, LightMapLayout::Bakery,
                                                          LightMapLayout::Halo3, LightMapLayout::UnrealHq)),
                         test::nameOfSceneAndLayout);

}  // namespace
}  // namespace lightcook
