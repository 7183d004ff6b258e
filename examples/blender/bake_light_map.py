#!/usr/bin/env python3
"""Bakes the SH light map of meshes in a .blend file with Cycles, as an EXR that lightcook cooks without any key but `file`.

    blender -b room.blend -P bake_light_map.py -- --output room_lightmap.exr --mesh room.glb --size 512

Method: a diffuse bake of a white surface gives E(n) / pi, the irradiance for a shading normal n, for light from the front of the face
alone. Irradiance is radiance convolved with the cosine, so that the integral of E(n) Y_i(n) over the sphere, divided by the cosine's factor
pi, 2 pi / 3 or pi / 4 of the band, is the coefficient i of the radiance (Ramamoorthi and Hanrahan, 2001). The integral is a product rule of
6 heights (Gauss) and 10 azimuths over the face's normal, which is exact up to degree 9. Cycles shades normals of the front alone; for the
others E(-n) = E(n) - n.V, where V is the integral of L(w) w: E of the face's own normal is V along it, and the difference of E of opposite
normals in the plane of the face is V along these.

The white surface is a copy of the meshes, a hair above them, with custom normals. Only bakes see it: light bounces off the scene's own
materials. The scene in memory is changed, the .blend file is not. Needs Cycles and python3-openimageio. Tried with Blender
3.4; from 4.1 on, meshes have no use_auto_smooth.
"""
import argparse
import math
import os
import sys
import time

import bpy
import numpy as np

COSINE = np.array([math.pi] + [2 * math.pi / 3] * 3 + [math.pi / 4] * 5)  # of each coefficient
HEIGHTS, AZIMUTHS = 6, 10
LEVEL = 0.005  # height of normals that stand for those in the plane of a face
GAP = 1e-4     # between a mesh and its white copy, relative to the mesh's size


def fail(text):
    """Ends Blender with exit code 2 and one line."""
    print(f"bake_light_map: error: {text}", file=sys.stderr)
    sys.stderr.flush()
    os._exit(2)


def basis(n):
    """The nine real, orthonormal harmonics of unit directions n[..., 3], without Condon-Shortley signs."""
    x, y, z = n[..., 0], n[..., 1], n[..., 2]
    return np.stack([0 * x + 0.28209479177387814, 0.4886025119029199 * y, 0.4886025119029199 * z, 0.4886025119029199 * x,
                     1.0925484305920792 * x * y, 1.0925484305920792 * y * z, 0.31539156525252005 * (3 * z * z - 1),
                     1.0925484305920792 * x * z, 0.5462742152960396 * (x * x - y * y)], -1)


def quadrature():
    """The normals [count, 3] of the upper half of the rule, and their weights; those of the whole sphere sum to 4 pi."""
    heights, weights = np.polynomial.legendre.leggauss(HEIGHTS)
    normals, factors = [], []
    for height, weight in zip(heights, weights):
        for k in range(AZIMUTHS if height > 0 else 0):
            angle, radius = 2 * math.pi * (k + 0.5) / AZIMUTHS, math.sqrt(1 - height * height)
            normals.append((radius * math.cos(angle), radius * math.sin(angle), height))
            factors.append(weight * 2 * math.pi / AZIMUTHS)
    return np.array(normals), np.array(factors)


def y_up(v):
    """glTF's axes (Y up) of Blender's (Z up), as the glTF exporter turns them."""
    return np.stack([v[..., 0], v[..., 2], -v[..., 1]], -1)


def read_options():
    parser = argparse.ArgumentParser(prog="bake_light_map.py", description="Bakes an SH light map with Cycles.")
    parser.add_argument("--output", required=True, help="the EXR to write")
    parser.add_argument("--mesh", help="also export the meshes as GLB, with the light-map UVs as TEXCOORD_1")
    parser.add_argument("--object", action="append", help="a mesh that gets light; default: all that are visible and have two UV layers")
    parser.add_argument("--uv", help="the UV layer of the light map; default: the second one, or the only one of a named object")
    parser.add_argument("--size", type=int, default=256, help="width and height of the light map [texels]")
    parser.add_argument("--samples", type=int, default=64, help=f"paths a texel for each of {HEIGHTS * AZIMUTHS // 2 + 5} normals")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    if not 4 <= options.size <= 16384:
        fail(f"--size: found {options.size}, expected 4 to 16384")
    if options.samples < 1:
        fail(f"--samples: found {options.samples}, expected at least 1")
    return options


