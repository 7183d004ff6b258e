#!/usr/bin/python3
"""Cooks and verifies small scenes under each of the faults that seed.py drew: run.py BUILD SEEDED [--faults N] [--only N,...] [--json FILE]

BUILD holds lightcook, lightcook_mutants and verify_tests_mutants, SEEDED is the folder that seed.py wrote. Of the faults, the first N (200)
are taken whose code runs for one of the scenes. Limits of the scenes are MARGIN times the errors of a right cook.
LIGHTCOOK_SOAK_SECONDS ends it earlier; LIGHTCOOK_SOAK_SEED chooses which of the N come first.

Fault of the encoders: the changed program cooks, which ends with a verification by code that has no fault.
  caught        the cook ends with an error, or not in ten times its time
  same bytes    in each scene for which the code runs, every file is that of a right cook
  true figures  other bytes within the limits. The program without faults measures the error that the report states, and so does this
                script, by formulas of its own, of the light that `reconstruct` finds in the files
  missed        anything else
Fault of verifier or shader: the changed program verifies what the program without faults cooked.
  caught        a right scene is refused, or tests of verify fail
  same figures  every figure of the report is the same
  near figures  errors are within a hundredth, and bounds are not lower by more: another order of a sum, another place that is looked at
  missed        anything else

Exit code 1: of those that are caught or missed, less than 95 % are caught. 77: skipped, and the last line says why.
"""
import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

try:
    import numpy
    import OpenImageIO as oiio
except ImportError:
    print("skipped: mutants: no python3-numpy or python3-openimageio")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
CROP = (160, 88, 48)  # of the example's light map, x, y and side: a shadow's edge and rims of charts
MARGIN = 1.25
SHARE = 0.95
OF_ENCODERS = {"bc1", "bc4", "bc6h", "bc7", "blocks", "texels", "light map", "basis"}
SCENES_OF_A_FAULT = 4
# Tests of verify that have to fail where a figure of right work changes and nothing is refused, by the folder of the fault.
BOUND_TESTS = ("VisibleGrid.*:VisibleBound.*:ExactBounds.*:LocalErrorBound.*:LightMapCoarseBound.*:MeansOfLight.*:AnyLight.*:"
               "EveryFamily/VisibleBoundOfLayout.*:LightMapVerifier.*:ErrorShader.*")
TESTS = {
    "verify/texture": "BlockDecoders/Astc.*:PackedFormats.*:SampleBilinear.*:SampleCube.*:FormatTolerance.*",
    "verify/light_map": BOUND_TESTS,
    "verify/error": "VisibleMetric.*:VisibleAccumulator.*:ErrorAccumulator.*:DisplayTransform.*:" + BOUND_TESTS,
    "verify/assets": "VerifyLut.*:LutBound.*:LutStepError.*:VerifyRsrm.*:VerifyCubemap.*:CubemapReference.*:PrefilteredLight.*:"
                     "VerifyDominant.*",
    "shaders": "ErrorShader.*:WholeShader.*:VerifyLut.*:LightMapStages.*",
}


class Scene:
    """A scene with one asset, or few of one kind, whose other inputs are the same for all."""

    def __init__(self, name, only, output="", light_map="", tables=""):
        self.name, self.only, self.output, self.light_map, self.tables = name, only, output, light_map, tables

    def text(self, limits=""):
        return (f'schema = 1\nname = "small"\n[output]\n{self.output}\n{limits}\n[[light_map]]\nname = "map"\nfile = "map.exr"\n'
                f'{self.light_map}\n{self.tables}\n[[material]]\nname = "*"\nnormal_map = true\nspecular = true\nm = [0.1, 0.5]\n'
                "f0 = [0.04, 0.6]\n")

    def limits_of(self, report):
        """Lines of [output] that a right cook keeps by MARGIN."""
        figures = [stage["error"][kind] for row in report["assets"] for kind in ("diffuse", "specular")
                   for stage in (row["stages"][-1], *row.get("mips", []), *row.get("mip_blends", []))]
        error = MARGIN * max(each["rel_rms"] for each in figures)
        visible = MARGIN * max(each.get("visible", {"p99": 0})["p99"] for each in figures)
        kind = "" if self.only == "map" else "converter_"
        lines = f"max_{kind}error = {max(error, 1e-5):.6g}\n"
        return lines + (f"max_{kind}visible = {visible:.6g}\n" if visible > 0 else "")


