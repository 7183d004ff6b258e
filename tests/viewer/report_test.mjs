// Modules of a report's page that need no browser: figures as text, advice, trends, treemaps. Run by node --test.
import assert from "node:assert/strict";
import test from "node:test";
import { adviceOf, alternativesOf, bytesOutsideCharts } from "../../viewer/report/advice.js";
import { noteCaption, stageCaption, textureCaption } from "../../viewer/report/captions.js";
import { bytesRead } from "../../viewer/src/sizes.js";
import { errorText, gainText, opportunitiesOf } from "../../viewer/report/opportunities.js";
import { formats, kinds, lastStage, placeText, shadingsOf, sizeText } from "../../viewer/report/parts.js";
import { labelPlaces, trendPoints } from "../../viewer/report/plots.js";
import { errorColor, errorRanges, treemap } from "../../viewer/src/treemap.js";
import { bytesText, counted, countText, exactText, numberText, percentText, secondsText, shortText, visibleText } from "../../viewer/src/units.js";

Object.assign(kinds, { "light-map": "light map", dominant: "dominant light", cubemap: "cubemap" });
Object.assign(formats, { "bc6h-uf16": { side: 4, bytes: 16 } });

const table = (textOf, rows) => rows.forEach(([value, text]) => assert.equal(textOf(value), text));

test("figures are text for people", () => {
  table(bytesText, [[0, "0 B"], [1023, "1023 B"], [1024, "1.00 KiB"], [21811, "21.3 KiB"], [1023 * 1024, "1023 KiB"], [1024 * 1024 - 1, "1.00 MiB"], [3 * 2 ** 40, "3.00 TiB"], [2 ** 64, "16.0 EiB"]]);
  table(countText, [[0, "0"], [999, "999"], [1000, "1,000"], [1234567, "1,234,567"]]);
  table(secondsText, [[0, "0 s"], [0.00025, "0.250 ms"], [0.34, "340 ms"], [0.9999, "1.00 s"], [12.34, "12.3 s"], [59.97, "1 min 00 s"], [125, "2 min 05 s"], [3725, "1 h 02 min"], [null, "not finite"]]);
  table(percentText, [[0, "0 %"], [0.0123, "1.23 %"], [0.00412, "0.412 %"], [1e-6, "< 0.001 %"], [-1e-6, "> -0.001 %"], [0.09996, "10.0 %"], [3.4, "340 %"], [2e7, "2.00e+9 %"], [NaN, "not finite"], [null, "not finite"]]);
  table(numberText, [[8, "8.00"], [0.0123, "0.0123"], [0, "0"], [-0.5, "-0.500"], [0.00007534, "7.53e-5"], [null, "not finite"]]);
  table((value) => shortText(value, 4), [[207.16, "207.2"], [1, "1"], [0.0000156, "1.56e-5"], [null, "not finite"]]);
  table(visibleText, [[5.446, "5.45"], [null, "not finite"]]);
  table(exactText, [[0.1, "0.1"], [null, "not finite"]]);
  assert.deepEqual([counted(1, "asset"), counted(0, "asset")], ["1 asset", "0 assets"]);
});

test("names have captions, and others stand as they are", () => {
  assert.equal(stageCaption("l0"), "mean light");
  assert.equal(stageCaption("no such stage"), "no such stage");
  assert.deepEqual(["light", "coverage", "no such texture"].map(textureCaption), ["one directional light", "texels inside charts, one bit each; with detail, also where it lies", ""]);
  assert.equal(noteCaption("covered_texels"), "Texels inside charts");
  assert.equal(noteCaption("a_new_note"), "a new note");
  assert.equal(placeText({ texel: [12.5, 31], channel: "green", f0: 0.04, local: 3 }), "texel (12.5, 31), green, F0 0.04");
  assert.equal(placeText(undefined), "");
  assert.equal(sizeText({ width: 128, height: 128, kind: "cubemap" }), "128 × 128 × 6");
  assert.equal(sizeText({ width: 0, height: 0, kind: "mesh" }), "");
});

