// The card of the worst places: those of the report, what failed first, and the flight to one of them.
import { Vector3 } from "three";
import { make } from "./elements.js";
import { visibleText } from "./units.js";

/** @typedef {import("./main.js").Page} Page */
/**
 * @typedef {object} Place
 * @property {number} map index of the light map
 * @property {string} what light that errs: diffuse or specular
 * @property {"surface" | "texel" | "seam"} kind where it was found
 * @property {[number, number]} texel integers are centres; of the bake if `isOfBake`, else of the light map
 * @property {boolean} isOfBake
 * @property {boolean} isFailed true if a limit on this light is exceeded
 * @property {number} visible just noticeable differences; of a seam those that the step grew by
 * @property {number[]} [normal] that the light was shaded with, in the axes of the light map
 * @property {number[]} [view]
 * @property {number} [m]
 * @property {number} [f0]
 * @property {string} [words] about a seam
 */

const WHERE = { surface: "on the surface", texel: "at a texel", seam: "at a seam" };
const SHOWN = 8;

/** Returns true if the last stage of a row is over a limit on a kind of light. @param {any} row of the report @param {any} figures of that light */
function isOver({ limit = {} }, figures) {
  const exceeds = (/** @type {any} */ value, /** @type {any} */ most) => typeof most === "number" && (value === null || value > most);
  return exceeds(figures.rel_rms, limit.max_error) || exceeds(figures.visible?.p99, limit.max_visible) || exceeds(figures.visible?.bound, limit.max_visible_bound);
}

/** Returns the places of a light map, as its row of the report has them. @param {any} row @param {number} map @returns {Place[]} */
export function placesOf(row, map) {
  const stages = row?.stages ?? [], last = stages[stages.length - 1]?.error;
  if (!last) return [];
  /** @type {Place[]} */
  const places = [];
  for (const what of ["diffuse", "specular"]) {
    const at = last[what]?.visible?.max_at;
    if (at) places.push({ ...at, map, what, kind: "surface", isOfBake: true, isFailed: isOver(row, last[what]), visible: last[what].visible.max ?? Infinity });
  }
  const isThere = (/** @type {number[]} */ [x, y]) => places.some(({ what, texel }) => what === "diffuse" && Math.abs(texel[0] - x) < 0.01 && Math.abs(texel[1] - y) < 0.01);
  for (const { texel, normal, visible } of row.preview?.worst ?? [])
    if (row.notes?.packing || !isThere(texel)) places.push({ map, what: "diffuse", kind: "texel", texel, normal, isOfBake: false, isFailed: isOver(row, last.diffuse), visible: visible ?? Infinity });
  const { worst = [] } = row.seams ?? {}, isSeamOver = typeof row.limit?.max_seam === "number" && worst.some((/** @type {any} */ { added }) => added > row.limit.max_seam);
  for (const { shading, added, bake_step: bake, cooked_step: cooked, texels, ...seam } of isSeamOver ? worst : [])
    places.push({ ...seam, map, what: shading, kind: "seam", texel: texels[0], isOfBake: true, isFailed: added > row.limit.max_seam, visible: added,
      words: `From one side to the other the bake steps by ${visibleText(bake)}, the cooked map by ${visibleText(cooked)}.` });
  return places;
}

/** Makes the card; null where the report has no places. @param {Page} page */
export function worstCard(page) {
  const view = /** @type {import("./view.js").View} */ (page.view), rowOf = (/** @type {string} */ name) => page.report?.assets?.find((/** @type {any} */ each) => each.name === name);
  const places = view.maps.flatMap(({ data }, map) => placesOf(rowOf(data.name), map)).sort((a, b) => Number(b.isFailed) - Number(a.isFailed) || b.visible - a.visible);
  if (places.length === 0) return null;
  const items = places.map((place) => {
    const { data } = view.maps[place.map], few = place.kind === "surface" && rowOf(data.name)?.charts?.few_texels?.find((/** @type {any} */ each) => each.shading === place.what);
    const failed = place.isFailed ? [" ", make("span", { class: "warning" }, "failed")] : [];
    return make("li", {}, make("button", { onclick: () => flyToPlace(page, place), title: `Texel ${place.texel.map((x) => x.toFixed(1)).join(", ")}` },
      make("b", {}, visibleText(place.visible)), make("span", {}, `${view.maps.length > 1 ? `${data.name}: ` : ""}${place.what}, ${WHERE[place.kind]}`, ...failed),
      make("span", { class: "soft" }, place.texel.map((x) => x.toFixed(0)).join(", "))), make("p", { class: "note" }, few?.advice ?? place.words ?? ""));
  });
  const list = (/** @type {HTMLElement[]} */ some, properties = {}) => make("ul", { class: "places", ...properties }, ...some);
  const more = items.slice(SHOWN);
  return make("section", { class: "card" }, make("h2", {}, "Worst places"), list(items.slice(0, SHOWN), { id: "worst" }),
    more.length > 0 ? make("details", {}, make("summary", {}, `${more.length} more`), list(more)) : null,
    make("p", { class: "note" }, "Visible error in just noticeable differences, light, texel."));
}

/** Returns the light-map UV of a place. @param {Page} page @param {Place} place @returns {[number, number] | undefined} */
function uvOfPlace({ view: shown }, { map, isOfBake, texel: [x, y] }) {
  const view = /** @type {import("./view.js").View} */ (shown), { width, height } = view.maps[map].asset, isPacked = view.maps[map].bake !== view.maps[map].asset;
  return isOfBake && isPacked ? view.surfaceOfBake(view.maps[map], [x, y])?.uv : [(x + 0.5) / width, (y + 0.5) / height];
}

/** Flies to a place, and shows the light that errs there as the report's sample was shaded: with its normal, and of specular light from its
 * view and on its surface. @param {Page} page @param {Place} place */
export function flyToPlace(page, place) {
  const { map, what, view: towards, normal, m, f0 } = place, uv = uvOfPlace(page, place);
  if (!uv) return;
  const view = /** @type {import("./view.js").View} */ (page.view), { state } = page, isSpecular = what === "specular" && view.has.tables;
  Object.assign(state, { light: 1, bump: 0 });
  if (isSpecular) Object.assign(state, { diffuse: false, glossy: "area", dominant: false, m: m ?? state.m, f0: f0 ?? state.f0 });
  else Object.assign(state, { diffuse: true, glossy: "none", dominant: false, albedo: 1 });
  page.allow();
  const shaded = normal && (isSpecular || what === "diffuse") ? [...normal, ...(isSpecular && towards ? towards : [0, 0, 0])] : null;
  const { hasMesh, decode } = view.maps[map];
  page.flyTo(map, uv[0], uv[1], shaded, isSpecular && hasMesh && towards ? new Vector3(...view.toMesh(decode.axes, towards)) : undefined);
}
