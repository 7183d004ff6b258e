#include "formats/color.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

using testing::HasSubstr;
using Matrix = std::array<std::array<double, 3>, 3>;  // rows

Matrix multiply(const Matrix& a, const Matrix& b) {
    Matrix result{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t k = 0; k < 3; ++k) result[i][j] += a[i][k] * b[k][j];
    return result;
}

/// Gauss-Jordan with pivoting: nothing in common with the cofactors that the code under test uses.
Matrix inverted(Matrix a) {
    Matrix result = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (std::size_t column = 0; column < 3; ++column) {
        std::size_t pivot = column;
        for (std::size_t row = column; row < 3; ++row)
            if (std::abs(a[row][column]) > std::abs(a[pivot][column])) pivot = row;
        std::swap(a[pivot], a[column]);
        std::swap(result[pivot], result[column]);
        const double scale = a[column][column];
        for (std::size_t k = 0; k < 3; ++k) a[column][k] /= scale, result[column][k] /= scale;
        for (std::size_t row = 0; row < 3; ++row) {
            if (row == column) continue;
            const double factor = a[row][column];
            for (std::size_t k = 0; k < 3; ++k) a[row][k] -= factor * a[column][k], result[row][k] -= factor * result[column][k];
        }
    }
    return result;
}

Matrix fromGlm(const glm::mat3& m) {
    Matrix result{};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            result[row][column] = static_cast<double>(m[static_cast<int>(column)][static_cast<int>(row)]);
    return result;
}

/// xyz of the primaries by the published formula, (x, y) pairs of red, green, blue, white.
Matrix xyzFromPrimaries(const std::array<double, 8>& xy) {
    Matrix primaries{};
    for (std::size_t p = 0; p < 3; ++p) {
        primaries[0][p] = xy[2 * p];
        primaries[1][p] = xy[2 * p + 1];
        primaries[2][p] = 1 - xy[2 * p] - xy[2 * p + 1];
    }
    const std::array<double, 3> white = {xy[6] / xy[7], 1, (1 - xy[6] - xy[7]) / xy[7]};
    const Matrix inverse = inverted(primaries);
    for (std::size_t p = 0; p < 3; ++p) {
        const double amount = inverse[p][0] * white[0] + inverse[p][1] * white[1] + inverse[p][2] * white[2];
        for (std::size_t row = 0; row < 3; ++row) primaries[row][p] *= amount;
    }
    return primaries;
}

const std::array<double, 8> kRec709 = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};
const std::array<double, 8> kAp1 = {0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767};

LinearConversion converted(const std::string& source, const std::string& working) {
    const auto result = linearConversion({source, working, {}});
    EXPECT_TRUE(result) << result.error().line();
    return result.value_or(LinearConversion{});
}

std::string refusalOf(const ColorSpaces& spaces) {
    const auto result = linearConversion(spaces);
    EXPECT_FALSE(result);
    if (result) return {};
    EXPECT_EQ(result.error().code, spaces.config.empty() ? ErrorCode::ColorSpace : result.error().code);
    EXPECT_EQ(result.error().line().find('\n'), std::string::npos);
    return result.error().line();
}

TEST(LinearConversion, Rec709ToAcescgFollowsFromThePrimariesAndBradford) {
    const Matrix cones = {{{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};
    Matrix scale{};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto response = [&](double x, double y) { return cones[i][0] * x / y + cones[i][1] + cones[i][2] * (1 - x - y) / y; };
        scale[i][i] = response(0.32168, 0.33767) / response(0.3127, 0.3290);
    }
    const Matrix adapted = multiply(multiply(inverted(cones), scale), cones);
    const Matrix expected = multiply(inverted(xyzFromPrimaries(kAp1)), multiply(adapted, xyzFromPrimaries(kRec709)));
    const LinearConversion conversion = converted("lin_rec709", "acescg");
    const Matrix found = fromGlm(conversion.workingFromSource);
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            EXPECT_NEAR(found[row][column], expected[row][column], 1e-6) << row << ' ' << column;
    // Published in the utilities of ACES 1.0, to the four digits in which they agree.
    EXPECT_NEAR(found[0][0], 0.6131, 1e-4);
    EXPECT_NEAR(found[1][1], 0.9164, 1e-4);
    EXPECT_NEAR(found[2][2], 0.8698, 1e-4);
    EXPECT_FALSE(conversion.isIdentity);
}

TEST(LinearConversion, EveryLinearSpaceKeepsWhiteAndComesBack) {
    for (const char* name : {"lin_rec709", "lin_srgb", "acescg", "lin_ap0", "aces2065-1", "lin_rec2020", "lin_p3d65"}) {
        const glm::mat3 there = converted("lin_rec709", name).workingFromSource, back = converted(name, "lin_rec709").workingFromSource;
        const glm::vec3 white = there * glm::vec3(1);
        const glm::mat3 both = back * there;
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(white[i], 1.0f, 2e-6f) << name;
            for (int j = 0; j < 3; ++j) EXPECT_NEAR(both[i][j], i == j ? 1.0f : 0.0f, 4e-6f) << name;
        }
    }
}