test("rows of light that was not measured are left out", () => {
  const zero = { rel_rms: 0, p99: 0, max_sampled: 0 }, some = { ...zero, max_sampled: 0.1 };
  const of = (diffuse, specular) => shadingsOf({ stages: [{ error: { diffuse, specular } }] });
  assert.deepEqual(of(zero, some), ["specular"]);
  assert.deepEqual(of(some, zero), ["diffuse"]);
  assert.equal(of(zero, zero).length, 2);
  assert.equal(of({ rel_rms: null }, zero).length, 1, "not finite is not zero");
  assert.equal(of(some, { rel_rms: 0, visible: { p99: 0 } }).length, 2, "an error of 0 that was measured");
  assert.equal(lastStage({ stages: [1, 2] }), 2);
});

test("areas of a treemap are as the bytes and fill the whole", () => {
  for (const values of [[6, 6, 4, 3, 2, 2, 1], [1], [1e9, 1, 1], [3, 0, 5]]) {
    const tiles = treemap(values.map((bytes) => ({ bytes })), 1.5), sum = values.reduce((a, b) => a + b);
    assert.equal(tiles.length, values.filter((bytes) => bytes > 0).length);
    for (const { item, x, y, width, height } of tiles) {
      assert.ok(Math.abs(width * height - item.bytes / sum) < 1e-9);
      assert.ok(x > -1e-6 && y > -1e-6 && x + width < 1 + 1e-6 && y + height < 1 + 1e-6);
    }
    tiles.forEach((a, i) => tiles.slice(0, i).forEach((b) => {
      const across = Math.min(a.x + a.width, b.x + b.width) - Math.max(a.x, b.x), down = Math.min(a.y + a.height, b.y + b.height) - Math.max(a.y, b.y);
      assert.ok(across < 1e-6 || down < 1e-6, "one tile covers part of another");
    }));
  }
  // Bruls, Huizing and van Wijk 2000, figure 4: 6 x 4. The first strip holds both sixes, 3 wide and 2 high each.
  const [first, second, third] = treemap([6, 6, 4, 3, 2, 2, 1].map((bytes) => ({ bytes })), 1.5);
  for (const [found, expected] of [[first.width * 6, 3], [first.height * 4, 2], [second.y * 4, 2], [third.x * 6, 3], [third.height * 4, 7 / 3]])
    assert.ok(Math.abs(found - expected) < 1e-9);
});

test("colours are ranges of visible errors", () => {
  assert.deepEqual([0.4, 1, 12.5].map(errorColor), ["var(--error-0)", "var(--error-1)", "var(--error-4)"]);
  assert.deepEqual(errorRanges().map(({ words }) => words), ["below 1", "1 to 2", "2 to 5", "5 to 10", "10 or more"]);
});

const candidate = (layout, bytes, error, more = {}) => ({ layout, bytes_gpu: bytes, diffuse: error, specular: error / 2, visible_diffuse: 1, visible_specular: 100 * error, fetches: 2, decode_ops: bytes / 100, ...more });
const stagesOf = (relRms, visible) => [{ error: { diffuse: { rel_rms: relRms, visible: { p99: visible } } } }];
const map = (more = {}) => ({
  name: "hall", kind: "light-map", layout: "basis-4", width: 100, height: 100, bytes_gpu: 10240, passed: true, limit: { value: 0.02 }, stages: stagesOf(0.015, 1.5),
  trial_candidates: [candidate("basis-3", 8192, 0.03), candidate("basis-4", 10240, 0.015), candidate("ratio", 40960, 0.005)], ...more,
});
const report = (assets, more = {}) => ({ assets, budget: { used_bytes: 40960, limit_bytes: null }, ...more });

/** Returns what the page says of the opportunities: gain, change of the error, words, lines, section. */
const said = (all) => opportunitiesOf(all).map((each) => [gainText(each, all.budget.used_bytes), errorText(each) + each.words, each.lines.join("; "), each.where]);

