// Figures that add up: the memory of a report is that of the files, by kind, by format and by asset; its time and memory are those of the
// runs that made the results; what was skipped would have cost what the report says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/gltf_scene.h"
#include "formats/gpu_texture.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "tests/pipeline/report_parts.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;

std::uint64_t sumOf(const Json& byName) {
    std::uint64_t sum = 0;
    for (const auto& [name, bytes] : byName.items()) sum += bytes.get<std::uint64_t>();
    return sum;
}

/// GPU memory of a texture file, level by level, from its header alone.
std::uint64_t textureBytes(const std::filesystem::path& file) {
    const auto reader = formats::TextureReader::open(file);
    if (!reader) throw std::runtime_error(reader.error().line());
    const formats::TextureShape& shape = reader->shape();
    const formats::PixelFormatInfo& format = formats::info(shape.format);
    std::uint64_t bytes = 0;
    for (int mip = 0; mip < shape.mipCount; ++mip) {
        const int width = std::max(1, shape.width >> mip), height = std::max(1, shape.height >> mip);
        const int across = (width + format.blockWidth - 1) / format.blockWidth,
                  down = (height + format.blockHeight - 1) / format.blockHeight;
        bytes += static_cast<std::uint64_t>(across) * static_cast<std::uint64_t>(down) * static_cast<std::uint64_t>(format.bytesPerBlock) *
                 static_cast<std::uint64_t>(shape.layerCount) * static_cast<std::uint64_t>(shape.faceCount);
    }
    return bytes;
}

/// GPU memory that a mesh adds for its light map: two 16-bit coordinates a vertex, or floats, and the padded byte of the basis.
std::uint64_t meshBytes(const std::filesystem::path& file, bool isDraco) {
    const auto scene = formats::GltfScene::load(file);
    if (!scene) throw std::runtime_error(scene.error().line());
    std::uint64_t bytes = 0;
    for (const formats::TriangleMesh* primitive : scene->triangleMeshes())
        bytes += primitive->vertexCount() * ((isDraco ? 4 : 8) + (primitive->find("_LIGHTCOOK_BASIS") != nullptr ? 4 : 0));
    return bytes;
}

/// GPU memory of everything that the manifest names, from the files and the tables themselves.
std::uint64_t payload(const std::filesystem::path& folder) {
    const Json manifest = readManifest(folder).value();
    std::uint64_t bytes = 0;
    for (const Json& asset : manifest.at("assets")) {
        for (const Json& texture : asset.at("textures")) bytes += textureBytes(folder / texture.at("file").get<std::string>());
        if (asset.contains("file")) bytes += meshBytes(folder / asset.at("file").get<std::string>(), asset.at("layout") == "glb-draco");
    }
    return bytes;
}

void expectSums(const Json& report, const std::filesystem::path& folder) {
    const Json& budget = report.at("budget");
    const auto used = budget.at("used_bytes").get<std::uint64_t>();
    std::uint64_t assets = 0;
    for (const Json& asset : report.at("assets")) assets += asset.at("bytes_gpu").get<std::uint64_t>();
    EXPECT_EQ(assets, used);
    EXPECT_EQ(sumOf(budget.at("by_kind")), used);
    EXPECT_EQ(sumOf(budget.at("by_format")), used) << budget.at("by_format");
    EXPECT_EQ(payload(folder), used);
}

class Figures : public testing::Test {
protected:
    Outcome cookShipped(const std::string& layout, bool hasDraco = true) const {
        CookOptions options;
        options.scene = std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "examples/cornell/scene.toml";
        options.output = folder_ / "out";
        options.cache = LIGHTCOOK_TEST_CACHE;
        options.given.set("output.effort", 0);
        options.given.set("output.light_map_layout", layout);
        options.given.set("output.max_error", 1);
        options.given.set("output.draco", hasDraco);
        options.samples = 0;
        const RunState state;
        return cookScene(options, state);
    }
    const formats::TemporaryFolder folder_;
};

TEST_F(Figures, OfMemoryAddUpForEveryKindOfAssetAndLayout) {
    for (const auto& [layout, draco] : {std::pair("basis-8", false), std::pair("ratio", true)}) {
        SCOPED_TRACE(layout);
        const Outcome outcome = cookShipped(layout, draco);
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        expectSums(outcome.report, folder_ / "out");
        const bool isLearned = std::string(layout).starts_with("basis");
        EXPECT_EQ(outcome.report.at("budget").at("by_format").contains("rgba16f"), isLearned) << "the tables";
        if (draco) continue;  // one verification, of the folder with a mesh without Draco and with tables
        const RunState state;
        expectSums(verifyCooked({folder_ / "out", {}, {}}, state).report, folder_ / "out");
    }
}

TEST_F(Figures, OfNotesAndMeasuresHaveCaptions) {
    const Outcome outcome = cookShipped("ratio");
    const std::string captions = formats::contentOf(std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "viewer/report/captions.js");
    int count = 0;
    for (const Json& asset : outcome.report.at("assets"))
        for (const char* member : {"notes", "measures"}) {
            const Json figures = asset.value(member, Json::object());
            for (const auto& [key, value] : figures.items()) {
                EXPECT_THAT(captions, HasSubstr("\n  " + key + ": \"")) << asset.at("name");
                ++count;
            }
        }
    EXPECT_GT(count, 0);
}

using FiguresSoak = Figures;
TEST_F(FiguresSoak, OfMemoryAddUpBesideAMeshInDraco) {
    const Outcome outcome = cookShipped("basis-8");
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    expectSums(outcome.report, folder_ / "out");
}

