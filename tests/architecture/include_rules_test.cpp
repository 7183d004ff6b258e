#include "tests/architecture/include_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>

#include "tests/formats/temporary_folder.h"

namespace lightcook::architecture {

void PrintTo(const Violation& violation, std::ostream* out) {
    *out << violation.place << ": " << violation.what;
}

namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(IncludeRules, EveryIncludeFollowsTheRules) {
    const TreeCheck check = checkTree(LIGHTCOOK_SOURCE_DIR);
    EXPECT_THAT(check.violations, IsEmpty());
    for (const std::string& module : modules()) {
        EXPECT_TRUE(std::any_of(check.read.begin(), check.read.end(), [&](const auto& file) { return *file.begin() == module; }))
            << "no source was read in module " << module;
    }
}

TEST(IncludeRules, EveryExceptionIsNeeded) {
    EXPECT_THAT(unusedExceptions(checkTree(LIGHTCOOK_SOURCE_DIR)), IsEmpty());
    for (const IncludeException& row : includeExceptions()) EXPECT_FALSE(row.reason.empty()) << row.from;
}

TEST(IncludeRules, RootsOfModulesHoldOnlyHeadersThatOthersInclude) {
    EXPECT_THAT(rootViolations(LIGHTCOOK_SOURCE_DIR, checkTree(LIGHTCOOK_SOURCE_DIR)), IsEmpty());
}

TEST(IncludeRules, SubfoldersArePrivateToTheirModuleAndItsTests) {
    const auto allowed = [](const std::string& file, const std::string& header) {
        return checkIncludes(file, "#include \"" + header + "\"\n").empty();
    };
    EXPECT_TRUE(allowed("compress/bc6h/encode.cpp", "compress/block/lanes.h"));
    EXPECT_TRUE(allowed("tests/compress/bc6h/fast_test.cpp", "compress/block/lanes.h"));
    EXPECT_TRUE(allowed("tests/pipeline/cook/cook_test.cpp", "compress/encode.h"));
    EXPECT_TRUE(allowed("bench/encoders.cpp", "compress/encode.h"));
    EXPECT_FALSE(allowed("pipeline/cook/cook.cpp", "compress/block/lanes.h"));
    EXPECT_FALSE(allowed("tests/pipeline/cook/cook_test.cpp", "compress/block/lanes.h"));
    EXPECT_FALSE(allowed("tests/shaders/values_test.cpp", "lighting/sh/sh_inl.h"));
    EXPECT_FALSE(allowed("bench/encoders.cpp", "compress/block/lanes.h"));
    EXPECT_THAT(
        checkIncludes("bench/encoders.cpp", "#include \"compress/block/lanes.h\"\n"),
        ElementsAre(Violation{"bench/encoders.cpp:1",
                              "bench may not include compress/block/lanes.h: only the headers at the root of compress are public"}));
}

TEST(IncludeRules, ArrowsRunOneWay) {
    const auto allowed = [](const std::string& from, const std::string& to) {
        return checkIncludes(from + "/a.cpp", "#include \"" + to + "/b.h\"\n").empty();
    };
    const std::vector<std::string> middle = {"atlas", "compress", "fit", "verify"};
    for (const std::string& module : middle) {
        EXPECT_TRUE(allowed("pipeline", module)) << module;
        EXPECT_FALSE(allowed(module, "pipeline")) << module;
        EXPECT_TRUE(allowed(module, "formats")) << module;
        EXPECT_FALSE(allowed("formats", module)) << module;
        for (const std::string& other : middle) EXPECT_EQ(allowed(module, other), module == other) << module << " -> " << other;
    }
    EXPECT_TRUE(allowed("formats", "lighting"));
    EXPECT_FALSE(allowed("lighting", "formats"));
    EXPECT_TRUE(allowed("verify", "shaders"));
    EXPECT_FALSE(allowed("shaders", "verify"));
    EXPECT_FALSE(allowed("compress", "shaders"));
    EXPECT_FALSE(allowed("fit", "shaders"));
    EXPECT_FALSE(allowed("formats", "shaders"));
}

TEST(IncludeRules, FoldersOfPipelineHaveAnOrder) {
    const auto allowed = [](const std::string& from, const std::string& to) {
        return checkIncludes("pipeline/" + from + "/a.cpp", "#include \"pipeline/" + to + "/b.h\"\n").empty();
    };
    EXPECT_TRUE(allowed("cook", "assets"));
    EXPECT_TRUE(allowed("cook", "report"));
    EXPECT_TRUE(allowed("assets", "assets/light_map"));
    EXPECT_FALSE(allowed("assets/light_map", "repack"));
    EXPECT_FALSE(allowed("lint", "repack")) << "of one row";
    EXPECT_FALSE(allowed("scene", "assets"));
    EXPECT_FALSE(allowed("cook", "unknown"));
    EXPECT_THAT(checkIncludes("pipeline/report/a.cpp", "#include \"pipeline/cook/b.h\"\n"),
                ElementsAre(Violation{"pipeline/report/a.cpp:1",
                                      "pipeline may not include pipeline/cook/b.h: folder pipeline/cook does not come before "
                                      "pipeline/report"}));
}

TEST(IncludeRules, ALibraryAwayFromItsHomeIsFound) {
    const auto allowed = [](const std::string& module, const std::string& header) {
        return checkIncludes(module + "/a.cpp", "#include <" + header + ">\n").empty();
    };
    struct Home {
        std::string header;
        std::vector<std::string> homes;
    };
    const std::vector<Home> table = {
        {"OpenImageIO/imageio.h", {"formats"}},
        {"OpenEXR/ImfTiledInputFile.h", {"formats"}},
        {"png.h", {"formats"}},
        {"OpenColorIO/OpenColorIO.h", {"formats"}},
        {"draco/compression/decode.h", {"formats"}},
        {"ceres/tiny_solver.h", {"fit"}},
        {"hwy/highway.h", {"compress"}},
        {"astcenc.h", {"compress"}},
        {"tbb/parallel_for.h", {"pipeline"}},
        {"toml++/toml.h", {"pipeline"}},
        {"CLI/CLI.hpp", {"pipeline"}},
        {"httplib.h", {"pipeline"}},
        {"nlohmann/json.hpp", {"formats", "pipeline"}},
        {"thread", {"pipeline"}},
        {"glm/vec3.hpp", modules()},
        {"vector", modules()},
        {"boost/any.hpp", {}},
        {"stb_image.h", {}},
    };
    for (const Home& home : table) {
        for (const std::string& module : modules()) {
            const bool isHome = std::find(home.homes.begin(), home.homes.end(), module) != home.homes.end();
            EXPECT_EQ(allowed(module, home.header), isHome) << module << " -> " << home.header;
        }
    }
}

TEST(IncludeRules, QuotesAndBlanksDoNotHideAnInclude) {
    EXPECT_THAT(checkIncludes("fit/a.cpp", "\n  #  include\t\"verify/bound.h\"  // for one constant\r\n"),
                ElementsAre(Violation{"fit/a.cpp:2", "fit may not include verify/bound.h: module verify is not below fit"}));
    EXPECT_THAT(checkIncludes("fit/a.cpp", "#include \"OpenImageIO/imageio.h\""),
                ElementsAre(Violation{"fit/a.cpp:1", "fit may not include OpenImageIO/imageio.h: it lives in formats"}));
    EXPECT_THAT(checkIncludes("fit/a.cpp", "#include \"lobe.h\"\n"),
                ElementsAre(Violation{"fit/a.cpp:1", "fit may not include lobe.h: ours are included as module/file.h"}));
    EXPECT_THAT(checkIncludes("fit/a.cpp", "// #include \"verify/bound.h\" would be wrong here\nint includes = 0;\n"), IsEmpty());
    EXPECT_THAT(checkIncludes("shaders/shade.glsl", "#include \"sh.glsl\"\n"), IsEmpty());
}

TEST(IncludeRules, APlantedViolationIsFoundInATree) {
    const formats::TemporaryFolder folder;
    const auto plant = [&](const std::string& file, const std::string& text) {
        const std::filesystem::path path = folder.path() / file;
        std::filesystem::create_directories(path.parent_path());
        formats::writeContent(path, text);
    };
    plant("lighting/sh.h", "#include <glm/vec3.hpp>\n");
    plant("formats/image.h", "#include \"lighting/sh.h\"\n#include <OpenImageIO/imageio.h>\n");
    plant("tests/verify/both_test.cpp", "#include \"formats/image.h\"\n#include \"verify/texture/decode.h\"\n");
    plant("compress/encode.cpp", "#include \"lighting/sh.h\"\n");
    EXPECT_THAT(checkTree(folder.path()).violations, IsEmpty());
    EXPECT_THAT(rootViolations(folder.path(), checkTree(folder.path())),
                ElementsAre("compress/encode.cpp is no header: move it into a subfolder"));
    std::filesystem::remove(folder / "tests/verify/both_test.cpp");
    EXPECT_THAT(rootViolations(folder.path(), checkTree(folder.path())),
                ElementsAre("compress/encode.cpp is no header: move it into a subfolder",
                            "formats/image.h is included by nobody outside formats: move it into a subfolder"));
    std::filesystem::remove_all(folder / "compress");

    plant("verify/detail/decode.cpp", "#include <array>\n#include \"compress/encode.h\"\n");
    plant("lighting/load.h", "#include <filesystem>\n");
    EXPECT_THAT(checkTree(folder.path()).violations,
                ElementsAre(Violation{"lighting/load.h:1", "lighting may not include filesystem: it lives in formats, pipeline, verify"},
                            Violation{"verify/detail/decode.cpp:2",
                                      "verify may not include compress/encode.h: module compress is not below verify"}));
    EXPECT_THAT(checkTree(folder.path()).read,
                ElementsAre("formats/image.h", "lighting/load.h", "lighting/sh.h", "verify/detail/decode.cpp"));
}

}  // namespace
}  // namespace lightcook::architecture
