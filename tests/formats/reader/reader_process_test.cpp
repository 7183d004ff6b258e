// Files that child processes read: the same texels as in this process, and an error of the file whatever happens behind the wall.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "formats/foreign_files.h"
#include "formats/gltf/draco_sources.h"
#include "formats/image/exr_source.h"
#include "formats/reader/walls.h"
#include "tests/formats/exr_attribute.h"
#include "tests/formats/exr_fixture.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using namespace std::chrono_literals;

/// A file that bad_reader takes for an order.
fs::path orderIn(const TemporaryFolder& folder, const std::string& word) {
    writeContent(folder / "a.exr", std::string("\x76\x2f\x31\x01\x02\0\0\0", 8) + word);
    return folder / "a.exr";
}

/// Returns the numbers of the processes that a process has started, and of those that these have.
std::vector<pid_t> descendantsOf(pid_t process) {
    std::vector<pid_t> found;
    for (const auto& task : fs::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
        std::istringstream children(contentOf(task.path() / "children"));
        for (pid_t child = 0; children >> child;) {
            found.push_back(child);
            const auto theirs = descendantsOf(child);
            found.insert(found.end(), theirs.begin(), theirs.end());
        }
    }
    return found;
}

/// Returns true for a process that runs; a zombie does not.
bool runs(pid_t process) {
    std::error_code code;
    if (!fs::exists("/proc/" + std::to_string(process), code)) return false;
    try {
        const std::string status = contentOf("/proc/" + std::to_string(process) + "/stat");
        return status.at(status.rfind(')') + 2) != 'Z';
    } catch (const std::exception&) {
        return false;
    }
}

template <class Condition>
bool becomesTrue(Condition condition) {
    for (const auto end = std::chrono::steady_clock::now() + 10s; std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(5ms))
        if (condition()) return true;
    return false;
}

/// Returns all texels of some rows, channel by channel.
Result<std::vector<float>> rowsOf(const ExrReader& reader, int firstRow, int rowCount) {
    const ExrInfo& info = reader.info();
    const auto channels = std::ssize(info.channels);
    std::vector<float> texels(static_cast<std::size_t>(channels * info.width * rowCount));
    std::vector<ExrPlane> planes;
    for (const std::string& channel : info.channels)
        planes.push_back({channel, texels.data() + planes.size(), channels, channels * info.width});
    LC_CHECK(reader.readRows(firstRow, rowCount, planes));
    return texels;
}

class ReaderProcesses : public testing::Test {
protected:
    void SetUp() override { readInChildProcesses({.program = LIGHTCOOK_READ}); }
    const TemporaryFolder folder_;
};

