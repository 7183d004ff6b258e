// The GLSL of the page: shades the float bake and the cooked light map alike, and shows one, the other or their visible error.
import { lightMapVertex } from "../loaders/index.js";
import { DIFFUSE_WHITE, viewingOf } from "./color.js";

/** View modes as the shader knows them. */
export const MODES = /** @type {const} */ (["wipe", "reference", "cooked", "blink", "error"]);

/** @typedef {import("../loaders/core/specular.js").ShaderPart} ShaderPart */

/** @param {number[][]} rows GLSL's matrices are given by columns */
const columns = (rows) => [0, 1, 2].flatMap((c) => rows.map((row) => row[c]));

/**
 * Uniforms that all materials share.
 * @param {string} working colour space
 */
export function sharedUniforms(working) {
  const viewing = viewingOf(working);
  return {
    shownSide: { value: 2 },  // 0: by the border, 1: reference, 2: cooked, 3: error
    borderX: { value: 0 },
    exposureStops: { value: 0 },
    errorEnd: { value: 10 },
    showDiffuse: { value: 1 },
    glossy: { value: 0 },  // 0: none, 1: area specular, 2: environment
    showDominant: { value: 0 },
    roughness: { value: 0.25 },
    f0: { value: 0.04 },
    albedoScale: { value: 1 },
    useMaterials: { value: 0 },
    bumpTilt: { value: 0 },
    bumpFrequency: { value: 1 },
    overlay: { value: 0 },  // 0: none, 1: charts, 2: clusters, 3: texels
    rec709FromWorking: { value: columns(viewing.rec709) },
    lmsFromWorking: { value: columns(viewing.lms) },
    lightMapDim: { value: [1, 1, 1] },  // of layouts with a light of their own
  };
}

/**
 * @param {string} include lightcook.glsl
 * @param {import("../loaders/core/light_map.js").LightMapDecode} lightMap
 * @param {{ tables: ShaderPart | null, dominant: ShaderPart | null, environment: ShaderPart | null, referenceLayers: number }} parts referenceLayers: 0 without a float bake
 */
