#include "compress/instruction_set.h"

#include "compress/block/highway_targets.h"
//
#include <hwy/highway.h>

namespace lightcook::compress {

void allowInstructionSet(InstructionSet set) {
    // Targets better than AVX2 are the bits under it; zero allows all that the processor has.
    hwy::DisableTargets(set == InstructionSet::Avx2 ? HWY_AVX2 - 1 : 0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace lightcook::compress
