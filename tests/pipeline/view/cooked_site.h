// A small scene, cooked, and a page that stands for the real one.
#pragma once

#include <gtest/gtest.h>

#include "pipeline/view/site.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {

inline constexpr BundledFile kPage[] = {{"index.html", "<!doctype html><title>page</title>"}, {"assets/page.js", "void 0;"}};

class CookedSite : public testing::Test {
protected:
    void SetUp() override {
        scene_.writeSceneFile("light_map_layout = \"ratio\"");
        const Outcome outcome = cookScene(scene_.options(), state_);
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    }
    std::filesystem::path folder() const { return scene_ / "out"; }
    formats::Result<Site> open() { return Site::open({folder(), {}, kPage}, state_); }

    SmallScene scene_{SmallScene::Parts::LightMap};
    RunState state_;
};

}  // namespace lightcook::pipeline
