#include "pipeline/command/compare.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <vector>

#include "formats/gpu_texture.h"
#include "formats/light_map.h"
#include "formats/plain_image.h"
#include "lighting/sh.h"
#include "pipeline/command/decode.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;

class CompareFiles : public testing::Test {
protected:
    /// Writes 3 x 2 texels of 0.5, and `odd` into blue at (2, 1).
    std::filesystem::path image(const char* name, float odd) const {
        formats::Image<glm::vec4> texels(3, 2, glm::vec4(0.5f));
        texels.at(2, 1).z = odd;
        EXPECT_TRUE(formats::writeExr(folder_ / name, texels.view(), 3).has_value());
        return folder_ / name;
    }
    static formats::Result<Json> compare(const std::filesystem::path& a, const std::filesystem::path& b) {
        const RunState state;
        return compareFiles(a, b, state).map([](const Comparison& compared) { return compared.figures; });
    }
    static std::string refusalOf(const std::filesystem::path& a, const std::filesystem::path& b, formats::ErrorCode code) {
        const auto compared = compare(a, b);
        if (compared) return "not refused";
        EXPECT_EQ(compared.error().code, code);
        return compared.error().line();
    }

    formats::TemporaryFolder folder_;
};

TEST_F(CompareFiles, MeasuresTheLargestDifference) {
    const auto compared = compare(image("a.exr", 0.5f), image("b.exr", 0.75f));
    ASSERT_TRUE(compared.has_value());
    EXPECT_DOUBLE_EQ(compared->at("max_abs").get<double>(), 0.25);
    EXPECT_DOUBLE_EQ(compared->at("rmse").get<double>(), std::sqrt(0.25 * 0.25 / 18));
}

TEST_F(CompareFiles, RefusesValuesThatAreNotFinite) {
    const auto fine = image("fine.exr", 0.5f);
    for (const float odd : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        const auto bad = image("bad.exr", odd);
        EXPECT_THAT(refusalOf(fine, bad, formats::ErrorCode::ValueNotFinite), HasSubstr("bad.exr, channel B, texel (2, 1): found "));
        EXPECT_THAT(refusalOf(bad, fine, formats::ErrorCode::ValueNotFinite), HasSubstr("bad.exr, channel B, texel (2, 1): found "));
    }
}

TEST_F(CompareFiles, TakesEveryLayerAndMipOfTextures) {
    using formats::PixelFormat;
    const auto texture = [&](const char* name, int layers, int mips, formats::SubImage bright) {
        const formats::TextureShape shape{PixelFormat::Rgba8Unorm, 4, 4, mips, layers, layers > 1, 1};
        auto writer = formats::TextureWriter::create(folder_ / name, shape, {});
        EXPECT_TRUE(writer.has_value());
        for (int mip = 0; mip < mips; ++mip)
            for (int layer = 0; layer < layers; ++layer) {
                const bool isBright = mip == bright.mip && layer == bright.layer;
                const std::vector<std::byte> bytes(shape.imageBytes(mip), std::byte{static_cast<unsigned char>(isBright ? 255 : 51)});
                EXPECT_TRUE(writer->writeBlockRows({mip, layer, 0}, 0, bytes).has_value());
            }
        EXPECT_TRUE(writer->commit().has_value());
        return folder_ / name;
    };
    const auto plain = texture("plain.ktx2", 3, 1, {-1, -1, 0}), mipped = texture("mipped.ktx2", 1, 2, {-1, -1, 0});
    const auto layer = compare(plain, texture("layer.ktx2", 3, 1, {0, 2, 0})), mip = compare(mipped, texture("mip.ktx2", 1, 2, {1, 0, 0}));
    ASSERT_TRUE(layer.has_value()) << layer.error().line();
    ASSERT_TRUE(mip.has_value()) << mip.error().line();
    EXPECT_NEAR(layer->at("max_abs").get<double>(), 0.8, 1e-6);
    EXPECT_EQ(layer->at("images"), 3);
    EXPECT_NEAR(mip->at("max_abs").get<double>(), 0.8, 1e-6);
    EXPECT_EQ(mip->at("images"), 2);
    EXPECT_THAT(refusalOf(plain, mipped, formats::ErrorCode::WrongShape), HasSubstr("mipped.ktx2: found 1 layer(s), expected 3 as in"));
    EXPECT_THAT(refusalOf(mipped, texture("one.ktx2", 1, 1, {}), formats::ErrorCode::WrongShape), HasSubstr("found 1 mip(s), expected 2"));
    const auto picture = compare(image("a.exr", 0.5f), image("b.exr", 0.75f));
    EXPECT_EQ(picture->at("channels"), 3);
}

