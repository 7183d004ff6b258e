// GPU memory as a squarified treemap (Bruls, Huizing and van Wijk 2000): areas are bytes.

/** @typedef {{ asset: string, role: string, kind: string, bytes: number, detail: string }} Item */
/** @typedef {{ item: Item, x: number, y: number, width: number, height: number }} Tile shares of the whole, in [0, 1] */

/** Lays out items, the largest first. Those without bytes are left out. @param {Item[]} items @param {number} aspect width over height @returns {Tile[]} */
export function treemap(items, aspect) {
  const left = items.filter((item) => item.bytes > 0).sort((a, b) => b.bytes - a.bytes);
  const total = left.reduce((sum, item) => sum + item.bytes, 0);
  /** @type {Tile[]} */
  const tiles = [];
  let x = 0, y = 0, width = aspect, height = 1;
  const area = (/** @type {Item} */ item) => (item.bytes / total) * aspect;
  /** Largest ratio of the sides in a row along the short side. */
  const worst = (/** @type {Item[]} */ row, /** @type {number} */ side) => {
    const sum = row.reduce((s, item) => s + area(item), 0);
    return Math.max(...row.map((item) => Math.max((side * side * area(item)) / (sum * sum), (sum * sum) / (side * side * area(item)))));
  };
  while (left.length > 0) {
    const side = Math.min(width, height), row = [/** @type {Item} */ (left.shift())];
    while (left.length > 0 && worst([...row, left[0]], side) <= worst(row, side)) row.push(/** @type {Item} */ (left.shift()));
    const sum = row.reduce((s, item) => s + area(item), 0), thickness = sum / side;
    let along = 0;
    for (const item of row) {
      const length = area(item) / thickness;
      tiles.push(width >= height
        ? { item, x: x / aspect, y: y + along, width: thickness / aspect, height: length }
        : { item, x: (x + along) / aspect, y, width: length / aspect, height: thickness });
      along += length;
    }
    if (width >= height) {
      x += thickness;
      width -= thickness;
    } else {
      y += thickness;
      height -= thickness;
    }
  }
  return tiles;
}

/** What each asset of a manifest keeps in GPU memory. @param {import("../loaders/core/cooked.js").CookedManifest} manifest @returns {Item[]} */
export function memoryItems(manifest) {
  return manifest.assets.flatMap((asset) => {
    const textures = asset.textures.map((texture) => ({
      asset: asset.name,
      role: texture.role,
      kind: asset.kind,
      bytes: texture.bytes_gpu,
      detail: `${texture.format}, ${texture.width} x ${texture.height}${texture.layers > 1 ? ` x ${texture.layers}` : ""}${texture.faces > 1 ? ` x ${texture.faces} faces` : ""}`,
    }));
    const rest = asset.bytes_gpu ?? 0;
    const isMesh = asset.kind === "mesh";
    return rest > 0
      ? [...textures, { asset: asset.name, role: isMesh ? "vertices" : "tables", kind: asset.kind, bytes: rest, detail: isMesh ? "what the light map needs" : "constants" }]
      : textures;
  });
}

/** @param {number} bytes */
export function sizeText(bytes) {
  if (bytes < 1024) return `${Math.round(bytes)} B`;
  return bytes < 1024 * 1024 ? `${(bytes / 1024).toFixed(1)} KiB` : `${(bytes / 1024 / 1024).toFixed(2)} MiB`;
}
