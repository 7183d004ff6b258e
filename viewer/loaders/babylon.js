// Cooked scenes in Babylon.js, WebGL2.
import { Constants } from "@babylonjs/core/Engines/constants.js";
import { BaseTexture } from "@babylonjs/core/Materials/Textures/baseTexture.js";
import { InternalTexture, InternalTextureSource } from "@babylonjs/core/Materials/Textures/internalTexture.js";
import { ShaderMaterial } from "@babylonjs/core/Materials/shaderMaterial.js";
import { Vector2, Vector3, Vector4 } from "@babylonjs/core/Maths/math.vector.js";
import { Mesh } from "@babylonjs/core/Meshes/mesh.js";
import { VertexData } from "@babylonjs/core/Meshes/mesh.vertexData.js";
import { CookedFolder, flatUniforms, glTexture, openFolder, sampleable, surfaceGlsl, surfaceUniforms, vertexGlsl } from "./core/index.js";
import { readMesh } from "./core/mesh.js";

export * from "./core/index.js";

/** @typedef {import("./core/ktx2.js").Ktx2} Ktx2 */

/** Attribute of a mesh with the clusters of a learned layout. */
const CLUSTERS = "lightcookBasis";

/** @param {import("@babylonjs/core/Engines/engine.js").Engine} engine */
const contextOf = (engine) => /** @type {WebGL2RenderingContext} */ (engine._gl);

/**
 * Makes a texture of a KTX2 file: a 2D array of its layers (of one layer, too), or a cubemap. Babylon's own loader knows neither BC6H nor
 * layers, so the texture is uploaded here, and wrapped.
 * @param {Ktx2} ktx
 * @param {import("@babylonjs/core/scene.js").Scene} scene
 * @param {string} name of the file, for messages
 * @param {boolean} [isFiltered] false: fetched texel by texel
 */
export function makeTexture(ktx, scene, name, isFiltered = true) {
  const engine = /** @type {import("@babylonjs/core/Engines/engine.js").Engine} */ (scene.getEngine()), gl = contextOf(engine);
  const internal = new InternalTexture(engine, InternalTextureSource.External);
  glTexture(gl, sampleable(ktx, gl, name), isFiltered, /** @type {any} */ (internal._hardwareTexture).underlyingResource);
  const { TEXTURE_TRILINEAR_SAMPLINGMODE, TEXTURE_BILINEAR_SAMPLINGMODE, TEXTURE_NEAREST_NEAREST_MIPNEAREST, TEXTURE_NEAREST_NEAREST } = Constants;
  const [filtered, fetched] =
    ktx.levels.length > 1 ? [TEXTURE_TRILINEAR_SAMPLINGMODE, TEXTURE_NEAREST_NEAREST_MIPNEAREST] : [TEXTURE_BILINEAR_SAMPLINGMODE, TEXTURE_NEAREST_NEAREST];
  Object.assign(internal, {
    baseWidth: ktx.width, baseHeight: ktx.height, width: ktx.width, height: ktx.height, depth: ktx.layers, isReady: true, label: name,
    is2DArray: ktx.faces !== 6, isCube: ktx.faces === 6, samplingMode: isFiltered ? filtered : fetched,
    useMipMaps: ktx.levels.length > 1, _cachedWrapU: 0, _cachedWrapV: 0, _cachedAnisotropicFilteringLevel: 1,
  });
  const texture = new BaseTexture(scene, internal);
  texture.name = name;
  texture.wrapU = texture.wrapV = Constants.TEXTURE_CLAMP_ADDRESSMODE;
  texture.anisotropicFilteringLevel = 1;
  texture.gammaSpace = false;
  return texture;
}

/** @extends {CookedFolder<BaseTexture>} */
export class CookedScene extends CookedFolder {
  /**
   * Opens a cooked folder, or a .glb that `cook --gltf` wrote. Cooked scenes are right-handed: set `scene.useRightHandedSystem` before.
   * @param {string} url of the folder, with a slash at its end; or of the .glb
   * @param {import("./core/cooked.js").OpenOptions & { scene: import("@babylonjs/core/scene.js").Scene }} options
   */
  static async open(url, options) {
    if (!options.scene.useRightHandedSystem) throw new Error(`${url}: cooked scenes are right-handed; set scene.useRightHandedSystem = true first`);
    const cooked = new CookedScene(...(await openFolder(url, options)), options);
    cooked.scene = options.scene;
    return cooked;
  }

  /** @type {import("@babylonjs/core/scene.js").Scene} */
  scene = /** @type {any} */ (null);