TEST_F(CompareFiles, SaysHowManyChannelsEachImageHas) {
    const formats::Image<glm::vec4> texels(4, 4, glm::vec4(0.5f));
    ASSERT_TRUE(formats::writeExr(folder_ / "rgba.exr", texels.view(), 4));
    ASSERT_TRUE(formats::writeExr(folder_ / "rgb.exr", texels.view(), 3));
    const auto differences = compare(folder_ / "rgba.exr", folder_ / "rgb.exr");
    ASSERT_TRUE(differences.has_value()) << differences.error().line();
    EXPECT_EQ(differences->at("channels"), 3);
    EXPECT_EQ(differences->at("a_channels"), 4);
    EXPECT_EQ(differences->at("b_channels"), 3);
}

/// The fourth colour of three of BC1 is transparent black, and opaque black is another one.
TEST_F(CompareFiles, SeesTheTransparencyOfBc1) {
    const auto texture = [&](const char* name, std::array<unsigned char, 8> block) {
        formats::TextureFileOptions options;
        options.container = formats::Container::Dds;
        auto writer = formats::TextureWriter::create(folder_ / name, {formats::PixelFormat::Bc1, 4, 4, 1, 1, false, 1}, options);
        EXPECT_TRUE(writer && writer->writeBlockRows({}, 0, std::as_bytes(std::span(block))) && writer->commit());
        return folder_ / name;
    };
    const auto transparent = texture("transparent.dds", {0, 0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff});
    const auto black = texture("black.dds", {0, 0, 1, 0, 0, 0, 0, 0});
    for (const auto& [a, b] : {std::pair(transparent, black), std::pair(black, transparent)}) {
        const auto differences = compare(a, b);
        ASSERT_TRUE(differences) << differences.error().line();
        EXPECT_EQ(differences->at("max_abs"), 1);
        EXPECT_EQ(differences->at("alpha_compared"), true);
        EXPECT_EQ(differences->at("channels"), 4);
    }
    EXPECT_EQ(compare(black, black)->at("channels"), 3);
    for (const auto& [file, channels] : {std::pair(transparent, 4), std::pair(black, 3)}) {
        ASSERT_TRUE(decodeTexture({file, folder_ / "out.exr", 0, 0}));
        const auto decoded = formats::readImage(folder_ / "out.exr");
        EXPECT_EQ(decoded->channelCount, channels);
        EXPECT_EQ(decoded->texels.at(2, 2), glm::vec4(0, 0, 0, channels == 4 ? 0 : 1));
        EXPECT_EQ(compare(file, folder_ / "out.exr")->at("max_abs"), 0);
    }
}

TEST_F(CompareFiles, ComparesAlphaWithAlpha) {
    const auto grey = [&](const char* name, int alpha) {
        formats::writePng(folder_ / name, 2, 2, 2, [alpha](int channel, int, int) { return channel == 0 ? 100 : alpha; });
        return folder_ / name;
    };
    const auto differences = compare(grey("a.png", 255), grey("b.png", 0));
    ASSERT_TRUE(differences) << differences.error().line();
    EXPECT_EQ(differences->at("max_abs"), 1);
}

TEST_F(CompareFiles, NamesTheFileBesideAFolder) {
    const auto file = image("a.exr", 0.5f);
    EXPECT_THAT(refusalOf(folder_.path(), folder_ / "nowhere", formats::ErrorCode::FileUnreadable),
                HasSubstr("nowhere: found no such folder"));
    EXPECT_THAT(refusalOf(file, folder_.path(), formats::ErrorCode::FileUnreadable),
                HasSubstr("a.exr: found a file, expected a cooked folder"));
}

/// Light maps of even light from above.
class CompareLightMaps : public CompareFiles {
protected:
    /// Writes 70 rows, more than one chunk, whose normal is (0, 0, 1). Light of coefficient 0 is 1 in red, green and blue; `scale` times
    /// that in the last row.
    std::filesystem::path lightMap(const char* name, float scale, int width = 5) const {
        constexpr int kHeight = 70;
        formats::Image<lighting::ShRgb> sh(width, kHeight);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < width; ++x) sh.at(x, y)[0] = glm::vec3(y == kHeight - 1 ? scale : 1);
        auto writer = formats::LightMapWriter::create(folder_ / name, width, kHeight);
        EXPECT_TRUE(writer && writer->append(sh.view()) && writer->commit());
        return folder_ / name;
    }
};

