// The page of one scene.
import { make } from "../src/elements.js";
import { bytesText, counted, numberText, percentText, shortText } from "../src/units.js";
import { adviceOf, bytesOutsideCharts } from "./advice.js";
import { assetSection } from "./asset.js";
import { stageCaption, TERMS } from "./captions.js";
import { baselineSection, platformSection, trendSection } from "./compare.js";
import { firstScreen, opportunityList } from "./first.js";
import {
  anchor, budgetSentence, bytes, card, cell, DASH, fact, kindCaption, kindColor, lastStage, layoutText, limitedError, limitedVisible, link, list, number, percent, row, seconds,
  shadingsOf, shares, sizeText, soft, sorted, sub, swatch, table, titled, verdict,
} from "./parts.js";
import { frontierPlot } from "./plots.js";
import { tilesOf } from "./tiles.js";

function findings({ findings: found = [] }) {
  const standing = ({ severity, allowed }) => (allowed === undefined ? severity : allowed ? `allowed: ${allowed}` : "allowed");
  return found.length > 0 && card("Plausibility of the inputs", table("findings", ["Code", "Of", "Found, and what to do", "Severity"], found.map((each) => [
    each.code, each.asset || "the scene", [each.found, sub(each.advice)], standing(each)])));
}

// Memory

/** Makes a bar of parts of a whole. @param {{ share: number, color: string, title: string }[]} parts */
const partsBar = (parts, words, isOver, ...more) => make("div", { class: isOver ? "bar over" : "bar", role: "img", "aria-label": words },
  parts.filter(({ share }) => share > 0).map(({ share, color, title }) => make("i", { style: `width:${(100 * Math.min(share, 1)).toFixed(3)}%;background:${color}`, title })), more);

/** Makes a treemap of the assets, each divided into its textures. Of light maps, texels outside charts stand apart. */
function assetTiles(assets) {
  const tiles = assets.map((asset) => {
    const color = kindColor(asset.kind), parts = (asset.textures ?? []).flatMap((texture) => {
      const unused = bytesOutsideCharts(asset, texture), name = `${texture.role}, ${texture.format}`;
      return [
        { name, detail: unused > 0 ? "inside charts" : "", color, bytes: texture.bytes_gpu - unused },
        { name: "outside charts", detail: name, color: "var(--track)", bytes: unused },
      ];
    });
    return { name: asset.name, detail: kindCaption(asset.kind), color, link: link(asset), bytes: asset.bytes_gpu, parts };
  });
  return tilesOf(tiles, "GPU memory of each asset and of its textures; the tables below have the figures");
}

function memory({ assets, budget }) {
  const { used_bytes: used, limit_bytes: limit, by_kind, by_format } = budget, words = budgetSentence(budget);
  const isOver = limit !== null && used > limit, whole = Math.max(used, limit ?? 0), kinds = sorted(Object.entries(by_kind), ([, count]) => count);
  const parts = kinds.map(([kind, count]) => ({ share: count / whole, color: kindColor(kind), title: `${kind}: ${bytesText(count)}` }));
  const mark = isOver && make("b", { style: `left:${((100 * limit) / whole).toFixed(3)}%`, title: `limit: ${bytesText(limit)}` });
  return card("Memory", partsBar(parts, words, isOver, mark), make("p", { class: isOver ? "sentence over" : "sentence" }, words), assetTiles(assets),
    make("div", { class: "pair" }, shares("By kind", by_kind, used, true), shares("By format", by_format, used)));
}

/** Makes what another budget buys: bytes against visible error, the next steps down and up, and all allocations. */
function frontier({ frontier: points = [], limit_bytes: limit }) {
  const chosen = points.findIndex((point) => point.chosen);
  if (points.length < 2 || chosen < 0) return null;
  const words = ({ layouts }) => layouts.map((each) => `${each.light_map}: ${layoutText(each.layout, true)}`).join("; ");
  const step = (to) => `${bytesText(Math.abs(to.bytes_gpu - points[chosen].bytes_gpu))} ${to.bytes_gpu > points[chosen].bytes_gpu ? "more" : "less"} take the visible error from ${
    numberText(points[chosen].visible)} to ${numberText(to.visible)} (${words(to)}).`;
  return card("What another budget buys",
    soft("Light maps share the memory. No other choice of layouts that was tried has fewer bytes and no larger visible error of the whole " +
      "shading (99 % of what pixels show of the worst light map; of the chosen one as cooked, of the others as their trials measured it, times how much more was found of the cooked one)."),
    make("div", { class: "curve-frame" }, frontierPlot(points, limit ?? 0, words)), list([points[chosen + 1], points[chosen - 1]].filter((to) => to).map(step)),
    make("details", {}, make("summary", {}, `All ${points.length} allocations`), table("frontier", ["Layouts", "#GPU memory", "#Visible error"], points.map((point) =>
      row(point.chosen ? "total" : "", words(point) + (point.chosen ? " (chosen)" : ""), bytes(point.bytes_gpu), number(point.visible))))));
}

