// The state of the view as the hash of a link, and back.

/** @typedef {ReturnType<typeof initialState>} State */

export function initialState() {
  return {
    mode: "wipe", wipe: 0.5, layout: "", beside: "", memory: "assets", stops: 0, errorEnd: 10, diffuse: true, glossy: "none", environment: 0,
    dominant: false, m: 0.25, f0: 0.04, albedo: 1, light: 1, materials: false, bump: 0, overlay: "none", seams: false, navigation: "orbit", theme: "auto",
    /** @type {number[] | null} position and target */ camera: null,
    /** @type {number[] | null} light map, u, v */ picked: null,
    /** @type {number[] | null} normal and view of a sample of the report that is picked, in the axes of the light map; a view of 0: the camera's */ shaded: null,
  };
}

/** Writes what differs from the initial state. @param {State} state */
export function hashOf(state) {
  const start = initialState(), parts = [];
  for (const key of /** @type {(keyof State)[]} */ (Object.keys(start))) {
    const value = state[key];
    if (value === null || value === start[key]) continue;
    parts.push(`${key}=${Array.isArray(value) ? value.map((x) => Number(x.toPrecision(9))).join(",") : typeof value === "boolean" ? Number(value) : encodeURIComponent(value)}`);
  }
  return parts.join("&");
}

/** Reads a hash. What it does not know, or what is no number, is left as it starts. @param {string} hash @returns {State} */
export function stateOf(hash) {
  const state = initialState();
  for (const [key, text] of new URLSearchParams(hash.replace(/^#/, ""))) {
    if (!Object.hasOwn(state, key)) continue;
    const start = /** @type {any} */ (state)[key];
    const numbers = text.split(",").map(Number);
    let value = start;
    if (key === "camera" || key === "picked" || key === "shaded") {
      if (numbers.length === (key === "picked" ? 3 : 6) && numbers.every(Number.isFinite)) value = numbers;
    } else if (typeof start === "number") value = Number.isFinite(numbers[0]) ? numbers[0] : start;
    else if (typeof start === "boolean") value = text === "1";
    else value = text;
    /** @type {any} */ (state)[key] = value;
  }
  return state;
}