TEST_F(CompareLightMaps, MeasuresTheErrorsOfShadedLight) {
    const auto compared = compare(lightMap("a.exr", 1), lightMap("b.exr", 1.5f));
    ASSERT_TRUE(compared.has_value()) << compared.error().line();
    EXPECT_EQ(compared->at("texels"), 350);
    const Json& diffuse = compared->at("diffuse");
    // One of 70 rows is brighter by half.
    EXPECT_NEAR(diffuse.at("rel_rms").get<double>(), 0.5 / std::sqrt(70.0), 1e-5);
    EXPECT_NEAR(diffuse.at("max").get<double>(), 0.5 / 1.02, 1e-4);
    EXPECT_LT(diffuse.at("visible").at("p50").get<double>(), 1e-3);
    EXPECT_GT(diffuse.at("visible").at("p99").get<double>(), 10) << "one texel in 70";
    EXPECT_GT(compared->at("specular").at("rel_rms").get<double>(), 0.01);

    const auto same = compare(folder_ / "a.exr", lightMap("same.exr", 1));
    ASSERT_TRUE(same.has_value());
    for (const char* kind : {"diffuse", "specular"}) {
        EXPECT_EQ(same->at(kind).at("rel_rms").get<double>(), 0);
        EXPECT_EQ(same->at(kind).at("visible").at("max").get<double>(), 0);
    }
}

/// The file that reconstruct writes says which texels of a bake without coverage count, and their normals.
TEST_F(CompareLightMaps, TakesCoverageAndNormalsFromTheMapThatHasThem) {
    constexpr int kWidth = 5, kHeight = 70;
    const auto bake = lightMap("a.exr", 1);
    formats::Image<lighting::ShRgb> sh(kWidth, kHeight);
    formats::Image<std::uint8_t> covered(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            covered.at(x, y) = y >= 10 ? 1 : 0;
            sh.at(x, y)[0] = glm::vec3(y >= 10 ? 1 : 9);  // anything outside charts
            sh.at(x, y)[1] = glm::vec3(0.5f);             // light along y, which the bake does not have
        }
    const auto diffuseBeside = [&](const glm::vec3& direction) {
        const formats::Image<glm::vec3> normal(kWidth, kHeight, direction);
        auto writer = formats::LightMapWriter::create(folder_ / "b.exr", kWidth, kHeight, formats::SurfaceOutput::CoverageAndNormals);
        EXPECT_TRUE(writer && writer->append(sh.view(), {covered.view(), normal.view()}) && writer->commit());
        const auto compared = compare(bake, folder_ / "b.exr");
        EXPECT_TRUE(compared.has_value());
        EXPECT_EQ(compared->at("texels"), 300);
        return compared->at("diffuse").at("rel_rms").get<double>();
    };
    const double along = diffuseBeside({0, 1, 0}), across = diffuseBeside({0, 0, 1});
    EXPECT_LT(along, 1) << "only covered texels count";
    EXPECT_GT(along, across + 0.003) << "light along y is brighter to normals along y";
}

TEST_F(CompareLightMaps, WarnsWhereNeitherFileSaysWhatCounts) {
    std::vector<std::string> warnings;
    RunState state;
    state.warning = [&](const std::string&, const std::string& detail) { warnings.push_back(detail); };
    ASSERT_TRUE(compareFiles(lightMap("a.exr", 1), lightMap("b.exr", 1), state));
    EXPECT_THAT(warnings, testing::ElementsAre(testing::AllOf(
                              HasSubstr("found no coverage (coverage.Y, or alpha) and no normals (normal.X, normal.Y, normal.Z) in it or "),
                              HasSubstr("texels outside charts count, and light is compared about (0, 0, 1)"))));
}

TEST_F(CompareLightMaps, TakesCoefficientsThatNoLightHas) {
    formats::Image<lighting::ShRgb> sh(5, 70);
    for (lighting::ShRgb& texel : sh.texels()) texel[0] = glm::vec3(1);
    sh.at(2, 3)[0].x = -0.25f;
    sh.at(3, 3)[5].y = 40;
    sh.at(4, 3)[0] = glm::vec3(1e6f);
    auto writer = formats::LightMapWriter::create(folder_ / "cooked.exr", 5, 70);
    ASSERT_TRUE(writer && writer->append(sh.view()) && writer->commit());
    const auto compared = compare(lightMap("a.exr", 1), folder_ / "cooked.exr");
    ASSERT_TRUE(compared.has_value()) << compared.error().line();
    EXPECT_GT(compared->at("diffuse").at("max").get<double>(), 1e5);
}

