"""A cooked scene in three.js, Babylon.js, PlayCanvas and plain OpenGL (examples/), pixel by pixel against shading on the CPU:
engines_test.py LIGHTCOOK SUITE [OPENGL_EXAMPLE]

Each suite is one test of ctest. Exit code 77: skipped, with the reason on a line of its own."""
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import time
import unittest

from viewer_test import CACHE, LIGHTCOOK, ROOT, Folder, decoded_textures, np, run, skip
import lighting
from raster import Camera, rasterize

WEB = ROOT / 'examples' / 'web'
OPENGL = pathlib.Path(sys.argv[3] if len(sys.argv) > 3 else 'absent')
ENGINES = ('three', 'babylon', 'playcanvas')
COMPRESSED = ['EXT_texture_compression_bptc', 'EXT_texture_compression_rgtc', 'WEBGL_compressed_texture_s3tc', 'EXT_texture_norm16']

if not (WEB / 'node_modules' / 'playcanvas').is_dir():
    skip('the npm packages of examples/web are missing: run ./dev setup')


class Scene(Folder):
    """A scene that is cooked with each of `layouts`, drawn by `camera`."""
    layouts = ('hdr',)
    least_share = 0.3  # of pixels inside surfaces

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.site = cls.folder / 'site'
        run('node', WEB / 'build.mjs', cls.site)
        cls.url = cls.serve(cls.site)
        cls.references = {}
        for layout in cls.layouts:
            cls.cook(layout, 'ktx2')

    @classmethod
    def cook(cls, layout, container):
        """Cooks diffuse light into a folder beside the pages. Returns its name.
        layout: its name, and after "@" its filter if that is not the usual one, or after "~" the visible error that its detail keeps"""
        name, scene = f'{layout}.{container}', cls.folder / f'{layout}.{container}.toml'
        layout, _, limit = layout.partition('~')
        layout, _, asked = layout.partition('@')
        # The error is not what is tested: it is that of the bytes, which the verifier reads as well.
        scene.write_text(f'''schema = 1
name = "scene"
[output]
container = "{container}"
light_map_layout = "{layout}"
{f'filter = "{asked}"' if asked else ''}
{f'detail = true{chr(10)}max_visible = {limit}' if limit else ''}
max_error = 1
effort = 1
gltf = {str(container == "ktx2").lower()}
[[light_map]]
name = "lightmap"
file = {json.dumps(str(cls.bake))}
mesh = {json.dumps(str(cls.mesh))}
[[material]]
name = "*"
normal_map = true
specular = false
''')
        run(LIGHTCOOK, 'cook', scene, '-o', cls.site / name, '--cache', CACHE)
        if limit:
            assert any('detail' in asset for asset in json.loads((cls.site / name / 'cooked.json').read_text())['assets'])
        return name

    def reference(self, name, mesh):
        """Rows and columns of the pixels that show the scene, and their colours [0, 255], shaded on the CPU."""
        if (name, mesh) not in self.references:
            cooked, parts = self.site / name, self.folder / 'mesh.json'
            run('node', ROOT / 'tests' / 'viewer' / 'mesh.mjs', cooked / mesh, parts)
            surfaces = rasterize(json.loads(parts.read_text()), self.camera)
            light = np.maximum(lighting.exit_radiance(self.coefficients(cooked, surfaces), surfaces.normal), 0)
            self.references[name, mesh] = surfaces.at, lighting.shown(light, 203)
        return self.references[name, mesh]

    def coefficients(self, cooked, surfaces):
        asset = next(asset for asset in json.loads((cooked / 'cooked.json').read_text())['assets'] if asset['kind'] == 'light-map')
        exr = self.folder / 'decoded.exr'
        if asset['layout'].startswith('basis') and asset['filter'] == 'hardware':
            self.assertGreater(len(np.unique(surfaces.cluster)), 1)
            return lighting.learned_sh(asset['constants'], decoded_textures(cooked, asset, exr), surfaces.uv, surfaces.cluster)
        run(LIGHTCOOK, 'reconstruct', cooked, 'lightmap', exr)
        sh = lighting.sh_of(lighting.read_exr(exr))
        if asset['filter'] == 'decoded':
            return lighting.bilinear_of_covered(sh, lighting.read_exr(self.bake)['coverage.Y'] > 0, *surfaces.uv)
        # The decode of "hdr" is linear, so that filtered coefficients are the coefficients of filtered texels.
        return lighting.bilinear(sh, *surfaces.uv)

    def mesh_of(self, name):
        return next(path.name for path in (self.site / name).glob('*_mesh.glb'))

    def draw(self, browser, engine, name, glb=''):
        """The picture that a page draws. Fails if the page logs an error or a warning."""
        c = self.camera
        query = f'cooked={name}/{glb}&eye={",".join(map(str, c.eye))}&target={",".join(map(str, c.target))}&fov={c.fov}&exposure=1&antialias=0'
        browser.open(f'{self.url}{engine}.html?{query}')
        picture = self.picture(browser.evaluate('lightcook.picture()'))
        self.assertEqual(browser.problems(), [], engine)
        return picture

    def check(self, picture, name, mesh, what):
        at, expected = self.reference(name, mesh)
        self.assertEqual(picture.shape[1::-1], self.camera.size, what)
        self.assertGreater(len(at[0]), self.least_share * picture.shape[0] * picture.shape[1], what)
        self.assert_shown(picture[at], expected, what)

    def check_engine(self, browser, engine, name, glb=''):
        with self.subTest(engine=engine, name=name, glb=glb):
            self.check(self.draw(browser, engine, name, glb), name, glb or self.mesh_of(name), engine)

    def new_browser(self):
        width, height = self.camera.size
        browser = self.browse(width=width, height=height)
        browser.resize(width, height)
        return browser

    def draw_opengl(self, name, okay=(0,), more=()):
        """Runs the OpenGL example, with `more` options, on Mesa's software rasterizer. Returns what it wrote to stderr; the picture is opengl.png."""
        if not OPENGL.is_file():
            self.skipTest('examples/opengl was not built (Debian: libegl-dev, libgl-dev)')
        c = self.camera
        options = [('--size', *c.size), ('--eye', *c.eye), ('--target', *c.target), ('--fov', c.fov)]
        done = subprocess.run([str(OPENGL), str(self.site / name), str(self.folder / 'opengl.png'), *(str(part) for option in options for part in option), *more],
                              env={**os.environ, 'LIBGL_ALWAYS_SOFTWARE': '1'}, capture_output=True, text=True)
        if 'libgl1-mesa-dri' in done.stderr:
            self.skipTest(done.stderr.strip())
        self.assertIn(done.returncode, okay, done.stderr)
        return done.stderr

    def check_opengl(self, name):
        self.draw_opengl(name)
        self.check(lighting.read_picture(self.folder / 'opengl.png'), name, self.mesh_of(name), f'OpenGL, {name}')


