// One scene, one lobe: cubemap, tables, dominant light, shader and verification of a scene have the lobe that its file names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "tests/pipeline/report_parts.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A scene with every kind of asset that has a lobe, cooked.
class LobeScene {
public:
    explicit LobeScene(const std::string& root) : scene_(SmallScene::Parts::All) {
        scene_.writeSceneFile("max_error = 0.05\nlight_map_layout = \"ratio\"\n", "", root);
        const RunState state;
        outcome_ = cookScene(scene_.options(), state);
    }
    const Outcome& outcome() const { return outcome_; }
    std::filesystem::path folder() const { return scene_ / "out"; }
    Json manifest() const { return readManifest(folder()).value(); }
    Json asset(const std::string& name) const { return assetOf(manifest(), name); }
    double whole() const { return outcome_.report.at("whole").at("rel_rms").get<double>(); }
    std::string shader() const { return formats::contentOf(folder() / kShaderName); }
    std::vector<formats::Error> verify() const {
        const RunState state;
        return verifyCooked({folder(), {}, {}}, state).errors;
    }

private:
    SmallScene scene_;
    Outcome outcome_;
};

TEST(LobeSoak, OfASceneIsThatOfEveryAssetAndTheWholeErrorIsAlike) {
    const LobeScene beckmann(""), ggx("lobe = \"ggx\"\n");
    for (const formats::Error& error : ggx.outcome().errors) ADD_FAILURE() << error.line();
    EXPECT_EQ(beckmann.manifest().at("lobe"), "beckmann");
    EXPECT_EQ(ggx.manifest().at("lobe"), "ggx");
    EXPECT_EQ(ggx.asset("specular").at("distribution"), "ggx");
    EXPECT_EQ(ggx.asset("probe").at("constants").at("kernel"), "ggx");
    for (const char* name : {"map", "map_dominant", "specular"}) EXPECT_EQ(ggx.asset(name).at("verify").at("shading").at("lobe"), "ggx");
    EXPECT_THAT(ggx.shader(), testing::StartsWith("// The specular lobe of this scene, for lcDistribution.\n#ifndef LIGHTCOOK_GGX"));
    EXPECT_THAT(beckmann.shader(), Not(HasSubstr("#define LIGHTCOOK_GGX\n#endif")));
    EXPECT_GT(ggx.whole(), 0.3 * beckmann.whole());
    EXPECT_LT(ggx.whole(), 1.5 * beckmann.whole());
    EXPECT_TRUE(ggx.verify().empty());
}

TEST(Lobe, BeckmannIsTheDefaultAndItsTexturesAreTheSame) {
    const LobeScene silent(""), named("lobe = \"beckmann\"\n");
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(silent.folder())) {
        if (entry.path().extension() != ".ktx2" && entry.path().extension() != ".glsl") continue;
        EXPECT_EQ(formats::contentOf(entry.path()), formats::contentOf(named.folder() / entry.path().filename())) << entry.path();
        ++files;
    }
    EXPECT_GT(files, 5);
}

}  // namespace
}  // namespace lightcook::pipeline
