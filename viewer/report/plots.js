// Plots as SVG: error against memory or run time of the layouts that were tried, histograms of visible errors, allocations of memory, trends.
import { draw, make } from "../src/elements.js";
import { bytesText, numberText, percentText, shortText } from "../src/units.js";

/** A logarithmic axis between two positions on the page, with a margin around its values. */
class Axis {
  /** @param {number} from @param {number} to positions @param {number} low @param {number} high values above 0 @param {number} [margin] beyond both [octaves] */
  constructor(from, to, low, high, margin = 0.35) {
    this.from = from;
    this.to = to;
    this.low = Math.log2(low) - margin;
    this.high = Math.log2(high) + margin;
  }
  at(value) {
    return this.from + ((this.to - this.from) * (Math.log2(value) - this.low)) / (this.high - this.low);
  }
  /** Returns those of the values that lie on the axis; without any, 1, 2 and 5 of each decade. */
  ticks(values = Array.from({ length: 17 }, (_, i) => [1, 2, 5].map((step) => step * 10 ** (i - 8))).flat()) {
    return values.filter((value) => Math.log2(value) >= this.low && Math.log2(value) <= this.high);
  }
}

const place = (value) => value.toFixed(1);
const line = (kind, x1, y1, x2, y2) => draw("line", { class: kind, x1: place(x1), y1: place(y1), x2: place(x2), y2: place(y2) });
const label = (kind, x, y, words) => draw("text", { class: kind, x: place(x), y: place(y) }, words);
const circle = (kind, x, y, r, tip) => draw("circle", { class: kind, cx: place(x), cy: place(y), r }, tip && draw("title", {}, tip));
const plot = (kind, { width, height }, words, ...content) =>
  draw("svg", { class: `curve ${kind}`, viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": words }, content);

/** Draws the lines and numbers of both axes. */
function grid({ left, right, top, bottom, height }, x, y, textOfX, textOfY, caption, ticksOfX) {
  return [
    y.ticks().map((tick) => [line("grid", left, y.at(tick), right, y.at(tick)), label("tick end", left - 7, y.at(tick) + 4, textOfY(tick))]),
    x.ticks(ticksOfX).map((tick) => [line("grid", x.at(tick), top, x.at(tick), bottom), label("tick middle", x.at(tick), bottom + 15, textOfX(tick))]),
    label("tick middle", (left + right) / 2, height - 4, caption),
  ];
}

// Layouts that were tried

const CURVE = { width: 640, height: 300, left: 58, right: 626, top: 12, bottom: 262 };
const COSTS = { bits_per_texel: "bits per texel, tables included", decode_ops: "operations of a sample's decode", fetches: "texture fetches of a sample" };

/** Places names beside their dots, left or right and up or down, where none covers another or a dot. */
class Labels {
  /** @type {{ left: number, right: number, y: number }[]} y: of the baseline */
  taken = [];
  /** Keeps an area free. @param {number} left @param {number} right @param {number} y */
  mark(left, right, y) {
    this.taken.push({ left, right, y });
  }
  /** Returns the place of a name; nothing if there is none. @param {string} name @param {number} x @param {number} y of the dot */
  placeOf(name, x, y) {
    const width = 6.6 * name.length;
    for (const step of [0, -13, 13, -26, 26]) {
      for (const left of [x + 9, x - 9 - width]) {
        const at = y + 4 + step, right = left + width, isInside = left >= CURVE.left && right <= CURVE.right && at > CURVE.top + 8 && at < CURVE.bottom;
        if (!isInside || this.taken.some((box) => left < box.right + 2 && box.left < right + 2 && Math.abs(at - box.y) < 13)) continue;
        this.mark(left, right, at);
        return { left, at };
      }
    }
    return null;
  }
}

/** Returns the labels of points: of the first one first. Those without room have none. @param {{ name: string, x: number, y: number }[]} points
 * @param {{ x: number, y: number }[]} dots @returns {Map<string, { left: number, at: number }>} */
export function labelPlaces(points, dots, limitAt = NaN) {
  const labels = new Labels(), found = new Map();
  for (const { x, y } of dots) labels.mark(x - 6, x + 6, y + 4);
  if (Number.isFinite(limitAt)) labels.mark(CURVE.right - 30, CURVE.right, limitAt - 4);
  for (const { name, x, y } of points) {
    const place = labels.placeOf(name, x, y);
    if (place) found.set(name, place);
  }
  return found;
}

/** Draws error against a cost of each layout on logarithmic axes: a dot (diffuse) and a ring (specular) with a line between them, and a rule at the limit.
 * Layouts without figures above 0 are left out; with fewer than two there is no plot.
 * @param {any} asset @param {boolean} isVisible @param {keyof COSTS} cost */
export function errorCurve({ trial_candidates: candidates, layout, choice = layout, limit: limits }, isVisible, cost) {
  const [diffuse, specular] = isVisible ? ["visible_diffuse", "visible_specular"] : ["diffuse", "specular"];
  const all = candidates.map((each) => ({ name: each.layout, cost: each[cost], diffuse: each[diffuse], specular: each[specular] }));
  const points = all.filter((each) => [each.cost, each.diffuse, each.specular].every((value) => value > 1e-8 && value < 1e8));
  if (points.length < 2) return null;
  const costs = points.map((each) => each.cost), errors = points.flatMap(({ diffuse, specular }) => [diffuse, specular]);
  const limit = limits[isVisible ? "max_visible" : "value"], hasLimit = limit > 0.5 * Math.min(...errors) && limit < 2 * Math.max(...errors);
  if (hasLimit) errors.push(limit);
  const { left, right, top, bottom } = CURVE;
  const x = new Axis(left, right, Math.min(...costs), Math.max(...costs)), y = new Axis(bottom, top, Math.min(...errors), Math.max(...errors));
  // The chosen layout has its name first.
  const named = [...points].sort((a, b) => Number(b.name === choice) - Number(a.name === choice)).map((each) => ({ name: each.name, x: x.at(each.cost), y: y.at(each.diffuse) }));
  const labels = labelPlaces(named, points.flatMap((each) => [each.diffuse, each.specular].map((value) => ({ x: x.at(each.cost), y: y.at(value) }))), hasLimit ? y.at(limit) : NaN);
  return plot("", CURVE, `${isVisible ? "Visible error" : "Error"} of each layout against ${COSTS[cost]}: dots diffuse, rings specular`,
    grid(CURVE, x, y, shortText, (tick) => (isVisible ? shortText(tick) : `${shortText(100 * tick)} %`), COSTS[cost]),
    hasLimit && [line("limit", left, y.at(limit), right, y.at(limit)), label("tick end limit", right, y.at(limit) - 4, "limit")],
    points.map((each) => {
      const at = x.at(each.cost), diffuse = y.at(each.diffuse), specular = y.at(each.specular), words = labels.get(each.name);
      return draw("g", { class: each.name === choice ? "chosen" : "other" }, line("stem", at, diffuse, at, specular),
        circle("ring", at, specular, 4, `${each.name}, specular`), circle("dot", at, diffuse, 4.5, `${each.name}, diffuse`), words && label("name", words.left, words.at, each.name));
    }));
}

// Visible errors

const HISTOGRAM = { width: 480, height: 220, left: 70, right: 466, top: 12, bottom: 182 };
/** Octaves of VisibleFigures::histogram (verify/visible.h): the first is below 2^-3, the last from 2^9 up. */
const OCTAVES = 14, LOWEST = -3;

/** Draws the shares of samples in each octave of visible error: filled bars for diffuse, outlined ones for specular shading; and a rule at the limit. */
export function visibleHistogram(error, limit) {
  const { left, right, top, bottom, height } = HISTOGRAM, share = new Axis(bottom, top, 1e-6, 1, 0);
  const at = (octave) => left + ((right - left) * octave) / OCTAVES;
  const bars = (kind, inset) => {
    const counts = error[kind]?.visible?.histogram ?? [], sum = counts.reduce((all, count) => all + count, 0);
    return counts.map((count, octave) => count > 1e-6 * sum && draw("rect", {
      class: kind, x: place(at(octave) + inset), width: place(at(octave + 1) - at(octave) - 2 * inset),
      y: place(share.at(count / sum)), height: place(bottom - share.at(count / sum)),
    }, draw("title", {}, `${kind}: ${shortText((100 * count) / sum)} % of ${sum} samples`)));
  };
  const drawn = [...bars("diffuse", 2), ...bars("specular", 5)].filter((each) => each);
  if (drawn.length === 0) return null;
  const x = at(1 + Math.log2(limit) - LOWEST);
  return plot("histogram", HISTOGRAM, "Share of the samples in each octave of visible error: filled diffuse, outlined specular",
    [1, 1e-2, 1e-4, 1e-6].map((tick) => [line("grid", left, share.at(tick), right, share.at(tick)), label("tick end", left - 7, share.at(tick) + 4, `${shortText(100 * tick)} %`)]),
    [1, 4, 7, 10, 13].map((octave) => label("tick middle", at(octave), bottom + 15, shortText(2 ** (LOWEST + octave - 1)))),
    label("tick middle", (left + right) / 2, height - 4, "visible error (filled: diffuse, outlined: specular)"), drawn,
    limit > 0 && x > left && x < right && [line("limit", x, top, x, bottom), label("tick limit", x + 4, top + 10, "limit for 99 %")]);
}

// Allocations of memory

const FRONTIER = { width: 640, height: 280, left: 58, right: 626, top: 24, bottom: 242 };

/** Draws bytes against visible error of the best allocations. A budget between two of them buys the one on the left. */
export function frontierPlot(points, limit, wordsOf) {
  const { left, right, top, bottom } = FRONTIER, shown = (visible) => Math.max(visible ?? 0, 0.05);
  const bytes = [...points.map(({ bytes_gpu }) => bytes_gpu), ...(limit > 0 ? [limit] : [])], errors = points.map(({ visible }) => shown(visible));
  const x = new Axis(left, right, Math.min(...bytes), Math.max(...bytes), 0.15), y = new Axis(bottom, top, Math.min(...errors), Math.max(...errors));
  const at = ({ bytes_gpu, visible }) => [x.at(bytes_gpu), y.at(shown(visible))];
  const steps = points.flatMap((point, i) => (i > 0 ? [[at(point)[0], at(points[i - 1])[1]], at(point)] : [at(point)]));
  return plot("", FRONTIER, "Visible error of the whole shading against GPU memory: the best allocations, this cook's marked",
    // Powers of two, of which memory has round figures.
    grid(FRONTIER, x, y, bytesText, shortText, "GPU memory of the scene", Array.from({ length: 50 }, (_, i) => 2 ** i)), label("tick", 2, 11, "Visible error"),
    limit > 0 && [line("limit", x.at(limit), top, x.at(limit), bottom), label("tick end limit", x.at(limit) - 5, top + 8, "budget")],
    draw("polyline", { class: "trendline", points: steps.map((step) => step.map(place).join(",")).join(" ") }),
    points.map((point) => draw("g", { class: point.chosen ? "chosen" : "other" },
      circle("dot", ...at(point), point.chosen ? 6 : 4, `${bytesText(point.bytes_gpu)}, ${numberText(point.visible)}: ${wordsOf(point)}`))));
}

// Trends

const TREND = { width: 720, height: 130, left: 74, right: 708, top: 12, bottom: 108 };

/** Returns the states of the scenes after each step of a history. A step ends before the line of a scene that it has already: one report of many
 * scenes is one step. */
export function trendPoints(history) {
  /** The last line of each scene and target. */
  const latest = new Map(), points = [];
  let step = new Set(), at = "";
  const end = () => {
    const lines = [...latest.values()], most = (valueOf) => Math.max(0, ...lines.map(valueOf));
    points.push({
      at, bytes: lines.reduce((sum, { bytes_gpu }) => sum + bytes_gpu, 0), failed: lines.filter(({ passed }) => !passed).length,
      error: most((each) => Math.max(each.diffuse_rel_rms ?? 0, each.specular_rel_rms ?? 0)), visible: most((each) => each.visible_p99 ?? 0),
    });
  };
  for (const each of history) {
    const key = JSON.stringify([each.scene, each.target]);
    if (step.has(key)) {
      end();
      step = new Set();
    }
    step.add(key);
    latest.set(key, each);
    at = each.at;
  }
  if (history.length > 0) end();
  return points;
}

/** Draws one figure over the steps, from zero to its largest value. */
function trend(points, title, key, textOf) {
  const { left, right, top, bottom, height } = TREND, values = points.map((point) => point[key]), most = Math.max(...values);
  if (!(most > 0)) return null;
  const x = (i) => left + ((right - left) * i) / (points.length - 1), y = (value) => bottom - ((bottom - top) * value) / most;
  const first = textOf(values[0]), last = textOf(values[values.length - 1]), isFew = points.length <= 200;
  return make("div", {}, make("p", { class: "soft" }, `${title}: ${last}, at first ${first}`), make("div", { class: "scroll" },
    plot("trend", TREND, `${title}: ${first} at first, ${last} now`,
      [0, most].map((value) => [line("grid", left, y(value), right, y(value)), label("tick end", left - 8, y(value) + 4, textOf(value))]),
      label("tick", left, height - 5, points[0].at.slice(0, 10)), label("tick end", right, height - 5, points[points.length - 1].at.slice(0, 10)),
      draw("polyline", { class: "trendline", points: values.map((value, i) => `${place(x(i))},${place(y(value))}`).join(" ") }),
      isFew && points.map(({ at, failed }, i) => circle(failed > 0 ? "bad" : "dot", x(i), y(values[i]), 3, `${at}: ${textOf(values[i])}${failed > 0 ? `, ${failed} failed` : ""}`)))));
}

/** Draws memory and errors over the steps of a history. */
export function trends(points, isOneScene) {
  return [
    trend(points, isOneScene ? "GPU memory" : "GPU memory of all scenes", "bytes", bytesText),
    trend(points, isOneScene ? "Largest RMS error of an asset" : "Largest RMS error of an asset of any scene", "error", percentText),
    trend(points, "Largest visible error (99 %)", "visible", numberText),
  ];
}