class Engines(Scene):
    """The scene that ships with lightcook."""
    layouts = ('hdr', 'basis-4', 'basis-4~2.5')
    bake, mesh = (ROOT / 'examples' / 'cornell' / file for file in ('cornell_lightmap.exr', 'cornell.glb'))
    camera = Camera((3.1, 3.3, 13.2), (2.7, 2.7, 2.75), 34, (240, 180))

    # Engine, folder and glTF: with the formats of the browser, and where it lacks them, decoded to halves and 8 bits. Between them, the
    # pictures cover Draco and plain meshes, manifest and glTF, and clusters in the mesh. viewer_test.py draws the layouts, and the shader
    # text is shared.
    drawn = (('three', 'hdr.ktx2', 'lightmap_scene.glb'), ('playcanvas', 'hdr.ktx2', 'lightmap_scene.glb'))
    drawn_decoded = (('babylon', 'basis-4~2.5.ktx2'),)
    drawn_by_opengl = ('basis-4.ktx2', 'basis-4~2.5.ktx2')

    def test_engines_draw_as_the_verifier_shades(self):
        browser = self.new_browser()
        for each in self.drawn:
            self.check_engine(browser, *each)
        self.check_refusals(browser)
        browser.without_extensions(COMPRESSED)
        for each in self.drawn_decoded:
            self.check_engine(browser, *each)

    def check_refusals(self, browser):
        """What is wrong with a file is one sentence on the page."""
        broken = self.site / 'broken'
        shutil.copytree(self.site / 'hdr.ktx2', broken)
        (broken / 'lightmap_sh.ktx2').write_bytes((broken / 'lightmap_sh.ktx2').read_bytes()[:100])
        with self.assertRaisesRegex(RuntimeError, 'lightmap_sh.ktx2'):
            self.draw(browser, 'playcanvas', 'broken')
        with self.assertRaisesRegex(RuntimeError, 'LIGHTCOOK_light_map'):
            self.draw(browser, 'babylon', 'hdr.ktx2', self.mesh_of('hdr.ktx2'))

    def test_opengl_draws_as_the_verifier_shades(self):
        for name in self.drawn_by_opengl:
            with self.subTest(name=name):
                self.check_opengl(name)

    def test_opengl_takes_each_texel_as_often_as_it_weighs(self):
        """--one-texel: pictures of single texels differ from the mix, and their mean comes near it."""
        name = 'basis-4.ktx2'
        at, expected = self.reference(name, self.mesh_of(name))
        is_within = expected < 250  # where no frame is clipped

        def light_of(codes):
            shown = codes[is_within] / 255
            return np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)

        light, frames = light_of(expected), []
        for count in range(1, 17):
            self.draw_opengl(name, more=('--one-texel', '--frames', str(count)))
            frames.append(light_of(lighting.read_picture(self.folder / 'opengl.png')[at]))
        error = np.mean([np.abs(frame - light).mean() for frame in frames])
        self.assertGreater(error, 0.002)
        # Measured: 0.20 of it, and 0.66 where lcQuadTexel takes the texels of two corners for each other.
        self.assertLess(np.abs(np.mean(frames, axis=0) - light).mean(), 0.35 * error)

    def test_opengl_refuses_one_texel_of_a_map_that_the_sampler_filters(self):
        self.assertRegex(self.draw_opengl('hdr.ktx2', okay=(1,), more=('--one-texel',)), '^lightcook_opengl: --one-texel: ')

    def test_opengl_refuses_a_folder_without_a_manifest(self):
        message = self.draw_opengl('absent', okay=(1,))
        self.assertRegex(message, r'^lightcook_opengl: .*cooked\.json: cannot be read\n$')
        self.assertFalse((self.folder / 'absent.png').exists())


