// A law that a cooked asset breaks, in words: what the figures of a whole asset would forgive.
#pragma once

#include <string>

namespace verify {

struct Violation {
    std::string place;  ///< inside the asset
    std::string found, expected;
};

}  // namespace verify
