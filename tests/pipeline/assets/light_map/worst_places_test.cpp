#include "pipeline/assets/light_map/worst_places.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "formats/plain_image.h"
#include "lighting/display.h"
#include "pipeline/assets/preview.h"
#include "pipeline/cook/cook.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

TEST(WorstTexels, AreTheWorstOfTheirSquaresInAnyCut) {
    constexpr int kWidth = 100, kHeight = 96;
    std::mt19937 random(4);
    std::uniform_int_distribution<int> level(0, 500);
    formats::Image<float> visible(kWidth, kHeight);
    for (float& value : visible.texels()) value = static_cast<float>(level(random));
    const auto found = [&](int stripHeight) {
        WorstTexels whole;
        for (int first = 0; first < kHeight; first += stripHeight) {
            WorstTexels strip(kWidth, first, stripHeight);
            for (int y = first; y < first + stripHeight; ++y)
                for (int x = 0; x < kWidth; ++x) strip.add(x, y, visible.at(x, y));
            whole.merge(strip);
        }
        return whole.apart(4, 24);
    };
    const auto places = found(16);
    ASSERT_EQ(places.size(), 4u);
    for (const int stripHeight : {32, 96}) {
        const auto others = found(stripHeight);
        for (std::size_t i = 0; i < places.size(); ++i) {
            EXPECT_EQ(others[i].x, places[i].x);
            EXPECT_EQ(others[i].y, places[i].y);
        }
    }
    EXPECT_EQ(places.front().visible, *std::ranges::max_element(visible.texels()));
    for (std::size_t i = 0; i < places.size(); ++i) {
        EXPECT_EQ(places[i].visible, visible.at(places[i].x, places[i].y));
        for (std::size_t j = 0; j < i; ++j) {
            EXPECT_LE(places[i].visible, places[j].visible);
            EXPECT_TRUE(std::abs(places[i].x - places[j].x) > 24 || std::abs(places[i].y - places[j].y) > 24);
        }
    }
    EXPECT_TRUE(WorstTexels().apart(4, 24).empty());
}

TEST(WorstPlaces, PicturesShowBakeCookedAndError) {
    const SmallScene scene{SmallScene::Parts::LightMap};
    scene.writeSceneFile("light_map_layout = \"basis-3\"\nmax_error = 0.9", "", "");
    const Outcome outcome = cookScene(scene.options(), RunState());
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    const Json& asset = outcome.report.at("assets").at(0);
    const Json& worst = asset.at("preview").at("worst");
    ASSERT_FALSE(worst.empty());
    // Without a white of its own, the display shows the map's key, which is its log-average luminance, at 18 % of white.
    const double key = asset.at("key").get<double>();
    double before = 1e9;
    for (const Json& place : worst) {
        double squared = 0;
        for (const Json& component : place.at("normal")) squared += component.get<double>() * component.get<double>();
        EXPECT_NEAR(squared, 1, 1e-3);
        EXPECT_LE(place.at("visible").get<double>(), before);
        before = place.at("visible").get<double>();
        const auto picture = formats::readImage(scene / "out" / place.at("file").get<std::string>());
        ASSERT_TRUE(picture.has_value());
        const int side = (picture->texels.width() - 2) / 3, height = picture->texels.height();
        const auto at = [&](const char* axis, int extent, int size) {
            const int texel = place.at("texel").at(axis[0] == 'x' ? 0 : 1).get<int>();
            return texel - std::clamp(texel - size / 2, 0, extent - size);
        };
        const int x = at("x", asset.at("width").get<int>(), side), y = at("y", asset.at("height").get<int>(), height);
        const auto expectColour = [&](const glm::vec4& pixel, const glm::u8vec3& wanted) {
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(255 * pixel[c], static_cast<float>(wanted[c]), 1.01f);
        };
        const auto lightOf = [&](const char* which) {
            const Json& light = place.at(which);
            return glm::vec3(light[0].get<float>(), light[1].get<float>(), light[2].get<float>());
        };
        expectColour(picture->texels.at(x, y), toneMapped(lightOf("reference"), key));
        expectColour(picture->texels.at(side + 1 + x, y), toneMapped(lightOf("found"), key));
        expectColour(picture->texels.at(2 * (side + 1) + x, y), heatOf(place.at("visible").get<float>()));
    }
}

/// Writes a wall of 1.2 x 7.2 units that shows the whole map, upright, to someone who looks along -z.
void writeWall(const SmallScene& scene) {
    std::string bytes;
    const auto add = [&](const auto& values) { bytes.append(reinterpret_cast<const char*>(values.data()), sizeof(values)); };
    add(std::array<float, 12>{0, 7.2f, 0, 0, 0, 0, 1.2f, 0, 0, 1.2f, 7.2f, 0});
    add(std::array<float, 8>{0, 0, 0, 1, 1, 1, 1, 0});
    add(std::array<std::uint16_t, 6>{0, 1, 2, 0, 2, 3});
    formats::writeContent(scene / "wall.bin", bytes);
    formats::writeContent(scene / "wall.gltf",
                          R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_1": 1}, "indices": 2}]}],
"buffers": [{"uri": "wall.bin", "byteLength": 92}],
"bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
  {"buffer": 0, "byteOffset": 80, "byteLength": 12}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1.2, 7.2, 0]},
  {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"}, {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}]})");
    const std::string text = formats::contentOf(scene.sceneFile()), file = "file = \"map.exr\"\n";
    const std::size_t at = text.find(file) + file.size();
    formats::writeContent(scene.sceneFile(), text.substr(0, at) + "mesh = \"wall.gltf\"\n" + text.substr(at));
}

TEST(WorstPlaces, RenderedViewsShowThePlaceInTheMiddle) {
    const SmallScene scene{SmallScene::Parts::LightMap};
    scene.writeSceneFile("light_map_layout = \"basis-3\"\nmax_error = 0.9", "", "");
    writeWall(scene);
    const Outcome outcome = cookScene(scene.options(), RunState());
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    const Json& asset = outcome.report.at("assets").at(0);
    const double key = asset.at("key").get<double>();
    const Json& worst = asset.at("preview").at("worst");
    ASSERT_FALSE(worst.empty());
    for (const Json& place : worst) {
        ASSERT_TRUE(place.contains("view"));
        const Json& view = place.at("view");
        // The wall has 10 texels a unit; the camera stands where 20 texels are half of the picture.
        EXPECT_NEAR(view.at("position")[0].get<double>(), (place.at("texel")[0].get<int>() + 0.5) / 10, 1e-6);
        EXPECT_NEAR(view.at("position")[1].get<double>(), 7.2 - (place.at("texel")[1].get<int>() + 0.5) / 10, 1e-6);
        EXPECT_NEAR(view.at("normal")[2].get<double>(), 1, 1e-9);
        EXPECT_NEAR(view.at("distance").get<double>(), 4, 1e-6);
        for (const char* which : {"reference", "cooked"}) {
            const auto picture = formats::readImage(scene / "out" / view.at(which).get<std::string>());
            ASSERT_TRUE(picture.has_value());
            const int middle = picture->texels.width() / 2;
            const Json& light = place.at(which == std::string("cooked") ? "found" : "reference");
            const glm::u8vec3 wanted = toneMapped({light[0].get<float>(), light[1].get<float>(), light[2].get<float>()}, key);
            // The pixel is within 0.15 texels of the centre of the texel; neighbours differ by a few codes.
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(255 * picture->texels.at(middle, middle)[c], static_cast<float>(wanted[c]), 6);
        }
    }
}

}  // namespace
}  // namespace lightcook::pipeline
