// The section of an asset: everything that the report holds about it.
import { make } from "../src/elements.js";
import { bytesText, countText, numberText, percentText } from "../src/units.js";
import { alternativesOf } from "./advice.js";
import { noteCaption, stageCaption, textureCaption } from "./captions.js";
import {
  bytes, cell, DASH, fact, figure, kindCaption, lastStage, layoutText, limitedError, limitedVisible, number, part, placeText, row, seconds, shadingsOf, shadingTable, sizeText, soft, sub,
  swatch, table, titled, vectorText, verdict, visible,
} from "./parts.js";
import { comparison, picture, viewsOf } from "./pictures.js";
import { errorCurve, visibleHistogram } from "./plots.js";
import { chartPart } from "./tiles.js";

const colorText = (color) => vectorText(color, numberText);

/** Makes the pictures of what lies around the texels with the largest visible errors. */
function worstPlaces({ preview }) {
  const worst = preview?.worst ?? [], views = worst.filter(({ view }) => view), texelOf = ({ texel }) => texel.join(", ");
  return worst.length > 0 && [
    views.length > 0 && part("The worst places in the scene: the mesh from in front of each, as a white surface under the bake and under the cooked map",
      viewsOf(views.map(({ view }) => view), (i) => `texel ${texelOf(views[i])}`)),
    part("Worst places, at the texels' own normals: bake, cooked and visible error, 24 texels across", make("div", { class: "pictures worst-places" }, worst.map((each) =>
      picture(each.file, `bake, cooked and visible error around texel ${texelOf(each)}`, [make("b", {}, `Texel ${texelOf(each)}`),
        `: visible error ${numberText(each.visible)}; bake ${colorText(each.reference)}, cooked ${colorText(each.found)}`])))),
  ];
}

/** Makes the caption and the name of a stage. "On the surface" is added where the report has figures of texel centres, too. */
function stageName({ name, at_texels }) {
  const caption = stageCaption(name);
  return [caption + (at_texels ? ", on the surface" : ""), caption !== name && sub(name)];
}

function stageTable(asset) {
  const shadings = shadingsOf(asset), last = lastStage(asset);
  return shadingTable("", "After the stage", shadings, ["RMS error", "local error, 99 %", "largest"], asset.stages.map((stage) => row(stage === last ? "last" : "", stageName(stage),
    ...shadings.flatMap((shading) => {
      const figures = stage.error[shading];
      return [stage === last ? limitedError(figures, asset) : figure(figures, "rel_rms"), figure(figures, "p99"), figure(figures, "max_sampled")];
    }))));
}

/** Makes the visible errors of each stage, and their histogram. */
function visibleTable(asset) {
  const shadings = shadingsOf(asset), last = lastStage(asset), keys = ["rms", "p50", "p99", "p999", "max", "bound"];
  const stages = asset.stages.filter(({ error }) => error.diffuse?.visible || error.specular?.visible);
  return stages.length > 0 && [
    shadingTable("visible", "Visible error", shadings, ["RMS", "median", "99 %", "99.9 %", "largest", "bound"], stages.map((stage) => row(stage === last ? "last" : "", stageName(stage),
      ...shadings.flatMap((shading) => keys.map((key) => {
        const figures = stage.error[shading];
        return stage === last && (key === "p99" || key === "bound") ? limitedVisible(figures, key, asset) : visible(figures?.visible, key);
      }))))),
    make("div", { class: "curve-frame" }, visibleHistogram(last.error, asset.limit.max_visible)),
    soft("In just noticeable differences (Delta E ITP): 1 is at the threshold of a trained eye, 10 is plain to see."),
  ];
}

/** Says the errors of a light map and its dominant light together. */
function wholeError({ whole }) {
  if (!whole) return null;
  const { visible: errors, rel_rms, places, max_visible, max_error } = whole, text = (key) => numberText(errors[key]);
  return make("p", {}, `Together with its dominant light, at ${countText(places)} places of the surface: visible error below ${text("p99")} at 99 % of the samples${
    max_visible === undefined ? "" : ` (limit ${numberText(max_visible)})`}, below ${text("p50")} at half of them, below ${text("p999")} at 99.9 %, largest ${
    text("max")}; RMS error ${percentText(rel_rms)}${
    max_error === undefined ? "" : ` (limit ${percentText(max_error)})`}.`);
}

/** Makes the mip levels of a light map from level 1 on, with the mix of each with the larger one, and why there are no more. */
function mipTable(asset) {
  const { mips = [], mip_blends: blends = [], mips_end: end } = asset;
  if (!end && mips.length === 0) return null;
  const shadings = shadingsOf(asset), rows = mips.flatMap((mip, i) => (blends[i] ? [blends[i], mip] : [mip]));
  return part("Mip levels",
    rows.length > 0 && shadingTable("", "Mip level", shadings, ["RMS error", "visible error, 99 %", "99.9 %", "bound"], rows.map(({ name, error }) => [name, ...shadings.flatMap((shading) => {
      const figures = error[shading];
      return [limitedError(figures, asset), limitedVisible(figures, "p99", asset), visible(figures?.visible, "p999"), limitedVisible(figures, "bound", asset)];
    })])),
    soft(`${mips.length + 1} level${mips.length === 0 ? "" : "s"} with level 0; no further one: ${end ?? ""}.`));
}

