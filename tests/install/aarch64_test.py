#!/usr/bin/python3
"""Builds the program for 64-bit Arm with Debian's cross compiler, runs it under QEMU, and compares what it writes with what this machine
writes: every pixel format, a light map in every layout, and the other assets of a scene are the same bytes. Takes about an hour.
Exits with 77, which ctest reports as skipped, where compiler, QEMU or the arm64 packages are missing (./dev setup aarch64).
  aarch64_test.py REPOSITORY BUILD_DIR
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

import numpy
import OpenImageIO

repository, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
arm_build, sysroot = repository / "build/aarch64", repository / "build/aarch64-sysroot"
out = build / "aarch64_test"
native = [str(build / "lightcook")]
arm = ["qemu-aarch64", "-L", str(sysroot), str(arm_build / "lightcook")]
FORMATS = ("bc1 bc3 bc4 bc4-snorm bc5 bc5-snorm bc6h-uf16 bc6h-sf16 bc7 astc-4x4-hdr astc-6x6-hdr astc-8x8-hdr astc-4x4-ldr rgb9e5 "
           "r11g11b10f rgba16f rgb16f r16-unorm rg16-unorm rgba16-unorm rgba8-unorm rgba8-srgb").split()
EFFORTS = (0, 3, 7)
# What libastcenc computes in the widest vectors of a machine is not ours to fix.
FOREIGN = ("astc-4x4-hdr", "astc-6x6-hdr", "astc-8x8-hdr", "astc-4x4-ldr")
LAYOUTS = re.findall(r'\.name = "([^"]+)"', (repository / "formats/light_map_layout.h").read_text())


def skip(reason):
    print(f"skipped: nothing was built for 64-bit Arm: {reason}")
    sys.exit(77)


def build_for_arm():
    for tool in ("aarch64-linux-gnu-g++", arm[0]):
        if shutil.which(tool) is None:
            skip(f"{tool} is missing: ./dev setup aarch64")
    if not (sysroot / "packages").exists():
        skip("the arm64 packages are missing: ./dev setup aarch64")
    for command in (["cmake", "--preset", "aarch64", "-DLIGHTCOOK_TESTS=OFF"],
                    ["cmake", "--build", str(arm_build), "--target", "lightcook", "lightcook_images"]):
        with open(out / "build.log", "a", encoding="utf-8") as log:
            subprocess.run(command, cwd=repository, stdout=log, stderr=log, check=True)


def crop(name, x, y, size):
    """Writes a square of the example's light map: QEMU takes 50 times as long as a processor."""
    source = OpenImageIO.ImageInput.open(str(repository / "examples/cornell/cornell_lightmap.exr"))
    spec = source.spec()
    texels = source.read_image(0, 0, 0, spec.nchannels, "float")[y:y + size, x:x + size]
    square = OpenImageIO.ImageSpec(size, size, spec.nchannels, "float")
    square.channelnames = spec.channelnames
    image = OpenImageIO.ImageOutput.create(str(out / name))
    image.open(str(out / name), square)
    image.write_image(numpy.ascontiguousarray(texels))
    image.close()


def write_picture(name, size):
    """Writes four channels in [0, 1] that have gradients, edges and noise."""
    y, x = numpy.mgrid[0:size, 0:size] / size
    noise = numpy.random.default_rng(1).random((size, size))
    texels = numpy.stack([x, (x + y > 0.9) * 0.8 + 0.1 * noise, y * y, 0.3 + 0.7 * noise], -1).astype(numpy.float32)
    image = OpenImageIO.ImageOutput.create(str(out / name))
    image.open(str(out / name), OpenImageIO.ImageSpec(size, size, 4, "float"))
    image.write_image(texels)
    image.close()


def textures(folder):
    return {str(file.relative_to(folder)): file.read_bytes()
            for file in sorted(folder.rglob("*")) if file.suffix in (".ktx2", ".dds", ".glb", ".glsl")}


def same(name, *arguments):
    """Runs both programs and returns whether they write the same bytes. '@' in an argument is the name of what they write."""
    written = []
    for machine, program in (("native", native), ("arm", arm)):
        folder = out / machine / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        environment = dict(os.environ, XDG_CACHE_HOME=str(folder / "cache"))
        ended = subprocess.run(program + [argument.replace("@", str(folder / "out")) for argument in arguments], cwd=out, env=environment,
                               capture_output=True, text=True, check=False)
        if ended.returncode not in (0, 4):  # 4: a limit of an error, which a small map may exceed
            print(f"{name} on {machine}: exit code {ended.returncode}: {ended.stderr.strip()}")
            return False
        shutil.rmtree(folder / "cache", ignore_errors=True)
        written.append(textures(folder))
    differing = [file for file in written[0] if written[0][file] != written[1].get(file)]
    if not written[0] or written[0].keys() != written[1].keys() or differing:
        print(f"{name}: differs: {', '.join(differing) or 'the files'}")
        return False
    return True


def main():
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    build_for_arm()
    crop("map.exr", 10, 60, 24)
    write_picture("picture.exr", 64)
    shutil.copy(repository / "examples/cornell/clear_sky_256x1.exr", out / "sky.exr")
    shutil.copy(repository / "examples/cornell/cornell_probe0.exr", out / "probe.exr")
    checks = [(f"{name} at effort {effort}", "encode", "picture.exr", "@.ktx2", "--format", name, "--effort", str(effort))
              for name in FORMATS if name not in FOREIGN for effort in EFFORTS]
    checks += [(f"layout {name}", "lightmap", "map.exr", "@", "--layout", name, "--max-error", "1") for name in LAYOUTS]
    checks += [("gradient", "rsrm", "sky.exr", "@.ktx2"), ("cubemap", "cubemap", "probe.exr", "@.ktx2", "--size", "16"),
               ("dominant light", "dominant", "map.exr", "@"), ("tables", "lut", "@")]
    failed = [check[0] for check in checks if not same(*check)]
    print(f"aarch64_test: {len(checks) - len(failed)} of {len(checks)} are the same bytes on both machines")
    sys.exit(1 if failed else 0)


main()
