// A repacked bake on its repacked mesh, against the bake on the mesh: by the triangles, with an interpolation of the test's own.
#include "pipeline/repack/repack.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>

#include "formats/gltf_scene.h"
#include "lighting/display.h"
#include "lighting/radiometry.h"
#include "pipeline/cook/cook.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/example_folder.h"
#include "verify/visible.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using lighting::ShRgb;
using testing::AllOf;
using testing::HasSubstr;

const fs::path kCornell = exampleFolder();

RepackRequest requestFor(const fs::path& folder, double maxVisible) {
    RepackRequest request;
    request.map = kCornell / "cornell_lightmap.exr";
    request.meshes = {kCornell / "cornell.glb"};
    request.folder = folder;
    request.maxVisible = maxVisible;
    return request;
}

struct Bake {
    formats::LightMapStrip texels;
    formats::GltfScene scene;
    glm::dvec2 size() const { return {texels.sh.width(), texels.sh.height()}; }
};
Bake read(const fs::path& map, const fs::path& mesh) {
    auto reader = formats::LightMapReader::open(map, {});
    EXPECT_TRUE(reader) << reader.error().line();
    return {*reader->read(0, reader->height()), *formats::GltfScene::load(mesh)};
}

/// Returns light filtered at a place [texels], in double. Places that are as good as texel centres read these alone.
ShRgb filtered(const Bake& bake, const glm::dvec2& place) {
    const auto split = [](double coordinate) {
        const double low = std::floor(coordinate - 0.5 + 1e-3);
        const double t = coordinate - 0.5 - low;
        return std::pair(static_cast<int>(low), t < 2e-3 ? 0.0 : t);
    };
    const auto [x, tx] = split(place.x);
    const auto [y, ty] = split(place.y);
    ShRgb sum{};
    for (int corner = 0; corner < 4; ++corner) {
        const double weight = (corner % 2 != 0 ? tx : 1 - tx) * (corner / 2 != 0 ? ty : 1 - ty);
        if (weight <= 0) continue;
        const ShRgb& texel = bake.texels.sh.at(std::clamp(x + corner % 2, 0, bake.texels.sh.width() - 1),
                                               std::clamp(y + corner / 2, 0, bake.texels.sh.height() - 1));
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<float>(weight) * texel[i];
    }
    return sum;
}

/// Calls visit(texel of the bake, light there, light of the repacked bake there) for each covered texel centre inside a triangle.
template <class Visit>
void forEachTexel(const Bake& before, const Bake& after, Visit visit) {
    const auto oldMeshes = before.scene.triangleMeshes(), newMeshes = after.scene.triangleMeshes();
    ASSERT_EQ(oldMeshes.size(), newMeshes.size());
    for (std::size_t mesh = 0; mesh < oldMeshes.size(); ++mesh) {
        ASSERT_EQ(oldMeshes[mesh]->indices, newMeshes[mesh]->indices);
        const formats::MeshAttribute &oldUv = *oldMeshes[mesh]->find("TEXCOORD_1"), &newUv = *newMeshes[mesh]->find("TEXCOORD_1");
        for (std::size_t i = 0; i < oldMeshes[mesh]->indices.size(); i += 3) {
            std::array<glm::dvec2, 3> from, to;
            for (std::size_t k = 0; k < 3; ++k) {
                from[k] = glm::dvec2(oldUv.at(oldMeshes[mesh]->indices[i + k])) * before.size();
                to[k] = glm::dvec2(newUv.at(oldMeshes[mesh]->indices[i + k])) * after.size();
            }
            const glm::dmat2 axes(from[1] - from[0], from[2] - from[0]);
            if (std::abs(glm::determinant(axes)) < 1e-9) continue;
            const glm::dmat2 inverse = glm::inverse(axes);
            const glm::dvec2 low = glm::min(from[0], glm::min(from[1], from[2])), high = glm::max(from[0], glm::max(from[1], from[2]));
            for (int y = static_cast<int>(low.y); y < std::min(high.y + 1, before.size().y); ++y)
                for (int x = static_cast<int>(low.x); x < std::min(high.x + 1, before.size().x); ++x) {
                    if (before.texels.covered.at(x, y) == 0) continue;
                    const glm::dvec2 at = inverse * (glm::dvec2(x, y) + 0.5 - from[0]);
                    if (at.x < -1e-6 || at.y < -1e-6 || at.x + at.y > 1 + 1e-6) continue;
                    visit(glm::ivec2(x, y), before.texels.sh.at(x, y),
                          filtered(after, to[0] + at.x * (to[1] - to[0]) + at.y * (to[2] - to[0])));
                }
        }
    }
}

