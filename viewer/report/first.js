// The first screen of a scene's page: verdict, memory before and after, what failed, a picture to wipe, and the largest opportunities.
import { make } from "../src/elements.js";
import { failureTexts, plain } from "../src/failure_text.js";
import { bytesRead } from "../src/sizes.js";
import { bytesText, counted, numberText, percentText } from "../src/units.js";
import { errorText, gainText, opportunitiesOf } from "./opportunities.js";
import { budgetSentence, bytes, card, fact, kindCaption, lastStage, link, seconds, soft, sorted, sub, verdict } from "./parts.js";
import { pictures, sharpness, sizeOf } from "./pictures.js";

const SHOWN = 3;
/** Share of the bake at first, as style.css has it [percent]: the line and its knob leave the place in the middle free. */
const WIPED = 44;

/** Returns the verdict in a sentence: assets, and the one nearest to a limit of its own. */
function verdictSentence({ assets, incomplete, partial }, uses) {
  const failed = assets.filter(({ passed }) => !passed).length;
  let sentence = failed === 0 ? "Every asset keeps its limit" : `${failed} of ${counted(assets.length, "asset")} failed`, most = 0, nearest = -1;
  if (incomplete?.assets.length > 0) sentence = `Not cooked: ${incomplete.assets.join(", ")}. ${sentence}`;
  if (partial) sentence = `This is a part of the scene; cook --only left out: ${partial.join(", ")}. ${sentence}`;
  uses.forEach((use, i) => {
    const share = use ? use.share ?? Infinity : 0;  // one that is not finite is null
    if (share > most) [most, nearest] = [share, i];
  });
  if (nearest >= 0) sentence += `; ${assets[nearest].name} is ${most > 1 ? "furthest over its limit" : "nearest to its limit"}: ${plain(uses[nearest].words)}${
    most <= 1 ? `, ${percentText(most)} of it` : ""}`;
  return `${sentence}.`;
}

/** Makes name, verdict and memory. */
function header(report, uses) {
  const { assets, budget } = report, { used_bytes: used, limit_bytes: limit } = budget, read = bytesRead(assets), isOver = limit !== null && used > limit;
  const packed = used > read && read > 0 && sub("the files are packed for the disk: no GPU reads them so");
  const sizes = fact(read > 0 ? "Compressed files → GPU memory" : "GPU memory", read > 0 && [bytes(read), " → "], make("b", {}, bytes(used)), packed);
  sizes.className = "sizes";
  const left = limit === null ? "none" : [bytesText(limit), make("span", { class: isOver ? "sub over" : "sub" }, `${limit > 0 ? `${percentText(used / limit)} used, ` : ""}${
    bytesText(Math.abs(limit - used))} ${isOver ? "over" : "free"}`)];
  return make("header", {}, make("p", { class: "eyebrow" }, "Cooked lighting"), make("div", { class: "title" }, make("h1", {}, report.scene), verdict(report.passed)),
    make("p", { class: "lead" }, verdictSentence(report, uses)),
    make("dl", { class: "facts first-facts" }, sizes, fact("Memory budget", left),
      fact("Assets passed", `${assets.filter(({ passed }) => passed).length} of ${assets.length}`), fact("Time to cook and verify", seconds(report.seconds))));
}

