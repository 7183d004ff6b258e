// Colour spaces and the visible error, as docs/theory/visible.md defines them.

/** @typedef {[number, number, number]} Vec3 */
/** @typedef {[Vec3, Vec3, Vec3]} Mat3 rows */

/** CIE xy of red, green, blue and white. @type {Record<string, [number, number][]>} */
const SPACES = {
  "lin_rec709": [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]],
  "lin_rec2020": [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], [0.3127, 0.329]],
  "lin_p3d65": [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06], [0.3127, 0.329]],
  "aces2065-1": [[0.7347, 0.2653], [0, 1], [0.0001, -0.077], [0.32168, 0.33767]],
  "acescg": [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.32168, 0.33767]],
};
/** @type {Record<string, string>} */
const ALIASES = { lin_srgb: "lin_rec709", lin_rec709_srgb: "lin_rec709", lin_ap1: "acescg", lin_ap0: "aces2065-1", aces2065_1: "aces2065-1" };
const XYZ = ["lin_ciexyzd65", "cie_xyz_d65"];

/** @param {Mat3} a @param {Vec3} v @returns {Vec3} */
export function apply(a, v) {
  return /** @type {Vec3} */ (a.map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]));
}
/** @param {Mat3} a @param {Mat3} b @returns {Mat3} */
export function multiply(a, b) {
  return /** @type {Mat3} */ (a.map((row) => [0, 1, 2].map((c) => row[0] * b[0][c] + row[1] * b[1][c] + row[2] * b[2][c])));
}
/** @param {Mat3} m @returns {Mat3} */
function inverse([[a, b, c], [d, e, f], [g, h, i]]) {
  const A = e * i - f * h, B = f * g - d * i, C = d * h - e * g, det = a * A + b * B + c * C;
  return /** @type {Mat3} */ ([[A, c * h - b * i, b * f - c * e], [B, a * i - c * g, c * d - a * f], [C, b * g - a * h, a * e - b * d]]
    .map((row) => row.map((x) => x / det)));
}
/** @param {Vec3} v @returns {Mat3} */
function diagonal([x, y, z]) {
  return [[x, 0, 0], [0, y, 0], [0, 0, z]];
}
/** @param {[number, number]} xy @returns {Vec3} */
function xyzOf([x, y]) {
  return [x / y, 1, (1 - x - y) / y];
}
/** SMPTE RP 177. @param {[number, number][]} space @returns {Mat3} */
function xyzFromRgb([red, green, blue, white]) {
  const columns = [red, green, blue].map(([x, y]) => [x, y, 1 - x - y]);
  const unscaled = /** @type {Mat3} */ ([0, 1, 2].map((row) => columns.map((column) => column[row])));
  return multiply(unscaled, diagonal(apply(inverse(unscaled), xyzOf(white))));
}
/** Bradford's adaptation of a white to D65 (ICC.1, annex E). @param {[number, number]} white @returns {Mat3} */
function adaptedToD65(white) {
  /** @type {Mat3} */
  const cone = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
  const from = apply(cone, xyzOf(white)), to = apply(cone, xyzOf([0.3127, 0.329]));
  return multiply(multiply(inverse(cone), diagonal(/** @type {Vec3} */ (to.map((x, i) => x / from[i])))), cone);
}
/** @param {string} name @returns {Mat3 | null} CIE XYZ (D65) from a working space; null if it is unknown */
function xyzFromWorking(name) {
  const key = name.toLowerCase();
  if (XYZ.includes(key)) return diagonal([1, 1, 1]);
  const space = SPACES[ALIASES[key] ?? key];
  return space ? multiply(adaptedToD65(space[3]), xyzFromRgb(space)) : null;
}

/** BT.2020 from BT.709 (ITU-R BT.2087-0), as the verifier has it. @type {Mat3} */
const BT2020_FROM_REC709 = [[0.627404, 0.329283, 0.043313], [0.069097, 0.91954, 0.011362], [0.016391, 0.088013, 0.895595]];
/** ITU-R BT.2100-2, table 7. @type {Mat3} */
const LMS_FROM_BT2020 = /** @type {Mat3} */ ([[1688, 2146, 262], [683, 2951, 462], [99, 309, 3688]].map((row) => row.map((x) => x / 4096)));

/** Matrices of a working space; one that is not known counts as Rec.709.
 * @param {string} working */
export function viewingOf(working) {
  const xyz = xyzFromWorking(working), isRec709 = (ALIASES[working.toLowerCase()] ?? working.toLowerCase()) === "lin_rec709";
  const to = (/** @type {string} */ space, /** @type {Mat3} */ otherwise) => (xyz ? multiply(inverse(xyzFromRgb(SPACES[space])), xyz) : otherwise);
  const bt2020 = isRec709 ? BT2020_FROM_REC709 : to("lin_rec2020", BT2020_FROM_REC709);
  return {
    isKnown: xyz !== null,
    rec709: isRec709 ? diagonal([1, 1, 1]) : to("lin_rec709", diagonal([1, 1, 1])),
    lms: multiply(LMS_FROM_BT2020, bt2020),
  };
}

/** Luminance of diffuse white [cd/m^2] (ITU-R BT.2408). */
export const DIFFUSE_WHITE = 203;

/** Linear Rec.709 as a CSS colour. @param {Vec3} linear */
export function cssOf(linear) {
  const code = linear.map((x) => {
    const v = Math.min(Math.max(x, 0), 1);
    return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
  });
  return `rgb(${code.join(" ")})`;
}
