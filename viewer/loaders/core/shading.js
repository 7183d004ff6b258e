// GLSL of a surface that is lit by a cooked light map: white Lambert exit radiance times the albedo. The same text in every engine.

/**
 * How an engine names what a vertex shader reads. Members are GLSL expressions.
 * @typedef {object} VertexNames
 * @property {string} declarations inputs and uniforms that the engine does not declare itself
 * @property {string} position
 * @property {string} normal
 * @property {string} uv of the light map
 * @property {string} cluster attribute _LIGHTCOOK_BASIS, read if LIGHT_MAP_CLUSTER is defined
 * @property {string} model world from object, mat4
 * @property {string} viewProjection clip from world, mat4
 */

/**
 * Returns the vertex shader of a lit mesh.
 * @param {VertexNames} names
 * @param {string} [declarations] more inputs and outputs
 * @param {string} [statements] that set them
 */
export const vertexGlsl = (names, declarations = "", statements = "") => `
${names.declarations}
out vec2 lightMapUv;
out vec3 worldNormal;
out vec3 worldPosition;
flat out float cluster;
${declarations}
void main() {
  lightMapUv = ${names.uv};
#ifdef LIGHT_MAP_CLUSTER
  cluster = ${names.cluster};
#else
  cluster = 0.0;
#endif
  worldNormal = transpose(inverse(mat3(${names.model}))) * ${names.normal};
  vec4 world = ${names.model} * vec4(${names.position}, 1.0);
  worldPosition = world.xyz;
  gl_Position = ${names.viewProjection} * world;
  ${statements}
}`;

export const LIGHT_MAP_VARYINGS = `
in vec2 lightMapUv;
in vec3 worldNormal;
in vec3 worldPosition;
flat in float cluster;
`;

/**
 * @typedef {object} SurfaceOptions
 * @property {[number, number, number]} [albedo]
 * @property {number} [exposure] factor of the light
 * @property {boolean} [srgb] true: the picture is shown as it is, by the curve of sRGB. false: linear light, for the engine's tone mapping
 */

/** Uniforms of surfaceGlsl beside those of the light map. @param {SurfaceOptions} options @returns {import("./light_map.js").Uniforms} */
export const surfaceUniforms = ({ albedo = [1, 1, 1], exposure = 1, srgb = false }) =>
  ({ surfaceAlbedo: { value: albedo }, surfaceExposure: { value: exposure }, surfaceCurve: { value: srgb ? 1 : 0 } });

/**
 * Returns the fragment shader of a lit mesh.
 * @param {string} include lightcook.glsl
 * @param {import("./light_map.js").LightMapDecode} lightMap
 * @param {string} output where the colour goes, for example gl_FragColor
 */
export const surfaceGlsl = (include, lightMap, output) => `${include}
${LIGHT_MAP_VARYINGS}
${lightMap.glsl}
uniform vec3 surfaceAlbedo;
uniform float surfaceExposure, surfaceCurve;
void main() {
  LcSh sh = lightMapSh(lightMapUv, cluster);
  vec3 light = ${lightMap.hasDirections ? "lcExitRadiance(sh, lightMapAxes(normalize(worldNormal)))" : "0.28209479 * sh.c[0]"};
  light = surfaceExposure * surfaceAlbedo * max(light, 0.0);
  vec3 shown = clamp(light, 0.0, 1.0);
  shown = mix(12.92 * shown, 1.055 * pow(shown, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, shown));
  ${output} = vec4(surfaceCurve > 0.5 ? shown : light, 1.0);
}`;
