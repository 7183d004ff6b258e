// A law that a cooked asset breaks, in words: what the figures of a whole asset would forgive.
#pragma once

#include <string>

#include "verify/figures.h"

namespace lightcook::verify {

struct Violation {
    std::string place;  ///< inside the asset
    std::string found, expected;
    ErrorPlace at = {};  ///< its worst sample, where there is one
};

}  // namespace lightcook::verify
