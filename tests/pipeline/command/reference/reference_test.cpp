// Files generated from the command table: pages of docs/reference, the manual page and the completions.
#include "pipeline/command/reference/reference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "pipeline/command/command.h"
#include "pipeline/command/reference/completions.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/shell.h"

namespace lightcook::pipeline {
namespace {

using formats::contentOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::filesystem::path committedPage(const char* name) {
    return std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "docs" / "reference" / name;
}

TEST(ReferencePages, AreTheCommittedOnes) {
    for (const ReferencePage& page : referencePages())
        EXPECT_EQ(contentOf(committedPage(page.name.c_str())), page.text) << page.name << ": update it with: ./dev docs";
}

// "none" is a value of the scene file's key alone: the converter has nothing to write for it.
TEST(CommandReference, EveryCommandAndOptionIsDescribed) {
    const ProgramDoc program = describeProgram();
    std::set<std::string> names;
    for (const CommandDoc& command : program.commands) {
        EXPECT_TRUE(names.insert(command.name).second) << command.name;
        EXPECT_THAT(command.summary, Not(IsEmpty())) << command.name;
        EXPECT_TRUE(std::ranges::any_of(command.options, [](const OptionDoc& option) { return option.names.back() == "--json"; }))
            << command.name << " has no --json";
        for (const OptionDoc& option : command.options) {
            EXPECT_THAT(option.description, Not(IsEmpty())) << command.name << ' ' << option.names.front();
            if (option.value == OptionDoc::Value::Choice) {
                EXPECT_THAT(option.choices, Not(Contains(IsEmpty()))) << command.name << ' ' << option.names.front();
            }
        }
    }
    EXPECT_EQ(names.size(), allCommands().size());
}

TEST(CommandReference, OptionsAreListedOnlyWhereTheyAct) {
    const ProgramDoc program = describeProgram();
    const auto commandsWith = [&](const std::string& name) {
        std::vector<std::string> commands;
        for (const CommandDoc& command : program.commands)
            for (const OptionDoc& option : command.options)
                if (option.names.back() == name) commands.push_back(command.name);
        return commands;
    };
    EXPECT_THAT(commandsWith("--layout"), ElementsAre("cook", "estimate", "lightmap", "cubemap", "demo"));
    EXPECT_THAT(commandsWith("--budget"), ElementsAre("cook", "estimate", "lightmap", "dominant", "cubemap", "lut", "rsrm", "demo"));
    EXPECT_THAT(commandsWith("--max-converter-error"), ElementsAre("cook", "demo"));
    EXPECT_THAT(commandsWith("--max-converter-visible"), ElementsAre("cook", "demo"));
    EXPECT_THAT(commandsWith("--max-visible"), ElementsAre("cook", "repack", "lightmap", "dominant", "cubemap", "lut", "rsrm", "demo"));
    EXPECT_THAT(commandsWith("--max-visible-bound"), ElementsAre("cook", "lightmap", "dominant", "cubemap", "lut", "rsrm", "demo"));
    EXPECT_THAT(commandsWith("--max-converter-visible-bound"), ElementsAre("cook", "demo"));
    EXPECT_THAT(commandsWith("--phase"), ElementsAre("repack", "lightmap", "dominant", "compare"));
    EXPECT_THAT(commandsWith("--target"), ElementsAre("cook", "estimate", "lightmap", "dominant", "cubemap", "rsrm", "demo"));
    EXPECT_THAT(commandsWith("--max-error"), ElementsAre("cook", "lightmap", "dominant", "cubemap", "lut", "rsrm", "demo"));
}

TEST(ManPage, IsSetWithoutWarnings) {
    const formats::TemporaryFolder folder;
    const std::string page = manPage(describeProgram());
    for (const CommandInfo& command : allCommands()) EXPECT_THAT(page, HasSubstr(".SS lightcook " + std::string(command.name)));
    for (const char* section : {".TH LIGHTCOOK 1", ".SH NAME", ".SH SYNOPSIS", ".SH EXIT STATUS"}) EXPECT_THAT(page, HasSubstr(section));
    if (!isInstalled("groff")) GTEST_SKIP() << "no groff";
    formats::writeContent(folder / "lightcook.1", page);
    const std::string messages = (folder / "messages").string();
    EXPECT_EQ(runShell("groff -man -Tutf8 -ww -z '" + (folder / "lightcook.1").string() + "' 2>'" + messages + "'"), 0);
    EXPECT_EQ(contentOf(messages), "");
}

/// Runs the real bash on the words of a command line, of which the last is completed.
class BashCompletion : public testing::Test {
protected:
    BashCompletion() {
        formats::writeContent(folder_ / "lightcook.bash", bashCompletion(describeProgram()));
        formats::writeContent(folder_ / "sky.exr", "");
        std::filesystem::create_directories(folder_ / "cooked");
    }

