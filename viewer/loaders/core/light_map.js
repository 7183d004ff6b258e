// Light-map layouts: from the manifest to uniforms and to the GLSL that fetches texels and calls the decode of lightcook.glsl.

/**
 * @typedef {object} Layout
 * @property {string} name middle part of the shader's names: LcRatioTexels, lcLightMapRatio
 * @property {string[]} [numbers] members of the constants that are one number
 * @property {string[]} [lists] members that are arrays of numbers
 * @property {string[]} [vectors] members that are vectors
 * @property {string[]} [single] texel members of one layer, named as their textures
 * @property {Record<string, [string, number]>} [arrays] texel members that are arrays: texture and number of layers
 * @property {3 | 4} [code] numbers of a learned layout's code
 * @property {number} [residuals] layers of its residual
 * @property {boolean} [flat] exit radiance instead of coefficients
 * @property {boolean} [hasLight] one directional light is stored apart from the rest, and can be dimmed: lcLightMap<name>Dimmed
 * @property {Record<string, number>} [sides] textures smaller than the map: side of the square of the map's texels that reads one of theirs
 */

/** @param {3 | 4} code @param {number} residuals @returns {Layout} */
const basis = (code, residuals) => ({ name: `Basis${code}`, code, residuals });
/** @param {number} side of the squares that read a texel of "rest" @returns {Layout} */
const lit = (side) => ({
  name: "Lit", numbers: ["range"], lists: ["scale", "bias"], single: ["l0", "light", "direction"], arrays: { rest: ["rest", 8] }, hasLight: true,
  sides: { rest: side },
});

/** @type {Record<string, Layout>} By the name of the manifest. */
export const LAYOUTS = {
  "raw": { name: "Raw", numbers: ["range"], arrays: { sh: ["sh", 9] } },
  "flat": { name: "Flat", numbers: ["range"], single: ["exit"], flat: true },
  "flat-2": { name: "Flat2", numbers: ["range", "share"], single: ["exit", "second"], flat: true },
  "ratio": { name: "Ratio", numbers: ["range"], lists: ["scale", "bias"], single: ["l0"], arrays: { ratio: ["ratio", 8] } },
  "basis-3": basis(3, 0),
  "basis-4": basis(4, 0),
  "basis-8": basis(4, 1),
  "basis-12": basis(4, 2),
  "basis-16": basis(4, 3),
  "basis-20": basis(4, 4),
  "basis-24": basis(4, 5),
  "sh4": { name: "Sh4", numbers: ["range"], lists: ["scale", "bias"], single: ["l0"], arrays: { ratio: ["ratio", 3] } },
  "godot": { name: "Godot", arrays: { sh: ["sh", 4] } },
  "mono-sh": { name: "MonoSh", single: ["l0", "l1"] },
  "bakery": { name: "Bakery", single: ["l0", "l1x", "l1y", "l1z"] },
  "hdr": { name: "Hdr", numbers: ["range"], lists: ["bias"], arrays: { sh: ["sh", 9] } },
  "halo3": { name: "Halo3", lists: ["range"], arrays: { first: ["luvw_first", 9], second: ["luvw_second", 9] } },
  "hdr-rgb9e5": { name: "HdrRgb9e5", numbers: ["range"], lists: ["bias"], arrays: { sh: ["sh", 9] } },
  "unreal-hq": { name: "UnrealHq", vectors: ["scale0", "add0", "scale1", "add1"], single: ["lightmap0", "lightmap1"] },
  "hdr-2": { name: "Hdr2", numbers: ["range", "share"], lists: ["bias"], arrays: { sh: ["sh", 9], second: ["second", 9] } },
  "lit": lit(1),
  "lit-half": lit(2),
  "lit-quarter": lit(4),
};

const FIRST = { 3: 80, 4: 120 }, RESIDUAL = 36;

/** Cluster of each block of 4 x 4 texels, where the manifest has them as runs. Null without.
 * @param {import("./cooked.js").CookedAsset} asset @returns {Uint8Array | null} */
export function clustersOfBlocks(asset) {
  const runs = asset.constants?.index_runs;
  if (!runs) return null;
  const clusters = new Uint8Array(Math.ceil(asset.width / 4) * Math.ceil(asset.height / 4));
  let at = 0;
  for (let i = 0; i + 1 < runs.length; i += 2) {
    clusters.fill(runs[i], at, at + runs[i + 1]);
    at += runs[i + 1];
  }
  return clusters;
}

