// The line of progress of a job.
#include "pipeline/command/terminal/progress.h"

#include <gmock/gmock.h>

#include "pipeline/assets/action_kind.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;
using testing::Not;

Action actionOf(const std::string& id) {
    return {id, id.substr(0, id.find('/')), id.substr(id.find('/') + 1), Json::object(), {}, {}};
}

TEST(Progress, AddsUpActionsAndPasses) {
    Progress progress;
    EXPECT_EQ(progress.fraction(), 0);
    const Action cook = actionOf("cook/map"), verify = actionOf("verify/map");
    for (const Action& action : {cook, verify}) progress.onEvent(action, ActionEvent::Planned);
    progress.onEvent(cook, ActionEvent::Started);
    progress.onPass(cook, "survey map", 1);
    EXPECT_DOUBLE_EQ(progress.fraction(), 0.5);
    progress.onPass(cook, "encode map", 0.25);
    EXPECT_DOUBLE_EQ(progress.fraction(), 0.5) << "a second pass of an action does not turn back";
    progress.onEvent(cook, ActionEvent::Finished);
    EXPECT_DOUBLE_EQ(progress.fraction(), 0.5);
    progress.onEvent(verify, ActionEvent::Started);
    progress.onPass(verify, "verify map", 0.5);
    EXPECT_DOUBLE_EQ(progress.fraction(), 0.75);
    EXPECT_EQ(progress.line(30, 100), "[##################......]  75 %  1/2 verify map 50 %  0:10 left");
    progress.onEvent(verify, ActionEvent::Reused);
    EXPECT_DOUBLE_EQ(progress.fraction(), 1);
    EXPECT_THAT(progress.line(40, 100), Not(HasSubstr("left")));
}

/// A trial takes longer than the cook and the verification of the layout that it finds, and lint next to nothing.
TEST(Progress, ExpectsTheTimeThatKindsOfActionsTake) {
    const formats::TemporaryFolder folder;
    formats::writeContent(folder / "map.exr", std::string(1 << 20, ' '));
    const auto workOfKind = [&](const char* kind) {
        Action action = actionOf("step/map");
        action.kind = kind;
        action.inputs = {{"source", folder / "map.exr"}};
        return workOf(action);
    };
    EXPECT_GT(workOfKind("joint-trial"), workOfKind("light-map") + workOfKind("verify-light-map"));
    EXPECT_GT(workOfKind("verify-light-map"), 3 * workOfKind("light-map"));
    EXPECT_LT(workOfKind("lint-light-map"), 0.1 * workOfKind("joint-trial"));
}

/// The bar would reach its end twice otherwise: nobody knows what a cook has to do before it has read the scene.
TEST(Progress, HasNoBarBeforeThePlanIsMade) {
    Progress progress;
    Action content = actionOf("content/map");
    content.kind = kContentKind;
    progress.onEvent(content, ActionEvent::Planned);
    progress.onEvent(content, ActionEvent::Started);
    progress.onPass(content, "survey the content of map", 0.5);
    EXPECT_EQ(progress.line(5, 100), "survey the content of map 50 %");
    progress.onEvent(actionOf("cook/map"), ActionEvent::Planned);
    EXPECT_THAT(progress.line(5, 100), testing::StartsWith("[######"));
}

TEST(Progress, CountsAnActionThatRunsAgain) {
    Progress progress;
    const Action cook = actionOf("cook/map"), verify = actionOf("verify/map");
    for (const Action& action : {cook, verify})
        for (const ActionEvent event : {ActionEvent::Planned, ActionEvent::Started, ActionEvent::Finished}) progress.onEvent(action, event);
    EXPECT_DOUBLE_EQ(progress.fraction(), 1);
    progress.onEvent(cook, ActionEvent::Started);
    EXPECT_DOUBLE_EQ(progress.fraction(), 2.0 / 4) << "its verification runs again, too";
    progress.onPass(cook, "encode map", 0.5);
    EXPECT_DOUBLE_EQ(progress.fraction(), 2.5 / 4);
    EXPECT_THAT(progress.line(30, 100), HasSubstr(" 2/4 encode map 50 %  0:18 left"));
    progress.onEvent(cook, ActionEvent::Finished);
    progress.onEvent(verify, ActionEvent::Started);
    EXPECT_DOUBLE_EQ(progress.fraction(), 3.0 / 4);
    progress.onEvent(verify, ActionEvent::Reused);
    EXPECT_DOUBLE_EQ(progress.fraction(), 1);
}

/// Estimates of the end move with each pass; what is shown counts down until they differ clearly.
TEST(Progress, CountsTheTimeLeftDown) {
    Progress progress;
    const Action cook = actionOf("cook/map");
    progress.onEvent(cook, ActionEvent::Started);
    const auto lineAt = [&](double seconds, double fraction) {
        progress.onPass(cook, "encode map", fraction);
        return progress.line(seconds, 100);
    };
    EXPECT_THAT(lineAt(20, 0.1), Not(HasSubstr("left"))) << "too early to tell";
    EXPECT_THAT(lineAt(50, 0.5), HasSubstr("0:50 left"));
    EXPECT_THAT(lineAt(60, 0.56), HasSubstr("0:40 left")) << "the new estimate, 0:47, is about the same";
    EXPECT_THAT(lineAt(90, 0.57), HasSubstr("1:08 left")) << "far from the 10 that are left of the first estimate";
}

TEST(Progress, ShowsControlCharactersOfNamesAsEscapes) {
    Progress progress;
    const Action action = actionOf("cook/lob\x1b[2Jby");
    progress.onEvent(action, ActionEvent::Started);
    EXPECT_THAT(progress.line(1, 100), HasSubstr("cook/lob\\x1b[2Jby 0 %"));
}

TEST(Progress, FitsTheTerminalAndKeepsTheTimeLeft) {
    Progress progress;
    for (int i = 0; i < 8; ++i) {
        const Action action = actionOf("cook/a-light-map-with-a-long-name-" + std::to_string(i));
        progress.onEvent(action, ActionEvent::Planned);
        progress.onEvent(action, ActionEvent::Started);
        progress.onPass(action, "encode " + action.asset, 0.5);
    }
    const std::string line = progress.line(5000, 80);
    EXPECT_LE(line.size(), 79u);
    EXPECT_THAT(line, testing::EndsWith("1:23:20 left"));
    EXPECT_THAT(progress.line(1, 80), Not(HasSubstr("left"))) << "too early to tell";
    EXPECT_LE(progress.line(5000, 20).size(), 19u);
}

}  // namespace
}  // namespace lightcook::pipeline
