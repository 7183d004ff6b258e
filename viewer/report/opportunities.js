// What a change of the scene file would save or improve, each with the line to write. Figures were measured in the cook (allocations and layouts that
// were tried) or follow from sizes alone.
//
// Of the steps to less memory, and of those to a smaller error, the one with the least bytes times error counts, if that product is below today's: it
// gains more than it costs. Visible errors below 1 count as 1, since nobody sees them; a step up takes at most twice the memory.
import { bytesText, numberText, percentText } from "../src/units.js";
import { alternativesOf, bytesOutsideCharts } from "./advice.js";
import { formats, lastStage, layoutText, nameOf, shadingsOf, sorted } from "./parts.js";

/** @typedef {{ saved: number, error?: { name: string, from: number, to: number, text: (value: number) => string }, words: string, lines: string[], where: string,
 *   isMeasured: boolean, isAtMost?: boolean }} Opportunity saved: bytes of GPU memory, negative for what costs some; lines: to write in the section `where` of the scene file */

const JUST_VISIBLE = 1, MOST_GROWTH = 2;

/** Returns a limit that allows a figure: rounded up to three digits. @param {number} value */
function limitAbove(value) {
  const step = 10 ** (Math.floor(Math.log10(value)) - 2);
  return Number((step * Math.ceil(value / step - 1e-9)).toPrecision(3));
}

/** Returns the step to less memory and the one to a smaller error that gain more than they cost. @template T @param {T[]} steps @param {T} chosen
 * @param {(step: T) => number} bytesOf @param {(step: T) => number} errorOf @param {boolean} isVisible */
function trades(steps, chosen, bytesOf, errorOf, isVisible) {
  const product = (each) => bytesOf(each) * Math.max(errorOf(each), isVisible ? JUST_VISIBLE : 0);
  const best = (isStep) => sorted(steps.filter((each) => isStep(each) && product(each) < product(chosen)), (each) => -product(each))[0];
  return [
    best((each) => bytesOf(each) < bytesOf(chosen)),
    best((each) => bytesOf(each) >= bytesOf(chosen) && bytesOf(each) <= MOST_GROWTH * bytesOf(chosen) && errorOf(each) < errorOf(chosen)),
  ].filter((each) => each !== undefined);
}

/** Returns the layouts of light maps that another budget, or another limit on the whole shading, chooses. @returns {Opportunity[]} */
function allocations({ budget, assets }) {
  const points = budget.frontier ?? [], chosen = points.find((point) => point.chosen), limit = assets.find(({ whole }) => typeof whole?.max_visible === "number")?.whole.max_visible;
  if (!chosen || (budget.limit_bytes === null && limit === undefined)) return [];
  return trades(points, chosen, ({ bytes_gpu }) => bytes_gpu, ({ visible }) => visible ?? Infinity, true).map((to) => {
    const changed = to.layouts.filter((each, i) => each.layout !== chosen.layouts[i]?.layout);
    const names = changed.slice(0, 2).map((each) => `${each.light_map} as ${layoutText(each.layout, true)}`);
    if (changed.length > names.length) names.push(`${changed.length - names.length} more`);
    const newLimit = limitAbove(to.visible), isBudget = budget.limit_bytes !== null;
    return {
      saved: chosen.bytes_gpu - to.bytes_gpu, error: { name: "visible error of the whole shading", from: chosen.visible ?? Infinity, to: to.visible, text: numberText }, words: `${names.join(", ")}.`,
      lines: [...(isBudget ? [`budget = "${Math.ceil(to.bytes_gpu / 1024)} KiB"`] : []), ...(!isBudget || to.visible > limit ? [`max_whole_visible = ${newLimit}`] : [])],
      where: "[output]", isMeasured: true,
    };
  });
}

/** Returns how much more the verification of a light map found than the trial of its layout, which may have looked at a part of it; at least 1. */
function excessOfTrial(asset, tried, isVisible) {
  const { error } = lastStage(asset), found = shadingsOf(asset).map((shading) => (isVisible ? error[shading]?.visible?.p99 : error[shading]?.rel_rms) ?? 0);
  return tried > 0 ? Math.max(1, Math.max(...found) / tried) : 1;
}

/** Returns the layouts that a light map may have in place of its own, where no allocation chose it. @returns {Opportunity[]} */
function layouts(asset, isAlone) {
  const { chosen, errorOf: triedError, isVisible, limit, text } = alternativesOf(asset);
  if (!chosen) return [];
  const excess = excessOfTrial(asset, triedError(chosen), isVisible), errorOf = (each) => excess * triedError(each);
  const steps = asset.trial_candidates.filter(({ excluded }) => !excluded), where = asset.trial_share < 1 ? `, measured on ${percentText(asset.trial_share)} of the map` : "";
  return trades(steps, chosen, ({ bytes_gpu }) => bytes_gpu, errorOf, isVisible).map((to) => {
    const isOver = errorOf(to) > limit, name = isVisible ? "visible error" : "RMS error";
    // "auto" takes the smallest layout that a limit allows.
    const [layout, detail] = to.layout.split("+"), asNamed = [`light_map_layout = "${layout}"`, ...(detail ? ["detail = true"] : [])];
    const asListed = [`layouts = ["${layout}"${detail ? `, "${detail.split("@")[0]}"` : ""}]`];
    const lines = isOver ? [`${isVisible ? "max_visible" : "max_error"} = ${limitAbove(errorOf(to))}`] : isAlone ? asNamed : asListed;
    return {
      saved: chosen.bytes_gpu - to.bytes_gpu, error: { name, from: errorOf(chosen), to: errorOf(to), text },
      words: `${nameOf(asset)} as ${layoutText(to.layout, true)} in place of ${layoutText(chosen.layout, true)}${where}${isOver ? `; today's limit is ${text(limit)}` : ""}.`,
      lines, where: isAlone || (isOver && !isVisible) ? "[output]" : `[[light_map]] ${asset.name}`, isMeasured: true,
    };
  });
}