    std::vector<std::string> complete(const std::string& words) const {
        const std::string script =
            "cd '" + (folder_ / "").string() + "' && source ./lightcook.bash && COMP_WORDS=(lightcook " + words +
            ") && COMP_CWORD=$((${#COMP_WORDS[@]} - 1)) && _lightcook && printf '%s\\n' \"${COMPREPLY[@]}\" >replies";
        formats::writeContent(folder_ / "script", script);
        EXPECT_EQ(runShell("bash --norc '" + (folder_ / "script").string() + "'"), 0) << words;
        std::vector<std::string> replies;
        std::istringstream lines(contentOf(folder_ / "replies"));
        for (std::string line; std::getline(lines, line);)
            if (!line.empty()) replies.push_back(line);
        return replies;
    }

    formats::TemporaryFolder folder_;
};

TEST_F(BashCompletion, OffersCommandsOptionsValuesAndFiles) {
    if (!isInstalled("bash")) GTEST_SKIP() << "no bash";
    EXPECT_THAT(complete("co"), ElementsAre("cook", "compare"));
    EXPECT_THAT(complete("''"), testing::SizeIs(allCommands().size()));
    EXPECT_THAT(complete("--lo"), ElementsAre("--log"));
    EXPECT_THAT(complete("--log ''"), ElementsAre("text", "json"));
    EXPECT_THAT(complete("-j 3 dec"), ElementsAre("decode"));
    EXPECT_THAT(complete("cook --ta"), ElementsAre("--target", "--targets"));
    EXPECT_THAT(complete("cook scene.toml --target ''"), ElementsAre("bc", "astc", "float"));
    EXPECT_THAT(complete("encode in.exr out.ktx2 --format bc6"), ElementsAre("bc6h-uf16", "bc6h-sf16"));
    EXPECT_THAT(complete("lut out --normalization ha"), ElementsAre("halo3"));
    EXPECT_THAT(complete("lut out --view-axis ''"), ElementsAre("auto", "NoV")) << "names with spaces are not offered";
    EXPECT_THAT(complete("decode --layout"), IsEmpty()) << "no option of decode";
    EXPECT_THAT(complete("rsrm sk"), ElementsAre("sky.exr"));
    EXPECT_THAT(complete("help co"), ElementsAre("cook", "compare")) << "commands, not the folder 'cooked'";
    EXPECT_THAT(complete("help --js"), ElementsAre("--json"));
    EXPECT_THAT(complete("cook scene.toml -o ''"), ElementsAre("cooked"));
    EXPECT_THAT(complete("cook scene.toml --effort ''"), IsEmpty());
}

TEST(ZshCompletion, IsValidAndKnowsEveryCommand) {
    const formats::TemporaryFolder folder;
    const std::string text = zshCompletion(describeProgram());
    EXPECT_TRUE(text.starts_with("#compdef lightcook\n"));
    for (const CommandInfo& command : allCommands())
        EXPECT_THAT(text, HasSubstr("\n                " + std::string(command.name) + ") _arguments"));
    if (!isInstalled("zsh")) GTEST_SKIP() << "no zsh";
    formats::writeContent(folder / "_lightcook", text);
    EXPECT_EQ(runShell("zsh -n '" + (folder / "_lightcook").string() + "'"), 0);
}

TEST(FishCompletion, IsValidAndKnowsEveryCommand) {
    const formats::TemporaryFolder folder;
    const std::string text = fishCompletion(describeProgram());
    for (const CommandInfo& command : allCommands()) EXPECT_THAT(text, HasSubstr(" -a " + std::string(command.name) + " -d "));
    if (!isInstalled("fish")) GTEST_SKIP() << "no fish";
    formats::writeContent(folder / "lightcook.fish", text);
    EXPECT_EQ(runShell("fish --no-execute '" + (folder / "lightcook.fish").string() + "'"), 0);
    const std::string offered = (folder / "offered").string(), messages = (folder / "messages").string();
    EXPECT_EQ(runShell("HOME='" + (folder / "").string() + "' fish --no-config -c \"source '" + (folder / "lightcook.fish").string() +
                       "'; complete -C 'lightcook cook --target '\" >'" + offered + "' 2>'" + messages + "'"),
              0);
    EXPECT_EQ(contentOf(messages), "");
    EXPECT_THAT(contentOf(offered), testing::AllOf(HasSubstr("astc"), HasSubstr("float"), Not(HasSubstr("verify"))));
}

}  // namespace
}  // namespace lightcook::pipeline
