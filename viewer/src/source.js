// Where the page takes a scene from: the cooked folder that it was exported with, or one that somebody drops on it.
import { fetchBytes, jsonOf } from "../loaders/index.js";
import { DIFFUSE_WHITE } from "./color.js";

/** @typedef {import("./view.js").ViewedScene} ViewedScene */
/** @typedef {import("../loaders/core/cooked.js").CookedAsset} CookedAsset */
/**
 * @typedef {object} SceneSource
 * @property {string} folder URL of the cooked folder, with a slash at its end
 * @property {(url: string) => Promise<Response>} fetch gives the files of that folder
 * @property {ViewedScene} data
 * @property {any} report report.json; null without
 * @property {string | null} reportPage URL of report.html
 * @property {boolean} isDropped
 */
/** @typedef {Map<string, File>} Files by their paths */

const FOLDER = "cooked/", SCENE_DATA = "viewer/scene.json", MANIFEST = "cooked.json";
/** Part of diffuse white that the key of a light map is shown at. */
const KEY_OF_WHITE = 0.18;

/** The scene of the site. @returns {Promise<SceneSource>} */
export async function siteSource() {
  const data = jsonOf(await fetchBytes(SCENE_DATA), SCENE_DATA);
  if (data.schema !== 1) throw new Error(`${SCENE_DATA}: found schema ${data.schema}, expected 1`);
  // Some servers answer with a page where there is no file.
  const report = await fetch(`${FOLDER}report.json`).then((answer) => (answer.ok ? answer.json() : null)).catch(() => null);
  return { folder: FOLDER, fetch: (url) => fetch(url), data, report, reportPage: report && `${FOLDER}report.html`, isDropped: false };
}

/** Returns the files that were dropped, those of folders too. @param {DataTransfer} transfer @returns {Promise<Files>} */
export async function droppedFiles(transfer) {
  // The list is empty once the event is over.
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
  /** @type {Files} */
  const files = new Map();
  const add = async (/** @type {any} */ entry, /** @type {string} */ path) => {
    if (entry.isFile) files.set(path + entry.name, await new Promise((done, failed) => entry.file(done, failed)));
    if (!entry.isDirectory) return;
    const reader = entry.createReader();
    for (;;) {
      /** @type {any[]} */
      const some = await new Promise((done, failed) => reader.readEntries(done, failed));
      if (some.length === 0) return;
      for (const each of some) await add(each, `${path}${entry.name}/`);
    }
  };
  for (const entry of entries) await add(entry, "");
  return files;
}

/** Returns the files of a form's input for folders. @param {FileList} list @returns {Files} */
export const chosenFiles = (list) => new Map([...list].map((file) => [file.webkitRelativePath || file.name, file]));

/** Returns the digests of a light map's bake. @param {CookedAsset} [asset] */
const bakeOf = (asset) => Object.entries(asset?.source?.files ?? {}).filter(([role]) => role.startsWith("source")).map(([role, { digest }]) => `${role} ${digest}`).sort().join();

/** Returns the display that a light map is shown on (lighting::DisplaySettings::of). @param {CookedAsset} asset */
function displayOf({ key, verify }) {
  const { white, stops = 0, black = 0.5 } = verify?.display ?? {};
  return { nits: (DIFFUSE_WHITE * (white ? 1 / white : KEY_OF_WHITE / (key || 1))) * 2 ** stops, black };
}

/**
 * The scene of a cooked folder. Its light maps are compared with the bakes of the site where those are of the same files.
 * @param {Files} files @param {SceneSource} site @returns {Promise<SceneSource>}
 */
export async function droppedSource(files, site) {
  const [path] = [...files.keys()].filter((name) => name === MANIFEST || name.endsWith(`/${MANIFEST}`)).sort((a, b) => a.split("/").length - b.split("/").length);
  if (path === undefined) throw new Error(`found no ${MANIFEST} among ${files.size} dropped files, expected the output folder of lightcook cook`);
  const folder = path.slice(0, -MANIFEST.length);
  const fetchDropped = async (/** @type {string} */ url) => {
    const file = files.get(url);
    return file ? new Response(file) : new Response(null, { status: 404, statusText: "not among the dropped files" });
  };
  const read = async (/** @type {string} */ url) => jsonOf(await fetchBytes(url, undefined, fetchDropped), url);
  const manifest = await read(path), own = jsonOf(await fetchBytes(FOLDER + MANIFEST), MANIFEST);
  const report = files.has(`${folder}report.json`) ? await read(`${folder}report.json`) : null, page = files.get(`${folder}report.html`);
  /** @type {CookedAsset[]} */
  const assets = manifest.assets;
  const lightMaps = assets.filter(({ kind }) => kind === "light-map").map((asset) => {
    const known = site.data.light_maps.find(({ name }) => name === asset.name), before = own.assets.find((/** @type {CookedAsset} */ each) => each.kind === "light-map" && each.name === asset.name);
    const mesh = assets.find(({ kind, light_map }) => kind === "mesh" && light_map === asset.name)?.name ?? null, shading = asset.verify?.shading ?? null;
    if (known?.reference && bakeOf(asset) === bakeOf(before)) return { ...known, mesh, shading };
    return {
      name: asset.name, reference: null, reference_missing: "The page has no bake of the same file.", reference_scale: 1, reference_layers: 0, mesh,
      display: displayOf(asset), shading,
    };
  });
  return {
    folder, fetch: fetchDropped, data: { schema: 1, scene: manifest.scene, light_maps: lightMaps, candidates: [] }, report, reportPage: page ? URL.createObjectURL(page) : null,
    isDropped: true,
  };
}