/** Returns true for textures that are fetched texel by texel, not filtered. @param {import("./cooked.js").CookedTexture} texture */
export const isFetched = ({ sampler }) => sampler.filter === "nearest";

/** @typedef {Record<string, { value: any }>} Uniforms numbers, textures, number[] for a vector or for vectors of three in a row, Float32Array
 *   for an array of floats, and structs as objects of these */

/**
 * @typedef {object} LightMapDecode
 * @property {Layout} layout
 * @property {boolean} hasDirections false: flat
 * @property {boolean} needsCluster true if the cluster is a vertex attribute
 * @property {Axes} axes of the light, by those of the mesh
 * @property {Uniforms} uniforms
 * @property {string} glsl declares the uniforms and defines, for fragment shaders that include lightcook.glsl before,
 *   `LcSh lightMapSh(vec2 uv, float cluster)`: light of the map at a place; cluster: the attribute _LIGHTCOOK_BASIS, passed flat. Of a
 *   flat map the result is light that is the same from everywhere. Of a learned layout also `int lightMapCluster(vec2 uv, float cluster)`.
 *   Of a map with filter "decoded" also `LcSh lightMapTexel(ivec2 texel, int level, float cluster)`: light of one texel of a mip level.
 *   `vec3 lightMapAxes(vec3 v)` brings a normal or a direction of the mesh's world into the axes of the light, which the scene key
 *   `output_axes` may turn.
 *   The fragment's derivatives choose the level. LIGHT_MAP_LEVEL, if it is defined, is a level for all; LIGHT_MAP_TEXTURE is what samples
 *   textures under filter "hardware", in place of `texture`.
 */

/** @typedef {[component: number, sign: number][]} Axes which component of a vector in the axes of the mesh is x, y and z, and its sign */

/** @param {import("./cooked.js").CookedAsset} asset @returns {Axes} */
export const axesOf = (asset) =>
  (asset.source?.description?.output_axes ?? "x,y,z").split(",").map((/** @type {string} */ part) => ["xyz".indexOf(part.trim().slice(-1)), part.trim().startsWith("-") ? -1 : 1]);

/** @typedef {{ declarations: string[], functions: string[], body: string[], mixed?: string[], uniforms: Uniforms, needsCluster: boolean }} DecodeParts
 *   body: of a function with `cluster` and the place that the fetches read, which returns the light there; mixed: of a learned layout, makes
 *   `LcSh sh` from `LcQuad q` of mip `level` and the factors of `int row`, after it has mixed the texels */

/** @typedef {(role: string, layer?: string, texel?: string) => string} Fetch returns the GLSL of a texel; layer: a GLSL int, texel: an ivec2 */

/** Filter "hardware": the sampler filters at `uv`. @type {Fetch} */
const fetchFiltered = (role, layer = "0") => `LIGHT_MAP_TEXTURE(lightMap_${role}, vec3(uv, ${layer}))`;
const DEFAULT_TEXTURE = ["#ifndef LIGHT_MAP_TEXTURE", "#define LIGHT_MAP_TEXTURE texture", "#endif"];
/** Filter "decoded": the texel that a texel of the map reads, of mip `level`. @param {Layout} layout @returns {Fetch} */
const fetchTexel = ({ sides = {} }) => (role, layer = "0", texel = "texel") => {
  const side = sides[role] ?? 1;
  return `texelFetch(lightMap_${role}, ivec3(${side > 1 ? `${texel} / ${side}` : texel}, ${layer}), level)`;
};
/** The four texels of `LcQuad q`. @param {(texel: string) => string} of @returns {string} arguments */
const corners = (of) => ["00", "10", "01", "11"].map((corner) => of(`q.texel${corner}`)).join(", ");
/** Where detail has the textures of its layout "lit": the array, and the layer of the first. @type {Record<string, [string, number]>} */
const IN_DETAIL = { l0: ["detail_hdr", 0], light: ["detail_hdr", 1], direction: ["detail_ldr", 0], rest: ["detail_ldr", 1] };
/** Detail: texel `texel` of its textures. @type {Fetch} */
const fetchDetail = (role, layer = "0") => {
  const [texture, first] = IN_DETAIL[role];
  return `texelFetch(lightMap_${texture}, ivec3(texel, ${first > 0 ? `${first} + ${layer}` : layer}), 0)`;
};