export function shadingGlsl(include, lightMap, { tables, dominant, environment, referenceLayers }) {
  const hasSpecular = lightMap.hasDirections && tables;
  return `${include}
${lightMap.glsl}
${hasSpecular ? tables.glsl : ""}
${hasSpecular && dominant ? dominant.glsl : ""}
${hasSpecular && environment ? environment.glsl : ""}
uniform float exposureStops, errorEnd, showDiffuse, roughness, f0, albedoScale, useMaterials, bumpTilt, bumpFrequency;
uniform int glossy, overlay;
uniform float showDominant;
uniform mat3 rec709FromWorking, lmsFromWorking;
uniform vec2 display;  // cd/m^2 of one unit of light, and of black
uniform vec2 mapSize;
uniform vec3 materialAlbedo, materialEmission;
#ifndef LIGHT_MAP_TEXTURE
#define LIGHT_MAP_TEXTURE texture
#endif
${referenceLayers > 0 ? "uniform highp sampler2DArray referenceMap;\nuniform float referenceUnit;" : ""}

// The float bake, filtered between covered texels alone. coverage: part of the filter's texels that are covered.
LcSh referenceSh(vec2 uv, out float coverage) {
  LcSh sh;
  for (int i = 0; i < 9; ++i) sh.c[i] = vec3(0.0);
${referenceLayers > 0
    ? `  coverage = LIGHT_MAP_TEXTURE(referenceMap, vec3(uv, 0.0)).a;
  for (int i = 0; i < ${referenceLayers}; ++i) sh.c[i] = LIGHT_MAP_TEXTURE(referenceMap, vec3(uv, float(i))).rgb * (referenceUnit / max(coverage, 1e-4));`
    : "  coverage = 0.0;"}
  return sh;
}

// A test normal map: waves in space, tilted by at most bumpTilt [radians].
vec3 bumped(vec3 n, vec3 place) {
  if (bumpTilt <= 0.0) return n;
  vec3 p = place * bumpFrequency;
  vec3 slope = vec3(cos(p.x) * sin(p.y + 1.0), cos(p.y) * sin(p.z + 2.0), cos(p.z) * sin(p.x + 3.0));
  slope -= dot(slope, n) * n;
  float steepness = length(slope);
  float angle = bumpTilt * min(steepness, 1.0);
  return steepness < 1e-5 ? n : normalize(cos(angle) * n + sin(angle) * slope / steepness);
}

// Exit radiance towards v: diffuse, glossy light and the dominant light's highlight, then clamped at zero.
vec3 shade(LcSh sh, vec3 n, vec3 v, vec2 uv) {
  vec3 albedo = albedoScale * mix(vec3(1.0), materialAlbedo, useMaterials);
  vec3 light = showDiffuse * albedo * lcExitRadiance(sh, n) + useMaterials * materialEmission;
${hasSpecular
    ? `  if (glossy > 0 || showDominant > 0.5) {
    LcSpecularKernel kernel = specularKernel(max(dot(n, v), 0.0), roughness);
    LcSh rest = sh;
${dominant
    ? `    if (showDominant > 0.5) {
      LcDominantLight one = dominantLight(uv, sh, n);
      light += lcDominantSpecular(v, one.direction, one.intensity, n, roughness, vec3(f0));
      rest = lcWithoutLight(sh, lcDominantDirection(one.direction, n), one.intensity);
    }`
    : ""}
    LcFrame frame = lcViewFrame(n, v);
    if (glossy == 1) light += lcAreaSpecular(lcLocalSh(rest, frame.x, frame.y, frame.z), kernel, vec3(f0));
${environment
    ? `    // The table's value for light of 1 from everywhere is the albedo of the lobe.
    if (glossy == 2) light += environmentRadiance(rest, lcReflection(v, n), roughness) * (f0 * kernel.c0236.x + (1.0 - f0) * kernel.d0236.x) / 0.28209479;`
    : ""}
  }`
    : ""}
  return max(light, 0.0);
}

// Normal for a place of a light map without a mesh: towards most of the light.
vec3 brightestNormal(LcSh sh) {
  vec3 axis = lcLinearAxis(sh, vec3(0.2126, 0.7152, 0.0722));
  return dot(axis, axis) < 0.5 ? vec3(0.0, 0.0, 1.0) : axis;
}

// SMPTE ST 2084, of cd/m^2.
vec3 perceptualQuantizer(vec3 nits) {
  vec3 y = pow(clamp(nits / 10000.0, 0.0, 1.0), vec3(2610.0 / 16384.0));
  return pow((0.8359375 + 18.8515625 * y) / (1.0 + 18.6875 * y), vec3(78.84375));
}
vec3 itpOf(vec3 light) {
  vec3 lms = perceptualQuantizer(lmsFromWorking * light * display.x + display.y);
  return 720.0 * vec3(0.5 * (lms.x + lms.y), (6610.0 * lms.x - 13613.0 * lms.y + 7003.0 * lms.z) / 8192.0,
                      (17933.0 * lms.x - 17390.0 * lms.y - 543.0 * lms.z) / 4096.0);
}
// Delta E ITP of two exit radiances.
float visibleError(vec3 a, vec3 b) {
  return distance(itpOf(a), itpOf(b));
}

// Diffuse white of the display is white on the screen; then exposure, and the curve of sRGB.
vec3 shown(vec3 light) {
  vec3 linear = clamp(rec709FromWorking * light * (display.x / ${DIFFUSE_WHITE.toFixed(1)} * exp2(exposureStops)), 0.0, 1.0);
  return mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, linear));
}

// Colours of the report's maps of errors.
vec3 heat(float t) {
  vec3 stops[6] = vec3[6](vec3(0.0), vec3(70.0, 15.0, 110.0) / 255.0, vec3(190.0, 40.0, 75.0) / 255.0, vec3(240.0, 110.0, 30.0) / 255.0,
                          vec3(250.0, 205.0, 60.0) / 255.0, vec3(1.0));
  float x = 5.0 * clamp(t, 0.0, 1.0);
  int i = min(int(x), 4);
  return mix(stops[i], stops[i + 1], x - float(i));
}
vec3 colourOf(float id) {
  vec3 x = fract(id * vec3(0.6180340, 0.7548777, 0.5698403) + vec3(0.1, 0.4, 0.7));
  return 0.15 + 0.8 * x;
}
`;
}

