// The sources that the keys of cached results are made of (pipeline/CMakeLists.txt) include every one that an action's result can depend
// on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/architecture/include_rules.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::architecture {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;

const fs::path kTree = fs::path(LIGHTCOOK_SOURCE_DIR).lexically_normal();

/// Returns the sources of the digest, relative to the tree.
std::set<std::string> digestSources() {
    std::set<std::string> names;
    std::istringstream lines(formats::contentOf(LIGHTCOOK_DIGEST_SOURCES));
    for (std::string line; std::getline(lines, line);) names.insert(fs::path(line).lexically_relative(kTree).generic_string());
    return names;
}

/// Returns the sources below a header's folder that define its functions: those of the same name.
std::vector<std::string> sourcesOf(const fs::path& header) {
    std::vector<std::string> names;
    const fs::path source = fs::path(header.filename()).replace_extension(".cpp");
    for (const auto& entry : fs::recursive_directory_iterator(kTree / header.parent_path()))
        if (entry.path().filename() == source) names.push_back(entry.path().lexically_relative(kTree).generic_string());
    return names;
}

/// Returns the files of this repository that a source includes and, for a header, those that define its functions.
std::vector<std::string> neighboursOf(const std::string& file) {
    std::vector<std::string> names;
    for (const std::string& name : quotedIncludes(formats::contentOf(kTree / file))) {
        const std::string ours = fs::exists(kTree / name) ? name : (fs::path(file).parent_path() / name).generic_string();
        if (fs::exists(kTree / ours)) names.push_back(ours);
    }
    if (file.ends_with(".h"))
        for (const std::string& source : sourcesOf(fs::path(file))) names.push_back(source);
    return names;
}

/// Returns every file that can be reached from the table of asset kinds and from the sources of the actions.
std::set<std::string> reachedByActions() {
    std::vector<std::string> waiting = {"pipeline/assets/asset_kind.cpp"};
    for (const auto& entry : fs::recursive_directory_iterator(kTree / "pipeline/assets"))
        if (entry.is_regular_file()) waiting.push_back(entry.path().lexically_relative(kTree).generic_string());
    std::set<std::string> reached;
    while (!waiting.empty()) {
        const std::string file = waiting.back();
        waiting.pop_back();
        if (!reached.insert(file).second) continue;
        for (const std::string& name : neighboursOf(file)) waiting.push_back(name);
    }
    return reached;
}

TEST(DigestSources, HoldAllThatAnActionReaches) {
    const std::set<std::string> counted = digestSources(), reached = reachedByActions();
    for (const char* known :
         {"pipeline/assets/cubemap/verify.cpp", "pipeline/assets/light_map/ground_truth.cpp", "pipeline/assets/light_map/planner.cpp",
          "compress/block/encode.cpp", "fit/cubemap/cubemap.cpp", "lighting/sh/sh.cpp", "shaders/sh.glsl", "verify/error/figures.cpp"})
        EXPECT_TRUE(reached.contains(known)) << known;
    std::vector<std::string> forgotten;
    for (const std::string& name : reached)
        if (!counted.contains(name)) forgotten.push_back(name);
    EXPECT_THAT(forgotten, IsEmpty());
}

TEST(DigestSources, HoldEverySourceOfTheModulesBelow) {
    const std::set<std::string> counted = digestSources();
    std::vector<std::string> forgotten;
    for (const fs::path& file : checkTree(kTree).read)
        if (*file.begin() != "pipeline" && !counted.contains(file.generic_string())) forgotten.push_back(file.generic_string());
    EXPECT_THAT(forgotten, IsEmpty());
}

TEST(DigestSources, LeaveOutSourcesThatOnlyReportResults) {
    const std::set<std::string> counted = digestSources();
    for (const char* name : {"pipeline/command/main.cpp", "pipeline/report/page.cpp", "pipeline/report/page.h"})
        EXPECT_FALSE(counted.contains(name)) << name;
}

}  // namespace
}  // namespace lightcook::architecture
