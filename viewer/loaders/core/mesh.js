// Meshes of a cooked scene as arrays, for engines whose glTF loaders drop the attribute _LIGHTCOOK_BASIS. A module of its own: it needs
// @gltf-transform, the rest of core/ does not.
import { Logger, WebIO } from "@gltf-transform/core";
import { KHRDracoMeshCompression, KHRMeshQuantization } from "@gltf-transform/extensions";
import { jsonOfGlb, lightMapsOfNodes } from "./gltf.js";

/**
 * @typedef {object} MeshPart a primitive, in world space
 * @property {string} name of the node
 * @property {Float32Array} positions
 * @property {Float32Array} normals
 * @property {Float32Array} uvs of the light map
 * @property {Float32Array | null} clusters attribute _LIGHTCOOK_BASIS
 * @property {Uint32Array} indices of triangles
 * @property {boolean} isDoubleSided
 * @property {[number, number, number]} baseColor of the material, linear
 * @property {string | undefined} lightMap where the glTF names it
 */

/** @type {Map<string, Promise<any>>} by URL */
const decoders = new Map();

/** Loads a Draco decoder once: draco_wasm_wrapper.js defines DracoDecoderModule, and fetches draco_decoder.wasm. @param {string} folder */
function dracoDecoder(folder) {
  let decoder = decoders.get(folder);
  if (!decoder) {
    decoder = new Promise((resolve, reject) => {
      const script = document.createElement("script");
      script.src = `${folder}draco_wasm_wrapper.js`;
      script.onload = () => resolve(/** @type {any} */ (globalThis).DracoDecoderModule({ locateFile: () => `${folder}draco_decoder.wasm` }));
      script.onerror = () => reject(new Error(`${script.src}: no Draco decoder; copy it from three/examples/jsm/libs/draco/gltf`));
      document.head.append(script);
    });
    decoders.set(folder, decoder);
  }
  return decoder;
}

/** Returns vectors as a matrix maps them: w is 1 for positions, 0 for directions. @param {Float32Array} from @param {number[]} m by columns @param {0 | 1} w */
function transformed(from, m, w) {
  const out = new Float32Array(from.length);
  for (let i = 0; i < from.length; i += 3)
    for (let k = 0; k < 3; ++k) out[i + k] = m[k] * from[i] + m[k + 4] * from[i + 1] + m[k + 8] * from[i + 2] + w * m[k + 12];
  return out;
}

/** Cofactors of the upper 3 x 3: they map normals, up to their length and the sign of the determinant. @param {number[]} m @returns {number[]} */
function normalMatrix(m) {
  const out = new Array(16).fill(0), at = (/** @type {number} */ row, /** @type {number} */ column) => m[4 * (column % 3) + (row % 3)];
  for (let c = 0; c < 3; ++c)
    for (let r = 0; r < 3; ++r) out[4 * c + r] = at(r + 1, c + 1) * at(r + 2, c + 2) - at(r + 1, c + 2) * at(r + 2, c + 1);
  return out.map((value) => value * Math.sign(determinant(m)));
}

/** Determinant of the upper 3 x 3. @param {number[]} m by columns */
function determinant(m) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) + m[1] * (m[6] * m[8] - m[4] * m[10]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
}

/** @param {import("@gltf-transform/core").Primitive} primitive @param {string} semantic @param {number} size */
function floats(primitive, semantic, size) {
  const accessor = primitive.getAttribute(semantic);
  if (!accessor) return null;
  const out = new Float32Array(size * accessor.getCount()), element = new Array(size).fill(0);
  for (let i = 0; i < accessor.getCount(); ++i) out.set(accessor.getElement(i, element), size * i);
  return out;
}

/** Returns the indices of triangles. A matrix that mirrors turns their order round (glTF 2.0, 3.7.4), so that fronts stay fronts.
 * @param {import("@gltf-transform/core").Primitive} primitive @param {number} count of vertices @param {boolean} isMirrored */
function indicesOf(primitive, count, isMirrored) {
  const stored = primitive.getIndices()?.getArray();
  const indices = stored ? Uint32Array.from(stored) : Uint32Array.from({ length: count }, (_, i) => i);
  for (let i = 0; isMirrored && i + 2 < indices.length; i += 3) [indices[i + 1], indices[i + 2]] = [indices[i + 2], indices[i + 1]];
  return indices;
}

/** @param {import("@gltf-transform/core").Node} node @param {import("@gltf-transform/core").Primitive} primitive
 * @param {import("./gltf.js").NodeLightMap | undefined} placed @param {string} file @returns {MeshPart} */
function partOf(node, primitive, placed, file) {
  const semantic = `TEXCOORD_${placed?.texCoord ?? 1}`, [su, sv, bu, bv] = placed?.scaleBias ?? [1, 1, 0, 0];
  const positions = floats(primitive, "POSITION", 3), normals = floats(primitive, "NORMAL", 3), uvs = floats(primitive, semantic, 2);
  if (!positions || !normals || !uvs) throw new Error(`${file}, ${node.getName()}: needs POSITION, NORMAL and ${semantic}`);
  if (primitive.getMode() !== 4) throw new Error(`${file}, ${node.getName()}: found primitives of mode ${primitive.getMode()}, expected triangles`);
  const matrix = node.getWorldMatrix(), material = primitive.getMaterial(), color = material?.getBaseColorFactor() ?? [1, 1, 1, 1];
  for (let i = 0; i < uvs.length; i += 2) uvs.set([su * uvs[i] + bu, sv * uvs[i + 1] + bv], i);
  return {
    name: node.getName(), uvs, lightMap: placed?.lightMap, isDoubleSided: material?.getDoubleSided() ?? false,
    positions: transformed(positions, matrix, 1), normals: transformed(normals, normalMatrix(matrix), 0),
    clusters: floats(primitive, "_LIGHTCOOK_BASIS", 1), indices: indicesOf(primitive, positions.length / 3, determinant(matrix) < 0),
    baseColor: [color[0], color[1], color[2]],
  };
}

/**
 * Reads the mesh of a cooked scene: a Draco or plain .glb that `cook` wrote, or the glTF of `cook --gltf`.
 * @param {Uint8Array} bytes @param {string} file for messages
 * @param {string} [draco] URL of a folder with draco_wasm_wrapper.js and draco_decoder.wasm, with a slash at its end
 * @returns {Promise<MeshPart[]>}
 */
export async function readMesh(bytes, file, draco) {
  const json = jsonOfGlb(bytes, file), isDraco = (json.extensionsRequired ?? []).includes("KHR_draco_mesh_compression");
  if (isDraco && draco === undefined) throw new Error(`${file}: compressed by Draco; set option "draco" to the folder of a decoder`);
  const io = new WebIO().setLogger(new Logger(Logger.Verbosity.ERROR)).registerExtensions([KHRDracoMeshCompression, KHRMeshQuantization]);
  if (isDraco) io.registerDependencies({ "draco3d.decoder": await dracoDecoder(/** @type {string} */ (draco)) });
  const placed = lightMapsOfNodes(json), { nodes } = await io.readBinary(bytes).then((document) => ({ nodes: document.getRoot().listNodes() }));
  return nodes.flatMap((node, index) => (node.getMesh()?.listPrimitives() ?? []).map((primitive) => partOf(node, primitive, placed.get(index), file)));
}