const NOT_MEASURED = "What that does to the error was not measured: cook it into another folder, and compare with `report --baseline`.";

/** Returns a dominant light without textures. @returns {Opportunity[]} */
function derivedDominant({ assets }) {
  return assets.filter(({ kind, notes }) => kind === "dominant" && notes?.fit === "explained").flatMap((asset) => {
    const map = sorted(assets.filter(({ kind, name }) => kind === "light-map" && asset.name.startsWith(`${name}_`)), ({ name }) => name.length)[0];
    if (!map) return [];
    return [{
      saved: asset.bytes_gpu, words: `Without ${nameOf(asset)}: the shader derives the light from the light map (lcDerivedLight). ${NOT_MEASURED}`,
      lines: ['dominant_layout = "derived"'], where: `[[light_map]] ${map.name}`, isMeasured: false,
    }];
  });
}

/** Returns the texels of a light map that no chart uses. Those of a packed map are what blocks and filters need at the rims of its charts. @returns {Opportunity[]} */
function unusedTexels(asset) {
  // Values of a ground truth lie at texels of the bake: charts stay there.
  if (asset.notes?.packing || asset.ground_truth) return [];
  const textures = asset.textures ?? [], sum = (valueOf) => textures.reduce((all, texture) => all + valueOf(texture), 0);
  const unused = sum((texture) => bytesOutsideCharts(asset, texture)), share = unused / sum(({ bytes_gpu }) => bytes_gpu);
  if (!(share >= 0.1)) return [];
  return [{
    saved: unused, isAtMost: true, isMeasured: false,
    words: `${percentText(share)} of the textures of ${nameOf(asset)} lie outside charts: packed anew, they need fewer texels${asset.charts ? "" : ". Name the mesh in [[light_map]] for that"}. ` +
      "Where a bright chart comes beside a dark one, the RMS error may rise several times, visible errors hardly: compare with `report --baseline`.",
    lines: ['charts = "pack"'], where: "[output]",
  }];
}

/** Returns the largest levels of cubemaps: one opportunity for those of one size that have as many levels which no material reads. @returns {Opportunity[]} */
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
  return [...groups.values()].map(({ width, unread, cubemaps, bytes }) => {
    const isOne = cubemaps.length === 1, names = isOne ? nameOf(cubemaps[0]) : `${cubemaps.length} cubemaps, '${cubemaps[0].name}' and others`;
    const whose = isOne ? "its" : "their", where = isOne ? `[[probe]] ${cubemaps[0].name}` : "each [[probe]]";
    return unread > 0
      ? { saved: bytes, words: `${names}: no material is smooth enough to read ${whose} ${unread === 1 ? "largest level" : `${unread} largest levels`}.`, lines: ['size = "auto"'], where, isMeasured: true }
      : { saved: bytes, words: `${names} without ${whose} largest ${isOne ? "level" : "levels"}, size ${width}. ${NOT_MEASURED}`, lines: [`size = ${width / 2}`], where, isMeasured: false };
  });
}

/** Returns the share of an error that goes: all that counts of one that is not finite. */
const removed = ({ from, to }) => (Number.isFinite(from) ? (from - to) / from : 1);

/** Returns what an opportunity gains, of the scene's memory or of the error. */
const gainOf = ({ saved, error }, used) => (saved > 0 ? saved / used : error ? removed(error) : 0);

/** Returns true for what does not make worse what fails: a scene over its limits gets nothing that may raise an error, one over its budget nothing that costs memory. */
function isFitting({ saved, error, isMeasured }, { assets, budget }) {
  const isSafe = error ? !(error.to > error.from) : isMeasured, isOver = budget.limit_bytes !== null && budget.used_bytes > budget.limit_bytes;
  return (isSafe || assets.every(({ passed }) => passed)) && (saved > 0 || !isOver);
}

/** Returns the opportunities of a report, the largest share of the memory or of the error first; those whose error was not measured come last. @returns {Opportunity[]} */
export function opportunitiesOf(report) {
  const maps = report.assets.filter(({ kind }) => kind === "light-map");
  // A layout that no allocation has would break the limit, or the budget, that chose them.
  const all = [...allocations(report), ...(report.budget.frontier?.length > 0 ? [] : maps.flatMap((map) => layouts(map, maps.length === 1))), ...maps.flatMap(unusedTexels), ...derivedDominant(report),
    ...cubemapLevels(report.assets)].filter((each) => isFitting(each, report));
  return sorted(all, (each) => (each.isMeasured ? 1e3 : 0) + Math.min(gainOf(each, report.budget.used_bytes), 1));
}

/** Returns what an opportunity gains, in a few words: "Save up to 642 KiB (56.5 % of the memory)". @param {Opportunity} opportunity @param {number} used bytes */
export function gainText({ saved, error, isAtMost }, used) {
  if (saved > 0) return `Save ${isAtMost ? "up to " : ""}${bytesText(saved)} (${percentText(saved / used)} of the memory)`;
  return error ? `${percentText(removed(error))} less ${error.name}, for ${saved === 0 ? "the same memory" : `${bytesText(-saved)} more`}` : "";
}

/** Returns how the error changes: "The visible error goes from 4.85 to 9.43: "; empty where it was not measured. @param {Opportunity} opportunity */
export function errorText({ error }) {
  if (!error) return "";
  const [from, to] = [error.from, error.to].map(error.text);
  return `The ${error.name} ${from === to ? `stays at ${to}` : `${error.to > error.from ? "grows" : "falls"} from ${from} to ${to}`}: `;
}
