// Sentences about memory and error, and the layouts beside the chosen one. Each has figures that were measured in the cook (layouts that were
// tried) or that follow from sizes alone.
import { bytesText, countText, numberText, percentText } from "../src/units.js";
import { formats, nameOf, sorted } from "./parts.js";

/** Textures of a light map that are not its texels. */
const LOOKUPS = ["tables", "index", "coverage"];

/** Returns the bytes of a light map's texture that lie outside charts; 0 for what is looked up beside its texels, and for other assets. */
export function bytesOutsideCharts({ kind, width, height, notes }, { role, bytes_gpu }) {
  const share = (notes?.covered_texels ?? NaN) / (width * height);
  return kind === "light-map" && !LOOKUPS.includes(role) && share < 1 ? Math.floor(bytes_gpu * (1 - share)) : 0;
}

/**
 * Returns three of the layouts that were tried for a light map: the chosen one, the best of the smaller ones, and the smallest of the better ones;
 * and the figure that compares them, of diffuse and specular light alike: visible error where the map has a limit on it, else rel_rms.
 */
export function alternativesOf({ trial_candidates: tried, layout, limit }) {
  /** @type {any[]} */
  const candidates = tried ?? [];
  const isVisible = typeof limit?.max_visible === "number" && candidates.every((each) => Number.isFinite(each.visible_diffuse) && Number.isFinite(each.visible_specular));
  const errorOf = (each) => (isVisible ? Math.max(each.visible_diffuse, each.visible_specular) : Math.max(each.diffuse ?? Infinity, each.specular ?? Infinity));
  const chosen = candidates.find((each) => each.layout === layout), others = candidates.filter((each) => !each.excluded);
  const least = (items, valueOf) => items.reduce((best, each) => (best && valueOf(best) <= valueOf(each) ? best : each), undefined);
  const bytesOf = (each) => each.bytes_gpu;
  return {
    chosen,
    cheaper: chosen && least(others.filter((each) => each.bytes_gpu < chosen.bytes_gpu), errorOf),
    better: chosen && least(others.filter((each) => errorOf(each) < errorOf(chosen)), bytesOf),
    errorOf,
    errorName: isVisible ? "visible error, p99" : "rel_rms",
    limit: isVisible ? limit.max_visible : limit?.value,
    text: isVisible ? numberText : percentText,
  };
}

/** Returns the asset that takes most memory for its error, and the one that makes most error for its memory. */
function proportions(report) {
  const used = report.budget.used_bytes, { parts } = report.whole ?? { parts: [] };
  const shares = report.assets.filter(({ name }) => parts.some(({ asset }) => asset === name)).map((asset) => ({
    asset, memory: used > 0 ? asset.bytes_gpu / used : 0, error: parts.reduce((sum, { asset: name, share }) => sum + (name === asset.name ? share ?? NaN : 0), 0),
  })).filter(({ error }) => error >= 0);
  const sentence = ({ asset, memory, error }, end) =>
    `${nameOf(asset)} (${bytesText(asset.bytes_gpu)}): ${percentText(memory)} of the memory, ${percentText(error)} of the squared error of ` +
    `the whole shading. Look here first to ${end}.`;
  const [heavy] = sorted(shares, ({ memory, error }) => memory - error), [faulty] = sorted(shares, ({ memory, error }) => error - memory);
  return [
    ...(heavy && heavy.memory - heavy.error > 0.1 ? [sentence(heavy, "save memory")] : []),
    ...(faulty && faulty.error - faulty.memory > 0.1 ? [sentence(faulty, "reduce the error")] : []),
  ];
}

function layouts(asset) {
  const { chosen, cheaper, better, errorOf, errorName, limit, text } = alternativesOf(asset), name = nameOf(asset);
  if (!chosen) return [];
  const where = asset.trial_share < 1 ? `measured on ${percentText(asset.trial_share)} of the map` : "measured";
  const cost = (each) => `${countText(each.fetches)} fetches and ${countText(each.decode_ops)} operations a sample`;
  const change = (each) => `the error (${errorName}, ${where}) goes from ${text(errorOf(chosen))} to ${text(errorOf(each))}`;
  return [
    cheaper && `${name}: layout ${cheaper.layout} in place of ${chosen.layout} saves ${bytesText(chosen.bytes_gpu - cheaper.bytes_gpu)}; ${change(cheaper)}${
      errorOf(cheaper) > limit ? `, over the limit of ${text(limit)}` : ""}. ${cost(cheaper)} in place of ${cost(chosen)}.`,
    better && better.bytes_gpu >= chosen.bytes_gpu && `${name}: layout ${better.layout} costs ${bytesText(better.bytes_gpu - chosen.bytes_gpu)} more; ${change(better)}. ${cost(better)}.`,
  ];
}