TEST_F(FiguresSoak, OfMemoryAddUpWithoutAMeshOrDirections) {
    const SmallScene scene(SmallScene::Parts::All);
    const RunState state;
    for (const char* output :
         {"target = \"astc\"\nlight_map_layout = \"basis-4\"", "target = \"float\"\nlight_map_layout = \"sh4\"\nmax_error = 1"}) {
        scene.writeSceneFile(output);
        const Outcome outcome = cookScene(scene.options(), state);
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        expectSums(outcome.report, scene / "out");
    }
}

/// Everything is cooked once; then nothing needs directions. What the second report says was saved is what the first one had.
void expectSkipsOf(const std::string& target) {
    const SmallScene scene(SmallScene::Parts::All);
    const RunState state;
    const std::string output = fmt::format("target = \"{}\"\nlight_map_layout = \"ratio\"\n", target);
    scene.writeSceneFile(output);
    const Outcome whole = cookScene(scene.optionsWithOwnCache(), state);
    scene.writeSceneFile(output, "[[material]]\nname = \"*\"\nnormal_map = false\nspecular = false\n");
    const Outcome flat = cookScene(scene.optionsWithOwnCache(), state);
    ASSERT_TRUE(whole.errors.empty() && flat.errors.empty());
    const auto bytesOf = [](const Outcome& outcome, const std::string& name) {
        for (const Json& row : outcome.report.at("assets"))
            if (row.at("name") == name) return row.at("bytes_gpu").get<std::int64_t>();
        return std::int64_t{0};
    };
    const auto saved = [&](const char* what) { return skipOf(flat.report, what).at("bytes_saved").get<std::int64_t>(); };
    EXPECT_EQ(saved("directional light map"), bytesOf(whole, "map") - bytesOf(flat, "map")) << target;
    EXPECT_EQ(saved("dominant light"), bytesOf(whole, "map_dominant")) << target;
    EXPECT_EQ(saved("cubemap"), bytesOf(whole, "probe")) << target;
    EXPECT_EQ(saved("RSRM"), bytesOf(whole, "sky") - bytesOf(flat, "sky")) << target;
    // Time was measured by the first cook: that of its own action, for as many texels.
    for (const Json& row : whole.report.at("assets")) {
        if (row.at("name") != "probe") continue;
        EXPECT_NEAR(skipOf(flat.report, "cubemap").at("seconds_saved").get<double>(), row.at("seconds").get<double>(), 1e-6);
    }
}

TEST_F(Figures, OfSkipsAreWhatTheCookWithoutThemHad) {
    expectSkipsOf("bc");
}

TEST_F(FiguresSoak, OfSkipsAreWhatTheCookWithoutThemHad) {
    expectSkipsOf("float");
}

TEST_F(Figures, OfTimeThatWasNeverMeasuredAreNone) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    scene.writeSceneFile("", "[[material]]\nname = \"*\"\nnormal_map = true\nspecular = false\n");
    const RunState state;
    const Outcome outcome = cookScene(scene.optionsWithOwnCache(), state);
    ASSERT_TRUE(outcome.errors.empty());
    EXPECT_TRUE(skipOf(outcome.report, "dominant light").at("seconds_saved").is_null());
}

TEST_F(Figures, OfAWarmCookAreThoseOfTheRunThatMadeTheResult) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    const RunState state;
    const Json first = cookScene(scene.optionsWithOwnCache(), state).report;
    ASSERT_EQ(first.at("runs").size(), 1u);
    const Json run = first.at("runs")[0];
    EXPECT_EQ(run.at("seconds"), first.at("seconds"));
    EXPECT_EQ(run.at("peak_rss_bytes"), first.at("peak_rss_bytes"));
    EXPECT_GT(run.at("actions").get<int>(), 3);
    for (const Json& row : first.at("assets")) EXPECT_EQ(row.at("cooked_at"), run.at("at"));
    // Nothing to do, but another folder: the report is written anew, from the cache.
    CookOptions elsewhere = scene.optionsWithOwnCache();
    elsewhere.output = scene / "elsewhere";
    const Outcome warm = cookScene(elsewhere, state);
    EXPECT_EQ(warm.actionsRun, 0);
    EXPECT_EQ(warm.report.at("runs"), first.at("runs"));
    EXPECT_EQ(warm.report.at("seconds"), first.at("seconds"));
    EXPECT_EQ(warm.report.at("peak_rss_bytes"), first.at("peak_rss_bytes"));
    EXPECT_THAT(formats::contentOf(scene / "elsewhere" / kReportHtmlName), HasSubstr(run.at("at").dump()));
    // One asset is made again: both runs are named, and add up. Of the first one only what is still used counts.
    scene.writeSceneFile("light_map_layout = \"hdr-2\"");
    const Json second = cookScene(scene.optionsWithOwnCache(), state).report;
    ASSERT_EQ(second.at("runs").size(), 2u);
    EXPECT_EQ(second.at("runs")[0].at("at"), run.at("at"));
    EXPECT_LT(second.at("runs")[0].at("seconds").get<double>(), run.at("seconds").get<double>());
    EXPECT_NEAR(second.at("seconds").get<double>(),
                second.at("runs")[0].at("seconds").get<double>() + second.at("runs")[1].at("seconds").get<double>(), 1e-9);
    for (const Json& row : second.at("assets"))
        EXPECT_EQ(row.at("cooked_at"), second.at("runs")[row.at("name") == "map" ? 1 : 0].at("at")) << row.at("name");
}

}  // namespace
}  // namespace lightcook::pipeline