def light_map(layout, target="bc", more="", name=""):
    return Scene(name or f"{layout} {target}", "map", f'light_map_layout = "{layout}"\ntarget = "{target}"\n{more}')


def sky(format_, gradient="sky"):
    return Scene(f"sky {format_}", "sky", 'light_map_layout = "ratio"',
                 tables=f'[[gradient]]\nname = "sky"\nfile = "{gradient}.exr"\nexponents = [1, 16, 256]\nformat = "{format_}"\n')


SCENES = [
    light_map("raw", "float"), light_map("ratio"), light_map("ratio", "astc"), light_map("ratio", "bc", "effort = 0", "ratio fast"),
    light_map("ratio", "bc", "effort = 9", "ratio best"), light_map("ratio", "bc", "rdo = 0.05\nzstd = true", "ratio rdo"),
    light_map("hdr-2"), light_map("hdr", "bc", "effort = 0", "hdr fast"), light_map("hdr", "bc", "effort = 9", "hdr best"),
    light_map("hdr", "astc", "mips = true", "hdr mips"), light_map("hdr-rgb9e5"), light_map("flat-2"), light_map("halo3"),
    light_map("basis-8"), light_map("basis-4", "astc"), light_map("basis-16", "bc", 'effort = 1\nobjective = "energy"', "basis energy"),
    light_map("lit-half"), light_map("lit", "astc"), light_map("sh4"), light_map("godot"), light_map("mono-sh"), light_map("bakery"),
    light_map("unreal-hq"), light_map("unreal-hq", "astc"),
    Scene("dominant", "map_dominant", 'light_map_layout = "ratio"', 'dominant_layout = "full"'),
    Scene("tables", "specular", 'light_map_layout = "ratio"'),
    Scene("probe", "probe", 'light_map_layout = "raw"\ntarget = "float"',
          tables='[[probe]]\nname = "probe"\nfile = "probe.exr"\nsize = 16\n'),
    *(sky(each) for each in ("rgba8", "bc7", "bc6h", "rgb9e5", "rgba16f")), sky("bc4", "grey"),
]


# ---- inputs: a part of the example, a small probe and a gradient ----

def write_exr(file, names, pixels):
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], "float")
    spec.channelnames = tuple(names)
    out = oiio.ImageOutput.create(str(file))
    if not (out and out.open(str(file), spec) and out.write_image(numpy.ascontiguousarray(pixels, dtype=numpy.float32)) and out.close()):
        sys.exit(f"{file}: {oiio.geterror()}")


def read_exr(file):
    """(names of channels, pixels)"""
    image = oiio.ImageInput.open(str(file))
    return list(image.spec().channelnames), image.read_image(format="float")


def sky_and_sun(direction):
    """Radiance from directions [..., 3]."""
    sun = numpy.maximum(0, direction @ numpy.array([0.4, 0.86, 0.3]) / numpy.linalg.norm([0.4, 0.86, 0.3])) ** 16
    return 4 * sun[..., None] * [1.0, 0.8, 0.6] + (0.6 + 0.4 * direction[..., 1:2]) * [0.2, 0.3, 0.5]


def write_inputs(folder):
    names, pixels = read_exr(ROOT / "examples/cornell/cornell_lightmap.exr")
    x, y, side = CROP
    write_exr(folder / "map.exr", names, pixels[y:y + side, x:x + side])
    size = 16
    s, t = numpy.meshgrid((2 * numpy.arange(size) + 1) / size - 1, (2 * numpy.arange(size) + 1) / size - 1)
    one = numpy.ones_like(s)
    faces = [(one, -t, -s), (-one, -t, s), (s, one, t), (s, -one, -t), (s, -t, one), (-s, -t, -one)]  # Vulkan 16.5.4
    directions = numpy.concatenate([numpy.stack(face, -1) for face in faces])
    write_exr(folder / "probe.exr", "RGB", sky_and_sun(directions / numpy.linalg.norm(directions, axis=-1, keepdims=True)))
    z = 1 - (2 * numpy.arange(64) + 1) / 64
    gradient = sky_and_sun(numpy.stack([numpy.sqrt(1 - z * z), z, 0 * z], -1)[None])
    write_exr(folder / "sky.exr", "RGB", gradient)
    write_exr(folder / "grey.exr", "RGB", gradient[..., 1:2] * [1, 1, 1])


