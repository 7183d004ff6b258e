// Parts of the sections of a report's page. The report is what docs/reference/report.md describes: figures that are not finite are null, and
// members without a value are absent.
import { make } from "../src/elements.js";
import { bytesText, countText, exactText, numberText, percentText, secondsText, shortText, visibleText } from "../src/units.js";

export const DASH = "–";
const SHADINGS = ["diffuse", "specular"];

/** Captions of the kinds of assets, by name. @type {Record<string, string>} */
export const kinds = {};
/** Blocks of the pixel formats, by name: their side [texels] and bytes. @type {Record<string, { side: number, bytes: number }>} */
export const formats = {};

// Figures, with all their digits where one points at them

export const titled = (shown, exact) => make("span", { title: exact }, shown);
export const bytes = (count) => titled(bytesText(count), `${countText(count)} bytes`);
export const seconds = (value) => titled(value === null ? DASH : secondsText(value), `${exactText(value)} s`);
export const percent = (ratio) => titled(percentText(ratio), exactText(ratio));
export const number = (value) => titled(numberText(value), exactText(value));
/** Returns a member, or a dash if it is absent. */
export const figure = (object, key, text = percentText) => (object && key in object ? titled(text(object[key]), exactText(object[key])) : titled(DASH, "not measured"));
export const visible = (object, key) => figure(object, key, visibleText);

// Tables

