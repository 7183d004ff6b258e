// The picture that the canvas shows, as a file: with the border of a wipe, and what is on its sides.
import { byId, make } from "./elements.js";

const MARGIN = 10, TEXT = 14;

/** Writes a text on a dark plate. @param {CanvasRenderingContext2D} context @param {string} text @param {number} x of its left end, or its right one where it is negative @param {number} bottom */
function label(context, text, x, bottom) {
  if (!text) return;
  const width = context.measureText(text).width + 2 * MARGIN, left = x < 0 ? context.canvas.width + x - width : x;
  context.fillStyle = "#000a";
  context.fillRect(left, bottom - TEXT - MARGIN, width, TEXT + MARGIN);
  context.fillStyle = "#fff";
  context.fillText(text, left + MARGIN, bottom - MARGIN + 1);
}

/**
 * Offers the picture as a PNG. The canvas must have been drawn in the same task: WebGL keeps no picture.
 * @param {HTMLCanvasElement} canvas @param {string} name of the file @param {number | null} wipe share of the width at which a line is drawn
 */
export function savePicture(canvas, name, wipe) {
  const copy = make("canvas", { width: canvas.width, height: canvas.height }), context = /** @type {CanvasRenderingContext2D} */ (copy.getContext("2d"));
  context.drawImage(canvas, 0, 0);
  if (wipe !== null) {
    context.fillStyle = "#fff";
    context.fillRect(Math.round(wipe * copy.width) - 1, 0, 2, copy.height);
  }
  context.font = `${TEXT}px system-ui, sans-serif`;
  label(context, byId("left-tag").textContent ?? "", MARGIN, copy.height - MARGIN);
  label(context, byId("right-tag").textContent ?? "", -MARGIN, copy.height - MARGIN);
  copy.toBlob((blob) => {
    if (!blob) return;
    const url = URL.createObjectURL(blob), link = make("a", { href: url, download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(url), 60000);
  }, "image/png");
}
