// BC6H and BC7 on the CPU, for browsers without EXT_texture_compression_bptc. After the Khronos Data Format Specification 1.3, chapter 20.
//
// Bits of a block are read from the lowest up. BC6H: the header's fields are given by mode as runs of bits; endpoints are deltas of the
// first one in the transformed modes. BC7: a table of field widths by mode. Both: a partition says which subset a texel belongs to, and
// the index of each subset's anchor texel has one bit less.

/** BC6H modes: lowest bits, subsets, transformed, bits of an endpoint, bits of the deltas of R, G, B, then the header. "g2:4" is bit 4 of
 * endpoint 2 of green, "r0+10" bits 0 to 9 of endpoint 0 of red.
 * @type {[number, number, boolean, number, number[], string][]} */
const MODES6 = [
  [0, 2, true, 10, [5, 5, 5],
    "g2:4 b2:4 b3:4 r0+10 g0+10 b0+10 r1+5 g3:4 g2+4 g1+5 b3:0 g3+4 b1+5 b3:1 b2+4 r2+5 b3:2 r3+5 b3:3"],
  [1, 2, true, 7, [6, 6, 6],
    "g2:5 g3:4 g3:5 r0+7 b3:0 b3:1 b2:4 g0+7 b2:5 b3:2 g2:4 b0+7 b3:3 b3:5 b3:4 r1+6 g2+4 g1+6 g3+4 b1+6 b2+4 r2+6 r3+6"],
  [2, 2, true, 11, [5, 4, 4],
    "r0+10 g0+10 b0+10 r1+5 r0:10 g2+4 g1+4 g0:10 b3:0 g3+4 b1+4 b0:10 b3:1 b2+4 r2+5 b3:2 r3+5 b3:3"],
  [6, 2, true, 11, [4, 5, 4],
    "r0+10 g0+10 b0+10 r1+4 r0:10 g3:4 g2+4 g1+5 g0:10 g3+4 b1+4 b0:10 b3:1 b2+4 r2+4 b3:0 b3:2 r3+4 g2:4 b3:3"],
  [10, 2, true, 11, [4, 4, 5],
    "r0+10 g0+10 b0+10 r1+4 r0:10 b2:4 g2+4 g1+4 g0:10 b3:0 g3+4 b1+5 b0:10 b2+4 r2+4 b3:1 b3:2 r3+4 b3:4 b3:3"],
  [14, 2, true, 9, [5, 5, 5],
    "r0+9 b2:4 g0+9 g2:4 b0+9 b3:4 r1+5 g3:4 g2+4 g1+5 b3:0 g3+4 b1+5 b3:1 b2+4 r2+5 b3:2 r3+5 b3:3"],
  [18, 2, true, 8, [6, 5, 5],
    "r0+8 g3:4 b2:4 g0+8 b3:2 g2:4 b0+8 b3:3 b3:4 r1+6 g2+4 g1+5 b3:0 g3+4 b1+5 b3:1 b2+4 r2+6 r3+6"],
  [22, 2, true, 8, [5, 6, 5],
    "r0+8 b3:0 b2:4 g0+8 g2:5 g2:4 b0+8 g3:5 b3:4 r1+5 g3:4 g2+4 g1+6 g3+4 b1+5 b3:1 b2+4 r2+5 b3:2 r3+5 b3:3"],
  [26, 2, true, 8, [5, 5, 6],
    "r0+8 b3:1 b2:4 g0+8 b2:5 g2:4 b0+8 b3:5 b3:4 r1+5 g3:4 g2+4 g1+5 b3:0 g3+4 b1+6 b2+4 r2+5 b3:2 r3+5 b3:3"],
  [30, 2, false, 6, [6, 6, 6],
    "r0+6 g3:4 b3:0 b3:1 b2:4 g0+6 g2:5 b2:5 b3:2 g2:4 b0+6 g3:5 b3:3 b3:5 b3:4 r1+6 g2+4 g1+6 g3+4 b1+6 b2+4 r2+6 r3+6"],
  [3, 1, false, 10, [10, 10, 10],
    "r0+10 g0+10 b0+10 r1+10 g1+10 b1+10"],
  [7, 1, true, 11, [9, 9, 9],
    "r0+10 g0+10 b0+10 r1+9 r0:10 g1+9 g0:10 b1+9 b0:10"],
  [11, 1, true, 12, [8, 8, 8],
    "r0+10 g0+10 b0+10 r1+8 r0:11 r0:10 g1+8 g0:11 g0:10 b1+8 b0:11 b0:10"],
  [15, 1, true, 16, [4, 4, 4],
    "r0+10 g0+10 b0+10 r1+4 r0:15 r0:14 r0:13 r0:12 r0:11 r0:10 g1+4 g0:15 g0:14 g0:13 g0:12 g0:11 g0:10 b1+4 b0:15 b0:14 b0:13 b0:12 b0:11 b0:10"],
];

