#include "pipeline/report/ci_rules.h"

#include <array>

#include "formats/vocabulary.h"
#include "pipeline/report/exit_codes.h"

namespace lightcook::pipeline {
namespace {

constexpr std::array kRules = {
    CiRuleInfo{.id = CiRule::UnchangedFiles,
               .name = "unchanged-files",
               .title = "UnchangedFiles",
               .brief = "The cooked files and their sources are those of the cook.",
               .help = "A file was edited, truncated or replaced after the cook, or a source changed since. Cook again. If only the place "
                       "of the sources changed, run `lightcook verify DIR --sources FOLDER`.",
               .isOfAsset = true},
    CiRuleInfo{.id = CiRule::Contract,
               .name = "contract",
               .title = "ManifestContract",
               .brief = "The manifest describes the asset as the shared shaders read it.",
               .help = "The entry of cooked.json was edited, or another version of lightcook wrote it. Cook again.",
               .isOfAsset = true},
    CiRuleInfo{.id = CiRule::FiniteFigures,
               .name = "finite-figures",
               .title = "FiniteFigures",
               .brief = "Every error figure of every stage is finite.",
               .help = "A reference of no light, or a value beyond the format, makes an error infinite. Look at the asset on the page "
                       "(report.html), and at the source with `lightcook info`.",
               .isOfAsset = true},
    CiRuleInfo{.id = CiRule::DiffuseError,
               .name = "diffuse-error",
               .title = "DiffuseError",
               .brief = "The error of diffuse shading is within the limit.",
               .help = "rel_rms of diffuse light is over max_error (light maps, meshes) or max_converter_error (other assets). Let the "
                       "layout be chosen (`light_map_layout = \"auto\"`), raise `effort`, or raise the limit.",
               .isOfAsset = true},
    CiRuleInfo{.id = CiRule::SpecularError,
               .name = "specular-error",
               .title = "SpecularError",
               .brief = "The error of specular shading is within the limit.",
               .help =
                   "rel_rms of specular light is over max_error (light maps, meshes) or max_converter_error (other assets). Let the "
                   "layout be chosen (`light_map_layout = \"auto\"`), for tables raise `views` and `rows`, raise `effort`, or raise the "
                   "limit.",
               .isOfAsset = true},
    CiRuleInfo{
        .id = CiRule::VisibleError,
        .name = "visible-error",
        .title = "VisibleError",
        .brief = "99 % of the visible errors are within the limit.",
        .help = "The asset looks different from its source: its visible error is over max_visible or max_converter_visible, or its "
                "proven bound over max_visible_bound. Of a light map, let the layout be chosen "
                "(`light_map_layout = \"auto\"`); else raise `effort`, raise the limit, or correct `[display]` if the game shows the scene "
                "darker.",
        .isOfAsset = true},
    CiRuleInfo{.id = CiRule::Seam,
               .name = "seam",
               .title = "Seam",
               .brief = "Light steps no further between charts that meet than in the bake, but for the limit.",
               .help = "Cooking adds a step over max_seam where two charts of the light map meet on its mesh. Let the layout be chosen "
                       "(`light_map_layout = \"auto\"`), raise `effort`, leave more padding between charts, or raise the limit.",
               .isOfAsset = true},
    CiRuleInfo{.id = CiRule::LocalError,
               .name = "local-error",
               .title = "LocalError",
               .brief = "No block, stage, level or vertex has an error that the figures of the whole asset average away.",
               .help = "One place lost its light although the whole asset is within its limit: usually a file that is not what the "
                       "manifest says. Look at the difference picture of report.html, then cook again.",
               .isOfAsset = true},
    CiRuleInfo{.id = CiRule::MemoryBudget,
               .name = "memory-budget",
               .title = "MemoryBudget",
               .brief = "The GPU memory of the scene is within its budget.",
               .help = "The assets need more GPU memory than `budget` allows. Raise `budget` or `max_error`, or look at `by_kind` in the "
                       "report for what takes the memory.",
               .isOfAsset = false},
    CiRuleInfo{.id = CiRule::Input,
               .name = "input",
               .title = "Input",
               .brief = "Every input can be read, is finite and of the right shape.",
               .help =
                   "A file is missing, damaged, not finite or of another shape. The message names file and place; `lightcook info FILE` "
                   "prints what it holds, and `--repair` replaces bad values.",
               .isOfAsset = false},
    CiRuleInfo{.id = CiRule::Request,
               .name = "request",
               .title = "Request",
               .brief = "Command line and scene file are valid.",
               .help = "The message names option, or line and column of the scene file, and what is expected there.",
               .isOfAsset = false},
    CiRuleInfo{.id = CiRule::Fault,
               .name = "fault",
               .title = "Fault",
               .brief = "The program ran to its end.",
               .help = "The run was interrupted, or the system failed (full disk, no permission), or lightcook has a fault of its own.",
               .isOfAsset = false},
};
static_assert(formats::isCompleteTable(kRules, CiRule::Fault));

}  // namespace

std::span<const CiRuleInfo> allCiRules() {
    return kRules;
}

const CiRuleInfo& info(CiRule rule) {
    return kRules.at(static_cast<std::size_t>(rule));
}

CiRule ruleOf(formats::ErrorCode code) {
    switch (exitCode(code)) {
        case 2:
            return CiRule::Request;
        case 3:
            return CiRule::Input;
        case 4:
            return CiRule::UnchangedFiles;
        case 5:
            return CiRule::MemoryBudget;
        default:
            return CiRule::Fault;
    }
}

}  // namespace lightcook::pipeline
