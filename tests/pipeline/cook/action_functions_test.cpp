#include "pipeline/cook/action_functions.h"

#include <gmock/gmock.h>

#include <set>

#include "pipeline/assets/asset_kind.h"

namespace lightcook::pipeline {
namespace {

TEST(ActionFunction, EachAssetKindHasTwoOfItsOwn) {
    std::set<ActionFunction> functions;
    for (const AssetKindInfo& row : allAssetKinds()) {
        const std::string name(row.name);
        functions.insert({actionFunction(name), actionFunction("verify-" + name)});
    }
    EXPECT_EQ(functions.size(), 2 * allAssetKinds().size());
}

TEST(ActionFunction, OfAnUnknownKindFailsByName) {
    const Action action{"x/y", "verify-hologram", "y", {}, {}, {}};
    SharedObjects shared;
    const RunState state;
    const auto outcome = actionFunction(action.kind)({action, {}, {}, {}, shared, state});
    ASSERT_FALSE(outcome.has_value());
    EXPECT_THAT(outcome.error().line(), testing::HasSubstr("verify-hologram"));
}

}  // namespace
}  // namespace lightcook::pipeline