function advice(report, more) {
  const sentences = adviceOf(report);
  return sentences.length + more.length > 0 && card("What limits what", sentences.length > 0 && list(sentences),
    more.length > 0 && [make("h3", {}, "Further opportunities"), opportunityList(more, report.budget.used_bytes)]);
}

// The whole shading

/** Returns "mean light 3.00 %, directions 98.0 %", of the squared error. */
const stagesText = ({ stages }) => stages.filter(({ share }) => share > 0).map(({ name, share }) => `${stageCaption(name)} ${percentText(share)}`).join(", ");

function whole(error) {
  if (!error) return null;
  const parts = error.parts.filter(({ share }) => share !== 0), { light_maps: maps = [], apart } = error;
  return card("Error of the whole shading",
    make("dl", { class: "facts whole-facts" },
      fact("Error of the whole shading, RMS", percent(error.rel_rms)), fact("Upper bound of it", percent(error.rel_rms_bound))),
    partsBar(parts.map(({ asset, kind, shading, share }) => ({ share, color: kindColor(kind), title: `${asset}, ${shading}: ${percentText(share)}` })), error.advice ?? "", false),
    make("p", { class: "sentence" }, error.advice),
    parts.length > 0 && table("shares", ["Asset", "Light", "#Share of the squared error", "#RMS error of its light"], parts.map((part) => [
      [swatch(part.kind), part.asset], cell("shading", part.shading), percent(part.share), percent(part.rel_rms)])),
    parts.some(stagesText) && make("details", {}, make("summary", {}, "Shares of their stages"),
      soft("The squared error of the scene if that stage alone erred. Errors of stages cancel in part, so one can be larger than the sum."),
      table("stage-shares", ["Asset", "Light", "Stages"], parts.filter(stagesText).map((part) => [part.asset, cell("shading", part.shading), stagesText(part)]))),
    maps.length > 0 && table("shares", ["Light map", "#Of the texels", "#Whole error", "#Upper bound"], maps.map((map) => [
      [map.name, map.advice && sub(map.advice)], percent(map.weight), percent(map.rel_rms), percent(map.rel_rms_bound)])),
    apart.length > 0 && soft("No part of what the light maps' pixels show: ",
      apart.map(({ asset, kind, rel_rms }) => `${asset} (${kindCaption(kind)}, ${percentText(rel_rms)})`).join(", "), "."));
}

// All assets

/** Limits on rel_rms from here on only tell an error from light that is lost: nobody asked for them. */
const NO_ERROR_LIMIT = 2;

function limitNote({ limit, whole: shown }) {
  const limits = [["value", "RMS error"], ["max_visible", "visible error"], ["max_visible_bound", "visible bound"], ["max_seam", "seam"]].filter(([key]) =>
    typeof limit[key] === "number" && !(key === "value" && limit.value >= NO_ERROR_LIMIT));
  const words = limits.map(([key, name]) => [`${name} `, key === "value" ? percent(limit.value) : shortText(limit[key])]);
  // Figures of the light map alone stand in the columns, those of the whole shading here.
  if (typeof shown?.max_visible === "number") words.push([`visible error of the whole shading ${numberText(shown.visible.p99)} of ${shortText(shown.max_visible)}`]);
  if (typeof shown?.max_error === "number") words.push(["RMS error of the whole shading ", percent(shown.rel_rms), ` of ${percentText(shown.max_error)}`]);
  return words.length > 0 && make("span", { class: "sub" }, `limit${words.length > 1 ? "s" : ""}: `, words.map((each, i) => [i > 0 && ", ", each]));
}

