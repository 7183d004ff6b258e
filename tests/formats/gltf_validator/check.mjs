// Prints the issues that Khronos' validator finds in each glTF or GLB file named on the command line, as one JSON array.
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { validateBytes } from 'gltf-validator';

async function issuesOf(file) {
  const report = await validateBytes(new Uint8Array(readFileSync(file)), {
    uri: file,
    maxIssues: 100,
    externalResourceFunction: async (uri) => new Uint8Array(readFileSync(join(dirname(file), decodeURIComponent(uri)))),
  });
  const { numErrors, numWarnings, messages } = report.issues;
  return { errors: numErrors, warnings: numWarnings, messages, extensions: report.info.extensionsUsed ?? [] };
}

console.log(JSON.stringify(await Promise.all(process.argv.slice(2).map(issuesOf))));
