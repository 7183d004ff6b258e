// BC6H at effort 0 must come close to a full search on simple pictures. A fast encoder that fails on one of these fails on all of its
// blocks: gradients, one colour, one hot texel, dim light beside the black between charts.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/vec3.hpp>

#include "bench/quality_table.h"

namespace lightcook::bench {
namespace {

struct SimplePicture {
    const char* name;
    glm::vec3 (*colour)(int x, int y);
    double behindDb;  ///< limit of effort 0 below effort 3
};

constexpr int kSide = 64;

glm::vec3 gradient(int x, int y) {
    const float u = static_cast<float>(x) / kSide, v = static_cast<float>(y) / kSide;
    return {0.2f + 0.3f * u, 0.3f + 0.2f * v, 0.4f - 0.2f * u * v};
}
glm::vec3 ramp(int x, int) {
    return glm::vec3(1, 0.8f, 0.6f) * std::exp2(static_cast<float>(x) / 8 - 4);
}
glm::vec3 sky(int, int y) {
    const float up = 1 - static_cast<float>(y) / kSide;
    return glm::vec3(0.25f, 0.45f, 0.9f) * (0.4f + up * up) + glm::vec3(0.9f, 0.6f, 0.3f) * std::exp2(-14 * up);
}
glm::vec3 flat(int, int) {
    return {0.37f, 0.21f, 0.53f};
}
glm::vec3 saturated(int x, int y) {
    return {1 + 0.02f * static_cast<float>(x), 0, 0.001f * static_cast<float>(y % 7)};
}
glm::vec3 hotTexel(int x, int y) {
    return x % 16 == 5 && y % 16 == 9 ? glm::vec3(60000, 50000, 40000) : gradient(x, y);
}
glm::vec3 alternating(int x, int y) {
    return (x + y) % 2 == 0 ? glm::vec3(0.1f, 0.2f, 0.3f) : glm::vec3(2, 1, 0.5f);
}
glm::vec3 grey(int x, int y) {
    return glm::vec3(0.18f + 0.01f * std::sin(0.3f * static_cast<float>(x)) * std::cos(0.2f * static_cast<float>(y)));
}
glm::vec3 tiny(int x, int y) {
    return gradient(x, y) * 1e-5f;
}
/// A chart whose border runs through blocks, with light below 1.
glm::vec3 dimBesideBlack(int x, int y) {
    return x + y / 3 > 41 || y < 3 ? glm::vec3(0) : gradient(x, y);
}

constexpr SimplePicture kPictures[] = {{"gradient", gradient, 5.3},
                                       {"ramp", ramp, 1.8},
                                       {"sky", sky, 1.8},
                                       {"flat", flat, 0.1},
                                       {"saturated", saturated, 1.6},
                                       {"hot_texel", hotTexel, 3.3},
                                       {"alternating", alternating, 0.1},
                                       {"grey", grey, 1},
                                       {"tiny", tiny, 0.1},
                                       {"dim_beside_black", dimBesideBlack, 3.6}};

class Bc6hSimplePictures : public testing::TestWithParam<SimplePicture> {};

TEST_P(Bc6hSimplePictures, EffortZeroIsNotFarBehind) {
    Picture picture{GetParam().name, PictureKind::Generated, formats::Image<glm::vec4>(kSide, kSide),
                    formats::Image<float>(kSide, kSide, 1.0f)};
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) picture.texels.at(x, y) = glm::vec4(GetParam().colour(x, y), 1.0f);
    const double fast = encodeAndMeasure(formats::PixelFormat::Bc6hUf16, 0, picture).psnrDb;
    const double searched = encodeAndMeasure(formats::PixelFormat::Bc6hUf16, 3, picture).psnrDb;
    EXPECT_GE(fast, searched - GetParam().behindDb) << fmt::format("found {:.2f} dB at effort 0, {:.2f} dB at effort 3", fast, searched);
}
INSTANTIATE_TEST_SUITE_P(Quality, Bc6hSimplePictures, testing::ValuesIn(kPictures),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace lightcook::bench
