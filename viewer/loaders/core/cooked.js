// A cooked folder: manifest, textures and shader include. Each engine adds what makes its textures and meshes.
import { readKtx2 } from "./ktx2.js";
import { isFetched, lightMapDecode } from "./light_map.js";
import { manifestOfGltf } from "./gltf.js";

/**
 * @typedef {object} CookedTexture
 * @property {string} role
 * @property {string} file
 * @property {string} format
 * @property {number} width
 * @property {number} height
 * @property {number} mips
 * @property {number} layers
 * @property {number} faces
 * @property {number} bytes_gpu
 * @property {number} bytes_disk
 * @property {{ filter: "linear" | "trilinear" | "nearest", wrap: string }} sampler
 */
/**
 * @typedef {object} CookedAsset an entry of `assets` in cooked.json (docs/reference/manifest.md)
 * @property {string} name
 * @property {"light-map" | "dominant" | "cubemap" | "lut" | "rsrm" | "mesh"} kind
 * @property {string} layout
 * @property {number} width
 * @property {number} height
 * @property {string} [file]
 * @property {number} [bytes_gpu]
 * @property {number} [bytes_disk]
 * @property {number} [bits_per_texel]
 * @property {number} [key] of a light map: 0.18 / key is the exposure that shows it as middle grey
 * @property {any} [constants]
 * @property {{ layout: string, tiles: number, constants: any }} [detail] tiles of a light map that are stored once more
 * @property {CookedTexture[]} textures
 * @property {{ attribute: string, light_map: string }} [basis]
 * @property {string} [dominant] of a light map: "derived" where the shader derives the dominant light from it
 * @property {string} [light_map] of a dominant light, and of a mesh
 * @property {{ description?: any, files?: Record<string, { file: string, digest: string }> }} [source]
 * @property {any} [verify]
 */
/**
 * @typedef {object} CookedManifest
 * @property {number} schema
 * @property {string} scene
 * @property {string} [digest] of the whole file
 * @property {{ name: string, version: string }} tool
 * @property {{ working: string }} color
 * @property {string} [lobe]
 * @property {"y" | "z" | "x"} [up_axis]
 * @property {{ file: string }} shader
 * @property {CookedAsset[]} assets
 */

/** @typedef {import("./ktx2.js").Ktx2} Ktx2 */
/**
 * @typedef {object} OpenOptions
 * @property {string} [draco] URL of a folder with a Draco decoder; the engine says which files
 * @property {(bytes: number) => void} [onBytes] called with the bytes that have arrived since the last call
 * @property {(url: string) => Promise<Response>} [fetch] in place of the browser's, for files that lie elsewhere
 */

/** @template Texture */
export class CookedFolder {
  /**
   * @param {string} url of the folder, with a slash at its end
   * @param {CookedManifest} manifest
   * @param {string} shader text of lightcook.glsl
   * @param {OpenOptions} [options]
   */
  constructor(url, manifest, shader, options = {}) {
    this.url = url;
    this.manifest = manifest;
    this.shader = shader;
    this.options = options;
  }

  /** Fetches a file of the folder. @param {string} file */
  fetch(file) {
    return fetchBytes(this.url + file, this.options.onBytes, this.options.fetch);
  }

  /** Makes a texture of the engine. Engines override it.
   * @param {Ktx2} ktx @param {string} name of the file @param {boolean} isFiltered false: fetched texel by texel @returns {Texture} */
  makeTexture(ktx, name, isFiltered) {
    throw new Error(`${name}: no engine (${ktx.format.name}, ${isFiltered})`);
  }

  /** @param {CookedAsset["kind"]} kind */
  assets(kind) {
    return this.manifest.assets.filter((asset) => asset.kind === kind);
  }

  /** @param {string} file */
  async read(file) {
    if (!file.endsWith(".ktx2")) throw new Error(`${file}: only KTX2 textures can be loaded; cook with container = "ktx2"`);
    return readKtx2(await this.fetch(file), file);
  }
  /** Returns the factor of the light that shows the light maps as middle grey in the mean: 0.18 over their key. 1 without a key, as in a glTF. */
  exposure() {
    const keys = this.assets("light-map").map(({ key }) => key ?? 0).filter((key) => key > 0);
    return keys.length > 0 ? 0.18 / Math.exp(keys.reduce((sum, key) => sum + Math.log(key), 0) / keys.length) : 1;
  }

  /** Loads a KTX2 file, by its path relative to the folder. @param {string} file @param {boolean} [isFiltered] */
  async texture(file, isFiltered = true) {
    return this.makeTexture(await this.read(file), file, isFiltered);
  }

  /** Loads the textures of an asset, by role. @param {CookedAsset} asset @returns {Promise<Map<string, Texture>>} */
  async textures(asset) {
    return new Map(await Promise.all(asset.textures.map(async (texture) => {
      const ktx = await this.read(texture.file);
      texture.mips = ktx.levels.length;  // a glTF does not say it
      return /** @type {const} */ ([texture.role, this.makeTexture(ktx, texture.file, !isFetched(texture))]);
    })));
  }

  /** Loads a light map: uniforms and GLSL. @param {CookedAsset} asset */
  async lightMap(asset) {
    return lightMapDecode(asset, await this.textures(asset));
  }
}

/**
 * Reads the manifest and the shader include of a cooked folder, or of a glTF that `cook --gltf` wrote.
 * @param {string} url of the folder, with a slash at its end; or of a .glb
 * @param {OpenOptions} [options]
 * @returns {Promise<[url: string, manifest: CookedManifest, shader: string]>}
 */
export async function openFolder(url, { onBytes, fetch } = {}) {
  const folder = url.slice(0, url.lastIndexOf("/") + 1), file = url.slice(folder.length);
  const bytes = await fetchBytes(folder + (file || "cooked.json"), onBytes, fetch);
  const manifest = file ? manifestOfGltf(bytes, file) : jsonOf(bytes, `${url}cooked.json`);
  if (manifest.schema !== 1) throw new Error(`${url}cooked.json: found schema ${manifest.schema}, expected 1`);
  return [folder, manifest, new TextDecoder().decode(await fetchBytes(folder + manifest.shader.file, onBytes, fetch))];
}

/** Parses JSON. @param {Uint8Array} bytes @param {string} name of the file, for messages @returns {any} */
export function jsonOf(bytes, name) {
  try {
    return JSON.parse(new TextDecoder().decode(bytes));
  } catch (fault) {
    throw new Error(`${name}: not a JSON file (${/** @type {Error} */ (fault).message})`);
  }
}

/** Fetches a file and reports its bytes as they arrive. @param {string} url @param {(bytes: number) => void} [onBytes]
 * @param {(url: string) => Promise<Response>} [from] */
export async function fetchBytes(url, onBytes, from = (each) => fetch(each)) {
  const response = await from(url);
  if (!response.ok || !response.body) throw new Error(`${url}: the server answered ${response.status} ${response.statusText}`);
  const parts = [];
  const reader = response.body.getReader();
  let size = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    parts.push(value);
    size += value.length;
    onBytes?.(value.length);
  }
  const bytes = new Uint8Array(size);
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}
