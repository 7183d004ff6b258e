// The bound of visible errors on the public scenes: never exceeded by random shadings, and not far above the worst that a search finds in
// blocks of 64 x 64 texels.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <numeric>

#include "tests/soak/soak.h"
#include "tests/verify/on_all_cores.h"
#include "tests/verify/public_scenes.h"
#include "tests/verify/visible_sampler.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using test::medianOf;
using test::onAllCores;
using test::SampledPlace;
using test::SceneAndLayout;
using test::ShadingRows;
using verify::Random;

constexpr int kSceneBlock = 64;

/// The rows of all samples.
const ShadingRows& rowsOf(bool isSpecular) {
    static const std::array<ShadingRows, 2> kRows = {ShadingRows(4096, false, 1), ShadingRows(4096, true, 2)};
    return kRows[isSpecular ? 1 : 0];
}

/// A scene's map, its sampler, and the bounds of its blocks.
class SceneMap {
public:
    SceneMap(const std::string& scene, LightMapLayout layout, int effort)
        : cooked_(cook(scene, layout, effort)), viewing_(test::viewingOf(cooked_)), sampler(cooked_, viewing_) {
        verifier_ = std::make_unique<verify::LightMapVerifier>(
            std::move(*verify::LightMapVerifier::create(cooked_.map, test::sampledShading(), {}, cooked_.key, viewing_)));
    }
    verify::LightMapVerifier::AreaVisibleBound bound(const verify::TexelArea& area) const {
        return verifier_->visibleBound(cooked_.texels, cooked_.reference, area);
    }
    /// Returns the blocks with at least a quarter of covered texels.
    std::vector<verify::TexelArea> blocks() const {
        std::vector<verify::TexelArea> out;
        for (int y = 0; y < cooked_.map.height; y += kSceneBlock)
            for (int x = 0; x < cooked_.map.width; x += kSceneBlock) {
                const auto count = std::ranges::count_if(sampler.covered, [&](const auto& texel) {
                    return texel.first / kSceneBlock == x / kSceneBlock && texel.second / kSceneBlock == y / kSceneBlock;
                });
                if (4 * count >= kSceneBlock * kSceneBlock) out.push_back({x, y, kSceneBlock, kSceneBlock});
            }
        return out;
    }
    int width() const { return cooked_.map.width; }
    int height() const { return cooked_.map.height; }

private:
    static test::Cooked cook(const std::string& scene, LightMapLayout layout, int effort) {
        const auto reader = formats::LightMapReader::open(test::lightMapOf(scene), test::descriptionFor(scene, layout));
        EXPECT_TRUE(reader.has_value());
        auto band = reader->read(0, reader->height());
        EXPECT_TRUE(band.has_value());
        return test::cook(std::move(*band), layout, formats::Target::Bc, effort);
    }
    test::Cooked cooked_;
    verify::Viewing viewing_;
    std::unique_ptr<verify::LightMapVerifier> verifier_;

public:
    test::VisibleSampler sampler;
};

