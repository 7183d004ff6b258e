#include "verify/specular_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <set>

namespace verify {
namespace {

SpecularTableAxis axisOf(int count, double minimum, double maximum) {
    if (count == 1) return {1, minimum, maximum, 0, 0.5f};
    const double scale = (count - 1) / (count * (maximum - minimum));
    return {count, minimum, maximum, static_cast<float>(scale), static_cast<float>(0.5 / count - minimum * scale)};
}

/// Tables of the kernel itself, in 16 bits, integrated here node by node.
CookedSpecularTables cook(int views, int rows, double minimumM, double maximumM, SpecularViewAxis viewAxis = SpecularViewAxis::Sine) {
    CookedSpecularTables tables;
    tables.viewAxis = viewAxis;
    tables.view = axisOf(views, 0, 1);
    tables.roughness = axisOf(rows, minimumM, maximumM);
    for (auto& texture : tables.textures) texture = formats::Image<glm::vec4>(views, rows);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < views; ++x) {
            const double place = x / (views - 1.0), NoV = viewAxis == SpecularViewAxis::Sine ? std::sqrt(1 - place * place) : place;
            const double m = rows > 1 ? minimumM + (maximumM - minimumM) * y / (rows - 1) : minimumM;
            const auto k = lighting::integrateAreaSpecular(std::max(1e-3, NoV), m, lighting::NormalDistribution::Beckmann,
                                                           lighting::CookTorranceNormalization::Energy, 400);
            tables.textures[0].at(x, y) = glm::vec4(glm::dvec4(k.c[0], k.c[2], k.c[3], k.c[6]));
            tables.textures[1].at(x, y) = glm::vec4(glm::dvec4(k.d[0], k.d[2], k.d[3], k.d[6]));
            tables.textures[2].at(x, y) = glm::vec4(glm::dvec4(k.c[7], k.c[8], k.d[7], k.d[8]));
        }
    for (std::size_t i = 0; i < 3; ++i) {
        glm::vec4 low = tables.textures[i].at(0, 0), high = low;
        for (const glm::vec4& value : tables.textures[i].texels()) low = glm::min(low, value), high = glm::max(high, value);
        tables.bias[i] = low;
        tables.scale[i] = high - low;
        for (glm::vec4& value : tables.textures[i].texels()) value = glm::round((value - low) / tables.scale[i] * 65535.0f) / 65535.0f;
    }
    return tables;
}

std::vector<StageError> verifyAll(const CookedSpecularTables& tables, int randomCount = 12) {
    const auto samples = specularTableSamples(tables, randomCount, 1);
    std::vector<SpecularTableResult> results;
    for (const SpecularTableSample& sample : samples) results.push_back(compareSpecularTables(tables, sample));
    return specularTableStages(samples, results, {0.0, 0.04, 1.0});
}

TEST(SpecularTableSamples, MeetEveryNodeEveryCellAndTheRangesOnly) {
    const CookedSpecularTables tables = cook(4, 3, 0.1, 0.7);
    const auto samples = specularTableSamples(tables, 50, 3);
    int nodes = 0, middles = 0;
    std::set<std::pair<double, double>> places;
    for (const SpecularTableSample& sample : samples) {
        nodes += sample.isNode ? 1 : 0;
        middles += sample.isMiddle ? 1 : 0;
        EXPECT_GE(sample.view, 0);
        EXPECT_LE(sample.view, 1);
        EXPECT_GE(sample.m, 0.1);
        EXPECT_LE(sample.m, 0.7 + 1e-12);
        places.insert({sample.view, sample.m});
    }
    EXPECT_EQ(nodes, 12);
    EXPECT_EQ(middles, 6);
    EXPECT_EQ(places.size(), samples.size());
}

TEST(VerifySpecularTables, GoodTablesQuantizeFinelyAndFilterWithinPercents) {
    const auto stages = verifyAll(cook(8, 6, 0.2, 0.6));
    ASSERT_EQ(stages.size(), 3u);
    EXPECT_EQ(stages[0].name, "quantize");
    EXPECT_EQ(stages[1].name, "filter");
    EXPECT_EQ(stages[2].name, "total");
    EXPECT_GT(stages[0].specular.relRms, 1e-7);
    EXPECT_LT(stages[0].specular.relRms, 1e-4);
    EXPECT_GT(stages[1].specular.relRms, stages[0].specular.relRms);
    EXPECT_LT(stages[1].specular.relRms, 0.2);
    EXPECT_LT(stages[2].specular.relRms, 0.15);
    for (const StageError& stage : stages) {
        EXPECT_GE(stage.specular.maxBound, stage.specular.maxSampled) << stage.name;
        EXPECT_EQ(stage.diffuse.relRms, 0);
    }
}

TEST(VerifySpecularTables, CosinesFilterBetterThanSines) {
    // Near grazing the kernel is smooth in NoV; in the sine it has a root.
    const double sines = verifyAll(cook(8, 4, 0.2, 0.5)).back().specular.relRms;
    const double cosines = verifyAll(cook(8, 4, 0.2, 0.5, SpecularViewAxis::NoV)).back().specular.relRms;
    EXPECT_LT(cosines, 0.7 * sines);
    EXPECT_LT(verifyAll(cook(8, 4, 0.2, 0.5, SpecularViewAxis::NoV)).front().specular.relRms, 1e-4);
}

TEST(VerifySpecularTables, OneRowOfRoughnessIsEnoughForOneMaterial) {
    const CookedSpecularTables tables = cook(8, 1, 0.3, 0.3);
    for (const SpecularTableSample& sample : specularTableSamples(tables, 9, 1)) EXPECT_EQ(sample.m, 0.3);
    EXPECT_LT(verifyAll(tables).back().specular.relRms, 0.15);
}

TEST(VerifySpecularTables, FindsWrongContentAndWrongCoordinates) {
    const CookedSpecularTables good = cook(6, 3, 0.2, 0.6);
    const double filter = verifyAll(good)[1].specular.relRms;
    CookedSpecularTables bright = cook(6, 3, 0.2, 0.6);
    for (glm::vec4& scale : bright.scale) scale *= 4.0f;  // Halo 3's normalisation where energy is claimed
    for (glm::vec4& bias : bright.bias) bias *= 4.0f;
    EXPECT_NEAR(verifyAll(bright)[0].specular.relRms, 3, 0.01);
    CookedSpecularTables swapped = cook(6, 3, 0.2, 0.6);
    std::swap(swapped.textures[0], swapped.textures[1]);
    EXPECT_GT(verifyAll(swapped)[2].specular.relRms, 0.3);
    CookedSpecularTables shifted = cook(6, 3, 0.2, 0.6);
    shifted.view.offset += 0.5f / 6;  // half a texel: the usual mistake
    EXPECT_GT(verifyAll(shifted)[0].specular.relRms, 0.005);
    EXPECT_GT(verifyAll(shifted)[1].specular.relRms, filter);
}

TEST(VerifySpecularTables, TotalTellsTheAreaSpecularOfAConstantLight) {
    // One sample, a kernel whose C0 alone is off by 10 %: reflected radiance under F0 = 1 is off by as much where light is constant.
    SpecularTableResult result;
    result.reference[0] = 0.25;
    result.cooked[0] = 0.275;
    const std::vector<SpecularTableSample> samples = {{0.5, 0.3, true, false}};
    const auto stages = specularTableStages(samples, {result}, {1.0});
    EXPECT_NEAR(stages[2].specular.relRms, 0.1, 1e-6);
    EXPECT_NEAR(stages[2].specular.maxSampled, 0.1 / 1.02, 2e-3);
}

}  // namespace
}  // namespace verify