/** Makes the rows of an asset, one for each kind of shading. The first has the cells that all share. */
function assetRows(asset, hasBounds) {
  const shadings = shadingsOf(asset), { error } = lastStage(asset), rowspan = shadings.length, shared = (kind, ...content) => make("td", { class: `num ${kind}`, rowspan }, content);
  const name = make("th", { scope: "rowgroup", rowspan }, make("a", { href: link(asset) }, asset.name),
    make("span", { class: "sub" }, swatch(asset.kind), [kindCaption(asset.kind), sizeText(asset), layoutText(asset.choice ?? asset.layout)].filter((each) => each).join(", ")), limitNote(asset));
  return make("tbody", {}, shadings.map((shading, i) => {
    const figures = error[shading];
    const bits = asset.bits_per_texel > 0 ? number(asset.bits_per_texel) : titled(DASH, "0");
    return make("tr", {}, i === 0 && [name, make("td", { class: "named", rowspan }, verdict(asset.passed)), shared("", bytes(asset.bytes_gpu)), shared("wide", bytes(asset.bytes_disk)), shared("wide", bits)],
      cell("shading", shading), limitedError(figures, asset),
      (hasBounds ? ["p99", "bound"] : ["p99"]).map((key) => limitedVisible(figures, key, asset)));
  }));
}

function allAssets({ assets }) {
  if (assets.length === 0) return card("Assets", soft("No assets were cooked."));
  const hasBounds = assets.some(({ limit }) => typeof limit.max_visible_bound === "number");
  const framed = table(hasBounds ? "assets bounded" : "assets", ["Asset", "Verdict", "#GPU", "#Disk", "#Bits per texel", "Shading", "#RMS error", "#Visible error", ...(hasBounds ? ["#Visible bound"] : [])], []);
  // Columns that narrow screens leave out, and those that stand over the figures there.
  for (const [kind, columns] of Object.entries({ wide: [3, 4], named: [0, 1] })) for (const at of columns) framed.querySelectorAll("th")[at].classList.add(kind);
  framed.querySelector("tbody")?.replaceWith(...assets.map((asset) => assetRows(asset, hasBounds)));
  return card("Assets", framed, soft("RMS error: of all samples, relative to their light. Visible error: 99 % of the samples differ by less, in just noticeable differences. " +
    "Thin lines show both on the way to their limits. Point at a number for its exact value; the sections of the assets below have the largest samples and the bounds."));
}

// Skipped work, and the meaning of the terms

function skips({ skipped }) {
  if (skipped.length === 0) return card("Skipped", soft("Nothing was skipped."));
  const sum = (skips, key) => skips.reduce((all, skip) => all + (skip[key] ?? 0), 0), isMeasured = (skips) => skips.some((skip) => typeof skip.seconds_saved === "number");
  // Assets that are skipped for one reason, and results of earlier cooks, are one row each.
  /** @type {Map<string, any[]>} */
  const groups = new Map();
  for (const skip of skipped) {
    const key = skip.asset === undefined ? "" : skip.why;
    groups.set(key, [...groups.get(key) ?? [], skip]);
  }
  const whatOf = (skips) => (skips[0].asset === undefined ? counted(skips.length, "result") : skips[0].what + (skips.length > 1 ? ` and ${skips.length - 1} more` : ""));
  const saved = (skips) => [bytes(sum(skips, "bytes_saved")), seconds(isMeasured(skips) ? sum(skips, "seconds_saved") : null)];
  return card("Skipped", table("skips", ["What", "Why", "#Memory saved", "#Time saved"], [
    ...[...groups.values()].map((skips) => [titled(whatOf(skips), skips.map(({ what }) => what).join(", ")), skips[0].asset === undefined ? "taken from the cache" : skips[0].why, ...saved(skips)]),
    row("total", "Together", "", ...saved(skipped))]));
}

/** Says what made the report, and what its terms mean. */
function footnote({ runs = [], tool, peak_rss_bytes: peak }) {
  const made = runs.map(({ at }) => at).filter((at) => at).join(", ");
  return make("footer", {}, make("h2", {}, "What the figures mean"), make("dl", {}, Object.entries(TERMS).map(([term, meaning]) => [make("dt", {}, term), make("dd", {}, meaning)])),
    make("p", {}, `Made by ${tool ? `${tool.name} ${tool.version}, ` : ""}${made ? `${runs.length > 1 ? "runs" : "the run"} of ${made}` : "this run"}; peak memory ${bytesText(peak)}.${runs.some(({ walls }) => walls?.includes("none")) ? " Input files were decoded without walls (--no-sandbox)." : ""}`));
}

/** Makes the page of a scene. */
export function scenePage({ report, history, uses }) {
  const { sections, more } = firstScreen(report, uses);
  return [
    ...sections, findings(report), platformSection(report.platforms), baselineSection(report.baseline), trendSection(history, true), allAssets(report),
    report.assets.map((asset) => assetSection(asset, anchor(asset))), memory(report), frontier(report.budget), advice(report, more), whole(report.whole), skips(report), footnote(report),
  ];
}
