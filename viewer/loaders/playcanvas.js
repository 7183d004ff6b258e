// Cooked scenes in PlayCanvas, WebGL2.
import {
  ADDRESS_CLAMP_TO_EDGE, BoundingBox, CULLFACE_BACK, CULLFACE_NONE, Entity, FILTER_LINEAR, FILTER_LINEAR_MIPMAP_LINEAR, FILTER_NEAREST,
  FILTER_NEAREST_MIPMAP_NEAREST, Mesh, MeshInstance, PIXELFORMAT_111110F, PIXELFORMAT_ASTC_4x4, PIXELFORMAT_BC6F, PIXELFORMAT_BC6UF, PIXELFORMAT_BC7, PIXELFORMAT_DXT1,
  PIXELFORMAT_DXT5, PIXELFORMAT_RGB16F, PIXELFORMAT_RGB9E5, PIXELFORMAT_RGBA16F, PIXELFORMAT_RGBA32F, PIXELFORMAT_RGBA8, SEMANTIC_ATTR8,
  SEMANTIC_NORMAL, SEMANTIC_POSITION, SEMANTIC_TEXCOORD1, ShaderMaterial, Texture,
} from "playcanvas";
import { CookedFolder, flatUniforms, imagesOf, openFolder, sampleable, surfaceGlsl, surfaceUniforms, vertexGlsl } from "./core/index.js";
import { readMesh } from "./core/mesh.js";

export * from "./core/index.js";

/** @typedef {import("./core/ktx2.js").Ktx2} Ktx2 */

/** Pixel formats of PlayCanvas, by the names of core/pixel_formats.js. What is not here is decoded: BC4, BC5, 16-bit unorm, larger ASTC. */
const FORMATS = new Map(Object.entries({
  "bc1": PIXELFORMAT_DXT1,
  "bc3": PIXELFORMAT_DXT5,
  "bc6h-uf16": PIXELFORMAT_BC6UF,
  "bc6h-sf16": PIXELFORMAT_BC6F,
  "bc7": PIXELFORMAT_BC7,
  "astc-4x4-ldr": PIXELFORMAT_ASTC_4x4,
  "astc-4x4-hdr": PIXELFORMAT_ASTC_4x4,
  "rgb9e5": PIXELFORMAT_RGB9E5,
  "r11g11b10f": PIXELFORMAT_111110F,
  "rgba32f": PIXELFORMAT_RGBA32F,
  "rgba16f": PIXELFORMAT_RGBA16F,
  "rgb16f": PIXELFORMAT_RGB16F,
  "rgba8-unorm": PIXELFORMAT_RGBA8,
}));

/**
 * Makes a texture of a KTX2 file: a 2D array of its layers (of one layer, too), or a cubemap.
 * @param {Ktx2} ktx
 * @param {import("playcanvas").GraphicsDevice} device
 * @param {string} name of the file, for messages
 * @param {boolean} [isFiltered] false: fetched texel by texel
 */
export function makeTexture(ktx, device, name, isFiltered = true) {
  const sampled = sampleable(ktx, /** @type {any} */ (device).gl, name, (format) => FORMATS.has(format.name)), isCube = ktx.faces === 6;
  const images = isCube ? 6 : ktx.layers;
  const [filtered, fetched] = ktx.levels.length > 1 ? [FILTER_LINEAR_MIPMAP_LINEAR, FILTER_NEAREST_MIPMAP_NEAREST] : [FILTER_LINEAR, FILTER_NEAREST];
  return new Texture(device, {
    name, width: ktx.width, height: ktx.height, format: FORMATS.get(sampled.format.name), cubemap: isCube, arrayLength: isCube ? 0 : ktx.layers,
    levels: /** @type {any} */ (ktx.levels.map((_, mip) => Array.from({ length: images }, (_, image) => imagesOf(sampled, mip, image, 1)))),
    mipmaps: ktx.levels.length > 1, numLevels: ktx.levels.length, minFilter: isFiltered ? filtered : fetched,
    magFilter: isFiltered ? FILTER_LINEAR : FILTER_NEAREST, addressU: ADDRESS_CLAMP_TO_EDGE, addressV: ADDRESS_CLAMP_TO_EDGE,
  });
}

/** @extends {CookedFolder<Texture>} */
export class CookedScene extends CookedFolder {
  /**
   * Opens a cooked folder, or a .glb that `cook --gltf` wrote.
   * @param {string} url of the folder, with a slash at its end; or of the .glb
   * @param {import("./core/cooked.js").OpenOptions & { device: import("playcanvas").GraphicsDevice }} options device: app.graphicsDevice, WebGL2
   */
  static async open(url, options) {
    if (!options.device.isWebGL2) throw new Error(`${url}: the shaders are GLSL; create the graphics device with deviceTypes: ["webgl2"]`);
    const cooked = new CookedScene(...(await openFolder(url, options)), options);
    cooked.device = options.device;
    return cooked;
  }

  /** @type {import("playcanvas").GraphicsDevice} */
  device = /** @type {any} */ (null);

  /** @override @param {Ktx2} ktx @param {string} name @param {boolean} isFiltered */
  makeTexture(ktx, name, isFiltered) {
    return makeTexture(ktx, this.device, name, isFiltered);
  }