export const FRAGMENT_MAIN = `
in vec2 lightMapUv;
in vec2 placeOfBake;
in vec3 worldNormal;
in vec3 worldPosition;
flat in float cluster;
flat in float chart;
out vec4 fragment;
uniform int shownSide;
uniform float borderX;
uniform vec3 eye;
void main() {
  vec3 v = normalize(eye - worldPosition);
  vec3 n = normalize(worldNormal);
  vec3 tilted = lightMapAxes(bumped(n, worldPosition));
  v = lightMapAxes(v);
#ifdef NO_MESH
  tilted = brightestNormal(lightMapSh(lightMapUv, cluster));
#endif
  int side = shownSide == 0 ? (gl_FragCoord.x < borderX ? 1 : 2) : shownSide;
  vec3 colour;
  float coverage = 1.0;
  vec3 reference = vec3(0.0), cooked = vec3(0.0);
  if (side != 2) reference = shade(referenceSh(placeOfBake, coverage), tilted, v, lightMapUv);
  if (side != 1) cooked = shade(lightMapSh(lightMapUv, cluster), tilted, v, lightMapUv);
  if (side == 3) colour = heat(visibleError(reference, cooked) / errorEnd);
  else colour = shown(side == 1 ? reference : cooked);
  // Nothing was baked here: stripes.
  if (side != 2 && coverage < 1e-3) colour = vec3(mod(gl_FragCoord.x + gl_FragCoord.y, 12.0) < 6.0 ? 0.35 : 0.45);
  if (overlay == 1) colour = mix(colour, colourOf(chart), 0.5);
#ifdef HAS_CLUSTERS
  if (overlay == 2) colour = mix(colour, colourOf(float(lightMapCluster(lightMapUv, cluster)) + 37.0), 0.5);
#endif
  if (overlay == 3) {
    vec2 at = lightMapUv * mapSize, width = fwidth(at), edge = abs(fract(at + 0.5) - 0.5) / max(width, 1e-6);
    float line = (1.0 - clamp(min(edge.x, edge.y), 0.0, 1.0)) * clamp(1.5 - 2.0 * max(width.x, width.y), 0.0, 1.0);
    colour = mix(colour, vec3(0.1, 0.7, 1.0), 0.7 * line);
  }
  fragment = vec4(colour, 1.0);
}`;

/** Rows of the values that the shader of points writes: a column a point. */
export const ROWS = { reference: 0, cooked: 9, referenceLight: 18, cookedLight: 19, error: 20, referenceShown: 21, cookedShown: 22, count: 23 };

/** Places are sampled with float weights, of level 0: a GPU's filter has 8 bits, and neighbours of a point lie anywhere. */
export const POINTS_HEAD = `
vec4 exactTexture(highp sampler2DArray map, vec3 at) {
  ivec2 last = textureSize(map, 0).xy - 1;
  vec2 place = at.xy * vec2(last + 1) - 0.5, low = floor(place), share = place - low;
  ivec2 a = clamp(ivec2(low), ivec2(0), last), b = clamp(ivec2(low) + 1, ivec2(0), last);
  int layer = int(at.z + 0.5);
  vec4 upper = mix(texelFetch(map, ivec3(a, layer), 0), texelFetch(map, ivec3(b.x, a.y, layer), 0), share.x);
  return mix(upper, mix(texelFetch(map, ivec3(a.x, b.y, layer), 0), texelFetch(map, ivec3(b, layer), 0), share.x), share.y);
}
#define LIGHT_MAP_TEXTURE exactTexture
#define LIGHT_MAP_LEVEL 0.0
`;
/** Attributes of a point. place: uv and cluster; normal: as shaded, or 0: that of brightestNormal; view: direction to the viewer; bake: uv of the bake.
 * They are no texture, since a learned layout with detail beside all else takes the sixteen that WebGL2 has. */
const POINT = "vec3 pointPlace, pointNormal, pointView;";

export const POINTS_MAIN = `
flat in ${POINT}
flat in vec2 pointBake;
out vec4 fragment;
void main() {
  int row = int(gl_FragCoord.y);
  vec3 place = pointPlace, n = pointNormal, v = pointView;
  float coverage;
  LcSh reference = referenceSh(pointBake, coverage), cooked = lightMapSh(place.xy, place.z);
  if (dot(n, n) < 0.5) v = n = brightestNormal(cooked);
  if (row < 9) fragment = vec4(reference.c[row], coverage);
  else if (row < 18) fragment = vec4(cooked.c[row - 9], 1.0);
  else {
    vec3 a = shade(reference, n, v, place.xy), b = shade(cooked, n, v, place.xy);
    if (row == 18) fragment = vec4(a, 1.0);
    else if (row == 19) fragment = vec4(b, 1.0);
    else if (row == 20) fragment = vec4(visibleError(a, b));
    else fragment = vec4(shown(row == 21 ? a : b), 1.0);
  }
}`;

export const VERTEX = lightMapVertex("in float chartId;\nin vec2 bakeUv;\nflat out float chart;\nout vec2 placeOfBake;", "chart = chartId;\nplaceOfBake = bakeUv;");

/** Draws a column for each instance. */
export const POINTS_VERTEX = `
in vec3 placeOfPoint, normalOfPoint, viewOfPoint;
in vec2 bakeOfPoint;
uniform float pointCount;
flat out ${POINT}
flat out vec2 pointBake;
void main() {
  pointPlace = placeOfPoint;
  pointNormal = normalOfPoint;
  pointView = viewOfPoint;
  pointBake = bakeOfPoint;
  gl_Position = vec4(2.0 * (float(gl_InstanceID) + 0.5 + position.x) / pointCount - 1.0, 2.0 * position.y, 0.0, 1.0);
}`;
