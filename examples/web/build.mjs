// Bundles the pages: node build.mjs [FOLDER]; without one, into dist/ beside this file.
import { build } from "esbuild";
import { copyFileSync, mkdirSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url)), out = resolve(process.argv[2] ?? join(here, "dist"));
const engines = ["three", "babylon", "playcanvas"], loaders = resolve(here, "../../viewer/loaders");

/** Finds lightcook-loaders in this repository, and the packages that it imports here. A project that has installed it needs none of this. */
const fromRepository = {
  name: "from-repository",
  setup({ onResolve, resolve: find }) {
    onResolve({ filter: /^lightcook-loaders\// }, ({ path }) => ({ path: join(loaders, path.replace("lightcook-loaders/", "") + ".js") }));
    onResolve({ filter: /^[^./]/ }, ({ path, importer, kind, pluginData }) =>
      importer.startsWith(loaders) && !pluginData ? find(path, { kind, resolveDir: here, pluginData: { found: true } }) : undefined);
  },
};

await build({
  absWorkingDir: here,
  entryPoints: engines.map((engine) => `${engine}.js`),
  outdir: out,
  bundle: true,
  format: "esm",
  target: "es2022",
  minify: true,
  external: ["node:*"],  // of @gltf-transform/core, for Node
  legalComments: "linked",
  logLevel: "warning",
  plugins: [fromRepository],
});
for (const engine of engines) copyFileSync(join(here, "page.html"), join(out, `${engine}.html`));
mkdirSync(join(out, "draco"), { recursive: true });
for (const file of ["draco_wasm_wrapper.js", "draco_decoder.wasm"])
  copyFileSync(join(here, "node_modules", "three", "examples", "jsm", "libs", "draco", "gltf", file), join(out, "draco", file));