class EnginesSoak(Engines):
    """The same for the ways that Engines leaves out, and filter "hardware" of a decode that is not linear."""
    layouts = (*Engines.layouts, 'basis-4@hardware', 'lit-half', 'lit-half~2.5')
    drawn = (('babylon', 'hdr.ktx2'), ('three', 'basis-4.ktx2'), ('babylon', 'basis-4@hardware.ktx2'), ('babylon', 'lit-half.ktx2', 'lightmap_scene.glb'), ('playcanvas', 'lit-half.ktx2'),
             ('three', 'basis-4~2.5.ktx2', 'lightmap_scene.glb'), ('babylon', 'lit-half~2.5.ktx2'), ('playcanvas', 'lit-half~2.5.ktx2', 'lightmap_scene.glb'))
    drawn_decoded = (('playcanvas', 'basis-4.ktx2'), ('three', 'basis-4@hardware.ktx2'), ('three', 'hdr.ktx2'), ('three', 'lit-half.ktx2'),
                     ('babylon', 'basis-4.ktx2'), ('playcanvas', 'basis-4~2.5.ktx2'))
    drawn_by_opengl = ('hdr.ktx2', 'hdr.dds', 'basis-4@hardware.ktx2', 'lit-half.ktx2', 'lit-half~2.5.ktx2')

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.cook('hdr', 'dds')


