// Writes the primitives of a .glb in world space as JSON, read by gltf-transform and Google's Draco decoder: node mesh.mjs IN.glb OUT.json
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
  const identity = node.getWorldMatrix().every((value, i) => value === (i % 5 === 0 ? 1 : 0));
  for (const primitive of node.getMesh()?.listPrimitives() ?? []) {
    if (!identity) throw new Error(`${input}, ${node.getName()}: expected a node without a transform`);
    const values = (semantic) => Array.from(primitive.getAttribute(semantic)?.getArray() ?? []);
    parts.push({ positions: values("POSITION"), normals: values("NORMAL"), uvs: values("TEXCOORD_1"), clusters: values("_LIGHTCOOK_BASIS"),
      indices: Array.from(primitive.getIndices().getArray()) });
  }
}
writeFileSync(output, JSON.stringify(parts));
