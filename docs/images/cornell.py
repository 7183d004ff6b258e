#!/usr/bin/python3
"""Renders docs/images/cornell.png: the Cornell box lit by its float bake, by the cooked light map, and the difference.

    build/release/lightcook demo -o demo && build/release/lightcook reconstruct demo lightmap reconstructed.exr
    docs/images/cornell.py reconstructed.exr cornell.png

Every pixel is exit radiance at the surface normal times the material's base colour. Needs Debian's python3-numpy and python3-openimageio.
"""
import json
import pathlib
import struct
import sys

import numpy
import OpenImageIO as oiio

EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples/cornell"
SIZE = 380  # [pixels] of one panel
SUPERSAMPLE = 3
EYE, TARGET, FIELD = (2.78, 2.73, 12.6), (2.78, 2.73, 0.0), 40.0  # [degrees]
EXPOSURE = 3.2
DIFFERENCE_RANGE = 0.1  # local relative error shown as white
GAP = 8


def read_map(file):
    """Coefficients (height, width, 9, 3) and coverage (height, width; None where the file has none)."""
    image = oiio.ImageInput.open(str(file))
    names = list(image.spec().channelnames)
    texels = image.read_image(oiio.FLOAT)
    image.close()
    order = [names.index(f"sh{i:02}.{c}") for i in range(9) for c in "RGB"]
    coverage = texels[..., names.index("coverage.Y")] > 0.5 if "coverage.Y" in names else None
    return texels[..., order].reshape(*texels.shape[:2], 9, 3).astype(numpy.float64), coverage


def read_triangles(file):
    """Positions, normals and light-map UVs (n, 3, k), base colours and emission (n, 3)."""
    data = file.read_bytes()
    json_length = struct.unpack_from("<I", data, 12)[0]
    gltf, binary = json.loads(data[20 : 20 + json_length]), data[28 + json_length :]
    components = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}

    def accessor(index):
        item = gltf["accessors"][index]
        start = gltf["bufferViews"][item["bufferView"]]["byteOffset"]
        kind = {5126: numpy.float32, 5125: numpy.uint32}[item["componentType"]]
        count = components[item["type"]]
        return numpy.frombuffer(binary, kind, item["count"] * count, start).reshape(item["count"], count)

    parts = [[], [], [], [], []]
    for primitive in gltf["meshes"][0]["primitives"]:
        corners = accessor(primitive["indices"]).reshape(-1, 3)
        material = gltf["materials"][primitive["material"]]
        strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        for part, name in zip(parts, ("POSITION", "NORMAL", "TEXCOORD_1")):
            part.append(accessor(primitive["attributes"][name])[corners].astype(numpy.float64))
        parts[3].append(numpy.tile(material["pbrMetallicRoughness"]["baseColorFactor"][:3], (len(corners), 1)))
        parts[4].append(numpy.tile(numpy.array(material.get("emissiveFactor", [0, 0, 0])) * strength, (len(corners), 1)))
    return [numpy.concatenate(part) for part in parts]


def camera_rays(size):
    """Unit directions (size * size, 3)."""
    eye, target = numpy.array(EYE), numpy.array(TARGET)
    forward = (target - eye) / numpy.linalg.norm(target - eye)
    right = numpy.cross(forward, [0, 1, 0])
    right /= numpy.linalg.norm(right)
    up = numpy.cross(right, forward)
    steps = ((numpy.arange(size) + 0.5) / size * 2 - 1) * numpy.tan(numpy.radians(FIELD / 2))
    x, y = numpy.meshgrid(steps, -steps)
    rays = forward + x[..., None] * right + y[..., None] * up
    return (rays / numpy.linalg.norm(rays, axis=-1, keepdims=True)).reshape(-1, 3)


def trace(rays, positions):
    """Index of the nearest front-facing triangle of each ray (-1: none), and barycentric coordinates (Moeller and Trumbore 1997)."""
    nearest = numpy.full(len(rays), numpy.inf)
    hit = numpy.full(len(rays), -1)
    weights = numpy.zeros((len(rays), 3))
    for index, (a, b, c) in enumerate(positions):
        cross = numpy.cross(rays, c - a)
        determinant = cross @ (b - a)
        with numpy.errstate(divide="ignore", invalid="ignore"):
            from_a = numpy.array(EYE) - a
            u = cross @ from_a / determinant
            turned = numpy.cross(from_a, b - a)
            v = rays @ turned / determinant
            distance = turned @ (c - a) / determinant
        inside = (determinant > 1e-9) & (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0) & (distance < nearest)
        nearest[inside], hit[inside] = distance[inside], index
        weights[inside] = numpy.stack([1 - u - v, u, v], -1)[inside]
    return hit, weights


