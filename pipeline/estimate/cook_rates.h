// Times of cooking light maps as they were measured once, for machines that have none of their own (WorkRates).
#pragma once

#include "formats/light_map_layout.h"

namespace lightcook::pipeline {

/// Returns the seconds for a million texels of cooking and verifying a light map in a layout, with effort 5 and two threads of a server
/// with AVX-512. They are CPU seconds over two, of the maps that docs/lab/pipeline.md names.
double measuredSecondsPerMegatexel(formats::LightMapLayout layout);
/// Returns those of the trial of layout "auto".
double measuredTrialSecondsPerMegatexel();

}  // namespace lightcook::pipeline