def find_objects(options):
    """The meshes to bake, each with the name of its light-map UV layer."""
    if options.object:
        objects = [bpy.data.objects.get(name) or fail(f"--object: found no object '{name}'") for name in options.object]
    else:
        objects = [o for o in bpy.context.view_layer.objects if o.type == "MESH" and o.visible_get() and len(o.data.uv_layers) > 1]
    if not objects:
        fail("found no visible mesh with two UV layers, expected one; --object NAME takes a mesh with one")
    found = {}
    for each in objects:
        layers = each.data.uv_layers if each.type == "MESH" else fail(f"object '{each.name}': found a {each.type}, expected a mesh")
        if options.uv and options.uv not in layers:
            fail(f"object '{each.name}': found no UV layer '{options.uv}'; there are: {', '.join(l.name for l in layers) or 'none'}")
        if not layers:
            fail(f"object '{each.name}': found no UV layer, expected one for the light map: UV > Lightmap Pack makes it")
        found[each] = options.uv or layers[min(1, len(layers) - 1)].name
    return found


class WhiteCopy:
    """Copies of the meshes in world space that only bakes see, with one material: white, or their normals as colours."""

    def __init__(self, objects, size):
        self.image = bpy.data.images.new("light map", size, size, alpha=True, float_buffer=True, is_data=True)
        material = bpy.data.materials.new("light map")
        material.use_nodes = True
        nodes, self.links = material.node_tree.nodes, material.node_tree.links
        nodes.clear()
        self.surface = nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]
        self.white, self.normal = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeEmission")
        self.white.inputs["Color"].default_value = (1, 1, 1, 1)
        geometry, scale = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeVectorMath")
        scale.operation = "MULTIPLY_ADD"  # n / 4 + 1/2
        scale.inputs[1].default_value, scale.inputs[2].default_value = (0.25,) * 3, (0.5,) * 3
        self.links.new(geometry.outputs["Normal"], scale.inputs[0])
        self.links.new(scale.outputs[0], self.normal.inputs["Color"])
        target = nodes.new("ShaderNodeTexImage")
        target.image = self.image
        nodes.active = target
        scene = bpy.context.evaluated_depsgraph_get()
        self.copies, self.frames = [], []
        for each, layer in objects.items():
            mesh = bpy.data.meshes.new_from_object(each.evaluated_get(scene))
            mesh.transform(each.matrix_world)
            if each.matrix_world.determinant() < 0:
                mesh.flip_normals()
            mesh.uv_layers.active = mesh.uv_layers[layer]
            mesh.materials.clear()
            mesh.materials.append(material)
            self.copies.append(bpy.data.objects.new(each.name + " light map", mesh))
            self.lift(mesh)
            self.frames.append(self.frames_of(mesh))
            bpy.context.scene.collection.objects.link(self.copies[-1])
            # Cycles would move places that are lit by what their normals say of the surface's curvature.
            self.copies[-1].cycles.shadow_terminator_offset = self.copies[-1].cycles.shadow_terminator_geometry_offset = 0
            for ray in ("diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
                setattr(self.copies[-1], "visible_" + ray, False)
        bpy.ops.object.select_all(action="DESELECT")
        for copy in self.copies:
            copy.select_set(True)
        bpy.context.view_layer.objects.active = self.copies[0]

    @staticmethod
    def lift(mesh):
        """Moves the vertices along their normals."""
        places, normals = (np.empty(3 * len(mesh.vertices), np.float32) for _ in range(2))
        mesh.vertices.foreach_get("co", places)
        mesh.vertices.foreach_get("normal", normals)
        corners = places.reshape(-1, 3)
        size = float((corners.max(0) - corners.min(0)).max()) if len(corners) else 0.0
        mesh.vertices.foreach_set("co", places + GAP * size * normals)
        mesh.update()

    @staticmethod
    def frames_of(mesh):
        """For each corner of a polygon two tangents and the normal of the polygon [corners, 3, 3]."""
        normals, counts = np.empty(3 * len(mesh.polygons), np.float32), np.empty(len(mesh.polygons), np.int32)
        mesh.polygons.foreach_get("normal", normals)
        mesh.polygons.foreach_get("loop_total", counts)
        normal = normals.reshape(-1, 3)
        other = np.where(np.abs(normal[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 1.0, 0]])
        tangent = np.cross(other, normal)
        tangent /= np.maximum(np.linalg.norm(tangent, axis=-1, keepdims=True), 1e-9)
        return np.repeat(np.stack([tangent, np.cross(normal, tangent), normal], 1), counts, 0)

    def inside(self):
        """True for texels whose centre lies in a triangle [height, width]: Cycles bakes some beside them too, at places off the surface."""
        size = self.image.size[0]
        covered = np.zeros((size, size), bool)
        for copy in self.copies:
            mesh = copy.data
            mesh.calc_loop_triangles()
            corners, uvs = np.empty(3 * len(mesh.loop_triangles), np.int32), np.empty(2 * len(mesh.loops), np.float32)
            mesh.loop_triangles.foreach_get("loops", corners)
            mesh.uv_layers.active.data.foreach_get("uv", uvs)
            places = (uvs.reshape(-1, 2) * [1, -1] + [0, 1]) * size - 0.5  # 0 is the centre of the upper left texel
            for a, b, c in places[corners].reshape(-1, 3, 2):
                low = np.clip(np.ceil(np.minimum(np.minimum(a, b), c)), 0, size).astype(int)
                high = np.clip(np.floor(np.maximum(np.maximum(a, b), c)) + 1, low, size).astype(int)
                area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
                if area == 0 or (high <= low).any():
                    continue
                y, x = np.mgrid[low[1]:high[1], low[0]:high[0]]
                sides = [((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) / area for p, q in ((a, b), (b, c), (c, a))]
                covered[low[1]:high[1], low[0]:high[0]] |= np.minimum(np.minimum(*sides[:2]), sides[2]) >= 0
        return covered

    def turn(self, normal):
        """Gives all faces a shading normal in the frame of each."""
        for copy, frames in zip(self.copies, self.frames):
            mesh = copy.data
            mesh.use_auto_smooth = True
            mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
            mesh.normals_split_custom_set((np.array(normal) @ frames).tolist())
            mesh.update()

    def bake(self, node, kind, **arguments):
        """The baked image [height, width, 3], the top row first."""
        self.links.new(node.outputs[0], self.surface)
        bpy.ops.object.bake(type=kind, margin=0, use_clear=True, target="IMAGE_TEXTURES", **arguments)
        pixels = np.empty(4 * self.image.size[0] * self.image.size[1], np.float32)
        self.image.pixels.foreach_get(pixels)
        return pixels.reshape(self.image.size[1], self.image.size[0], 4)[::-1, :, :3].astype(np.float64)

    def bake_normals(self):
        """World normals [height, width, 3]; zero where no face lies."""
        cycles = bpy.context.scene.cycles
        samples, cycles.samples = cycles.samples, 1
        baked = self.bake(self.normal, "EMIT")
        cycles.samples = samples
        normal = (baked - 0.5) * (baked.sum(-1, keepdims=True) > 0)
        return normal / np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-9)

    def bake_irradiance(self, seed):
        bpy.context.scene.cycles.seed = seed
        return math.pi * self.bake(self.white, "DIFFUSE", pass_filter={"DIRECT", "INDIRECT"})


def set_up_cycles(options):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples, cycles.seed = options.samples, options.seed
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_animated_seed = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0  # clamping takes energy away
    return cycles


def write_exr(file, sh, covered, normal):
    try:
        import OpenImageIO as oiio
    except ImportError:
        fail("found no Python module OpenImageIO, expected Debian's python3-openimageio")
    names = [f"sh{i:02}.{c}" for i in range(9) for c in "RGB"] + ["coverage.Y", "normal.X", "normal.Y", "normal.Z"]
    height, width = covered.shape
    texels = np.concatenate([sh.reshape(height, width, 27), covered[..., None], normal], -1).astype(np.float32)
    spec = oiio.ImageSpec(width, height, len(names), "float")
    spec.channelnames = names
    spec.attribute("compression", "zip")
    partial = file + ".partial.exr"
    output = oiio.ImageOutput.create(partial)
    if not output or not output.open(partial, spec) or not output.write_image(np.ascontiguousarray(texels)) or not output.close():
        fail(f"{file}: cannot write: {output.geterror() if output else oiio.geterror()}")
    os.replace(partial, file)


def export_mesh(file, objects):
    """Writes the meshes as GLB. The light-map UVs become the second layer, TEXCOORD_1."""
    for each, name in objects.items():
        layers = each.data.uv_layers
        if len(layers) == 1:
            layers.new(name="light map").data  # a new layer is a copy of the active one
            continue
        at = layers.find(name)
        if at == 1:
            continue
        first, second = (np.empty(2 * len(each.data.loops), np.float32) for _ in range(2))
        layers[at].data.foreach_get("uv", first)
        layers[1].data.foreach_get("uv", second)
        layers[1].data.foreach_set("uv", first)
        layers[at].data.foreach_set("uv", second)
    bpy.ops.object.select_all(action="DESELECT")
    for each in objects:
        each.select_set(True)
    bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
    bpy.ops.export_scene.gltf(filepath=file, export_format="GLB", use_selection=True, export_apply=True)


def main():
    options, start = read_options(), time.time()
    objects = find_objects(options)
    if options.mesh:
        export_mesh(options.mesh, objects)
        for each in objects:
            objects[each] = each.data.uv_layers[1].name
    set_up_cycles(options)
    white = WhiteCopy(objects, options.size)
    shading_normal = y_up(white.bake_normals())
    covered = white.inside() & (np.linalg.norm(shading_normal, axis=-1) > 0.5)
    if not covered.any():
        fail("found no texel inside the light-map UVs, expected UVs in [0, 1]")

    seeds = iter(range(options.seed, options.seed + 1000))

    def irradiance_for(normal):
        """The normal that faces have for this one in their frames, and the irradiance for it."""
        white.turn(normal)
        return y_up(white.bake_normals()), white.bake_irradiance(next(seeds))

    flat = math.sqrt(1 - LEVEL * LEVEL)
    face, along = irradiance_for((0, 0, 1))
    vector = face[..., None] * along[..., None, :]  # the integral of L(w) w [height, width, axis, channel]
    for axis in ((flat, 0), (0, flat)):
        (ahead, front), (behind, back) = (irradiance_for((sign * axis[0], sign * axis[1], LEVEL)) for sign in (1, -1))
        vector += ((ahead - behind) / 2)[..., None] * (front - back)[..., None, :]
    sh = np.zeros((options.size, options.size, 9, 3))
    normals, weights = quadrature()
    opposite = np.array([1, -1, -1, -1, 1, 1, 1, 1, 1])  # Y_i(-n) / Y_i(n)
    for k, (normal, weight) in enumerate(zip(normals, weights)):
        n, front = irradiance_for(normal)
        back = np.maximum(front - np.einsum("hwa,hwac->hwc", n, vector), 0)
        factors = weight * basis(n) / COSINE
        sh += factors[..., None] * front[..., None, :] + (factors * opposite)[..., None] * back[..., None, :]
        print(f"bake_light_map: normal {k + 1} of {len(weights)}, {time.time() - start:.0f} s", flush=True)

    # The last normal once more, from another seed: the difference is noise.
    again = white.bake_irradiance(next(seeds))
    noise, level = math.sqrt(((again - front)[covered] ** 2).mean() / 2), math.sqrt((front[covered] ** 2).mean())
    sh[..., 0, :] = np.maximum(sh[..., 0, :], 0)
    write_exr(options.output, sh * covered[..., None, None], covered.astype(np.float64), shading_normal * covered[..., None])
    print(f"bake_light_map: {options.output}: {options.size} x {options.size} texels, {covered.mean():.1%} covered, "
          f"{time.time() - start:.0f} s; noise of one of {len(weights) + 5} bakes {noise / max(level, 1e-30):.1%}")


try:
    main()
except Exception as error:  # Blender would go on and exit with code 0
    fail(f"{type(error).__name__}: {error}")
