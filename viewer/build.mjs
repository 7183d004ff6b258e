// Bundles the pages: node build.mjs [FOLDER]; without one, into dist/ beside this file. FOLDER/report.html is the page of a report without its data.
import { build } from "esbuild";
import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url)), out = resolve(process.argv[2] ?? join(here, "dist"));
const { engines } = JSON.parse(readFileSync(join(here, "package.json"), "utf8"));
const least = Number(/\d+/.exec(engines.node)?.[0]), found = Number(process.versions.node.split(".")[0]);
if (found < least) {
  console.error(`build.mjs: found Node ${process.versions.node}, expected ${least} or later`);
  process.exit(1);
}

rmSync(out, { recursive: true, force: true });
mkdirSync(join(out, "assets", "draco"), { recursive: true });
/** @type {import("esbuild").BuildOptions} */
const options = { absWorkingDir: here, bundle: true, target: "es2022", minify: true, logLevel: "warning" };
await build({
  ...options,
  entryPoints: { page: "src/main.js", start: "src/start.js", style: "src/style.css" },
  outdir: join(out, "assets"),
  format: "esm",
  legalComments: "linked",
});
const report = await build({ ...options, entryPoints: ["report/main.js", "report/style.css"], outdir: out, format: "iife", charset: "utf8", write: false });
const parts = Object.fromEntries(report.outputFiles.map(({ path, text }) => [path.endsWith(".css") ? "style" : "script", text.trim()]));
writeFileSync(join(out, "report.html"), readFileSync(join(here, "report", "page.html"), "utf8").replace(/<!--(style|script)-->/g, (_, name) => parts[name]));
copyFileSync(join(here, "src", "index.html"), join(out, "index.html"));
for (const file of ["draco_wasm_wrapper.js", "draco_decoder.wasm"])
  copyFileSync(join(here, "node_modules", "three", "examples", "jsm", "libs", "draco", "gltf", file), join(out, "assets", "draco", file));
