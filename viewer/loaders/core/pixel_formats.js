// The pixel formats that lightcook writes, as WebGL2 takes them. One row a format; VkFormat is what KTX2 files say.
import { decodeBc1Block, decodeBc4Block } from "./bc.js";
import { decodeBc6hBlock, decodeBc7Block } from "./bptc.js";
import { fromHalf } from "./half.js";

/**
 * @typedef {object} PixelFormat
 * @property {string} name as `lightcook encode --format` has it
 * @property {number} block width and height of a block [texels]
 * @property {number} bytes bytes of a block
 * @property {number} internal internal format of WebGL
 * @property {number} [format] format of WebGL; without one, the texture is compressed
 * @property {number} [type] type of WebGL
 * @property {string} [extension] WebGL extension that the format needs
 * @property {string} [profile] profile of WEBGL_compressed_texture_astc that it needs
 * @property {boolean} [isHdr] true for light above 1, whose decoded texels are halves
 * @property {boolean} [normalized] 16-bit integers that stand for [0, 1]
 * @property {(bytes: Uint8Array, at: number, out: Float32Array) => void} [decode] decodes a block of 4 x 4 texels to RGBA
 */

const S3TC = "WEBGL_compressed_texture_s3tc", RGTC = "EXT_texture_compression_rgtc", BPTC = "EXT_texture_compression_bptc",
  ASTC = "WEBGL_compressed_texture_astc", NORM16 = "EXT_texture_norm16";
const halves = new Uint16Array(64), octets = new Uint8Array(64);

/** @param {boolean} signed @returns {PixelFormat["decode"]} */
const bc6h = (signed) => (bytes, at, out) => {
  decodeBc6hBlock(bytes, at, halves, signed);
  for (let i = 0; i < 64; ++i) out[i] = fromHalf(halves[i]);
};
/** @param {number} channels @param {boolean} signed @returns {PixelFormat["decode"]} */
const rgtc = (channels, signed) => (bytes, at, out) => {
  for (let t = 0; t < 16; ++t) out.set([0, 0, 0, 1], 4 * t);
  for (let c = 0; c < channels; ++c) decodeBc4Block(bytes, at + 8 * c, out, c, signed);
};

// Numbers of the OpenGL registry.
const RED = 0x1903, RG = 0x8227, RGB = 0x1907, RGBA = 0x1908, BYTE = 0x1401, SHORT = 0x1403, HALF = 0x140b, FLOAT = 0x1406;

