// Instruction sets that the kernels are compiled for: include before any header of Highway.
// The floor is AVX2 (the whole program is built for it), so nothing below it is made; what lies above is chosen at run time.
#pragma once

#if defined(__x86_64__)
#define HWY_BASELINE_TARGETS HWY_AVX2
#endif
