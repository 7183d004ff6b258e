// cook --patch: what it keeps of the last cook, which bytes change, and when it cooks in full.
#include "pipeline/cook/patch.h"

#include <gmock/gmock.h>
#include <tbb/task_arena.h>

#include "formats/gpu_texture.h"
#include "pipeline/cook/cook.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// The scene with more light in a corner: in the first strip, and further from the second than an encoder looks.
glm::vec3 withBrightCorner(const glm::dvec3& direction, const glm::dvec2& place) {
    const float factor = place.x < 0.3 && place.y < 0.08 ? 1.2f : 1.0f;
    return factor * sunAndSky(direction, place);
}
constexpr int kSecondStrip = 64;  ///< its first row

/// Returns the rows of all layers of a texture from a row on.
std::vector<std::byte> blocksFrom(const fs::path& file, int firstRow) {
    std::vector<std::byte> all;
    const auto texture = formats::TextureReader::open(file);
    EXPECT_TRUE(texture) << file;
    if (!texture) return all;
    const formats::TextureShape& shape = texture->shape();
    const int height = formats::info(shape.format).blockHeight;
    std::vector<std::byte> blocks(formats::bytesPerBlockRow(shape.format, shape.width));
    for (int layer = 0; layer < shape.layerCount; ++layer)
        for (int row = firstRow / height; row < formats::blocksDown(shape.format, shape.height); ++row) {
            EXPECT_TRUE(texture->readBlockRows({0, layer, 0}, row, blocks));
            all.insert(all.end(), blocks.begin(), blocks.end());
        }
    return all;
}

/// Returns the files of a folder by name; of its report what is no time.
std::map<std::string, std::string> contentsOf(const fs::path& folder) {
    std::map<std::string, std::string> contents;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        const std::string name = entry.path().lexically_relative(folder);
        if (entry.is_regular_file() && !name.starts_with("report.")) contents[name] = *readFile(entry.path());
    }
    const Json report = parseJson(*readFile(folder / kReportName));
    Json assets = report.at("assets");
    for (Json& asset : assets) {
        for (const char* time : {"seconds", "verify_seconds", "cooked_at", "verified_at", "peak_rss_bytes"}) asset.erase(time);
        for (Json& stage : asset.at("stages")) stage.erase("seconds");
    }
    contents["assets"] = assets.dump(1);
    for (const char* key : {"whole", "lint"})
        if (const auto found = report.find(key); found != report.end()) contents[key] = found->dump(1);
    return contents;
}

class PatchOfAScene : public testing::Test {
protected:
    Outcome cook(bool patch) const {
        CookOptions options = scene_.optionsWithOwnCache();
        options.patch = patch;
        return pipeline::cook(options);
    }
    void write(const std::string& output) const { scene_.writeSceneFile(output, "dominant_layout = \"derived\"\n"); }
    void bake(const LightField& light) const {
        const SmallScene again(SmallScene::Parts::LightMap, light);
        fs::copy_file(again / "map.exr", scene_ / "map.exr", fs::copy_options::overwrite_existing);
    }
    /// Cooks, keeps the folder as "old", and bakes the map again.
    void cookAndBakeAgain(const std::string& output, const LightField& light = withBrightCorner) const {
        write(output);
        bake(sunAndSky);
        EXPECT_TRUE(cook(false).errors.empty());
        fs::remove_all(scene_ / "old");
        fs::copy(scene_ / "out", scene_ / "old", fs::copy_options::recursive);
        bake(light);
    }
    Manifest manifest(const char* folder = "out") const {
        auto manifest = loadManifest(scene_ / folder);
        EXPECT_TRUE(manifest) << manifest.error().line();
        return manifest.value_or(Manifest{});
    }
    /// Returns the files that differ between two folders, without the manifest.
    std::vector<std::string> changedFiles(const char* before, const char* after) const {
        std::vector<std::string> names;
        for (const FileRecord& file : filesOf(manifest(after)))
            if (*readFile(scene_ / before / file.name) != *readFile(scene_ / after / file.name)) names.push_back(file.name);
        return names;
    }

    const SmallScene scene_{SmallScene::Parts::LightMap};
};

TEST_F(PatchOfAScene, ChangesTheBytesOfTheStripThatWasBakedAgainAlone) {
    for (const char* output : {"light_map_layout = \"ratio\"", "light_map_layout = \"basis-4\"", "max_visible = 30",
                               "light_map_layout = \"hdr\"\nmips = true"}) {
        SCOPED_TRACE(output);
        cookAndBakeAgain(output);
        const Outcome patched = cook(true);
        for (const formats::Error& error : patched.errors) ADD_FAILURE() << error.line();
        EXPECT_EQ(patched.whyNotPatched, "");
        const CookedAsset before = manifest("old").assets.at(0), after = manifest().assets.at(0);
        EXPECT_EQ(after.layout, before.layout);
        EXPECT_EQ(after.plan, before.plan);
        EXPECT_EQ(after.constants, before.constants);
        EXPECT_EQ(manifest().cooks.at(0).decisions.keptFrom, parseJson(*readFile(scene_ / "old" / kManifestName)).at("digest"));
        const std::vector<std::string> changed = changedFiles("old", "out");
        EXPECT_FALSE(changed.empty());
        for (const std::string& file : changed)
            EXPECT_EQ(blocksFrom(scene_ / "old" / file, kSecondStrip), blocksFrom(scene_ / "out" / file, kSecondStrip)) << file;

        const RunState state;
        EXPECT_TRUE(verifyCooked({scene_ / "out", {}, {}, false}, state).errors.empty());
        EXPECT_EQ(cook(true).actionsRun, 0) << "nothing changed since";
    }
}

