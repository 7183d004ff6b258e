// Cooked scenes in three.js.
import {
  BufferAttribute, ClampToEdgeWrapping, CompressedArrayTexture, CompressedCubeTexture, CubeTexture, DataArrayTexture, DataTexture, FloatType, GLSL3,
  HalfFloatType, LinearFilter, LinearMipmapLinearFilter, NearestFilter, NearestMipmapNearestFilter, RED_GREEN_RGTC2_Format, RED_RGTC1_Format, RGBAFormat,
  RGBA_ASTC_4x4_Format, RGBA_ASTC_6x6_Format, RGBA_ASTC_8x8_Format, RGBA_BPTC_Format, RGBA_S3TC_DXT5_Format, RGBFormat, RGB_BPTC_SIGNED_Format,
  RGB_BPTC_UNSIGNED_Format, RGB_S3TC_DXT1_Format, RGFormat, RedFormat, SIGNED_RED_GREEN_RGTC2_Format, SIGNED_RED_RGTC1_Format, ShaderMaterial,
  UnsignedByteType, UnsignedInt101111Type, UnsignedInt5999Type, UnsignedShortType,
} from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { DRACOLoader } from "three/addons/loaders/DRACOLoader.js";
import { CookedFolder, imagesOf, lightMapsOfNodes, mipSize, openFolder, sampleable, surfaceGlsl, surfaceUniforms, vertexGlsl } from "./core/index.js";

export * from "./core/index.js";

/** @typedef {import("./core/ktx2.js").Ktx2} Ktx2 */

/** Format and type constants of three.js, by the names of core/pixel_formats.js. @type {Record<string, [any, any]>} */
const FORMATS = {
  "bc1": [RGB_S3TC_DXT1_Format, UnsignedByteType],
  "bc3": [RGBA_S3TC_DXT5_Format, UnsignedByteType],
  "bc4": [RED_RGTC1_Format, UnsignedByteType],
  "bc4-snorm": [SIGNED_RED_RGTC1_Format, UnsignedByteType],
  "bc5": [RED_GREEN_RGTC2_Format, UnsignedByteType],
  "bc5-snorm": [SIGNED_RED_GREEN_RGTC2_Format, UnsignedByteType],
  "bc6h-uf16": [RGB_BPTC_UNSIGNED_Format, HalfFloatType],
  "bc6h-sf16": [RGB_BPTC_SIGNED_Format, HalfFloatType],
  "bc7": [RGBA_BPTC_Format, UnsignedByteType],
  "astc-4x4-ldr": [RGBA_ASTC_4x4_Format, UnsignedByteType],
  "astc-4x4-hdr": [RGBA_ASTC_4x4_Format, HalfFloatType],
  "astc-6x6-hdr": [RGBA_ASTC_6x6_Format, HalfFloatType],
  "astc-8x8-hdr": [RGBA_ASTC_8x8_Format, HalfFloatType],
  "rgb9e5": [RGBFormat, UnsignedInt5999Type],
  "r11g11b10f": [RGBFormat, UnsignedInt101111Type],
  "rgba32f": [RGBAFormat, FloatType],
  "rgba16f": [RGBAFormat, HalfFloatType],
  "rgb16f": [RGBFormat, HalfFloatType],
  "r16-unorm": [RedFormat, UnsignedShortType],
  "rg16-unorm": [RGFormat, UnsignedShortType],
  "rgba16-unorm": [RGBAFormat, UnsignedShortType],
  "rgba8-unorm": [RGBAFormat, UnsignedByteType],
};

/** @param {Ktx2} ktx */
function compressedTexture(ktx) {
  const [format, type] = FORMATS[ktx.format.name];
  const mips = (/** @type {number} */ first, /** @type {number} */ count) =>
    ktx.levels.map((_, mip) => ({ ...mipSize(ktx, mip), data: /** @type {Uint8Array} */ (imagesOf(ktx, mip, first, count)) }));
  if (ktx.faces !== 6) return new CompressedArrayTexture(mips(0, ktx.layers), ktx.width, ktx.height, ktx.layers, format, type);
  const faces = Array.from({ length: 6 }, (_, face) => ({ width: ktx.width, height: ktx.height, mipmaps: mips(face, 1) }));
  return new CompressedCubeTexture(/** @type {any} */ (faces), format, type);
}