/** Returns the layout that the scene's list lacks and the map would be better off with. */
function excluded(asset) {
  const other = asset.better_excluded;
  if (!other) return null;
  const bytes = bytesText(Math.abs(other.bytes_saved)), memory = other.bytes_saved < 0 ? `costs ${bytes} more` : `saves ${bytes}`;
  return `${nameOf(asset)}: with layout ${other.layout} in the scene's layouts it ${memory}; the error (rel_rms, in the trial) goes from ` +
    `${percentText(other.rel_rms)} to ${percentText(other.rel_rms_then)}, the visible error (p99) from ${numberText(other.visible)} to ` +
    `${numberText(other.visible_then)}.`;
}

/** Returns the texels of a light map that no chart uses. Those of a packed map are what blocks and filters need at the rims of its charts. */
function unusedTexels(asset) {
  // Values of a ground truth lie at texels of the bake: charts stay there.
  if (asset.notes?.packing || asset.ground_truth) return null;
  const textures = asset.textures ?? [], sum = (valueOf) => textures.reduce((all, texture) => all + valueOf(texture), 0);
  const unused = sum((texture) => bytesOutsideCharts(asset, texture)), share = unused / sum(({ bytes_gpu }) => bytes_gpu);
  if (!(share >= 0.1)) return null;
  return `${nameOf(asset)}: texels outside charts take ${percentText(share)} of its textures: ${bytesText(unused)}. ${asset.charts ? "" : "Name its mesh in [[light_map]]: "}` +
    'charts = "pack" packs the light-map UVs of its mesh anew, which saves up to that. Blocks then hold texels of several charts: where a bright one comes beside a dark ' +
    "one, rel_rms may rise several times, visible errors hardly. Cook it into another folder, and compare with report --baseline.";
}

/** Returns what the largest levels of cubemaps take: one sentence for those of one size that have as many levels which no material reads. */
function cubemapLevels(assets) {
  /** By width and unread levels. @type {Map<string, { width: number, unread: number, cubemaps: any[], bytes: number }>} */
  const groups = new Map();
  for (const asset of assets) {
    const { kind, width, textures = [], notes } = asset, format = textures.length === 1 && formats[textures[0].format];
    if (kind !== "cubemap" || width < 64 || !format) continue;
    const unread = notes?.unread_levels ?? 0, bytes = unread > 0 ? notes.unread_bytes ?? 0 : 6 * Math.ceil(width / format.side) ** 2 * format.bytes;
    if (bytes >= asset.bytes_gpu) continue;
    const key = `${width} ${unread}`, group = groups.get(key) ?? { width, unread, cubemaps: /** @type {any[]} */ ([]), bytes: 0 };
    group.cubemaps.push(asset);
    group.bytes += bytes;
    groups.set(key, group);
  }
  return sorted(groups.values(), ({ width, unread }) => 1e3 * width + unread).map(({ width, unread, cubemaps, bytes }) => {
    const isOne = cubemaps.length === 1, names = isOne ? nameOf(cubemaps[0]) : `${cubemaps.length} cubemaps, '${cubemaps[0].name}' and others`;
    const whose = isOne ? "its" : "their", saved = bytesText(bytes);
    return unread > 0
      ? `${names}: no material is smooth enough to read ${whose} ${unread === 1 ? "largest level" : `${unread} largest levels`}. size = "auto" leaves ${
        unread === 1 ? "it" : "them"} out and saves ${saved}. The other levels may be encoded anew; their error keeps the same limits.`
      : `${names}: size = ${width / 2} in place of ${width} saves ${saved}, ${whose} largest ${isOne ? "level" : "levels"}. ` +
        "The error of that was not measured: cook it, and compare with report --baseline.";
  });
}

/** Returns the sentences of a report, the most important one first. @returns {string[]} */
export function adviceOf(report) {
  const assets = sorted(report.assets, ({ bytes_gpu }) => bytes_gpu);
  const found = [...proportions(report), ...assets.flatMap((asset) => [...layouts(asset), excluded(asset), unusedTexels(asset)]), ...cubemapLevels(assets)];
  return found.filter((sentence) => sentence).map((sentence) => sentence[0].toUpperCase() + sentence.slice(1));
}
