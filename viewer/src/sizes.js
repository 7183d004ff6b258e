// Bytes of a scene before and after it was cooked.

/** Returns the bytes of the files that were read; a light map and its dominant light come from one.
 * @param {any[]} assets rows of the report */
export function bytesRead(assets) {
  const hasMaps = assets.some(({ kind }) => kind === "light-map"), read = new Map();
  for (const { kind, name, light, bytes_in } of assets) {
    const isOfBake = kind === "light-map" || kind === "dominant";
    if (kind !== "dominant" || light?.bake || !hasMaps) read.set(isOfBake ? `bake ${light?.bake ?? name}` : `${kind} ${name}`, bytes_in);
  }
  return [...read.values()].reduce((sum, count) => sum + count, 0);
}

/** Returns the GPU memory of assets of a manifest. @param {import("../loaders/core/cooked.js").CookedAsset[]} assets */
export const bytesCooked = (assets) =>
  assets.reduce((sum, { textures, bytes_gpu = 0 }) => sum + textures.reduce((all, texture) => all + texture.bytes_gpu, bytes_gpu), 0);