// Seams

const seamName = (seam) => `${seam.shading}, at ${vectorText(seam.position)}`;

function seamTables(seams, views) {
  const shadings = "bake_specular" in seams ? ["diffuse", "specular"] : ["diffuse"], sides = (pair, text) => pair.map((side) => vectorText(side, text)).join(" | ");
  const steps = (kind, name, figuresOf) => row(kind, name, ...shadings.flatMap((shading) => [visible(figuresOf(shading), "p99"), visible(figuresOf(shading), "max")]));
  const stages = seams.stages ?? [], last = stages[stages.length - 1];
  const columns = ["#Added", "#Bake", "#Cooked", "Texels", "Light of the bake", "Cooked light"];
  const worst = (title, key) => seams[key]?.length > 0 && table("worst seams", [title, ...columns], seams[key].map((seam) => [
    seamName(seam), visible(seam, "added"), visible(seam, "bake_step"), visible(seam, "cooked_step"),
    sides(seam.texels), sides(seam.reference), sides(seam.found)]));
  return [
    shadingTable("seams", "Steps between both sides", shadings, ["99 %", "largest"], [steps("", "bake", (shading) => seams[`bake_${shading}`]), ...stages.flatMap((stage) =>
      ["cooked", "added"].map((kind) => steps(stage === last && kind === "added" ? "last" : "", `${kind}, ${stageCaption(stage.name)}`, (shading) => stage[shading]?.[kind])))]),
    worst("Largest steps that cooking adds", "worst"),
    viewsOf((views ?? []).slice(0, seams.worst?.length ?? 0), (i) => `the seam ${seamName(seams.worst[i])}`),
    worst("Largest steps of the bake itself", "worst_of_bake"),
  ];
}

/** Makes the section of the seams; nothing without. */
function seamPart({ seams, preview }) {
  const count = (key) => countText(seams[key]);
  return seams && part("Seams, in just noticeable differences", seams.note ? soft(`Not measured: ${seams.note}.`) : [
    soft(`${count("places")} places of ${count("edges")} edges that two charts share; ${count("joined_edges")} edges are inside charts, ${
      count("hard_edges")} are hard, ${count("open_edges")} belong to one triangle alone.`),
    seamTables(seams, preview?.seams)]);
}

// Places, candidates, notes

/** Makes the places of the worst samples of the last stage. Where charts were packed, samples lie in the bake as it was. */
function worstTable(asset) {
  const { error } = lastStage(asset), isPacked = asset.stages.some(({ name }) => name === "repacked");
  const rows = ["diffuse", "specular"].flatMap((shading) => {
    const figures = error[shading] ?? {}, { sampled_at: sampled, visible: errors } = figures, largest = errors?.max_at;
    const few = asset.charts?.few_texels?.find((each) => each.shading === shading);
    return [
      ...(sampled ? [[`${shading}, largest sample`, figure(figures, "max_sampled"), placeText(sampled), number(sampled.reference), number(sampled.found)]] : []),
      ...(largest ? [[`${shading}, largest visible error`, visible(errors, "max"), [placeText(largest), few && sub(few.advice)],
        colorText(largest.reference), colorText(largest.found)]] : []),
    ];
  });
  return rows.length > 0 && table("worst", ["Worst", "#Error", isPacked ? "Where, in the bake" : "Where", "#Light", "#Cooked"], rows);
}

/** Makes the layouts that were tried: error against memory and run time, and a table, smallest first. */
function candidates(asset) {
  const all = asset.trial_candidates ?? [], { chosen, cheaper, better } = alternativesOf(asset);
  if (all.length === 0) return null;
  const roleOf = (each) => (each === chosen ? " (chosen)" : each === cheaper ? " (next cheaper)" : each === better ? " (next better)" : each.excluded ? " (not in layouts)" : "");
  const curve = (title, isVisible, cost) => {
    const plot = errorCurve(asset, isVisible, cost);
    return plot && make("div", {}, soft(title), make("div", { class: "curve-frame" }, plot));
  };
  const columns = ["Candidate", "#GPU", "#Bits per texel", "#Fetches", "#Operations",
    "#Diffuse RMS error", "#Specular RMS error", "#Diffuse visible error", "#Specular visible error"];
  return part("Layouts tried",
    make("div", { class: "columns" },
      curve("RMS error against memory", false, "bits_per_texel"), curve("Visible error, 99 %, against memory", true, "bits_per_texel"),
      curve("RMS error against run time: operations", false, "decode_ops"), curve("RMS error against run time: fetches", false, "fetches")),
    soft("Point at a dot for its name; layouts without room for theirs have it there alone, and in the table."),
    table("candidates", columns, all.map((each) => row(each === chosen ? "total" : "", layoutText(each.layout, true) + roleOf(each),
      bytes(each.bytes_gpu), numberText(each.bits_per_texel), countText(each.fetches), countText(each.decode_ops),
      figure(each, "diffuse"), figure(each, "specular"), visible(each, "visible_diffuse"), visible(each, "visible_specular")))));
}