def basis(n):
    """The nine functions of docs/theory/lighting.md times the band factors of exit radiance."""
    x, y, z = n.T
    one = numpy.ones_like(x)
    band1, band2 = 0.488603 * 2 / 3, 1 / 4
    return numpy.stack([0.282095 * one, band1 * y, band1 * z, band1 * x, band2 * 1.092548 * x * y, band2 * 1.092548 * y * z,
                        band2 * 0.315392 * (3 * z * z - 1), band2 * 1.092548 * x * z, band2 * 0.546274 * (x * x - y * y)], -1)


def sample(coefficients, coverage, uv):
    """Bilinear filter over covered texels alone."""
    height, width = coverage.shape
    place = uv * (width, height) - 0.5
    first = numpy.floor(place).astype(int)
    fraction = place - first
    total, weight = 0, 0
    for dy in (0, 1):
        for dx in (0, 1):
            x = numpy.clip(first[:, 0] + dx, 0, width - 1)
            y = numpy.clip(first[:, 1] + dy, 0, height - 1)
            w = numpy.abs(1 - dx - fraction[:, 0]) * numpy.abs(1 - dy - fraction[:, 1]) * coverage[y, x]
            total = total + w[:, None, None] * coefficients[y, x]
            weight = weight + w
    return total / numpy.maximum(weight, 1e-9)[:, None, None]


def shaded(coefficients, coverage, uv, normals):
    return numpy.maximum(numpy.einsum("ni,nic->nc", basis(normals), sample(coefficients, coverage, uv)), 0)


def display(linear):
    """Filmic curve (Narkowicz 2015, ACES fit) and sRGB encoding."""
    x = linear * EXPOSURE * 0.6
    x = numpy.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0, 1)
    return numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def heat(value):
    """Black, purple, red, yellow, white."""
    stops = numpy.array([[0, 0, 4], [87, 16, 110], [188, 55, 84], [249, 142, 9], [252, 255, 164]]) / 255
    place = numpy.clip(value, 0, 1) * (len(stops) - 1)
    low = numpy.minimum(place.astype(int), len(stops) - 2)
    return stops[low] + (place - low)[..., None] * (stops[low + 1] - stops[low])


def main():
    bake, coverage = read_map(EXAMPLE / "cornell_lightmap.exr")
    cooked, _ = read_map(sys.argv[1])
    positions, normals, uvs, colors, emission = read_triangles(EXAMPLE / "cornell.glb")
    size = SIZE * SUPERSAMPLE
    hit, weights = trace(camera_rays(size), positions)
    seen = hit >= 0
    index, weight = hit[seen], weights[seen][..., None]
    normal = (normals[index] * weight).sum(1)
    uv = (uvs[index] * weight).sum(1)
    reference, result = (shaded(each, coverage, uv, normal) for each in (bake, cooked))
    luminance = numpy.array([0.2126, 0.7152, 0.0722])
    key = numpy.exp(numpy.log(numpy.maximum(reference @ luminance, 1e-6)).mean())
    error = numpy.abs(result - reference).max(-1) / (reference.max(-1) + 0.02 * key)

    def panel(values):
        image = numpy.zeros((size * size, 3))
        image[seen] = values
        return image.reshape(SIZE, SUPERSAMPLE, SIZE, SUPERSAMPLE, 3).mean((1, 3))

    panels = [panel(display(each * colors[index] + emission[index])) for each in (reference, result)]
    panels.append(panel(heat(error / DIFFERENCE_RANGE)))
    gap = numpy.ones((SIZE, GAP, 3))
    picture = numpy.concatenate([panels[0], gap, panels[1], gap, panels[2]], 1)
    picture = numpy.ascontiguousarray((picture * 255 + 0.5).astype(numpy.uint8))
    out = oiio.ImageOutput.create(sys.argv[2])
    out.open(sys.argv[2], oiio.ImageSpec(picture.shape[1], picture.shape[0], 3, oiio.UINT8))
    out.write_image(picture)
    out.close()


main()