/// Searches the largest visible error of a block of quads: samples first, then climbs from the best of them over place, shading and the
/// sampler's tolerance.
class BlockSearch {
public:
    BlockSearch(const SceneMap& map, const verify::TexelArea& area, bool isSpecular)
        : map_(map), isSpecular_(isSpecular), random_(static_cast<std::uint64_t>(area.x + 4096 * area.y + 7)) {
        for (const auto& [x, y] : map.sampler.covered)
            if (x >= area.x && x < area.x + area.width && y >= area.y && y < area.y + area.height) texels_.emplace_back(x, y);
        last_ = {area.x + area.width - 1, area.y + area.height - 1};
    }
    double run() {
        constexpr std::size_t kStarts = 12;
        for (const auto& [x, y] : texels_)
            for (int i = 0; i < 9; ++i) {
                SampledPlace place{x, y, 0.5f * glm::vec2(i % 3 - 1, i / 3 - 1), 0, {}, {}};
                if (!isIn(place)) continue;
                place.decode = nearestCorner(place);
                const auto light = map_.sampler.lightAt(place);
                for (int group = 0; group < 4; ++group) trySome(light, place, starts_, kStarts);
            }
        double best = 0;
        for (const Start& start : starts_) best = std::max(best, climb(start));
        return best;
    }

private:
    struct Start {
        double most = 0;
        SampledPlace place;
        test::ShadingRow row{};
    };
    bool isIn(const SampledPlace& place) const { return place.quadX() <= last_.x && place.quadY() <= last_.y; }
    static int nearestCorner(const SampledPlace& place) { return (place.x - place.quadX()) + 2 * (place.y - place.quadY()); }
    void trySome(const test::SampledLight& light, const SampledPlace& place, std::vector<Start>& best, std::size_t count) {
        const ShadingRows& rows = rowsOf(isSpecular_);
        const std::size_t first = static_cast<std::size_t>(random_.below(256)) * ShadingRows::kLanes;
        std::array<float, ShadingRows::kLanes> found;
        map_.sampler.differences(light, rows, first, found.data());
        const auto largest = std::ranges::max_element(found);
        const auto most = static_cast<double>(*largest);
        if (best.size() == count && most <= best.back().most) return;
        // One start for each texel.
        for (Start& each : best)
            if (each.place.x == place.x && each.place.y == place.y) {
                if (most > each.most) each = {most, place, rows.rows[first + static_cast<std::size_t>(largest - found.begin())]};
                std::ranges::stable_sort(best, std::greater{}, &Start::most);
                return;
            }
        best.push_back({most, place, rows.rows[first + static_cast<std::size_t>(largest - found.begin())]});
        std::ranges::stable_sort(best, std::greater{}, &Start::most);
        if (best.size() > count) best.pop_back();
    }
    double climb(const Start& start) {
        std::vector<Start> best = {start};
        for (int round = 0; round < 4; ++round) {
            for (int step = 0; step < 60; ++step) {
                SampledPlace place = best[0].place;
                const float reach = 0.5f * std::pow(0.9f, static_cast<float>(step));
                place.off += reach * (glm::vec2(static_cast<float>(random_.next()), static_cast<float>(random_.next())) - 0.5f);
                place.off = glm::clamp(place.off, -0.5f, 0.5f);
                place.decode = nearestCorner(place);
                if (!isIn(place)) continue;
                const auto light = map_.sampler.lightAt(place);
                for (int group = 0; group < 4; ++group) trySome(light, place, best, 1);
                if (differenceAt(place, best[0].row) > best[0].most) best[0] = {differenceAt(place, best[0].row), place, best[0].row};
            }
            useTolerance(best[0]);
        }
        return best[0].most;
    }
    double differenceAt(const SampledPlace& place, const test::ShadingRow& row) const {
        const auto light = map_.sampler.lightAt(place);
        return map_.sampler.difference(light, row);
    }
    void useTolerance(Start& best) const {
        best.place.tolerance.resize(4 * map_.sampler.layerCount(), 0.0f);
        const auto tryBoth = [&](float& offset, float most) {
            for (const float way : {-most, most}) {
                const float before = std::exchange(offset, way);
                const double found = differenceAt(best.place, best.row);
                if (found > best.most)
                    best.most = found;
                else
                    offset = before;
            }
        };
        tryBoth(best.place.shift.x, 1.0f / 256);
        tryBoth(best.place.shift.y, 1.0f / 256);
        for (float& offset : best.place.tolerance) tryBoth(offset, 1);
    }

    const SceneMap& map_;
    bool isSpecular_;
    Random random_;
    std::vector<std::pair<int, int>> texels_;
    glm::ivec2 last_;
    std::vector<Start> starts_;
};

/// Compares random shadings with the bound of their block, in the soak as many as there is time for.
void expectVisibleWithinTheBound(const std::string& scene, LightMapLayout layout, int effort, bool isSoak) {
    if (!std::filesystem::exists(test::lightMapOf(scene))) GTEST_SKIP() << "the shared scenes are not here";
    const SceneMap map(scene, layout, effort);
    const int across = (map.width() + kSceneBlock - 1) / kSceneBlock, down = (map.height() + kSceneBlock - 1) / kSceneBlock;
    std::vector<verify::LightMapVerifier::AreaVisibleBound> bounds(static_cast<std::size_t>(across * down));
    onAllCores(bounds.size(), [&](std::size_t i) {
        const auto block = static_cast<int>(i);
        bounds[i] = map.bound({kSceneBlock * (block % across), kSceneBlock * (block / across), kSceneBlock, kSceneBlock});
    });
    constexpr std::size_t kPlaces = 1024, kGroups = 8;
    constexpr auto kEach = static_cast<std::int64_t>(kPlaces * kGroups * 2 * ShadingRows::kLanes);
    std::atomic<std::int64_t> above{0};
    const auto shade = [&](std::size_t index) {
        Random random(index + 1);
        for (std::size_t i = 0; i < kPlaces; ++i) {
            const auto [x, y] =
                map.sampler.covered[static_cast<std::size_t>(random.next() * static_cast<double>(map.sampler.covered.size()))];
            const SampledPlace place = map.sampler.placeAt(x, y, random);
            const auto light = map.sampler.lightAt(place);
            const auto& bound = bounds[static_cast<std::size_t>(std::max(place.quadY(), 0) / kSceneBlock * across +
                                                                std::max(place.quadX(), 0) / kSceneBlock)];
            for (std::size_t group = 0; group < kGroups; ++group)
                for (const bool isSpecular : {false, true}) {
                    std::array<float, ShadingRows::kLanes> found;
                    map.sampler.differences(light, rowsOf(isSpecular), static_cast<std::size_t>(random.below(256)) * ShadingRows::kLanes,
                                            found.data());
                    for (const float each : found) above += !(static_cast<double>(each) <= (isSpecular ? bound.specular : bound.diffuse));
                }
        }
    };
    constexpr std::size_t kAtOnce = (1'000'000 + kEach - 1) / kEach;
    const auto shadeMany = [&](std::uint64_t seed) {
        onAllCores(kAtOnce, [&](std::size_t i) { shade(kAtOnce * seed + i); });
        EXPECT_EQ(above, 0) << scene << ' ' << formats::info(layout).name;
    };
    if (isSoak)
        test::repeatInSoak("shadings", kAtOnce * kEach, shadeMany);
    else
        shadeMany(0);
}

