#include "pipeline/command/compare.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "formats/environment.h"
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
    static std::string refusalOf(const std::filesystem::path& a, const std::filesystem::path& b, formats::ErrorCode code) {
        const auto compared = compareFiles(a, b);
        if (compared) return "not refused";
        EXPECT_EQ(compared.error().code, code);
        return compared.error().line();
    }

    formats::TemporaryFolder folder_;
};

TEST_F(CompareFiles, MeasuresTheLargestDifference) {
    const auto compared = compareFiles(image("a.exr", 0.5f), image("b.exr", 0.75f));
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

TEST_F(CompareFiles, NamesTheFileBesideAFolder) {
    const auto file = image("a.exr", 0.5f);
    EXPECT_THAT(refusalOf(folder_.path(), folder_ / "nowhere", formats::ErrorCode::FileUnreadable),
                HasSubstr("nowhere: found no such folder"));
    EXPECT_THAT(refusalOf(file, folder_.path(), formats::ErrorCode::FileUnreadable),
                HasSubstr("a.exr: found a file, expected a cooked folder"));
}

}  // namespace
}  // namespace lightcook::pipeline
