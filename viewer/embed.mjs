// Writes a C++ source that holds what build.mjs wrote: viewerBundle() and reportTemplate() of pipeline/report/bundle.h.
//   node embed.mjs FOLDER OUT.cpp
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const [folder, out] = process.argv.slice(2);
if (!folder || !out) {
  console.error("usage: node embed.mjs FOLDER OUT.cpp");
  process.exit(2);
}

/** Bytes as the text of a C++ string literal: octal escapes of three digits, which no following digit can extend. */
function literal(bytes) {
  let text = "";
  for (const byte of bytes) {
    if (byte === 0x22 || byte === 0x5c) text += "\\" + String.fromCharCode(byte);
    else if (byte >= 0x20 && byte < 0x7f && byte !== 0x3f) text += String.fromCharCode(byte);
    else text += "\\" + byte.toString(8).padStart(3, "0");
  }
  return `"${text}"`;
}

/** Literals of at most this many bytes, which the compiler joins. */
const PIECE = 16384;

function filesOf(parent, prefix = "") {
  return readdirSync(parent, { withFileTypes: true })
    .sort((a, b) => (a.name < b.name ? -1 : 1))
    .flatMap((entry) =>
      entry.isDirectory() ? filesOf(join(parent, entry.name), `${prefix}${entry.name}/`) : [`${prefix}${entry.name}`]);
}

/** A file as lines of C++: its pieces, and its size in bytes after a comma. */
function content(name) {
  const bytes = readFileSync(join(folder, name)), pieces = [];
  for (let at = 0; at < bytes.length; at += PIECE) pieces.push(literal(bytes.subarray(at, at + PIECE)));
  return [...(pieces.length ? pieces : ['""']), `, ${bytes.length}`];
}

const REPORT = "report.html", files = filesOf(folder);
for (const needed of ["index.html", REPORT])
  if (!files.includes(needed)) {
    console.error(`${folder}: found no ${needed}, expected what build.mjs writes`);
    process.exit(1);
  }
const lines = [
  "// Written by viewer/embed.mjs.",
  '#include "pipeline/report/bundle.h"',
  "",
  "namespace lightcook::pipeline {",
  "",
  "std::span<const BundledFile> viewerBundle() {",
  "    static constexpr BundledFile kFiles[] = {",
];
for (const name of files.filter((each) => each !== REPORT)) lines.push(`        {${literal(Buffer.from(name))}, {`, ...content(name), "}},");
lines.push("    };", "    return kFiles;", "}", "", "std::string_view reportTemplate() {", "    return {", ...content(REPORT), "    };", "}", "", "}  // namespace lightcook::pipeline", "");
writeFileSync(out, lines.join("\n"));
