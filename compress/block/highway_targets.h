// Selects the instruction sets that the kernels are compiled for. Include it before any header of Highway.
// AVX2 is the minimum that the whole program is built for, so nothing below it is compiled; better sets are chosen at run time.
#pragma once

#if defined(__x86_64__)
#define HWY_BASELINE_TARGETS HWY_AVX2
#endif