TEST_F(CompareLightMaps, RefusesValuesThatAreNotFinite) {
    formats::Image<lighting::ShRgb> sh(5, 70);
    sh.at(4, 66)[8].z = std::numeric_limits<float>::infinity();
    auto writer = formats::LightMapWriter::create(folder_ / "bad.exr", 5, 70);
    ASSERT_TRUE(writer && writer->append(sh.view()) && writer->commit());
    EXPECT_THAT(refusalOf(lightMap("a.exr", 1), folder_ / "bad.exr", formats::ErrorCode::ValueNotFinite),
                HasSubstr("bad.exr, channel sh08.B, texel (4, 66): found "));
}

TEST_F(CompareLightMaps, ReadsEachMapByItsConventions) {
    const auto write = [&](const char* name, float sign) {
        formats::Image<lighting::ShRgb> sh(4, 4);
        for (lighting::ShRgb& texel : sh.texels()) {
            texel[0] = glm::vec3(1);
            texel[1] = glm::vec3(sign * 0.4f);
        }
        auto writer = formats::LightMapWriter::create(folder_ / name, 4, 4);
        EXPECT_TRUE(writer && writer->append(sh.view()) && writer->commit());
        return folder_ / name;
    };
    const auto baked = write("baked.exr", -1), canonical = write("canonical.exr", 1);
    formats::LightMapDescription ofBake;
    ofBake.phase = formats::ShPhase::CondonShortley;
    const auto error = [&](const formats::LightMapDescription& ofA, const formats::LightMapDescription& ofB) {
        const auto compared = compareFiles(baked, canonical, RunState(), ofA, ofB);
        return compared ? compared->figures.at("diffuse").at("rel_rms").get<double>() : -1;
    };
    EXPECT_EQ(error(ofBake, {}), 0);
    EXPECT_GT(error({}, {}), 0.1);
    EXPECT_GT(error(ofBake, ofBake), 0.1);
}

TEST_F(CompareLightMaps, OtherFilesHaveNoConventions) {
    const auto refusal = [&](const formats::LightMapDescription& ofA, const formats::LightMapDescription& ofB) {
        const auto compared = compareFiles(image("a.exr", 0.5f), image("b.exr", 0.5f), RunState(), ofA, ofB);
        if (compared) return std::string("not refused");
        EXPECT_EQ(compared.error().code, formats::ErrorCode::InvalidRequest);
        return compared.error().line();
    };
    formats::LightMapDescription turned, onMesh, spread;
    turned.phase = formats::ShPhase::CondonShortley;
    onMesh.mesh = folder_ / "room.glb";
    spread.fireflyLimit = 10;
    EXPECT_THAT(refusal(turned, turned), HasSubstr("a.exr: found images or textures with --phase, expected light maps: name the bake"));
    EXPECT_THAT(refusal(onMesh, {}), HasSubstr("with --mesh, expected light maps"));
    EXPECT_THAT(refusal({}, spread), HasSubstr("with --firefly-limit, expected light maps"));
    EXPECT_EQ(refusal({}, {}), "not refused");
}

TEST_F(CompareLightMaps, RefusesOtherSizes) {
    const auto map = lightMap("a.exr", 1);
    EXPECT_THAT(refusalOf(map, lightMap("wide.exr", 1, 6), formats::ErrorCode::WrongShape),
                HasSubstr("wide.exr: found 6 x 70 texels, expected 5 x 70 as in"));
    EXPECT_THAT(refusalOf(map, image("flat.exr", 0.5f), formats::ErrorCode::WrongShape), HasSubstr("flat.exr: found 3 x 2 texels"));
}

TEST_F(CompareLightMaps, RefusesABakeThatNeedsItsMesh) {
    const auto map = lightMap("a.exr", 1);
    for (const char* name : {"room_RNM0.exr", "room_RNM1.exr", "room_RNM2.exr"}) image(name, 0.5f);
    EXPECT_THAT(refusalOf(map, folder_ / "room_RNM0.exr", formats::ErrorCode::FormatUnsupported),
                HasSubstr("found bake format bakery-rnm, whose light depends on a mesh"));
}

}  // namespace
}  // namespace lightcook::pipeline
