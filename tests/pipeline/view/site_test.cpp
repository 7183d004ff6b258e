#include "pipeline/view/site.h"

#include <gmock/gmock.h>

#include <glm/gtc/packing.hpp>
#include <set>

#include "formats/gpu_texture.h"
#include "pipeline/command/decode.h"
#include "pipeline/document/json.h"
#include "pipeline/manifest/manifest.h"
#include "tests/pipeline/view/cooked_site.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::ErrorCode;
using testing::Contains;
using testing::HasSubstr;
using testing::Key;
using testing::Not;

Json sceneDataOf(const Site& site) {
    return Json::parse(std::get<std::string>(site.files().at("viewer/scene.json").content));
}

TEST_F(CookedSite, HasThePageTheCookedFilesAndTheBakes) {
    const auto site = open();
    ASSERT_TRUE(site.has_value()) << site.error().line();
    EXPECT_TRUE(site->notes().empty());
    for (const char* path : {"index.html", "assets/page.js", "cooked/cooked.json", "cooked/report.json", "cooked/report.html",
                             "cooked/lightcook.glsl", "viewer/scene.json", "viewer/map.reference.ktx2"})
        EXPECT_THAT(site->files(), Contains(Key(path)));
    EXPECT_EQ(site->files().at("assets/page.js").mediaType, "text/javascript; charset=utf-8");
    EXPECT_EQ(mediaTypeOf("unknown.xyz"), "application/octet-stream");
    const Json data = sceneDataOf(*site);
    EXPECT_EQ(data.at("scene"), "small");
    const Json& map = data.at("light_maps").at(0);
    EXPECT_EQ(map.at("name"), "map");
    // An engine shows the map as the page does with an exposure of 0.18 / key: middle grey of diffuse white, 203 cd/m^2.
    const double key = readManifest(scene_ / "out")->at("assets").at(0).at("key").get<double>();
    EXPECT_NEAR(map.at("display").at("nits").get<double>() / 203, 0.18 / key, 1e-6 / key);
    EXPECT_EQ(map.at("display").at("black"), 0.5);
}

/// Their light is in units of "range", and the EXR does not look as the map does.
TEST_F(CookedSite, DecodedTexelsComeWithTheConstantsOfTheirShader) {
    const Json asset = readManifest(scene_ / "out")->at("assets").at(0);
    const fs::path texture = scene_ / "out" / asset.at("textures").at(0).at("file").get<std::string>();
    const auto facts = decodeTexture({texture, scene_ / "texels.exr", 0, 0});
    ASSERT_TRUE(facts.has_value()) << facts.error().line();
    EXPECT_EQ(facts->at("constants").at("range"), asset.at("constants").at("range"));
}

TEST_F(CookedSite, BakeIsThatOfTheFileInHalfFloats) {
    const auto site = open();
    ASSERT_TRUE(site.has_value()) << site.error().line();
    const double scale = sceneDataOf(*site).at("light_maps").at(0).at("reference_scale");
    const auto bake = formats::LightMapReader::open(scene_ / "map.exr", {});
    ASSERT_TRUE(bake.has_value());
    const auto rows = bake->read(0, bake->height());
    ASSERT_TRUE(rows.has_value());
    const auto texture = formats::TextureReader::open(std::get<fs::path>(site->files().at("viewer/map.reference.ktx2").content));
    ASSERT_TRUE(texture.has_value()) << texture.error().line();
    ASSERT_EQ(texture->shape().layerCount, 9);
    for (int layer = 0; layer < 9; ++layer) {
        const auto bytes = texture->readImage({0, layer, 0});
        ASSERT_TRUE(bytes.has_value());
        for (int y = 0; y < bake->height(); ++y)
            for (int x = 0; x < bake->width(); ++x) {
                std::uint64_t packed = 0;
                std::memcpy(&packed, bytes->data() + 8 * (static_cast<std::size_t>(y) * bake->width() + x), 8);
                const glm::vec4 found = glm::unpackHalf4x16(packed);
                const bool isCovered = rows->covered.at(x, y) != 0;
                EXPECT_EQ(found.a, layer == 0 && isCovered ? 1 : 0);
                for (int channel = 0; channel < 3; ++channel) {
                    const double expected = isCovered ? scale * rows->sh.at(x, y)[std::size_t(layer)][channel] : 0;
                    ASSERT_NEAR(found[channel], expected, std::abs(expected) / 1024 + 1e-7) << layer << " at " << x << ", " << y;
                }
            }
    }
}