# ---- an independent measure ----

def basis(d):
    """Real orthonormal SH of degree 2, without Condon-Shortley signs, of directions [..., 3]."""
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    a, b, c = 0.5 / numpy.sqrt(numpy.pi), numpy.sqrt(0.75 / numpy.pi), numpy.sqrt(3.75 / numpy.pi)
    return numpy.stack([a + 0 * x, b * y, b * z, b * x, c * x * y, c * y * z, c * (3 * z * z - 1) / numpy.sqrt(12), c * x * z,
                        c / 2 * (x * x - y * y)], -1)


def diffuse_error(bake, reconstructed):
    """RMS of the error over RMS of the reference, at texel centres, for normals in the hemispheres of the texels' own."""
    (names, a), (other_names, b) = read_exr(bake), read_exr(reconstructed)
    covered = a[..., names.index("coverage.Y")] > 0.5
    light, other = (numpy.stack([numpy.stack([p[..., n.index(f"sh{i:02}.{c}")] for c in "RGB"], -1) for i in range(9)], -2)[covered]
                    .astype(float) for n, p in ((names, a), (other_names, b)))
    normal = numpy.stack([a[..., names.index(f"normal.{c}")] for c in "XYZ"], -1)[covered].astype(float)
    normal /= numpy.linalg.norm(normal, axis=1, keepdims=True)
    error = reference = 0
    rng = numpy.random.default_rng(1)
    for _ in range(64):
        d = rng.normal(size=normal.shape)
        d /= numpy.linalg.norm(d, axis=1, keepdims=True)
        side = d - (d * normal).sum(1, keepdims=True) * normal
        side /= numpy.linalg.norm(side, axis=1, keepdims=True)
        cosine = rng.random((len(normal), 1))
        weights = basis(cosine * normal + numpy.sqrt(1 - cosine * cosine) * side) * ([1] + 3 * [2 / 3] + 5 * [1 / 4])
        exact, found = (numpy.einsum("ti,tic->tc", weights, each) for each in (light, other))
        error, reference = error + ((found - exact) ** 2).sum(), reference + (exact ** 2).sum()
    return float(numpy.sqrt(error / reference))


# ---- runs ----