/** @type {[number, PixelFormat][]} */
const ROWS = [
  [131, { name: "bc1", block: 4, bytes: 8, internal: 0x83f0, extension: S3TC, decode: (bytes, at, out) => decodeBc1Block(bytes, at, out, false) }],
  [137, { name: "bc3", block: 4, bytes: 16, internal: 0x83f3, extension: S3TC,
    decode: (bytes, at, out) => {
      decodeBc1Block(bytes, at + 8, out, true);
      decodeBc4Block(bytes, at, out, 3, false);
    } }],
  [139, { name: "bc4", block: 4, bytes: 8, internal: 0x8dbb, extension: RGTC, decode: rgtc(1, false) }],
  [140, { name: "bc4-snorm", block: 4, bytes: 8, internal: 0x8dbc, extension: RGTC, decode: rgtc(1, true) }],
  [141, { name: "bc5", block: 4, bytes: 16, internal: 0x8dbd, extension: RGTC, decode: rgtc(2, false) }],
  [142, { name: "bc5-snorm", block: 4, bytes: 16, internal: 0x8dbe, extension: RGTC, decode: rgtc(2, true) }],
  [143, { name: "bc6h-uf16", block: 4, bytes: 16, internal: 0x8e8f, extension: BPTC, isHdr: true, decode: bc6h(false) }],
  [144, { name: "bc6h-sf16", block: 4, bytes: 16, internal: 0x8e8e, extension: BPTC, isHdr: true, decode: bc6h(true) }],
  [145, { name: "bc7", block: 4, bytes: 16, internal: 0x8e8c, extension: BPTC,
    decode: (bytes, at, out) => {
      decodeBc7Block(bytes, at, octets);
      for (let i = 0; i < 64; ++i) out[i] = octets[i] / 255;
    } }],
  [157, { name: "astc-4x4-ldr", block: 4, bytes: 16, internal: 0x93b0, extension: ASTC }],
  [1000066000, { name: "astc-4x4-hdr", block: 4, bytes: 16, internal: 0x93b0, extension: ASTC, profile: "hdr", isHdr: true }],
  [1000066004, { name: "astc-6x6-hdr", block: 6, bytes: 16, internal: 0x93b4, extension: ASTC, profile: "hdr", isHdr: true }],
  [1000066007, { name: "astc-8x8-hdr", block: 8, bytes: 16, internal: 0x93b7, extension: ASTC, profile: "hdr", isHdr: true }],
  [123, { name: "rgb9e5", block: 1, bytes: 4, internal: 0x8c3d, format: RGB, type: 0x8c3e }],
  [122, { name: "r11g11b10f", block: 1, bytes: 4, internal: 0x8c3a, format: RGB, type: 0x8c3b }],
  [109, { name: "rgba32f", block: 1, bytes: 16, internal: 0x8814, format: RGBA, type: FLOAT }],
  [97, { name: "rgba16f", block: 1, bytes: 8, internal: 0x881a, format: RGBA, type: HALF }],
  [90, { name: "rgb16f", block: 1, bytes: 6, internal: 0x881b, format: RGB, type: HALF }],
  [70, { name: "r16-unorm", block: 1, bytes: 2, internal: 0x822a, format: RED, type: SHORT, extension: NORM16, normalized: true }],
  [77, { name: "rg16-unorm", block: 1, bytes: 4, internal: 0x822c, format: RG, type: SHORT, extension: NORM16, normalized: true }],
  [91, { name: "rgba16-unorm", block: 1, bytes: 8, internal: 0x805b, format: RGBA, type: SHORT, extension: NORM16, normalized: true }],
  [37, { name: "rgba8-unorm", block: 1, bytes: 4, internal: 0x8058, format: RGBA, type: BYTE }],
];
/** Formats by VkFormat. */
export const PIXEL_FORMATS = new Map(ROWS);

/** Returns a format by its name. @param {string} name @returns {PixelFormat} */
export function formatOf(name) {
  const row = ROWS.find(([, format]) => format.name === name);
  if (!row) throw new Error(`"${name}": no such pixel format`);
  return row[1];
}

/** Returns true if a WebGL2 context samples a format itself.
 * @param {WebGL2RenderingContext | null} gl null: no format that needs an extension @param {PixelFormat} format */
export function isSupported(gl, format) {
  if (!format.extension) return true;
  const extension = gl?.getExtension(format.extension);
  return !!extension && (!format.profile || extension.getSupportedProfiles().includes(format.profile));
}

/** Decodes an image of blocks, or of 16-bit numbers, to RGBA floats. Returns null for a format without a decoder (ASTC).
 * @param {PixelFormat} format @param {Uint8Array} bytes @param {number} width @param {number} height @returns {Float32Array | null} */
export function decodeImage(format, bytes, width, height) {
  const texels = new Float32Array(4 * width * height);
  if (format.normalized) {
    const channels = format.bytes / 2;
    for (let i = 0; i < width * height; ++i) {
      texels[4 * i + 3] = 1;
      for (let c = 0; c < channels; ++c) {
        const at = 2 * (channels * i + c);
        texels[4 * i + c] = (bytes[at] | (bytes[at + 1] << 8)) / 65535;
      }
    }
    return texels;
  }
  const { decode, block } = format;
  if (!decode) return null;
  const across = Math.ceil(width / block), down = Math.ceil(height / block), out = new Float32Array(64);
  for (let by = 0; by < down; ++by)
    for (let bx = 0; bx < across; ++bx) {
      decode(bytes, format.bytes * (by * across + bx), out);
      for (let t = 0; t < 16; ++t) {
        const x = block * bx + (t & 3), y = block * by + (t >> 2);
        if (x < width && y < height) texels.set(out.subarray(4 * t, 4 * t + 4), 4 * (y * width + x));
      }
    }
  return texels;
}