/** Two subsets: bit i is the subset of texel i. */
const TWO_SUBSETS = [
  0xcccc, 0x8888, 0xeeee, 0xecc8, 0xc880, 0xfeec, 0xfec8, 0xec80, 0xc800, 0xffec, 0xfe80, 0xe800,
  0xffe8, 0xff00, 0xfff0, 0xf000, 0xf710, 0x008e, 0x7100, 0x08ce, 0x008c, 0x7310, 0x3100, 0x8cce,
  0x088c, 0x3110, 0x6666, 0x366c, 0x17e8, 0x0ff0, 0x718e, 0x399c, 0xaaaa, 0xf0f0, 0x5a5a, 0x33cc,
  0x3c3c, 0x55aa, 0x9696, 0xa55a, 0x73ce, 0x13c8, 0x324c, 0x3bdc, 0x6996, 0xc33c, 0x9966, 0x0660,
  0x0272, 0x04e4, 0x4e40, 0x2720, 0xc936, 0x936c, 0x39c6, 0x639c, 0x9336, 0x9cc6, 0x817e, 0xe718,
  0xccf0, 0x0fcc, 0x7744, 0xee22,
];
const TWO_ANCHORS = [
  15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 2, 8, 2, 2, 8, 8, 15, 2, 8,
  2, 2, 8, 8, 2, 2, 15, 15, 6, 8, 2, 8, 15, 15, 2, 8, 2, 2, 2, 15, 15, 6, 6, 2, 6, 8, 15, 15, 2, 2,
  15, 15, 15, 15, 15, 2, 2, 15,
];
/** Three subsets: two bits a texel. */
const THREE_SUBSETS = [
  0xaa685050, 0x6a5a5040, 0x5a5a4200, 0x5450a0a8, 0xa5a50000, 0xa0a05050, 0x5555a0a0, 0x5a5a5050,
  0xaa550000, 0xaa555500, 0xaaaa5500, 0x90909090, 0x94949494, 0xa4a4a4a4, 0xa9a59450, 0x2a0a4250,
  0xa5945040, 0x0a425054, 0xa5a5a500, 0x55a0a0a0, 0xa8a85454, 0x6a6a4040, 0xa4a45000, 0x1a1a0500,
  0x0050a4a4, 0xaaa59090, 0x14696914, 0x69691400, 0xa08585a0, 0xaa821414, 0x50a4a450, 0x6a5a0200,
  0xa9a58000, 0x5090a0a8, 0xa8a09050, 0x24242424, 0x00aa5500, 0x24924924, 0x24499224, 0x50a50a50,
  0x500aa550, 0xaaaa4444, 0x66660000, 0xa5a0a5a0, 0x50a050a0, 0x69286928, 0x44aaaa44, 0x66666600,
  0xaa444444, 0x54a854a8, 0x95809580, 0x96969600, 0xa85454a8, 0x80959580, 0xaa141414, 0x96960000,
  0xaaaa1414, 0xa05050a0, 0xa0a5a5a0, 0x96000000, 0x40804080, 0xa9a8a9a8, 0xaaaaaa44, 0x2a4a5254,
];
const THREE_ANCHORS_2 = [
  3, 3, 15, 15, 8, 3, 15, 15, 8, 8, 6, 6, 6, 5, 3, 3, 3, 3, 8, 15, 3, 3, 6, 10, 5, 8, 8, 6, 8, 5,
  15, 15, 8, 15, 3, 5, 6, 10, 8, 15, 15, 3, 15, 5, 15, 15, 15, 15, 3, 15, 5, 5, 5, 8, 5, 10, 5, 10,
  8, 13, 15, 12, 3, 3,
];
const THREE_ANCHORS_3 = [
  15, 8, 8, 3, 15, 15, 3, 8, 15, 15, 15, 15, 15, 15, 15, 8, 15, 8, 15, 3, 15, 8, 15, 8, 3, 15, 6,
  10, 15, 15, 10, 8, 15, 3, 15, 10, 10, 8, 9, 10, 6, 15, 8, 15, 3, 6, 6, 8, 15, 3, 15, 15, 15, 15,
  15, 15, 15, 15, 15, 15, 3, 15, 15, 8,
];
/** Weights of the second endpoint in 64ths, by bits of an index. @type {Record<number, number[]>} */
const WEIGHTS = {
  2: [0, 21, 43, 64],
  3: [0, 9, 18, 27, 37, 46, 55, 64],
  4: [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64],
};