/** @param {Ktx2} ktx @param {string} name */
function plainTexture(ktx, name) {
  const [format, type] = FORMATS[ktx.format.name];
  let texture;
  if (ktx.faces !== 6 && ktx.levels.length > 1) {
    // DataArrayTexture has no mips. CompressedArrayTexture has, and takes RGBA that is not compressed.
    if (format !== RGBAFormat) throw new Error(`${name}: three.js has no mips of ${ktx.format.name} arrays, cook without mips`);
    texture = compressedTexture(ktx);
  } else if (ktx.faces === 6) {
    const faces = (/** @type {number} */ mip) =>
      Array.from({ length: 6 }, (_, face) => {
        const { width, height } = mipSize(ktx, mip), side = new DataTexture(imagesOf(ktx, mip, face, 1), width, height, format, type);
        side.needsUpdate = true;
        return side;
      });
    texture = new CubeTexture(/** @type {any} */ (faces(0)));
    texture.mipmaps = /** @type {any} */ (ktx.levels.slice(1).map((_, mip) => ({ image: faces(mip + 1) })));
  } else {
    texture = new DataArrayTexture(imagesOf(ktx, 0), ktx.width, ktx.height, ktx.layers);
    texture.unpackAlignment = 1;
  }
  texture.format = format;
  texture.type = type;
  texture.normalized = !!ktx.format.normalized;
  return texture;
}

/**
 * Makes a texture of a KTX2 file: a 2D array of its layers (of one layer, too), or a cubemap. Filters linearly and clamps, as the errors
 * in report.json assume. Texels are numbers of light or of a decode: no colour space is applied.
 * @param {Ktx2} ktx
 * @param {WebGL2RenderingContext | null} gl context that will sample it; null decodes every format that needs an extension
 * @param {string} name of the file, for messages
 * @param {boolean} [isFiltered] false: fetched texel by texel
 */
export function makeTexture(ktx, gl, name, isFiltered = true) {
  const sampled = sampleable(ktx, gl, name);
  const texture = sampled.format.format === undefined ? compressedTexture(sampled) : plainTexture(sampled, name);
  texture.name = name;
  // WebGL2 fetches no other level than the first of a texture whose filter has no mips.
  const [filtered, fetched] = ktx.levels.length > 1 ? [LinearMipmapLinearFilter, NearestMipmapNearestFilter] : [LinearFilter, NearestFilter];
  texture.minFilter = isFiltered ? filtered : fetched;
  texture.magFilter = isFiltered ? LinearFilter : NearestFilter;
  texture.wrapS = texture.wrapT = ClampToEdgeWrapping;
  texture.generateMipmaps = false;
  texture.flipY = false;
  texture.needsUpdate = true;
  return texture;
}

/** @extends {CookedFolder<import("three").Texture>} */
export class CookedScene extends CookedFolder {
  /**
   * Opens a cooked folder, or a .glb that `cook --gltf` wrote.
   * @param {string} url of the folder, with a slash at its end; or of the .glb
   * @param {import("./core/cooked.js").OpenOptions & { gl: WebGL2RenderingContext | null, draco: string }} options draco: URL of the folder with
   *   three.js' Draco decoder (examples/jsm/libs/draco/gltf), with a slash at its end
   */
  static async open(url, options) {
    const scene = new CookedScene(...(await openFolder(url, options)), options);
    scene.gl = options.gl;
    return scene;
  }

  /** @type {WebGL2RenderingContext | null} */
  gl = null;

  /** @override @param {Ktx2} ktx @param {string} name @param {boolean} isFiltered @returns {import("three").Texture} */
  makeTexture(ktx, name, isFiltered) {
    return makeTexture(ktx, this.gl, name, isFiltered);
  }