def write_glb(path, nodes, positions, normals, uvs, indices):
    """Writes a mesh that each of `nodes` with "mesh": 0 shows. The first node is the root. uvs are those of the light map."""
    arrays = [np.array(values, kind) for values, kind in ((positions, '<f4'), (normals, '<f4'), (uvs, '<f4'), (indices, '<u4'))]
    starts = np.cumsum([0] + [array.nbytes for array in arrays])
    accessors = [{'bufferView': i, 'componentType': 5125 if i == 3 else 5126, 'count': array.size if i == 3 else len(array),
                  'type': ('VEC3', 'VEC3', 'VEC2', 'SCALAR')[i]} for i, array in enumerate(arrays)]
    accessors[0].update(min=arrays[0].min(0).tolist(), max=arrays[0].max(0).tolist())
    attributes = {'POSITION': 0, 'NORMAL': 1, 'TEXCOORD_0': 2, 'TEXCOORD_1': 2}
    document = {'asset': {'version': '2.0'}, 'scene': 0, 'scenes': [{'nodes': [0]}], 'nodes': nodes,
                'meshes': [{'primitives': [{'attributes': attributes, 'indices': 3}]}], 'accessors': accessors,
                'bufferViews': [{'buffer': 0, 'byteOffset': int(start), 'byteLength': array.nbytes} for start, array in zip(starts, arrays)],
                'buffers': [{'byteLength': int(starts[-1])}]}
    path.write_bytes(glb_of(document, b''.join(array.tobytes() for array in arrays)))


def glb_of(document, binary):
    """Binary glTF of a JSON chunk and a binary one."""
    text = json.dumps(document).encode()
    text += b' ' * (-len(text) % 4)
    chunks = struct.pack('<2I', len(text), 0x4e4f534a) + text + struct.pack('<2I', len(binary), 0x4e4942) + binary
    return struct.pack('<3I', 0x46546c67, 2, 12 + len(chunks)) + chunks


