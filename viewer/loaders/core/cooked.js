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
 * @property {any} [constants]
 * @property {CookedTexture[]} textures
 * @property {{ attribute: string, light_map: string }} [basis]
 * @property {string} [dominant] of a light map: "derived" where the shader derives the dominant light from it
 * @property {string} [light_map] of a dominant light, and of a mesh
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
    return fetchBytes(this.url + file, this.options.onBytes);
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

  /** Loads a KTX2 file, by its path relative to the folder. @param {string} file @param {boolean} [isFiltered] */
  async texture(file, isFiltered = true) {
    if (!file.endsWith(".ktx2")) throw new Error(`${file}: only KTX2 textures can be loaded; cook with container = "ktx2"`);
    return this.makeTexture(await readKtx2(await this.fetch(file), file), file, isFiltered);
  }

  /** Loads the textures of an asset, by role. @param {CookedAsset} asset @returns {Promise<Map<string, Texture>>} */
  async textures(asset) {
    return new Map(await Promise.all(asset.textures.map(async (texture) => /** @type {const} */ ([texture.role, await this.texture(texture.file, !isFetched(texture))]))));
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
export async function openFolder(url, { onBytes } = {}) {
  const folder = url.slice(0, url.lastIndexOf("/") + 1), file = url.slice(folder.length);
  const bytes = await fetchBytes(folder + (file || "cooked.json"), onBytes);
  const manifest = file ? manifestOfGltf(bytes, file) : jsonOf(bytes, `${url}cooked.json`);
  if (manifest.schema !== 1) throw new Error(`${url}cooked.json: found schema ${manifest.schema}, expected 1`);
  return [folder, manifest, new TextDecoder().decode(await fetchBytes(folder + manifest.shader.file, onBytes))];
}

/** Parses JSON. @param {Uint8Array} bytes @param {string} name of the file, for messages @returns {any} */
export function jsonOf(bytes, name) {
  try {
    return JSON.parse(new TextDecoder().decode(bytes));
  } catch (fault) {
    throw new Error(`${name}: not a JSON file (${/** @type {Error} */ (fault).message})`);
  }
}

/** Fetches a file and reports its bytes as they arrive. @param {string} url @param {(bytes: number) => void} [onBytes] */
export async function fetchBytes(url, onBytes) {
  const response = await fetch(url);
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
