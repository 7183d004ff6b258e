// Measures the speed and the quality of an encoder on a picture.
#pragma once

#include <optional>

#include "bench/figures.h"
#include "bench/pictures.h"

namespace lightcook::bench {

struct Timing {
    double mpixPerCpuSecond = 0;  ///< one thread; processor time, so that other work on the machine does not count
    double mpixPerSecond2 = 0;    ///< two threads, wall clock: meaningful only on a machine without other work
    double share = 1;             ///< share of the picture's blocks that was encoded: evenly spread ones if the whole takes too long
    Figures figures;              ///< over the same share
    double wholeDb = 0;           ///< figures.psnrDb, or an estimate of it for the whole picture: see Control
};

/// An effort that encoded the whole picture. A slower effort is measured on a share of the blocks: its gain over the control there is taken
/// as its gain on the whole picture.
struct Control {
    int effort = 0;
    double db = 0;
};

/// Measures an encoder: the best time of a few runs.
/// secondsEach  time limit for a picture, roughly: slower efforts encode every k-th block
Timing timeEncoder(formats::PixelFormat format, int effort, const Picture& picture, double secondsEach,
                   const std::optional<Control>& control);

}  // namespace lightcook::bench