class Workshop:
    def __init__(self, build, folder):
        self.build, self.folder = build, folder
        self.inputs = folder / "inputs"
        self.inputs.mkdir()
        write_inputs(self.inputs)

    def run(self, program, arguments, fault=None, reached=None, limit=120):
        """Exit code, or None where it did not end."""
        environment = {**os.environ, "LIGHTCOOK_MUTANT": str(-1 if fault is None else fault)}
        if reached:
            environment["LIGHTCOOK_MUTANTS_REACHED"] = str(reached)
        try:
            done = subprocess.run([str(self.build / program), *map(str, arguments)], env=environment, timeout=limit,
                                  stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
        except subprocess.TimeoutExpired:
            return None, "does not end"
        return done.returncode, done.stdout

    def cook(self, program, scene, output, limits="", **more):
        file = self.inputs / f"{output.parent.name}-{output.name}.toml"
        file.write_text(scene.text(limits))
        cache = output.parent / (output.name + ".cache")
        code = self.run(program, ["cook", file, "-o", output, "--cache", cache, "--only", scene.only, "-j", 1, "-q", "--json",
                                  output.parent / (output.name + ".json")], **more)
        shutil.rmtree(cache, ignore_errors=True)
        return code

    def verify(self, program, output, report, **more):
        return self.run(program, ["verify", output, "-j", 1, "-q", "--json", report], **more)


def figures_of(report):
    """What a report states of errors: its numbers by their paths."""
    found = {}

    def visit(value, path):
        if isinstance(value, dict):
            for name, each in value.items():
                if not name.endswith("seconds"):
                    visit(each, path + (name,))
        elif isinstance(value, list):
            for index, each in enumerate(value):
                visit(each, path + (index,))
        else:
            found[path] = value

    for row in json.loads(report.read_text())["assets"]:
        for part in ("stages", "mips", "mip_blends", "passed", "violations", "worst_block", "key"):
            visit(row.get(part), (row["name"], part))
    return found


def files_of(output):
    """What an engine loads, and the constants that it is told."""
    files = {file.name: file.read_bytes() for file in output.iterdir() if file.suffix in (".ktx2", ".dds", ".glsl", ".glb")}
    files["constants"] = [each.get("constants") for each in json.loads((output / "cooked.json").read_text())["assets"]]
    return files


ERRORS, BOUNDS = ("rel_rms", "rms", "p95", "p99"), ("bound", "max_bound")


def are_near(right, found):
    """Errors are within a hundredth, and no bound is lower by more than that: a higher one is still a bound."""
    right, found = ({key: value for key, value in each.items() if key[-1] in ERRORS + BOUNDS} for each in (right, found))
    return right.keys() == found.keys() and all(
        a == b or None not in (a, b) and b >= 0.99 * a and (key[-1] in BOUNDS or b <= 1.01 * a)
        for key, a in right.items() for b in (found[key],))


def of_encoder(shop, fault, scenes, folder):
    changed = []
    for scene in scenes:
        output = folder / scene.name.replace(" ", "_")
        code, lines = shop.cook("lightcook_mutants", scene, output, scene.limits, fault=fault["number"], limit=10 + 10 * scene.seconds)
        if code != 0:
            return "caught", scene.name, lines.strip().splitlines()[-1:] or [f"exit code {code}"]
        if files_of(output) == scene.files:
            continue
        report = folder / "verified.json"
        code, lines = shop.verify("lightcook", output, report)
        if code != 0:
            return "missed", scene.name, ["the cook passed, and verify says: " + lines]
        stated = figures_of(output / "report.json")
        if stated != figures_of(report):
            return "missed", scene.name, ["the report states other figures"]
        if scene.only == "map" and "flat" not in scene.name:
            file = folder / "reconstructed.exr"
            code, lines = shop.run("lightcook", ["reconstruct", output, "map", file, "-q"])
            mine = diffuse_error(shop.inputs / "map.exr", file)
            row = json.loads((output / "report.json").read_text())["assets"][0]
            theirs = row["stages"][-1]["at_texels"]["diffuse"]["rel_rms"]
            if not abs(mine - theirs) <= 0.05 * theirs + 1e-5:
                return "missed", scene.name, [f"states {theirs}, found {mine}"]
        changed.append(scene.name)
    return ("true figures", changed, []) if changed else ("same bytes", [scene.name for scene in scenes], [])


def of_verifier(shop, fault, scenes, folder):
    result = ("same figures", [scene.name for scene in scenes], [])
    for scene in scenes:
        report = folder / "verified.json"
        code, lines = shop.verify("lightcook_mutants", scene.output_folder, report, fault=fault["number"], limit=10 + 10 * scene.seconds)
        if code != 0:
            return "caught", scene.name, lines.strip().splitlines()[-1:] or [f"exit code {code}"]
        found = figures_of(report)
        if found != scene.figures and result[0] != "missed":
            differing = {key: (scene.figures.get(key), found.get(key)) for key in found.keys() | scene.figures.keys()
                         if found.get(key) != scene.figures.get(key)}
            result = ("near figures" if are_near(scene.figures, found) else "missed", scene.name,
                      [f"{'/'.join(map(str, key))}: {a} -> {b}" for key, (a, b) in sorted(differing.items(), key=str)
                       if key[-1] in ERRORS + BOUNDS][:8])
    if result[0] == "missed":
        tests = next(names for folder, names in TESTS.items() if fault["file"].startswith(folder))
        code, lines = shop.run("verify_tests_mutants", [f"--gtest_filter={tests}", "--gtest_brief=1", "--gtest_fail_fast"],
                               fault=fault["number"], limit=600)
        if code != 0:
            return "caught", "verify_tests", [line for line in lines.splitlines() if "FAILED" in line][:1]
    return result


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("seeded", type=pathlib.Path)
    parser.add_argument("--faults", type=int, default=200)
    parser.add_argument("--only", type=lambda text: [int(each) for each in text.split(",")])
    parser.add_argument("--json", type=pathlib.Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="lightcook-mutants-") as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        measure(options, pathlib.Path(folder), pool)


def prepare(shop, scene):
    """Cooks a scene as it is, then within the limits that this leaves it, by both programs."""
    folder = shop.folder / scene.name.replace(" ", "_")
    folder.mkdir()
    code, lines = shop.cook("lightcook", scene, folder / "free")
    if code != 0:
        sys.exit(f"{scene.name}: {lines}")
    scene.limits = scene.limits_of(json.loads((folder / "free/report.json").read_text()))
    scene.output_folder = folder / "right"
    started = os.times().elapsed
    for program, output in (("lightcook", scene.output_folder), ("lightcook_mutants", folder / "mutants")):
        code, lines = shop.cook(program, scene, output, scene.limits, reached=folder / "cook.txt")
        if code != 0:
            sys.exit(f"{scene.name}: {program}: {lines}")
    scene.seconds = (os.times().elapsed - started) / 2
    code, lines = shop.verify("lightcook_mutants", scene.output_folder, folder / "verified.json", reached=folder / "verify.txt")
    scene.files = files_of(scene.output_folder)
    scene.figures = figures_of(folder / "verified.json")
    if files_of(folder / "mutants") != scene.files or code != 0 or scene.figures != figures_of(scene.output_folder / "report.json"):
        sys.exit(f"{scene.name}: without a fault, lightcook_mutants does not do what lightcook does")
    scene.reached = [set(map(int, (folder / name).read_text().split())) for name in ("cook.txt", "verify.txt")]


def measure(options, folder, pool):
    until = time.monotonic() + float(os.environ.get("LIGHTCOOK_SOAK_SECONDS", "inf"))
    shop = Workshop(options.build, folder)
    list(pool.map(lambda scene: prepare(shop, scene), SCENES))
    faults, runs = json.loads((options.seeded / "mutants.json").read_text()), []
    for fault in faults:
        which = 0 if fault["group"] in OF_ENCODERS else 1
        scenes = [scene for scene in SCENES if fault["number"] in scene.reached[which]]
        if scenes and len(runs) < options.faults and (not options.only or fault["number"] in options.only):
            runs.append((fault, scenes[::-(-len(scenes) // SCENES_OF_A_FAULT)]))
        fault["runs"] = bool(scenes)
    print(f"{len(faults)} faults, {sum(fault['runs'] for fault in faults)} run, {len(runs)} taken; seconds of the scenes: "
          + ", ".join(f"{scene.name} {scene.seconds:.1f}" for scene in SCENES), flush=True)

    if seed := os.environ.get("LIGHTCOOK_SOAK_SEED"):
        random.Random(int(seed)).shuffle(runs)

    def judge(run):
        if time.monotonic() > until:
            return None
        fault, scenes = run
        own = folder / f"fault{fault['number']}"
        own.mkdir()
        what_becomes = of_encoder if fault["group"] in OF_ENCODERS else of_verifier
        fault["class"], fault["where"], fault["said"] = what_becomes(shop, fault, scenes, own)
        shutil.rmtree(own)
        if fault["class"] == "missed":
            print(json.dumps(fault), flush=True)
        return fault

    judged = [fault for fault in pool.map(judge, runs) if fault]
    print(f"soak: {len(judged)} mutants")
    if options.json:
        options.json.write_text(json.dumps(judged, indent=1))
    table = collections.Counter((fault["group"], fault["class"]) for fault in judged)
    for key, count in sorted(table.items()):
        print(*key, count, sep="\t")
    totals = collections.Counter(fault["class"] for fault in judged)
    print(dict(totals))
    wrong = totals["caught"] + totals["missed"]
    if totals["caught"] < SHARE * wrong:
        sys.exit(f"{totals['missed']} of {wrong} missed, at most {1 - SHARE:.0%} are allowed")


if __name__ == "__main__":
    main()
