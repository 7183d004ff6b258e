#include "formats/archive.h"

#include <gtest/gtest.h>

#include <limits>

namespace lightcook::formats {
namespace {

struct Inner {
    std::string name;
    std::vector<std::vector<float>> rows;
    bool operator==(const Inner&) const = default;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.name, self.rows);
    }
};
struct Outer {
    int number = 0;
    std::map<std::string, std::vector<float>> constants = {};
    std::optional<Inner> inner = {};
    std::vector<std::int64_t> histogram = std::vector<std::int64_t>(9);
    bool operator==(const Outer&) const = default;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.number, self.constants, self.inner);
        archive.sparse(self.histogram);
    }
};

const Outer kValue{7,
                   {{"range", {1, 2.5f}}, {"", {}}},
                   Inner{"l0", {{1}, {}, {2, 3}}},
                   {0, 0, 5, 128, 0, std::int64_t{1} << 40, 0, 0, std::numeric_limits<std::int64_t>::max()}};

TEST(Archive, GivesBackWhatItWasGiven) {
    EXPECT_EQ(unarchived<Outer>(archived(kValue)), kValue);
    EXPECT_EQ(unarchived<Outer>(archived(Outer())), Outer());
}

TEST(Archive, BytesThatAreCutOrTooManyAreNoValue) {
    const std::string bytes = archived(kValue);
    for (std::size_t length = 0; length < bytes.size(); ++length) EXPECT_FALSE(unarchived<Outer>(bytes.substr(0, length))) << length;
    EXPECT_FALSE(unarchived<Outer>(bytes + "x"));
}

}  // namespace
}  // namespace lightcook::formats