TEST(LinearConversion, WeightsAreTheLuminanceOfEachPrimary) {
    for (const auto& [name, xy] : {std::pair{"lin_rec709", kRec709}, std::pair{"acescg", kAp1}}) {
        const Matrix xyz = xyzFromPrimaries(xy);
        const glm::vec3 weights = converted("lin_rec709", name).luminanceWeights;
        for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(weights[static_cast<int>(i)], xyz[1][i], 1e-6) << name;
    }
    EXPECT_NEAR(converted("lin_rec709", "lin_rec709").luminanceWeights.y, 0.7152, 1e-4);
    EXPECT_EQ(converted("lin_rec709", "lin_ciexyzd65").luminanceWeights, glm::vec3(0, 1, 0));
}

TEST(LinearConversion, TheSameSpaceIsTheIdentityUnderAnyOfItsNames) {
    for (const auto& [a, b] : {std::pair{"lin_rec709", "lin_srgb"}, std::pair{"aces2065-1", "lin_ap0"}, std::pair{"ACEScg", "acescg"}}) {
        const LinearConversion conversion = converted(a, b);
        EXPECT_TRUE(conversion.isIdentity) << a;
        EXPECT_EQ(conversion.workingFromSource, glm::mat3(1)) << a;
    }
    EXPECT_FALSE(converted("lin_rec709", "lin_rec2020").isIdentity);
}

TEST(LinearConversion, EncodedSpacesAreRefusedByNameAndWithTheReason) {
    for (const char* name : {"srgb_texture", "g22_rec709"}) {
        const std::string line = refusalOf({name, "lin_rec709", {}});
        EXPECT_THAT(line, HasSubstr(std::string("colour space '") + name + "' is not linear"));
        EXPECT_THAT(line, HasSubstr("SH coefficients, cubemaps and gradients only keep their meaning under linear conversions"));
        EXPECT_THAT(line, HasSubstr("found ("));
        EXPECT_THAT(line, HasSubstr("expected ("));
        EXPECT_THAT(refusalOf({"acescg", name, {}}), HasSubstr(std::string("'") + name + "' is not linear"));
        EXPECT_THAT(refusalOf({name, name, {}}), HasSubstr("is not linear")) << "curves that cancel do not make the working space linear";
    }
}

TEST(LinearConversion, UnknownSpacesSuggestTheNearest) {
    EXPECT_THAT(refusalOf({"lin_rec790", "lin_rec709", {}}),
                testing::AllOf(HasSubstr("'lin_rec790'"), HasSubstr("nearest is 'lin_rec709'")));
    EXPECT_THAT(refusalOf({"lin_rec709", "asescg", {}}), HasSubstr("nearest is 'acescg'"));
    EXPECT_THAT(refusalOf({"", "acescg", {}}), HasSubstr("found no such space"));
}

using Xy = std::array<float, 8>;
constexpr Xy kStatedRec709 = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
constexpr Xy kStatedAcesCg = {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f};
constexpr Xy kStatedRec2020 = {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f};
constexpr Xy kStatedP3D65 = {0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, 0.3127f, 0.3290f};
constexpr Xy kStatedAces = {0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.0770f, 0.32168f, 0.33767f};
constexpr Xy kStatedXyz = {1, 0, 0, 1, 0, 0, 1 / 3.0f, 1 / 3.0f};