const firstOf = (/** @type {any} */ value) => [value].flat()[0];
/** @param {string} head @param {string[]} body @returns {string[]} lines of a function */
const functionOf = (head, body) => [`${head} {`, ...body.map((line) => "  " + line), "}"];

/** The decode of a learned layout at `uv`. @param {import("./cooked.js").CookedAsset} asset @param {Map<string, any>} textures
 * @param {Layout} layout @param {Fetch} fetch @returns {DecodeParts} */
function learnedParts(asset, textures, { code = 3, residuals = 0 }, fetch) {
  const count = FIRST[code], needsCluster = !textures.has("index");
  if (!textures.has("tables")) throw new Error(`${asset.name}: layout "${asset.layout}" needs texture "tables"`);
  /** @type {Uniforms} */
  const uniforms = { lightMapRange: { value: firstOf(asset.constants.range) }, lightMapNeutral: { value: firstOf(asset.constants.neutral) ?? 0 } };
  const declarations = ["uniform float lightMapRange, lightMapNeutral;"];
  const row = needsCluster ? "int(cluster + 0.5)" : "lcBasisCluster(texture(lightMap_index, vec3(lcBasisIndexUv(uv, lightMapSize), 0.0)), uv, lightMapSize)";
  /** @type {(light: string, decode: string, add: string) => string[]} light: declares what `decode`, and `add` for each `layer`, take */
  const lines = (light, decode, add) => [`LcBasisFirst${code} first;`,
    `for (int i = 0; i < ${count}; ++i) first.v[i] = texelFetch(lightMap_tables, ivec3(i, row, 0), 0).rgb;`, light, `LcSh sh = ${decode};`,
    ...(residuals > 0 ? [`for (int layer = 0; layer < ${residuals}; ++layer) {`, "LcBasisResidual residual;",
      `for (int i = 0; i < ${RESIDUAL}; ++i) residual.v[i] = texelFetch(lightMap_tables, ivec3(${count} + ${RESIDUAL} * layer + i, row, 0), 0).rgb;`,
      `sh = ${add};`, "}"] : [])];
  const body = lines(`vec4 l0 = ${fetch("l0")};`, `lcLightMapBasis${code}(l0, ${fetch("code")}, first, lightMapRange)`,
    `lcLightMapBasisAdd(sh, l0, ${fetch("residual", "layer")}, residual, lightMapRange, lightMapNeutral)`);
  const four = (/** @type {string} */ role, layer = "0") => corners((texel) => fetch(role, layer, `ivec2(${texel})`));
  const mixed = lines(`LcBasisQuad light = lcBasisQuad(${four("l0")}, q.weights, lightMapRange);`, `lcMixBasis${code}(light, ${four("code")}, first)`,
    `lcMixBasisAdd(sh, light, ${four("residual", "layer")}, residual, lightMapNeutral)`);
  const functions = functionOf("int lightMapCluster(vec2 uv, float cluster)", [`return ${row};`]);
  return { declarations, functions, body: ["int row = lightMapCluster(uv, cluster);", ...body, "return sh;"], mixed, uniforms, needsCluster };
}

/** The decode of a layout without clusters. @param {Layout} layout @param {any} constants @param {Fetch} fetch
 * @param {string} [name] of the uniform with the constants @returns {DecodeParts} */