test("advice names the layouts that a list lacks, those of the largest asset first", () => {
  assert.deepEqual(adviceOf(report([])), []);
  const other = { layout: "bakery", bytes_saved: 2048, rel_rms: 0.02, rel_rms_then: 0.01, visible: 4, visible_then: 3 };
  const [first, ...rest] = adviceOf(report([map({ name: "roof" }), map({ better_excluded: other }), map({ name: "cellar", bytes_gpu: 20480, better_excluded: other })]));
  assert.match(first, /'cellar': with layout bakery in the scene's layouts it saves 2\.00 KiB; the RMS error .* from 4\.00 to 3\.00, as the trial/);
  assert.equal(rest.length, 1);
  assert.match(rest[0], /'hall': /);
});

test("a layout is an opportunity if it gains more than it costs", () => {
  // Bytes times error: 8 x 0.017 < 10 x 0.015, but 5 x 0.04 is not; 18 x 0.005 < 10 x 0.015, but 40 is more than twice the bytes.
  const tried = [candidate("tiny", 5120, 0.04), candidate("basis-3", 8192, 0.017), candidate("basis-4", 10240, 0.015), candidate("basis-8", 18432, 0.005), candidate("ratio", 40960, 0.0005)];
  const hall = map({ trial_candidates: tried, trial_share: 0.25 });
  assert.deepEqual(said(report([hall])), [
    ["66.7 % less RMS error, for 8.00 KiB more", "The RMS error falls from 1.50 % to 0.500 %: light map 'hall' as basis-8 in place of basis-4, measured on 25.0 % of the map.",
      'light_map_layout = "basis-8"', "[output]"],
    ["Save 2.00 KiB (5.00 % of the memory)", "The RMS error grows from 1.50 % to 1.70 %: light map 'hall' as basis-3 in place of basis-4, measured on 25.0 % of the map.",
      'light_map_layout = "basis-3"', "[output]"],
  ]);
  assert.equal(said(report([map()])).length, 0, "the smaller errs too much, the better is too large");
  // Over today's limit the line is the limit that allows it.
  assert.deepEqual(said(report([{ ...hall, limit: { value: 0.016 } }]))[1].slice(2), ["max_error = 0.017", "[output]"]);
  assert.match(said(report([{ ...hall, limit: { value: 0.016 } }]))[1][1], /; today's limit is 1\.60 %\.$/);
  const visible = said(report([{ ...hall, limit: { value: 2, max_visible: 1.6 } }, map({ name: "roof" })]));
  assert.deepEqual(visible.map((each) => each.slice(2)), [["max_visible = 1.7", "[[light_map]] hall"]], "errors below 1 count as 1");
  assert.deepEqual(said(report([hall, map({ name: "roof" })]))[0].slice(2), ['layouts = ["basis-8"]', "[[light_map]] hall"]);
  assert.equal(said(report([map({ trial_candidates: tried.map((each) => ({ ...each, excluded: each.layout !== "basis-4" })) })])).length, 0, "not what the scene's list lacks");
  // The cooked map errs 1.2 times as much as its trial: so will others, and the limit to write allows it.
  const excess = said(report([{ ...hall, limit: { value: 0.019 }, stages: stagesOf(0.018, 1.5) }]));
  assert.match(excess[0][1], /falls from 1\.80 % to 0\.600 %/);
  assert.equal(excess[1][2], "max_error = 0.0204");
  const { cheaper, better } = alternativesOf(map({ trial_candidates: [candidate("basis-3", 8192, 0.01, { excluded: true }), ...map().trial_candidates] }));
  assert.deepEqual([cheaper.layout, cheaper.diffuse, better.layout], ["basis-3", 0.03, "ratio"]);
});

test("an allocation is a budget or a limit to write", () => {
  const point = (bytes, visible, layout, chosen = false) => ({ bytes_gpu: bytes << 10, visible, chosen, layouts: [{ light_map: "hall", layout }] });
  const frontier = [point(100, 9.401, "basis-3"), point(200, 6, "basis-4", true), point(300, 2, "basis-8"), point(390, 0.2, "ratio"), point(900, 0, "raw")];
  const scene = (limit_bytes, max_visible) => report([map({ whole: { max_visible } })], { budget: { used_bytes: 200 << 10, limit_bytes, frontier } });
  // 390 KiB at an error of 0.2 are no better than at 1, which nobody sees either: still less than 300 at 2.
  const limited = said(scene(null, 6));
  assert.deepEqual(limited, [
    ["96.7 % less visible error of the whole shading, for 190 KiB more", "The visible error of the whole shading falls from 6.00 to 0.200: hall as ratio.", "max_whole_visible = 0.2", "[output]"],
    ["Save 100 KiB (50.0 % of the memory)", "The visible error of the whole shading grows from 6.00 to 9.40: hall as basis-3.", "max_whole_visible = 9.41", "[output]"],
  ]);
  assert.deepEqual(said(scene(205 << 10, undefined)).map(([, , line]) => line), ['budget = "390 KiB"', 'budget = "100 KiB"']);
  assert.deepEqual(said(scene(205 << 10, 6)).map(([, , line]) => line), ['budget = "390 KiB"', 'budget = "100 KiB"; max_whole_visible = 9.41'], "the limit holds beside the budget");
  const alone = report([map({ trial_candidates: [candidate("basis-3", 1024, 0.015), ...map().trial_candidates], whole: { max_visible: 6 } })], { budget: { used_bytes: 40960, limit_bytes: null, frontier: [frontier[1]] } });
  assert.deepEqual(said(alone), [], "a layout that no allocation has would break the limit");
});

test("a scene that fails gets nothing that makes it worse", () => {
  const tried = [candidate("basis-3", 8192, 0.017), candidate("basis-4", 10240, 0.015), candidate("basis-8", 18432, 0.005)], textures = [{ role: "l0", bytes_gpu: 8192 }];
  const hall = map({ trial_candidates: tried, textures, notes: { covered_texels: 5000 } });
  const lines = (passed, limit_bytes) => said(report([{ ...hall, passed }], { budget: { used_bytes: 40960, limit_bytes } })).map(([, , line]) => line);
  assert.deepEqual(lines(true, 40960), ['light_map_layout = "basis-8"', 'light_map_layout = "basis-3"', 'charts = "pack"']);
  assert.deepEqual(lines(false, null), ['light_map_layout = "basis-8"'], "neither an error that grows nor one that was not measured");
  assert.deepEqual(lines(true, 40959), ['light_map_layout = "basis-3"', 'charts = "pack"']);
  assert.deepEqual(lines(false, 40959), []);
});

test("charts are packed only where the scene may do it", () => {
  const hall = map({ trial_candidates: undefined, notes: { covered_texels: 5000 }, textures: [{ role: "l0", bytes_gpu: 4096 }, { role: "tables", bytes_gpu: 0 }], charts: {} });
  const [[gain, words, line]] = said(report([hall]));
  assert.deepEqual([gain, line], ["Save up to 2.00 KiB (5.00 % of the memory)", 'charts = "pack"']);
  assert.match(words, /^50\.0 % of the textures of light map 'hall' lie outside charts: packed anew, they need fewer texels\. Where/);
  assert.match(said(report([{ ...hall, charts: undefined }]))[0][1], /texels\. Name the mesh in \[\[light_map\]\] for that\. Where/);
  assert.deepEqual(said(report([{ ...hall, ground_truth: {} }])), []);
  assert.deepEqual(said(report([{ ...hall, notes: { ...hall.notes, packing: "8 x 8 texels of 16 x 16" } }])), []);
  for (const role of ["tables", "coverage", "detail_ldr"]) assert.equal(bytesOutsideCharts(hall, { role, bytes_gpu: 4096 }), 0);
});

test("a dominant light may be derived from its light map", () => {
  const light = { name: "hall_dominant", kind: "dominant", passed: true, width: 100, bytes_gpu: 8192, textures: [{ role: "direction" }], notes: { fit: "explained" } };
  const lines = (...assets) => said(report(assets)).map(([gain, , line, where]) => [gain, line, where]);
  assert.deepEqual(lines(map(), light), [["Save 8.00 KiB (20.0 % of the memory)", 'dominant_layout = "derived"', "[[light_map]] hall"]]);
  assert.deepEqual(lines(light), []);
  assert.deepEqual(lines(map(), { ...light, notes: { fit: "halo3" } }), [], "the shader derives no other fit");
});

test("cubemaps of one size share an opportunity, and what was measured comes first", () => {
  const cubemap = (name, width, notes) => ({ name, kind: "cubemap", passed: true, width, bytes_gpu: 8 * width * width, textures: [{ format: "bc6h-uf16" }], notes });
  const found = (...assets) => said(report(assets));
  // A level of BC6H has a byte a texel: 6 * 128 * 128 bytes are 96 KiB.
  const [one] = found(cubemap("hall", 128));
  assert.match(one[0], /^Save 96\.0 KiB/);
  assert.match(one[1], /^cubemap 'hall' without its largest level, size 128\. What that does to the error was not measured/);
  assert.deepEqual(one.slice(2), ["size = 64", "[[probe]] hall"]);
  const several = found(cubemap("a", 128), cubemap("b", 64), cubemap("c", 128), cubemap("d", 128));
  assert.match(several[0][1], /^3 cubemaps, 'a' and others without their largest levels, size 128/);
  assert.deepEqual(several.map((each) => each.slice(2)), [["size = 64", "each [[probe]]"], ["size = 32", "[[probe]] b"]]);
  const unread = (levels, bytes) => ({ unread_levels: levels, unread_bytes: bytes });
  const named = found(cubemap("a", 128, unread(2, 1228)), cubemap("b", 128, unread(2, 1228)), cubemap("c", 128, unread(1, 983)), cubemap("d", 64));
  assert.match(named[0][1], /^2 cubemaps, 'a' and others: no material is smooth enough to read their 2 largest levels\./);
  assert.match(named[1][1], /^cubemap 'c': no material is smooth enough to read its largest level\./);
  assert.deepEqual(named.map(([gain, , line]) => [gain.slice(0, 13), line]), [["Save 2.40 KiB", 'size = "auto"'], ["Save 983 B (2", 'size = "auto"'], ["Save 24.0 KiB", "size = 32"]]);
});

test("a file that light map and dominant light come from is read once", () => {
  const of = (kind, name, bytes_in, bake) => ({ kind, name, bytes_in, light: bake && { bake } });
  const both = [of("light-map", "hall", 100, "a.exr"), of("dominant", "hall_dominant", 100, "a.exr"), of("light-map", "roof", 30, "b.exr")];
  assert.equal(bytesRead([...both, of("mesh", "mesh", 7, "a.exr"), of("cubemap", "probe", 2), of("lut", "specular", 0)]), 139);
  assert.equal(bytesRead([of("dominant", "hall_dominant", 100, "a.exr")]), 100, "of a cook of that alone");
  assert.equal(bytesRead([of("light-map", "hall", 100), of("dominant", "hall_dominant", 100)]), 100);
});

test("names in a plot cover neither each other nor dots", () => {
  const points = Array.from({ length: 20 }, (_, i) => ({ name: `layout-${i}`, x: 100 + 6 * (i % 7), y: 100 + 5 * i }));
  const places = labelPlaces(points, points, 150), boxes = [...places].map(([name, { left, at }]) => ({ left, right: left + 6.6 * name.length, at }));
  assert.ok(places.has("layout-0"), "the first one has its name");
  assert.ok(boxes.length > 5 && boxes.length < points.length, "those without room have none");
  boxes.forEach((a, i) => {
    for (const b of boxes.slice(0, i)) assert.ok(a.left >= b.right || b.left >= a.right || Math.abs(a.at - b.at) >= 13, "two names");
    for (const { x, y } of points) assert.ok(a.left >= x + 4.5 || a.right <= x - 4.5 || Math.abs(a.at - 4 - y) >= 9, "a dot");
  });
});

test("a step of a history ends before a scene is there again", () => {
  const line = (scene, at, bytes, more = {}) => ({ scene, target: "bc", at, bytes_gpu: bytes, passed: true, diffuse_rel_rms: null, specular_rel_rms: 0.01, ...more });
  const points = trendPoints([line("hall", "1", 100), line("roof", "1", 50, { visible_p99: 4 }), line("hall", "2", 80, { passed: false, diffuse_rel_rms: 0.02 })]);
  assert.deepEqual(points, [{ at: "1", bytes: 150, failed: 0, error: 0.01, visible: 4 }, { at: "2", bytes: 130, failed: 1, error: 0.02, visible: 4 }]);
  assert.deepEqual(trendPoints([]), []);
});
