#!/usr/bin/python3
"""Makes this folder's data from the full-size Cornell box: examples/cornell/make.py [SOURCE]

SOURCE is the folder of the test data that holds scenes/ and gradients/ (default: ../shared/data beside the repository). The light map is
rounded to half and loses what lightcook does not read (positions); the rest is copied byte for byte. What the rounding changed is printed.
Needs Debian's python3-numpy and python3-openimageio.
"""
import pathlib
import shutil
import sys

import numpy
import OpenImageIO as oiio

HERE = pathlib.Path(__file__).resolve().parent
SH_CHANNELS = [f"sh{i:02}.{c}" for i in range(9) for c in "RGB"]
KEPT_CHANNELS = ["coverage.Y", "normal.X", "normal.Y", "normal.Z"] + SH_CHANNELS
COPIED = [
    "scenes/cornell.glb",
    "scenes/cornell_probe0.exr",
    "scenes/cornell_probes.json",
    "gradients/clear_sky_256x1.exr",
]


def read_channels(file, names):
    """{name: float32 array of height x width}, selected by name: libraries disagree about the order inside a layer."""
    image = oiio.ImageInput.open(str(file))
    if image is None:
        sys.exit(f"make.py: {file}: {oiio.geterror()}")
    stored = list(image.spec().channelnames)
    missing = [name for name in names if name not in stored]
    if missing:
        sys.exit(f"make.py: {file}: expected channels {', '.join(missing)}, found {', '.join(stored)}")
    texels = image.read_image(oiio.FLOAT)
    image.close()
    return {name: texels[:, :, stored.index(name)] for name in names}


def write_half(file, channels):
    height, width = next(iter(channels.values())).shape
    spec = oiio.ImageSpec(width, height, len(channels), oiio.HALF)
    spec.channelnames = tuple(channels)
    spec.tile_width = spec.tile_height = 64
    spec.attribute("compression", "zip")
    spec.attribute("DateTime", "2026:01:01 00:00:00")  # otherwise the time of day: the same input shall give the same bytes
    spec.attribute("ImageDescription", "SH light map: incident radiance, sh9 layout, no Condon-Shortley phase, world frame (Y up); CC0")
    out = oiio.ImageOutput.create(str(file))
    texels = numpy.stack(list(channels.values()), axis=2).astype(numpy.float16)
    if not (out and out.open(str(file), spec) and out.write_image(texels) and out.close()):
        sys.exit(f"make.py: {file}: {oiio.geterror()}")


def print_change(before, after):
    """Relative change of a texel's coefficients: of each against its own size, and against the texel's sh00 of the same channel."""
    covered = before["coverage.Y"] > 0.5
    own = of_dc = 0.0
    for name in SH_CHANNELS:
        change = numpy.abs(after[name] - before[name])[covered].astype(numpy.float64)
        size = numpy.abs(before[name])[covered]
        own = max(own, (change[size >= 2**-14] / size[size >= 2**-14]).max())  # below, half is denormal
        dc = before["sh00." + name[-1]][covered]
        of_dc = max(of_dc, (change[dc > 0] / dc[dc > 0]).max())
    squares = sum(((after[n] - before[n])[covered].astype(numpy.float64) ** 2).sum() for n in SH_CHANNELS)
    reference = sum((before[n][covered].astype(numpy.float64) ** 2).sum() for n in SH_CHANNELS)
    print(f"covered texels       {covered.sum()} of {covered.size}")
    print(f"largest value        {max(numpy.abs(before[n]).max() for n in SH_CHANNELS):.4g} (half holds 65504)")
    print(f"largest change       {own:.3g} of the coefficient, {of_dc:.3g} of the texel's sh00 (half rounds by up to {2**-11:.3g})")
    print(f"rms of the change    {(squares / reference) ** 0.5:.3g} of the map's rms")


def main():
    source = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parents[1].parent / "shared" / "data"
    before = read_channels(source / "scenes" / "cornell_lightmap.exr", KEPT_CHANNELS)
    write_half(HERE / "cornell_lightmap.exr", before)
    print_change(before, read_channels(HERE / "cornell_lightmap.exr", KEPT_CHANNELS))
    for name in COPIED:
        shutil.copyfile(source / name, HERE / pathlib.Path(name).name)
    print(f"bytes                {sum(f.stat().st_size for f in HERE.iterdir() if f.is_file())}")


if __name__ == "__main__":
    main()
