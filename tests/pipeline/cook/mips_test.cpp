// Light maps with mip levels: cooked, read again, and verified level by level.
#include <gmock/gmock.h>
#include <tbb/task_arena.h>

#include <array>
#include <cmath>

#include "formats/gpu_texture.h"
#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "tests/pipeline/small_scene.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;

constexpr int kMippedSide = 64;

/// A scene with two charts, of which the second begins `gap` texels to the right of column 32.
class MippedScene {
public:
    explicit MippedScene(int gap) {
        auto writer =
            formats::LightMapWriter::create(scene_ / "map.exr", kMippedSide, kMippedSide, formats::SurfaceOutput::CoverageAndNormals);
        formats::Image<lighting::ShRgb> sh(kMippedSide, kMippedSide, lighting::ShRgb{});
        formats::Image<std::uint8_t> covered(kMippedSide, kMippedSide, 0);
        formats::Image<glm::vec3> normal(kMippedSide, kMippedSide, glm::vec3(0));
        for (int y = 0; y < kMippedSide; ++y)
            for (int x = 0; x < kMippedSide; ++x) {
                if (x >= 32 && x < 32 + gap) continue;
                covered.at(x, y) = 1;
                normal.at(x, y) = glm::vec3(0, 0, 1);
                sh.at(x, y) = shOf(sunAndSky, {(x + 0.5) / kMippedSide, (y + 0.5) / kMippedSide});
                for (glm::vec3& coefficient : sh.at(x, y)) coefficient *= x < 32 ? 1.0f : 6.0f;
            }
        (void)writer->append(sh.view(), {covered.view(), normal.view()});
        (void)writer->commit();
    }
    Outcome cook(const std::string& output, const std::string& folder = "out") const {
        scene_.writeSceneFile(output);
        CookOptions options = scene_.options();
        options.onlyKind = "light-map";
        options.output = scene_ / folder;
        options.force = true;
        return cookScene(options, RunState());
    }
    std::filesystem::path operator/(const std::filesystem::path& name) const { return scene_ / name; }

private:
    SmallScene scene_{SmallScene::Parts::LightMap};
};

const Json& mapOf(const Outcome& outcome) {
    return outcome.report.at("assets").at(0);
}

TEST(LightMapMipsSoak, EachLevelIsVerifiedInLayoutsOfEveryKind) {
    const MippedScene scene(8);
    constexpr std::array<std::array<const char*, 2>, 6> kCooks = {
        {{"hdr", "ktx2"}, {"basis-4", "dds"}, {"godot", "dds"}, {"ratio", "ktx2"}, {"raw", "ktx2"}, {"raw", "dds"}}};
    for (const auto& [layout, container] : kCooks) {
        const std::string output = fmt::format("light_map_layout = \"{}\"\ncontainer = \"{}\"\nmax_error = 0.5\n", layout, container);
        const Outcome outcome = scene.cook(output + "mips = true");
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << layout << ": " << error.line();
        const Json& map = mapOf(outcome);
        ASSERT_EQ(map.at("mips").size(), 3u) << "8 texels keep charts apart at level 3, which begin at texels of it: " << layout;
        EXPECT_EQ(map.at("mips").at(2).at("name"), "mip 3");
        EXPECT_THAT(map.at("mips_end").get<std::string>(), HasSubstr("level 4"));
        for (const Json& mip : map.at("mips")) {
            const Json& error = mip.at("error").at("diffuse");
            EXPECT_LT(error.at("rel_rms").get<double>(), 0.3) << layout << mip.at("name");
            EXPECT_LE(error.at("max_sampled").get<double>(), error.at("max_bound").get<double>()) << layout << mip.at("name");
        }
        const auto manifest = loadManifest(scene / "out");
        ASSERT_TRUE(manifest);
        for (const CookedTexture& texture : manifest->assets.front().textures) {
            const bool isFetched = texture.sampler.filter == "nearest";
            EXPECT_EQ(texture.mips, isFetched ? 1 : 4) << texture.role;
            if (!isFetched) {
                EXPECT_EQ(texture.sampler.filter, "trilinear");
            }
        }
    }
}