/** Makes the comparison with traced light, divided among truncation, fit and quantization. */
function groundTruth({ ground_truth: truth }) {
  const keys = ["truncation", "fit", "quantization", "total", "with_rest", "two_lights"];
  const rowOf = (name, errors) => [name, ...keys.map((key) => (key in errors ? figure(errors, key) : DASH))];
  const rows = [["Lambert", "lambert"], ["Area specular of the nine coefficients", "area_specular"], ["Specular of the dominant light", "specular"]].flatMap(([name, key]) => {
    const errors = truth?.[key];
    return errors ? [rowOf(name, errors), ...(errors.by_m ?? []).map((each) => rowOf(`m ${numberText(each.m)}`, each))] : [];
  });
  return rows.length > 0 && part(`Ground truth: ${countText(truth.values ?? 0)} values`,
    table("truth", ["RMS error against traced light", "#Nine coefficients", "#One light", "#Cooking", "#Total", "#With area specular of the rest", "#Two lights"], rows),
    truth.fit_is_largest && make("p", {}, `One light cannot explain this scene: its fit is the largest of the three parts. A second light would take it from ${
      percentText(truth.specular.fit)} to ${percentText(truth.specular.two_lights)}.`));
}

function valueOf(value) {
  if (Number.isInteger(value)) return countText(value);
  return typeof value === "number" || value === null ? number(value) : String(value);
}

/** Returns captions and values of an object; those of inner objects as "outer inner". Zeros are left out. */
const entries = (object, prefix = "") => Object.entries(object ?? {}).flatMap(([key, value]) =>
  value !== null && typeof value === "object" ? entries(value, `${prefix}${noteCaption(key)} `) : value === 0 ? [] : [[prefix + noteCaption(key), valueOf(value)]]);

function notes({ notes: facts, mesh_error: shift, measures }) {
  const moved = shift ? [["Largest shift of a position [scene units]", valueOf(shift.position)], ["Largest turn of a normal [rad]", valueOf(shift.normal_radians)],
    ["Largest shift of a light-map UV [of the map's side]", valueOf(shift.light_map_uv)]] : [];
  const rows = [...entries(facts), ...moved, ...entries(measures)];
  return rows.length > 0 && part("Notes", make("dl", {}, rows.map((each) => fact(...each))));
}

const textureName = (kind, role) => {
  const caption = kind === "light-map" ? textureCaption(role) : "";
  return caption ? [role, sub(caption)] : role;
};
const textureTable = ({ kind, textures }) => textures?.length > 0 && table("textures", ["Texture", "Format", "#GPU", "File"], textures.map((texture) => [
  textureName(kind, texture.role), texture.format, bytes(texture.bytes_gpu), cell("file", texture.file)]));

function facts(asset) {
  const size = sizeText(asset), { worst_block: block } = asset;
  return make("dl", { class: "facts small" },
    fact("Kind", swatch(asset.kind), kindCaption(asset.kind)), fact("Layout", layoutText(asset.choice ?? asset.layout)), size && fact("Size", size), asset.bytes_in > 0 && fact("Read", bytes(asset.bytes_in)),
    fact("GPU", bytes(asset.bytes_gpu)), fact("Disk", bytes(asset.bytes_disk)), asset.bits_per_texel > 0 && fact("Bits/texel", number(asset.bits_per_texel)),
    fact("Cooked in", seconds(asset.seconds)), fact("Verified in", seconds(asset.verify_seconds ?? null)), typeof asset.key === "number" && fact("Key", number(asset.key)),
    block && fact("Worst block", titled(`${numberText(block.visible)} at ${vectorText(block.block)}`, String(block.visible))));
}

/** Makes the section; that of an asset which passed is folded. @param {string} id for links */
export function assetSection(asset, id) {
  const lists = [textureTable(asset), notes(asset)], size = [kindCaption(asset.kind), layoutText(asset.choice ?? asset.layout), bytesText(asset.bytes_gpu)].filter((each) => each).join(", ");
  return make("section", { class: "card asset", id }, make("details", { open: !asset.passed },
    make("summary", {}, make("h2", {}, asset.name), verdict(asset.passed), make("span", { class: "soft" }, size)), facts(asset), comparison(asset), worstPlaces(asset),
    stageTable(asset), visibleTable(asset), wholeError(asset), mipTable(asset), seamPart(asset), chartPart(asset), worstTable(asset),
    groundTruth(asset), candidates(asset), make("div", { class: "pair" }, lists)));
}
