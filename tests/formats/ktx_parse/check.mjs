// Prints what ktx-parse finds in each KTX2 file named on the command line, as one JSON array. tests/formats/ktx_parse_test.cpp compares it.
import { readFileSync } from 'node:fs';
import { read } from 'ktx-parse';

/// FNV-1a, 32 bits: enough to tell one test pattern from another.
function hash(bytes) {
  let value = 0x811c9dc5;
  for (const byte of bytes) value = Math.imul(value ^ byte, 0x01000193) >>> 0;
  return value;
}

function describe(file) {
  const container = read(readFileSync(file));
  const { vkFormat, typeSize, pixelWidth, pixelHeight, pixelDepth, layerCount, faceCount, levelCount, supercompressionScheme } = container;
  return {
    vkFormat, typeSize, pixelWidth, pixelHeight, pixelDepth, layerCount, faceCount, levelCount, supercompressionScheme,
    levels: container.levels.map((level) => ({
      bytes: level.levelData.byteLength,
      uncompressedBytes: level.uncompressedByteLength,
      hash: hash(level.levelData),
    })),
    descriptors: container.dataFormatDescriptor.map((descriptor) => ({
      model: descriptor.colorModel,
      primaries: descriptor.colorPrimaries,
      transfer: descriptor.transferFunction,
      flags: descriptor.flags,
      block: descriptor.texelBlockDimension,
      bytesPlane: descriptor.bytesPlane,
      samples: descriptor.samples.map((sample) => [
        sample.bitOffset, sample.bitLength, sample.channelType, sample.sampleLower >>> 0, sample.sampleUpper >>> 0,
      ]),
    })),
    // ktx-parse makes text of the keys that it knows and leaves the others as bytes; ours are text that ends in NUL.
    keys: Object.fromEntries(Object.entries(container.keyValue).map(([key, value]) =>
      [key, typeof value === 'string' ? value : new TextDecoder().decode(value).replace(/\0$/, '')])),
  };
}

console.log(JSON.stringify(process.argv.slice(2).map(describe)));
