// Sections about more than one report: a baseline, the budgets of platforms, a history; and the page of several scenes.
import { make } from "../src/elements.js";
import { bytesText, counted, countText, numberText, percentText, shortText, visibleText } from "../src/units.js";
import {
  bar, bytes, card, cell, DASH, fact, figure, kindCaption, kindColor, row, seconds, shares, shareOf, soft, sorted, sub, table, titled, verdict,
} from "./parts.js";
import { grownErrors } from "./pictures.js";
import { trendPoints, trends } from "./plots.js";
import { tilesOf } from "./tiles.js";

const growthText = (value) => (Number.isFinite(value) ? `${value < 0 ? "" : "+"}${value.toFixed(2)} %` : DASH);
const growth = (value) => (Number.isFinite(value) ? titled(growthText(value), String(value)) : DASH);
/** Growth of nothing to something has no percentage. */
const isNew = ({ bytes_before, bytes_now }) => bytes_before === 0 && bytes_now > 0;
/** Returns "at most 2 % more GPU memory and 5 % more error pass"; empty where any growth does. */
function allowedText({ allowed_percent: memory, allowed_error_percent: error }) {
  const parts = [[memory, "GPU memory"], [error, "error"]].filter(([percent]) => percent !== undefined).map(([percent, what]) => `${shortText(percent, 6)} % more ${what}`);
  return parts.length > 0 ? `at most ${parts.join(" and ")} ${parts.length > 1 ? "pass" : "passes"}` : "";
}

const grown = ({ before, now }) => (now?.bytes_gpu ?? 0) - (before?.bytes_gpu ?? 0);

function changeRow(asset, name) {
  const { before, now } = asset, layouts = before && now && before.layout !== now.layout && `${before.layout} → ${now.layout}`;
  // One figure of both where they read the same.
  const both = (key, text) => {
    const [was, is] = [before, now].map((report) => (Number.isFinite(report?.[key]) ? figure(report, key, text) : make("span", {}, DASH)));
    return was.textContent === is.textContent ? is : [was, " → ", is];
  };
  const verdicts = before && now && before.passed !== now.passed ? (now.passed ? ", passes now" : ", fails now") : "";
  return [
    [name, layouts && sub(layouts)], before ? bytes(before.bytes_gpu) : DASH, now ? bytes(now.bytes_gpu) : DASH, growth(asset.growth_percent),
    both("diffuse_rel_rms", percentText), both("specular_rel_rms", percentText), both("visible_p99", visibleText), asset.change + verdicts];
}

const changeTable = (rows) => table("baseline", ["Asset", "#GPU before", "#GPU now", "#Growth", "#Diffuse RMS error", "#Specular RMS error", "#Visible error", "Change"], rows);

function changes(sentence, rows, pictures) {
  const shown = pictures.filter((each) => each);
  return card("Compared with the baseline", sentence, rows.length > 0 && changeTable(rows), shown.length > 0 && [make("h3", {}, "Where errors grew"), shown]);
}

/** Makes the comparison of a scene with an older report. */
export function baselineSection(baseline) {
  if (!baseline) return null;
  const assets = sorted(baseline.assets, grown), allowed = allowedText(baseline);
  const sum = row("total", "Together", bytes(baseline.bytes_before), bytes(baseline.bytes_now),
    isNew(baseline) ? "new" : growth(baseline.growth_percent), "", "", "", cell("", verdict(baseline.passed)));
  return changes(soft(`${baseline.file}: ${allowed || "no growth was forbidden (--fail-over, --fail-over-error)"}.`),
    [...assets.map((asset) => changeRow(asset, asset.name)), sum], assets.map((asset) => grownErrors(asset, asset.name)));
}

const longBar = (share) => bar("meter long", share);