/// The other coefficients are 0 and would be most of the page's bytes.
TEST_F(CookedSite, ABakeHasNoLayersOfZeros) {
    struct Case {
        int coefficients, layers;
    };
    for (const auto [coefficients, layers] : {Case{1, 1}, Case{4, 4}}) {
        const SmallScene scene(SmallScene::Parts::LightMap);
        const auto map = formats::LightMapReader::open(scene / "map.exr", {});
        ASSERT_TRUE(map.has_value());
        auto rows = map->read(0, map->height());
        ASSERT_TRUE(rows.has_value());
        for (lighting::ShRgb& sh : rows->sh.texels()) std::fill(sh.begin() + coefficients, sh.end(), glm::vec3(0));
        auto writer = formats::LightMapWriter::create(scene / "map.exr", SmallScene::kWidth, SmallScene::kHeight);
        ASSERT_TRUE(writer && writer->append(rows->sh.view()) && writer->commit());
        scene.writeSceneFile("light_map_layout = \"raw\"");
        ASSERT_TRUE(cookScene(scene.options(), state_).errors.empty());
        const auto site = Site::open({scene / "out", {}, kPage}, state_);
        ASSERT_TRUE(site.has_value()) << site.error().line();
        EXPECT_EQ(sceneDataOf(*site).at("light_maps").at(0).at("reference_layers"), layers);
        const auto texture = formats::TextureReader::open(std::get<fs::path>(site->files().at("viewer/map.reference.ktx2").content));
        ASSERT_TRUE(texture.has_value()) << texture.error().line();
        EXPECT_EQ(texture->shape().layerCount, layers);
        EXPECT_TRUE(texture->shape().isArray) << "also of one layer: the page samples an array";
    }
}

TEST_F(CookedSite, LightBeyondHalfFloatsIsScaled) {
    SmallScene bright(SmallScene::Parts::LightMap,
                      [](const glm::dvec3& direction, const glm::dvec2& place) { return 1e6f * sunAndSky(direction, place); });
    bright.writeSceneFile("target = \"float\"\nlight_map_layout = \"raw\"");
    ASSERT_TRUE(cookScene(bright.options(), state_).errors.empty());
    const auto site = Site::open({bright / "out", {}, kPage}, state_);
    ASSERT_TRUE(site.has_value()) << site.error().line();
    const double scale = sceneDataOf(*site).at("light_maps").at(0).at("reference_scale");
    EXPECT_LT(scale, 1);
    EXPECT_EQ(std::exp2(std::round(std::log2(scale))), scale) << "a power of two";
}

TEST_F(CookedSite, ShowsASceneWhoseBakeIsGoneAndSaysSo) {
    fs::remove(scene_ / "map.exr");
    const auto site = open();
    ASSERT_TRUE(site.has_value()) << site.error().line();
    ASSERT_EQ(site->notes().size(), 1u);
    EXPECT_THAT(site->notes()[0], HasSubstr("map.exr"));
    EXPECT_THAT(site->files(), Not(Contains(Key("viewer/map.reference.ktx2"))));
    const Json map = sceneDataOf(*site).at("light_maps").at(0);
    EXPECT_FALSE(map.contains("reference"));
    EXPECT_THAT(map.at("reference_missing").get<std::string>(), HasSubstr("map.exr"));
}

