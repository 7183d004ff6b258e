// glTF that `cook --gltf` wrote: its light maps as a manifest. docs/guide/into-an-engine.md describes extension LIGHTCOOK_light_map.

const EXTENSION = "LIGHTCOOK_light_map", GLB = 0x46546c67, JSON_CHUNK = 0x4e4f534a;

/** Returns the JSON of a binary glTF. @param {Uint8Array} bytes @param {string} file for messages */
export function jsonOfGlb(bytes, file) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.length < 20 || view.getUint32(0, true) !== GLB || view.getUint32(16, true) !== JSON_CHUNK) throw new Error(`${file}: not a binary glTF`);
  const length = view.getUint32(12, true);
  if (20 + length > bytes.length) throw new Error(`${file}: cut short in its JSON`);
  return JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
}

/**
 * @typedef {object} NodeLightMap how a node of a glTF is lit
 * @property {string} lightMap
 * @property {number} texCoord set of the UVs
 * @property {[number, number, number, number]} scaleBias of the UVs: scale u, scale v, bias u, bias v
 */

/** Returns how the nodes of a glTF are lit, by their index. Empty for one without the extension: a cooked mesh.
 * @param {any} json @returns {Map<number, NodeLightMap>} */
export function lightMapsOfNodes(json) {
  const maps = json.extensions?.[EXTENSION]?.maps ?? [], found = new Map();
  (json.nodes ?? []).forEach((/** @type {any} */ node, /** @type {number} */ index) => {
    const bound = node.extensions?.[EXTENSION];
    if (bound) found.set(index, { lightMap: maps[bound.map].name, texCoord: bound.texCoord ?? 1, scaleBias: bound.coordinateScaleBias ?? [1, 1, 0, 0] });
  });
  return found;
}

/**
 * Returns the manifest of a glTF: its light maps, and the file itself as the mesh.
 * @param {Uint8Array} bytes @param {string} file @returns {import("./cooked.js").CookedManifest}
 */
export function manifestOfGltf(bytes, file) {
  const json = jsonOfGlb(bytes, file), maps = json.extensions?.[EXTENSION]?.maps;
  if (!maps?.length) throw new Error(`${file}: no extension ${EXTENSION}; write it with lightcook cook --gltf`);
  for (const { name, version } of maps) if (version !== 1) throw new Error(`${file}: light map "${name}" has version ${version}, expected 1`);
  const lightMaps = maps.map((/** @type {any} */ map) => ({
    name: map.name, kind: "light-map", layout: map.layout, width: map.width, height: map.height, constants: map.constants,
    detail: map.detail,
    textures: map.textures.map((/** @type {any} */ { role, uri, ...rest }) => ({ ...rest, role, file: uri })),
  }));
  const mesh = { name: file, kind: "mesh", layout: "glb", width: 0, height: 0, file, light_map: maps[0].name, textures: [] };
  return { schema: 1, scene: file, tool: json.asset.generator, color: { working: maps[0].color }, shader: { file: maps[0].shader.uri },
    assets: [...lightMaps, mesh] };
}
