#include "pipeline/estimate/cook_rates.h"

#include <array>

namespace lightcook::pipeline {
namespace {

using formats::LightMapLayout;

struct CookRate {
    LightMapLayout id;
    double secondsPerMegatexel;
};
constexpr std::array kCookRates = {
    CookRate{LightMapLayout::Raw, 3.4},      CookRate{LightMapLayout::Flat, 6.8},     CookRate{LightMapLayout::Ratio, 5.5},
    CookRate{LightMapLayout::Basis3, 9.7},   CookRate{LightMapLayout::Basis4, 9.8},   CookRate{LightMapLayout::Basis8, 10.9},
    CookRate{LightMapLayout::Basis12, 12.3}, CookRate{LightMapLayout::Basis16, 13.5}, CookRate{LightMapLayout::Basis20, 14.8},
    CookRate{LightMapLayout::Basis24, 16.5}, CookRate{LightMapLayout::Sh4, 7.3},      CookRate{LightMapLayout::Godot, 6.3},
    CookRate{LightMapLayout::MonoSh, 5.7},   CookRate{LightMapLayout::Bakery, 6.1},   CookRate{LightMapLayout::Hdr, 4.3},
    CookRate{LightMapLayout::Hdr2, 5.6},     CookRate{LightMapLayout::Halo3, 7.3},    CookRate{LightMapLayout::HdrRgb9e5, 4.6},
    CookRate{LightMapLayout::Flat2, 5.7},    CookRate{LightMapLayout::UnrealHq, 5.0}, CookRate{LightMapLayout::Rnm, 8.9},
    CookRate{LightMapLayout::Lit, 6.7},      CookRate{LightMapLayout::LitHalf, 5.9},  CookRate{LightMapLayout::LitQuarter, 5.7},
};
static_assert([] {
    for (std::size_t i = 0; i < kCookRates.size(); ++i)
        if (static_cast<std::size_t>(kCookRates[i].id) != i) return false;
    return kCookRates.size() == formats::allLightMapLayouts().size();
}());
constexpr double kTrialRate = 13;

}  // namespace

double measuredSecondsPerMegatexel(LightMapLayout layout) {
    return kCookRates.at(static_cast<std::size_t>(layout)).secondsPerMegatexel;
}

double measuredTrialSecondsPerMegatexel() {
    return kTrialRate;
}

}  // namespace lightcook::pipeline
