// The card of the GPU memory: a treemap of textures, or of charts with their visible errors.
import { make } from "./elements.js";
import { chartItems, colorOf, errorRanges, memoryItems, treemap } from "./treemap.js";
import { bytesText } from "./units.js";

export class MemoryCard {
  /** @param {import("./main.js").Page} page */
  constructor(page) {
    this.page = page;
    this.view = /** @type {import("./view.js").View} */ (page.view);
    /** @type {Map<number, import("./treemap.js").ChartError>[] | undefined} */
    this.errorsOfCharts = undefined;
    const { view } = this, { controls } = page, body = make("div", {}), hasCharts = view.maps.some(({ hasMesh }) => hasMesh);
    let drawn = "";
    controls.follow(() => {
      const { memory, layout } = page.state, { cooked, maps } = view.setFor(layout), key = `${memory} ${view.sets.has(layout) ? layout : ""}`;
      if (key === drawn) return;
      drawn = key;
      const items = memoryItems(cooked.manifest);
      // The report is that of the scene's own layout.
      body.replaceChildren(...this.memoryTiles(memory === "charts" ? chartItems(items, maps, layout && view.sets.has(layout) ? [] : this.chartErrors()) : items));
    });
    const choice = hasCharts ? [controls.segments("memory-by", "Tiles of memory", "memory", [["assets", "Textures"], ["charts", "Charts"]])] : [];
    this.element = make("section", { class: "card" }, make("h2", {}, "Memory"), ...choice, body);
  }
  /** Errors of the report by chart of each map. The report numbers charts in its own way: they are paired by a texel. */
  chartErrors() {
    const { view, page } = this;
    this.errorsOfCharts ??= view.maps.map((map) => {
      /** @type {Map<number, import("./treemap.js").ChartError>} */
      const errors = new Map(), { asset } = map;
      const row = page.report?.assets?.find((/** @type {any} */ each) => each.name === asset.name);
      for (const { worst, visible_p99, visible_max } of row?.charts?.largest ?? []) {
        const u = (worst[0] + 0.5) / asset.width, v = (worst[1] + 0.5) / asset.height, found = view.surface(map, u, v);
        // Several charts of the page may be one of the report, which joins charts that share texels.
        if (found && !errors.has(found.chart)) errors.set(found.chart, { p99: visible_p99 ?? Infinity, max: visible_max ?? Infinity, worst: [u, v] });
      }
      return errors;
    });
    return this.errorsOfCharts;
  }
  /** @param {import("./treemap.js").Item[]} items */
  memoryTiles(items) {
    const total = items.reduce((sum, item) => sum + item.bytes, 0), caption = make("p", { class: "note" });
    /** @type {HTMLElement[]} */
    const buttons = [];
    const tiles = treemap(items, 1.8).map(({ item, x, y, width, height }) => {
      const name = `${item.asset}, ${item.role}`, label = width > 0.14 && height > 0.2 ? [make("b", {}, item.role), make("br"), item.asset] : [];
      const button = make("button", {
        "aria-label": `${name}: ${bytesText(item.bytes)}`, title: name, "aria-pressed": "false",
        style: `left:${100 * x}%;top:${100 * y}%;width:${100 * width}%;height:${100 * height}%;background:${colorOf(item)}`,
        onclick: () => {
          for (const other of buttons) other.setAttribute("aria-pressed", String(other === button));
          caption.textContent = `${name}: ${bytesText(item.bytes)}, ${((100 * item.bytes) / total).toFixed(1)} %. ${item.detail}`;
          if (item.place) this.page.flyTo(...item.place);
        },
      }, ...label);
      buttons.push(button);
      return button;
    });
    caption.textContent = `${bytesText(total)} of GPU memory. Click a tile for what it is.`;
    const legend = items.some(({ visible }) => visible !== undefined) ? [this.errorLegend()] : [];
    return [make("div", { class: "treemap", id: "memory" }, ...tiles), ...legend, caption];
  }

  /** Makes the legend of the colours of charts. */
  errorLegend() {
    return make("p", { class: "note errors" }, "Visible error that 99 % of a chart stay below, in just noticeable differences: ", errorRanges().map(({ words, color }) => make("span", {}, make("i", { style: `background: ${color}` }), words)));
  }
}