/** Makes a sentence in which lines of a scene file, and commands between backquotes, are code. @param {string} words */
const marked = (words) => words.split(/(`[^`]+`|\b[a-z_]+ = (?:"[^"]*"|\[[^\]]*\]|true|false|[0-9.]*[0-9]))/).map((part, i) =>
  (i % 2 === 1 ? make("code", {}, part.replaceAll("`", "")) : part));

function failures({ assets, budget }) {
  const lines = assets.flatMap(({ name, passed, failures: reasons = [] }) => (passed ? [] : failureTexts(name, reasons).map(({ found, worst, advice }) =>
    make("li", {}, make("a", { href: link({ name }) }, name), `: ${found}`, advice && sub(marked(advice)),
      worst && make("details", { class: "where" }, make("summary", {}, "The worst place"), `At ${worst}.`)))));
  if (budget.limit_bytes !== null && budget.used_bytes > budget.limit_bytes) lines.push(make("li", {}, `memory budget: ${budgetSentence(budget)}`, budget.advice && sub(marked(budget.advice))));
  return lines.length > 0 && make("section", { class: "card failures" }, make("h2", {}, "What failed"), make("ul", {}, lines));
}

// Before and after

/** Returns the two pictures that show most: the mesh around the worst seam if that is what failed, or around the largest visible error that has a view; else the
 * texels of the largest light map or, without one, of the largest asset with pictures; and their words. */
function beforeAndAfter(assets) {
  const isThere = (pair) => pair && pair.reference in pictures && pair.cooked in pictures;
  const isSeamAlone = ({ failures: reasons = [] }) => reasons.length > 0 && reasons.every(({ seam }) => seam !== undefined);
  const torn = assets.find((asset) => isSeamAlone(asset) && isThere(asset.preview?.seams?.[0]));
  if (torn) {
    const [{ added, texels: [at, other] }] = torn.seams.worst, placeOf = (texel) => texel.map((each) => numberText(each)).join(", ");
    return {
      pair: torn.preview.seams[0], kind: "smooth", sides: ["Bake", "Cooked"], title: "Before and after, at the worst seam",
      words: `${torn.name}: the charts meet in the middle, at texels ${placeOf(at)} and ${placeOf(other)}. Cooking adds a step of ${numberText(added)} there, for one normal or view; 1 is just ` +
        "noticeable. A white surface under the light map alone, at its own normals.",
    };
  }
  const places = assets.flatMap((asset) => (asset.preview?.worst ?? []).filter(({ view }) => isThere(view)).map((place) => ({ asset, place })));
  const [worst] = sorted(places, ({ place }) => place.visible ?? 1e300);
  if (worst) {
    const { asset, place } = worst, below = lastStage(asset).error.diffuse?.visible?.p99;
    return {
      pair: place.view, kind: "smooth", sides: ["Bake", "Cooked"], title: "Before and after, at the worst place of diffuse light",
      words: `${asset.name} around texel ${place.texel.join(", ")}, the worst of its pictures: visible error ${numberText(place.visible)} there${
        Number.isFinite(below) ? `, below ${numberText(below)} at 99 % of the map's samples` : ""}; 1 is just noticeable. A white surface under the light map alone, without its materials.`,
    };
  }
  const [asset] = sorted(assets.filter(({ preview }) => isThere(preview)), ({ kind, bytes_gpu }) => bytes_gpu + (kind === "light-map" ? 1e15 : 0));
  return asset && {
    pair: asset.preview, kind: sharpness(sizeOf(pictures[asset.preview.reference])), sides: ["Reference", "Cooked"], title: "Before and after",
    words: `The texels of the ${kindCaption(asset.kind)} ${asset.name}, not a view of the scene.`,
  };
}

/** Makes two pictures over each other, with a line between bake and cooked that one can move. */
function wipe(assets) {
  const shown = beforeAndAfter(assets);
  if (!shown) return null;
  const { pair, kind, sides: [before, after] } = shown, { width, height } = sizeOf(pictures[pair.reference]);
  const layer = (side, alt, file) => make("img", { class: `${side} ${kind} light`, src: pictures[file], alt });
  const frame = make("div", { class: "wipe", style: `aspect-ratio:${width}/${height}` }, layer("before", before, pair.reference), layer("after", after, pair.cooked),
    make("span", { class: "side" }, before), make("span", { class: "side right" }, after), make("i", { class: "line" }));
  const range = make("input", { type: "range", min: 0, max: 100, step: 0.5, value: WIPED, "aria-label": "Wipe between bake and cooked",
    oninput: () => frame.style.setProperty("--at", `${range.value}%`) });
  frame.append(range);
  return card(shown.title, frame, soft(shown.words));
}

// Opportunities

function opportunity(each, used) {
  const change = errorText(each);
  return make("li", {}, make("b", {}, gainText(each, used)), make("p", {}, change, marked(change ? each.words : each.words[0].toUpperCase() + each.words.slice(1))),
    make("p", { class: "line" }, each.lines.map((line) => [make("code", {}, line), " "]), make("span", { class: "soft" }, `in ${each.where}`)));
}

/** Makes a list of opportunities. @param {import("./opportunities.js").Opportunity[]} found @param {number} used bytes of the scene */
export const opportunityList = (found, used) => found.length > 0 && make("ol", { class: "opportunities" }, found.map((each) => opportunity(each, used)));

function opportunities(found, used, isPassed) {
  return card(found.length === 0 ? "Opportunities" : found.length === 1 ? "The largest opportunity" : `The ${Math.min(found.length, SHOWN)} largest opportunities`,
    found.length > 0 ? opportunityList(found.slice(0, SHOWN), used) : soft(isPassed ? "Nothing that was tried gains more than it costs." : "The advice stands under What failed."));
}

/** Makes the first screen, and returns with it the opportunities that it has no room for. */
export function firstScreen(report, uses) {
  const found = opportunitiesOf(report), used = report.budget.used_bytes;
  return { sections: [header(report, uses), failures(report), make("div", { class: "opening" }, wipe(report.assets), opportunities(found, used, report.passed))], more: found.slice(SHOWN) };
}
