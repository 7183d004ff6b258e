// Which vector instructions the encoders may use. The bytes do not depend on it; tests force each and compare.
#pragma once

namespace lightcook::compress {

enum class InstructionSet {
    Widest,  ///< the best that this processor has
    Avx2     ///< the floor that the program is built for
};

/// For the whole process, before any encoding.
void allowInstructionSet(InstructionSet set);

}  // namespace lightcook::compress
