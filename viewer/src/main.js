// The page: its state and link, the camera and keys, and the cards of view, light and worst places.
import { Vector3 } from "three";
import { Camera } from "./camera.js";
import { viewingOf } from "./color.js";
import { freeDistance, texelSideAt } from "./charts.js";
import { Controls } from "./controls.js";
import { byId, make } from "./elements.js";
import { failureTexts } from "./failure_text.js";
import { hashOf, initialState, stateOf } from "./link.js";
import { MemoryCard } from "./memory_card.js";
import { PlaceCard } from "./place_card.js";
import { savePicture } from "./picture.js";
import { MODES } from "./shading.js";
import { bytesCooked, bytesRead } from "./sizes.js";
import { chosenFiles, droppedFiles, droppedSource, siteSource } from "./source.js";
import { bytesText } from "./units.js";
import { View } from "./view.js";
import { worstCard } from "./worst_card.js";

/** @typedef {import("./link.js").State} State */

const BLINK_MS = 600;
const POLL_MS = 5000;
/** The camera in front of a place, as that of the report's pictures: so many texels to their side, or this share of the way to what lies between. */
const RADIUS_TEXELS = 20, SLOPE = 0.5, FREE = 0.95;

export class Page {
  constructor() {
    this.canvas = /** @type {HTMLCanvasElement} */ (byId("canvas"));
    this.panel = byId("panel");
    this.state = stateOf(location.hash);
    /** @type {View | undefined} */
    this.view = undefined;
    /** @type {Camera | undefined} */
    this.camera = undefined;
    /** Done once a dropped folder is shown. @type {Promise<void> | undefined} */
    this.opening = undefined;
    this.blinked = false;
    this.controls = new Controls(this);
    this.isLoadingLayout = false;
    this.layoutFault = "";
    this.pending = 0;
    this.hashTimer = 0;
    this.applyTheme();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.changed());
  }

  async start() {
    this.watchContext();
    this.site = await siteSource();
    await this.load(this.site);
    this.listenToWipe();
    this.listenToDrops();
    new ResizeObserver(() => this.camera?.setAspect(/** @type {View} */ (this.view).resize())).observe(this.canvas);
    addEventListener("hashchange", () => {
      if (location.hash.slice(1) !== hashOf(this.state)) this.restore(stateOf(location.hash));
    });
    addEventListener("keydown", (event) => this.key(event));
    setInterval(() => this.blink(), BLINK_MS);
    addEventListener("focus", () => this.lookForNewCook());
    // A server of `lightcook view` is on this machine. Others are asked only when somebody comes back to the page.
    if (["127.0.0.1", "localhost", "[::1]"].includes(location.hostname)) setInterval(() => document.hidden || this.lookForNewCook(), POLL_MS);
  }

  /** Loads a scene, and shows it in place of the one before. That stays if it cannot be loaded. @param {import("./source.js").SceneSource} source */
  async load(source) {
    const progress = /** @type {HTMLProgressElement} */ (byId("progress")), before = this.view, view = new View(this.canvas, before?.renderer);
    progress.value = 0;
    await view.load(source, (share) => (progress.value = share));
    const axis = view.cooked?.manifest.up_axis ?? "y", up = new Vector3(Number(axis === "x"), Number(axis === "y"), Number(axis === "z"));
    const isSame = before?.cooked?.manifest.scene === view.cooked?.manifest.scene;
    if (before) this.state = { ...initialState(), theme: this.state.theme, mode: this.state.mode, camera: isSame ? this.state.camera : null };
    this.view = view;
    this.report = source.report;
    this.camera ??= new Camera(this.canvas, up, () => this.moved(), (x, y) => this.click(x, y));
    this.camera.stop();
    this.camera.setUp(up);
    const camera = this.state.camera;
    this.camera.size = Math.max(view.box.getSize(new Vector3()).length(), 1e-6);
    this.camera.setAspect(view.resize());
    this.state.camera = camera;
    this.controls = new Controls(this);
    this.allow();
    this.build();
    this.applyCamera();
    before?.dispose();
    byId("loading").hidden = true;
    this.changed();
    if (this.state.picked) this.place?.show();
    await this.needLayouts();
  }

  /** Shows a cooked folder, or says why not. @param {() => Promise<Map<string, File>>} filesOf */
  async openFolder(filesOf) {
    const loading = byId("loading");
    byId("loading-text").textContent = "Loading the folder";
    loading.hidden = false;
    let fault = "";
    try {
      await this.load(await droppedSource(await filesOf(), /** @type {import("./source.js").SceneSource} */ (this.site)));
    } catch (failed) {
      fault = /** @type {Error} */ (failed).message;
    }
    loading.hidden = true;
    byId("folder-fault").textContent = fault;
  }
  /** A cooked folder that is dropped anywhere on the page is shown. */
  listenToDrops() {
    const hint = byId("drop"), hasFiles = (/** @type {DragEvent} */ { dataTransfer }) => dataTransfer?.types.includes("Files");
    addEventListener("dragover", (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      hint.hidden = false;
    });
    addEventListener("dragleave", (event) => {
      if (event.relatedTarget === null) hint.hidden = true;
    });
    addEventListener("drop", (event) => {
      hint.hidden = true;
      const { dataTransfer } = event;
      if (!dataTransfer || !hasFiles(event)) return;
      event.preventDefault();
      const files = droppedFiles(dataTransfer);
      this.opening = this.openFolder(() => files);
    });
  }

  /** Says when the browser takes the context away, as it does with too little memory, and draws again once it is back. three.js makes its
   * textures and buffers anew by itself. */
  watchContext() {
    const loading = byId("loading"), progress = byId("progress");
    let hidden = true;
    this.canvas.addEventListener("webglcontextlost", () => {
      hidden = loading.hidden;
      byId("loading-text").textContent = "The browser took the page's WebGL context away, perhaps for lack of memory. Reload the page if the scene does not come back.";
      progress.hidden = true;
      loading.hidden = false;
    });
    this.canvas.addEventListener("webglcontextrestored", () => {
      byId("loading-text").textContent = "Loading";
      progress.hidden = false;
      loading.hidden = hidden;
      this.redraw();
    });
  }

  /** Offers to reload once the folder has another manifest than the one that is shown. */
  async lookForNewCook() {
    const offer = byId("again"), { cooked, source } = /** @type {View} */ (this.view), shown = cooked?.manifest.digest;
    if (!shown || source?.isDropped || !offer.hidden) return;
    const manifest = await fetch("cooked/cooked.json", { cache: "no-store" }).then((answer) => (answer.ok ? answer.json() : null)).catch(() => null);
    if (manifest?.digest && manifest.digest !== shown) offer.hidden = false;
  }

  /** Loads the layouts that the state shows. A layout that cannot be loaded is named, and the state goes back to the scene's own. */
  async needLayouts() {
    const view = /** @type {View} */ (this.view), { state } = this;
    const missing = [state.layout, state.beside].find((layout) => layout && !view.sets.has(layout));
    if (!missing || this.isLoadingLayout) return;
    this.isLoadingLayout = true;
    const loading = byId("loading"), progress = /** @type {HTMLProgressElement} */ (byId("progress"));
    byId("loading-text").textContent = `Loading ${missing}`;
    progress.value = 0;
    loading.hidden = false;
    try {
      await view.loadCandidate(missing, (share) => (progress.value = share));
      this.layoutFault = "";
    } catch (fault) {
      this.layoutFault = /** @type {Error} */ (fault).message;
      for (const key of /** @type {const} */ (["layout", "beside"])) if (this.state[key] === missing) this.state[key] = "";
    }
    loading.hidden = true;
    this.isLoadingLayout = false;
    this.changed();
    if (this.state.picked) this.place?.show();
  }

  /** Brings the state to what the scene has and the controls reach. */
  allow() {
    const view = /** @type {View} */ (this.view), { state } = this, { has } = view, start = initialState();
    const oneOf = (/** @type {string} */ value, /** @type {readonly string[]} */ values, /** @type {string} */ otherwise) => (values.includes(value) ? value : otherwise);
    state.layout = oneOf(state.layout, ["", ...view.candidates.map(({ layout }) => layout)], "");
    state.beside = oneOf(state.beside, this.besideChoices(), this.besideChoices()[0] ?? "");
    state.mode = this.isCompared() ? oneOf(state.mode, this.modeChoices(), start.mode) : "cooked";
    state.memory = oneOf(state.memory, ["assets", "charts"], "assets");
    state.glossy = oneOf(state.glossy, this.glossyChoices(), "none");
    state.overlay = oneOf(state.overlay, this.overlayChoices(), "none");
    state.navigation = oneOf(state.navigation, ["orbit", "fly"], "orbit");
    state.theme = oneOf(state.theme, ["auto", "light", "dark"], "auto");
    const clamp = (/** @type {"wipe" | "stops" | "errorEnd" | "f0" | "albedo" | "light" | "bump" | "m"} */ key, /** @type {number} */ low, /** @type {number} */ high) =>
      (state[key] = Math.min(Math.max(state[key], low), high));
    clamp("wipe", 0, 1);
    clamp("stops", -8, 8);
    clamp("errorEnd", 1, 50);
    clamp("f0", 0, 1);
    clamp("albedo", 0, 1);
    clamp("light", 0, 1);
    clamp("bump", 0, this.mostTilt());
    clamp("m", view.roughness[0], view.roughness[1]);
    if (!view.environments[state.environment]) state.environment = 0;
    if (state.picked && !view.maps[state.picked[0]]) state.picked = null;
    if (!state.picked) state.shaded = null;
    state.dominant &&= has.dominant;
    state.materials &&= has.materials;
    state.seams &&= has.mesh;
    state.diffuse ||= !has.tables;
  }
  modeChoices() {
    const { has } = /** @type {View} */ (this.view);
    return MODES.filter((mode) => has.reference || mode !== "error");
  }
  /** Returns the layouts that the cooked one can be compared with; "" is the float bake. */
  besideChoices() {
    const { has, candidates } = /** @type {View} */ (this.view);
    return [...(has.reference ? [""] : []), ...candidates.map(({ layout }) => layout)];
  }
  isCompared() {
    return this.besideChoices().length > 0;
  }
  glossyChoices() {
    const view = /** @type {View} */ (this.view);
    if (!view.has.tables) return ["none"];
    return view.environments.length > 0 ? ["none", "area", "environment"] : ["none", "area"];
  }
  overlayChoices() {
    const { has } = /** @type {View} */ (this.view);
    return ["none", ...(has.mesh ? ["charts"] : []), ...(has.clusters ? ["clusters"] : []), "texels"];
  }
  /** Largest tilt of a normal map that the scene was cooked for [degrees]. */
  mostTilt() {
    const maps = /** @type {View} */ (this.view).maps.filter(({ decode, hasMesh }) => decode.hasDirections && hasMesh);
    return Math.max(0, ...maps.map(({ data, asset }) => data.shading?.normal_map_tilt ?? asset.verify?.shading?.normal_map_tilt ?? 0));
  }

  /** @param {State} state */
  restore(state) {
    this.state = state;
    this.allow();
    this.applyCamera();
    this.changed();
    this.place?.show();
  }
  applyCamera() {
    const camera = /** @type {Camera} */ (this.camera), at = this.state.camera;
    camera.isFlying = this.state.navigation === "fly";
    camera.stop();
    if (!at) return camera.frame(/** @type {View} */ (this.view).box);
    camera.view.position.set(at[0], at[1], at[2]);
    camera.target.set(at[3], at[4], at[5]);
    camera.update();
  }
  applyTheme() {
    const isDark = this.state.theme === "dark" || (this.state.theme === "auto" && matchMedia("(prefers-color-scheme: dark)").matches);
    document.documentElement.dataset.theme = isDark ? "dark" : "light";
    document.documentElement.style.colorScheme = isDark ? "dark" : "light";
  }

  moved() {
    const camera = /** @type {Camera} */ (this.camera);
    this.state.camera = [...camera.view.position.toArray(), ...camera.target.toArray()];
    this.redraw();
    this.keepLink();
    // Glossy light of the picked place changes with the view.
    if (this.state.glossy !== "none" || this.state.dominant) this.place?.update();
  }
  /** Shows a changed state everywhere. @param {Partial<State>} [by] */
  changed(by) {
    Object.assign(this.state, by);
    this.applyTheme();
    this.controls.refresh();
    this.redraw();
    this.keepLink();
    if (this.view?.sets.size) void this.needLayouts();
  }
  redraw() {
    if (this.pending) return;
    this.pending = requestAnimationFrame(() => {
      this.pending = 0;
      this.drawNow();
    });
  }
  drawNow() {
    const view = /** @type {View} */ (this.view), camera = /** @type {Camera} */ (this.camera);
    if (!view || !camera) return;
    view.apply(this.state, this.blinked);
    view.draw(camera.view, getComputedStyle(document.documentElement).getPropertyValue("--stage").trim());
    this.place?.mark();
  }
  keepLink() {
    clearTimeout(this.hashTimer);
    this.hashTimer = window.setTimeout(() => history.replaceState(null, "", `#${hashOf(this.state)}`), 250);
  }
  blink() {
    if (this.state.mode !== "blink" || document.hidden) return;
    this.blinked = !this.blinked;
    this.showTags();
    this.redraw();
  }

  // --- cards --------------------------------------------------------------------------------------------------------------------------

  build() {
    const view = /** @type {View} */ (this.view);
    this.buildStage();
    const header = this.header(), settings = [this.viewCard(), this.lightCard()], failures = this.failuresCard(), worst = worstCard(this);
    this.place = new PlaceCard(this);
    const memory = new MemoryCard(this);
    this.panel.replaceChildren(header, ...settings, ...[failures, worst].filter((card) => card !== null), this.place.element, memory.element, this.helpCard());
    const missing = view.maps.filter(({ data }) => !data.reference);
    for (const { data } of missing)
      this.panel.children[1].append(make("p", { class: "note warning" }, `${data.name}: no float bake to compare with. ${data.reference_missing ?? ""}`));
    for (const { data, hasMesh } of view.maps)
      if (!hasMesh) this.panel.children[1].append(make("p", { class: "note" }, `${data.name}: no mesh. The map lies flat, lit from where most light comes.`));
    if (!viewingOf(view.workingSpace).isKnown)
      this.panel.children[1].append(make("p", { class: "note" }, `Working space ${view.workingSpace} is shown as Rec.709.`));
  }

  listenToWipe() {
    const wipe = byId("wipe");
    const move = (/** @type {number} */ at) => this.changed({ wipe: Math.min(Math.max(at, 0), 1) });
    let start = 0, isMoved = false;
    wipe.addEventListener("pointerdown", (event) => {
      wipe.setPointerCapture(event.pointerId);
      [start, isMoved] = [event.clientX, false];
    });
    wipe.addEventListener("pointermove", (event) => {
      const box = this.canvas.getBoundingClientRect();
      isMoved ||= Math.abs(event.clientX - start) >= 3;
      if (isMoved && wipe.hasPointerCapture(event.pointerId)) move((event.clientX - box.left) / box.width);
    });
    // A click means the surface below the line.
    wipe.addEventListener("pointerup", (event) => {
      const box = this.canvas.getBoundingClientRect();
      if (!isMoved && event.button === 0) this.click(event.clientX - box.left, event.clientY - box.top);
    });
    wipe.addEventListener("keydown", (event) => {
      const { wipe: at } = this.state;
      const to = { ArrowLeft: at - 0.02, ArrowDown: at - 0.02, ArrowRight: at + 0.02, ArrowUp: at + 0.02, PageDown: at - 0.1, PageUp: at + 0.1, Home: 0, End: 1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      move(to);
    });
  }
  buildStage() {
    const wipe = byId("wipe"), legend = byId("legend");
    this.controls.follow(() => {
      const { mode } = this.state, isWiped = mode === "wipe";
      wipe.hidden = !isWiped;
      wipe.style.left = `${100 * this.state.wipe}%`;
      wipe.setAttribute("aria-valuenow", String(Math.round(100 * this.state.wipe)));
      legend.hidden = mode !== "error";
      byId("legend-end").textContent = `${this.state.errorEnd} or more`;
      this.showTags();
    });
  }
  /** Names what is shown on each side, with the bytes of its light maps. */
  showTags() {
    const view = /** @type {View} */ (this.view), { mode, layout, beside } = this.state, isWiped = mode === "wipe";
    const isReference = mode === "reference" || (mode === "blink" && this.blinked);
    const right = this.layoutName(layout), tag = (/** @type {string} */ name, /** @type {number} */ bytes) => (bytes > 0 ? `${name}, ${bytesText(bytes)}` : name);
    byId("left-tag").textContent = this.isCompared() && (isWiped || isReference) ? tag(beside || "Reference", beside ? this.bytesOf(beside) : this.bytesOfBakes()) : "";
    byId("right-tag").textContent = mode === "error" ? `Visible error${view.candidates.length > 0 ? ` of ${right}` : ""}` : isReference ? ""
      : tag(view.candidates.length > 0 ? right : "Cooked", this.bytesOf(layout));
  }
  /** Returns the GPU memory of the light maps under a layout. @param {string} layout */
  bytesOf(layout) {
    return bytesCooked(/** @type {View} */ (this.view).setFor(layout).maps.map(({ asset }) => asset));
  }
  /** Returns the bytes of the files of the bakes; 0 without a report. */
  bytesOfBakes() {
    return bytesRead((this.report?.assets ?? []).filter((/** @type {any} */ { kind }) => kind === "light-map"));
  }

  header() {
    const view = /** @type {View} */ (this.view), manifest = /** @type {NonNullable<View["cooked"]>} */ (view.cooked).manifest;
    const themes = ["auto", "light", "dark"];
    const theme = make("button", { id: "theme", title: "Theme", onclick: () => this.changed({ theme: themes[(themes.indexOf(this.state.theme) + 1) % 3] }) });
    this.controls.follow(() => (theme.textContent = `Theme: ${this.state.theme}`));
    const link = make("button", { id: "link", title: "Copy a link that reopens this view", onclick: () => this.copyLink(link) }, "Copy link");
    const picture = make("button", { id: "picture", title: "Save the picture as a PNG", onclick: () => this.savePicture() }, "Save picture");
    const input = make("input", { type: "file", id: "folder", webkitdirectory: true, hidden: true, "aria-label": "Cooked folder" });
    input.addEventListener("change", () => input.files && input.files.length > 0 && this.openFolder(async () => chosenFiles(/** @type {FileList} */ (input.files))));
    const open = make("button", { id: "open", title: "Show another cooked folder of this computer; or drop it on the page", onclick: () => input.click() }, "Open folder");
    const verdict = this.report ? [make("span", { class: `verdict ${this.report.passed ? "passed" : "failed"}` }, this.report.passed ? "Passed" : "Failed")] : [];
    const page = view.source?.reportPage, report = page ? [make("a", { href: page }, "Report")] : [];
    const read = bytesRead(this.report?.assets ?? []), used = bytesText(bytesCooked(manifest.assets));
    const sizes = make("p", { class: "sizes" }, ...(read > 0 ? [bytesText(read), " of files → "] : []), make("b", {}, used), " of GPU memory");
    const again = make("button", { id: "again", title: "The folder has another manifest than the scene that is shown", hidden: true, onclick: () => location.reload() },
      "Cooked again: reload");
    return make("header", { class: "card" }, make("h1", {}, manifest.scene), ...verdict, again, sizes, make("nav", {}, picture, link, open, theme, input),
      make("p", { class: "note warning", id: "folder-fault" }),
      make("span", { class: "soft", style: "flex: 1 1 100%" }, view.source?.isDropped ? "A folder of this computer, read by the page alone. " : "", `${manifest.tool.name} ${manifest.tool.version} `, ...report));
  }
  savePicture() {
    const { mode, wipe } = this.state, scene = /** @type {View} */ (this.view).cooked?.manifest.scene ?? "scene";
    this.drawNow();
    savePicture(this.canvas, `${scene}_${mode}.png`, mode === "wipe" && this.isCompared() ? wipe : null);
  }
  /** @param {HTMLElement} button */
  async copyLink(button) {
    history.replaceState(null, "", `#${hashOf(this.state)}`);
    try {
      await navigator.clipboard.writeText(location.href);
      button.textContent = "Copied";
    } catch {
      button.textContent = "In address bar";
    }
    setTimeout(() => (button.textContent = "Copy link"), 1500);
  }

  /** Name of a layout choice: that of the cooked scene if it is "". @param {string} layout */
  layoutName(layout) {
    const { cooked, maps } = /** @type {View} */ (this.view);
    if (layout || !cooked) return layout;
    const own = [...new Set(cooked.assets("light-map").map((asset) => asset.layout))];
    return own.length === 1 ? own[0] : `as cooked (${maps.length} maps)`;
  }

  /** Chooses a value of a row of buttons. @param {import("./controls.js").Choice} key @param {string} value */
  choose(key, value) {
    this.blinked = false;
    this.changed({ [key]: value });
    if (key === "navigation") /** @type {Camera} */ (this.camera).isFlying = value === "fly";
  }

  viewCard() {
    const { has, candidates } = /** @type {View} */ (this.view), { controls } = this, rows = [];
    if (this.isCompared()) {
      const names = { wipe: "Wipe", reference: "Reference", cooked: "Cooked", blink: "Blink", error: "Error" };
      rows.push(controls.segments("mode", "View", "mode", this.modeChoices().map((mode) => [mode, names[mode]])));
    }
    if (candidates.length > 0) rows.push(...this.layoutRows());
    if (has.reference) {
      const end = controls.slider("errorEnd", "Scale ends at", [1, 50, 1], (value) => String(value));
      controls.follow(() => (end.hidden = this.state.mode !== "error"));
      rows.push(end);
    }
    // The visible error is that of the report's display, whatever the exposure here.
    const exposure = controls.slider("stops", "Exposure", [-8, 8, 0.25], (value) => `${value > 0 ? "+" : ""}${value} stops`);
    controls.follow(() => (exposure.hidden = this.state.mode === "error"));
    rows.push(exposure);
    const names = { none: "None", charts: "Charts", clusters: "Clusters", texels: "Texels" };
    rows.push(controls.select("overlay", "Overlay", this.overlayChoices().map((value) => [value, names[/** @type {keyof names} */ (value)]])));
    if (has.mesh) rows.push(controls.check("seams", "Borders of charts"));
    const home = make("button", { id: "home", onclick: () => this.goHome() }, "Show all");
    rows.push(make("div", { class: "row" }, make("span", {}, "Camera"), controls.segments("navigation", "Camera", "navigation", [["orbit", "Orbit"], ["fly", "Fly"]])), home);
    return make("section", { class: "card" }, make("h2", {}, "View"), ...rows);
  }
  /** Choices of the layouts on both sides. */
  layoutRows() {
    const { candidates } = /** @type {View} */ (this.view), { controls } = this;
    const labels = new Map(candidates.map(({ layout, bytes_gpu, visible }) => [layout, `${layout}: ${bytesText(bytes_gpu)}, visible ${visible === null ? "unknown" : visible.toPrecision(2)}`]));
    const labelOf = (/** @type {string} */ layout) => labels.get(layout) ?? "";
    const fault = make("p", { class: "note warning", id: "layout-fault" });
    controls.follow(() => (fault.textContent = this.layoutFault));
    return [
      controls.select("layout", "Cooked as", [["", `${this.layoutName("")}: this scene`], ...candidates.map(({ layout }) => /** @type {[string, string]} */ ([layout, labelOf(layout)]))]),
      controls.select("beside", "Beside", this.besideChoices().map((layout) => /** @type {[string, string]} */ ([layout, layout ? labelOf(layout) : "The float bake"]))),
      fault,
    ];
  }
  goHome() {
    const camera = /** @type {Camera} */ (this.camera);
    camera.stop();
    camera.frame(/** @type {View} */ (this.view).box);
  }

  lightCard() {
    const view = /** @type {View} */ (this.view), { has } = view, { controls } = this, rows = [];
    if (has.tables) {
      rows.push(controls.check("diffuse", "Diffuse"));
      const names = { none: "None", area: "Area", environment: "Probe" };
      rows.push(make("div", { class: "row" }, make("span", {}, "Glossy"), controls.segments("glossy", "Glossy", "glossy", this.glossyChoices().map((value) => [value, names[/** @type {keyof names} */ (value)]]))));
      if (view.environments.length > 1) {
        const probes = controls.select("environment", "Probe", view.environments.map(({ name }, i) => [i, name]));
        controls.follow(() => (probes.hidden = this.state.glossy !== "environment"));
        rows.push(probes);
      }
      if (has.dominant) rows.push(controls.check("dominant", "Highlight of the dominant light"));
      const [low, high] = view.roughness, roughness = controls.slider("m", "Roughness m", [low, high, 0.005], (value) => value.toFixed(3));
      const gloss = [roughness, controls.slider("f0", "F0", [0, 1, 0.01], (value) => value.toFixed(2))];
      controls.follow(() => gloss.forEach((row) => (row.hidden = this.state.glossy === "none" && !this.state.dominant)));
      rows.push(...gloss);
    }
    rows.push(controls.slider("albedo", "Albedo", [0, 1, 0.01], (value) => value.toFixed(2)));
    if (has.light) {
      const light = controls.slider("light", "Light of the map", [0, 1, 0.01], (value) => value.toFixed(2));
      controls.follow(() => (light.hidden = !this.showsLight()));
      rows.push(light);
    }
    if (has.materials) rows.push(controls.check("materials", "Colours of the materials"));
    const tilt = this.mostTilt();
    if (tilt > 0) rows.push(controls.slider("bump", "Normal map", [0, tilt, 1], (value) => `${value}°`));
    return make("section", { class: "card" }, make("h2", {}, "Light"), ...rows);
  }

  /** Returns true while a shown layout has a light that can be dimmed. */
  showsLight() {
    const view = /** @type {View} */ (this.view), { layout, beside } = this.state;
    return [view.setFor(layout), ...(beside ? [view.setFor(beside)] : [])].some(({ maps }) => maps.some(({ decode }) => decode.layout.hasLight));
  }

  /** Makes the list of what failed, with the advice of the report; null where all passed. */
  failuresCard() {
    const failures = (this.report?.assets ?? []).flatMap((/** @type {any} */ { name, failures: found = [] }) => failureTexts(name, found).map((text) => ({ name, ...text })));
    if (failures.length === 0) return null;
    return make("section", { class: "card" }, make("h2", {}, "What failed"), ...failures.map((/** @type {any} */ { name, found, advice }) =>
      make("p", { class: "note warning" }, `${name}: ${found}.`, advice && make("b", {}, ` ${advice}`))));
  }

  /** Flies to a place of a light map, in front of what lies between. @param {number} map @param {number} u @param {number} v
   * @param {number[] | null} [shaded] normal and view of a sample there @param {Vector3} [towards] unit, from the place to the camera */
  flyTo(map, u, v, shaded = null, towards = undefined) {
    const view = /** @type {View} */ (this.view), camera = /** @type {Camera} */ (this.camera), { meshes, asset } = view.maps[map], found = view.surface(view.maps[map], u, v);
    if (!found) return;
    this.changed({ picked: [map, u, v], shaded });
    this.place?.show();
    const { up } = camera.view, isLevel = Math.abs(found.normal.dot(up)) > 0.9, aside = new Vector3(up.y, up.z, up.x);
    const away = towards ?? found.normal.clone().addScaledVector(isLevel ? aside : up, isLevel ? 0.3 : 0.25).normalize();
    const side = texelSideAt(found, asset.width, asset.height), wanted = (RADIUS_TEXELS / SLOPE) * side, skipped = 1e-3 * side;
    const distance = Math.min(wanted, FREE * (skipped + freeDistance(meshes, found.position.clone().addScaledVector(away, skipped), away, wanted)));
    camera.flyTo(found.position.clone().addScaledVector(away, distance), found.position);
  }

  helpCard() {
    const line = (/** @type {string[]} */ keys, /** @type {string} */ text) => [make("dt", {}, ...keys.flatMap((key) => [make("kbd", {}, key), " "])), make("dd", {}, text)];
    const { has } = /** @type {View} */ (this.view);
    return make("details", { class: "card" }, make("summary", {}, "Keys and touch"),
      make("dl", { style: "margin-top: 8px" },
        ...(has.reference ? [...line(["1", "–", "5"], "wipe, reference, cooked, blink, error"), ...line(["Space"], "the other of reference and cooked")] : []),
        ...line(["[", "]"], "exposure"), ...line(["W", "A", "S", "D", "Q", "E"], "move"), ...line(["F"], "orbit or fly"), ...line(["H"], "show all"),
        make("dt", {}, "Drag"), make("dd", {}, "turn; with Shift or two fingers, move"), make("dt", {}, "Scroll, pinch"), make("dd", {}, "closer or farther")));
  }

  /** @param {number} x [CSS pixels of the canvas] @param {number} y */
  click(x, y) {
    const view = /** @type {View} */ (this.view), { clientWidth, clientHeight } = this.canvas;
    const hit = view.pick(/** @type {Camera} */ (this.camera).view, x / clientWidth, y / clientHeight);
    this.state.picked = hit ? [hit.map, ...hit.uv] : null;
    this.state.shaded = null;
    this.place?.show();
    this.keepLink();
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    // Many keyboards type brackets with AltGr, which some systems report as Ctrl and Alt.
    if ((event.ctrlKey || event.metaKey || event.altKey) && !event.getModifierState("AltGraph")) return;
    const { tagName } = /** @type {HTMLElement} */ (event.target);
    if (tagName === "SELECT" || (event.code === "Space" && ["BUTTON", "SUMMARY", "INPUT"].includes(tagName))) return;
    const { state } = this, digit = Number(event.key), modes = this.isCompared() ? this.modeChoices() : [];
    if (digit >= 1 && digit <= modes.length) this.choose("mode", modes[digit - 1]);
    else if (modes.length > 0 && event.code === "Space") this.choose("mode", state.mode === "reference" ? "cooked" : "reference");
    else if (event.key === "[" || event.key === "]") this.changed({ stops: Math.min(Math.max(state.stops + (event.key === "]" ? 0.5 : -0.5), -8), 8) });
    else if (event.code === "KeyF") this.choose("navigation", state.navigation === "fly" ? "orbit" : "fly");
    else if (event.code === "KeyH") this.goHome();
    else return;
    event.preventDefault();
  }

  // --- values for programs ----------------------------------------------------------------------------------------------------------------

  /**
   * Shades places of a light map with the settings of the page.
   * @param {string} name of the light map @param {[number, number][]} places [texels] integers are centres
   * @param {number[][]} normals unit @param {number[][]} views unit, to the viewer
   */
  shade(name, places, normals, views) {
    const view = /** @type {View} */ (this.view), map = view.maps.find(({ data }) => data.name === name);
    if (!map) throw new Error(`no light map "${name}"`);
    view.apply(this.state, this.blinked);
    const { width, height } = map.asset;
    return view.values(map, places.map(([x, y], i) => {
      /** @type {[number, number]} */
      const uv = [(x + 0.5) / width, (y + 0.5) / height];
      return { uv, bakeUv: view.bakeUvAt(map, uv), cluster: view.clusterOf(map, Math.floor(x + 0.5), Math.floor(y + 0.5)), normal: normals[i], view: views[i] };
    }));
  }

  /** Surfaces at pixels of the canvas: light map, uv, normal and direction to the viewer; null beside the scene.
   * @param {[number, number][]} pixels [CSS pixels] */
  look(pixels) {
    const view = /** @type {View} */ (this.view), camera = /** @type {Camera} */ (this.camera).view, { clientWidth, clientHeight } = this.canvas;
    return pixels.map(([x, y]) => {
      const hit = view.pick(camera, x / clientWidth, y / clientHeight);
      if (!hit) return null;
      const { normal, position, chart } = hit.surface;
      return { map: view.maps[hit.map].data.name, uv: hit.uv, chart, normal: normal.toArray(), view: camera.position.clone().sub(position).normalize().toArray() };
    });
  }
}

const page = new Page();
const ready = page.start().catch((fault) => {
  byId("loading").classList.add("failed");
  byId("progress").hidden = true;
  byId("loading-text").textContent = fault.message;
  console.error(fault);
});
/** For tests and scripts: `await lightcook.ready`, then `lightcook.shade(...)`. */
Object.assign(window, { lightcook: { ready, page, shade: page.shade.bind(page), look: page.look.bind(page) } });