export const row = (kind, ...cells) => ({ kind, cells });
export const cell = (kind, ...content) => make("td", { class: kind }, content);
const head = (name, properties = {}) => make("th", { scope: "col", class: name[0] === "#" ? "num" : "", ...properties }, name.replace(/^#/, ""));

/** Makes a table. @param {string} kind @param {string[]} columns names; those of numbers begin with "#"
 * @param {any[]} rows lists of contents, the first of which is the head of the row, or of row() */
export function table(kind, columns, rows) {
  return framed(kind, make("tr", {}, columns.map((name) => head(name))), rows, (i) => columns[i][0] === "#");
}

/** Makes a table with the same figures of each kind of shading. @param {string} kind @param {string} title of the first column
 * @param {string[]} shadings @param {string[]} figures names @param {any[]} rows as of table() */
export function shadingTable(kind, title, shadings, figures, rows) {
  const groups = make("tr", {}, head(title, { rowspan: 2 }), shadings.map((shading) => head(shading, { class: "group", colspan: figures.length })));
  const names = make("tr", {}, shadings.map(() => figures.map((name, i) => head(`#${name}`, { class: i === 0 ? "num first" : "num" }))));
  return framed(`stages ${kind}${shadings.length === 1 ? " one" : ""}`, [groups, names], rows, (i) => i > 0);
}

function framed(kind, heads, rows, isNumber) {
  const cellOf = (content, i) => {
    if (content instanceof HTMLTableCellElement) return content;
    return i === 0 ? make("th", { scope: "row" }, content) : make("td", isNumber(i) ? { class: "num" } : {}, content);
  };
  const body = rows.map((each) => make("tr", { class: each.kind ?? "" }, (each.cells ?? each).map(cellOf)));
  return make("div", { class: "scroll" }, make("table", { class: kind }, make("thead", {}, heads), make("tbody", {}, body)));
}

/** Makes a cell with a member over a thin bar that is full at its limit; without a limit the member alone. */
export function limited(object, key, limit, text = percentText) {
  const isMeasured = object && key in object, share = isMeasured && (limit >= 0 || object[key] === null) ? shareOf(object[key], limit) : 0;
  return cell(share > 1 ? "num over" : "num", figure(object, key, text), isMeasured && limit > 0 && bar("meter", share));
}
/** Makes the cell of rel_rms. */
export const limitedError = (figures, asset) => limited(figures, "rel_rms", asset.limit.value);
/** Makes the cell of a visible error: p99 or bound. */
export const limitedVisible = (figures, key, asset) => limited(figures?.visible, key, asset.limit[key === "bound" ? "max_visible_bound" : "max_visible"], visibleText);

/** Returns a part of a whole; infinite for a part that is not finite. */
export const shareOf = (part, whole) => (part === null ? Infinity : part === 0 ? 0 : part / whole);
/** Makes a thin bar. @param {string} kind @param {number} share full at 1 */
export const bar = (kind, share) => make("span", { class: kind }, make("i", { style: `width:${(100 * Math.min(share, 1)).toFixed(1)}%` }));

// Pieces

export const card = (title, ...content) => make("section", { class: "card" }, make("h2", {}, title), content);
/** Makes a part of a card under a title. */
export const part = (title, ...content) => make("div", { class: "notes" }, make("h3", {}, title), content);
export const soft = (...content) => make("p", { class: "soft" }, content);
export const sub = (...content) => make("span", { class: "sub" }, content);
export const verdict = (passed) => make("span", { class: `verdict ${passed ? "passed" : "failed"}` }, passed ? "✓" : "✗", make("span", {}, passed ? " passed" : " failed"));
export const fact = (name, ...value) => make("div", {}, make("dt", {}, name), make("dd", {}, value));
export const swatch = (kind) => make("span", { class: "swatch", style: `background:${kindColor(kind)}` });
export const list = (sentences) => make("ul", { class: "advice" }, sentences.map((sentence) => make("li", {}, sentence)));

export const kindColor = (kind) => (kind in kinds ? `var(--kind-${kind})` : "var(--kind-other)");
export const kindCaption = (kind) => kinds[kind] ?? (kind || "unknown");
export const nameOf = ({ kind, name }) => `${kindCaption(kind)} '${name}'`;

/** Makes a table of memory by name, largest first. @param {string} title @param {Record<string, number>} byName @param {number} used @param {boolean} [isKind] */
export function shares(title, byName, used, isKind) {
  const share = (count) => (used > 0 ? count / used : 0);
  const rows = sorted(Object.entries(byName), ([, count]) => count).map(([name, count]) => [
    cell("", isKind && swatch(name), kindCaption(name)), bytes(count), titled(`${(100 * share(count)).toFixed(1)} %`, exactText(share(count)))]);
  return table("shares", [title, "#GPU memory", "#Share"], rows.length > 0 ? rows : [[make("td", { colspan: 3, class: "soft" }, "nothing")]]);
}

// Reading the report

/** Returns the name of the section of an asset, the same in every report of the scene, so that links to it stay. */
export const anchor = ({ name }) => `asset-${name}`;
/** Returns the address of that section on the page. */
export const link = (asset) => `#${encodeURIComponent(anchor(asset))}`;

export function budgetSentence({ used_bytes: used, limit_bytes: limit }) {
  if (limit === null) return `${bytesText(used)} used; the scene has no memory budget`;
  return `${bytesText(used)} of ${bytesText(limit)} used${limit > 0 ? ` (${percentText(used / limit)})` : ""}, ${bytesText(Math.abs(limit - used))} ${used > limit ? "over" : "free"}`;
}

/** Returns a sorted copy, the largest value first. */
export const sorted = (items, valueOf) => [...items].sort((a, b) => valueOf(b) - valueOf(a));
export const lastStage = (asset) => asset.stages[asset.stages.length - 1];

/** Returns the kinds of shading that were measured of an asset: those with a visible error, a place or a figure other than 0; both if there is none. */
export function shadingsOf(asset) {
  const keys = ["rel_rms", "p99", "max_sampled", "max_bound"];
  const isMeasured = (figures) => figures &&
    (figures.visible || figures.sampled_at || figures.bound_at || keys.some((key) => key in figures && figures[key] !== 0));
  const measured = SHADINGS.filter((shading) => asset.stages.some(({ error }) => isMeasured(error[shading])));
  return measured.length > 0 ? measured : SHADINGS;
}

/** Returns "256 × 256" or "128 × 128 × 6"; empty for an asset without texels. */
export const sizeText = ({ width, height, kind }) => (width && height ? `${width} × ${height}${kind === "cubemap" ? " × 6" : ""}` : "");

/** Returns a layout for people: "basis-4+lit@5" is "basis-4, detail", or "basis-4, detail above 5". @param {string} name @param {boolean} [withLimit] */
export function layoutText(name, withLimit = false) {
  const [layout, detail] = name.split("+"), limit = detail?.split("@")[1];
  return detail ? `${layout}, detail${withLimit && limit ? ` above ${shortText(Number(limit), 2)}` : ""}` : layout;
}

/** Returns "(1, 2.5, 3)". */
export const vectorText = (values, text = (value) => shortText(value, 4)) => (values ? `(${values.map(text).join(", ")})` : DASH);

/** Returns "texel (12, 31), green, normal (0, 0, 1)"; empty without a place. */
export function placeText(at) {
  const keys = ["mip", "face", "primitive", "triangle", "position", "texel", "channel", "normal", "view", "m", "f0"];
  return keys.filter((key) => at && key in at).map((key) => {
    const value = at[key], text = Array.isArray(value) ? vectorText(value) : typeof value === "number" ? shortText(value, 4) : value;
    return `${key === "channel" ? "" : `${key === "f0" ? "F0" : key} `}${text}`;
  }).join(", ");
}
