// The card of the picked place: its texel, chart, light, coefficients and error.
import { apply, cssOf, DIFFUSE_WHITE, viewingOf } from "./color.js";
import { byId, make } from "./elements.js";
import { bytesText, visibleText } from "./units.js";

/** @typedef {import("./view.js").ShownMap} ShownMap */
/** @typedef {import("./view.js").Values} Values */

/** @param {number} x */
const short = (x) => (x === 0 ? "0" : Math.abs(x) >= 1000 || Math.abs(x) < 0.001 ? x.toExponential(2) : x.toPrecision(4));

const hint = () => make("p", { class: "note" }, "Click a surface for its texel, coefficients and error.");

export class PlaceCard {
  /** @param {import("./main.js").Page} page */
  constructor(page) {
    this.page = page;
    this.body = make("div", { id: "picked" }, hint());
    this.element = make("section", { class: "card" }, make("h2", {}, "Place"), this.body);
    /** In world space. @type {import("three").Vector3 | null} */
    this.position = null;
    this.pending = 0;
    this.showsCoefficients = false;
    page.controls.follow(() => this.update());
  }

  /** Shows the place again in the next frame, if one is picked: shaded values follow the settings. */
  update() {
    if (!this.page.state.picked || this.pending) return;
    this.pending = requestAnimationFrame(() => {
      this.pending = 0;
      this.show();
    });
  }

  /** Puts the ring on the picked place. */
  mark() {
    const { page } = this, marker = byId("marker"), camera = /** @type {import("./camera.js").Camera} */ (page.camera).view;
    const place = page.state.picked && this.position ? this.position.clone().project(camera) : null;
    marker.hidden = !place || Math.abs(place.z) > 1;
    if (place) marker.style.translate = `${((1 + place.x) / 2) * page.canvas.clientWidth}px ${((1 - place.y) / 2) * page.canvas.clientHeight}px`;
  }

  /** Shows the picked place, or how to pick one. */
  show() {
    const { page, body } = this, { state } = page, view = /** @type {import("./view.js").View} */ (page.view);
    if (!state.picked) {
      this.mark();
      body.replaceChildren(hint());
      return;
    }
    const [index, u, v] = state.picked, map = view.maps[index], found = view.surface(map, u, v);
    if (!found) return;
    this.position = found.position;
    this.mark();
    view.apply(state, page.blinked);
    const [values] = view.values(map, [{ uv: [u, v], bakeUv: view.bakeUvAt(map, [u, v], found), cluster: found.cluster, ...this.shadingOf(map, found) }]);
    const rows = this.rowsOf(map, [u, v], found), parts = [];
    if (values) {
      rows.push(...this.lightRows(map, values));
      if (state.shaded) parts.push(make("p", { class: "note" }, `Shaded at the normal${state.shaded.slice(3).some((x) => x !== 0) ? " and from the view" : ""} of the report's sample.`));
      if (map.hasReference) parts.push(this.swatches(map, values));
      if (map.decode.hasDirections) parts.push(this.coefficients(values, map.hasReference));
    }
    const isOnSummary = body.contains(document.activeElement);
    body.replaceChildren(make("dl", {}, ...rows.flatMap(([term, text]) => [make("dt", {}, term), make("dd", { "data-term": term }, text)])), ...parts);
    if (isOnSummary) body.querySelector("summary")?.focus({ preventScroll: true });
  }

  /** Returns the normal and the view, in the axes of the light map, that a place is shaded with: those of the report's sample, if it is one.
   * @param {ShownMap} map @param {import("./charts.js").Found} found @returns {{ normal: number[], view: number[] }} */
  shadingOf({ hasMesh, decode }, found) {
    const { page } = this, { shaded } = page.state, view = /** @type {import("./view.js").View} */ (page.view), none = [0, 0, 0];
    const eye = /** @type {import("./camera.js").Camera} */ (page.camera).view.position.clone().sub(found.position).normalize();
    const own = hasMesh ? { normal: view.toMap(decode.axes, found.normal.toArray()), view: view.toMap(decode.axes, eye.toArray()) } : { normal: none, view: none };
    if (!shaded) return own;
    const sampled = shaded.slice(3).some((x) => x !== 0) ? shaded.slice(3) : own.view;
    return { normal: shaded.slice(0, 3), view: hasMesh || sampled !== own.view ? sampled : shaded.slice(0, 3) };
  }

  /** Returns terms and texts of what is known without shading. @param {ShownMap} map @param {[number, number]} uv @param {import("./charts.js").Found} found */
  rowsOf({ asset, data, decode, charts, hasMesh }, [u, v], found) {
    const rows = [["Light map", `${data.name}, ${asset.layout}`], ["Texel", `${(u * asset.width - 0.5).toFixed(2)}, ${(v * asset.height - 0.5).toFixed(2)}`]];
    if (decode.needsCluster) rows.push(["Cluster", String(found.cluster)]);
    if (hasMesh && asset.bits_per_texel) {
      const texels = charts.texels[found.chart];
      rows.push(["Chart", `${found.chart + 1} of ${charts.count}, ${Math.round(texels)} texels`], ["Bytes of the chart", bytesText((texels * asset.bits_per_texel) / 8)]);
    }
    return rows;
  }
  /** @param {ShownMap} map @param {Values} values */
  lightRows({ hasReference }, values) {
    const light = (/** @type {number[]} */ rgb) => rgb.map(short).join("  "), rows = [];
    if (hasReference) rows.push(["Visible error", visibleText(values.error)], ["Reference", light(values.referenceLight)]);
    rows.push(["Cooked", light(values.cookedLight)]);
    return rows;
  }
  /** Makes patches of the colours that the page shows. @param {ShownMap} map @param {Values} values */
  swatches({ data }, values) {
    const unit = ((data.display?.nits ?? DIFFUSE_WHITE) / DIFFUSE_WHITE) * 2 ** this.page.state.stops;
    const { rec709 } = viewingOf(/** @type {import("./view.js").View} */ (this.page.view).workingSpace);
    const patch = (/** @type {string} */ title, /** @type {number[]} */ light) =>
      make("i", { title, style: `background: ${cssOf(apply(rec709, /** @type {any} */ (light.map((x) => x * unit))))}` });
    return make("div", { class: "swatches" }, patch("Reference", values.referenceLight), patch("Cooked", values.cookedLight));
  }
  /** @param {Values} values @param {boolean} hasReference */
  coefficients(values, hasReference) {
    const cells = (/** @type {number[]} */ rgb) => rgb.map((x) => make("td", {}, short(x)));
    const head = (/** @type {string} */ text) => make("th", { colspan: 3 }, text);
    const rows = values.cooked.map((cooked, i) => make("tr", {}, make("th", {}, String(i)), ...(hasReference ? cells(values.reference[i]) : []), ...cells(cooked)));
    return make("details", { open: this.showsCoefficients, ontoggle: (/** @type {Event} */ event) => (this.showsCoefficients = /** @type {HTMLDetailsElement} */ (event.target).open) },
      make("summary", {}, "SH coefficients"),
      make("div", { class: "scroll" }, make("table", {}, make("thead", {}, make("tr", {}, make("th"), ...(hasReference ? [head("Reference R G B")] : []), head("Cooked R G B"))), make("tbody", {}, ...rows))));
  }
}