function plainParts(layout, constants, fetch, name = "lightMapConstants") {
  const members = [...(layout.numbers ?? []), ...(layout.lists ?? []), ...(layout.vectors ?? [])];
  const of = (/** @type {string} */ key) =>
    layout.numbers?.includes(key) ? firstOf(constants[key]) : layout.lists?.includes(key) ? Float32Array.from(constants[key]) : constants[key];
  const value = Object.fromEntries(members.map((key) => [key, of(key)]));
  const hasConstants = members.length > 0, call = ["t", ...(hasConstants ? [name] : []), ...(layout.hasLight ? ["lightMapDim"] : [])];
  const body = [];
  if (layout.flat)
    body.push("LcSh sh;", "for (int i = 0; i < 9; ++i) sh.c[i] = vec3(0.0);",
      `sh.c[0] = lcLightMap${layout.name}(${(layout.single ?? []).map((role) => fetch(role)).join(", ")}, ${name}) / 0.28209479;`,
      "return sh;");
  else {
    body.push(`Lc${layout.name}Texels t;`);
    for (const member of layout.single ?? []) body.push(`t.${member} = ${fetch(member)};`);
    for (const [member, [role, layers]] of Object.entries(layout.arrays ?? {}))
      body.push(`for (int i = 0; i < ${layers}; ++i) t.${member}[i] = ${fetch(role, "i")};`);
    body.push(`return lcLightMap${layout.name}${layout.hasLight ? "Dimmed" : ""}(${call.join(", ")});`);
  }
  const declarations = [
    ...(hasConstants ? [`uniform Lc${layout.name}Constants ${name};`] : []), ...(layout.hasLight ? ["uniform vec3 lightMapDim;"] : []),
  ];
  const uniforms = { ...(hasConstants && { [name]: { value } }), ...(layout.hasLight && { lightMapDim: { value: [1, 1, 1] } }) };
  return { declarations, functions: [], body, uniforms, needsCluster: false };
}

/** The decode of the tiles that have detail. It is dimmed as the map is. @param {Layout} layout of the map
 * @param {NonNullable<import("./cooked.js").CookedAsset["detail"]>} detail @returns {DecodeParts} */
const detailParts = (layout, detail) =>
  plainParts({ ...LAYOUTS[detail.layout], hasLight: layout.hasLight }, detail.constants, fetchDetail, "lightMapDetailConstants");

/** Declares the tile of a texel. @param {string} texel */
const tileOf = (texel) => `vec4 tile = texelFetch(lightMap_coverage, ivec3(lcCoverageTexel(${texel}), 1), 0);`;

/** The light of `LcQuad q` of a learned layout: that of its texels is mixed first, and that of their detail added.
 * @param {string[]} mixed of DecodeParts @param {boolean} hasDetail @returns {string[]} */
const learnedMix = (mixed, hasDetail) => [
  "int row = lightMapCluster((lcQuadTexel(q, 0.5) + 0.5) * exp2(float(level)) / lightMapSize, cluster);",
  ...(hasDetail ? ["vec2 texels[4] = vec2[4](q.texel00, q.texel10, q.texel01, q.texel11);", "LcSh detail;",
    "for (int i = 0; i < 9; ++i) detail.c[i] = vec3(0.0);", "for (int k = 0; k < 4; ++k) {", tileOf("texels[k]"), "if (!lcHasDetail(tile)) continue;",
    "LcSh one = lightMapDetail(ivec2(lcDetailTexel(tile, texels[k])));", "for (int i = 0; i < 9; ++i) detail.c[i] += q.weights[k] * one.c[i];",
    "q.weights[k] = 0.0;", "}", "if (q.weights == vec4(0.0)) return detail;"] : []),
  ...mixed, ...(hasDetail ? ["for (int i = 0; i < 9; ++i) sh.c[i] += detail.c[i];"] : []), "return sh;",
];

/** Filter "decoded": mixes the light of the covered texels around a place (filter.glsl), and that of two mip levels as a trilinear sampler does.
 * @param {Layout} layout @param {DecodeParts} parts @param {number} mips @param {DecodeParts | null} detail of a map with one level
 * @returns {string[]} */
