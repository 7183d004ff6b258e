#include "pipeline/graph/cache.h"

#include <gtest/gtest.h>

#include <fstream>

#include "formats/temporaries.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/part_cache.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

ActionRecord storeOneFile(const Cache& cache, const std::filesystem::path& folder, const std::string& key, const std::string& content) {
    EXPECT_TRUE(writeFile(folder / "file", content).has_value());
    ActionRecord record;
    record.id = "cook/a";
    record.result = {{"answer", 42}, {"fraction", 0.1f}};
    record.seconds = 1.5;
    record.files = {{"file", *digestOfFile(folder / "file"), content.size()}};
    EXPECT_TRUE(cache.store(key, record, folder).has_value());
    return record;
}

TEST(Cache, GivesBackWhatItWasGiven) {
    const formats::TemporaryFolder folder;
    const Cache cache(folder / "cache", 1 << 20);
    const ActionRecord stored = storeOneFile(cache, folder.path(), "key", "content");
    const auto found = cache.find("key");
    ASSERT_TRUE(found.has_value());
    EXPECT_EQ(found->id, stored.id);
    EXPECT_EQ(found->result, stored.result);
    EXPECT_EQ(found->seconds, stored.seconds);
    ASSERT_EQ(found->files.size(), 1u);
    EXPECT_EQ(found->files[0].name, stored.files[0].name);
    EXPECT_EQ(found->files[0].digest, stored.files[0].digest);
    EXPECT_EQ(found->files[0].bytes, stored.files[0].bytes);
    ASSERT_TRUE(cache.restore(stored.files[0].digest, folder / "back"));
    EXPECT_EQ(*readFile(folder / "back"), "content");
    EXPECT_FALSE(cache.find("other key").has_value());
}

TEST(Cache, ADamagedRecordOrContentIsAMiss) {
    const formats::TemporaryFolder folder;
    const Cache cache(folder / "cache", 1 << 20);
    const ActionRecord stored = storeOneFile(cache, folder.path(), "key", "content");
    formats::writeContent(folder / "cache" / "cas" / stored.files[0].digest, "CONTENT");
    EXPECT_FALSE(cache.restore(stored.files[0].digest, folder / "back"));
    EXPECT_FALSE(std::filesystem::exists(folder / "back"));
    formats::writeContent(folder / "cache" / "ac" / "key", "{\"id\": 3}");
    EXPECT_FALSE(cache.find("key").has_value());
    formats::writeContent(folder / "cache" / "ac" / "key", "not json");
    EXPECT_FALSE(cache.find("key").has_value());
}

TEST(Cache, ADamagedContentIsReplacedWhenItIsStoredAgain) {
    const formats::TemporaryFolder folder;
    const Cache cache(folder / "cache", 1 << 20);
    const std::string digest = storeOneFile(cache, folder.path(), "key", "content").files[0].digest;
    for (const char* damaged : {"", "CONTENT"}) {
        formats::writeContent(folder / "cache" / "cas" / digest, damaged);
        storeOneFile(cache, folder.path(), "key", "content");
        EXPECT_TRUE(cache.restore(digest, folder / "back"));
    }
}

TEST(Cache, ARecordWhoseFiguresChangedOnDiskIsAMiss) {
    const formats::TemporaryFolder folder;
    const Cache cache(folder / "cache", 1 << 20);
    storeOneFile(cache, folder.path(), "key", "content");
    ASSERT_TRUE(cache.find("key").has_value());
    const std::filesystem::path place = folder / "cache" / "ac" / "key";
    std::string text = formats::contentOf(place);
    const std::size_t figure = text.find("42");
    ASSERT_NE(figure, std::string::npos);
    formats::writeContent(place, text.replace(figure, 2, "24"));
    EXPECT_FALSE(cache.find("key").has_value());
}

TEST(Cache, TheRecordOfAnotherKeyIsAMiss) {
    const formats::TemporaryFolder folder;
    const Cache cache(folder / "cache", 1 << 20);
    storeOneFile(cache, folder.path(), "key", "content");
    storeOneFile(cache, folder.path(), "other", "content");
    std::filesystem::copy_file(folder / "cache/ac/other", folder / "cache/ac/key", std::filesystem::copy_options::overwrite_existing);
    EXPECT_FALSE(cache.find("key").has_value());
    EXPECT_TRUE(cache.find("other").has_value());
    RunRecord run;
    for (const char* at : {"2024-01-01T00:00:00.000Z", "2024-01-02T00:00:00.000Z"}) {
        run.at = at;
        cache.storeRun(run);
        ASSERT_TRUE(cache.findRun(at).has_value());
    }
    std::filesystem::rename(folder / "cache/runs/2024-01-02T00:00:00.000Z", folder / "cache/runs/2024-01-01T00:00:00.000Z");
    EXPECT_FALSE(cache.findRun("2024-01-01T00:00:00.000Z").has_value());
}

