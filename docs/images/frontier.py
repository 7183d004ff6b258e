#!/usr/bin/python3
"""Draws docs/images/frontier.svg: GPU memory against visible error of every allocation that no other beats, a panel for each scene.

    for s in cornell outdoor interior zdm2_sun; do build/release/lightcook cook $s.toml -o out/$s; done    # scenes with a `budget`
    docs/images/frontier.py out/cornell out/outdoor out/interior out/zdm2_sun > docs/images/frontier.svg

Reads `budget.frontier` of each folder's report.json. Layout `raw`, the bake's own halves, is left out: its error is next to nothing in many
times the memory. Both axes are logarithmic; that of the error is the same in all panels. A full circle is what the cook chose.
"""
import json
import math
import pathlib
import sys

WIDTH, HEIGHT = 470, 300  # [pixels] of a panel
LEFT, RIGHT, TOP, BOTTOM = 48, 16, 30, 44
COLUMNS = 2
ERRORS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100)  # lines that may lie across the panels
LABEL_WIDTH = 50  # [pixels]
COLOUR = {"one layout": "#1f5fa8", "with detail": "#b8860b"}


def read_frontier(folder):
    """List of (KiB, visible error, chosen, layout, kind of the point: a key of COLOUR)."""
    report = json.loads((pathlib.Path(folder) / "report.json").read_text())
    points = []
    for entry in report["budget"]["frontier"]:
        layout, plus, _ = entry["layouts"][0]["layout"].partition("+")
        if layout != "raw":
            points.append((entry["bytes_gpu"] / 1024, entry["visible"], entry["chosen"], layout, "with detail" if plus else "one layout"))
    return points


def axis(low, high, start, end):
    """Maps values to pixels along a logarithmic axis."""
    return lambda value: start + (end - start) * math.log(value / low) / math.log(high / low)


def labelled(points, x):
    """(point, x and y of its label from it, class of the label) of the first point of each run with the same layout. Curves fall to the right:
    a label lies above the point on the right or, where it would cover another one or leave the panel, below on the left."""
    last, above, below = None, 0, LEFT  # [pixels]: where the next label may begin
    for point in points:
        at = x(point[0])
        if point[3] != last and at >= above and at + LABEL_WIDTH <= WIDTH - RIGHT:
            yield point, 5, -6, "small"
            above = at + LABEL_WIDTH
        elif point[3] != last and at - LABEL_WIDTH >= below:
            yield point, -5, 13, "small end"
            below = at
        last = point[3]


def lines_around(errors):
    """Those of ERRORS from the last below all errors to the first above them, which are the ends of the axis."""
    first = max(i for i, line in enumerate(ERRORS) if line <= min(errors))
    last = min(i for i, line in enumerate(ERRORS) if line >= max(errors))
    return ERRORS[first : last + 1]


def panel(name, points, lines, left, top):
    """SVG elements of one scene."""
    x = axis(points[0][0] / 1.1, points[-1][0] * 1.25, LEFT, WIDTH - RIGHT)
    y = axis(lines[0], lines[-1], HEIGHT - BOTTOM, TOP)
    out = [f'<g transform="translate({left} {top})">', f'<text x="{LEFT}" y="18" class="title">{name}</text>']
    for error in lines:
        out.append(f'<path d="M{LEFT} {y(error):.1f}H{WIDTH - RIGHT}" class="grid"/>')
        out.append(f'<text x="{LEFT - 6}" y="{y(error) + 4:.1f}" class="end">{error}</text>')
    for power in range(5, 16):
        kib = 2**power
        if points[0][0] / 1.1 <= kib <= points[-1][0] * 1.25:
            out.append(f'<path d="M{x(kib):.1f} {TOP}V{HEIGHT - BOTTOM}" class="grid"/>')
            text = f"{kib} KiB" if kib < 1024 else f"{kib // 1024} MiB"
            out.append(f'<text x="{x(kib):.1f}" y="{HEIGHT - BOTTOM + 16}" class="middle">{text}</text>')
    line = "L".join(f"{x(kib):.1f} {y(error):.1f}" for kib, error, *_ in points)
    out.append(f'<path d="M{line}" class="line"/>')
    for kib, error, chosen, _, kind in points:
        colour = COLOUR[kind]
        fill = colour if chosen else "#ffffff"
        out.append(f'<circle cx="{x(kib):.1f}" cy="{y(error):.1f}" r="{5 if chosen else 3}" stroke="{colour}" fill="{fill}"/>')
    for (kib, error, _, layout, _), right, down, style in labelled(points, x):
        out.append(f'<text x="{x(kib) + right:.1f}" y="{y(error) + down:.1f}" class="{style}">{layout}</text>')
    return out + ["</g>"]


def legend(down):
    """One line: the colours of the points."""
    out = [f'<g transform="translate({LEFT} {down})">']
    out.append('<text x="580" y="4">across: GPU memory; up: visible error, p99</text>')
    for i, (name, colour) in enumerate(COLOUR.items()):
        out.append(f'<circle cx="{10 + 110 * i}" cy="0" r="4" stroke="{colour}" fill="{colour}"/>')
        out.append(f'<text x="{20 + 110 * i}" y="4">{name}</text>')
    return out + ["</g>"]


def main(folders):
    rows = -(-len(folders) // COLUMNS)
    width, height = WIDTH * COLUMNS, HEIGHT * rows + 30
    style = (
        "text{font:12px sans-serif;fill:#333}.title{font-weight:bold;font-size:14px}.end{text-anchor:end}.middle{text-anchor:middle}"
        ".small{font-size:10px}.grid{stroke:#ddd;fill:none}.line{stroke:#888;fill:none}"
    )
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">',
        f'<style>{style}</style><rect width="{width}" height="{height}" fill="#fff"/>',
    ]
    frontiers = {pathlib.Path(folder).name: read_frontier(folder) for folder in folders}
    lines = lines_around([point[1] for points in frontiers.values() for point in points])
    for i, (name, points) in enumerate(frontiers.items()):
        out += panel(name, points, lines, WIDTH * (i % COLUMNS), HEIGHT * (i // COLUMNS))
    print("\n".join(out + legend(HEIGHT * rows + 10) + ["</svg>"]))


if __name__ == "__main__":
    main(sys.argv[1:])
