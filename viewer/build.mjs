// Bundles the page: node build.mjs [FOLDER]; without one, into dist/ beside this file.
import { build } from "esbuild";
import { copyFileSync, mkdirSync, readFileSync, rmSync } from "node:fs";
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
await build({
  absWorkingDir: here,
  entryPoints: { page: "src/main.js", start: "src/start.js", style: "src/style.css" },
  outdir: join(out, "assets"),
  bundle: true,
  format: "esm",
  target: "es2022",
  minify: true,
  legalComments: "linked",
  logLevel: "warning",
});
copyFileSync(join(here, "src", "index.html"), join(out, "index.html"));
for (const file of ["draco_wasm_wrapper.js", "draco_decoder.wasm"])
  copyFileSync(join(here, "node_modules", "three", "examples", "jsm", "libs", "draco", "gltf", file), join(out, "assets", "draco", file));