TEST(LightMapMips, LevelsHoldTheMeanOfTheirChart) {
    const MippedScene scene(4);
    const Outcome outcome = scene.cook("target = \"float\"\nlight_map_layout = \"raw\"\nmips = true");
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    const auto manifest = loadManifest(scene / "out");
    ASSERT_TRUE(manifest);
    const CookedAsset& map = manifest->assets.front();
    const auto texture = formats::TextureReader::open(scene / "out" / map.textures.front().file);
    ASSERT_TRUE(texture);
    ASSERT_EQ(texture->shape().mipCount, 3);
    const double range = map.constants->at("range").at(0).get<double>();
    for (int mip = 1; mip < 3; ++mip) {
        const auto texels = verify::decodeImage(*texture, {mip, 0, 0});
        ASSERT_TRUE(texels);
        const int side = 1 << mip;
        for (const int x : {0, 32 / side - 1, 36 / side, kMippedSide / side - 1}) {
            double sum = 0, count = 0;
            for (int dx = 0; dx < side; ++dx)
                for (int dy = 0; dy < side; ++dy) {
                    const int fromX = x * side + dx, fromY = 5 * side + dy;
                    if (fromX >= 32 && fromX < 36) continue;
                    sum += (fromX < 32 ? 1.0 : 6.0) *
                           static_cast<double>(shOf(sunAndSky, {(fromX + 0.5) / kMippedSide, (fromY + 0.5) / kMippedSide})[0].x);
                    ++count;
                }
            EXPECT_NEAR(range * static_cast<double>(texels->at(x, 5).x), sum / count, 2e-3 * sum / count) << mip << ", " << x;
        }
    }
}

TEST(LightMapMipsSoak, ChartsThatAreCloseEndThem) {
    for (const auto& [gap, count] : {std::pair(1, 0), std::pair(2, 1), std::pair(4, 2)}) {
        const MippedScene scene(gap);
        const Outcome outcome = scene.cook("light_map_layout = \"basis-4\"\nmips = true\nmax_error = 0.5");
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << gap << ": " << error.line();
        const Json& map = mapOf(outcome);
        EXPECT_EQ(map.contains("mips") ? map.at("mips").size() : 0, static_cast<std::size_t>(count)) << gap;
        EXPECT_EQ(map.at("mips_end"), fmt::format("level {} would mix charts, at its texel ({}, 0)", count + 1, 32 >> (count + 1)));
    }
}

TEST(LightMapMips, ALimitHoldsForEachLevel) {
    const MippedScene scene(8);
    const Outcome outcome = scene.cook("light_map_layout = \"hdr\"\nmips = true\nmax_error = 1e-3");
    ASSERT_FALSE(outcome.errors.empty());
    std::string all;
    for (const Json& failure : mapOf(outcome).at("failures")) all += failure.at("message").get<std::string>() + "\n";
    for (const char* mip : {"mip 1, diffuse", "mip 3, diffuse", "mip 0 to 1, diffuse", "mip 2 to 3, specular"})
        EXPECT_THAT(all, HasSubstr(mip));
    const Json& blends = mapOf(outcome).at("mip_blends");
    ASSERT_EQ(blends.size(), 3u);
    for (const Json& blend : blends) EXPECT_GT(blend.at("error").at("diffuse").at("rel_rms").get<double>(), 1e-3) << blend.at("name");
}

TEST(LightMapMipsSoak, WithoutThemTheBytesAreTheSame) {
    const MippedScene scene(8);
    for (const char* keys : {"", "mips = false", "mips = true"}) {
        // With mip levels the hardware filters by default.
        const std::string output = fmt::format("light_map_layout = \"basis-4\"\nfilter = \"hardware\"\n{}", keys);
        const Outcome outcome = scene.cook(output, fmt::format("out{}", keys));
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    }
    const std::string file = "map_l0.ktx2", without = formats::contentOf(scene / "out" / file);
    EXPECT_EQ(without, formats::contentOf(scene / "outmips = false" / file));
    const auto level0 = [&](const char* folder) { return *formats::TextureReader::open(scene / folder / file)->readImage({}); };
    EXPECT_EQ(level0("out"), level0("outmips = true"));
}

TEST(LightMapMipsSoak, OneThreadAndTwoGiveTheSameBytes) {
    const MippedScene scene(8);
    std::vector<std::string> bytes;
    for (const int threads : {1, 2}) {
        tbb::task_arena arena(threads);
        const std::string folder = fmt::format("out{}", threads);
        const Outcome outcome = arena.execute([&] { return scene.cook("light_map_layout = \"basis-4\"\nmips = true", folder); });
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
        bytes.push_back(formats::contentOf(scene / folder / "map_l0.ktx2") + formats::contentOf(scene / folder / "map_code.ktx2"));
    }
    EXPECT_EQ(bytes[0], bytes[1]);
}

TEST(LightMapMips, OtherValuesAreRefused) {
    const MippedScene scene(8);
    const Outcome outcome = scene.cook("mips = 3");
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::InvalidRequest);
    EXPECT_THAT(outcome.errors.front().line(), HasSubstr("mips"));
    EXPECT_THAT(outcome.errors.front().line(), HasSubstr("true or false"));
}

}  // namespace
}  // namespace lightcook::pipeline
