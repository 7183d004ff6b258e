// The corpora of the fuzzers, taken again: inputs that reach each part of a parser, and those that once broke one.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <random>
#include <vector>

#include "tests/formats/texture_fixture.h"
#include "tests/fuzz/target.h"

namespace lightcook::fuzz {
namespace {

std::vector<std::filesystem::path> corpusOf(const Target& target) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(LIGHTCOOK_FUZZ_CORPUS "/" + std::string(target.name)))
        files.push_back(entry.path());
    std::ranges::sort(files);
    return files;
}

/// Targets print much, so their output is shown only if one failed.
class FuzzCorpus : public testing::TestWithParam<Target> {
protected:
    void SetUp() override {
        testing::internal::CaptureStdout();
        testing::internal::CaptureStderr();
    }
    void TearDown() override {
        const std::string printed = testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
        if (HasFailure()) std::cout << printed;
    }
};

TEST_P(FuzzCorpus, IsReadOrRefused) {
    const std::vector<std::filesystem::path> files = corpusOf(GetParam());
    ASSERT_GE(files.size(), 5u);
    for (const std::filesystem::path& file : files) {
        SCOPED_TRACE(file.filename());
        EXPECT_NO_THROW(GetParam().take(formats::wholeFile(file)));
    }
}

/// A byte changed, a part left out or twice: what a fuzzer without feedback does.
TEST_P(FuzzCorpus, ChangedInputsAreReadOrRefused) {
    std::mt19937 random(1);
    for (const std::filesystem::path& file : corpusOf(GetParam()))
        for (int change = 0; change < 4; ++change) {
            std::vector<std::byte> bytes = formats::wholeFile(file);
            if (bytes.empty()) continue;
            for (int count = 0; count < 3; ++count) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
            const std::size_t begin = random() % bytes.size(), end = begin + random() % (bytes.size() - begin);
            const std::vector<std::byte> part(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                                              bytes.begin() + static_cast<std::ptrdiff_t>(end));
            if (change == 1) bytes.resize(begin);
            if (change == 2) bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(end), part.begin(), part.end());
            SCOPED_TRACE(file.filename().string() + ", change " + std::to_string(change));
            EXPECT_NO_THROW(GetParam().take(bytes));
        }
}

std::string testName(const testing::TestParamInfo<Target>& instance) {
    std::string name(instance.param.name);
    std::ranges::replace(name, '-', '_');
    return name;
}

// A macro of its own, since a name that is an argument of GoogleTest's is not expanded.
#define LC_INSTANTIATE(module) INSTANTIATE_TEST_SUITE_P(module, FuzzCorpus, testing::ValuesIn(targets().begin(), targets().end()), testName)
LC_INSTANTIATE(LIGHTCOOK_FUZZ_MODULE);

}  // namespace
}  // namespace lightcook::fuzz