TEST_F(PatchOfAScene, StaysOneAfterACookOfAnotherAssetAlone) {
    cookAndBakeAgain("light_map_layout = \"ratio\"");
    ASSERT_EQ(cook(true).whyNotPatched, "");
    const Decisions patched = manifest().cooks.at(0).decisions;
    CookOptions options = scene_.optionsWithOwnCache();
    options.only = "specular";
    options.force = true;
    const Outcome other = pipeline::cook(options);
    for (const formats::Error& error : other.errors) ADD_FAILURE() << error.line();
    EXPECT_GT(other.actionsRun, 0);
    EXPECT_EQ(manifest().cooks.at(0).decisions.keptFrom, patched.keptFrom);
    EXPECT_EQ(manifest().cooks.at(0).decisions.kept, patched.kept);
    const RunState state;
    for (const formats::Error& error : verifyCooked({scene_ / "out", {}, {}, false}, state).errors) ADD_FAILURE() << error.line();
}

TEST_F(PatchOfAScene, IsThatOfAFullCookWithTheSamePlanAtAnyNumberOfThreads) {
    cookAndBakeAgain("light_map_layout = \"basis-4\"\nmax_whole_visible = 50");
    const std::string plan = manifest().assets.at(0).plan.value_or("");
    const auto content = PartCache(scene_ / "cache", false).find(plan);
    ASSERT_TRUE(content);
    ASSERT_EQ(cook(true).whyNotPatched, "");
    fs::rename(scene_ / "out", scene_ / "warm");
    for (const int threads : {1, 2}) {
        fs::copy(scene_ / "old", scene_ / "out", fs::copy_options::recursive);
        fs::remove_all(scene_ / "cache");
        PartCache(scene_ / "cache", false).store(plan, *content);
        tbb::task_arena arena(threads);
        arena.execute([&] { EXPECT_EQ(cook(true).whyNotPatched, ""); });
        EXPECT_EQ(contentsOf(scene_ / "warm"), contentsOf(scene_ / "out")) << "what the cache had of a strip is what is found there";
        fs::remove_all(scene_ / "out");
    }
}

TEST_F(PatchOfAScene, LooksAtTheStripThatWasBakedAgainAlone) {
    const auto parts = [&] {
        return std::distance(fs::directory_iterator(scene_ / "cache" / PartCache::kFolder), fs::directory_iterator());
    };
    cookAndBakeAgain("light_map_layout = \"ratio\"\nmax_whole_visible = 50");
    const auto all = parts();  // of two strips, and the plan
    ASSERT_EQ(cook(true).whyNotPatched, "");
    EXPECT_EQ(2 * (parts() - all), all - 1) << "each pass made that of the first strip anew, and none of the second";
}

TEST_F(PatchOfAScene, CooksInFullWhereNothingServes) {
    const auto isFull = [&](const char* why) {
        const Outcome patched = cook(true);
        EXPECT_THAT(patched.whyNotPatched, HasSubstr(why));
        EXPECT_EQ(manifest().cooks.at(0).decisions.keptFrom, "");
        fs::remove_all(scene_ / "patched");
        fs::rename(scene_ / "out", scene_ / "patched");
        const Outcome full = cook(false);
        EXPECT_EQ(changedFiles("patched", "out"), std::vector<std::string>());
        EXPECT_EQ(*readFile(scene_ / "patched" / kManifestName), *readFile(scene_ / "out" / kManifestName));
        ASSERT_EQ(patched.errors.size(), full.errors.size());
        for (std::size_t i = 0; i < full.errors.size(); ++i) EXPECT_EQ(patched.errors[i].line(), full.errors[i].line());
    };
    const auto isCorner = [](const glm::dvec2& place) { return place.x < 0.22 && place.y < 0.06; };
    write("light_map_layout = \"ratio\"");
    isFull("cooked.json");  // no folder

    cookAndBakeAgain("light_map_layout = \"ratio\"");
    write("light_map_layout = \"ratio\"\nrdo = 0.02");
    isFull("found another output/rdo");

    cookAndBakeAgain("light_map_layout = \"ratio\"");
    fs::remove_all(scene_ / "cache");
    isFull("found no plan of its last cook in the cache");

    cookAndBakeAgain("light_map_layout = \"ratio\"",
                     [](const glm::dvec3& direction, const glm::dvec2& place) { return 1.1f * sunAndSky(direction, place); });
    isFull("found a key of");

    cookAndBakeAgain("light_map_layout = \"ratio\"", [&](const glm::dvec3& direction, const glm::dvec2& place) {
        const double other = std::pow(std::max(0.0, glm::dot(direction, glm::normalize(glm::dvec3(-0.86, -0.3, 0.4)))), 8);
        return isCorner(place) ? glm::vec3(static_cast<float>(3.5 * other)) : sunAndSky(direction, place);
    });
    isFull("values beyond the ranges of its kept plan");

    // Light of band 2, which the layout does not have, under a limit that the first bake just keeps.
    bake(sunAndSky);
    write("light_map_layout = \"sh4\"");
    const auto report = fromJson<Report>(cook(false).report, kReportName);
    ASSERT_TRUE(report);
    const verify::StageError& total = report->assets.at(0).verdict.stages.back();
    cookAndBakeAgain(
        fmt::format("light_map_layout = \"sh4\"\nmax_error = {}", 1.002 * std::max(total.diffuse.relRms, total.specular.relRms)),
        [&](const glm::dvec3& direction, const glm::dvec2& place) {
            const double more = isCorner(place) ? direction.x * direction.x : 0;
            return sunAndSky(direction, place) + glm::vec3(more * glm::dvec3(0.45, 0.68, 1.1));
        });
    isFull("found a limit that is missed");
}

}  // namespace
}  // namespace lightcook::pipeline