TEST_F(ReaderProcesses, GiveTheTexelsOfThisProcess) {
    ExrRecipe recipe{.width = 300, .height = 201, .channels = seededShChannels()};
    recipe.chromaticities = std::array{0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
    for (const bool isTiled : {false, true})
        for (const bool isHalf : {false, true}) {
            recipe.isTiled = isTiled;
            recipe.isHalf = isHalf;
            recipe.environment = isHalf ? std::optional(ExrEnvironment::LatLong) : std::nullopt;
            const fs::path file = folder_ / "map.exr";
            writeRecipe(file, recipe);
            const int descriptor = ::open(file.c_str(), O_RDONLY);
            const auto here = openExrHere(descriptor, file);
            const auto there = ExrReader::open(file);
            ASSERT_TRUE(here && there);
            EXPECT_EQ(there->info().channels, (*here)->info().channels);
            EXPECT_EQ(there->info().tileHeight, (*here)->info().tileHeight);
            EXPECT_EQ(there->info().chromaticities, (*here)->info().chromaticities);
            EXPECT_EQ(there->info().environment, (*here)->info().environment);
            // Strips that begin and end inside tiles and chunks, by threads that share the file.
            constexpr int kStrip = 37;
            std::vector<std::thread> threads;
            std::vector<Result<std::vector<float>>> strips(6);
            for (int strip = 0; strip < 6; ++strip)
                threads.emplace_back([&, strip] {
                    strips[static_cast<std::size_t>(strip)] = rowsOf(*there, strip * kStrip, std::min(kStrip, 201 - strip * kStrip));
                });
            for (std::thread& each : threads) each.join();
            for (int strip = 0; strip < 6; ++strip) {
                const auto& read = strips[static_cast<std::size_t>(strip)];
                ASSERT_TRUE(read) << read.error().line();
                std::vector<float> expected(read->size());
                std::vector<ExrPlane> planes;
                for (const std::string& channel : (*here)->info().channels)
                    planes.push_back({channel, expected.data() + planes.size(), 27, 27 * 300});
                ASSERT_TRUE((*here)->readRows(strip * kStrip, std::min(kStrip, 201 - strip * kStrip), planes));
                EXPECT_EQ(*read, expected) << strip;
            }
            ::close(descriptor);
        }
    const auto walls = wallsOfReaders();
    EXPECT_EQ(walls.front(), "process");
    EXPECT_THAT(walls, testing::Contains("limits"));
}

TEST_F(ReaderProcesses, StoredDigestsAreThoseOfTheChunksThatRowsLieIn) {
    constexpr int kHeight = 100, kPoked = 70;
    const fs::path file = folder_ / "map.exr";
    // Returns the digests of rows [16 i, 16 i + 16).
    const auto digests = [&](const ExrRecipe& recipe) {
        writeRecipe(file, recipe);
        const int descriptor = ::open(file.c_str(), O_RDONLY);
        const auto here = openExrHere(descriptor, file);
        const auto there = ExrReader::open(file);
        EXPECT_TRUE(here && there);
        std::vector<std::string> found;
        for (int row = 0; row < kHeight; row += 16) {
            const int count = std::min(16, kHeight - row);
            const auto digest = there->storedDigest(row, count);
            EXPECT_TRUE(digest) << digest.error().line();
            EXPECT_EQ(*digest, (*here)->storedDigest(row, count).value_or(""));
            found.push_back(*digest);
        }
        ::close(descriptor);
        return found;
    };
    for (const bool isTiled : {false, true}) {
        ExrRecipe recipe{.width = 50, .height = kHeight, .isTiled = isTiled, .channels = seededShChannels()};
        recipe.tileExtent = 32;
        const auto before = digests(recipe);
        EXPECT_EQ(digests(recipe), before);
        recipe.corner = {-7, 13};
        EXPECT_EQ(digests(recipe), before) << "texels are the same wherever the window lies";
        if (!isTiled) {
            writeContent(file, withAttribute(contentOf(file), "capDate", "string", "today"));
            const auto later = ExrReader::open(file);
            ASSERT_TRUE(later);
            EXPECT_EQ(later->storedDigest(16, 16).value_or(""), before[1]) << "nor of any note in the header";
        }
        for (const int column : {0, 49}) {
            ExrRecipe poked = recipe;
            poke(poked, "sh08.B", column, kPoked, 2.5f);
            const auto after = digests(poked);
            for (std::size_t i = 0; i < after.size(); ++i) {
                const int chunk = isTiled ? 32 : 16;
                EXPECT_EQ(after[i] != before[i], static_cast<int>(16 * i) / chunk == kPoked / chunk) << i;
            }
        }
        ExrRecipe wide = recipe;
        wide.chromaticities = std::array{0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.329f};
        EXPECT_NE(digests(wide).front(), before.front()) << "these are other colours";
        ExrRecipe half = recipe;
        half.isHalf = true;
        half.isZip = false;
        recipe.isZip = false;
        EXPECT_NE(digests(half).front(), digests(recipe).front());
    }
    writeContent(file, contentOf(file).substr(0, fs::file_size(file) - 400));
    const auto cut = ExrReader::open(file);
    if (cut) {
        EXPECT_EQ(cut->storedDigest(0, kHeight).value_or("none"), "");
    }
}

TEST_F(ReaderProcesses, ErrorsAreThoseOfThisProcess) {
    ExrRecipe recipe{.width = 64, .height = 64, .channels = seededShChannels()};
    const fs::path file = folder_ / "map.exr";
    writeRecipe(file, recipe);
    const std::string whole = contentOf(file);
    for (const std::size_t bytes : {whole.size() / 2, std::size_t{400}, std::size_t{9}, std::size_t{3}}) {
        writeContent(file, whole.substr(0, bytes));
        const int descriptor = ::open(file.c_str(), O_RDONLY);
        const auto here = openExrHere(descriptor, file);
        const auto there = ExrReader::open(file);
        ASSERT_EQ(here.has_value(), there.has_value());
        Error ours = here ? Error() : here.error(), theirs = there ? Error() : there.error();
        if (here) {  // pixel data end too early
            std::vector<float> texels(64 * 64);
            const ExrPlane plane{"sh00.R", texels.data(), 1, 64};
            const auto rowsHere = (*here)->readRows(0, 64, {&plane, 1}), rowsThere = there->readRows(0, 64, {&plane, 1});
            ASSERT_FALSE(rowsHere || rowsThere);
            ours = rowsHere.error();
            theirs = rowsThere.error();
        }
        ::close(descriptor);
        EXPECT_EQ(ours.line(), theirs.line());
        EXPECT_EQ(ours.code, theirs.code);
    }
    EXPECT_THAT(ExrReader::open(folder_ / "none.exr").error().line(), HasSubstr("found no such file, expected an OpenEXR image"));
}

TEST_F(ReaderProcesses, MeshesOfDracoAreThoseOfThisProcess) {
    TriangleMesh mesh;
    MeshAttribute position;
    position.semantic = "POSITION";
    constexpr int kSide = 200;  // more than one piece of indices
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            for (const float value : {static_cast<float>(x), static_cast<float>(y), static_cast<float>(x * y % 7)}) {
                const auto bytes = std::as_bytes(std::span(&value, 1));
                position.values.insert(position.values.end(), bytes.begin(), bytes.end());
            }
    for (int y = 0; y + 1 < kSide; ++y)
        for (int x = 0; x + 1 < kSide; ++x)
            for (const int corner : {0, 1, kSide, 1, kSide + 1, kSide})
                mesh.indices.push_back(static_cast<std::uint32_t>(y * kSide + x + corner));
    mesh.attributes = {position};
    const std::vector<std::optional<Quantization>> quantization = {Quantization{.bits = 14, .origin = {}, .range = 1}};
    const auto encoded = encodeDraco(mesh, quantization, 5);
    ASSERT_TRUE(encoded) << encoded.error();
    const std::vector<DracoAttribute> wanted = {{"POSITION", encoded->uniqueIds.front()}};
    const auto here = decodeDracoHere(encoded->bytes, wanted), there = decodeDraco(encoded->bytes, wanted);
    ASSERT_TRUE(here && there);
    EXPECT_EQ(here->indices, there->indices);
    EXPECT_EQ(here->attributes.front().values, there->attributes.front().values);
    const auto stepHere = dracoLatticesHere(encoded->bytes), stepThere = dracoLattices(encoded->bytes);
    ASSERT_TRUE(stepHere && stepThere);
    EXPECT_EQ(stepHere->positionStep, stepThere->positionStep);
    EXPECT_EQ(stepHere->bitsOfId, stepThere->bitsOfId);
    const auto cut = std::span(encoded->bytes).first(encoded->bytes.size() / 2);
    EXPECT_EQ(decodeDracoHere(cut, wanted).error(), decodeDraco(cut, wanted).error());
}

TEST_F(ReaderProcesses, EndWithTheirFilesAndWithTheProgram) {
    ExrRecipe recipe{.width = 8, .height = 8, .channels = seededShChannels()};
    writeRecipe(folder_ / "map.exr", recipe);
    {
        const auto first = ExrReader::open(folder_ / "map.exr"), second = ExrReader::open(folder_ / "map.exr");
        ASSERT_TRUE(first && second);
        EXPECT_EQ(std::ranges::count_if(descendantsOf(::getpid()), runs), 3);  // and the server
    }
    EXPECT_TRUE(becomesTrue([] { return std::ranges::count_if(descendantsOf(::getpid()), runs) == 1; }));
    // A process that is killed leaves none behind.
    const pid_t victim = ::fork();
    if (victim == 0) {
        readInChildProcesses({.program = LIGHTCOOK_READ});
        const auto reader = ExrReader::open(folder_ / "map.exr");
        for (;;) ::pause();
    }
    std::vector<pid_t> theirs;
    EXPECT_TRUE(becomesTrue([&] { return (theirs = descendantsOf(victim)).size() == 2; }));
    ::kill(victim, SIGKILL);
    ::waitpid(victim, nullptr, 0);
    EXPECT_TRUE(becomesTrue([&] { return std::ranges::none_of(theirs, runs); }));
}

/// With the reader that misbehaves.
class BadReader : public ReaderProcesses {
protected:
    void SetUp() override { limitTo(1); }
    static void limitTo(double seconds) {
        readInChildProcesses({.program = LIGHTCOOK_BAD_READER, .seconds = seconds, .memoryBytes = std::uint64_t{512} << 20});
    }
    /// Returns the error of a file on which its reader does something.
    Error errorOf(const std::string& word) {
        const auto reader = ExrReader::open(orderIn(folder_, word));
        return reader ? Error() : reader.error();
    }
    void expectError(const std::string& word, const std::string& words) {
        SCOPED_TRACE(word);
        const Error error = errorOf(word);
        EXPECT_EQ(error.code, ErrorCode::FileUnreadable);
        EXPECT_EQ(error.file, folder_ / "a.exr");
        EXPECT_THAT(error.line(), testing::StartsWith((folder_ / "a.exr").string() + ": found content "));
        EXPECT_THAT(error.line(), HasSubstr(words));
    }
};

TEST_F(BadReader, CrashesAreErrorsOfTheFile) {
    expectError("crash", areReadersSanitized() ? "its reader" : "crashed (SIGSEGV)");
    expectError("abort", "crashed (SIGABRT)");
    expectError("throw", "crashed (SIGABRT)");
    expectError("exit", "ended without an answer");
    // Another file is read by another process.
    ExrRecipe recipe{.width = 8, .height = 8, .channels = seededShChannels()};
    writeRecipe(folder_ / "map.exr", recipe);
    const auto whole = ExrReader::open(folder_ / "map.exr");
    ASSERT_TRUE(whole) << whole.error().line();
    EXPECT_TRUE(rowsOf(*whole, 0, 8));
}

TEST_F(BadReader, HangsEndInTime) {
    expectError("hang", "worked for 1 s without progress");
    expectError("sleep", "worked for 1 s without progress");
    EXPECT_EQ(errorOf("work").detail, "worked");  // 2.4 s, with progress
}

TEST_F(BadReader, MemoryHasALimit) {
    if (areReadersSanitized()) GTEST_SKIP() << "the address sanitizer reserves terabytes";
    limitTo(60);  // pages of a busy machine are slow
    expectError("eat", "takes more than its limit of 512 MiB of memory");
    expectError("claim", "takes more than its limit of 512 MiB of memory");
}

TEST_F(BadReader, AnswersAreNotTrusted) {
    expectError("nonsense", "went wrong");
    expectError("huge", "went wrong");
}

TEST_F(BadReader, WallsHold) {
    if (areReadersSanitized()) GTEST_SKIP() << "the sanitizers open files and start threads";
    EXPECT_EQ(errorOf("walls").detail, "gaps:");
}

TEST_F(BadReader, OtherProgramsAreRefused) {
    const auto lineOf = [&] { return errorOf("crash").line(); };
    ::setenv("LIGHTCOOK_BAD_READER", "version", 1);
    EXPECT_THAT(lineOf(), HasSubstr("found lightcook-read 0.0.1 instead of "));
    ::unsetenv("LIGHTCOOK_BAD_READER");
    readInChildProcesses({.program = folder_ / "lightcook-read"});
    EXPECT_EQ(errorOf("crash").code, ErrorCode::Internal);
    EXPECT_THAT(lineOf(), HasSubstr("lightcook-read: found \"No such file or directory\", expected the program that reads images"));
    readInChildProcesses({.program = "/bin/true"});
    EXPECT_THAT(lineOf(), HasSubstr("/bin/true: found a program that says nothing, expected lightcook-read"));
}

}  // namespace
}  // namespace lightcook::formats
