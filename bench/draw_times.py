#!/usr/bin/env python3
"""Draws the example scene in OpenGL under every light-map layout and prints the time of a frame beside the cost of the decode.

    draw_times.py LIGHTCOOK LIGHTCOOK_OPENGL [--target float|bc] [--frames N] [--size WIDTH HEIGHT]

`./dev bench draw` calls it. The GPU is the one that EGL gives; LIBGL_ALWAYS_SOFTWARE=1 takes Mesa's software rasterizer. That one decodes
blocks of BC6H and BC7 again for every fetch, so the default is textures without blocks: what is left is fetches and arithmetic.
"""
import argparse
import pathlib
import re
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENE = ROOT / "examples" / "cornell" / "scene.toml"


def layouts():
    """Layouts, texture fetches and operations of their decode, as the generated reference has them."""
    lines = (ROOT / "docs" / "reference" / "light-map-layouts.md").read_text().splitlines()
    head = next(line for line in lines if line.startswith("| layout |")).split(" | ")
    fetches, operations = (next(i for i, name in enumerate(head) if name.startswith(word)) for word in ("fetches", "operations"))
    rows = [line.split(" | ") for line in lines if line.startswith("| `")]
    return [(row[0].strip("| `"), row[fetches], row[operations]) for row in rows]


def drawn(lightcook, opengl, layout, options):
    """Milliseconds of a frame."""
    with tempfile.TemporaryDirectory() as folder:
        cooked = pathlib.Path(folder) / "cooked"
        subprocess.run([lightcook, "cook", SCENE, "-o", cooked, "--layout", layout, "--target", options.target, "--max-error", "0.9",
                        "--max-visible", "9999", "--max-converter-error", "0.9", "--quiet"], check=True)
        size = [str(side) for side in options.size]
        done = subprocess.run([opengl, cooked, pathlib.Path(folder) / "out.png", "--size", *size, "--frames", str(options.frames)], check=True,
                              capture_output=True, text=True)
        return float(re.search(r": ([0-9.]+) ms", done.stdout)[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("lightcook")
    parser.add_argument("opengl")
    parser.add_argument("--target", choices=("bc", "float"), default="float")
    parser.add_argument("--frames", type=int, default=30)
    parser.add_argument("--size", type=int, nargs=2, default=(960, 720))
    options = parser.parse_args()
    print("| layout | fetches | operations | ms a frame |\n|---|---:|---:|---:|")
    for layout, fetches, operations in layouts():
        print(f"| `{layout}` | {fetches} | {operations} | {drawn(options.lightcook, options.opengl, layout, options):.1f} |", flush=True)


if __name__ == "__main__":
    main()