  /** Loads a mesh. Light-map UVs are the attribute `uv1`, clusters of a learned layout `_lightcook_basis`.
   * @param {import("./core/cooked.js").CookedAsset} asset @returns {Promise<import("three").Group>} */
  async mesh(asset) {
    const bytes = await this.fetch(/** @type {string} */ (asset.file));
    const draco = new DRACOLoader().setDecoderPath(this.options.draco ?? "");
    try {
      const gltf = await new GLTFLoader().setDRACOLoader(draco).parseAsync(/** @type {ArrayBuffer} */ (bytes.buffer), this.url);
      placeUvs(gltf);
      return gltf.scene;
    } catch (fault) {
      throw new Error(`${asset.file}: ${/** @type {Error} */ (fault).message}`);
    } finally {
      draco.dispose();
    }
  }
}

/** Applies scale and bias of the light-map UVs, and names the light map in userData.lightMap, where a glTF says so.
 * @param {import("three/addons/loaders/GLTFLoader.js").GLTF} gltf */
function placeUvs({ parser }) {
  const lightMaps = lightMapsOfNodes(parser.json);
  for (const [object, association] of parser.associations) {
    // The material of primitives without one has no association.
    const nodes = association?.nodes, placed = nodes === undefined ? undefined : lightMaps.get(nodes);
    if (!placed || !("traverse" in object)) continue;
    // A mesh of several primitives is a group of them. Other children are nodes, which have entries of their own.
    const isPart = (/** @type {any} */ each) => "geometry" in each && (each === object || parser.associations.get(each)?.nodes === undefined);
    for (const part of [object, ...object.children].filter(isPart)) {
      const mesh = /** @type {import("three").Mesh} */ (part), [su, sv, bu, bv] = placed.scaleBias;
      mesh.userData.lightMap = placed.lightMap;
      if (placed.texCoord === 1 && [su, sv, bu, bv].join() === "1,1,0,0") continue;
      // Nodes may share a geometry: each has its own place in the light map.
      const geometry = (mesh.geometry = mesh.geometry.clone());
      const uv = geometry.getAttribute(placed.texCoord === 0 ? "uv" : `uv${placed.texCoord}`), out = new Float32Array(2 * uv.count);
      for (let i = 0; i < uv.count; ++i) out.set([su * uv.getX(i) + bu, sv * uv.getY(i) + bv], 2 * i);
      geometry.setAttribute("uv1", new BufferAttribute(out, 2));
    }
  }
}

const NAMES = {
  declarations: "in vec2 uv1;\n#ifdef LIGHT_MAP_CLUSTER\nin float _lightcook_basis;\n#endif",
  position: "position", normal: "normal", uv: "uv1", cluster: "_lightcook_basis", model: "modelMatrix", viewProjection: "projectionMatrix * viewMatrix",
};

/** Source of the vertex shader of a lit mesh. @param {string} [declarations] more inputs and outputs @param {string} [statements] that set them */
export const lightMapVertex = (declarations, statements) => vertexGlsl(NAMES, declarations, statements);

/**
 * Makes a material of a light map. Output is linear light in the scene's working colour space, times `exposure`; tone map it as you like.
 * @param {CookedScene} scene
 * @param {import("./core/light_map.js").LightMapDecode} lightMap
 * @param {import("./core/shading.js").SurfaceOptions} [options]
 */
export function lightMapMaterial(scene, lightMap, options = {}) {
  return new ShaderMaterial({
    glslVersion: GLSL3,
    defines: lightMap.needsCluster ? { LIGHT_MAP_CLUSTER: 1 } : {},
    uniforms: { ...lightMap.uniforms, ...surfaceUniforms(options) },
    vertexShader: lightMapVertex(),
    fragmentShader: `out vec4 fragment;\n${surfaceGlsl(scene.shader, lightMap, "fragment")}`,
  });
}
