// 16-bit floats (IEEE 754 binary16) as integers of their bits.

const word = new Float32Array(1), wordBits = new Uint32Array(word.buffer);

/** @param {number} bits @returns {number} */
export function fromHalf(bits) {
  const exponent = (bits >> 10) & 31, fraction = bits & 1023, sign = bits & 0x8000 ? -1 : 1;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (exponent === 0 ? fraction * 2 ** -24 : (1 + fraction / 1024) * 2 ** (exponent - 15));
}

/** Rounds to the nearest half, ties to even. Larger numbers become 65504, the largest one. @param {number} value @returns {number} */
export function toHalf(value) {
  word[0] = Math.min(Math.max(value, -65504), 65504);
  const sign = (wordBits[0] >>> 16) & 0x8000, magnitude = Math.abs(word[0]);
  if (Number.isNaN(magnitude)) return sign | 0x7e00;
  const exponent = Math.max(Math.floor(Math.log2(magnitude)), -14), step = 2 ** (exponent - 10);
  const steps = magnitude / step, floor = Math.floor(steps), rest = steps - floor;
  const rounded = floor + (rest > 0.5 || (rest === 0.5 && floor % 2 === 1) ? 1 : 0);
  // A carry into the next power of two increments the exponent, as the bits lie one after the other.
  return sign | (rounded === 0 ? 0 : ((exponent + 14) << 10) + rounded);
}
