// GPU memory as treemaps: of assets, of scenes, and of the charts of a light map.
import { draw, make } from "../src/elements.js";
import { errorColor, errorRanges, treemap } from "../src/treemap.js";
import { bytesText, countText, numberText } from "../src/units.js";
import { bytes, DASH, part, soft, sorted, table, visible } from "./parts.js";

/** @typedef {{ name: string, bytes: number, color: string, detail?: string, link?: string, parts?: Tile[] }} Tile parts lie inside; their bytes add up to those of the tile */
/** @typedef {{ x: number, y: number, width: number, height: number }} Area */

/** Width of a letter and height of a line of labels, and room that the name of a tile with parts needs. */
const LETTER = 6.4, LINE = 16, HEAD = 44;

/** Returns as much of a text as fits, with an ellipsis; empty if fewer than six letters fit. */
function fitted(text, width) {
  const letters = Math.floor((width - 8) / LETTER), all = [...text];
  return all.length <= letters ? text : letters < 6 ? "" : `${all.slice(0, letters - 1).join("")}…`;
}
const place = (value) => value.toFixed(1);
const label = (kind, x, y, text) => text && draw("text", { class: kind, x: place(x), y: place(y) }, text);
const box = (kind, { x, y, width, height }, color) => draw("rect", { class: kind, x: place(x), y: place(y), width: place(width), height: place(height), style: `fill:${color}` });
const names = ({ name, bytes }, { x, y, width, height }) => {
  const shown = height >= LINE + 2 && fitted(name, width), size = bytesText(bytes);
  return shown && [label("name", x + 4, y + 13, shown), height >= 2 * LINE + 2 && fitted(size, width) === size && label("bytes", x + 4, y + 13 + LINE, size)];
};
/** @param {Tile} tile @param {any[]} content */
const linked = ({ name, bytes, detail, link }, ...content) =>
  draw(link ? "a" : "g", link ? { href: link } : {}, draw("title", {}, `${name}: ${bytesText(bytes)}${detail ? `, ${detail}` : ""}`), content);
/** @param {Tile[]} tiles @param {Area} area */
const placed = (tiles, { x, y, width, height }) => treemap(tiles, width / height).map((at) =>
  ({ tile: at.item, area: { x: x + at.x * width, y: y + at.y * height, width: at.width * width, height: at.height * height } }));

/** @param {{ tile: Tile, area: Area }} placedTile */
function drawn({ tile, area }) {
  const { x, y, width, height } = area, parts = (tile.parts ?? []).filter((each) => each.bytes > 0), whole = box("tile", area, tile.color);
  if (parts.length < 2) return linked(tile, whole, names(tile, area));
  // Too small for words on each part: colours alone. A page of hundreds of scenes opens faster without slivers.
  if (Math.min(width, height) < HEAD)
    return linked(tile, whole, placed(parts, area).map((at) => Math.min(at.area.width, at.area.height) >= 3 && box("fill", at.area, at.tile.color)), names(tile, area));
  const inner = { x: x + 2, y: y + LINE + 2, width: width - 4, height: height - LINE - 4 };
  return [linked(tile, whole, label("name", x + 4, y + 13, fitted(`${tile.name}  ${bytesText(tile.bytes)}`, width))),
    placed(parts, inner).map((at) => linked(at.tile, box("part", at.area, at.tile.color), names(at.tile, at.area)))];
}

/** Draws tiles once for wide screens and paper, and once for narrow screens. @param {Tile[]} tiles @param {string} words for readers who do not see them */
export function tilesOf(tiles, words) {
  if (!tiles.some(({ bytes }) => bytes > 0)) return null;
  return /** @type {[string, number, number][]} */ ([["wide", 1100, 380], ["narrow", 360, 420]]).map(([kind, width, height]) => draw("svg",
    { class: `treemap ${kind}`, viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": words }, placed(tiles, { x: 0, y: 0, width, height }).map(drawn)));
}

const pairText = (pair) => (pair ? pair.join(", ") : DASH);

/** Makes the charts of a light map: a treemap whose areas are bytes and whose colours are visible errors, and a table of the charts with the largest. */
export function chartPart({ charts, bytes_gpu }) {
  const { count = 0, largest = [], rest } = charts ?? {};
  const tileOf = (chart, name) => ({
    name, bytes: chart.bytes, color: chart.visible_p99 === null ? "var(--track)" : errorColor(chart.visible_p99),
    detail: `${countText(chart.texels)} texels, visible error ${numberText(chart.visible_p99)} for 99 %, at most ${numberText(chart.visible_max)} at texel ${pairText(chart.worst)}`,
  });
  const tiles = largest.map((chart) => tileOf(chart, `chart ${chart.number}`));
  if (rest) tiles.push(tileOf(rest, `${count - largest.length} smaller charts`));
  const used = tiles.reduce((sum, tile) => sum + tile.bytes, 0);
  if (used === 0) return null;
  tiles.push({ name: "between charts", detail: "texels that no chart holds", color: "var(--track)", bytes: bytes_gpu - used });
  const worst = sorted(largest.filter(({ visible_p99 }) => visible_p99 >= 1), ({ visible_p99 }) => visible_p99).slice(0, 6);
  return part("Charts: memory and visible errors",
    soft(`${countText(count)} ${count === 1 ? "chart" : "charts"}. Areas are GPU memory, colours the visible error that 99 % of a chart's texels stay under, at their own normals:`),
    make("p", { class: "soft error-classes" }, errorRanges().map(({ words, color }) => make("span", {}, make("i", { class: "swatch", style: `background:${color}` }), words))),
    tilesOf(tiles, "GPU memory of each chart, coloured by its visible error"),
    worst.length > 0 && table("charts", ["Most visible", "#GPU", "#From texel", "#Size", "#99 %", "#largest", "#at texel"], worst.map((chart) => [
      `chart ${chart.number}`, bytes(chart.bytes), pairText(chart.first), pairText(chart.size), visible(chart, "visible_p99"), visible(chart, "visible_max"), pairText(chart.worst)])));
}
