/* C interface of a peer: a texture encoder in a shared object, which `./dev bench encoders --peers DIR` measures beside lightcook's own.
 *
 * A peer is a file `*.so` in DIR that exports the five functions below with C linkage. bench/example_peers/ holds one; the manual is
 * docs/guide/benchmark-peers.md. All strings are UTF-8, end in 0, belong to the peer and live as long as it is loaded. The functions are
 * called from one thread. Formats have the names of `lightcook encode --format`, for example "bc6h-uf16" or "astc-4x4-ldr". */
#ifndef LIGHTCOOK_BENCH_ENCODER_PEER_H
#define LIGHTCOOK_BENCH_ENCODER_PEER_H

/* A header of C: its include and its names are not those of our C++. NOLINTBEGIN */
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LIGHTCOOK_PEER_INTERFACE 1 /* version of this header */

/* Type of a texel that an encoder reads: four channels R, G, B, A, without padding. */
#define LIGHTCOOK_PEER_RGBA32F 1 /* floats: linear light of float formats, [0, 1] or [-1, 1] of others */
#define LIGHTCOOK_PEER_RGBA16F 2 /* IEEE halfs of the same, as uint16_t */
#define LIGHTCOOK_PEER_RGBA8 3   /* bytes, round(255 x); two's complement round(127 x) of signed formats */

/* Returns LIGHTCOOK_PEER_INTERFACE of the header that the peer was compiled with. */
int32_t lightcook_peer_interface(void);

/* Returns the name of the encoder, best with its version: "libsquish 1.15". */
const char* lightcook_peer_name(void);

/* Returns the name of the profile of this index (0, 1, ...), fastest first, or NULL past the last. A format that the peer does not encode
 * has none. */
const char* lightcook_peer_profile(const char* format, int32_t profile);

/* Returns one of LIGHTCOOK_PEER_RGBA*: the texels that lightcook_peer_encode() wants for this format. Conversion to them is not timed. */
int32_t lightcook_peer_texels(const char* format);

/* Encodes an image, with one thread. This call is what is timed.
 * texels  width * height texels, rows from the top, without gaps; width and height are multiples of the block size
 * blocks  receives the blocks, rows from the top, without gaps
 * Returns 0, or any other number for failure. */
int32_t lightcook_peer_encode(const char* format, int32_t profile, const void* texels, int32_t width, int32_t height, void* blocks);

#ifdef __cplusplus
}
#endif
/* NOLINTEND */
#endif
