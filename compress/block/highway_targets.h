// Selects the instruction sets that the kernels are compiled for. Include it before any header of Highway.
// x86-64: AVX2 is the minimum that the whole program is built for, so nothing below it is compiled; better sets are chosen at run time.
// AArch64: NEON alone. Kernels keep vectors in structs, which the vectors of SVE, whose size is unknown to the compiler, do not allow.
#pragma once

#if defined(__x86_64__)
#define HWY_BASELINE_TARGETS HWY_AVX2
#elif defined(__aarch64__)
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#endif
