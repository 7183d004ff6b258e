// Modules of a report's page that need no browser: figures as text, advice, trends, treemaps. Run by node --test.
import assert from "node:assert/strict";
import test from "node:test";
import { adviceOf, alternativesOf, bytesOutsideCharts } from "../../viewer/report/advice.js";
import { noteCaption, stageCaption, textureCaption } from "../../viewer/report/captions.js";
import { formats, kinds, lastStage, placeText, shadingsOf, sizeText } from "../../viewer/report/parts.js";
import { trendPoints } from "../../viewer/report/plots.js";
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
  assert.deepEqual(["light", "coverage", "no such texture"].map(textureCaption), ["one directional light", "texels inside charts, one bit each", ""]);
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
const map = (more = {}) => ({
  name: "hall", kind: "light-map", layout: "basis-4", width: 100, height: 100, bytes_gpu: 10240, passed: true, limit: { value: 0.02 },
  trial_candidates: [candidate("basis-3", 8192, 0.03), candidate("basis-4", 10240, 0.015), candidate("ratio", 40960, 0.005)], ...more,
});
const report = (assets, more = {}) => ({ assets, budget: { used_bytes: 40960 }, ...more });

test("advice names bytes and errors that were measured", () => {
  const hall = map({ trial_share: 0.25, textures: [{ role: "l0", bytes_gpu: 8192 }, { role: "tables", bytes_gpu: 0 }], notes: { covered_texels: 7500 } });
  const light = { name: "hall_dominant", kind: "dominant", bytes_gpu: 30720, passed: true };
  const parts = [{ asset: "hall", share: 0.6 }, { asset: "hall", share: 0.3 }, { asset: "hall_dominant", share: 0.1 }];
  const advice = adviceOf(report([hall, light], { whole: { parts } }));
  assert.equal(advice.length, 5);
  assert.equal(advice[0], "Dominant light 'hall_dominant' (30.0 KiB): 75.0 % of the memory, 10.0 % of the squared error of the whole shading. Look here first to save memory.");
  assert.match(advice[1], /^Light map 'hall' .*Look here first to reduce the error/);
  assert.match(advice[2], /layout basis-3 in place of basis-4 saves 2\.00 KiB; the error \(rel_rms, measured on 25\.0 % of the map\) goes from 1\.50 % to 3\.00 %, over the limit of 2\.00 %/);
  assert.match(advice[3], /layout ratio costs 30\.0 KiB more/);
  assert.match(advice[4], /texels outside charts take 25\.0 % of its textures: 2\.00 KiB\. Name its mesh in \[\[light_map\]\]: charts/);
  parts[0].share = null;
  assert.equal(adviceOf(report([hall, light], { whole: { parts } })).length, 4, "no share of the map is known");
  assert.deepEqual(adviceOf(report([])), []);
});

test("layouts are compared by the error that is limited", () => {
  const found = (limit) => adviceOf(report([map({ layout: "ratio", limit, trial_candidates: [candidate("basis-24", 1024, 0.01, { visible_specular: 7.5 }), candidate("ratio", 3072, 0.02, { visible_specular: 4.25 })] })]));
  assert.match(found({ value: 0.1, max_visible: 5 })[0], /layout basis-24 in place of ratio saves 2\.00 KiB; the error \(visible error, p99, measured\) goes from 4\.25 to 7\.50, over the limit of 5\.00\./);
  assert.match(found({ value: 0.1 })[0], /\(rel_rms, measured\) goes from 2\.00 % to 1\.00 %\./);
  const other = { layout: "bakery", bytes_saved: 2048, rel_rms: 0.02, rel_rms_then: 0.01, visible: 4, visible_then: 3 };
  assert.match(adviceOf(report([map({ trial_candidates: [], better_excluded: other })]))[0], /with layout bakery in the scene's layouts it saves 2\.00 KiB; the error .* from 4\.00 to 3\.00\./);
  const { cheaper, better } = alternativesOf(map({ trial_candidates: [candidate("basis-3", 8192, 0.01, { excluded: true }), ...map().trial_candidates] }));
  assert.deepEqual([cheaper.layout, cheaper.diffuse, better.layout], ["basis-3", 0.03, "ratio"], "not what the scene's list lacks");
});

test("charts are packed only where the scene may do it", () => {
  const hall = map({ trial_candidates: undefined, notes: { covered_texels: 5000 }, textures: [{ role: "l0", bytes_gpu: 4096 }], charts: {} });
  assert.match(adviceOf(report([hall]))[0], /textures: 2\.00 KiB\. charts = "pack" packs the light-map UVs/);
  assert.deepEqual(adviceOf(report([{ ...hall, ground_truth: {} }])), []);
  assert.deepEqual(adviceOf(report([{ ...hall, notes: { ...hall.notes, packing: "8 x 8 texels of 16 x 16" } }])), []);
  for (const role of ["tables", "coverage"]) assert.equal(bytesOutsideCharts(hall, { role, bytes_gpu: 4096 }), 0);
});

test("cubemaps of one size share a sentence", () => {
  const cubemap = (name, width, notes) => ({ name, kind: "cubemap", width, bytes_gpu: 8 * width * width, textures: [{ format: "bc6h-uf16" }], notes });
  const found = (...assets) => adviceOf(report(assets)).filter((sentence) => sentence.includes("largest level"));
  // A level of BC6H has a byte a texel: 6 * 128 * 128 bytes are 96 KiB.
  assert.match(found(cubemap("hall", 128))[0], /^Cubemap 'hall': size = 64 in place of 128 saves 96\.0 KiB, its largest level\./);
  const several = found(cubemap("a", 128), cubemap("b", 64), cubemap("c", 128), cubemap("d", 128));
  assert.match(several[0], /^3 cubemaps, 'a' and others: size = 64 in place of 128 saves 288 KiB, their largest levels\./);
  assert.match(several[1], /^Cubemap 'b': size = 32 in place of 64 saves 24\.0 KiB/);
  const unread = (levels, bytes) => ({ unread_levels: levels, unread_bytes: bytes });
  const named = found(cubemap("a", 128, unread(2, 122880)), cubemap("b", 128, unread(2, 122880)), cubemap("c", 128, unread(1, 98304)));
  assert.match(named[0], /^2 cubemaps, 'a' and others: no material is smooth enough to read their 2 largest levels\. size = "auto" leaves them out and saves 240 KiB/);
  assert.match(named[1], /^Cubemap 'c': no material is smooth enough to read its largest level\. size = "auto" leaves it out and saves 96\.0 KiB/);
});

test("a step of a history ends before a scene is there again", () => {
  const line = (scene, at, bytes, more = {}) => ({ scene, target: "bc", at, bytes_gpu: bytes, passed: true, diffuse_rel_rms: null, specular_rel_rms: 0.01, ...more });
  const points = trendPoints([line("hall", "1", 100), line("roof", "1", 50, { visible_p99: 4 }), line("hall", "2", 80, { passed: false, diffuse_rel_rms: 0.02 })]);
  assert.deepEqual(points, [{ at: "1", bytes: 150, failed: 0, error: 0.01, visible: 4 }, { at: "2", bytes: 130, failed: 1, error: 0.02, visible: 4 }]);
  assert.deepEqual(trendPoints([]), []);
});
