// Pictures of a cooked folder, which the page holds as data: URLs.
import { make } from "../src/elements.js";

/** The pictures of the page: data: URLs by file. @type {Record<string, string>} */
export const pictures = {};

/** Smaller pictures are enlarged without smoothing, so that texels can be seen [pixels]. */
const SMOOTH_FROM = 256;

/** Returns width and height of a PNG: bytes 16 to 23 of the file. @param {string} url */
export function sizeOf(url) {
  const bytes = atob(url.slice(url.indexOf(",") + 1).slice(0, 32)), word = (at) => [0, 1, 2, 3].reduce((sum, i) => 256 * sum + bytes.charCodeAt(at + i), 0);
  return { width: word(16), height: word(20) };
}

/** Returns the class of a picture that is shown enlarged. */
export const sharpness = ({ width, height }) => (Math.max(width, height) >= SMOOTH_FROM ? "smooth" : "pixels");

/** Makes a picture with its caption, or words in place of one that is missing. @param {string} file @param {string} alt words for readers who do not see it
 * @param {import("../src/elements.js").Content} caption @param {boolean} [isLight] true for tone-mapped light, which is shown at other exposures */
export function picture(file, alt, caption, isLight) {
  const url = pictures[file];
  if (!url) return make("figure", {}, make("div", { class: "missing" }, file ? `picture missing: ${file}` : "no picture"), make("figcaption", {}, caption));
  const size = sizeOf(url);
  return make("figure", {}, make("img", { src: url, alt, class: `${sharpness(size)}${isLight ? " light" : ""}`, ...size }), make("figcaption", {}, caption));
}

const bold = (text) => make("b", {}, text);

/** Makes the pictures of a place as a camera sees it, under the bake and under the cooked map. @param {{ reference: string, cooked: string }[]} views
 * @param {(i: number) => string} nameOf place of a view */
export function viewsOf(views, nameOf) {
  const pair = (view, where) => [["Bake", view.reference], ["Cooked", view.cooked]].map(([name, file]) =>
    picture(file, `${name}, seen around ${where}`, [bold(name), `, the mesh around ${where}`], true));
  return views.length > 0 && make("div", { class: "columns" },
    views.map((view, i) => make("div", {}, make("div", { class: "pictures lit views" }, pair(view, nameOf(i))))));
}

/** Makes reference, cooked and difference of an asset. */
export function comparison({ kind, preview, stages }) {
  if (!preview) return null;
  // Pictures of other assets show local errors, also beside visible figures.
  const isVisible = kind === "light-map" && !!stages[stages.length - 1].error.diffuse?.visible;
  const [reference, cooked] = {
    lut: ["integrated; NoV from grazing (left) to facing, m from smooth (top) to rough, constant light off F0 0.04", "as the shader reads it"],
    mesh: ["the float bake, over the light map", "light-map UVs moved and normals turned by the most that quantization did"],
  }[kind] ?? ["the float bake", "as the shader reads it"];
  const difference = isVisible ? "visible error at the texel's own normal, the worst under each pixel"
    : `local relative error, the worst under each pixel${kind === "lut" ? "; RMS over all lights and F0" : ""}`;
  const scale = make("span", { class: "scale" }, "0", make("span", { class: "heat" }), isVisible ? "10 or more" : "10 % or more");
  return [
    make("div", { class: "pictures lit" }, picture(preview.reference, "reference", [bold("Reference"), `: ${reference}`], true),
      picture(preview.cooked, "cooked", [bold("Cooked"), `: ${cooked}`], true), picture(preview.difference, "difference", [bold("Difference"), `: ${difference}`, scale])),
    preview.any_normal && make("details", {}, make("summary", {}, "Visible error at any normal"), make("div", { class: "pictures" }, picture(preview.any_normal, "any_normal",
      "The largest over the normals that a normal map can turn to, of every texel that the other pictures show; same scale"))),
  ];
}

/** Makes the pictures of the errors of an asset before and now, if they grew and there are files of them. */
export function grownErrors({ picture_before, picture_now }, name) {
  const files = [[picture_before, "errors in the baseline"], [picture_now, "errors now"]].filter(([file]) => file);
  return picture_now && make("div", { class: "pictures grown" }, files.map(([file, role]) => picture(file, `errors of ${name}, ${role}`, [bold(name), `, ${role}`])));
}