TEST(StatedPrimaries, TheMatrixIsThatOfTheSpace) {
    const auto rec709 = bt2020FromChromaticities(kStatedRec709);
    ASSERT_TRUE(rec709);
    const glm::dmat3 published = lighting::bt2020FromRec709();
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) EXPECT_NEAR((*rec709)[column][row], published[column][row], 1e-4) << row << ' ' << column;
}

TEST(StatedPrimaries, ASpaceAgreesWithItselfAlone) {
    const std::vector<std::pair<std::string, Xy>> spaces = {{"lin_rec709", kStatedRec709},   {"acescg", kStatedAcesCg},
                                                            {"lin_rec2020", kStatedRec2020}, {"lin_p3d65", kStatedP3D65},
                                                            {"aces2065-1", kStatedAces},     {"lin_ciexyzd65", kStatedXyz}};
    for (const auto& [source, ofSource] : spaces)
        for (const auto& [name, xy] : spaces) {
            const auto primaries = statedPrimaries(xy, converted(source, "lin_p3d65"));
            ASSERT_TRUE(primaries) << source << ' ' << name;
            EXPECT_EQ(primaries->space, name);
            EXPECT_EQ(primaries->chromaticities, xy);
            if (source == name)
                EXPECT_LT(primaries->difference, 1e-4) << name;
            else
                EXPECT_GT(primaries->difference, 2 * kSamePrimaries) << source << ' ' << name;
        }
}

/// Primaries of no built-in space: Adobe RGB.
TEST(StatedSource, ConvertsFromWhatTheFileStates) {
    const auto stated = [](const std::optional<Xy>& xy) { return linearConversion({kStatedSource, "lin_rec709", {}}, xy); };
    EXPECT_TRUE(stated({})->isIdentity);
    EXPECT_TRUE(stated(kStatedRec709)->isIdentity) << "those of the format, not of a nearly equal matrix";
    EXPECT_EQ(stated(kStatedAcesCg)->workingFromSource, converted("acescg", "lin_rec709").workingFromSource);
    constexpr Xy kAdobe = {0.64f, 0.33f, 0.21f, 0.71f, 0.15f, 0.06f, 0.3127f, 0.3290f};
    const auto adobe = stated(kAdobe);
    ASSERT_TRUE(adobe) << adobe.error().line();
    // Red and blue are those of Rec.709, and white is white: a published matrix (its rows: 1.3983 -0.3983 0, 0 1 0, 0 -0.0429 1.0429).
    const glm::vec3 white = adobe->workingFromSource * glm::vec3(1), green = adobe->workingFromSource * glm::vec3(0, 1, 0);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(white[c], 1, 1e-4f);
    EXPECT_NEAR(green.r, -0.3983f, 1e-3f);
    EXPECT_NEAR(green.g, 1, 1e-3f);
    EXPECT_NEAR(green.b, -0.0429f, 1e-3f);
    EXPECT_LT(statedPrimaries(kAdobe, *adobe)->difference, 1e-9);
    EXPECT_FALSE(stated(Xy{}));
    EXPECT_TRUE(checkColorSpace(kStatedSource, {}));
    EXPECT_FALSE(checkColorSpace(kStatedSource, "config.ocio"));
}

TEST(StatedPrimaries, NoSpaceHasPrimariesOnALine) {
    EXPECT_FALSE(bt2020FromChromaticities({}));
    EXPECT_FALSE(bt2020FromChromaticities({0.1f, 0.1f, 0.2f, 0.2f, 0.3f, 0.3f, 0.3127f, 0.3290f}));
    Xy withoutWhite = kStatedRec709, infinite = kStatedRec709;
    withoutWhite[7] = 0;
    infinite[0] = INFINITY;
    EXPECT_FALSE(bt2020FromChromaticities(withoutWhite));
    EXPECT_FALSE(bt2020FromChromaticities(infinite));
    EXPECT_FALSE(statedPrimaries(infinite, converted("lin_rec709", "lin_rec709")));
}

const char* const kUserConfig = R"(ocio_profile_version: 2
roles:
  default: plain
  scene_linear: plain
displays:
  d:
    - !<View> {name: v, colorspace: plain}
