// KTX2 files as texels that a WebGL2 context can sample: what it cannot is decoded here.
import { KHR_SUPERCOMPRESSION_NONE, KHR_SUPERCOMPRESSION_ZSTD, read } from "ktx-parse";
import { ZSTDDecoder } from "zstddec";
import { PIXEL_FORMATS, decodeImage, formatOf, isSupported } from "./pixel_formats.js";
import { toHalf } from "./half.js";

/** @typedef {import("./pixel_formats.js").PixelFormat} PixelFormat */
/**
 * @typedef {object} Ktx2
 * @property {PixelFormat} format
 * @property {number} width [texels]
 * @property {number} height [texels]
 * @property {number} layers at least 1
 * @property {number} faces 6 for a cubemap, else 1
 * @property {Uint8Array[]} levels texels of each mip: layer by layer, face by face
 */

/** @type {Promise<ZSTDDecoder> | undefined} */
let zstd;

/** Reads a KTX2 file. Throws an Error that names the file if it is damaged or of an unknown format.
 * @param {ArrayBuffer | Uint8Array} data @param {string} name of the file, for messages @returns {Promise<Ktx2>} */
export async function readKtx2(data, name) {
  let file;
  try {
    file = read(data instanceof Uint8Array ? data : new Uint8Array(data));
  } catch (fault) {
    throw new Error(`${name}: not a KTX2 file (${/** @type {Error} */ (fault).message})`);
  }
  const format = PIXEL_FORMATS.get(file.vkFormat);
  if (!format) throw new Error(`${name}: found VkFormat ${file.vkFormat}, expected one that lightcook writes`);
  const scheme = file.supercompressionScheme;
  if (scheme !== KHR_SUPERCOMPRESSION_NONE && scheme !== KHR_SUPERCOMPRESSION_ZSTD)
    throw new Error(`${name}: found supercompression scheme ${scheme}, expected none or Zstandard`);
  if (scheme === KHR_SUPERCOMPRESSION_ZSTD && !zstd) {
    const decoder = new ZSTDDecoder();
    zstd = decoder.init().then(() => decoder);
  }
  const decoder = scheme === KHR_SUPERCOMPRESSION_ZSTD ? await zstd : undefined;
  const ktx = { format, width: file.pixelWidth, height: file.pixelHeight, layers: Math.max(file.layerCount, 1), faces: file.faceCount };
  const levels = file.levels.map((level, mip) => {
    const bytes = decoder ? decoder.decode(level.levelData, level.uncompressedByteLength) : level.levelData;
    const expected = imageBytes(ktx, mip) * ktx.layers * ktx.faces;
    if (bytes.length !== expected) throw new Error(`${name}: level ${mip} has ${bytes.length} bytes, expected ${expected}`);
    return bytes;
  });
  return { ...ktx, levels };
}

/** @param {{ width: number, height: number }} size @param {number} mip */
export function mipSize({ width, height }, mip) {
  return { width: Math.max(width >> mip, 1), height: Math.max(height >> mip, 1) };
}

/** Bytes of one image of a mip. @param {Pick<Ktx2, "format" | "width" | "height">} ktx @param {number} mip */
export function imageBytes({ format, ...size }, mip) {
  const { width, height } = mipSize(size, mip);
  return Math.ceil(width / format.block) * Math.ceil(height / format.block) * format.bytes;
}

/** @typedef {Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer> | Uint32Array<ArrayBuffer> | Float32Array<ArrayBuffer>} Texels */

/** Array types of texels by the type of WebGL. Compressed and packed ones are bytes or words. */
const ARRAYS = /** @type {const} */ ({ 0x1401: Uint8Array, 0x1403: Uint16Array, 0x140b: Uint16Array, 0x1406: Float32Array });

/** Returns images of a mip, layer by layer or face by face, as the array type that WebGL takes for the format.
 * @param {Ktx2} ktx @param {number} mip @param {number} [first] image @param {number} [count] images; all without @returns {Texels} */
export function imagesOf(ktx, mip, first = 0, count = ktx.layers * ktx.faces) {
  const { format } = ktx, one = imageBytes(ktx, mip), bytes = ktx.levels[mip].slice(first * one, (first + count) * one).buffer;
  if (format.type === undefined) return new Uint8Array(bytes);
  const Type = ARRAYS[/** @type {keyof typeof ARRAYS} */ (format.type)] ?? Uint32Array;
  return new Type(/** @type {ArrayBuffer} */ (bytes));
}

/** Array type and conversion of decoded texels, by the name of the format that they are stored in. */
const STORED = {
  "rgba8-unorm": { Type: Uint8Array, of: (/** @type {number} */ x) => Math.round(255 * x) },
  "rgba16f": { Type: Uint16Array, of: toHalf },
  "rgba32f": { Type: Float32Array, of: (/** @type {number} */ x) => x },
};

/** @param {PixelFormat} format @param {WebGL2RenderingContext | null} gl @returns {keyof typeof STORED} */
function decodedFormat(format, gl) {
  if (format.name === "bc7") return "rgba8-unorm";
  return !format.isHdr && gl?.getExtension("OES_texture_float_linear") ? "rgba32f" : "rgba16f";
}

/** Returns true if WebGL2 takes the size: it has no BC textures whose sides are no multiples of 4. @param {Ktx2} ktx */
const isWholeBlocks = ({ format, width, height }) => !format.name.startsWith("bc") || (width % 4 === 0 && height % 4 === 0);

/**
 * Returns a file that can be sampled: itself, or its texels decoded to RGBA. HDR becomes halves, BC7 8 bits, the rest floats where those
 * are filtered, else halves.
 * @param {Ktx2} ktx
 * @param {WebGL2RenderingContext | null} gl context that will sample it; null decodes every format that needs an extension
 * @param {string} name of the file, for messages
 * @param {(format: PixelFormat) => boolean} [isKnown] false for formats that the engine has no name for
 * @returns {Ktx2}
 */
export function sampleable(ktx, gl, name, isKnown = () => true) {
  const most = gl ? Number(gl.getParameter(ktx.faces === 6 ? gl.MAX_CUBE_MAP_TEXTURE_SIZE : gl.MAX_TEXTURE_SIZE)) : Infinity;
  if (Math.max(ktx.width, ktx.height) > most)
    throw new Error(`${name}: found ${ktx.width} x ${ktx.height} texels, this browser samples textures of up to ${most} x ${most}`);
  if (isSupported(gl, ktx.format) && isWholeBlocks(ktx) && isKnown(ktx.format)) return ktx;
  const decoded = decodedFormat(ktx.format, gl);
  return { ...ktx, format: formatOf(decoded), levels: ktx.levels.map((_, mip) => decodeLevel(ktx, mip, decoded, name)) };
}

/** @param {Ktx2} ktx @param {number} mip @param {keyof typeof STORED} stored @param {string} name */
function decodeLevel(ktx, mip, stored, name) {
  const { width, height } = mipSize(ktx, mip), one = imageBytes(ktx, mip), images = ktx.layers * ktx.faces, count = 4 * width * height;
  const { Type, of } = STORED[stored], out = new Type(images * count);
  for (let i = 0; i < images; ++i) {
    const texels = decodeImage(ktx.format, ktx.levels[mip].subarray(i * one, (i + 1) * one), width, height);
    if (!texels) throw new Error(`${name}: this browser has no ${ktx.format.name} textures; cook for target bc or float`);
    for (let k = 0; k < count; ++k) out[i * count + k] = of(texels[k]);
  }
  return new Uint8Array(out.buffer);
}
