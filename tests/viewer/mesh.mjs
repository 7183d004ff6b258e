// Writes the primitives of a .glb and the world matrices of their nodes as JSON, read by gltf-transform and Google's Draco decoder: node mesh.mjs IN.glb OUT.json
import { createRequire } from "node:module";
import { resolve } from "node:path";
import { writeFileSync } from "node:fs";

const require = createRequire(resolve(import.meta.dirname ?? ".", "../../examples/web/package.json"));
const { NodeIO } = require("@gltf-transform/core"), { KHRDracoMeshCompression } = require("@gltf-transform/extensions");
const [input, output] = process.argv.slice(2);
const io = new NodeIO().registerExtensions([KHRDracoMeshCompression])
  .registerDependencies({ "draco3d.decoder": await require("draco3dgltf").createDecoderModule() });
const parts = [];
for (const node of (await io.read(input)).getRoot().listNodes()) {
  for (const primitive of node.getMesh()?.listPrimitives() ?? []) {
    const values = (semantic) => Array.from(primitive.getAttribute(semantic)?.getArray() ?? []);
    parts.push({ node: node.getName(), matrix: node.getWorldMatrix(), positions: values("POSITION"), normals: values("NORMAL"), uvs: values("TEXCOORD_1"), clusters: values("_LIGHTCOOK_BASIS"),
      indices: Array.from(primitive.getIndices().getArray()) });
  }
}
writeFileSync(output, JSON.stringify(parts));