/** @typedef {{ subset: Uint8Array, anchors: number[] }} Partition */

/** @type {Partition[][]} Partitions by number of subsets. */
const PARTITIONS = [[], [{ subset: new Uint8Array(16), anchors: [0] }], [], []];
for (let i = 0; i < 64; ++i) {
  PARTITIONS[2].push({ subset: Uint8Array.from({ length: 16 }, (_, t) => (TWO_SUBSETS[i] >> t) & 1), anchors: [0, TWO_ANCHORS[i]] });
  PARTITIONS[3].push({
    subset: Uint8Array.from({ length: 16 }, (_, t) => (THREE_SUBSETS[i] >>> (2 * t)) & 3),
    anchors: [0, THREE_ANCHORS_2[i], THREE_ANCHORS_3[i]],
  });
}

/** Reads the bits of a block from the lowest up. */
class Bits {
  /** @param {Uint8Array} bytes @param {number} at */
  constructor(bytes, at) {
    this.bytes = bytes;
    this.next = 8 * at;
  }
  /** @param {number} count at most 16 */
  take(count) {
    let value = 0;
    for (let i = 0; i < count; ++i, ++this.next) value |= ((this.bytes[this.next >> 3] >> (this.next & 7)) & 1) << i;
    return value;
  }
}

/** @typedef {{ subsets: number, transformed: boolean, bits: number, deltas: number[], runs: number[][] }} Mode6 */

/** @type {(Mode6 | undefined)[]} BC6H modes by the lowest five bits. */
const MODE_OF = [];
for (const [lowest, subsets, transformed, bits, deltas, header] of MODES6) {
  const runs = header.split(" ").map((run) => {
    const [, channel, endpoint, bit, count] = /** @type {RegExpExecArray} */ (/^([rgb])(\d)(?::(\d+))?(?:\+(\d+))?$/.exec(run));
    return [3 * Number(endpoint) + "rgb".indexOf(channel), Number(bit ?? 0), Number(count ?? 1)];
  });
  const mode = { subsets, transformed, bits, deltas, runs };
  if (lowest < 2) for (let high = 0; high < 8; ++high) MODE_OF[lowest | (high << 2)] = mode;
  else MODE_OF[lowest] = mode;
}

/** @param {number} value @param {number} bits */
function signExtend(value, bits) {
  return (value << (32 - bits)) >> (32 - bits);
}

/** @param {number} value @param {number} bits @param {boolean} signed */
function unquantize(value, bits, signed) {
  if (!signed) {
    if (bits >= 15 || value === 0) return value;
    return value === (1 << bits) - 1 ? 0xffff : ((value << 16) + 0x8000) >>> bits;
  }
  if (bits >= 16 || value === 0) return value;
  const magnitude = Math.abs(value);
  const wide = magnitude >= (1 << (bits - 1)) - 1 ? 0x7fff : ((magnitude << 15) + 0x4000) >> (bits - 1);
  return value < 0 ? -wide : wide;
}

/** Decodes a block of 16 bytes to 16 texels of four halves.
 * @param {Uint8Array} bytes @param {number} at @param {Uint16Array} out 64 halves @param {boolean} signed */
export function decodeBc6hBlock(bytes, at, out, signed) {
  const bits = new Bits(bytes, at);
  const mode = MODE_OF[bytes[at] & 31];
  for (let t = 0; t < 16; ++t) out.set([0, 0, 0, 0x3c00], 4 * t);
  if (!mode) return;
  bits.take((bytes[at] & 2) === 0 ? 2 : 5);
  const fields = new Array(12).fill(0);
  for (const [field, lowest, count] of mode.runs) fields[field] |= bits.take(count) << lowest;
  const partition = PARTITIONS[mode.subsets][mode.subsets === 2 ? bits.take(5) : 0];
  const mask = (1 << mode.bits) - 1;
  const ends = fields.map((stored, f) => {
    let value = stored;
    if (mode.transformed && f >= 3) value = (fields[f % 3] + signExtend(value, mode.deltas[f % 3])) & mask;
    return unquantize(signed ? signExtend(value, mode.bits) : value, mode.bits, signed);
  });
  const indexBits = mode.subsets === 2 ? 3 : 4;
  for (let t = 0; t < 16; ++t) {
    const subset = partition.subset[t];
    const weight = WEIGHTS[indexBits][bits.take(indexBits - (partition.anchors.includes(t) ? 1 : 0))];
    for (let c = 0; c < 3; ++c) {
      const mixed = (ends[6 * subset + c] * (64 - weight) + ends[6 * subset + 3 + c] * weight + 32) >> 6;
      if (!signed) out[4 * t + c] = (mixed * 31) >> 6;
      else if (mixed >= 0) out[4 * t + c] = (mixed * 31) >> 5;
      else out[4 * t + c] = (-mixed * 31) >> 5 === 0 ? 0 : 0x8000 | ((-mixed * 31) >> 5);
    }
  }
}

