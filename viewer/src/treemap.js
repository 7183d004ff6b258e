// GPU memory as a squarified treemap (Bruls, Huizing and van Wijk 2000): areas are bytes.

/**
 * @typedef {object} Item
 * @property {string} asset
 * @property {string} role
 * @property {string} kind
 * @property {number} bytes
 * @property {string} detail
 * @property {[map: number, u: number, v: number]} [place] inside a chart
 * @property {number} [visible] visible error that 99 % of a chart's texels stay under [Delta E ITP]
 */
/** @typedef {{ p99: number, max: number, worst: [u: number, v: number] }} ChartError visible errors of a chart, and the place of the largest */
/** @template T @typedef {{ item: T, x: number, y: number, width: number, height: number }} Tile shares of the whole, in [0, 1] */

/** Lays out items, the largest first. Those without bytes are left out.
 * @template {{ bytes: number }} T @param {T[]} items @param {number} aspect width over height @returns {Tile<T>[]} */
export function treemap(items, aspect) {
  const left = items.filter((item) => item.bytes > 0).sort((a, b) => b.bytes - a.bytes);
  const total = left.reduce((sum, item) => sum + item.bytes, 0);
  /** @type {Tile<T>[]} */
  const tiles = [];
  let x = 0, y = 0, width = aspect, height = 1;
  const area = (/** @type {T} */ item) => (item.bytes / total) * aspect;
  /** Largest ratio of the sides in a row along the short side. */
  const worst = (/** @type {T[]} */ row, /** @type {number} */ side) => {
    const sum = row.reduce((s, item) => s + area(item), 0);
    return Math.max(...row.map((item) => Math.max((side * side * area(item)) / (sum * sum), (sum * sum) / (side * side * area(item)))));
  };
  while (left.length > 0) {
    const side = Math.min(width, height), row = [/** @type {T} */ (left.shift())];
    while (left.length > 0 && worst([...row, left[0]], side) <= worst(row, side)) row.push(/** @type {T} */ (left.shift()));
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

/** Returns what each asset of a manifest keeps in GPU memory. @param {import("../loaders/core/cooked.js").CookedManifest} manifest @returns {Item[]} */
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

/** Most charts of a light map that have a tile of their own: more could not be told apart. */
const MOST_CHARTS = 120;

/**
 * Returns the items with the charts of light maps in place of their textures. A chart has the bytes of its area; the rest of a light map
 * lies between charts.
 * @param {Item[]} items of memoryItems
 * @param {import("./view.js").ShownMap[]} maps
 * @param {Map<number, ChartError>[]} errors of each map by chart, as far as they are known
 * @returns {Item[]}
 */
export function chartItems(items, maps, errors) {
  const split = maps.flatMap((map, index) => {
    const { asset, charts, hasMesh } = map, own = items.filter((item) => item.kind === "light-map" && item.asset === asset.name);
    const whole = own.reduce((sum, { bytes }) => sum + bytes, 0), texels = charts.texels.reduce((sum, count) => sum + count, 0);
    if (!hasMesh || charts.count === 0 || texels > asset.width * asset.height) return own;
    const bytesOf = (/** @type {number} */ count) => (whole * count) / (asset.width * asset.height);
    const order = Array.from(charts.texels.keys()).sort((a, b) => charts.texels[b] - charts.texels[a]);
    /** @type {Item[]} */
    const tiles = order.slice(0, MOST_CHARTS).map((chart) => {
      const error = errors[index]?.get(chart), texels = `${Math.round(charts.texels[chart])} texels`;
      return {
        asset: asset.name, role: `chart ${chart + 1}`, kind: "light-map", bytes: bytesOf(charts.texels[chart]),
        detail: error ? `${texels}, visible error ${error.p99.toFixed(2)} for 99 % of them, at most ${error.max.toFixed(2)}` : texels,
        place: [index, ...(error ? error.worst : /** @type {[number, number]} */ ([charts.middle[2 * chart], charts.middle[2 * chart + 1]]))],
        visible: error?.p99,
      };
    });
    const few = order.slice(MOST_CHARTS), fewTexels = few.reduce((sum, chart) => sum + charts.texels[chart], 0);
    tiles.push({ asset: asset.name, role: `${few.length} smaller charts`, kind: "light-map", bytes: bytesOf(fewTexels), detail: `${Math.round(fewTexels)} texels` });
    tiles.push({ asset: asset.name, role: "between charts", kind: "light-map", bytes: bytesOf(asset.width * asset.height - texels), detail: "no triangle lies there; some of it pads charts" });
    return tiles;
  });
  const isSplit = (/** @type {Item} */ { kind, asset }) => kind === "light-map" && maps.some((map) => map.asset.name === asset);
  return [...items.filter((item) => !isSplit(item)), ...split];
}

/** Ends of the ranges of visible errors that have one colour each [Delta E ITP]. */
const ERROR_ENDS = [1, 2, 5, 10];

/** Returns the colour of a visible error. @param {number} visible not finite: beyond all ranges */
export function errorColor(visible) {
  return `var(--error-${ERROR_ENDS.filter((end) => !(visible < end)).length})`;
}

/** Returns the ranges of visible errors, for a legend. */
export function errorRanges() {
  return [0, ...ERROR_ENDS].map((start, i) => ({
    words: i === 0 ? `below ${ERROR_ENDS[0]}` : i < ERROR_ENDS.length ? `${start} to ${ERROR_ENDS[i]}` : `${start} or more`,
    color: errorColor(start),
  }));
}

/** Colour of a tile. @param {Item} item */
export function colorOf({ kind, visible }) {
  return visible === undefined ? `var(--kind-${kind})` : errorColor(visible);
}