/** Makes the limits of each platform: those that are passed, and the fullest of the others. */
export function platformSection(platforms) {
  if (!platforms?.length) return null;
  const share = ({ used_bytes, limit_bytes }) => shareOf(used_bytes, limit_bytes), where = ({ scene, of }) => (scene ? scene + (of ? `, ${of}` : "") : "all scenes together");
  return card("Budgets of platforms", platforms.map((platform) => {
    const checks = [...platform.checks].sort((a, b) => (share(a) === share(b) ? 0 : share(b) - share(a))), kept = checks.filter(({ passed }) => passed).slice(0, 5);
    const shown = checks.filter((check) => !check.passed || kept.includes(check)).slice(0, 40);
    return [
      make("div", { class: "title small" }, make("h3", {}, platform.name), verdict(platform.passed)),
      soft(`${bytesText(platform.used_bytes)} in ${counted(platform.scenes, "scene")}${platform.target ? ` cooked for ${platform.target}` : ""}.`),
      shown.length > 0 && table("checks", ["Limit", "#GPU memory", "#Budget", "#Used", "Verdict"], shown.map((check) => [
        where(check), bytes(check.used_bytes), bytes(check.limit_bytes),
        cell(check.passed ? "num" : "num over", percentText(share(check)), longBar(share(check))), verdict(check.passed)])),
      shown.length < checks.length && soft(`The fullest ${shown.length} of ${checks.length} limits.`),
    ];
  }));
}

/** Makes the trend of a history. @param {any[]} history @param {boolean} isOneScene */
export function trendSection(history, isOneScene) {
  const points = trendPoints(history);
  return points.length > 1 && card("Over time", make("div", { class: "pair trends" }, trends(points, isOneScene)),
    soft(`${points.length} steps. Red dots: ${isOneScene ? "the scene failed" : "a scene failed"}.`));
}

// Several scenes

function header({ scenes, passed, totals, tool }) {
  return make("header", {}, make("p", { class: "eyebrow" }, "Cooked lighting"),
    make("div", { class: "title" }, make("h1", {}, counted(scenes.length, "scene")), verdict(passed)),
    make("dl", { class: "facts" },
      fact("Scenes passed", `${scenes.filter((scene) => scene.passed).length} of ${scenes.length}`), fact("GPU memory", bytes(totals.bytes_gpu)),
      fact("Disk", bytes(totals.bytes_disk)), fact("Saved by skipping", bytes(totals.bytes_saved)),
      fact("Time of the cooks", seconds(scenes.reduce((sum, scene) => sum + scene.seconds, 0))), fact("Tool", `${tool.name} ${tool.version}`)));
}

function failures(scenes, errors) {
  const lines = [...scenes.flatMap((scene) => scene.errors.map((error) => [make("b", {}, scene.name), `: ${error}`])), ...errors], most = 30;
  if (lines.length > most) lines.splice(most, Infinity, `and ${lines.length - most} more`);
  return lines.length > 0 && make("section", { class: "card failures" }, make("h2", {}, "What failed"), make("ul", {}, lines.map((line) => make("li", {}, line))));
}

function growthSection(baseline) {
  if (!baseline) return null;
  const assets = baseline.scenes.flatMap((scene) => scene.assets.map((asset) => ({ asset, name: `${scene.name}: ${asset.name}` }))), most = 100;
  const { file, scenes, bytes_before: before, bytes_now: now } = baseline, allowed = allowedText(baseline);
  const changed = scenes.filter(({ change }) => change !== "same").length, change = isNew(baseline) ? "new" : growthText(baseline.growth_percent);
  const limit = allowed && `; ${allowed}`;
  const rest = assets.length > most ? ` The table shows ${most} of ${assets.length} assets that changed.` : "";
  const sentence = `${file}: ${changed} of ${scenes.length} scenes changed, ${bytesText(before)} to ${bytesText(now)} (${change}${limit}).${rest}`;
  return changes(make("p", { class: baseline.passed ? "soft" : "over" }, sentence), assets.slice(0, most).map(({ asset, name }) => changeRow(asset, name)),
    assets.filter(({ asset }) => asset.picture_now).slice(0, 12).map(({ asset, name }) => grownErrors(asset, name)));
}

