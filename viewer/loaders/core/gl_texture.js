// KTX2 files as textures of WebGL2, for engines whose own textures do not know the formats or the layers, and for programs without one.
import { imagesOf, mipSize } from "./ktx2.js";

/**
 * Fills a texture of a context: a 2D array of the layers (of one layer, too), or a cubemap. Clamps. Restores the state that it changes.
 * @param {WebGL2RenderingContext} gl
 * @param {import("./ktx2.js").Ktx2} ktx in a format that the context samples: see sampleable
 * @param {boolean} isFiltered true: linear, also between mips; false: nearest, for fetches
 * @param {WebGLTexture} [texture] a new one; created without
 */
export function glTexture(gl, ktx, isFiltered, texture = gl.createTexture()) {
  const { format, layers, faces } = ktx, isCube = faces === 6, target = isCube ? gl.TEXTURE_CUBE_MAP : gl.TEXTURE_2D_ARRAY;
  const bound = gl.getParameter(isCube ? gl.TEXTURE_BINDING_CUBE_MAP : gl.TEXTURE_BINDING_2D_ARRAY);
  const unpack = /** @type {const} */ ([[gl.UNPACK_FLIP_Y_WEBGL, 0], [gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, 0], [gl.UNPACK_ALIGNMENT, 1]]);
  const before = unpack.map(([key]) => Number(gl.getParameter(key)));
  gl.bindTexture(target, texture);
  for (const [key, value] of unpack) gl.pixelStorei(key, value);
  ktx.levels.forEach((_, mip) => {
    const { width, height } = mipSize(ktx, mip);
    for (let face = 0; isCube && face < faces; ++face) {
      const side = gl.TEXTURE_CUBE_MAP_POSITIVE_X + face, texels = imagesOf(ktx, mip, face, 1);
      if (format.format === undefined) gl.compressedTexImage2D(side, mip, format.internal, width, height, 0, texels);
      else gl.texImage2D(side, mip, format.internal, width, height, 0, format.format, /** @type {number} */ (format.type), texels);
    }
    if (isCube) return;
    if (format.format === undefined) gl.compressedTexImage3D(target, mip, format.internal, width, height, layers, 0, imagesOf(ktx, mip));
    else gl.texImage3D(target, mip, format.internal, width, height, layers, 0, format.format, /** @type {number} */ (format.type), imagesOf(ktx, mip));
  });
  // WebGL2 fetches no other level than the first of a texture whose filter has no mips.
  const [filtered, fetched] = ktx.levels.length > 1 ? [gl.LINEAR_MIPMAP_LINEAR, gl.NEAREST_MIPMAP_NEAREST] : [gl.LINEAR, gl.NEAREST];
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, isFiltered ? filtered : fetched);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, isFiltered ? gl.LINEAR : gl.NEAREST);
  gl.texParameteri(target, gl.TEXTURE_MAX_LEVEL, ktx.levels.length - 1);
  for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(target, wrap, gl.CLAMP_TO_EDGE);
  unpack.forEach(([key], i) => gl.pixelStorei(key, before[i]));
  gl.bindTexture(target, bound);
  return texture;
}
