// Words for the names that report.json has: stages, textures, notes, and the figures' terms.

/** @type {Record<string, string>} */
const STAGES = {
  "total": "whole asset",
  "repacked": "whole asset, against the repacked bake",
  "half": "16-bit floats",
  "exit": "exit radiance",
  "stage 1": "first texture",
  "stage 2": "second texture, of what the first one left",
  "l0": "mean light",
  "l1": "linear band",
  "rnm": "light of three directions",
  "ratio": "directions, as ratios to the mean",
  "light": "one directional light",
  "rest": "the other light, by ratios to its mean",
  "code": "directions, by learned bases",
  "residual 1": "first refinement",
  "residual 2": "second refinement",
  "residual 3": "third refinement",
  "residual 4": "fourth refinement",
  "residual 5": "fifth refinement",
  "magnified": "filtering between texels, at samples",
  "divide": "division and encoding, at all texels",
  "filter": "filtering between stored entries, at samples",
  "quantize": "quantization of stored entries",
};

/** Textures of a light map whose names are no stages. @type {Record<string, string>} */
const TEXTURES = {
  "direction": "direction of that light",
  "coverage": "texels inside charts, one bit each; with detail, also where it lies",
  "detail_hdr": "detail: mean light, and one directional light",
  "detail_ldr": "detail: direction of that light, and ratios of the other light",
};

/** Keys of `notes` and `measures`: pipeline/assets/note_keys.h. @type {Record<string, string>} */
const NOTES = {
  covered_texels: "Texels inside charts",
  packing: "Charts packed anew",
  unread_texels: "Texels inside charts that no triangle reads: left out of the packed map",
  unread_levels: "Largest levels that no material is smooth enough to read",
  unread_bytes: "Memory of these levels [bytes]",
  whole_visible: "Visible error of the whole shading, as the trial measured it",
  beyond_positive_bounds: "Texels whose coefficients no positive light could give",
  repaired_not_finite: "Texels set to zero because a coefficient was not finite",
  repaired_negative_dc: "Channels set to zero because their mean was negative",
  repaired_bands: "Bands scaled down to what light of their mean can have",
  repaired_fireflies: "Stray bright texels that took the mean of their neighbours",
  repaired_texels: "Texels repaired because they were negative or not finite",
  negative_after_gamut: "Values negative in the working colour space",
  clamped_high: "Values clamped to the format's largest",
  clamped_light: "Values of light above 65504, which became 65504",
  clamped_negative: "Negative values clamped to zero, all an unsigned format holds",
  division_clamped: "Values whose division passed the largest float,",
  division_lost: "Values lost under the texture's smallest step,",
  formats_tried: "Errors of the format",
  window_lambda: "Strength of the window against ringing (lambda)",
  fit: "Method of the fit",
  refined: "Texels whose direction was searched",
  skipped: "Texels that kept the closed form: black, without a direction, or within the tolerance",
  solved_with_neighbours: "Texels fitted together with their neighbours",
  light_map_uv_bits: "Bits of a light-map UV",
  normal_bits: "Bits of a normal",
  bound_of_rel_rms: "Upper bound of the RMS error that these bits make",
  zones: "Zones of equal solid angle that the source was read in",
  asymmetric_energy: "Share of the source's energy that is not symmetric around its axis",
  gradient_uncertainty: "Uncertainty of the average around the axis, of the largest value",
  code_error: "Largest error at a texel centre [codes]",
  step_codes: "Largest step between neighbours beyond the exact one [codes]",
  step_contrast: "The same, relative to the light there",
  band_codes: "Largest mean error of 8 neighbours, which shows as a band [codes]",
  direction_error_degrees_mean: "Mean error of a light's direction [degrees]",
  direction_error_degrees_max: "Largest error of a light's direction [degrees]",
  unexplained_energy_stored: "Share of the light that one direction does not explain, as stored",
  unexplained_energy_reference: "Share of the light that one direction does not explain, in the bake",
  shaded_every_texels: "Distance of the samples between texels; texels are shaded all",
};

/** What the figures mean, for the end of the page. */
export const TERMS = {
  "error": "of shaded exit radiance on a white surface, against the float bake, at texels inside charts and between them",
  "RMS error": "rel_rms in report.json: the RMS of the error over the RMS of the reference, over texels, directions and channels",
  "visible error": "Delta E ITP, in just noticeable differences: 1 is at the threshold of a trained eye, 10 is plain to see",
  "99 %": "of the samples are below this figure: p99 in report.json. The largest is the largest that was seen",
  "local error": "|error| / (|reference| + 0.02 key), at each sample",
  "key": "the log-average, over the map, of the luminance of the exit radiance at each texel's own normal",
  "bound": "of visible errors: no place, normal, view, material or allowed sampler can exceed it; computed, not sampled",
};

/** Returns the words of a stage; a name without a row as it is. @param {string} name */
export const stageCaption = (name) => STAGES[name] ?? name;
/** Returns the words of a texture of a light map; empty for a name without a row. @param {string} role */
export const textureCaption = (role) => TEXTURES[role] ?? STAGES[role] ?? "";
/** Returns the words of a note; a key without a row with spaces for underscores. @param {string} key */
export const noteCaption = (key) => NOTES[key] ?? key.replaceAll("_", " ");
