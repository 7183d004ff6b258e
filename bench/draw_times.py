#!/usr/bin/env python3
"""Draws a scene in OpenGL under every light-map layout and filter, and prints the time of a frame beside the cost of the decode.

    draw_times.py LIGHTCOOK LIGHTCOOK_OPENGL [--scene FILE] [--target float|bc] [--layouts NAME,...] [--frames N] [--rounds N]
        [--pictures FOLDER] [-- OPTION_OF_LIGHTCOOK_OPENGL...]

`./dev bench draw` calls it. A time is relative to that of `ratio` under the hardware's filter: in each round both are drawn one after the
other, the shortest of their frames are divided, and the table has the median of the rounds, so that a machine with other work gives the
same figures. Filter "one texel" is "decoded" with one of the four texels at random.

Fetches, operations and bits (target bc, without tables) are those of docs/reference/light-map-layouts.md. Tables are the factors of learned
layouts that the shader of a sample reads beside them.

The GPU is the one that EGL gives; LIBGL_ALWAYS_SOFTWARE=1 takes Mesa's software rasterizer. That one decodes blocks of BC6H and BC7 again
for every fetch, so the default is textures without blocks: what is left is fetches and arithmetic.
"""
import argparse
import itertools
import json
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENE = ROOT / "examples" / "cornell" / "scene.toml"
REFUSED = 2  # exit code of a layout that does not have the filter
WEIGHTS, MIX = 16, 4 * 9 * 3  # operations beside four decodes (LightMapLayoutInfo::operations)


class Layout(NamedTuple):
    """A row of the generated reference."""

    name: str
    layers: int
    bits: int  # of a texel, with the coverage if the usual filter is "decoded"
    operations: list[int]  # under each filter that the layout has, the hardware's first
    table: int  # factors of a learned layout


class Drawing(NamedTuple):
    """A layout, cooked for a filter, and how it is drawn."""

    layout: Layout
    filter: str
    folder: pathlib.Path
    bits: int
    fetches: int
    operations: int
    tables: int

    def options(self):
        return ["--one-texel"] if self.filter == "one texel" else []


def layouts():
    lines = (ROOT / "docs" / "reference" / "light-map-layouts.md").read_text().splitlines()
    head = next(line for line in lines if line.startswith("| layout |")).split(" | ")
    at = {word: next(i for i, name in enumerate(head) if name.startswith(word)) for word in ("textures", "`bc`", "operations", "tables")}
    for row in (line.split(" | ") for line in lines if line.startswith("| `")):
        layers = sum(int(count) for count in re.findall(r"\((\d+)\)", row[at["textures"]]))
        yield Layout(row[0].strip("| `"), layers, int(row[at["`bc`"]]), [int(count) for count in row[at["operations"]].split("/")], int(row[at["tables"]]) // 8)


def cook(options, folder, layout, *more):
    """Returns the filter of the cooked light map; None if the layout does not have the one that is asked for."""
    done = subprocess.run([options.lightcook, "cook", options.scene, "-o", folder, "--layout", layout.name, "--target", options.target,
                           "--max-error", "0.99", "--max-visible", "9999", "--max-converter-error", "0.99", "--quiet", *more],
                          capture_output=True, text=True)
    if done.returncode == REFUSED and more:
        return None
    if done.returncode:
        raise SystemExit(f"draw_times.py: {layout.name}: exit code {done.returncode}: {done.stderr}")
    assets = json.loads((folder / "cooked.json").read_text())["assets"]
    return next(asset for asset in assets if asset["kind"] == "light-map")["filter"]


def drawings(options, layout, folder):
    """The layout under each filter that it has."""
    usual = cook(options, folder / "usual", layout)
    cooked = {usual: folder / "usual"}
    other = "hardware" if usual == "decoded" else "decoded"
    if cook(options, folder / "other", layout, "--filter", other):
        cooked[other] = folder / "other"
    decode = layout.operations[0] if "hardware" in cooked else (layout.operations[0] - WEIGHTS - MIX) // 4
    coverage = usual == "decoded"  # a bit a texel
    if "hardware" in cooked:
        yield Drawing(layout, "hardware", cooked["hardware"], layout.bits - coverage, layout.layers, decode, layout.table)
    if "decoded" in cooked:
        bits = layout.bits - coverage + 1
        yield Drawing(layout, "decoded", cooked["decoded"], bits, 4 * (layout.layers + 1), layout.operations[-1], layout.table)
        yield Drawing(layout, "one texel", cooked["decoded"], bits, layout.layers + 4, decode + WEIGHTS, layout.table)


def drawn(options, drawing, picture):
    """Milliseconds of the shortest frame."""
    done = subprocess.run([options.opengl, drawing.folder, picture, "--frames", str(options.frames), *drawing.options(), *options.drawing],
                          capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"draw_times.py: {drawing.layout.name}, {drawing.filter}: {done.stderr}")
    return float(re.search(r": ([0-9.]+) ms", done.stdout)[1])


def main():
    own = list(itertools.takewhile(lambda argument: argument != "--", sys.argv[1:]))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], epilog="Options after -- are those of lightcook_opengl.")
    parser.add_argument("lightcook")
    parser.add_argument("opengl")
    parser.add_argument("--scene", type=pathlib.Path, default=SCENE)
    parser.add_argument("--target", choices=("bc", "float"), default="float")
    parser.add_argument("--layouts", type=lambda names: names.split(","), help="default: all but rnm, which the example does not draw")
    parser.add_argument("--frames", type=int, default=10, help="of a picture in each round")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--pictures", type=pathlib.Path, help="keep what was drawn")
    options = parser.parse_args(own)
    if options.frames < 2:
        parser.error("--frames: at least 2, of which the shortest counts")
    options.drawing = sys.argv[2 + len(own) :]
    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
    table = {layout.name: layout for layout in layouts()}
    names = options.layouts or [name for name in table if name != "rnm"]
    print("| layout | filter | bits | fetches | operations | tables | time of `ratio`, hardware |\n|---|---|---:|---:|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        reference = next(drawings(options, table["ratio"], root / "reference"))
        milliseconds = []
        for name in names:
            for drawing in drawings(options, table[name], root / name):
                picture = (options.pictures or root) / f"{name}_{drawing.filter.replace(' ', '_')}.png"
                shares = []
                for _ in range(options.rounds):
                    milliseconds.append(drawn(options, reference, root / "reference.png"))
                    shares.append(drawn(options, drawing, picture) / milliseconds[-1])
                print(f"| `{name}` | {drawing.filter} | {drawing.bits} | {drawing.fetches} | {drawing.operations} | {drawing.tables} | "
                      f"{statistics.median(shares):.2f} |", flush=True)
        print(f"`ratio`, hardware: {statistics.median(milliseconds):.1f} ms a frame, {min(milliseconds):.1f} to {max(milliseconds):.1f}")


if __name__ == "__main__":
    main()