class VisibleScenes : public testing::TestWithParam<SceneAndLayout> {};
TEST_P(VisibleScenes, NoShadingExceedsTheBoundOfItsBlock) {
    expectVisibleWithinTheBound(std::get<0>(GetParam()), std::get<1>(GetParam()), 1, false);
}
INSTANTIATE_TEST_SUITE_P(Scenes, VisibleScenes,
                         testing::Combine(testing::Values("cornell"),
                                          testing::Values(LightMapLayout::Ratio, LightMapLayout::Basis4, LightMapLayout::LitHalf)),
                         test::nameOfSceneAndLayout);

class VisibleScenesSoak : public testing::TestWithParam<SceneAndLayout> {};
TEST_P(VisibleScenesSoak, NoShadingExceedsTheBoundOfItsBlock) {
    expectVisibleWithinTheBound(std::get<0>(GetParam()), std::get<1>(GetParam()), 3, true);
}
INSTANTIATE_TEST_SUITE_P(Scenes, VisibleScenesSoak,
                         testing::Combine(testing::ValuesIn(test::kPublicScenes), testing::ValuesIn(test::kEveryLayout)),
                         test::nameOfSceneAndLayout);

class TightVisibleBoundsSoak : public testing::TestWithParam<SceneAndLayout> {};
TEST_P(TightVisibleBoundsSoak, AreNotFarAboveTheWorstThatASearchFinds) {
    const auto& [scene, layout] = GetParam();
    if (!std::filesystem::exists(test::lightMapOf(scene))) GTEST_SKIP() << "the shared scenes are not here";
    const SceneMap map(scene, layout, 3);
    std::vector<verify::TexelArea> blocks = map.blocks();
    constexpr std::size_t kMost = 16;
    const std::size_t step = (blocks.size() + kMost - 1) / kMost, count = blocks.size() / step;
    std::vector<double> diffuse(count), specular(count), seconds(count);
    onAllCores(count, [&](std::size_t i) {
        const verify::TexelArea& area = blocks[i * step];
        const auto start = std::chrono::steady_clock::now();
        const auto bound = map.bound(area);
        seconds[i] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        const double worstDiffuse = BlockSearch(map, area, false).run(), worstSpecular = BlockSearch(map, area, true).run();
        diffuse[i] = bound.diffuse / worstDiffuse;
        specular[i] = bound.specular / worstSpecular;
        if (std::getenv("LIGHTCOOK_VERBOSE") != nullptr)
            fmt::print("  {} {}: {:.1f} / {:.1f}, {:.1f} / {:.1f}\n", area.x, area.y, bound.diffuse, worstDiffuse, bound.specular,
                       worstSpecular);
        EXPECT_GE(diffuse[i], 1);
        EXPECT_GE(specular[i], 1);
    });
    fmt::print("tight {:8} {:11} {} blocks: diffuse {:.2f}, specular {:.2f}, {:.2f} s\n", scene, formats::info(layout).name, count,
               medianOf(diffuse), medianOf(specular), std::accumulate(seconds.begin(), seconds.end(), 0.0));
    // Those of docs/lab/verify.md, and a little.
    const bool isMixed = layout == LightMapLayout::LitHalf;
    EXPECT_LE(medianOf(diffuse), isMixed ? 2.5 : 6);
    EXPECT_LE(medianOf(specular), isMixed ? 3 : 6.5);
}
INSTANTIATE_TEST_SUITE_P(Scenes, TightVisibleBoundsSoak,
                         testing::Combine(testing::Values("cornell", "interior"),
                                          testing::Values(LightMapLayout::Halo3, LightMapLayout::Ratio, LightMapLayout::Basis4,
                                                          LightMapLayout::Raw, LightMapLayout::Hdr2, LightMapLayout::HdrRgb9e5,
                                                          LightMapLayout::LitHalf)),
                         test::nameOfSceneAndLayout);

}  // namespace
}  // namespace lightcook
