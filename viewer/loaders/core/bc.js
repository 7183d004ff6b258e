// BC1, BC3, BC4 and BC5 on the CPU, for browsers without the extensions. After the Khronos Data Format Specification 1.3, chapters 18 and 19.

/** Returns the eight palette values of a BC4 block, in units of 1/255 (unsigned) or 1/127 (signed).
 * @param {number} a @param {number} b @param {number} low @param {boolean} isWhole true: all eight lie between the ends; false: low and high are two of them */
function palette4(a, b, low, isWhole) {
  const values = [a, b];
  if (isWhole) for (let i = 1; i < 7; ++i) values.push(((7 - i) * a + i * b) / 7);
  else {
    for (let i = 1; i < 5; ++i) values.push(((5 - i) * a + i * b) / 5);
    values.push(low, low < 0 ? 127 : 255);
  }
  return values;
}

/** Decodes eight bytes to one channel of 16 RGBA texels, in [0, 1], or [-1, 1] if signed.
 * @param {Uint8Array} bytes @param {number} at @param {Float32Array} out @param {number} channel @param {boolean} signed */
export function decodeBc4Block(bytes, at, out, channel, signed) {
  // The stored ends are compared, -128 below -127; both mean -1.
  const [a, b] = [bytes[at], bytes[at + 1]].map((v) => (signed ? (v << 24) >> 24 : v)), low = signed ? -127 : 0;
  const values = palette4(Math.max(a, low), Math.max(b, low), low, a > b);
  for (let t = 0; t < 16; ++t) {
    const bit = 3 * t;
    const pair = bytes[at + 2 + (bit >> 3)] | ((bytes[at + 3 + (bit >> 3)] ?? 0) << 8);
    out[4 * t + channel] = values[(pair >> (bit & 7)) & 7] / (signed ? 127 : 255);
  }
}

/** Decodes the colours of a BC1 block to 16 RGBA texels in [0, 1].
 * @param {Uint8Array} bytes @param {number} at @param {Float32Array} out @param {boolean} alwaysFour BC3 has no mode of three colours */
export function decodeBc1Block(bytes, at, out, alwaysFour) {
  const packed = [bytes[at] | (bytes[at + 1] << 8), bytes[at + 2] | (bytes[at + 3] << 8)];
  const ends = packed.map((p) => [(p >> 11) / 31, ((p >> 5) & 63) / 63, (p & 31) / 31]);
  const four = alwaysFour || packed[0] > packed[1];
  for (let t = 0; t < 16; ++t) {
    const index = (bytes[at + 4 + (t >> 2)] >> (2 * (t & 3))) & 3;
    for (let c = 0; c < 3; ++c) {
      const [a, b] = [ends[0][c], ends[1][c]];
      out[4 * t + c] = index === 0 ? a : index === 1 ? b : four ? (index === 2 ? (2 * a + b) / 3 : (a + 2 * b) / 3) : index === 2 ? (a + b) / 2 : 0;
    }
    out[4 * t + 3] = 1;
  }
}