function mixedLines(layout, { body, mixed }, mips, detail) {
  const ofTexel = layout.code ? ["vec2 uv = (vec2(texel) + 0.5) * exp2(float(level)) / lightMapSize;"] : [];
  const choice = [tileOf("vec2(texel)"), "if (lcHasDetail(tile)) return lightMapDetail(ivec2(lcDetailTexel(tile, vec2(texel))));"];
  const lines = [
    ...(detail ? functionOf("LcSh lightMapDetail(ivec2 texel)", detail.body) : []),
    ...functionOf("LcSh lightMapTexel(ivec2 texel, int level, float cluster)", [...(detail ? choice : []), ...ofTexel, ...body]),
    ...functionOf("float lightMapCovered(vec2 texel, int level)",
      ["return lcCovered(texelFetch(lightMap_coverage, ivec3(lcCoverageTexel(texel), 0), level), texel);"]),
    ...functionOf("LcSh lightMapLevel(vec2 uv, int level, float cluster)", ["LcQuad q = lcQuad(uv, lightMapSize * exp2(-float(level)));",
      `q = lcCoveredQuad(q, vec4(${corners((texel) => `lightMapCovered(${texel}, level)`)}));`,
      ...(mixed ? learnedMix(mixed, !!detail) : [`return lcMix(${corners((texel) => `lightMapTexel(ivec2(${texel}), level, cluster)`)}, q.weights);`])]),
  ];
  if (mips === 1) return [...lines, ...functionOf("LcSh lightMapSh(vec2 uv, float cluster)", ["return lightMapLevel(uv, 0, cluster);"])];
  return [
    ...lines, "#ifndef LIGHT_MAP_LEVEL", "#define LIGHT_MAP_LEVEL 0.5 * log2(max(max(dot(across, across), dot(down, down)), 1.0))", "#endif",
    ...functionOf("LcSh lightMapSh(vec2 uv, float cluster)", [
      "vec2 across = dFdx(uv) * lightMapSize, down = dFdy(uv) * lightMapSize;", `float level = clamp(LIGHT_MAP_LEVEL, 0.0, ${(mips - 1).toFixed(1)}), share = fract(level);`,
      "LcSh sh = lightMapLevel(uv, int(level), cluster);", "if (share <= 0.0) return sh;", "LcSh next = lightMapLevel(uv, int(level) + 1, cluster);",
      "for (int i = 0; i < 9; ++i) sh.c[i] = mix(sh.c[i], next.c[i], share);", "return sh;"]),
  ];
}

/**
 * Returns the decode of a light map.
 * @param {import("./cooked.js").CookedAsset} asset
 * @param {Map<string, any>} textures of the engine, by role
 * @returns {LightMapDecode}
 */
export function lightMapDecode(asset, textures) {
  if (asset.layout === "rnm") throw new Error(`${asset.name}: layout "rnm" is decoded with the tangents of the mesh, by the engine's own shader`);
  const layout = LAYOUTS[asset.layout];
  if (!layout) throw new Error(`${asset.name}: layout "${asset.layout}" is unknown to this version of lightcook-loaders`);
  // Texture "coverage" belongs to filter "decoded".
  const isDecoded = textures.has("coverage"), fetch = isDecoded ? fetchTexel(layout) : fetchFiltered;
  const parts = layout.code ? learnedParts(asset, textures, layout, fetch) : plainParts(layout, asset.constants ?? {}, fetch);
  const { declarations, functions, body, uniforms, needsCluster } = parts;
  const detail = asset.detail ? detailParts(layout, asset.detail) : null;
  Object.assign(uniforms, detail?.uniforms);
  if (isDecoded || textures.has("index")) {
    uniforms.lightMapSize = { value: [asset.width, asset.height] };
    declarations.push("uniform vec2 lightMapSize;");
  }
  const samplers = [...textures.keys()].map((role) => `uniform highp sampler2DArray lightMap_${role};`);
  for (const [role, texture] of textures) uniforms[`lightMap_${role}`] = { value: texture };
  const mips = Math.min(...asset.textures.filter(({ role }) => role !== "index" && role !== "tables").map((texture) => texture.mips));
  const decode = isDecoded ? mixedLines(layout, parts, mips, detail) : [...DEFAULT_TEXTURE, ...functionOf("LcSh lightMapSh(vec2 uv, float cluster)", body)];
  const axes = axesOf(asset), turned = axes.map(([component, sign]) => `${sign < 0 ? "-" : ""}v.${"xyz"[component]}`).join(", ");
  const glsl = [...samplers, ...new Set([...declarations, ...(detail?.declarations ?? [])]), ...functions, ...decode, ...functionOf("vec3 lightMapAxes(vec3 v)", [`return vec3(${turned});`])].join("\n");
  return { layout, hasDirections: !layout.flat, needsCluster, axes, uniforms, glsl };
}

/** Uniforms by the names that WebGL has for them, as engines take them that do not know structs: "lightMapConstants.range".
 * @param {Uniforms} uniforms @returns {[string, any][]} */
export function flatUniforms(uniforms) {
  /** @type {(name: string, value: any) => [string, any][]} */
  const flat = (name, value) =>
    value && Object.getPrototypeOf(value) === Object.prototype ? Object.entries(value).flatMap(([key, each]) => flat(`${name}.${key}`, each)) : [[name, value]];
  return Object.entries(uniforms).flatMap(([name, { value }]) => flat(name, value));
}