  /** Loads a mesh, in world space, as an entity with a material. Light-map UVs are TEXCOORD1.
   * @param {import("./core/cooked.js").CookedAsset} asset @param {ShaderMaterial} material */
  async mesh(asset, material) {
    const file = /** @type {string} */ (asset.file), parts = await readMesh(await this.fetch(file), file, this.options.draco);
    const both = parts.some(({ isDoubleSided }) => isDoubleSided) ? /** @type {ShaderMaterial} */ (material.clone()) : material;
    if (both !== material) both.cull = CULLFACE_NONE;
    both.update();
    const entity = new Entity(asset.name);
    entity.addComponent("render", { meshInstances: parts.map((part) => new MeshInstance(this.meshOf(part), part.isDoubleSided ? both : material)) });
    return entity;
  }

  /** @param {import("./core/mesh.js").MeshPart} part */
  meshOf(part) {
    const mesh = new Mesh(this.device);
    mesh.setPositions(part.positions);
    mesh.setNormals(part.normals);
    mesh.setUvs(1, part.uvs);
    if (part.clusters) mesh.setVertexStream(SEMANTIC_ATTR8, part.clusters, 1);
    mesh.setIndices(part.indices);
    mesh.update();
    mesh.aabb = boxOf(part.positions);
    return mesh;
  }
}

/** @param {Float32Array} positions */
function boxOf(positions) {
  const box = new BoundingBox();
  box.compute(positions);
  return box;
}

const NAMES = {
  declarations: `in vec3 vertex_position;\nin vec3 vertex_normal;\nin vec2 vertex_texCoord1;\n#ifdef LIGHT_MAP_CLUSTER\nin float lightcook_basis;\n#endif
uniform mat4 matrix_model;\nuniform mat4 matrix_viewProjection;`,
  position: "vertex_position", normal: "vertex_normal", uv: "vertex_texCoord1", cluster: "lightcook_basis", model: "matrix_model",
  viewProjection: "matrix_viewProjection",
};

/** GLSL's type of a plain uniform, and what follows its name. @param {any} value @returns {[string, string]} */
function typeOf(value) {
  if (typeof value === "number") return ["float", ""];
  if (value instanceof Float32Array) return ["float", `[${value.length}]`];
  return value.length <= 4 ? [`vec${value.length}`, ""] : ["vec3", `[${value.length / 3}]`];
}

/**
 * Returns a shader without uniforms that are structs: PlayCanvas moves uniforms to the top, before the structs are declared. A member
 * becomes a uniform of its own, `lightMapConstants_range`, and the struct's name a macro that puts them together.
 * @param {string} glsl @param {import("./core/light_map.js").Uniforms} uniforms
 * @returns {{ fragment: string, values: [string, any][] }}
 */
export function withoutStructs(glsl, uniforms) {
  /** @type {[string, any][]} */
  const values = [];
  for (const [name, uniform] of Object.entries(uniforms)) {
    const members = flatUniforms({ [name]: uniform });
    if (members.length === 1 && members[0][0] === name) values.push(members[0]);
    else {
      const plain = (/** @type {string} */ member) => member.replaceAll(".", "_");
      values.push(...members.map(([member, value]) => /** @type {[string, any]} */ ([plain(member), value])));
      const lines = members.map(([member, value]) => `uniform ${typeOf(value)[0]} ${plain(member)}${typeOf(value)[1]};`);
      const sets = members.map(([member]) => `  s${member.slice(name.length)} = ${plain(member)};`);
      glsl = glsl.replace(new RegExp(`uniform (\\w+) ${name};`), (_, type) =>
        [...lines, `${type} ${name}_value() {`, `  ${type} s;`, ...sets, "  return s;", "}", `#define ${name} ${name}_value()`].join("\n"));
    }
  }
  return { fragment: glsl, values };
}

/**
 * Makes a material of any shader that reads what was cooked. The fragment shader writes gl_FragColor.
 * @param {{ name: string, vertex: string, fragment: string, uniforms: import("./core/light_map.js").Uniforms, needsCluster: boolean }} shader
 */
export function cookedMaterial({ name, vertex, fragment, uniforms, needsCluster }) {
  const plain = withoutStructs(fragment, uniforms);
  const material = new ShaderMaterial({
    uniqueName: name, vertexGLSL: (needsCluster ? "#define LIGHT_MAP_CLUSTER\n" : "") + vertex, fragmentGLSL: plain.fragment,
    attributes: {
      vertex_position: SEMANTIC_POSITION, vertex_normal: SEMANTIC_NORMAL, vertex_texCoord1: SEMANTIC_TEXCOORD1,
      ...(needsCluster ? { lightcook_basis: SEMANTIC_ATTR8 } : {}),
    },
  });
  for (const [key, value] of plain.values) setUniform(material, key, value);
  material.cull = CULLFACE_BACK;
  material.update();
  return material;
}

/** Sets a uniform. PlayCanvas names arrays by their first element. @param {ShaderMaterial} material @param {string} name @param {any} value */
function setUniform(material, name, value) {
  const isArray = value instanceof Float32Array || (Array.isArray(value) && value.length > 4);
  material.setParameter(isArray ? `${name}[0]` : name, isArray ? Float32Array.from(value) : value);
}

/**
 * Makes a material of a light map: white Lambert exit radiance times the albedo.
 * @param {CookedScene} cooked
 * @param {import("./core/light_map.js").LightMapDecode} lightMap
 * @param {import("./core/shading.js").SurfaceOptions} [options]
 */
export function lightMapMaterial(cooked, lightMap, options = {}) {
  return cookedMaterial({
    name: `lightcook-${lightMap.layout.name}`, vertex: vertexGlsl(NAMES), fragment: surfaceGlsl(cooked.shader, lightMap, "gl_FragColor"),
    uniforms: { ...lightMap.uniforms, ...surfaceUniforms(options) }, needsCluster: lightMap.needsCluster,
  });
}