function memory({ scenes, totals }, links) {
  const tiles = scenes.map((scene, i) => {
    const parts = Object.entries(scene.budget.by_kind).map(([kind, count]) => ({ name: kindCaption(kind), detail: scene.name, color: kindColor(kind), bytes: count }));
    return { name: scene.name, detail: scene.target, color: parts.length === 1 ? parts[0].color : "var(--track)", link: links[i], bytes: scene.budget.used_bytes, parts };
  });
  return card("Memory", tilesOf(tiles, "GPU memory of every scene, by kind of asset; the table below has the figures"),
    make("div", { class: "pair" }, shares("By kind", totals.by_kind, totals.bytes_gpu, true), shares("By format", totals.by_format, totals.bytes_gpu),
      shares("By target", totals.by_target, totals.bytes_gpu)));
}

/** Makes a cell that is sorted by a value; those without one come first. */
const valueCell = (value, content, isOver = false) => {
  const made = cell(isOver ? "num over" : "num", content);
  made.dataset.value = String(value ?? -1);
  return made;
};

function sceneRow(scene, link, uses, most) {
  const { used_bytes: used, limit_bytes: limit } = scene.budget, ofBudget = limit > 0 ? used / limit : undefined;
  // A share that is not finite is null.
  const limited = scene.assets.map(({ name }, i) => ({ name, ...uses[i], share: uses[i] ? uses[i].share ?? 1e300 : -1 })).filter(({ share }) => share >= 0);
  const [worst] = sorted(limited, ({ share }) => share), errors = scene.assets.filter((asset) => "visible_p99" in asset);
  const visible = errors.length > 0 ? Math.max(...errors.map(({ visible_p99 }) => visible_p99 ?? Infinity)) : undefined;
  const folder = scene.folder + (scene.partial ? `, without ${scene.partial.join(", ")}` : "");
  return [
    [link ? make("a", { href: link }, scene.name) : scene.name, sub(folder)], scene.target, valueCell(used, [bytes(used), longBar(most > 0 ? used / most : 0)]),
    valueCell(ofBudget, ofBudget === undefined ? "none" : percentText(ofBudget), (ofBudget ?? 0) > 1),
    valueCell(worst?.share ?? 0, worst ? [percentText(worst.share < 1e300 ? worst.share : NaN), sub(`${worst.name}: ${worst.words}`)] : DASH, worst?.share > 1),
    valueCell(visible, visible === undefined ? DASH : numberText(visible)),
    valueCell(scene.whole_rel_rms, scene.whole_rel_rms === undefined ? DASH : percentText(scene.whole_rel_rms)),
    valueCell(scene.bytes_disk, bytes(scene.bytes_disk)), valueCell(scene.findings, countText(scene.findings)), verdict(scene.passed),
  ];
}

/** Makes the page of several scenes. It opens fast with thousands of them: pictures are shown only where an error grew. */
export function collectionPage({ collection, errors, history, links, uses }) {
  const { scenes } = collection, most = scenes[0]?.budget.used_bytes ?? 0;
  return [
    header(collection), failures(scenes, errors), platformSection(collection.platforms), growthSection(collection.baseline), trendSection(history, false), memory(collection, links),
    card("Scenes",
      table("scenes sortable", ["Scene", "Target", "#GPU memory", "#Of its budget", "#Largest error, of its limit", "#Visible error",
        "#Error of the whole scene", "#Disk", "#Findings", "Verdict"], scenes.map((scene, i) => sceneRow(scene, links[i], uses[i], most))),
      soft("The largest error is that of the asset that uses most of one of its limits. Visible errors are in just noticeable differences: 1 is at the threshold of a trained eye.")),
  ];
}
