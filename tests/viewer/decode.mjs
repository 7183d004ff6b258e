// Decodes level 0, layer 0 of KTX2 files with the loaders' decoders for browsers without the format, to RGBA floats (little-endian):
//   node decode.mjs IN.ktx2 OUT.bin [IN OUT]...
import { readFileSync, writeFileSync } from "node:fs";
import { decodeImage } from "../../viewer/loaders/core/pixel_formats.js";
import { makeTexture, readKtx2 } from "../../viewer/loaders/three.js";

for (let i = 2; i + 1 < process.argv.length; i += 2) {
  const [input, output] = process.argv.slice(i, i + 2);
  const ktx = await readKtx2(readFileSync(input), input);
  const texels = decodeImage(ktx.format, ktx.levels[0], ktx.width, ktx.height);
  if (!texels) throw new Error(`${input}: no decoder of ${ktx.format.name}`);
  makeTexture(ktx, null, input);  // without WebGL: every format that needs an extension is decoded
  writeFileSync(output, texels);
}