TEST_F(CookedSite, RefusesWhatIsNoCookedFolder) {
    const auto none = Site::open({scene_ / "nowhere", {}, kPage}, state_);
    ASSERT_FALSE(none.has_value());
    EXPECT_THAT(none.error().line(), HasSubstr("nowhere"));
    const auto withoutPage = Site::open({folder(), {}, {}}, state_);
    ASSERT_FALSE(withoutPage.has_value());
    EXPECT_EQ(withoutPage.error().code, ErrorCode::InvalidRequest);
    EXPECT_THAT(withoutPage.error().line(), HasSubstr("LIGHTCOOK_VIEWER"));
}

TEST_F(CookedSite, RefusesDdsTextures) {
    CookOptions options = scene_.options();
    options.given.set("output.container", "dds");
    ASSERT_TRUE(cookScene(options, state_).errors.empty());
    const auto site = open();
    ASSERT_FALSE(site.has_value());
    EXPECT_EQ(site.error().code, ErrorCode::FormatUnsupported);
    EXPECT_THAT(site.error().line(),
                HasSubstr(".dds: found a DDS texture, which the page does not read, expected KTX2: cook with container = \"ktx2\""));
}

TEST_F(CookedSite, RefusesAChangedFileAndALinkOutOfTheFolder) {
    const fs::path shader = folder() / "lightcook.glsl";
    fs::rename(shader, scene_ / "outside.glsl");
    fs::create_symlink(scene_ / "outside.glsl", shader);
    const auto linked = open();
    ASSERT_FALSE(linked.has_value());
    EXPECT_EQ(linked.error().code, ErrorCode::FileUnreadable);
    EXPECT_THAT(linked.error().line(), HasSubstr("symbolic link out of the folder"));
    fs::remove(shader);
    formats::writeContent(shader, "// changed\n");
    const auto changed = open();
    ASSERT_FALSE(changed.has_value());
    EXPECT_EQ(changed.error().code, ErrorCode::Verification);
    EXPECT_THAT(changed.error().line(), HasSubstr("lightcook.glsl"));
}

std::set<std::string> namesIn(const fs::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (!entry.is_directory()) names.insert(entry.path().lexically_relative(folder).string());
    return names;
}
std::set<std::string> namesOf(const Site& site) {
    std::set<std::string> names;
    for (const auto& [path, file] : site.files()) names.insert(path);
    return names;
}

TEST_F(CookedSite, AnExportOverAnotherKeepsForeignFilesAndDropsItsOwn) {
    static constexpr BundledFile kOldPage[] = {
        {"index.html", "old"}, {"assets/old.js", "old"}, {"old/deep/x.css", "old"}, {"old/shared.css", "old"}};
    const fs::path page = scene_ / "page";
    {
        const auto old = Site::open({folder(), {}, kOldPage}, state_);
        ASSERT_TRUE(old.has_value()) << old.error().line();
        ASSERT_TRUE(exportSite(*old, page, state_).has_value());
    }
    for (const char* name : {"CNAME", "docs/notes.txt", "assets/mine.css", "old/mine.txt"}) {
        fs::create_directories((page / name).parent_path());
        formats::writeContent(page / name, "mine");
    }
    formats::writeContent(scene_ / "outside.txt", "mine");
    fs::create_symlink("../outside.txt", page / "link.txt");
    const auto site = open();
    ASSERT_TRUE(site.has_value()) << site.error().line();
    const auto done = exportSite(*site, page, state_);
    ASSERT_TRUE(done.has_value()) << done.error().line();
    auto expected = namesOf(*site);
    expected.insert({"CNAME", "docs/notes.txt", "assets/mine.css", "old/mine.txt", "link.txt"});
    EXPECT_EQ(namesIn(page), expected);
    EXPECT_FALSE(fs::exists(page / "old/deep")) << "a folder that is empty now";
    EXPECT_EQ(formats::contentOf(page / "index.html"), kPage[0].bytes);
    EXPECT_EQ(formats::contentOf(page / "docs/notes.txt"), "mine");
}

