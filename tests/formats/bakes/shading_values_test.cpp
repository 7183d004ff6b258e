#include "formats/shading_values.h"

#include <gmock/gmock.h>

#include <fstream>
#include <glm/geometric.hpp>

#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

using testing::HasSubstr;

const std::string kHead = "x,y,kind,m,f0,dx,dy,dz,r,g,b\n";

class ShadingValues : public testing::Test {
protected:
    Result<std::vector<ShadingValue>> read(const std::string& content) const {
        std::ofstream(file_) << content;
        return readShadingValues(file_, 16, 8);
    }
    /// Line 2 of an otherwise sound file.
    void expectRefused(const std::string& line, ErrorCode code, const std::string& found) const {
        const auto values = read(kHead + line + "\n1,2,lambert,0,0,0,0,1,1,1,1\n");
        ASSERT_FALSE(values.has_value()) << line;
        EXPECT_EQ(values.error().code, code) << line;
        EXPECT_THAT(values.error().line(), HasSubstr("truth.csv, line 2: found " + found));
        EXPECT_THAT(values.error().line(), HasSubstr(", expected "));
    }

    TemporaryFolder folder_;
    std::filesystem::path file_ = folder_ / "truth.csv";
};

TEST_F(ShadingValues, BothKindsAreRead) {
    const auto values = read(kHead + "15,7,lambert,0,0,0,0,2,1,2.5,0\r\n\n3,0,spec,0.25,0.04,0.6,0,0.8,1e-3,0,7\n");
    ASSERT_TRUE(values.has_value()) << values.error().line();
    ASSERT_EQ(values->size(), 2u);
    const ShadingValue &lambert = values->front(), &specular = values->back();
    EXPECT_EQ(lambert.kind, ShadingValue::Kind::Lambert);
    EXPECT_EQ(lambert.x, 15);
    EXPECT_EQ(lambert.y, 7);
    EXPECT_EQ(lambert.direction, glm::dvec3(0, 0, 1)) << "made unit";
    EXPECT_EQ(lambert.value, glm::dvec3(1, 2.5, 0));
    EXPECT_EQ(specular.kind, ShadingValue::Kind::Specular);
    EXPECT_EQ(specular.line, 4);
    EXPECT_EQ(specular.m, 0.25);
    EXPECT_EQ(specular.f0, 0.04);
    EXPECT_NEAR(glm::length(specular.direction), 1, 1e-15);
}

TEST_F(ShadingValues, AByteOrderMarkIsLeftOut) {
    const auto values = read("\xEF\xBB\xBF" + kHead + "1,2,lambert,0,0,0,0,1,1,1,1\r\n");
    ASSERT_TRUE(values.has_value()) << values.error().line();
    EXPECT_EQ(values->size(), 1u);
}

TEST_F(ShadingValues, ImpossibleValuesAreRefusedByLine) {
    expectRefused("1,2,lambert,0,0,0,0,1,1,1", ErrorCode::WrongShape, "10 columns");
    expectRefused("1,2,lambert,0,0,0,0,1,1,1,1,1", ErrorCode::WrongShape, "12 columns");
    expectRefused("16,2,lambert,0,0,0,0,1,1,1,1", ErrorCode::WrongShape, "texel (16, 2)");
    expectRefused("1,8,lambert,0,0,0,0,1,1,1,1", ErrorCode::WrongShape, "texel (1, 8)");
    expectRefused("-1,2,lambert,0,0,0,0,1,1,1,1", ErrorCode::WrongShape, "texel (-1, 2)");
    expectRefused("1.5,2,lambert,0,0,0,0,1,1,1,1", ErrorCode::WrongShape, "texel (1.5, 2)");
    expectRefused("1,2,phong,0,0,0,0,1,1,1,1", ErrorCode::FormatUnsupported, "kind 'phong'");
    expectRefused("1,2,lambert,0,0,0,0,1,nan,1,1", ErrorCode::ValueNotFinite, "'nan'");
    expectRefused("1,2,lambert,0,0,0,0,1,1,inf,1", ErrorCode::ValueNotFinite, "'inf'");
    expectRefused("1,2,lambert,0,0,0,0,1,1,1,", ErrorCode::ValueNotFinite, "''");
    expectRefused("1,2,lambert,0,0,0,0,0,1,1,1", ErrorCode::ValueOutOfRange, "a direction of length 0");
    expectRefused("1,2,lambert,0,0,0,0,1,1,-1,1", ErrorCode::ValueOutOfRange, "light of (1, -1, 1)");
    expectRefused("1,2,lambert,0,0,0,0,1,1,1e300,1", ErrorCode::ValueOutOfRange, "light of (1, 1e+300, 1)");
    expectRefused("1,2,spec,0,0.04,0,0,1,1,1,1", ErrorCode::ValueOutOfRange, "m 0");
    expectRefused("1,2,spec,0.5,1.5,0,0,1,1,1,1", ErrorCode::ValueOutOfRange, "f0 1.5");
}

TEST_F(ShadingValues, AFileWithoutItsColumnsOrValuesIsRefused) {
    EXPECT_THAT(read("").error().line(), HasSubstr("line 1: found ''"));
    EXPECT_THAT(read("a,b\n1,2\n").error().line(), HasSubstr("found 'a,b', expected the columns x,y,kind"));
    EXPECT_THAT(read(kHead).error().line(), HasSubstr("found no values"));
    EXPECT_EQ(readShadingValues(folder_ / "absent.csv", 4, 4).error().code, ErrorCode::FileUnreadable);
    EXPECT_EQ(readShadingValues(folder_ / "", 4, 4).error().code, ErrorCode::FileUnreadable);
}

}  // namespace
}  // namespace lightcook::formats
