#include "pipeline/report/html.h"

namespace lightcook::pipeline {

// Nothing is shown by colour alone: verdicts are words, and the table under the bar names the segments.
// The hues of kinds differ in lightness too, so that they can be told apart by colour-blind readers and on grey printers.
std::string_view reportStyle() {
    return R"css(
:root {
  --page: #f5f5f2; --card: #ffffff; --ink: #1d1f21; --soft: #62666b; --line: #e4e4df; --track: #ecece7; --link: #1f5fa8;
  --edge: #00000030;
  --good: #0b6b3c; --good-back: #e3f3ea; --bad: #b3261e; --bad-back: #fbe9e7; --meter: #8a9299;
  --kind-light-map: #2a78d6; --kind-dominant: #eda100; --kind-cubemap: #1baf7a; --kind-lut: #4a3aa7; --kind-rsrm: #e87ba4;
  --kind-mesh: #008300; --kind-other: #8a9299;
  --error-0: #b9c4cd; --error-1: #f2d95c; --error-2: #f0a030; --error-3: #e0512f; --error-4: #8e2a86;
}
@media screen and (prefers-color-scheme: dark) {
  :root {
    --page: #15171a; --card: #1e2125; --ink: #e6e7e8; --soft: #9ba1a8; --line: #30343a; --track: #2b2f34; --link: #86b7f0;
    --edge: #000000c0;
    --good: #6fd19c; --good-back: #17372a; --bad: #ff9d94; --bad-back: #45211f; --meter: #7d858d;
    --kind-light-map: #3987e5; --kind-dominant: #c98500; --kind-cubemap: #199e70; --kind-lut: #9085e9; --kind-rsrm: #d55181;
    --kind-mesh: #3c9a3c; --kind-other: #7d858d;
    --error-0: #56616b; --error-1: #c9b03c; --error-2: #d98a1e; --error-3: #e0603f; --error-4: #b24aa8;
  }
}
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; scroll-behavior: smooth; }
body { margin: 0; background: var(--page); color: var(--ink);
  font: 14px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "Helvetica Neue", Arial, sans-serif; }
main { max-width: 1200px; margin: 0 auto; padding: 32px 24px 48px; }
a { color: var(--link); text-decoration: none; }
a:hover { text-decoration: underline; }
h1 { margin: 0; font-size: 30px; line-height: 1.2; font-weight: 650; letter-spacing: -0.01em; overflow-wrap: anywhere; }
h2 { margin: 0 0 12px; font-size: 17px; line-height: 1.3; font-weight: 650; overflow-wrap: anywhere; }
p { margin: 0; }
.soft { color: var(--soft); }
.eyebrow { color: var(--soft); font-size: 12px; letter-spacing: 0.06em; text-transform: uppercase; margin-bottom: 2px; }
.title { display: flex; flex-wrap: wrap; align-items: center; gap: 6px 14px; margin-bottom: 14px; }
.title h2 { margin: 0; font-size: 20px; }
header { margin-bottom: 24px; }

.verdict { display: inline-block; padding: 1px 9px 2px; border-radius: 999px; font-size: 13px; font-weight: 600; white-space: nowrap; }
.verdict.passed { color: var(--good); background: var(--good-back); }
.verdict.failed { color: var(--bad); background: var(--bad-back); }
h1 + .verdict { font-size: 16px; padding: 3px 14px 4px; }

.card { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 20px 22px 22px; margin: 0 0 20px; }
.failures { border-color: var(--bad); }
.failures h2 { color: var(--bad); }
.failures ul { margin: 0; padding-left: 20px; }
.facts { display: flex; flex-wrap: wrap; gap: 12px 40px; margin: 0; }
.facts dt { color: var(--soft); font-size: 12px; }
.facts dd { margin: 0; font-size: 19px; line-height: 1.35; font-variant-numeric: tabular-nums; }
.facts.small { gap: 8px 28px; margin-bottom: 18px; }
.facts.small dd { font-size: 14px; }
.whole-facts { margin-bottom: 14px; }
.card > .scroll + .scroll, .notes .scroll + .scroll { margin-top: 18px; }
.pair { display: flex; flex-wrap: wrap; gap: 20px 48px; align-items: flex-start; }
.pair > * { flex: 1 1 300px; min-width: 0; max-width: 640px; }

.bar { position: relative; display: flex; gap: 2px; height: 26px; border-radius: 6px; overflow: hidden; background: var(--track); }
.bar i { display: block; flex: 0 1 auto; min-width: 2px; }
.bar b { position: absolute; top: 0; bottom: 0; right: 0; border-left: 3px solid var(--bad);
  background: repeating-linear-gradient(135deg, var(--bad) 0 2px, transparent 2px 8px); }
.lead { margin: -4px 0 14px; font-size: 15.5px; max-width: 90ch; }
.advice { margin: 0; padding-left: 20px; }
.advice li { margin: 0 0 7px; max-width: 100ch; }
.views figure { flex: 1 1 160px; max-width: 300px; }
.views + .tools, .notes > .tools { margin-top: 10px; }
.sentence { margin: 6px 0 18px; font-variant-numeric: tabular-nums; }
.over { color: var(--bad); font-weight: 600; }
.bar.over { box-shadow: none; }
.swatch { display: inline-block; width: 10px; height: 10px; border-radius: 3px; margin-right: 7px; }

/* Shadows at the sides beyond which a table goes on. */
.scroll { overflow-x: auto; background: linear-gradient(90deg, var(--card) 40%, transparent) 0 0 / 32px 100% no-repeat local,
  linear-gradient(270deg, var(--card) 40%, transparent) 100% 0 / 32px 100% no-repeat local,
  linear-gradient(90deg, var(--edge), transparent) 0 0 / 10px 100% no-repeat,
  linear-gradient(270deg, var(--edge), transparent) 100% 0 / 10px 100% no-repeat; }
table { width: 100%; border-collapse: collapse; }
th, td { padding: 6px 10px; text-align: left; vertical-align: top; font-weight: 400; }
th:first-child, td:first-child { padding-left: 0; }
th:last-child, td:last-child { padding-right: 0; }
thead th { color: var(--soft); font-size: 12px; vertical-align: bottom; border-bottom: 1px solid var(--line); padding-top: 0; }
tbody tr + tr > *, tbody + tbody > tr:first-child > * { border-top: 1px solid var(--line); }
.num { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
thead .num { white-space: normal; }
tbody th { font-weight: 550; }
.assets tbody tr + tr:last-child > * { border-top: none; padding-top: 1px; padding-bottom: 9px; }
.assets tbody tr:first-child > * { padding-top: 9px; padding-bottom: 9px; }
.assets tbody tr + tr > td { padding-left: 10px; padding-right: 10px; }
.assets tbody th { min-width: 200px; overflow-wrap: anywhere; }
.assets + p, .scroll + p { margin-top: 12px; font-size: 12.5px; }
.sub { display: block; color: var(--soft); font-size: 12.5px; font-weight: 400; }
.sub .swatch { width: 8px; height: 8px; }
.shading { color: var(--soft); }
.meter { display: block; height: 3px; width: 52px; margin: 2px 0 0 auto; border-radius: 2px; background: var(--track); overflow: hidden; }
.meter i { display: block; height: 100%; background: var(--meter); margin-right: auto; }
.over .meter i { background: var(--bad); }
@media (min-width: 861px) {
  .stages { table-layout: fixed; }
  .stages thead tr:first-child > :first-child { width: 12%; }
}
.stages .group { text-align: left; border-bottom: none; padding: 0 0 3px 30px; color: var(--ink); font-weight: 600; }
.stages thead tr + tr > * { padding-left: 10px; padding-right: 10px; }
.stages .first { padding-left: 30px; }
.stages .last > * { font-weight: 600; }
.total > * { font-weight: 600; }
.columns { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 440px), 1fr)); gap: 12px 32px; }
.columns > * { min-width: 0; }
.scroll + .pair { margin-top: 22px; }
.file { color: var(--soft); overflow-wrap: anywhere; }

