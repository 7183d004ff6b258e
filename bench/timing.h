// How long an encoder takes for a picture, and how well it does.
#pragma once

#include <optional>

#include "bench/figures.h"
#include "bench/pictures.h"

namespace lightcook::bench {

struct Timing {
    double mpixPerCpuSecond = 0;  ///< one thread; processor time, so that other work on the machine does not count
    double mpixPerSecond2 = 0;    ///< two threads, wall clock: only of worth on a quiet machine
    double share = 1;             ///< of the picture's blocks that the figures are of: evenly spread ones where the whole took too long
    Figures figures;              ///< over the same share
    double wholeDb = 0;           ///< figures.psnrDb, or what it would be over the whole picture: see Control
};

/// An effort that encoded the whole picture. What another effort gains on a share of it over this one on the same share is taken for what
/// it gains on the whole.
struct Control {
    int effort = 0;
    double db = 0;
};

/// Best of a few runs.
/// secondsEach  about what one picture may take: slower efforts encode every k-th block
Timing timeEncoder(formats::PixelFormat format, int effort, const Picture& picture, double secondsEach,
                   const std::optional<Control>& control);

}  // namespace lightcook::bench