TEST(Repack, ChartsThatAreMovedOnlyKeepEveryBit) {
    const formats::TemporaryFolder folder;
    const auto made = repack(requestFor(folder / "out", 0), RunState{});
    ASSERT_TRUE(made) << made.error().line();
    EXPECT_EQ(made->reducedCharts, 0u);
    EXPECT_EQ(made->relRms, 0);
    EXPECT_EQ(made->visible.max, 0);
    EXPECT_GE(made->read, made->readBefore) << "texels at the border of the bake, which is clamped there, are read twice elsewhere";
    EXPECT_LE(made->read, made->size.x * made->size.y);
    EXPECT_LE(made->readBefore, made->sizeBefore.x * made->sizeBefore.y);
    EXPECT_LT(made->size.x * made->size.y, made->sizeBefore.x * made->sizeBefore.y);
    const Bake before = read(kCornell / "cornell_lightmap.exr", kCornell / "cornell.glb"), after = read(made->map, made->meshes.front());
    int texels = 0;
    forEachTexel(before, after, [&](const glm::ivec2& at, const ShRgb& old, const ShRgb& found) {
        ++texels;
        EXPECT_EQ(found, old) << at.x << " " << at.y;
    });
    const auto covered = std::count(before.texels.covered.texels().begin(), before.texels.covered.texels().end(), 1);
    EXPECT_GE(texels, covered) << "every covered texel of the example lies in a triangle";
}

TEST(Repack, FewerTexelsStayWithinTheLimit) {
    const formats::TemporaryFolder folder;
    const auto made = repack(requestFor(folder / "out", 1), RunState{});
    ASSERT_TRUE(made) << made.error().line();
    EXPECT_GT(made->reducedCharts, 0u);
    EXPECT_LT(made->read, made->readBefore);
    EXPECT_LE(made->visible.p99, 1);
    EXPECT_GT(made->visible.max, 0);
    const Bake before = read(kCornell / "cornell_lightmap.exr", kCornell / "cornell.glb"), after = read(made->map, made->meshes.front());
    std::vector<double> luminances;
    const auto exit = [&](const ShRgb& sh, const glm::ivec2& at) {
        return glm::dvec3(lighting::evaluate(lighting::convolve(sh, lighting::kExitRadianceBands), before.texels.normal.at(at.x, at.y)));
    };
    for (int y = 0; y < before.texels.sh.height(); ++y)
        for (int x = 0; x < before.texels.sh.width(); ++x)
            if (before.texels.covered.at(x, y) != 0)
                luminances.push_back(glm::dot(exit(before.texels.sh.at(x, y), {x, y}), glm::dvec3(0.2126, 0.7152, 0.0722)));
    const lighting::Display display = lighting::DisplaySettings{}.of(verify::displayKeyOf(luminances));
    std::vector<double> visible;
    forEachTexel(before, after, [&](const glm::ivec2& at, const ShRgb& old, const ShRgb& found) {
        visible.push_back(lighting::visibleDifference(exit(old, at), exit(found, at), display));
    });
    std::sort(visible.begin(), visible.end());
    EXPECT_LE(visible[visible.size() * 99 / 100], 1);
    EXPECT_LE(visible.back(), made->visible.max * 1.01 + 0.01);
    EXPECT_GT(visible.back(), 0);
}

TEST(Repack, ChartsStayWhereTheyAreIfTheMapGetsNoSmaller) {
    const formats::TemporaryFolder folder;
    RepackRequest request = requestFor(folder / "0", 0);
    auto made = repack(request, RunState{});
    ASSERT_TRUE(made) << made.error().line();
    // Each round packs the map of the last one, until no texel is gained.
    for (int round = 1; made->size != made->sizeBefore; ++round) {
        ASSERT_LT(round, 5);
        request.map = made->map;
        request.meshes = made->meshes;
        request.folder = folder / std::to_string(round);
        const glm::ivec2 size = made->size;
        made = repack(request, RunState{});
        ASSERT_TRUE(made) << made.error().line();
        ASSERT_LE(made->size.x * made->size.y, size.x * size.y);
    }
    EXPECT_EQ(made->read, made->readBefore);
    EXPECT_LE(made->read, made->size.x * made->size.y) << "a chart at the border reads no texel beyond it";
    const Bake before = read(request.map, request.meshes.front()), after = read(made->map, made->meshes.front());
    EXPECT_EQ(made->reducedCharts, 0u);
    for (std::size_t i = 0; i < before.texels.sh.texels().size(); ++i)
        if (before.texels.covered.texels()[i] != 0) {
            ASSERT_EQ(after.texels.sh.texels()[i], before.texels.sh.texels()[i]) << i;
        }
    const formats::MeshAttribute &old = *before.scene.triangleMeshes().front()->find("TEXCOORD_1"),
                                 &now = *after.scene.triangleMeshes().front()->find("TEXCOORD_1");
    for (std::size_t vertex = 0; vertex < before.scene.triangleMeshes().front()->vertexCount(); ++vertex)
        for (int axis = 0; axis < 2; ++axis) ASSERT_NEAR(now.at(vertex)[axis], old.at(vertex)[axis], 1e-6) << vertex;
}