colorspaces:
  - !<ColorSpace>
    name: plain
  - !<ColorSpace>
    name: doubled
    to_reference: !<MatrixTransform> {matrix: [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: lifted
    to_reference: !<MatrixTransform> {offset: [0.1, 0.1, 0.1, 0]}
  - !<ColorSpace>
    name: clipped
    to_reference: !<RangeTransform> {min_in_value: 0, min_out_value: 0, max_in_value: 1, max_out_value: 1}
  - !<ColorSpace>
    name: data
    isdata: true
  - !<ColorSpace>
    name: absent_table
    to_reference: !<FileTransform> {src: nowhere.spi3d}
)";

TEST(LinearConversion, AUsersConfigIsProbedAndNotBelieved) {
    const TemporaryFolder folder;
    const auto config = folder / "config.ocio";
    writeContent(config, kUserConfig);
    const auto doubled = linearConversion({"doubled", "plain", config});
    ASSERT_TRUE(doubled) << doubled.error().line();
    EXPECT_FLOAT_EQ(doubled->workingFromSource[1][1], 2.0f);
    EXPECT_THAT(refusalOf({"lifted", "plain", config}), HasSubstr("'lifted' is not linear"));
    EXPECT_THAT(refusalOf({"clipped", "plain", config}), HasSubstr("'clipped' is not linear"));
    EXPECT_THAT(refusalOf({"data", "plain", config}), HasSubstr("data without primaries"));
    EXPECT_THAT(refusalOf({"absent_table", "plain", config}), HasSubstr("nowhere.spi3d"));
    EXPECT_THAT(refusalOf({"doublet", "plain", config}), HasSubstr("nearest is 'doubled'"));
    EXPECT_FALSE(doubled->bt2020FromSource) << "the config has no role aces_interchange";
    EXPECT_FALSE(statedPrimaries(kStatedRec709, *doubled));
}

TEST(FilesOfConversion, AreTheMatricesAndTablesOfTheTwoSpaces) {
    const TemporaryFolder folder;
    const auto config = folder / "config.ocio";
    writeContent(config,
                 std::string(kUserConfig) + "  - !<ColorSpace>\n    name: half\n    to_reference: !<FileTransform> {src: half.spimtx}\n");
    writeContent(folder / "half.spimtx", "0.5 0 0 0\n0 0.5 0 0\n0 0 0.5 0\n");
    EXPECT_THAT(filesOfConversion({"half", "plain", config}), testing::ElementsAre(folder / "half.spimtx"));
    EXPECT_THAT(filesOfConversion({"doubled", "plain", config}), testing::IsEmpty());
    EXPECT_THAT(filesOfConversion({"absent_table", "plain", config}), testing::IsEmpty());
    EXPECT_THAT(filesOfConversion({"half", "plain", folder / "absent.ocio"}), testing::IsEmpty());
    EXPECT_THAT(filesOfConversion({}), testing::IsEmpty());
}

TEST(StatedPrimaries, AConfigWithTheInterchangeRoleIsComparedWith) {
    const TemporaryFolder folder;
    writeContent(folder / "config.ocio", R"(ocio_profile_version: 2
roles:
  aces_interchange: aces
  default: aces
  scene_linear: aces
colorspaces:
  - !<ColorSpace>
    name: aces
  - !<ColorSpace>
    name: half
    to_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}
)");
    const auto same = linearConversion({"aces", "half", folder / "config.ocio"});
    ASSERT_TRUE(same) << same.error().line();
    EXPECT_LT(statedPrimaries(kStatedAces, *same)->difference, 1e-4);
    const auto darker = linearConversion({"half", "aces", folder / "config.ocio"});
    ASSERT_TRUE(darker) << darker.error().line();
    EXPECT_GT(statedPrimaries(kStatedAces, *darker)->difference, kSamePrimaries);
}

TEST(LinearConversion, ABrokenConfigFileIsOneLine) {
    const TemporaryFolder folder;
    writeContent(folder / "broken.ocio", "ocio_profile_version: 2\ncolorspaces:\n  - [unclosed\n");
    EXPECT_THAT(refusalOf({"a", "b", folder / "broken.ocio"}), HasSubstr("expected an OpenColorIO config file"));
    EXPECT_THAT(refusalOf({"a", "b", folder / "absent.ocio"}), HasSubstr("absent.ocio"));
}

}  // namespace
}  // namespace lightcook::formats
