// Specular tables, dominant lights and cubemaps: uniforms and GLSL beside lightcook.glsl.

/** @typedef {{ uniforms: Record<string, { value: any }>, glsl: string }} ShaderPart */

/** Tables of the area-specular kernel. The GLSL has `LcSpecularKernel specularKernel(float NoV, float m)`.
 * @param {import("./cooked.js").CookedAsset} asset @param {Map<string, any>} textures by role @returns {ShaderPart} */
export function specularTables(asset, textures) {
  const { constants } = asset;
  const values = (/** @type {string} */ kind) =>
    ({ c0236: constants[`c0236_${kind}`], d0236: constants[`d0236_${kind}`], cd78: constants[`cd78_${kind}`] });
  /** @type {Record<string, { value: any }>} */
  const uniforms = { tableConstants: { value: { scale: values("scale"), bias: values("bias") } } };
  for (const axis of ["view", "roughness"]) {
    uniforms[`${axis}Factors`] = { value: constants[axis].factors };
    uniforms[`${axis}Place`] = { value: [constants[axis].scale, constants[axis].offset] };
  }
  for (const role of ["c0236", "d0236", "cd78"]) uniforms[`table_${role}`] = { value: textures.get(role) };
  const glsl = `
uniform LcSpecularConstants tableConstants;
uniform vec4 viewFactors, roughnessFactors;
uniform vec2 viewPlace, roughnessPlace;
uniform highp sampler2DArray table_c0236, table_d0236, table_cd78;
LcSpecularKernel specularKernel(float NoV, float m) {
  vec3 at = vec3(lcTableCoordinate(lcTableAxis(NoV, viewFactors), viewPlace.x, viewPlace.y),
                 lcTableCoordinate(lcTableAxis(m, roughnessFactors), roughnessPlace.x, roughnessPlace.y), 0.0);
  LcSpecularKernel texels;
  texels.c0236 = texture(table_c0236, at);
  texels.d0236 = texture(table_d0236, at);
  texels.cd78 = texture(table_cd78, at);
  return lcSpecularKernel(texels, tableConstants);
}`;
  return { uniforms, glsl };
}

/** A dominant light that the shader derives from the light map: `dominant: "derived"` of its asset. The GLSL has
 * `LcDominantLight dominantLight(vec2 uv, LcSh sh, vec3 normal)`, as that of dominantLight(); sh is the light map's there. @returns {ShaderPart} */
export const derivedLight = () => ({
  uniforms: {}, glsl: "LcDominantLight dominantLight(vec2 uv, LcSh sh, vec3 normal) {\n  return lcDerivedLight(sh, normal);\n}",
});

/** A dominant light. The GLSL has `vec3 dominantDirection(vec2 uv)`, unnormalised, and `vec3 dominantIntensity(vec2 uv)`; and both as
 * `LcDominantLight dominantLight(vec2 uv, LcSh sh, vec3 normal)`.
 * @param {import("./cooked.js").CookedAsset} asset @param {Map<string, any>} textures by role @returns {ShaderPart} */
export function dominantLight(asset, textures) {
  const k = asset.constants;
  /** @type {Record<string, { value: any }>} */
  const uniforms = {
    dominantScaleBias: { value: [k.direction_scale, k.direction_bias] },
    dominantResidual: { value: [k.residual_scale, k.residual_centre] },
    dominantRange: { value: k.intensity_range },
  };
  for (const role of ["direction", "residual", "intensity"]) uniforms[`dominant_${role}`] = { value: textures.get(role) };
  const glsl = `
uniform vec2 dominantScaleBias, dominantResidual;
uniform float dominantRange;
uniform highp sampler2DArray dominant_direction, dominant_residual, dominant_intensity;
vec3 dominantDirection(vec2 uv) {
  vec3 stored = lcDominantStored(texture(dominant_direction, vec3(uv, 0.0)).rgb, texture(dominant_residual, vec3(uv, 0.0)).rgb,
                                 dominantResidual.x, dominantResidual.y);
  return dominantScaleBias.x * stored + vec3(dominantScaleBias.y);
}
vec3 dominantIntensity(vec2 uv) {
  return dominantRange * texture(dominant_intensity, vec3(uv, 0.0)).rgb;
}
LcDominantLight dominantLight(vec2 uv, LcSh sh, vec3 normal) {
  LcDominantLight light;
  light.direction = dominantDirection(uv);
  light.intensity = dominantIntensity(uv);
  return light;
}`;
  return { uniforms, glsl };
}

/** Most levels of a cubemap: faces of 2048 texels have 12. */
const MOST_MIPS = 16;

/** A cubemap. The GLSL has `vec3 environmentRadiance(LcSh sh, vec3 direction, float m)`: radiance through the lobe of roughness m. Of a
 * pre-divided map, sh is the light of the pixel, which brings the energy.
 * @param {import("./cooked.js").CookedAsset} asset @param {Map<string, any>} textures by role @returns {ShaderPart} */
export function environmentMap(asset, textures) {
  const { constants } = asset;
  const bands = Array.from({ length: MOST_MIPS }, (_, mip) => constants.mips[Math.min(mip, constants.mips.length - 1)].bands);
  const last = constants.mips.length - 1;
  const uniforms = environmentUniforms(asset.layout === "pre-divided", [last, constants.first_level ?? 0], constants.range, bands, textures.get("cubemap"));
  const glsl = `
uniform highp samplerCube environmentMap;
uniform float environmentRange, environmentIsDivided;
uniform vec2 environmentLevels;  // the last level, and the number of larger ones that were left out
uniform vec3 environmentBands[${MOST_MIPS}];
vec3 environmentRadiance(LcSh sh, vec3 direction, float m) {
  float level = clamp(sqrt(m) * (environmentLevels.x + environmentLevels.y) - environmentLevels.y, 0.0, environmentLevels.x);
  vec3 stored = textureLod(environmentMap, direction, level).rgb;
  if (environmentIsDivided < 0.5) return lcPrefiltered(stored, environmentRange);
  int first = int(level);
  vec3 bands = mix(environmentBands[first], environmentBands[min(first + 1, ${MOST_MIPS - 1})], fract(level));
  return lcEnvironment(environmentRange * stored, lcZonalSpecular(sh, direction, bands));
}`;
  return { uniforms, glsl };
}

/** @param {boolean} isDivided @param {[number, number]} levels @param {number} range @param {number[][]} bands @param {any} texture
 * @returns {Record<string, { value: any }>} */
function environmentUniforms(isDivided, levels, range, bands, texture) {
  return {
    environmentMap: { value: texture },
    environmentRange: { value: range },
    environmentLevels: { value: levels },
    environmentIsDivided: { value: isDivided ? 1 : 0 },
    environmentBands: { value: bands.flat() },
  };
}
