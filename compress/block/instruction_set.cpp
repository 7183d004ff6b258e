#include "compress/encode_options.h"

#include "compress/block/highway_targets.h"

#include <hwy/highway.h>

namespace lightcook::compress {

void allowInstructionSet(InstructionSet set) {
    // Better targets than AVX2 have lower bits. Zero disables none.
    hwy::DisableTargets(set == InstructionSet::Avx2 ? HWY_AVX2 - 1 : 0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace lightcook::compress
