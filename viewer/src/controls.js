// Controls that show and change one member of the state of the page.
import { make } from "./elements.js";
import { initialState } from "./link.js";

/** @typedef {import("./link.js").State} State */
/** @typedef {"mode" | "glossy" | "navigation" | "memory"} Choice members of the state that a row of buttons chooses */
/**
 * @typedef {object} StateOwner
 * @property {State} state
 * @property {(by: Partial<State>) => void} changed changes the state, and shows it
 * @property {(key: Choice, value: string) => void} choose
 */

export class Controls {
  /** @param {StateOwner} owner */
  constructor(owner) {
    this.owner = owner;
    /** @type {(() => void)[]} */
    this.refreshers = [];
  }

  /** Calls a function after each change of the state. @param {() => void} refresh */
  follow(refresh) {
    this.refreshers.push(refresh);
  }
  /** Shows the state in all controls. */
  refresh() {
    for (const refresh of this.refreshers) refresh();
  }

  /** Makes a row of buttons, one of which is pressed.
   * @param {string} id @param {string} label @param {Choice} key @param {[string, string][]} choices value and label */
  segments(id, label, key, choices) {
    const buttons = choices.map(([value, label]) => make("button", { "data-value": value, onclick: () => this.owner.choose(key, value) }, label));
    this.follow(() => buttons.forEach((button) => button.setAttribute("aria-pressed", String(button.dataset.value === this.owner.state[key]))));
    return make("div", { class: "segments", id, role: "group", "aria-label": label }, ...buttons);
  }
  /** @param {"stops" | "errorEnd" | "m" | "f0" | "albedo" | "light" | "bump"} key @param {string} label @param {[low: number, high: number, step: number]} range
   * @param {(value: number) => string} text */
  slider(key, label, [low, high, step], text) {
    const input = /** @type {HTMLInputElement} */ (make("input", { type: "range", id: key, min: low, max: high, step, "aria-label": label }));
    const output = make("output", { for: key });
    input.addEventListener("input", () => this.owner.changed({ [key]: Number(input.value) }));
    input.addEventListener("dblclick", () => this.owner.changed({ [key]: Math.min(Math.max(initialState()[key], low), high) }));
    this.follow(() => {
      input.value = String(this.owner.state[key]);
      output.textContent = text(this.owner.state[key]);
    });
    return make("div", { class: "row" }, make("label", { for: key }, label), input, output);
  }
  /** @param {"diffuse" | "dominant" | "materials" | "seams"} key @param {string} label */
  check(key, label) {
    const input = /** @type {HTMLInputElement} */ (make("input", { type: "checkbox", id: key }));
    input.addEventListener("change", () => this.owner.changed({ [key]: input.checked }));
    this.follow(() => (input.checked = this.owner.state[key]));
    return make("label", { class: "check" }, input, label);
  }
  /** @param {"overlay" | "environment" | "layout" | "beside"} key @param {string} label @param {[string | number, string][]} choices */
  select(key, label, choices) {
    const select = /** @type {HTMLSelectElement} */ (make("select", { id: key }, ...choices.map(([value, name]) => make("option", { value }, name))));
    select.addEventListener("change", () => this.owner.changed({ [key]: key === "environment" ? Number(select.value) : select.value }));
    this.follow(() => (select.value = String(this.owner.state[key])));
    return make("div", { class: "row" }, make("label", { for: key }, label), select);
  }
}