TEST(Repack, TheResultIsTheSameAtAnyNumberOfThreadsAndCooks) {
    const formats::TemporaryFolder folder;
    for (const int threads : {1, 2}) {
        tbb::task_arena arena(threads);
        arena.execute([&] { ASSERT_TRUE(repack(requestFor(folder / (threads == 1 ? "a" : "b"), 2), RunState{})); });
    }
    for (const char* name : {"cornell_lightmap.exr", "cornell.glb"})
        EXPECT_EQ(formats::contentOf(folder / "a" / name), formats::contentOf(folder / "b" / name));
    std::ofstream(folder / "scene.toml")
        << "schema = 1\nname = \"box\"\n[[light_map]]\nname = \"map\"\nfile = \"a/cornell_lightmap.exr\"\nmesh = \"a/cornell.glb\"\n";
    CookOptions options;
    options.scene = folder / "scene.toml";
    options.output = folder / "cooked";
    const Outcome outcome = cookScene(options, RunState{});
    EXPECT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
}

TEST(Repack, InputsAreNotReplacedAndFaultsLeaveNothing) {
    const formats::TemporaryFolder folder;
    fs::copy_file(kCornell / "cornell.glb", folder / "cornell.glb");
    RepackRequest request = requestFor(folder.path(), 1);
    request.meshes = {folder / "cornell.glb"};
    const auto replaced = repack(request, RunState{});
    ASSERT_FALSE(replaced);
    EXPECT_THAT(replaced.error().line(), HasSubstr("found an input, expected a folder other than that of the inputs"));

    request = requestFor(folder / "out", 1);
    request.meshes.push_back(request.meshes.front());
    const auto twice = repack(request, RunState{});
    ASSERT_FALSE(twice);
    EXPECT_THAT(twice.error().line(), HasSubstr("found two inputs of this name"));

    request = requestFor(folder.path(), 1);
    request.keepsOthers = true;
    const auto foreign = repack(request, RunState{});
    ASSERT_FALSE(foreign);
    EXPECT_THAT(foreign.error().line(), HasSubstr("cornell.glb: found a file that no repack wrote, expected none of this name"));
    EXPECT_FALSE(fs::exists(folder / "cornell_lightmap.exr"));

    RunState interrupted;
    interrupted.interrupted = true;
    const auto stopped = repack(requestFor(folder / "out", 1), interrupted);
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, formats::ErrorCode::Interrupted);
    EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(Repack, FilesOfAnEarlierRepackAreReplaced) {
    const formats::TemporaryFolder folder;
    RepackRequest request = requestFor(folder.path(), 0);
    request.keepsOthers = true;
    ASSERT_TRUE(repack(request, RunState{}));
    EXPECT_EQ(formats::contentOf(folder / kRepackedListName), "[\n \"cornell.glb\",\n \"cornell_lightmap.exr\"\n]\n");
    const auto again = repack(request, RunState{});
    EXPECT_TRUE(again) << again.error().line();

    formats::writeContent(folder / kRepackedListName, "{}");
    const auto other = repack(request, RunState{});
    ASSERT_FALSE(other);
    EXPECT_THAT(other.error().line(), HasSubstr("repacked.json: found a file that no repack wrote"));
}

TEST(Repack, ATriangleWithoutAreaInTheMapIsNamed) {
    const formats::TemporaryFolder folder;
    const auto scene = formats::GltfScene::load(kCornell / "cornell.glb");
    ASSERT_TRUE(scene);
    // A quarter of the triangles lose their light-map UVs: all of their vertices go to one place.
    std::vector<std::vector<glm::vec2>> uvs;
    for (const formats::TriangleMesh* mesh : scene->triangleMeshes()) {
        std::vector<glm::vec2>& made = uvs.emplace_back();
        for (std::size_t vertex = 0; vertex < mesh->vertexCount(); ++vertex) made.emplace_back(mesh->find("TEXCOORD_1")->at(vertex));
        for (std::size_t i = 0; i < mesh->indices.size() / 4; ++i) made[mesh->indices[i]] = made[mesh->indices[0]];
    }
    ASSERT_TRUE(scene->writeLightMapUvs(folder / "flat.glb", uvs));
    RepackRequest request = requestFor(folder / "out", 0);
    request.meshes = {folder / "flat.glb"};
    const auto refused = repack(request, RunState{});
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().line(),
                AllOf(HasSubstr("covered texels of cornell_lightmap.exr that no triangle reads, expected all meshes that use the bake; "),
                      HasSubstr("flat.glb, primitive 0, triangle 0 has an area in the world and none in TEXCOORD_1")));
}

}  // namespace
}  // namespace lightcook::pipeline
