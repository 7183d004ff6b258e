// A requirement that a cooked asset breaks, as text. Violations fail a verification even if the asset's error figures pass.
#pragma once

#include <string>

#include "verify/figures.h"

namespace lightcook::verify {

struct Violation {
    std::string place;  ///< within the asset
    std::string found, expected;
    ErrorPlace at = {};  ///< worst sample, if there is one
};

}  // namespace lightcook::verify