/** BC7 modes: subsets, bits of partition, rotation, index selection, colour, alpha, p-bits of each endpoint, shared p-bits, index bits,
 * bits of the second index. */
const MODES7 = [
  [3, 4, 0, 0, 4, 0, 1, 0, 3, 0],
  [2, 6, 0, 0, 6, 0, 0, 1, 3, 0],
  [3, 6, 0, 0, 5, 0, 0, 0, 2, 0],
  [2, 6, 0, 0, 7, 0, 1, 0, 2, 0],
  [1, 0, 2, 1, 5, 6, 0, 0, 2, 3],
  [1, 0, 2, 0, 7, 8, 0, 0, 2, 2],
  [1, 0, 0, 0, 7, 7, 1, 0, 4, 0],
  [2, 6, 0, 0, 5, 5, 1, 0, 2, 0],
];

/** @param {Bits} bits @param {Partition} partition @param {number} indexBits */
function takeIndices(bits, partition, indexBits) {
  return Array.from({ length: 16 }, (_, t) => bits.take(indexBits - (partition.anchors.includes(t) ? 1 : 0)));
}

/** Decodes a block of 16 bytes to 16 texels of four bytes.
 * @param {Uint8Array} bytes @param {number} at @param {Uint8Array} out 64 bytes */
export function decodeBc7Block(bytes, at, out) {
  if (bytes[at] === 0) {
    out.fill(0);
    return;
  }
  const number = 31 - Math.clz32(bytes[at] & -bytes[at]);
  const [subsets, partitionBits, rotationBits, selectionBits, colourBits, alphaBits, ownP, sharedP, indexBits, secondBits] = MODES7[number];
  const bits = new Bits(bytes, at);
  bits.take(number + 1);
  const partition = PARTITIONS[subsets][bits.take(partitionBits)];
  const rotation = bits.take(rotationBits);
  const selection = bits.take(selectionBits);
  const ends = Array.from({ length: 2 * subsets }, () => [0, 0, 0, 255]);
  for (let c = 0; c < (alphaBits ? 4 : 3); ++c) for (const end of ends) end[c] = bits.take(c < 3 ? colourBits : alphaBits);
  let p = 0;
  for (let e = 0; e < ends.length; ++e) {
    if (ownP || (sharedP && e % 2 === 0)) p = bits.take(1);
    for (let c = 0; c < (alphaBits ? 4 : 3); ++c) {
      const stored = (c < 3 ? colourBits : alphaBits) + (ownP | sharedP);
      const value = (ownP | sharedP ? (ends[e][c] << 1) | p : ends[e][c]) << (8 - stored);
      ends[e][c] = value | (value >> stored);
    }
  }
  let colours = takeIndices(bits, partition, indexBits), alphas = colours, weights = WEIGHTS[indexBits], alphaWeights = weights;
  if (secondBits) {
    alphas = takeIndices(bits, PARTITIONS[1][0], secondBits);
    alphaWeights = WEIGHTS[secondBits];
    if (selection) [colours, alphas, weights, alphaWeights] = [alphas, colours, alphaWeights, weights];
  }
  for (let t = 0; t < 16; ++t) {
    const a = ends[2 * partition.subset[t]], b = ends[2 * partition.subset[t] + 1];
    for (let c = 0; c < 4; ++c) {
      const weight = c < 3 ? weights[colours[t]] : alphaWeights[alphas[t]];
      out[4 * t + c] = ((64 - weight) * a[c] + weight * b[c] + 32) >> 6;
    }
    if (rotation) {
      const alpha = out[4 * t + 3];
      out[4 * t + 3] = out[4 * t + rotation - 1];
      out[4 * t + rotation - 1] = alpha;
    }
  }
}
