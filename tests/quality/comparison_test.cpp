// Comparisons with peers: a tiny peer made here is loaded, measured and drawn; peers with a fault are refused by name.
#include "bench/comparison.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

namespace lightcook::bench {
namespace {

namespace fs = std::filesystem;
using formats::PixelFormat;

/// The folder of one of the peers that tests/quality/CMakeLists.txt builds: "sound", or one with the fault of its name.
fs::path peerFolder(const std::string& kind) {
    return fs::path(LIGHTCOOK_TINY_PEERS) / kind;
}

std::string errorOf(const fs::path& folder) {
    const auto peers = loadPeerEncoders(folder);
    return peers ? "no error" : peers.error().line();
}

std::vector<PeerEncoder> soundPeers() {
    auto peers = loadPeerEncoders(peerFolder("sound"));
    if (!peers) throw std::runtime_error(peers.error().line());
    return std::move(*peers);
}

/// Blocks of one colour each, with values that every format holds: 0 and 1.
ClassPicture uniformBlocks(PictureClass pictureClass) {
    ClassPicture picture{"uniform_blocks", pictureClass, formats::Image<glm::vec4>(kPictureTile, kPictureTile),
                         formats::Image<float>(kPictureTile, kPictureTile, 1.0f)};
    for (int y = 0; y < kPictureTile; ++y)
        for (int x = 0; x < kPictureTile; ++x) picture.texels.at(x, y) = glm::vec4(x / 4 % 2, y / 4 % 2, x / 8 % 2, 1);
    return picture;
}

ComparisonOptions quick() {
    ComparisonOptions options;
    options.efforts = {0, 5};
    options.rounds = 2;
    options.secondsRound = 0;
    return options;
}

std::vector<Comparison> compare(PixelFormat format, const std::vector<ClassPicture>& pictures) {
    const std::vector<PeerEncoder> peers = soundPeers();
    auto comparisons = compareEncoders(format, peers, pictures, quick());
    if (!comparisons) throw std::runtime_error(comparisons.error().line());
    return std::move(*comparisons);
}

TEST(Comparison, APeerGetsTheTexelsOfItsTypeAndItsBlocksAreDecoded) {
    std::vector<ClassPicture> pictures;
    pictures.push_back(uniformBlocks(PictureClass::Photographs));
    pictures.push_back(uniformBlocks(PictureClass::LightMaps));
    for (const PixelFormat format : {PixelFormat::Bc1, PixelFormat::Bc4, PixelFormat::Bc6hUf16}) {
        const std::vector<Comparison> comparisons = compare(format, pictures);
        ASSERT_EQ(comparisons.size(), 1u);
        const std::vector<ComparisonEntry>& entries = comparisons[0].entries;
        ASSERT_EQ(entries.size(), 4u);
        EXPECT_EQ(entries[0].encoder, "lightcook");
        EXPECT_EQ(entries[1].profile, "5");
        EXPECT_EQ(entries[2].encoder, "tiny <peer>");
        EXPECT_EQ(entries[2].profile, "first texel");
        EXPECT_EQ(entries[3].profile, "again");
        for (const ComparisonEntry& entry : entries) {
            EXPECT_GT(entry.mpixPerCpuSecond, 0);
            // The peer's ten bits of BC6H are 31 halfs apart: up to 3 % of 1.
            EXPECT_GE(entry.db, format == PixelFormat::Bc6hUf16 && !entry.isOurs ? 30 : 120) << entry.encoder;
        }
    }
}

TEST(Comparison, OnlyTheFirstTexelOfABlockIsNotEnoughForARealPicture) {
    const std::vector<ClassPicture> pictures = ownClassPictures(LIGHTCOOK_SOURCE_DIR, kPictureTile);
    const std::vector<Comparison> comparisons = compare(PixelFormat::Bc4, pictures);
    ASSERT_EQ(comparisons.size(), 4u);  // photographs, SH ratios, normals, directions
    for (const Comparison& each : comparisons) {
        EXPECT_GT(each.entries[0].db, each.entries[2].db + 3) << info(each.pictureClass).name;
        EXPECT_TRUE(each.entries[0].isOnFront || each.entries[1].isOnFront);
    }
}

TEST(Comparison, FormatsThatNoPeerEncodesAreLeftOut) {
    EXPECT_TRUE(compare(PixelFormat::Bc7, ownClassPictures(LIGHTCOOK_SOURCE_DIR, kPictureTile)).empty());
}

TEST(Comparison, TheFrontHoldsWhatNothingElseBeats) {
    std::vector<ComparisonEntry> entries(5);
    const std::pair<double, double> speedAndDb[] = {{100, 30}, {50, 40}, {50, 39}, {40, 40}, {1, 41}};
    for (std::size_t i = 0; i < entries.size(); ++i)
        entries[i].mpixPerCpuSecond = speedAndDb[i].first, entries[i].db = speedAndDb[i].second;
    markFront(entries);
    const bool expected[] = {true, true, false, false, true};
    for (std::size_t i = 0; i < entries.size(); ++i) EXPECT_EQ(entries[i].isOnFront, expected[i]) << i;
}

TEST(Comparison, PageAndJsonShowEveryEntry) {
    std::vector<ClassPicture> pictures;
    pictures.push_back(uniformBlocks(PictureClass::Photographs));
    const std::vector<Comparison> comparisons = compare(PixelFormat::Bc4, pictures);
    const std::string page = comparisonPage(comparisons, pictures);
    for (const char* part : {"<h2>bc4, photographs</h2>", "effort 5: ", "tiny &lt;peer>, profile again: ", "class=\"front c2\"",
                             "Pictures, photographs: uniform_blocks.", "<svg viewBox"})
        EXPECT_NE(page.find(part), std::string::npos) << part;
    for (const char* outside : {"<script", "src=", "href=", "http:", "https:", "url("})
        EXPECT_EQ(page.find(outside), std::string::npos) << "the page is one file, but holds " << outside;

    const nlohmann::json json = nlohmann::json::parse(comparisonJson(comparisons));
    ASSERT_EQ(json.size(), 1u);
    EXPECT_EQ(json[0]["format"], "bc4");
    EXPECT_EQ(json[0]["class"], "photographs");
    ASSERT_EQ(json[0]["encoders"].size(), 4u);
    EXPECT_EQ(json[0]["encoders"][2]["encoder"], "tiny <peer>");
    EXPECT_EQ(json[0]["encoders"][2]["pictures"][0]["name"], "uniform_blocks");
    EXPECT_EQ(json[0]["encoders"][2]["psnr_db"], comparisons[0].entries[2].db);
}

TEST(PeerEncoders, APeerWithAFaultIsRefusedInOneLine) {
    EXPECT_NE(errorOf(peerFolder("old")).find("old/tiny_peer.so: found interface 2, expected 1"), std::string::npos)
        << errorOf(peerFolder("old"));
    EXPECT_NE(errorOf(peerFolder("without_encode")).find("found no function lightcook_peer_encode;"), std::string::npos)
        << errorOf(peerFolder("without_encode"));
    EXPECT_NE(errorOf(peerFolder("nowhere")).find("--peers takes a folder"), std::string::npos) << errorOf(peerFolder("nowhere"));

    const fs::path folder = fs::path(testing::TempDir()) / "lightcook_no_peers";
    fs::remove_all(folder);
    fs::create_directory(folder);
    EXPECT_NE(errorOf(folder).find("found no *.so"), std::string::npos) << errorOf(folder);
    std::ofstream(folder / "text.so") << "no shared object\n";
    EXPECT_NE(errorOf(folder).find("text.so: the shared object does not load"), std::string::npos) << errorOf(folder);
    fs::remove_all(folder);
}

TEST(PeerEncoders, FailuresWhileEncodingAreErrors) {
    std::vector<ClassPicture> pictures;
    pictures.push_back(uniformBlocks(PictureClass::Photographs));
    const auto failing = loadPeerEncoders(peerFolder("fails"));
    ASSERT_TRUE(failing.has_value());
    const auto failed = compareEncoders(PixelFormat::Bc4, *failing, pictures, quick());
    ASSERT_FALSE(failed.has_value());
    EXPECT_NE(failed.error().line().find("lightcook_peer_encode returned 42 for bc4, profile 1, 48 x 48 texels"), std::string::npos)
        << failed.error().line();

    const auto untyped = loadPeerEncoders(peerFolder("type"));
    ASSERT_TRUE(untyped.has_value());
    const auto refused = compareEncoders(PixelFormat::Bc4, *untyped, pictures, quick());
    ASSERT_FALSE(refused.has_value());
    EXPECT_NE(refused.error().line().find("found texel type 77 for bc4"), std::string::npos) << refused.error().line();
}

TEST(ClassPictures, EveryClassHasAPictureWithinItsRange) {
    std::set<PictureClass> found;
    for (const ClassPicture& picture : ownClassPictures(LIGHTCOOK_SOURCE_DIR, 2 * kPictureTile)) {
        found.insert(picture.pictureClass);
        EXPECT_EQ(picture.texels.width(), 2 * kPictureTile) << picture.name;
        EXPECT_EQ(picture.texels.height(), 2 * kPictureTile) << picture.name;
        const PictureContent content = info(picture.pictureClass).content;
        for (const glm::vec4& texel : picture.texels.texels())
            for (int c = 0; c < 3; ++c) {
                ASSERT_GE(texel[c], content == PictureContent::Vectors ? -1.0f : 0.0f) << picture.name;
                ASSERT_LE(texel[c], content == PictureContent::Light ? 65504.0f : 1.0f) << picture.name;
            }
    }
    EXPECT_EQ(found.size(), allPictureClasses().size());
}

}  // namespace
}  // namespace lightcook::bench