class EnginesMaps(Scene):
    """Two light maps, each with a mesh. Two nodes share the mesh of one; the child of them mirrors, and shears by the uneven scale of its
    parent."""
    camera = Camera((0, 0, 4), (0, 0, 0), 40, (320, 240))
    layouts = ()
    least_share = 0.1
    nodes = {
        'left': [{'name': 'upper', 'mesh': 0, 'children': [1], 'translation': [-0.9, 0.6, 0], 'scale': [1.4, 0.8, 1]},
                 {'name': 'lower', 'mesh': 0, 'translation': [0, -1.6, 0.2], 'rotation': [0, 0, float(np.sin(0.2)), float(np.cos(0.2))],
                  'scale': [-1, 1, 1]}],
        'right': [{'name': 'right', 'mesh': 0, 'translation': [0.9, 0, 0], 'scale': [1.2, 2, 1]}],
    }

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
        normals = np.column_stack([0.3 * corners, np.ones(4)])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        y, x = np.mgrid[0:16, 0:16] / 15
        maps = []
        for i, (name, nodes) in enumerate(cls.nodes.items()):
            write_glb(cls.folder / f'{name}.glb', nodes, np.column_stack([corners, np.zeros(4)]), normals, np.array([0.5, 0.5]) + corners * [1, -1],
                      [0, 1, 2, 0, 2, 3])
            light = {f'sh{k:02d}.{c}': np.zeros((16, 16), np.float32) for k in range(9) for c in 'RGB'}
            for c, colour in zip('RGB', ((0.9, 0.4, 0.1), (0.1, 0.5, 0.8))[i]):
                light[f'sh00.{c}'] += (colour * (0.5 + x + (1 - y) * i)).astype(np.float32)
                light[f'sh03.{c}'] += (0.4 * colour * y).astype(np.float32)
            lighting.write_exr(cls.folder / f'{name}.exr', {**light, 'coverage.Y': np.ones((16, 16), np.float32)})
            maps.append(f'[[light_map]]\nname = "{name}"\nfile = "{name}.exr"\nmesh = "{name}.glb"\n')
        scene = cls.folder / 'maps.toml'
        scene.write_text('schema = 1\nname = "maps"\n[output]\nlight_map_layout = "hdr"\nmax_error = 1\neffort = 1\ngltf = true\n' + ''.join(maps) +
                         '[[material]]\nname = "*"\nnormal_map = true\nspecular = false\n')
        run(LIGHTCOOK, 'cook', scene, '-o', cls.site / 'maps', '--cache', CACHE)

    def parts(self, file):
        run('node', ROOT / 'tests' / 'viewer' / 'mesh.mjs', file, self.folder / 'mesh.json')
        return json.loads((self.folder / 'mesh.json').read_text())

    def expect(self, parts, maps):
        """Adds what the pixels show to the references. parts: of each of `maps`."""
        sh = []
        for each, name in zip(parts, maps):
            for part in each:
                part['clusters'] = [len(sh)] * (len(part['positions']) // 3)
            run(LIGHTCOOK, 'reconstruct', self.site / 'maps', name, self.folder / 'decoded.exr')
            sh.append(lighting.sh_of(lighting.read_exr(self.folder / 'decoded.exr')))
        surfaces = rasterize([part for each in parts for part in each], self.camera)
        coefficients = np.array([lighting.bilinear(image, *surfaces.uv) for image in sh])[surfaces.cluster.astype(int), np.arange(len(surfaces.cluster))]
        return surfaces.at, lighting.shown(np.maximum(lighting.exit_radiance(coefficients, surfaces.normal), 0), 203)

    def test_each_mesh_has_the_light_of_its_own_map(self):
        maps = {asset['light_map']: asset['file'] for asset in json.loads((self.site / 'maps' / 'cooked.json').read_text())['assets'] if asset['kind'] == 'mesh'}
        self.assertEqual(sorted(maps), sorted(self.nodes))
        self.references['maps', ''] = self.expect([self.parts(self.site / 'maps' / file) for file in maps.values()], maps)
        browser = self.new_browser()
        for engine in ENGINES:
            with self.subTest(engine=engine):
                self.check(self.draw(browser, engine, 'maps'), 'maps', '', engine)

    def test_opengl_draws_back_faces_of_double_sided_materials_alone(self):
        original = (self.folder / 'left.glb').read_bytes()
        end = 20 + int.from_bytes(original[12:16], 'little')
        for is_double_sided in (False, True):
            name = 'both' if is_double_sided else 'front'
            document = json.loads(original[20:end])
            document['materials'] = [{'doubleSided': is_double_sided}]
            document['meshes'][0]['primitives'][0]['material'] = 0
            document['nodes'] = [{'mesh': 0, 'rotation': [0, 1, 0, 0]}]  # the back to the camera
            document['scenes'] = [{'nodes': [0]}]
            (self.folder / f'{name}.glb').write_bytes(glb_of(document, original[end + 8:]))
            scene = self.folder / f'{name}.toml'
            scene.write_text(f'schema = 1\nname = "{name}"\n[output]\nlight_map_layout = "hdr"\nmax_error = 1\neffort = 1\n'
                             f'[[light_map]]\nname = "left"\nfile = "left.exr"\nmesh = "{name}.glb"\n')
            run(LIGHTCOOK, 'cook', scene, '-o', self.site / name, '--cache', CACHE)
            with self.subTest(is_double_sided=is_double_sided):
                self.draw_opengl(name)
                self.assertEqual(bool(lighting.read_picture(self.folder / 'opengl.png').any()), is_double_sided)

    def test_each_node_has_its_own_place_in_the_light_map(self):
        """coordinateScaleBias of nodes that share a geometry: each shows another half of the map."""
        file = self.site / 'maps' / 'left_scene.glb'
        data = file.read_bytes()
        end = 20 + int.from_bytes(data[12:16], 'little')
        document = json.loads(data[20:end])
        places = {'upper': [0.5, 1, 0, 0], 'lower': [0.5, 0.5, 0.5, 0.5]}
        for node in document['nodes']:
            node['extensions']['LIGHTCOOK_light_map']['coordinateScaleBias'] = places[node['name']]
        halves = self.site / 'maps' / 'halves.glb'
        halves.write_bytes(glb_of(document, data[end + 8:]))
        parts = self.parts(halves)
        self.assertEqual(sorted(part['node'] for part in parts), sorted(places))
        for part in parts:
            su, sv, bu, bv = places[part['node']]
            part['uvs'] = (np.array(part['uvs']).reshape(-1, 2) * [su, sv] + [bu, bv]).tolist()
        self.references['maps', 'halves.glb'] = self.expect([parts], ['left'])
        browser = self.new_browser()
        for engine in ENGINES:
            with self.subTest(engine=engine):
                self.check(self.draw(browser, engine, 'maps', 'halves.glb'), 'maps', 'halves.glb', engine)


class EnginesMips(Scene):
    """Filter "decoded" with mip levels: a checkerboard of texels, two of which fit into a pixel, is grey. Without them a pixel shows one texel."""
    # A square of side 1 has 32 pixels, whose centres are those of texels.
    camera = Camera((1 / 128, 1 / 128, 120 / np.tan(np.radians(20)) / 32), (1 / 128, 1 / 128, 0), 40, (320, 240))
    layouts = ()

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
        write_glb(cls.folder / 'square.glb', [{'mesh': 0}], np.column_stack([corners, np.zeros(4)]), np.tile([0, 0, 1], (4, 1)),
                  np.array([0.5, 0.5]) + corners * [1, -1], [0, 1, 2, 0, 2, 3])
        y, x = np.mgrid[0:64, 0:64]
        light = {f'sh{k:02d}.{c}': np.zeros((64, 64), np.float32) for k in range(9) for c in 'RGB'}
        for c in 'RGB':
            light[f'sh00.{c}'] = np.where((x + y) % 2 == 0, 0.1, 1.9).astype(np.float32)
        lighting.write_exr(cls.folder / 'square.exr', {**light, 'coverage.Y': np.ones((64, 64), np.float32)})
        for layout in ('hdr', 'lit-half', 'basis-4'):
            scene = cls.folder / f'{layout}.toml'
            scene.write_text(f'schema = 1\nname = "mips"\n[output]\nlight_map_layout = "{layout}"\nfilter = "decoded"\nmips = true\nmax_error = 10\neffort = 1\n'
                             '[[light_map]]\nname = "square"\nfile = "square.exr"\nmesh = "square.glb"\n[[material]]\nname = "*"\nnormal_map = true\nspecular = false\n')
            run(LIGHTCOOK, 'cook', scene, '-o', cls.site / layout, '--cache', CACHE)

    def test_levels_are_decoded_and_mixed(self):
        browser = self.new_browser()
        for engine, layout in (('three', 'hdr'), ('babylon', 'lit-half'), ('playcanvas', 'hdr'), ('three', 'basis-4')):
            with self.subTest(engine=engine, layout=layout):
                self.check_grey(self.draw(browser, engine, layout))

    def test_opengl_decodes_and_mixes_levels(self):
        for layout in ('lit-half', 'basis-4'):
            with self.subTest(layout=layout):
                self.draw_opengl(layout)
                self.check_grey(lighting.read_picture(self.folder / 'opengl.png'))

    def check_grey(self, picture):
        grey = lighting.shown(np.sqrt(1 / np.pi) / 2, 203)
        self.assertLess(np.abs(picture[108:132, 148:172].astype(float) - grey).max(), 6, 'grey')
        self.assertEqual(picture[60, 60].max(), 0, 'beside the square')


class GuideSoak(Folder):
    """The programs of docs/guide/into-an-engine.md, as they are copied: on the example, all three engines show the same picture."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.guide = (ROOT / 'docs' / 'guide' / 'into-an-engine.md').read_text()
        cls.site = cls.folder / 'site'
        cls.site.mkdir()
        run(LIGHTCOOK, 'cook', ROOT / 'examples' / 'cornell' / 'scene.toml', '-o', cls.site / 'cooked', '--effort', 0, '--cache', CACHE)
        modules = cls.site / 'node_modules'
        modules.mkdir()
        for package in (WEB / 'node_modules').iterdir():
            (modules / package.name).symlink_to(package)
        (modules / 'lightcook-loaders').symlink_to(ROOT / 'viewer' / 'loaders')
        (cls.site / 'draco').symlink_to(WEB / 'node_modules' / 'three' / 'examples' / 'jsm' / 'libs' / 'draco' / 'gltf')
        cls.url = cls.serve(cls.site)

    def block(self, heading, language):
        section = self.guide.split(f'\n## {heading}\n')[1].split('\n## ')[0]
        return section.split(f'```{language}\n')[1].split('\n```')[0]

    def show(self, browser, name):
        """The picture of a page, once it shows the scene."""
        browser.show(f'{self.url}{name}.html')
        deadline = time.monotonic() + 60
        while True:
            browser.settle()
            (self.folder / 'page.png').write_bytes(browser.screenshot())
            picture = lighting.read_picture(self.folder / 'page.png').astype(float)
            if np.ptp(picture[100:200, 150:250]) > 40 or time.monotonic() > deadline:
                self.assertEqual(browser.problems(), [], name)
                return picture

    def test_programs_of_the_guide_show_the_scene(self):
        browser = self.browse()
        browser.resize(400, 300)
        page = self.block('three.js', 'html')
        (self.site / 'main.js').write_text(self.block('three.js', 'js'))
        (self.site / 'three.html').write_text(page)
        expected = self.show(browser, 'three')
        inside = (slice(80, 220), slice(130, 270))
        # The map in the mean is middle grey, under the curve of sRGB.
        self.assertLess(abs(expected[inside].mean() - 255 * 0.46), 45)
        for heading, name in (('Babylon.js', 'babylon'), ('PlayCanvas', 'playcanvas')):
            (self.site / f'{name}_main.js').write_text(self.block(heading, 'js'))
            run('node', WEB / 'node_modules' / 'esbuild' / 'bin' / 'esbuild', self.site / f'{name}_main.js', '--bundle', '--format=esm', '--preserve-symlinks',
                '--external:node:*', '--log-level=error', f'--outfile={self.site / name}.js')
            (self.site / f'{name}.html').write_text(page.replace('src="main.js"', f'src="{name}.js"'))
            with self.subTest(engine=name):
                self.assertLess(np.mean(np.abs(self.show(browser, name)[inside] - expected[inside])), 12)


class TypesSoak(unittest.TestCase):
    """Ten seconds for the declarations of two engines."""

    def test_the_loaders_have_no_errors_of_types(self):
        run('node', ROOT / 'viewer' / 'node_modules' / 'typescript' / 'bin' / 'tsc', '--project', ROOT / 'viewer' / 'tsconfig.engines.json')


class OutdoorSoak(Scene):
    """A large scene of the shared data."""
    bake, mesh = (ROOT.parent / 'shared' / 'data' / 'scenes' / f'outdoor{end}' for end in ('_lightmap.exr', '.glb'))
    camera = Camera((9, 5, 12), (0, 0.5, 0), 40, (480, 360))

    @classmethod
    def setUpClass(cls):
        if not cls.mesh.is_file():
            skip(f'{cls.mesh.name} is absent')
        super().setUpClass()

    def test_engines_draw_as_the_verifier_shades(self):
        browser = self.new_browser()
        for engine in ENGINES:
            self.check_engine(browser, engine, 'hdr.ktx2')

    def test_opengl_draws_as_the_verifier_shades(self):
        self.check_opengl('hdr.ktx2')


if __name__ == '__main__':
    unittest.main(argv=[sys.argv[0], sys.argv[2]], verbosity=2)
