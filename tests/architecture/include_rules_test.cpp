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

TEST(IncludeRules, EveryIncludeOfEveryRoomFollowsTheArrows) {
    const TreeCheck check = checkTree(LIGHTCOOK_SOURCE_DIR);
    EXPECT_THAT(check.violations, IsEmpty());
    for (const std::string& room : rooms()) {
        EXPECT_TRUE(std::any_of(check.read.begin(), check.read.end(), [&](const auto& file) { return *file.begin() == room; }))
            << "no source was read in room " << room;
    }
}

TEST(IncludeRules, ArrowsRunOneWay) {
    const auto allowed = [](const std::string& from, const std::string& to) {
        return checkIncludes(from + "/a.cpp", "#include \"" + to + "/b.h\"\n").empty();
    };
    const std::vector<std::string> middle = {"compress", "fit", "verify"};
    for (const std::string& room : middle) {
        EXPECT_TRUE(allowed("pipeline", room)) << room;
        EXPECT_FALSE(allowed(room, "pipeline")) << room;
        EXPECT_TRUE(allowed(room, "formats")) << room;
        EXPECT_FALSE(allowed("formats", room)) << room;
        for (const std::string& other : middle) EXPECT_EQ(allowed(room, other), room == other) << room << " -> " << other;
    }
    EXPECT_TRUE(allowed("formats", "lighting"));
    EXPECT_FALSE(allowed("lighting", "formats"));
    EXPECT_TRUE(allowed("verify", "shaders"));
    EXPECT_FALSE(allowed("shaders", "verify"));
    EXPECT_FALSE(allowed("compress", "shaders"));
    EXPECT_FALSE(allowed("fit", "shaders"));
    EXPECT_FALSE(allowed("formats", "shaders"));
}

TEST(IncludeRules, ALibraryAwayFromItsHomeIsFound) {
    const auto allowed = [](const std::string& room, const std::string& header) {
        return checkIncludes(room + "/a.cpp", "#include <" + header + ">\n").empty();
    };
    struct Home {
        std::string header;
        std::vector<std::string> homes;
    };
    const std::vector<Home> table = {
        {"OpenImageIO/imageio.h", {"formats"}},
        {"OpenEXR/ImfTiledInputFile.h", {"formats"}},
        {"OpenColorIO/OpenColorIO.h", {"formats"}},
        {"draco/compression/decode.h", {"formats"}},
        {"tiny_gltf.h", {"formats"}},
        {"ceres/tiny_solver.h", {"fit"}},
        {"hwy/highway.h", {"compress"}},
        {"astcenc.h", {"compress"}},
        {"tbb/parallel_for.h", {"pipeline"}},
        {"toml++/toml.h", {"pipeline"}},
        {"CLI/CLI.hpp", {"pipeline"}},
        {"nlohmann/json.hpp", {"formats", "pipeline"}},
        {"thread", {"pipeline"}},
        {"glm/vec3.hpp", rooms()},
        {"vector", rooms()},
        {"boost/any.hpp", {}},
        {"stb_image.h", {}},
    };
    for (const Home& home : table) {
        for (const std::string& room : rooms()) {
            const bool isHome = std::find(home.homes.begin(), home.homes.end(), room) != home.homes.end();
            EXPECT_EQ(allowed(room, home.header), isHome) << room << " -> " << home.header;
        }
    }
}

TEST(IncludeRules, QuotesAndBlanksDoNotHideAnInclude) {
    EXPECT_THAT(checkIncludes("fit/a.cpp", "\n  #  include\t\"verify/bound.h\"  // for one constant\r\n"),
                ElementsAre(Violation{"fit/a.cpp:2", "fit may not include verify/bound.h: room verify is not below fit"}));
    EXPECT_THAT(checkIncludes("fit/a.cpp", "#include \"OpenImageIO/imageio.h\""),
                ElementsAre(Violation{"fit/a.cpp:1", "fit may not include OpenImageIO/imageio.h: it lives in formats"}));
    EXPECT_THAT(checkIncludes("fit/a.cpp", "#include \"lobe.h\"\n"),
                ElementsAre(Violation{"fit/a.cpp:1", "fit may not include lobe.h: ours are included as room/file.h"}));
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
    plant("tests/verify/both_test.cpp", "#include \"compress/encode.h\"\n#include \"verify/texture/decode.h\"\n");
    EXPECT_THAT(checkTree(folder.path()).violations, IsEmpty());

    plant("verify/detail/decode.cpp", "#include <array>\n#include \"compress/encode.h\"\n");
    plant("lighting/load.h", "#include <filesystem>\n");
    EXPECT_THAT(checkTree(folder.path()).violations,
                ElementsAre(Violation{"lighting/load.h:1", "lighting may not include filesystem: it lives in formats, pipeline, verify"},
                            Violation{"verify/detail/decode.cpp:2",
                                      "verify may not include compress/encode.h: room compress is not below verify"}));
    EXPECT_THAT(checkTree(folder.path()).read,
                ElementsAre("formats/image.h", "lighting/load.h", "lighting/sh.h", "verify/detail/decode.cpp"));
}

}  // namespace
}  // namespace lightcook::architecture
