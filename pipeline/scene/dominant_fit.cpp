#include "pipeline/scene/dominant_fit.h"

#include <fmt/format.h>

#include <array>

#include "formats/vocabulary.h"

namespace lightcook::pipeline {
namespace {

constexpr std::array kFits = {
    DominantFitInfo{"explained",
                    "the direction of least error, dimmed where one light explains little; the shader shades the rest as area specular",
                    fit::DominantFit::Explained, verify::DominantFit::Explained},
    DominantFitInfo{"halo3", "the direction of band 1, as in the Halo 3 paper", fit::DominantFit::Closed, verify::DominantFit::Closed},
    DominantFitInfo{"refined", "the direction of least error", fit::DominantFit::Refined, verify::DominantFit::Refined},
    DominantFitInfo{"refined-ambient", "the direction of least error beside ambient light", fit::DominantFit::RefinedAmbient,
                    verify::DominantFit::RefinedAmbient},
};

}  // namespace

std::span<const DominantFitInfo> allDominantFits() {
    return kFits;
}

const DominantFitInfo* dominantFitFromName(std::string_view name) {
    return formats::findByName(allDominantFits(), name);
}

formats::Result<const DominantFitInfo*> dominantFitOf(const std::string& asset, std::string_view name) {
    const DominantFitInfo* fit = dominantFitFromName(name);
    if (fit != nullptr) return fit;
    return formats::failure(formats::ErrorCode::Verification, asset + ", fit",
                            fmt::format("found \"{}\", expected {}", name, formats::listOfNames(allDominantFits())));
}

bool isDerivable(std::string_view fit) {
    const DominantFitInfo* const known = dominantFitFromName(fit);
    return known != nullptr && known->verified == verify::DominantFit::Explained;
}

}  // namespace lightcook::pipeline