TEST_F(CookedSite, AnExportReplacesNothingOfTheUsers) {
    const auto site = open();
    ASSERT_TRUE(site.has_value()) << site.error().line();
    const fs::path page = scene_ / "page";
    ASSERT_TRUE(exportSite(*site, page, state_).has_value());
    formats::writeContent(scene_ / "outside.txt", "mine");
    // A link with the name of an exported file is replaced, and not followed.
    fs::remove(page / "index.html");
    fs::create_symlink("../outside.txt", page / "index.html");
    ASSERT_TRUE(exportSite(*site, page, state_).has_value());
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(page / "index.html")));
    EXPECT_EQ(formats::contentOf(scene_ / "outside.txt"), "mine");

    const auto refusal = [&](const fs::path& name) {
        const auto refused = exportSite(*site, page, state_);
        EXPECT_FALSE(refused.has_value());
        if (refused.has_value()) return;
        EXPECT_EQ(refused.error().code, ErrorCode::InvalidRequest);
        EXPECT_EQ(refused.error().subject, (page / name).string());
        EXPECT_EQ(formats::contentOf(page / "index.html"), "changed") << "nothing was written";
    };
    formats::writeContent(page / "index.html", "changed");
    // A file that has the name of a new one, a folder in place of a file, a link in place of a folder.
    const std::string list = formats::contentOf(page / "viewer/files.json");
    formats::writeContent(page / "viewer/files.json", R"(["index.html", "viewer/files.json", "viewer/scene.json"])");
    refusal("assets/page.js");
    formats::writeContent(page / "viewer/files.json", list);
    fs::remove(page / "assets/page.js");
    fs::create_directory(page / "assets/page.js");
    refusal("assets/page.js");
    fs::remove_all(page / "assets");
    fs::create_directory(scene_ / "elsewhere");
    fs::create_directory_symlink("../elsewhere", page / "assets");
    refusal("assets");
    EXPECT_TRUE(fs::is_empty(scene_ / "elsewhere"));
    // A list that names files outside is none.
    fs::remove(page / "assets");
    formats::writeContent(page / "viewer/files.json", R"(["../outside.txt", "index.html"])");
    ASSERT_TRUE(exportSite(*site, page, state_).has_value());
    EXPECT_EQ(formats::contentOf(scene_ / "outside.txt"), "mine");
}

TEST_F(CookedSite, IsExportedWholeAndReplacesAnEarlierExport) {
    const auto site = open();
    ASSERT_TRUE(site.has_value()) << site.error().line();
    const fs::path page = scene_ / "page";
    ASSERT_TRUE(exportSite(*site, page, state_).has_value());
    for (const auto& [path, file] : site->files()) EXPECT_TRUE(fs::is_regular_file(page / path)) << path;
    EXPECT_EQ(formats::contentOf(page / "index.html"), kPage[0].bytes);
    EXPECT_EQ(formats::contentOf(page / "cooked/cooked.json"), formats::contentOf(folder() / "cooked.json"));
    EXPECT_EQ(namesIn(page), namesOf(*site));
    ASSERT_TRUE(exportSite(*site, page, state_).has_value());
    EXPECT_EQ(namesIn(page), namesOf(*site));
    // An empty folder and one with a slash at its end are no other places.
    fs::create_directory(scene_ / "empty");
    ASSERT_TRUE(exportSite(*site, (scene_ / "empty").string() + "/", state_).has_value());
    EXPECT_EQ(namesIn(scene_ / "empty"), namesOf(*site));

    fs::create_directory(scene_ / "mine");
    formats::writeContent(scene_ / "mine/notes.txt", "not an export");
    const auto refused = exportSite(*site, scene_ / "mine", state_);
    ASSERT_FALSE(refused.has_value());
    EXPECT_EQ(refused.error().code, ErrorCode::InvalidRequest);
    EXPECT_EQ(formats::contentOf(scene_ / "mine/notes.txt"), "not an export");
    EXPECT_FALSE(exportSite(*site, scene_ / "mine/notes.txt", state_).has_value());
}

}  // namespace
}  // namespace lightcook::pipeline