TEST(Cache, ADamagedPartAndThatOfAnotherKeyAreMisses) {
    const formats::TemporaryFolder folder;
    const PartCache parts(folder.path(), false);
    const auto onlyFile = [&] { return std::filesystem::directory_iterator(folder / PartCache::kFolder)->path(); };
    EXPECT_FALSE(parts.find("key"));
    parts.store("key", "content\nof two lines");
    EXPECT_EQ(parts.find("key"), "content\nof two lines");
    EXPECT_FALSE(PartCache(folder.path(), true).find("key")) << "nothing is found by force";
    const std::string text = formats::contentOf(onlyFile());
    for (const std::string& damaged : {std::string(), text.substr(0, text.size() - 1), "0" + text.substr(1), text + "x"}) {
        formats::writeContent(onlyFile(), damaged);
        EXPECT_FALSE(parts.find("key"));
    }
    parts.store("key", "content");
    const std::filesystem::path stored = onlyFile();
    parts.store("other", "other");
    for (const auto& entry : std::filesystem::directory_iterator(folder / PartCache::kFolder))
        if (entry.path() != stored) std::filesystem::copy_file(entry.path(), stored, std::filesystem::copy_options::overwrite_existing);
    EXPECT_FALSE(parts.find("key"));
    EXPECT_EQ(parts.find("other"), "other");

    parts.store("key", std::string(1000, 'x'));
    EXPECT_TRUE(parts.find("key"));
    Cache(folder.path(), 100).prune();
    EXPECT_FALSE(parts.find("key")) << "parts count";
}

TEST(Cache, PruningForgetsTheLeastRecentlyUsedFirst) {
    const formats::TemporaryFolder folder;
    const Cache cache(folder / "cache", 250);
    std::vector<std::string> digests;
    for (const char c : {'a', 'b', 'c'}) {
        digests.push_back(storeOneFile(cache, folder.path(), std::string(1, c), std::string(100, c)).files[0].digest);
        std::filesystem::last_write_time(
            folder / "cache" / "cas" / digests.back(),
            std::filesystem::file_time_type::clock::now() - std::chrono::hours(10 - static_cast<int>(digests.size())));
    }
    EXPECT_TRUE(cache.restore(digests[0], folder / "used again"));
    cache.prune();
    EXPECT_TRUE(cache.restore(digests[0], folder / "x"));
    EXPECT_FALSE(cache.restore(digests[1], folder / "x")) << "the oldest use";
    EXPECT_TRUE(cache.restore(digests[2], folder / "x"));
}

TEST(Cache, PruningLeavesTheContentThatAnotherProcessWrites) {
    const formats::TemporaryFolder folder;
    const Cache cache(folder / "cache", 50);
    const std::string digest = storeOneFile(cache, folder.path(), "key", std::string(100, 'a')).files[0].digest;
    const auto incomplete = folder / "cache" / "cas" / (std::string(formats::kTemporaryPrefix) + "1-0");
    formats::writeContent(incomplete, std::string(100, 'b'));
    cache.prune();
    EXPECT_TRUE(std::filesystem::exists(incomplete));
    EXPECT_FALSE(cache.restore(digest, folder / "x"));
}

TEST(DigestMemo, RemembersUntilTheFileChanges) {
    const formats::TemporaryFolder folder;
    const auto file = folder / "file";
    formats::writeContent(file, "one");
    {
        DigestMemo memo(folder / "memo");
        EXPECT_EQ(memo.of(file), digestOfText("one"));
        memo.save();
    }
    DigestMemo memo(folder / "memo");
    EXPECT_EQ(memo.of(file), digestOfText("one"));
    formats::writeContent(file, "two");  // same size
    EXPECT_EQ(memo.of(file), digestOfText("two"));
    std::filesystem::remove(file);
    const auto gone = memo.of(file);
    ASSERT_FALSE(gone.has_value());
    EXPECT_EQ(gone.error().code, formats::ErrorCode::FileUnreadable);
}

TEST(DigestMemo, AnInputKeepsTheContentOfItsFirstUse) {
    const formats::TemporaryFolder folder;
    const auto file = folder / "file";
    formats::writeContent(file, "one");
    DigestMemo memo(folder / "memo");
    EXPECT_EQ(memo.ofInput(file), digestOfText("one"));
    EXPECT_EQ(memo.ofInput(file), digestOfText("one"));
    formats::writeContent(file, "two");
    EXPECT_FALSE(memo.ofInput(file).has_value());
    EXPECT_EQ(memo.of(file), digestOfText("two"));
    EXPECT_EQ(memo.ofInputAsRead(file), digestOfText("one"));
    formats::writeContent(file, "one");
    EXPECT_EQ(memo.ofInput(file), digestOfText("one"));
    EXPECT_EQ(memo.ofInputAsRead(folder / "none"), "");
}

TEST(Digest, AMegabyteOfFileAndOfTextAgree) {
    const formats::TemporaryFolder folder;
    const std::string content(3'000'001, 'x');
    formats::writeContent(folder / "file", content);
    EXPECT_EQ(digestOfFile(folder / "file"), digestOfText(content));
    EXPECT_EQ(digestOfText("").size(), 32u);
}

TEST(PrepareFileIfChanged, LeavesTheTimesOfAnUnchangedFile) {
    const formats::TemporaryFolder folder;
    const auto write = [](const std::filesystem::path& file, std::string_view content) {
        auto pending = prepareFileIfChanged(file, content);
        return pending.has_value() && (!*pending || (*pending)->commit().has_value());
    };
    const auto file = folder / "deep" / "file";
    ASSERT_TRUE(write(file, "one"));
    const auto old = std::filesystem::file_time_type::clock::now() - std::chrono::hours(1);
    std::filesystem::last_write_time(file, old);
    ASSERT_TRUE(write(file, "one"));
    EXPECT_EQ(std::filesystem::last_write_time(file), old);
    ASSERT_TRUE(write(file, "two"));
    EXPECT_NE(std::filesystem::last_write_time(file), old);
    EXPECT_EQ(*readFile(file), "two");
}

}  // namespace
}  // namespace lightcook::pipeline
