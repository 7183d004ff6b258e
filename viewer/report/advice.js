// Sentences about layouts that the scene's list lacks, and the layouts beside the chosen one. Each has figures that were measured in the cook.
import { bytesText, numberText, percentText } from "../src/units.js";
import { nameOf, sorted } from "./parts.js";

/** Textures of a light map that are not its texels, or those of some of its tiles. */
const LOOKUPS = ["tables", "index", "coverage", "detail_hdr", "detail_ldr"];

/** Returns the bytes of a light map's texture that lie outside charts; 0 for what is looked up beside its texels, and for other assets. */
export function bytesOutsideCharts({ kind, width, height, notes }, { role, bytes_gpu }) {
  const share = (notes?.covered_texels ?? NaN) / (width * height);
  return kind === "light-map" && !LOOKUPS.includes(role) && share < 1 ? Math.floor(bytes_gpu * (1 - share)) : 0;
}

/**
 * Returns three of the layouts that were tried for a light map: the chosen one, the best of the smaller ones, and the smallest of the better ones;
 * and the figure that compares them, of diffuse and specular light alike: visible error where the map has a limit on it, else rel_rms.
 */
export function alternativesOf({ trial_candidates: tried, layout, choice, limit }) {
  /** @type {any[]} */
  const candidates = tried ?? [];
  const isVisible = typeof limit?.max_visible === "number" && candidates.every((each) => Number.isFinite(each.visible_diffuse) && Number.isFinite(each.visible_specular));
  const errorOf = (each) => (isVisible ? Math.max(each.visible_diffuse, each.visible_specular) : Math.max(each.diffuse ?? Infinity, each.specular ?? Infinity));
  const chosen = candidates.find((each) => each.layout === (choice ?? layout)), others = candidates.filter((each) => !each.excluded);
  const least = (items, valueOf) => items.reduce((best, each) => (best && valueOf(best) <= valueOf(each) ? best : each), undefined);
  const bytesOf = (each) => each.bytes_gpu;
  return {
    chosen,
    cheaper: chosen && least(others.filter((each) => each.bytes_gpu < chosen.bytes_gpu), errorOf),
    better: chosen && least(others.filter((each) => errorOf(each) < errorOf(chosen)), bytesOf),
    errorOf,
    isVisible,
    limit: isVisible ? limit.max_visible : limit?.value,
    text: isVisible ? numberText : percentText,
  };
}

/** Returns the layout that the scene's list lacks and the map would be better off with. */
function excluded(asset) {
  const other = asset.better_excluded;
  if (!other) return null;
  const bytes = bytesText(Math.abs(other.bytes_saved)), memory = other.bytes_saved < 0 ? `costs ${bytes} more` : `saves ${bytes}`;
  return `${nameOf(asset)}: with layout ${other.layout} in the scene's layouts it ${memory}; the RMS error goes from ` +
    `${percentText(other.rel_rms)} to ${percentText(other.rel_rms_then)}, the visible error from ${numberText(other.visible)} to ` +
    `${numberText(other.visible_then)}, as the trial measured them.`;
}

/** Returns the sentences of a report, those of the largest asset first. @returns {string[]} */
export function adviceOf({ assets }) {
  const found = sorted(assets, ({ bytes_gpu }) => bytes_gpu).map(excluded).filter((sentence) => sentence !== null);
  return found.map((sentence) => sentence[0].toUpperCase() + sentence.slice(1));
}