.pictures { display: flex; flex-wrap: wrap; gap: 16px; margin-bottom: 20px; }
figure { flex: 1 1 200px; min-width: 0; margin: 0; }
figure img, .missing { display: block; width: 100%; border-radius: 6px; background: #000; }
figure img { height: auto; max-height: 400px; object-fit: contain; }
.pixels { image-rendering: pixelated; }
.missing { display: grid; place-items: center; min-height: 120px; padding: 12px; color: var(--soft); background: var(--track);
  overflow-wrap: anywhere; text-align: center; }
figcaption { margin-top: 6px; color: var(--soft); font-size: 12.5px; }
figcaption b { color: var(--ink); font-weight: 600; }
.scale { display: flex; align-items: center; gap: 8px; white-space: nowrap; }
.heat { flex: 0 1 130px; height: 9px; border-radius: 2px; border: 1px solid var(--line);
  background: linear-gradient(90deg, #000, #460f6e, #be284b, #f06e1e, #facd3c, #fff); }

.curve { display: block; width: 100%; max-width: 760px; margin: 10px 0 14px; font-size: 11px; }
.curve text { fill: var(--ink); }
.curve .tick { fill: var(--soft); font-variant-numeric: tabular-nums; }
.curve .end { text-anchor: end; }
.curve .middle { text-anchor: middle; }
.curve .grid { stroke: var(--line); }
.curve line.limit { stroke: var(--bad); stroke-dasharray: 5 4; }
.curve text.limit { fill: var(--bad); }
.curve .stem { stroke: var(--meter); }
.curve .dot { fill: var(--meter); }
.curve .ring { fill: var(--card); stroke: var(--meter); stroke-width: 1.5; }
.curve .chosen .dot { fill: var(--link); }
.curve .chosen .ring, .curve .chosen .stem { stroke: var(--link); }
.curve .chosen .name { fill: var(--link); font-weight: 650; }

.curve .diffuse { fill: var(--meter); }
.curve .specular { fill: none; stroke: var(--link); stroke-width: 1.5; }
.histogram { max-width: 560px; }
.curve + .soft, .curve-frame + .soft { margin-bottom: 16px; }
details { margin: 0 0 20px; }
summary { cursor: pointer; color: var(--link); }
details .pictures { margin: 10px 0 0; }
details figure { max-width: 384px; }
.worst-places { margin-top: 10px; }
.worst-places figure { flex-basis: 260px; max-width: 420px; }

.treemap { display: block; width: 100%; margin: 0 0 18px; font-size: 12px; }
.treemap.narrow { display: none; }
.treemap rect { stroke: var(--card); stroke-width: 1.5; }
.treemap .tile { fill-opacity: 0.42; }
.treemap .part { fill-opacity: 0.5; }
.treemap .fill { fill-opacity: 0.5; stroke: none; }
.treemap text { fill: var(--ink); pointer-events: none; }
.treemap .bytes { fill: var(--ink); opacity: 0.8; font-variant-numeric: tabular-nums; }
.error-classes { display: flex; flex-wrap: wrap; gap: 2px 16px; margin: 2px 0 8px; }
.error-classes span, .charts th { white-space: nowrap; }
.trend { max-width: none; font-size: 13px; }
.trends > div { flex: 1 1 420px; }
.trendline { fill: none; stroke: var(--link); stroke-width: 1.5; }
.trend .dot { fill: var(--link); }
.trend .bad { fill: var(--bad); }
.meter.long { width: 90px; }
.title.small { margin: 14px 0 2px; }
h3 { margin: 0 0 6px; font-size: 14px; font-weight: 650; }
.grown { margin-top: 12px; }
.grown figure { flex: 1 1 260px; max-width: 384px; }
.scroll + h3 { margin-top: 16px; }
.sort { font: inherit; color: inherit; text-align: inherit; background: none; border: 0; padding: 0; cursor: pointer; }
.sort:hover, .sort:focus-visible { text-decoration: underline; }
th[aria-sort="descending"] .sort::after { content: " \2193"; }
th[aria-sort="ascending"] .sort::after { content: " \2191"; }
.search input { font: inherit; color: inherit; width: min(100%, 320px); padding: 5px 10px; margin: 0 12px 10px 0;
  border: 1px solid var(--line); border-radius: 7px; background: var(--page); }
.tools { display: flex; flex-wrap: wrap; align-items: center; gap: 6px 18px; margin: 0 0 10px; color: var(--soft); font-size: 12.5px; }
.tools input { vertical-align: middle; width: 150px; }
.tools output { display: inline-block; min-width: 62px; font-variant-numeric: tabular-nums; }
.tools button, .zoom button { font: inherit; color: var(--ink); padding: 2px 12px; border: 1px solid var(--line); border-radius: 7px;
  background: var(--page); cursor: pointer; }
.exposed { filter: url(#exposure); }
.filters { position: absolute; }
figure img[tabindex] { cursor: zoom-in; }
.zoom { max-width: 96vw; max-height: 94vh; padding: 12px; border: 1px solid var(--line); border-radius: 10px; background: var(--card);
  color: var(--ink); }
.zoom button { margin: 0 8px 8px 0; }
.zoom .frame { overflow: auto; max-height: 82vh; }
.zoom img { display: block; image-rendering: pixelated; max-width: none; }

.card > .notes, .card > .notes + .scroll, .card > .notes + .pair, .columns + .scroll { margin-top: 20px; }
.notes > .columns, .notes > p { margin-top: 10px; }
.notes h3 { margin: 0; padding-bottom: 6px; color: var(--soft); font-size: 12px; font-weight: 400; border-bottom: 1px solid var(--line); }
.notes dl { margin: 0; }
.notes dl div { display: flex; justify-content: space-between; gap: 24px; padding: 5px 0; border-top: 1px solid var(--line); }
.notes dl div:first-child { border-top: none; }
.notes dt { color: var(--soft); }
.notes dd { margin: 0; flex: 0 0 auto; max-width: 60%; text-align: right; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }
footer { padding: 4px 22px 0; color: var(--soft); font-size: 12.5px; }
footer h2 { font-size: 14px; margin-bottom: 8px; color: var(--ink); }
footer dl { display: grid; grid-template-columns: max-content 1fr; gap: 3px 18px; margin: 0; }
footer dt { color: var(--ink); }
footer dd { margin: 0; max-width: 76ch; }

@media (max-width: 860px) {
  main { padding: 22px 14px 36px; }
  .card { padding: 16px 16px 18px; }
  .facts { gap: 10px 28px; }
  th, td { padding-left: 7px; padding-right: 7px; }
  table { font-size: 13px; }
  .assets, .stages { font-size: 12.5px; }
  .assets tbody th { min-width: 110px; }
  .assets th, .assets td { padding-left: 5px; padding-right: 5px; }
  .assets .sub, .assets .verdict { font-size: 12px; }
  .assets .verdict { padding: 1px 7px 2px; }
  .assets th:first-child { padding-left: 0; }
  .assets th:last-child { padding-right: 0; }
  .assets tbody tr:first-child td:last-child { padding-right: 0; }
  .stages .first { padding-left: 18px; }
  .stages .group { padding-left: 18px; }
  .stages thead tr + tr > :not(.first) { padding-left: 7px; padding-right: 7px; }
  .assets tbody tr + tr > td { padding-left: 5px; padding-right: 5px; }
}
@media screen {
  .card { content-visibility: auto; contain-intrinsic-size: auto 900px; }
}
@media screen and (max-width: 560px) {
  .treemap.wide { display: none; }
  .treemap.narrow { display: block; }
  .curve { min-width: 520px; }
  .curve-frame { overflow-x: auto; }
  .worst td:nth-child(3) { min-width: 210px; }
}
@media (max-width: 560px) {
  footer dl { grid-template-columns: 1fr; }
  footer dd { margin-bottom: 6px; }
}
@media print {
  .tools, .search, dialog, .filters { display: none; }
  .scenes { font-size: 9.5px; }
  :root { --page: #ffffff; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  body, table, .stages, .assets { font-size: 10.5px; }
  .facts dd { font-size: 14px; }
  .facts.small dd { font-size: 11px; }
  thead th, .notes h3, .facts dt, .sub, .verdict, figcaption, footer, .assets .sub, .assets .verdict, .scroll + p { font-size: 9.5px; }
  main { max-width: none; padding: 0; }
  .card { border-radius: 0; padding: 10px 0; border-width: 1px 0 0; }
  .scroll { overflow: visible; background: none; }
  th, td { padding: 3px 5px; }
  thead { display: table-header-group; }
  tr, figure, .bar, .facts, .title { break-inside: avoid; }
  h2, .title { break-after: avoid; }
  a { color: inherit; }
}
)css";
}

}  // namespace lightcook::pipeline
