// The ranges of a patch, by what they are for: written over the old files they make the new ones.
#include "pipeline/manifest/folder_difference.h"

#include <gmock/gmock.h>

#include <random>

#include "pipeline/cook/cook.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::contentOf;
using formats::writeContent;

FolderDifference compared(const FolderWithManifest& old, const FolderWithManifest& updated) {
    const RunState state;
    auto difference = differenceOf(old, updated, state);
    EXPECT_TRUE(difference) << difference.error().line();
    return difference.value_or(FolderDifference{});
}

/// Folders whose manifest names shader.glsl and some meshes, with a digest that is no other's.
class Folders : public testing::Test {
protected:
    FolderWithManifest write(const std::string& name, const std::map<std::string, std::string>& files) {
        FolderWithManifest cooked{folder_ / name, {}};
        fs::create_directories(cooked.folder);
        cooked.manifest.shader = {"shader.glsl", "same"};
        writeContent(cooked.folder / kManifestName, "{}");
        writeContent(cooked.folder / "shader.glsl", "void main() {}");
        for (const auto& [file, content] : files) {
            CookedAsset asset;
            asset.name = asset.file.emplace(file);
            asset.digest = std::to_string(++digests_);
            cooked.manifest.assets.push_back(asset);
            writeContent(cooked.folder / file, content);
        }
        return cooked;
    }
    /// Writes the ranges over the old file.
    static std::string patched(const FolderWithManifest& old, const FolderWithManifest& updated, const FileDifference& file) {
        std::string content = file.change == FileChange::Added ? "" : contentOf(old.folder / file.file);
        const std::string target = contentOf(updated.folder / file.file);
        content.resize(file.bytesNew);
        for (const ByteRange& range : file.ranges) content.replace(range.offset, range.length, target.substr(range.offset, range.length));
        return content;
    }

    formats::TemporaryFolder folder_;
    int digests_ = 0;
};

TEST_F(Folders, RangesAreThoseThatDiffer) {
    std::string bytes(200'000, 'a'), changed = bytes + "12345";
    changed[0] = changed[10] = 'b';  // less than a gap apart: one range
    changed[100] = 'b';              // another one
    changed[(1 << 16) - 1] = 'b';    // the last byte of a chunk, and the first of the next
    changed[1 << 16] = 'b';
    const FolderDifference difference = compared(write("old", {{"m.glb", bytes}}), write("new", {{"m.glb", changed}}));
    ASSERT_EQ(difference.files.size(), 1u);
    const FileDifference& file = difference.files[0];
    std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
    for (const ByteRange& range : file.ranges) ranges.emplace_back(range.offset, range.length);
    EXPECT_THAT(ranges,
                testing::ElementsAre(std::pair(0u, 11u), std::pair(100u, 1u), std::pair((1u << 16) - 1, 2u), std::pair(200'000u, 5u)));
    EXPECT_EQ(file.bytesChanged, 19u);
    EXPECT_EQ(difference.bytesChanged, 19u);
    EXPECT_EQ(difference.filesSame, 2u) << "manifest and shader";
}

TEST_F(Folders, RandomPatchesMakeTheNewFile) {
    std::mt19937 random(11);
    const auto below = [&](std::size_t end) { return static_cast<std::size_t>(random()) % end; };
    for (int i = 0; i < 40; ++i) {
        std::string old(1 + below(150'000), '\0');
        for (char& each : old) each = static_cast<char>(below(256));
        std::string updated = old;
        for (std::size_t edits = below(30); edits > 0; --edits) updated[below(updated.size())] ^= static_cast<char>(1 + below(255));
        updated.resize(1 + below(150'000), 'x');
        const FolderWithManifest before = write("old", {{"m.glb", old}}), after = write("new", {{"m.glb", updated}});
        const FolderDifference difference = compared(before, after);
        if (old == updated) continue;
        ASSERT_EQ(difference.files.size(), 1u);
        EXPECT_EQ(patched(before, after, difference.files[0]), updated);
        std::uint64_t end = 0;
        for (const ByteRange& range : difference.files[0].ranges) {
            EXPECT_TRUE(end == 0 || range.offset >= end + kLeastGap);
            end = range.offset + range.length;
            EXPECT_LE(end, updated.size());
        }
    }
}

TEST_F(Folders, AFileThatIsOnlyCutIsChangedWithoutRanges) {
    const FolderDifference difference = compared(write("old", {{"m.glb", "abcdef"}}), write("new", {{"m.glb", "abc"}}));
    ASSERT_EQ(difference.files.size(), 1u);
    EXPECT_EQ(difference.files[0].change, FileChange::Changed);
    EXPECT_TRUE(difference.files[0].ranges.empty());
    EXPECT_EQ(difference.files[0].bytesNew, 3u);
}

TEST_F(Folders, FilesThatComeAndGoAreNamed) {
    const FolderDifference difference = compared(write("old", {{"gone.glb", "12"}}), write("new", {{"come.glb", "123"}}));
    ASSERT_EQ(difference.files.size(), 2u);
    EXPECT_EQ(difference.files[0].file, "come.glb");
    EXPECT_EQ(difference.files[0].change, FileChange::Added);
    EXPECT_EQ(difference.files[1].change, FileChange::Removed);
    EXPECT_EQ(difference.filesAdded, 1u);
    EXPECT_EQ(difference.filesRemoved, 1u);
    EXPECT_EQ(difference.bytesChanged, 3u) << "of a removed file nothing is sent";
}

TEST_F(Folders, AFileThatIsMissingIsAnError) {
    const FolderWithManifest old = write("old", {{"m.glb", "abc"}}), updated = write("new", {{"m.glb", "abd"}});
    fs::remove(old.folder / "m.glb");
    const RunState state;
    const auto difference = differenceOf(old, updated, state);
    ASSERT_FALSE(difference);
    EXPECT_EQ(difference.error().code, formats::ErrorCode::FileUnreadable);
}

TEST_F(Folders, APatchOfACookMakesTheNextOne) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    CookOptions options = scene.options();
    std::vector<FolderWithManifest> cooked;
    for (const char* effort : {"0", "5"}) {
        options.output = scene / effort;
        options.given.set("output.effort", effort, "--effort");
        ASSERT_TRUE(cook(options).errors.empty());
        auto manifest = loadManifest(options.output);
        ASSERT_TRUE(manifest);
        cooked.push_back({options.output, std::move(*manifest)});
    }
    const FolderDifference difference = compared(cooked[0], cooked[1]);
    EXPECT_GT(difference.filesChanged, 1u);
    for (const FileDifference& file : difference.files)
        EXPECT_EQ(patched(cooked[0], cooked[1], file), contentOf(cooked[1].folder / file.file)) << file.file;
    EXPECT_TRUE(compared(cooked[1], cooked[1]).files.empty());
}

}  // namespace
}  // namespace lightcook::pipeline