  /** @override @param {Ktx2} ktx @param {string} name @param {boolean} isFiltered */
  makeTexture(ktx, name, isFiltered) {
    return makeTexture(ktx, this.scene, name, isFiltered);
  }

  /** Loads a mesh, in world space, as its primitives. Light-map UVs are `uv2`.
   * @param {import("./core/cooked.js").CookedAsset} asset @param {ShaderMaterial} material */
  async mesh(asset, material) {
    const file = /** @type {string} */ (asset.file), parts = await readMesh(await this.fetch(file), file, this.options.draco);
    const both = parts.some(({ isDoubleSided }) => isDoubleSided) ? material.clone(`${material.name} of both sides`) : material;
    if (both !== material) both.backFaceCulling = false;
    return parts.map((part) => {
      const mesh = this.meshOf(part);
      mesh.material = part.isDoubleSided ? both : material;
      return mesh;
    });
  }

  /** @param {import("./core/mesh.js").MeshPart} part */
  meshOf(part) {
    const mesh = new Mesh(part.name, this.scene), data = new VertexData();
    Object.assign(data, { positions: part.positions, normals: part.normals, uvs2: part.uvs, indices: part.indices });
    data.applyToMesh(mesh);
    if (part.clusters) mesh.setVerticesData(CLUSTERS, part.clusters, false, 1);
    mesh.metadata = { baseColor: part.baseColor, lightMap: part.lightMap };
    return mesh;
  }
}

const NAMES = {
  declarations: `in vec3 position;\nin vec3 normal;\nin vec2 uv2;\n#ifdef LIGHT_MAP_CLUSTER\nin float ${CLUSTERS};\n#endif\nuniform mat4 world, viewProjection;`,
  position: "position", normal: "normal", uv: "uv2", cluster: CLUSTERS, model: "world", viewProjection: "viewProjection",
};

/** Sets a uniform by the form of its value: a Float32Array is an array of floats, a plain array a vector or, if longer, vectors of three.
 * @param {ShaderMaterial} material @param {string} name @param {any} value */
function setUniform(material, name, value) {
  if (value instanceof BaseTexture) material.setTexture(name, value);
  else if (typeof value === "number") material.setFloat(name, value);
  else if (value instanceof Float32Array) material.setFloats(name, Array.from(value));
  else if (value.length === 2) material.setVector2(name, Vector2.FromArray(value));
  else if (value.length === 3) material.setVector3(name, Vector3.FromArray(value));
  else if (value.length === 4) material.setVector4(name, Vector4.FromArray(value));
  else material.setArray3(name, value);
}

/**
 * Makes a material of any shader that reads what was cooked. The GLSL is that of WebGL2.
 * @param {import("@babylonjs/core/scene.js").Scene} scene
 * @param {{ vertex: string, fragment: string, uniforms: import("./core/light_map.js").Uniforms, needsCluster: boolean }} shader
 */
export function cookedMaterial(scene, { vertex, fragment, uniforms, needsCluster }) {
  const values = flatUniforms(uniforms), isTexture = (/** @type {any} */ value) => value instanceof BaseTexture;
  const names = (/** @type {boolean} */ textures) => values.filter(([, value]) => isTexture(value) === textures).map(([name]) => name);
  // With a version, the source is used as it is.
  const version = "#version 300 es\n";
  const material = new ShaderMaterial("lightcook", scene, { vertexSource: version + vertex, fragmentSource: version + fragment }, {
    attributes: ["position", "normal", "uv2", ...(needsCluster ? [CLUSTERS] : [])],
    defines: needsCluster ? ["LIGHT_MAP_CLUSTER"] : [],
    uniforms: ["world", "viewProjection", ...names(false)],
    samplers: names(true),
  });
  material.sideOrientation = Constants.MATERIAL_CounterClockWiseSideOrientation;
  for (const [name, value] of values) setUniform(material, name, value);
  return material;
}

/**
 * Makes a material of a light map: white Lambert exit radiance times the albedo.
 * @param {CookedScene} cooked
 * @param {import("./core/light_map.js").LightMapDecode} lightMap
 * @param {import("./core/shading.js").SurfaceOptions} [options]
 */
export function lightMapMaterial(cooked, lightMap, options = {}) {
  return cookedMaterial(cooked.scene, {
    vertex: vertexGlsl(NAMES), fragment: `precision highp float;\nout vec4 fragment;\n${surfaceGlsl(cooked.shader, lightMap, "fragment")}`,
    uniforms: { ...lightMap.uniforms, ...surfaceUniforms(options) }, needsCluster: lightMap.needsCluster,
  });
}
