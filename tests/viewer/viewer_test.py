"""The page of lightcook view in a headless Chromium, and the loaders for three.js: viewer_test.py LIGHTCOOK SUITE

Each suite is one test of ctest. Exit code 77: skipped, with the reason on a line of its own."""
import base64
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
VIEWER = ROOT / 'viewer'


def skip(reason):
    print(f'skipped: viewer: {reason}')
    sys.exit(77)


if not shutil.which('node') or not (VIEWER / 'node_modules' / 'three').is_dir():
    skip('the npm packages of viewer/ are missing: run ./dev setup')
try:
    import numpy as np
    import OpenImageIO
except ImportError:
    skip('python3-numpy or python3-openimageio is missing')

from browser import Browser, serve  # noqa: E402
from export import export  # noqa: E402
import lighting  # noqa: E402
from lighting import SpecularTables  # noqa: E402

LIGHTCOOK = sys.argv[1] if len(sys.argv) > 1 else 'lightcook'
CACHE = pathlib.Path(LIGHTCOOK).resolve().parent / 'test_cache'  # that of the other tests
LAYOUTS = re.findall(r'^  "([a-z0-9-]+)": (?:\{|basis|lit)', (VIEWER / 'loaders' / 'core' / 'light_map.js').read_text(), re.M)
BAKE = ROOT / 'examples' / 'cornell' / 'cornell_lightmap.exr'


def run(*command, okay=(0,)):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode not in okay:
        raise AssertionError(f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def decoded_textures(cooked, asset, exr):
    """First layers of the textures of an asset, decoded by the verifier: [height, width, 4] by role. exr: a temporary file."""
    images = {}
    for texture in asset['textures']:
        run(LIGHTCOOK, 'decode', cooked / texture['file'], exr)
        channels = lighting.read_exr(exr)
        images[texture['role']] = np.stack([channels.get(c, np.zeros_like(channels['R'])) for c in 'RGBA'], -1).astype(np.float64)
    return images


class Folder(unittest.TestCase):
    """A suite with a folder of its own, which is removed at the end."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix='lightcook-viewer-test-'))
        cls.addClassCleanup(shutil.rmtree, cls.folder, True)

    @classmethod
    def serve(cls, folder):
        server, url = serve(folder)
        cls.addClassCleanup(server.server_close)
        cls.addClassCleanup(server.shutdown)
        return url

    @classmethod
    def browse(cls, **options):
        if not shutil.which('chromium'):
            skip('chromium is not installed')
        browser = Browser(**options)
        cls.addClassCleanup(browser.close)
        return browser

    def assert_shown(self, found, expected, what, codes=1):
        """99.9 % of the values within 1/255, or `codes` (both in [0, 255], before rounding), and no picture of one colour."""
        self.assertGreater(np.ptp(expected), 20, what)
        share = np.mean(np.abs(np.asarray(found, float) - expected) <= codes)
        self.assertGreaterEqual(share, 0.999, what)

    def picture(self, url):
        """A PNG as a data: URL, as [height, width, 3]."""
        (self.folder / 'canvas.png').write_bytes(base64.b64decode(url.split(',')[1]))
        return lighting.read_picture(self.folder / 'canvas.png')

    @classmethod
    def bundle(cls):
        dist = cls.folder / 'dist'
        run('node', VIEWER / 'build.mjs', dist)
        return dist


class Decoders(Folder):
    """The decoders for browsers without a format, against those of the verifier."""

    def decoded(self, files):
        """Decodes KTX2 files in Node. Returns [height, width, 4] of each."""
        pairs = [part for file in files for part in (file, file.with_suffix('.bin'))]
        run('node', HERE / 'decode.mjs', *pairs)
        return [np.fromfile(file.with_suffix('.bin'), '<f4') for file in files]

    def check(self, files, tolerance=0.0):
        for file, ours in zip(files, self.decoded(files)):
            run(LIGHTCOOK, 'decode', file, file.with_suffix('.exr'))
            theirs = lighting.read_exr(file.with_suffix('.exr'))
            height, width = next(iter(theirs.values())).shape
            ours = ours.reshape(height, width, 4)
            self.assertGreater(np.ptp(theirs['R']), 0.1, file.name)
            for i, channel in enumerate('RGBA'):
                if channel in theirs:
                    difference = np.abs(ours[:, :, i].astype(np.float64) - theirs[channel])
                    self.assertLessEqual(np.max(difference), tolerance, f'{file.name} {channel}')

    @classmethod
    def setUpClass(cls):
        """Encodes a picture in every format. Its 1024 blocks are what the other test replaces."""
        super().setUpClass()
        random = np.random.default_rng(7)
        y, x = np.mgrid[0:125, 0:127]  # no multiples of a block
        waves = {c: (0.5 + 0.4 * np.sin(x / (3 + i)) * np.cos(y / (5 - i)) + 0.1 * random.random(x.shape)).astype(np.float32) for i, c in enumerate('RGBA')}
        cls.picture = cls.folder / 'picture.exr'
        lighting.write_exr(cls.picture, {c: np.clip(v, 0, 1) for c, v in waves.items()})
        for name in cls.formats:
            run(LIGHTCOOK, 'encode', cls.picture, cls.folder / f'{name}.ktx2', '--format', name, '--effort', 3)

    formats = ('bc1', 'bc3', 'bc4', 'bc4-snorm', 'bc5', 'bc5-snorm', 'bc6h-uf16', 'bc6h-sf16', 'bc7', 'r16-unorm', 'rg16-unorm', 'rgba16-unorm')

    def test_encoded_pictures(self):
        exact, close = [], []
        for name in self.formats:
            (exact if name.startswith('bc6h') else close).append(self.folder / f'{name}.ktx2')
        run(LIGHTCOOK, 'encode', self.picture, self.folder / 'zstd.ktx2', '--format', 'bc7', '--zstd', '--effort', 0)
        self.check(exact)
        self.check(close + [self.folder / 'zstd.ktx2'], 2e-7)

    def test_random_blocks_of_every_mode(self):
        random = np.random.default_rng(11)
        exact, close = [], []
        for name in ('bc6h-uf16', 'bc6h-sf16', 'bc7', 'bc4', 'bc4-snorm', 'bc5', 'bc5-snorm', 'bc1'):
            file = self.folder / f'random_{name}.ktx2'
            data = bytearray((self.folder / f'{name}.ktx2').read_bytes())
            size = 1024 * (8 if name in ('bc4', 'bc4-snorm', 'bc1') else 16)
            blocks = random.integers(0, 256, size, np.uint8)
            if name == 'bc7':  # modes by a unary code: as many of each
                for block in range(1024):
                    blocks[16 * block] = (blocks[16 * block] << (block % 9)) & 255 if block % 9 == 8 else ((blocks[16 * block] | 1) << (block % 8)) & 255
            if name == 'bc4-snorm':  # -128 and -127 both mean -1, and differ in the mode that their order chooses
                blocks[:16] = [0x81, 0x80] + 6 * [0xff] + [0x80, 0x81] + 6 * [0xff]
            data[-size:] = blocks.tobytes()
            file.write_bytes(data)
            (exact if name.startswith('bc6h') else close).append(file)
        self.check(exact)
        self.check(close, 2e-7)


def shading_points(width, height, count, seed):
    """Random places [texels], half of them centres, and unit normals and views in one hemisphere."""
    random = np.random.default_rng(seed)
    places = random.integers(2, [width - 2, height - 2], (count, 2)).astype(float)
    normals = random.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    views = normals + 0.9 * random.normal(size=(count, 3))
    views *= np.sign(np.sum(views * normals, 1, keepdims=True))
    views /= np.linalg.norm(views, axis=1, keepdims=True)
    return places, normals, views


class PageSuite(Folder):
    def shade(self, name, places, normals, views):
        """The page's values, as arrays by name."""
        values = self.browser.evaluate(f'lightcook.shade({json.dumps(name)}, {places.tolist()}, {normals.tolist()}, {views.tolist()})')
        return {key: np.array([value[key] for value in values]) for key in values[0]}


class LayoutsSoak(PageSuite):
    """Every layout, learned and not, on a light map without a mesh: places between texels and texel centres, against reconstruct."""

    # After "~": the visible error that detail keeps.
    cases = [*((layout, 'bc') for layout in LAYOUTS), ('ratio', 'float'), ('halo3', 'float'),
             ('basis-8~1.35', 'bc'), ('basis-4~0.8', 'float'), ('lit-quarter~1.8', 'bc')]
    decoded_here = ('basis-3', 'halo3', 'unreal-hq')
    products = {'halo3': 32, 'unreal': 8}  # beginnings of layouts whose textures are BC3, and codes that a device may be off

    def test_every_layout_is_decoded_as_reconstruct_does(self):
        # Most texels of charts; and, for filter "decoded" and for detail, rims of charts. There, sides of the smallest texture of lit-quarter are no multiples
        # of 4, which WebGL2 takes in no BC format.
        self.write_window('map', 48, 1)
        self.write_window('rims', 40, 0.8)
        dist = self.bundle()
        self.browser = self.browse(width=500, height=900)
        for layout, target in self.cases:
            with self.subTest(layout=layout, target=target):
                # A device may round the palettes of S3TC to 8 bits, which halo3 and unreal-hq multiply.
                codes = next((codes for name, codes in self.products.items() if layout.startswith(name) and target == 'bc'), 1)
                self.check_layout(layout, target, dist, codes)
        if self.decoded_here:
            self.browser.without_extensions(['WEBGL_compressed_texture_s3tc'])
        for layout in self.decoded_here:
            with self.subTest(layout=layout, decoder='JavaScript'):
                self.check_layout(layout, 'bc', dist, 1)

    def write_window(self, name, size, share):
        """Writes a square of the bake, about `share` of whose texels lie in charts."""
        channels = lighting.read_exr(BAKE)
        covered = channels['coverage.Y'] > 0
        places = [(y, x) for y in range(0, 256 - size, 16) for x in range(0, 256 - size, 16)]
        top, left = min(places, key=lambda at: abs(covered[at[0]:at[0] + size, at[1]:at[1] + size].mean() - share))
        lighting.write_exr(self.folder / f'{name}.exr', {name: values[top:top + size, left:left + size] for name, values in channels.items()}, 'half')

    def check_layout(self, layout, target, dist, codes):
        source = 'rims' if layout.startswith('lit') or '~' in layout else 'map'
        window = lighting.read_exr(self.folder / f'{source}.exr')
        bake, inside = lighting.sh_of(window), window['coverage.Y'] > 0
        name = f'{layout}.{target}'
        layout, _, limit = layout.partition('~')
        scene, cooked, site = self.folder / f'{name}.toml', self.folder / name, self.folder / f'{name}.site'
        scene.write_text(f'''schema = 1
name = "layouts"
[output]
target = "{target}"
light_map_layout = "{layout}"
max_error = 10
{f'detail = true{chr(10)}max_visible = {limit}' if limit else ''}
{'' if target == 'float' else 'effort = 1'}
[[light_map]]
name = "map"
file = "{source}.exr"
[[material]]
name = "*"
normal_map = {str(not layout.startswith('flat')).lower()}
specular = false
''')
        run(LIGHTCOOK, 'cook', scene, '-o', cooked, '--cache', CACHE)
        self.assertEqual('detail' in json.loads((cooked / 'cooked.json').read_text())['assets'][0], bool(limit))
        run(LIGHTCOOK, 'reconstruct', cooked, 'map', self.folder / 'fine.exr', '--supersample', 2)
        if not site.exists():
            export(LIGHTCOOK, cooked, site, dist)
        self.browser.open(self.serve(site) + '#mode=cooked')
        nits = json.loads((site / 'viewer/scene.json').read_text())['light_maps'][0]['display']['nits']
        height, width = inside.shape
        fine = lighting.sh_of(lighting.read_exr(self.folder / 'fine.exr'))
        places, normals, views = shading_points(width, height, 600, 3)
        # Places of the finer grid, and those of them that lie among covered texels.
        grid = (2 * places + np.random.default_rng(5).integers(0, 2, places.shape)).astype(int)
        if source == 'rims':
            # Where no texel is covered there is no light: the four may have several clusters, of which the shader takes one.
            is_lit = lighting.bilinear(inside.astype(float), (grid[:, 0] + 0.5) / 2 / width, (grid[:, 1] + 0.5) / 2 / height) > 0
            self.check_filter_decoded(layout, grid[is_lit], fine, normals[is_lit], views[is_lit])
        around = np.array([inside[max(y // 2 - 1, 0):y // 2 + 2, max(x // 2 - 1, 0):x // 2 + 2].all() for x, y in grid])
        grid, normals, views = grid[around], normals[around], views[around]
        self.assertGreater(len(grid), 100)
        values = self.shade('map', (grid + 0.5) / 2 - 0.5, normals, views)
        expected = fine[grid[:, 1], grid[:, 0]]
        if layout == 'flat':
            light = np.maximum(np.sqrt(1 / np.pi) / 2 * expected[:, 0], 0)
        else:
            light = np.maximum(lighting.exit_radiance(expected, normals), 0)
            scale = np.abs(expected).max()
            # A device may round the palettes of BC1 and BC3 to 8 bits.
            tolerance = 1e-2 if layout.startswith(tuple(self.products)) or layout == 'basis-3' else 2e-3
            self.assertLess(np.quantile(np.abs(values['cooked'] - expected), 0.999) / scale, tolerance, 'coefficients')
        self.assert_shown(255 * values['cookedShown'], lighting.shown(light, nits), 'cooked', codes)
        # The float bake: filtered between texels, all of which are covered here.
        u, v = (grid[:, 0] + 0.5) / 2 / width, (grid[:, 1] + 0.5) / 2 / height
        reference = np.maximum(lighting.exit_radiance(lighting.bilinear(bake, u, v), normals), 0)
        self.assert_shown(255 * values['referenceShown'], lighting.shown(reference, nits), 'reference')
        error = lighting.visible_error(values['referenceLight'], values['cookedLight'], nits, 0.5)
        self.assertLess(np.max(np.abs(values['error'] - error) / (1 + error)), 0.05, 'visible error')
        self.assertEqual(self.browser.problems(), [])
        for absent in ('#glossy', '#dominant', '#diffuse', '#seams', '#memory-none', *(() if layout.startswith('lit') else ('#light',))):
            self.assertFalse(self.browser.evaluate(f'!!document.querySelector("{absent}")'), absent)
        self.assertEqual(self.browser.evaluate('[...document.querySelectorAll("#overlay option")].map((o) => o.value).includes("clusters")'), 'basis' in layout)

    def check_filter_decoded(self, layout, grid, fine, normals, views):
        """At rims of charts, too, the light is that of covered texels. The page's control dims the light that the layout stores apart."""
        places, expected = (grid + 0.5) / 2 - 0.5, fine[grid[:, 1], grid[:, 0]]
        scale = np.abs(expected).max()
        self.assertLess(np.abs(self.shade('map', places, normals, views)['cooked'] - expected).max() / scale, 2e-3, 'coefficients')
        if not layout.startswith('lit'):
            return
        dimmed = []
        for light in (0, 0.5, 1):
            self.browser.evaluate(f'lightcook.page.changed({{ light: {light} }})')
            self.assertEqual(self.browser.evaluate('document.querySelector("#light").value'), str(light))
            dimmed.append(self.shade('map', places, normals, views)['cooked'])
        self.assertLess(np.abs(dimmed[2] - expected).max() / scale, 2e-3, 'coefficients as baked')
        self.assertLess(np.abs((dimmed[0] + dimmed[2]) / 2 - dimmed[1]).max() / scale, 1e-5, 'half of the light')
        self.assertGreater(np.abs(dimmed[2] - dimmed[0]).max() / scale, 0.1, 'no light')


    def test_the_most_textures_of_a_map_fit_the_units_of_webgl(self):
        """A learned layout with residual, index and detail, beside dominant light, tables, probe and float bake: sixteen textures."""
        example = ROOT / 'examples' / 'cornell'
        scene, cooked, site = self.folder / 'most.toml', self.folder / 'most', self.folder / 'most.site'
        scene.write_text(f'''schema = 1
name = "most"
[output]
light_map_layout = "basis-8"
detail = true
max_visible = 6
max_error = 0.5
max_converter_error = 1
effort = 0
[[light_map]]
name = "map"
file = {json.dumps(str(BAKE))}
dominant_layout = "full"
[[probe]]
name = "probe"
file = {json.dumps(str(example / 'cornell_probe0.exr'))}
[[material]]
name = "*"
normal_map = true
specular = true
m = [0.1, 0.5]
f0 = [0.04, 0.6]
''')
        run(LIGHTCOOK, 'cook', scene, '-o', cooked, '--cache', CACHE)
        run(LIGHTCOOK, 'reconstruct', cooked, 'map', self.folder / 'fine.exr', '--supersample', 2)
        export(LIGHTCOOK, cooked, site, self.bundle())
        self.browser = self.browse(width=500, height=900)
        self.browser.open(self.serve(site) + '#mode=cooked')
        fine = lighting.sh_of(lighting.read_exr(self.folder / 'fine.exr'))
        places, normals, views = shading_points(256, 256, 300, 3)
        grid = (2 * places + np.random.default_rng(5).integers(0, 2, places.shape)).astype(int)
        # Where no texel is covered there is no light: the four may have several clusters, of which the shader takes one.
        covered = (lighting.read_exr(BAKE)['coverage.Y'] > 0).astype(float)
        is_lit = lighting.bilinear(covered, *((grid + 0.5) / 512).T) > 0
        grid, normals, views = grid[is_lit], normals[is_lit], views[is_lit]
        self.assertGreater(len(grid), 200)
        found, expected = self.shade('map', (grid + 0.5) / 2 - 0.5, normals, views)['cooked'], fine[grid[:, 1], grid[:, 0]]
        self.assertLess(np.abs(found - expected).max() / np.abs(expected).max(), 2e-3)
        units = self.browser.evaluate("""(() => {
            const { renderer } = lightcook.page.view, gl = lightcook.page.view.gl(), kinds = [gl.SAMPLER_2D, gl.SAMPLER_2D_ARRAY, gl.SAMPLER_CUBE];
            const typesOf = ({ program }) => [...Array(gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS)).keys()].map((i) => gl.getActiveUniform(program, i).type);
            return renderer.info.programs.map((program) => typesOf(program).filter((type) => kinds.includes(type)).length);
        })()""")
        self.assertEqual(units, [16, 16], 'of the surface and of single places')
        self.assertEqual(self.browser.problems(), [])


class Layouts(LayoutsSoak):
    """The same for a learned layout, floats of one by formula, and filter "decoded". The soak has the others, and the formats that JavaScript decodes: here Controls
    has these."""

    cases = [('basis-4', 'bc'), ('ratio', 'float'), ('lit-half', 'bc'), ('basis-4~1.6', 'bc'), ('lit-half~1.6', 'bc')]
    decoded_here = ()
    test_the_most_textures_of_a_map_fit_the_units_of_webgl = None  # in the soak

    def test_every_layout_of_the_table_is_known(self):
        self.assertGreaterEqual(len(LAYOUTS), 17)
        known = re.findall(r'^\| `([a-z0-9-]+)` \|', (ROOT / 'docs/reference/light-map-layouts.md').read_text(), re.M)
        refused = {'rnm'}  # by name: its decode needs the tangents of a mesh
        self.assertEqual(set(known), set(LAYOUTS) | refused)


class SceneSuite(PageSuite):
    """The example, cooked once: `options` of cook, shown in a browser of 840 x 480."""
    options = ()
    max_error = 0.1
    scene = ROOT / 'examples' / 'cornell' / 'scene.toml'

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser = cls.browse(width=840, height=480)
        cls.cooked, cls.site = cls.folder / 'cooked', cls.folder / 'site'
        run(LIGHTCOOK, 'cook', cls.scene, '-o', cls.cooked, '--max-error', cls.max_error, '--max-converter-error', 1, '--effort', 0, '--cache', CACHE,
            *cls.options)
        export(LIGHTCOOK, cls.cooked, cls.site, cls.bundle())
        cls.url = cls.serve(cls.site)
        cls.manifest = json.loads((cls.cooked / 'cooked.json').read_text())
        cls.data = json.loads((cls.site / 'viewer/scene.json').read_text())['light_maps'][0]
        cls.nits, cls.black = cls.data['display']['nits'], cls.data['display']['black']
        cls.report = json.loads((cls.cooked / 'report.json').read_text())
        channels = lighting.read_exr(BAKE)
        cls.bake, cls.covered = lighting.sh_of(channels), channels['coverage.Y'] > 0
        cls.seen = {}
        cls.browser.resize(840, 480)
        cls.browser.open(cls.url)

    def setUp(self):
        self.reset()

    def tearDown(self):
        self.assertEqual(self.browser.problems(), [])

    def asset(self, kind):
        return next(asset for asset in self.manifest['assets'] if asset['kind'] == kind)

    def worst_places(self):
        """Places of the report, the worst first, with the light that errs: of a scene that passed."""
        row = next(asset for asset in self.report['assets'] if asset['kind'] == 'light-map')
        error = row['stages'][-1]['error']
        places = [{'what': what, 'visible': error[what]['visible']['max'], **error[what]['visible']['max_at']} for what in ('diffuse', 'specular')]
        places += [{'what': 'diffuse', **place} for place in row['preview']['worst'] if place['texel'] != places[0]['texel']]
        return sorted(places, key=lambda place: -place['visible'])

    def textures(self, asset):
        return decoded_textures(self.cooked, asset, self.folder / 'texture.exr')

    def reset(self, hash=''):
        self.browser.evaluate(f'(history.replaceState(null, "", "#" + {json.dumps(hash)}), dispatchEvent(new HashChangeEvent("hashchange")))')
        self.browser.settle()

    def state(self, key):
        return self.browser.evaluate(f'lightcook.page.state[{json.dumps(key)}]')

    def pixels(self, before='0'):
        """The canvas [height, width, 3]. No timer of the page comes between the script `before` and the drawing."""
        return self.picture(
            self.browser.evaluate(f'({before}, lightcook.page.drawNow(), document.getElementById("canvas").toDataURL())'))

    def visible(self):
        """Pixels inside charts whose texels are all covered: rows and columns, uv, normals, views. Once for each camera."""
        width, height = self.browser.evaluate('[document.getElementById("canvas").width, document.getElementById("canvas").height]')
        key = (width, height, *self.state('camera'))
        if key not in self.seen:
            self.seen[key] = self.find_visible(width, height)
        return self.seen[key]

    def find_visible(self, width, height):
        at = [(x, y) for y in range(4, height - 4, 7) for x in range(4, width - 4, 7)]
        look = lambda dx, dy: self.browser.evaluate(f'lightcook.look({[[x + 0.5 + dx, y + 0.5 + dy] for x, y in at]})')
        middle, beside = look(0, 0), [look(dx, dy) for dx, dy in ((2, 0), (-2, 0), (0, 2), (0, -2))]
        rows = []
        for i, hit in enumerate(middle):
            if hit is None or any(other[i] is None or other[i]['chart'] != hit['chart'] for other in beside):
                continue
            x, y = (int(np.clip(c * n - 0.5, 0, n - 2)) for c, n in zip(hit['uv'], self.covered.shape[::-1]))
            if self.covered[y:y + 2, x:x + 2].all():
                rows.append((at[i][1], at[i][0], *hit['uv'], *hit['normal'], *hit['view']))
        rows = np.array(rows)
        self.assertGreater(len(rows), 500)
        return (rows[:, 0].astype(int), rows[:, 1].astype(int)), rows[:, 2:4].T, rows[:, 4:7], rows[:, 7:10]

    def press_mode(self, mode):
        self.browser.click(f'#mode [data-value="{mode}"]')
        self.assertEqual(self.state('mode'), mode)


class ControlsSuite(SceneSuite):
    """The example in a layout that is linear in its texels, so that filtered coefficients are enough to shade it here."""
    options = ('--layout', 'hdr')

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        run(LIGHTCOOK, 'reconstruct', cls.cooked, 'lightmap', cls.folder / 'cooked.exr')
        cls.sh = lighting.sh_of(lighting.read_exr(cls.folder / 'cooked.exr'))

    def coefficients(self, image, uv):
        return lighting.bilinear(image, *uv)

    def check_cooked(self, light, at, what, stops=0.0):
        self.assert_shown(self.pixels()[at], lighting.shown(np.maximum(light, 0), self.nits, stops), what)


class Controls(ControlsSuite):
    """Controls that change what the GPU computes, clicked, against pixels that are shaded here; and files that are damaged."""

    def test_reference_cooked_and_exposure(self):
        at, uv, n, _ = self.visible()
        for mode, image in (('reference', self.bake), ('cooked', self.sh)):
            self.press_mode(mode)
            self.check_cooked(lighting.exit_radiance(self.coefficients(image, uv), n), at, mode)
        self.browser.click('#stops', 0.8)
        stops = self.state('stops')
        self.assertGreater(stops, 2)
        self.check_cooked(lighting.exit_radiance(self.coefficients(self.sh, uv), n), at, 'exposure', stops)

    def test_the_wipe_has_the_reference_on_its_left(self):
        self.press_mode('reference')
        left = self.pixels()
        self.press_mode('cooked')
        right = self.pixels()
        self.assertGreater(np.abs(left - right).max(), 8)
        self.press_mode('wipe')
        for share in (0.5, 0.3):
            if share != 0.5:
                x, y = self.browser.place_of('#wipe')
                self.browser.drag((x, y), (x + (share - 0.5) * left.shape[1], y))
            border = self.state('wipe') * left.shape[1]
            self.assertAlmostEqual(border, share * left.shape[1], delta=2)
            pixels, edge = self.pixels(), int(border)
            np.testing.assert_array_equal(pixels[:, :edge - 1], left[:, :edge - 1])
            np.testing.assert_array_equal(pixels[:, edge + 2:], right[:, edge + 2:])

    def test_error_shows_the_visible_error_on_its_scale(self):
        at, uv, n, _ = self.visible()
        self.press_mode('error')
        light = [np.maximum(lighting.exit_radiance(self.coefficients(image, uv), n), 0) for image in (self.bake, self.sh)]
        error = lighting.visible_error(*light, self.nits, self.black)
        stops = np.array([[0, 0, 0], [70, 15, 110], [190, 40, 75], [240, 110, 30], [250, 205, 60], [255, 255, 255]], float)
        for end in (10, 2):
            if end != 10:
                self.browser.click('#errorEnd', 0.03)
                end = self.state('errorEnd')
                self.assertLess(end, 5)
            x = 5 * np.clip(error / end, 0, 1)
            i = np.minimum(x.astype(int), 4)
            expected = stops[i] + (x - i)[:, None] * (stops[i + 1] - stops[i])
            share = np.mean(np.abs(self.pixels()[at] - expected) <= 40 / end + 2)  # 0.07 of Delta E ITP
            self.assertGreaterEqual(share, 0.99)
            self.assertGreater(np.ptp(expected), 60)
            self.assertIn(str(end), self.browser.evaluate('document.getElementById("legend").textContent'))

    def test_area_specular_and_the_dominant_light(self):
        at, uv, n, v = self.visible()
        self.press_mode('cooked')
        self.browser.click('#glossy [data-value="area"]')
        self.browser.click('#f0', 0.6)
        self.browser.click('#m', 0.3)
        m, f0 = self.state('m'), self.state('f0')
        tables = SpecularTables(self.asset('lut')['constants'], self.textures(self.asset('lut')))
        sh = self.coefficients(self.sh, uv)
        area = tables.reflected(sh, n, v, m, f0)
        self.assertGreater(np.median(area * self.nits), 1)
        self.check_cooked(lighting.exit_radiance(sh, n) + area, at, 'diffuse and area')
        self.browser.click('#diffuse')
        self.check_cooked(area, at, 'area')
        # With the dominant light: its highlight, and area specular of the rest.
        self.browser.click('#dominant')
        dominant = self.asset('dominant')
        k, images = dominant['constants'], self.textures(dominant)
        stored = lighting.bilinear(images['direction'], *uv) + k['residual_scale'] * (lighting.bilinear(images['residual'], *uv) - k['residual_centre'])
        towards = k['direction_scale'] * stored[:, :3] + k['direction_bias']
        length = np.linalg.norm(towards, axis=1, keepdims=True)
        towards = np.where(length > 1e-4, towards / np.maximum(length, 1e-9), n)
        intensity = k['intensity_range'] * lighting.bilinear(images['intensity'], *uv)[:, :3]
        half = towards + v
        half /= np.linalg.norm(half, axis=1, keepdims=True)
        nov, nol, noh, voh = (np.sum(a * b, 1) for a, b in ((n, v), (n, towards), (n, half), (v, half)))
        distribution = np.exp((noh ** 2 - 1) / (noh ** 2 * m * m)) / (np.pi * m * m * noh ** 4)
        shadowing = np.minimum(1, 2 * noh * np.minimum(nov, nol) / voh)
        fresnel = f0 + (1 - f0) * (1 - voh) ** 5
        highlight = np.where((nol > 0) & (nov > 0), distribution * shadowing * fresnel / (4 * nov), 0)[:, None] * intensity
        rest = sh - lighting.basis(towards)[:, :, None] * intensity[:, None, :]
        self.assertGreater(highlight.max() * self.nits, 10)
        self.check_cooked(highlight + tables.reflected(rest, n, v, m, f0), at, 'dominant light')

    def test_the_probe_reflects(self):
        self.press_mode('cooked')
        before = self.pixels()
        self.browser.click('#glossy [data-value="environment"]')
        at, uv, n, v = self.visible()
        rough = self.pixels()
        self.assertTrue((rough[at] >= before[at] - 1).all())
        self.assertGreater(np.abs(rough - before).max(), 4)
        self.browser.click('#m', 0.95)  # rougher: the cubemap has the levels that materials read
        self.assertGreater(np.abs(self.pixels() - rough).max(), 2)

    def test_overlays(self):
        self.press_mode('cooked')
        plain = self.pixels()
        for value in ('charts', 'texels'):
            self.browser.evaluate(f"""(() => {{
                const select = document.getElementById('overlay');
                select.value = '{value}';
                select.dispatchEvent(new Event('change'));
            }})()""")
            self.browser.settle()
            self.assertGreater(np.mean(np.abs(self.pixels() - plain)), 0.5, value)
        self.reset('mode=cooked')
        self.browser.click('#seams')
        self.assertGreater(np.max(np.abs(self.pixels() - plain)), 50)

    def test_the_camera_flies_to_the_worst_places(self):
        places = self.worst_places()
        self.assertGreaterEqual(len(places), 3)
        self.assertEqual(self.browser.evaluate('document.querySelectorAll("#worst li").length'), len(places))
        before = self.state('camera')
        self.browser.click('#worst li:first-child button')
        texel = places[0]['texel']
        self.assertGreater(np.linalg.norm(np.subtract(self.state('camera'), before)), 1)
        _, u, v = self.state('picked')
        np.testing.assert_allclose([u * 256 - 0.5, v * 256 - 0.5], texel, atol=1e-6)
        # The place is in the middle of the picture.
        hit = self.browser.evaluate('(({ clientWidth: w, clientHeight: h }) => lightcook.look([[w / 2, h / 2]]))(document.getElementById("canvas"))')[0]
        np.testing.assert_allclose(hit['uv'], [u, v], atol=0.02)

    def shown_error(self):
        return float(self.browser.evaluate('[...document.querySelectorAll("#picked dd")].find((dd) => dd.dataset.term === "Visible error").textContent'))

    def test_a_worst_place_shows_the_figure_of_the_list(self):
        """Also once the camera has turned away: normal and view are those of the sample."""
        for i, place in enumerate(self.worst_places()):
            self.browser.click(f'#worst li:nth-child({i + 1}) button')
            listed = float(self.browser.evaluate(f'document.querySelector("#worst li:nth-child({i + 1}) b").textContent'))
            self.assertAlmostEqual(listed, place['visible'], delta=0.005)
            isSpecular = place['what'] == 'specular'
            self.assertEqual([self.state(key) for key in ('diffuse', 'glossy', 'dominant')], [not isSpecular, 'area' if isSpecular else 'none', False])
            # Half floats of the reference; and specular light is that of the cooked tables.
            tolerance = 0.01 + (0.1 if isSpecular else 0.01) * place['visible']
            self.assertAlmostEqual(self.shown_error(), place['visible'], delta=tolerance, msg=place)
            if isSpecular:
                np.testing.assert_allclose([self.state('m'), self.state('f0')], [place['m'], place['f0']], rtol=1e-6)
                towards = np.subtract(*np.split(np.array(self.state('camera')), 2))
                np.testing.assert_allclose(towards / np.linalg.norm(towards), place['view'], atol=1e-4)
            self.browser.press('h', 'KeyH')
            self.assertAlmostEqual(self.shown_error(), place['visible'], delta=tolerance, msg=place)
        # A click, here on the line of the wipe, is shaded at the surface's own normal.
        self.browser.click_at(*self.browser.place_of('#canvas'))
        self.assertIsNotNone(self.state('picked'))
        self.assertIsNone(self.state('shaded'))

    def test_the_camera_stays_in_front_of_what_hides_a_place(self):
        """Every place is in the middle of the picture. One of the cases lies below a box."""
        distances = []
        for i, place in enumerate(self.worst_places()):
            self.browser.click(f'#worst li:nth-child({i + 1}) button')
            u, v = self.state('picked')[1:]
            hit = self.browser.evaluate('(({ clientWidth: w, clientHeight: h }) => lightcook.look([[w / 2, h / 2]]))(document.getElementById("canvas"))')[0]
            np.testing.assert_allclose(np.multiply(hit['uv'], 256), np.multiply([u, v], 256), atol=2, err_msg=str(place))
            camera = np.array(self.state('camera'))
            distances.append(np.linalg.norm(camera[:3] - camera[3:]))
        # 20 texels to the half of the picture's side.
        self.assertLess(max(distances), 40 * 5.5 / 81 + 0.01)
        self.assertGreater(max(distances), 2)

    def test_a_click_shows_the_place(self):
        self.press_mode('cooked')
        at, uv, n, v = self.visible()
        i = len(uv[0]) // 2
        y, x = at[0][i], at[1][i]
        self.browser.click_at(x + 0.5, y + 0.5)
        shown = self.browser.evaluate('Object.fromEntries([...document.querySelectorAll("#picked dd")].map((dd) => [dd.dataset.term, dd.textContent]))')
        texel = [float(part) for part in shown['Texel'].split(',')]
        np.testing.assert_allclose(texel, uv[:, i] * 256 - 0.5, atol=0.02)
        place = [uv[:, i:i + 1][0], uv[:, i:i + 1][1]]
        light = [np.maximum(lighting.exit_radiance(self.coefficients(image, place), n[i:i + 1]), 0) for image in (self.bake, self.sh)]
        for term, expected in zip(('Reference', 'Cooked'), light):
            np.testing.assert_allclose([float(part) for part in shown[term].split()], expected[0], rtol=0.02, atol=2e-4)
        self.assertAlmostEqual(float(shown['Visible error']), lighting.visible_error(*light, self.nits, self.black)[0], delta=0.1)
        self.assertRegex(shown['Bytes of the chart'], r'^[0-9.]+ (B|KiB|MiB)$')
        rows = self.browser.evaluate('[...document.querySelectorAll("#picked tbody tr")].map((row) => [...row.children].map((cell) => Number(cell.textContent)))')
        np.testing.assert_allclose(np.array(rows)[:, 4:], self.coefficients(self.sh, place)[0], rtol=0.02, atol=2e-3)
        ring = self.browser.place_of('#marker')
        np.testing.assert_allclose(ring, (x + 0.5, y + 0.5), atol=1.5)
        self.browser.click_at(3, 3)
        self.assertIsNone(self.state('picked'))
        self.assertTrue(self.browser.evaluate('document.getElementById("marker").hidden'))

    def test_memory_is_that_of_the_manifest(self):
        total = sum(texture['bytes_gpu'] for asset in self.manifest['assets'] for texture in asset['textures'])
        total += sum(asset.get('bytes_gpu', 0) for asset in self.manifest['assets'])
        areas = self.browser.evaluate("""[...document.querySelectorAll('#memory button')].map((tile) =>
            parseFloat(tile.style.width) * parseFloat(tile.style.height) / 1e4)""")
        self.assertAlmostEqual(sum(areas), 1, delta=1e-3)
        largest = max(texture['bytes_gpu'] for asset in self.manifest['assets'] for texture in asset['textures'])
        self.assertAlmostEqual(max(areas), largest / total, delta=1e-3)
        self.browser.click('#memory button')
        self.assertIn(f'{100 * max(areas):.1f} %', self.browser.evaluate('document.getElementById("memory").nextSibling.textContent'))

    def test_missing_formats_are_decoded(self):
        places, n, v = shading_points(256, 256, 300, 9)
        places = places[self.covered[places[:, 1].astype(int), places[:, 0].astype(int)]]
        self.reset('mode=cooked&glossy=area&dominant=1&f0=0.5')
        native = self.shade('lightmap', places, n, v)
        mirror = 'mode=cooked&glossy=environment&m=0.07&f0=1&diffuse=0'
        self.reset(mirror)
        reflected = self.pixels()
        poor = Browser(width=840, height=480)
        try:
            poor.resize(840, 480)
            poor.without_extensions(['EXT_texture_compression_bptc', 'EXT_texture_compression_rgtc', 'WEBGL_compressed_texture_s3tc', 'EXT_texture_norm16'])
            poor.open(self.url + '#mode=cooked&glossy=area&dominant=1&f0=0.5')
            own, browser = self.browser, poor
            type(self).browser = browser
            try:
                decoded = self.shade('lightmap', places, n, v)
                self.reset(mirror)
                self.assertGreater(np.ptp(reflected), 100)
                np.testing.assert_allclose(self.pixels(), reflected, atol=2)
            finally:
                type(self).browser = own
            self.assertEqual(poor.problems(), [])
        finally:
            poor.close()
        self.assert_shown(255 * decoded['cookedShown'], 255 * native['cookedShown'], 'decoded on the CPU')

    def test_what_is_damaged_is_named(self):  # the last by its name: it leaves a page that has failed
        for file, cut, message in (('cooked/lightmap_sh.ktx2', 100, 'lightmap_sh.ktx2'), ('cooked/cooked.json', None, 'cooked.json'), ('cooked/cooked.json', 1000, 'cooked/cooked.json: not a JSON file'),
                                   ('viewer/scene.json', None, 'scene.json')):
            broken = self.folder / 'broken'
            shutil.rmtree(broken, ignore_errors=True)
            shutil.copytree(self.site, broken)
            if cut is None:
                (broken / file).unlink()
            else:
                (broken / file).write_bytes((broken / file).read_bytes()[:cut])
            with self.assertRaisesRegex(RuntimeError, message):
                self.browser.open(self.serve(broken))
        self.browser.events.clear()  # what it logged


class ControlsSoak(ControlsSuite):
    """The other controls, and what the page does by itself."""

    def test_blink_alternates(self):
        seen = {}
        for mode in ('reference', 'cooked'):
            self.press_mode(mode)
            seen[mode] = self.pixels()
        self.press_mode('blink')
        for blinked, mode in ((True, 'reference'), (False, 'cooked')):
            self.browser.evaluate(f"""new Promise((done) => {{
                const poll = () => lightcook.page.blinked === {str(blinked).lower()} ? done(1) : setTimeout(poll, 20);
                poll();
            }})""")
            pixels = self.pixels(before=f'lightcook.page.blinked = {str(blinked).lower()}')
            np.testing.assert_array_equal(pixels, seen[mode])

    def test_albedo_materials_and_the_normal_map(self):
        at, uv, n, _ = self.visible()
        self.press_mode('cooked')
        white = self.pixels()
        self.browser.click('#albedo', 0.4)
        albedo = self.state('albedo')
        self.assertLess(albedo, 0.6)
        self.check_cooked(albedo * lighting.exit_radiance(self.coefficients(self.sh, uv), n), at, 'albedo')
        self.reset('mode=cooked')
        self.browser.click('#materials')
        coloured = self.pixels()
        # The left wall is red: it keeps a larger part of red than of green.
        self.assertGreater(np.mean(np.abs(coloured - white)), 3)
        self.assertGreater(np.max((coloured[..., 0] - coloured[..., 1]) - (white[..., 0] - white[..., 1])), 30)
        self.browser.click('#materials')
        np.testing.assert_array_equal(self.pixels(), white)
        self.browser.click('#bump', 0.5)
        self.assertGreater(np.mean(np.abs(self.pixels() - white)), 2)

    def test_worst_places_in_charts_of_few_texels_say_so(self):
        self.browser.open(self.url)
        remarks = '(lightcook.page.build(), [...document.querySelectorAll("#worst li > .note")].map((note) => note.textContent).filter(Boolean))'
        self.assertEqual(self.browser.evaluate(remarks), [])
        shown = self.browser.evaluate(f'''(() => {{
            const row = lightcook.page.report.assets.find(({{ name }}) => name === "lightmap");
            row.charts.few_texels = [{{ shading: "specular", texels: 3.2, advice: "Give the chart more texels." }}];
            return {remarks};
        }})()''')
        self.assertEqual(len(shown), 1)
        self.assertEqual(shown[0], 'Give the chart more texels.')

    def test_what_failed_is_listed_with_the_advice_of_the_report(self):
        self.browser.open(self.url)
        self.assertTrue(self.browser.evaluate('lightcook.page.failuresCard() === null'))
        shown = self.browser.evaluate('''(() => {
            lightcook.page.report.assets[0].failures = [{ subject: "lightmap, stage total, diffuse", detail: "found rel_rms 2, expected at most 1 (max_error); worst at texel (1, 2)", advice: "A limit of 2 allows it." }];
            return lightcook.page.failuresCard().textContent;
        })()''')
        self.assertTrue(shown.endswith('lightmap: diffuse: found an RMS error of 2, expected at most 1 (max_error). A limit of 2 allows it.'), shown)

    def test_a_link_reopens_the_view(self):
        canvas = self.browser.place_of('#canvas')
        self.browser.drag(canvas, (canvas[0] + 120, canvas[1] - 40))
        self.browser.click('#glossy [data-value="area"]')
        self.browser.click('#stops', 0.3)
        self.press_mode('error')
        self.browser.click('#link')
        link, pixels = self.browser.evaluate('location.href'), self.pixels()
        self.browser.open(link)
        # The camera is in the link with nine digits.
        self.assertGreaterEqual(np.mean(np.abs(self.pixels() - pixels) <= 1), 0.999)
        # A link that nobody wrote does no harm.
        self.browser.open(self.url + '#mode=nothing&stops=x&camera=1,2&picked=9,9,9&m=1e9&overlay=constructor&__proto__=1')
        self.assertEqual(self.state('mode'), 'wipe')
        self.assertLessEqual(self.state('m'), 1)

    def test_keys_and_touch(self):
        self.browser.evaluate('document.getElementById("canvas").focus()')
        for key, mode in zip('12345', ('wipe', 'reference', 'cooked', 'blink', 'error')):
            self.browser.press(key, f'Digit{key}')
            self.assertEqual(self.state('mode'), mode)
        self.browser.press(' ', 'Space')
        self.assertEqual(self.state('mode'), 'reference')
        self.browser.press(']', 'BracketRight')
        self.assertEqual(self.state('stops'), 0.5)
        self.browser.press('f', 'KeyF')
        self.assertEqual(self.state('navigation'), 'fly')
        home = np.array(self.state('camera'))
        self.browser.press('w', 'KeyW', 0.4)
        moved = np.array(self.state('camera')) - home
        self.assertGreater(np.linalg.norm(moved[:3]), 0.05)
        np.testing.assert_allclose(moved[:3], moved[3:], atol=1e-6)
        canvas = self.browser.place_of('#canvas')
        before = np.array(self.state('camera'))
        self.browser.drag(canvas, (canvas[0] + 90, canvas[1] + 20))
        np.testing.assert_allclose(np.array(self.state('camera'))[:3], before[:3], atol=1e-6)  # fly: looks around
        self.browser.press('h', 'KeyH')
        self.browser.press('f', 'KeyF')
        np.testing.assert_allclose(self.state('camera'), home, atol=1e-6)
        self.browser.touch([[canvas], [(canvas[0] + 40, canvas[1])], [(canvas[0] + 80, canvas[1])]])
        turned = np.array(self.state('camera'))
        np.testing.assert_allclose(turned[3:], home[3:], atol=1e-6)  # orbit: around the target
        self.assertGreater(np.linalg.norm(turned[:3] - home[:3]), 0.5)
        x, y = canvas
        self.browser.touch([[(x - d, y), (x + d, y)] for d in (40, 60, 80, 100)])
        distance = lambda c: np.linalg.norm(np.array(c)[:3] - np.array(c)[3:])
        self.assertLess(distance(self.state('camera')), 0.8 * distance(turned))

    def test_keys_with_a_control_in_focus(self):
        focus = lambda selector: self.browser.evaluate(f'document.querySelector({json.dumps(selector)}).focus()')
        focus('details.card summary')
        self.browser.press(' ', 'Space')
        self.assertTrue(self.browser.evaluate('document.querySelector("details.card").open'))
        self.assertEqual(self.state('mode'), 'wipe')
        focus('#seams')
        self.browser.press(' ', 'Space')
        self.assertTrue(self.state('seams'))
        self.assertEqual(self.state('mode'), 'wipe')
        for control in ('#stops', '#wipe'):
            self.press_mode('wipe')
            focus(control)
            self.browser.press('3', 'Digit3')
            self.assertEqual(self.state('mode'), 'cooked', control)
        self.press_mode('wipe')
        focus('#wipe')
        for key, share in (('End', 1), ('Home', 0), ('PageUp', 0.1), ('ArrowRight', 0.12)):
            self.browser.press(key, key)
            self.assertAlmostEqual(self.state('wipe'), share, places=9)
        self.assertEqual(self.browser.evaluate('[...document.querySelectorAll("[role=group]")].filter((group) => !group.ariaLabel).length'), 0)

    def test_a_lost_context_is_named_and_comes_back(self):
        self.press_mode('cooked')
        self.browser.click('#glossy [data-value="area"]')
        before = self.picture('data:image/png;base64,' + base64.b64encode(self.browser.screenshot()).decode())
        self.browser.evaluate('''new Promise((done) => {
            window.lost = lightcook.page.view.gl().getExtension("WEBGL_lose_context");
            document.getElementById("canvas").addEventListener("webglcontextlost", () => setTimeout(done), { once: true });
            lost.loseContext();
        })''')
        self.assertFalse(self.browser.evaluate('document.getElementById("loading").hidden'))
        self.assertIn('WebGL context', self.browser.evaluate('document.getElementById("loading-text").textContent'))
        self.browser.evaluate('''new Promise((done) => {
            document.getElementById("canvas").addEventListener("webglcontextrestored", () => setTimeout(done), { once: true });
            lost.restoreContext();
        })''')
        self.browser.settle()
        self.assertTrue(self.browser.evaluate('document.getElementById("loading").hidden'))
        after = self.picture('data:image/png;base64,' + base64.b64encode(self.browser.screenshot()).decode())
        np.testing.assert_array_equal(after, before)

    def test_up_is_the_axis_of_the_scene(self):
        turned = self.folder / 'turned'
        shutil.copytree(self.site, turned)
        manifest = {**self.manifest, 'up_axis': 'z'}
        (turned / 'cooked' / 'cooked.json').write_text(json.dumps(manifest))
        (turned / 'cooked' / 'report.json').write_text('<p>not found</p>')  # with status 200, as of some web servers: the page has no verdict then
        self.browser.open(self.serve(turned))
        self.assertFalse(self.browser.evaluate('!!document.querySelector(".verdict")'))
        camera = 'lightcook.page.camera.view.matrix.elements'
        x, y = self.browser.place_of('#canvas')
        for end in ((x, y), (x + 90, y + 30)):
            self.browser.drag((x, y), end)
            right, up = np.reshape(self.browser.evaluate(f'[...{camera}]'), (4, 4))[:2, :3]
            self.assertAlmostEqual(right[2], 0, places=6)  # the horizon is level
            self.assertGreater(up[2], 0.1)
        target, before = self.state('camera')[3:], self.state('camera')
        self.browser.drag((x, y), (x + 90, y))
        np.testing.assert_allclose([self.state('camera')[2], *self.state('camera')[3:]], [before[2], *target], atol=1e-6)  # about the vertical axis
        self.browser.open(self.url)

    def test_a_new_cook_is_offered(self):
        again = self.folder / 'again'
        shutil.copytree(self.site, again)
        self.browser.open(self.serve(again))
        hidden = lambda: self.browser.evaluate('lightcook.page.lookForNewCook().then(() => document.getElementById("again").hidden)')
        self.assertTrue(hidden())
        manifest = {**self.manifest, 'scene': 'cooked again', 'digest': 32 * '0'}
        (again / 'cooked' / 'cooked.json').write_text('{')  # in the middle of a write
        self.assertTrue(hidden())
        (again / 'cooked' / 'cooked.json').write_text(json.dumps(manifest))
        self.assertFalse(hidden())
        self.browser.click('#again')
        for _ in range(100):
            if self.browser.evaluate('!!globalThis.lightcook && document.querySelector("h1")?.textContent') == 'cooked again':
                break
            time.sleep(0.05)
        self.assertTrue(hidden())
        self.browser.open(self.url)

    def drop(self, folder):
        self.browser.evaluate('lightcook.page.opening = undefined')
        self.browser.drop(folder, *self.browser.place_of('#canvas'))
        self.browser.evaluate("""(async () => {
            for (let i = 0; i < 600 && !lightcook.page.opening; ++i) await new Promise((done) => setTimeout(done, 50));
            await lightcook.page.opening;
        })()""")
        self.browser.settle()

    def test_a_dropped_folder_is_shown_beside_the_bake_of_the_site(self):
        other = self.folder / 'other'
        run(LIGHTCOOK, 'cook', self.scene, '-o', other, '--max-error', self.max_error, '--max-converter-error', 1, '--effort', 0, '--cache', CACHE, '--layout', 'raw')
        self.browser.open(self.url)
        at, uv, n, _ = self.visible()
        self.press_mode('reference')
        reference = self.pixels()
        self.drop(other)
        self.assertEqual(self.browser.evaluate('document.getElementById("folder-fault").textContent'), '')
        run(LIGHTCOOK, 'reconstruct', other, 'lightmap', self.folder / 'other.exr')
        raw = lighting.sh_of(lighting.read_exr(self.folder / 'other.exr'))
        self.press_mode('cooked')
        self.check_cooked(lighting.exit_radiance(lighting.bilinear(raw, *uv), n), at, 'the dropped folder')
        self.press_mode('reference')
        np.testing.assert_array_equal(self.pixels(), reference)
        self.assertTrue(self.browser.evaluate('document.querySelector("header a").href').startswith('blob:'))
        self.assertTrue(self.browser.evaluate('lightcook.page.lookForNewCook().then(() => document.getElementById("again").hidden)'))
        # What is no cooked folder leaves the page as it is.
        (self.folder / 'no').mkdir()
        (self.folder / 'no' / 'scene.toml').write_text('')
        self.drop(self.folder / 'no')
        self.assertIn('found no cooked.json among 1 dropped files', self.browser.evaluate('document.getElementById("folder-fault").textContent'))
        self.press_mode('cooked')
        self.check_cooked(lighting.exit_radiance(lighting.bilinear(raw, *uv), n), at, 'still the folder')
        # Of another bake there is no comparison.
        digest = self.asset('light-map')['source']['files']['source']['digest']
        (other / 'cooked.json').write_text((other / 'cooked.json').read_text().replace(digest, 32 * '0'))
        self.drop(other)
        self.assertFalse(self.browser.evaluate('lightcook.page.view.has.reference'))
        self.check_cooked(lighting.exit_radiance(lighting.bilinear(raw, *uv), n), at, 'at the exposure of the key')
        self.browser.open(self.url)

    def test_sizes_and_the_saved_picture(self):
        self.browser.open(self.url)
        tags = self.browser.evaluate('["left-tag", "right-tag"].map((id) => document.getElementById(id).textContent)')
        self.assertRegex(tags[0], r'^Reference, [0-9.]+ [KM]iB$')
        self.assertRegex(tags[1], r'^Cooked, [0-9.]+ [KM]iB$')
        self.assertRegex(self.browser.evaluate('document.querySelector(".sizes").textContent'), r'^[0-9.]+ [KM]iB of files → [0-9.]+ [KM]iB of GPU memory$')
        saved = self.browser.evaluate("""new Promise((done) => {
            HTMLAnchorElement.prototype.click = async function () {
                const reader = new FileReader();
                reader.onload = () => done([this.download, reader.result]);
                reader.readAsDataURL(await (await fetch(this.href)).blob());
            };
            document.getElementById('picture').click();
        })""")
        self.assertEqual(saved[0], 'cornell_wipe.png')
        picture, canvas = self.picture(saved[1]), self.pixels()
        self.assertEqual(picture.shape, canvas.shape)
        border = canvas.shape[1] // 2
        np.testing.assert_array_equal(picture[:400, :border - 2], canvas[:400, :border - 2])
        self.assertTrue((picture[:, border - 1:border + 1] == 255).all(), 'the border')
        self.assertGreater(np.abs(picture[-30:].astype(float) - canvas[-30:]).max(), 50, 'names of the sides')
        self.browser.open(self.url)

    def test_a_page_that_is_opened_as_a_file_says_so(self):
        self.browser.call('Page.navigate', {'url': (self.site / 'index.html').as_uri()})
        for _ in range(100):
            text = self.browser.evaluate('document.getElementById("loading-text")?.textContent ?? ""')
            if 'from a file' in text:
                break
            time.sleep(0.05)
        self.assertIn('http.server', text)
        self.browser.open(self.url)

    def test_themes_and_narrow_pages(self):
        background = lambda: self.browser.evaluate('getComputedStyle(document.body).backgroundColor')
        for scheme, theme in (('dark', 'dark'), ('light', 'light')):
            self.browser.prefer(scheme)
            self.browser.settle()
            self.assertEqual(self.browser.evaluate('document.documentElement.dataset.theme'), theme)
        light = background()
        self.browser.click('#theme')
        self.browser.click('#theme')
        self.assertEqual(self.state('theme'), 'dark')
        self.assertNotEqual(background(), light)
        self.assertLess(self.pixels()[2, 2].max(), 64)
        for width in (1400, 800, 420, 320):
            self.browser.resize(width, 800)
            self.browser.settle()
            self.assertLessEqual(self.browser.evaluate('document.scrollingElement.scrollWidth'), width)
            overflowing = self.browser.evaluate("""[...document.querySelectorAll('#panel .card')].filter((card) => card.scrollWidth > card.clientWidth + 1)
                .map((card) => card.textContent.slice(0, 40))""")
            self.assertEqual(overflowing, [], width)
        self.browser.resize(840, 480)


class Nodes(SceneSuite):
    """A mesh below nodes that rotate, then scale unevenly and mirror: a shear, which rotation and scale of one node cannot express."""
    options = ('--layout', 'sh4')
    max_error = 0.9
    angle, scale = 0.6, (-1.0, 2.0, 1.0)

    @classmethod
    def setUpClass(cls):
        source = pathlib.Path(tempfile.mkdtemp(prefix='lightcook-viewer-test-'))
        cls.addClassCleanup(shutil.rmtree, source, True)
        cls.scene = source / 'scene.toml'
        cls.write_mesh(ROOT / 'examples' / 'cornell' / 'cornell.glb', source / 'nodes.glb')
        cls.scene.write_text(
            f'schema = 1\nname = "nodes"\n[[light_map]]\nname = "lightmap"\nfile = {json.dumps(str(BAKE))}\nmesh = "nodes.glb"\n'
            '[[material]]\nname = "*"\nnormal_map = true\nspecular = false\n')
        super().setUpClass()

    @classmethod
    def write_mesh(cls, source, target):
        """Puts the nodes of a .glb below two others."""
        data = source.read_bytes()
        length = int.from_bytes(data[12:16], 'little')
        document = json.loads(data[20:20 + length])
        nodes, scene = document['nodes'], document['scenes'][0]
        nodes.append({'children': scene['nodes'], 'rotation': [0, 0, float(np.sin(cls.angle / 2)), float(np.cos(cls.angle / 2))]})
        nodes.append({'children': [len(nodes) - 1], 'scale': cls.scale})
        scene['nodes'] = [len(nodes) - 1]
        text = json.dumps(document).encode()
        text += b' ' * (-len(text) % 4)
        rest = data[20 + length:]
        target.write_bytes(struct.pack('<5I', 0x46546c67, 2, 20 + len(text) + len(rest), len(text), 0x4e4f534a) + text + rest)

    def test_nodes_place_the_mesh(self):
        box = self.browser.evaluate('(({ min, max }) => [min.toArray(), max.toArray()])(lightcook.page.view.box)')
        c, s = np.cos(self.angle), np.sin(self.angle)
        matrix = np.diag(self.scale) @ [[c, -s, 0], [s, c, 0], [0, 0, 1]]
        corners = np.array([[x, y, z] for x in (0, 5.5) for y in (0, 5.5) for z in (0, 5.5)]) @ matrix.T
        np.testing.assert_allclose(box, [corners.min(0), corners.max(0)], atol=2e-2)

    def test_normals_are_those_of_the_surface(self):
        """Light of a clicked place is shaded at its normal: across the triangle, on the side that is seen."""
        width, height = self.browser.evaluate('[document.getElementById("canvas").clientWidth, document.getElementById("canvas").clientHeight]')
        hits = self.browser.evaluate(f"""[...Array(400).keys()].map((i) => {{
            const place = (dx, dy) => lightcook.page.view.pick(lightcook.page.camera.view, (i % 20 + 0.5) / 20 + dx / {width}, (Math.floor(i / 20) + 0.5) / 20 + dy / {height});
            const hits = [place(0, 0), place(2, 0), place(0, 2)];
            if (hits.some((hit) => !hit || hit.surface.chart !== hits[0].surface.chart)) return null;
            return [...hits.map(({{ surface }}) => surface.position.toArray()), hits[0].surface.normal.toArray()];
        }}).filter((hit) => hit)""")
        self.assertGreater(len(hits), 50)
        a, right, down, normal = np.swapaxes(np.array(hits), 0, 1)
        across = np.cross(down - a, right - a)  # towards the viewer
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        self.assertGreater(np.min(np.sum(across * normal, 1)), 0.999)


class Packed(SceneSuite):
    """Charts packed anew: the reference is the bake as it was, through the UVs that the mesh had."""
    options = ('--charts', 'pack', '--layout', 'hdr')

    def test_reference_and_cooked_are_those_of_the_scene_as_it_was(self):
        self.assertEqual([asset['name'] for asset in self.manifest['assets'] if asset['kind'] == 'light-map'], ['lightmap'])
        self.press_mode('reference')
        reference = self.pixels()
        self.press_mode('cooked')
        cooked = self.pixels()
        unpacked, site = self.folder / 'unpacked', self.folder / 'unpacked_site'
        # As Controls cooks it.
        run(LIGHTCOOK, 'cook', self.scene, '-o', unpacked, '--max-error', self.max_error, '--max-converter-error', 1, '--effort', 0, '--cache', CACHE, '--layout', 'hdr')
        export(LIGHTCOOK, unpacked, site, self.folder / 'dist')
        self.browser.open(self.serve(site))
        self.press_mode('reference')
        expected = self.pixels()
        height, width = expected.shape[:2]
        at = [(x, y) for y in range(4, height - 4, 7) for x in range(4, width - 4, 7)]
        look = lambda dx, dy: self.browser.evaluate(f'lightcook.look({[[x + 0.5 + dx, y + 0.5 + dy] for x, y in at]})')
        hits = [look(*offset) for offset in ((0, 0), (2, 0), (-2, 0), (0, 2), (0, -2))]
        inside = [i for i, around in enumerate(zip(*hits)) if None not in around and len({hit['chart'] for hit in around}) == 1]
        self.assertGreater(len(inside), 500)
        rows, columns = [at[i][1] for i in inside], [at[i][0] for i in inside]
        self.assert_shown(reference[rows, columns], expected[rows, columns].astype(float), 'reference', codes=2)
        self.assertLess(np.mean(np.abs(cooked[rows, columns].astype(float) - expected[rows, columns])), 1)
        self.browser.open(self.url)

    def test_worst_places_lie_where_the_bake_has_them(self):
        places = self.browser.evaluate('[...document.querySelectorAll("#worst button")].map((button) => [button.title, button.textContent])')
        checked = 0
        for i, (title, text) in enumerate(places):
            if 'on the surface' not in text:
                continue
            self.browser.click(f'#worst li:nth-child({i + 1}) button')
            found = self.browser.evaluate("""(() => {
                const { state, view } = lightcook.page, [index, u, v] = state.picked, map = view.maps[index], [x, y] = view.bakeUvAt(map, [u, v]);
                return [x * map.bake.width - 0.5, y * map.bake.height - 0.5];
            })()""")
            texel = [float(part) for part in re.findall(r'[-0-9.]+', title)]
            self.assertLess(np.max(np.abs(np.array(found) - texel)), 1, title)
            checked += 1
        self.assertEqual(checked, 2, 'diffuse and specular')


class Candidates(SceneSuite):
    """Layouts that the cook kept, beside each other. hdr and raw are linear in their texels, so filtered coefficients are enough; for a
    learned layout, whose clusters the mesh names, the decode is written here."""
    options = ('--max-visible', 10, '--keep-candidates')

    @classmethod
    def setUpClass(cls):
        text = (ROOT / 'examples' / 'cornell' / 'scene.toml').read_text()
        scene = pathlib.Path(tempfile.mkdtemp(prefix='lightcook-viewer-test-'))
        cls.addClassCleanup(shutil.rmtree, scene, True)
        shutil.copytree(ROOT / 'examples' / 'cornell', scene, dirs_exist_ok=True)
        cls.scene = scene / 'scene.toml'
        cls.scene.write_text(text.replace('[output]', '[output]\nfilter = "hardware"\nlayouts = ["hdr", "basis-8", "raw"]', 1))
        super().setUpClass()
        cls.sh = {}
        cls.learned = cls.cooked / 'candidates' / 'basis-8'
        for layout, folder in (('', cls.cooked), ('basis-8', cls.learned), ('raw', cls.cooked / 'candidates' / 'raw')):
            run(LIGHTCOOK, 'reconstruct', folder, 'lightmap', cls.folder / 'cooked.exr')
            cls.sh[layout] = lighting.sh_of(lighting.read_exr(cls.folder / 'cooked.exr'))

    def select(self, control, value):
        self.browser.evaluate(f"""(() => {{
            const select = document.getElementById('{control}');
            select.value = '{value}';
            select.dispatchEvent(new Event('change'));
        }})()""")
        self.wait_for(value)

    def wait_for(self, layout):
        self.browser.evaluate(f"""(async () => {{
            for (let i = 0; i < 600 && !lightcook.page.view.sets.has('{layout}') && !lightcook.page.layoutFault; ++i)
                await new Promise((done) => setTimeout(done, 50));
        }})()""")
        self.browser.settle()

    def learned_sh(self, uv):
        manifest = json.loads((self.learned / 'cooked.json').read_text())
        asset = next(asset for asset in manifest['assets'] if asset['kind'] == 'light-map')
        constants = asset['constants']
        self.assertIn('index_runs', constants)
        self.assertGreater(constants['clusters'][0], 1)
        runs = np.array(constants['index_runs']).reshape(-1, 2).astype(int)
        clusters = np.repeat(runs[:, 0], runs[:, 1]).reshape(64, 64)
        which = clusters[(uv[1] * 256).astype(int) // 4, (uv[0] * 256).astype(int) // 4]
        return lighting.learned_sh(constants, decoded_textures(self.learned, asset, self.folder / 'texture.exr'), uv, which)

    def check(self, layout, pixels, at, uv, n):
        sh = self.learned_sh(uv) if layout == 'basis-8' else lighting.bilinear(self.sh[layout], *uv)
        light = np.maximum(lighting.exit_radiance(sh, n), 0)
        self.assert_shown(pixels[at], lighting.shown(light, self.nits), layout)

    def test_each_layout_is_shown_as_cooked(self):
        at, uv, n, _ = self.visible()
        self.assertEqual(self.browser.evaluate("[...document.querySelectorAll('#layout option')].map((o) => o.value)"), ['', 'basis-8', 'raw'])
        self.assertRegex(self.browser.evaluate("document.querySelector('#layout option:nth-child(2)').textContent"), r'^basis-8: [0-9.]+ [KM]iB, visible [0-9.]+$')
        self.press_mode('cooked')
        self.check('', self.pixels(), at, uv, n)
        for layout in ('basis-8', 'raw'):
            self.select('layout', layout)
            shown = self.pixels()
            self.check(layout, shown, at, uv, n)
            self.assertIn(layout, self.browser.evaluate("document.getElementById('right-tag').textContent"))
            if layout == 'basis-8':
                self.browser.evaluate("(() => { const s = document.getElementById('overlay'); s.value = 'clusters'; s.dispatchEvent(new Event('change')); })()")
                self.browser.settle()
                self.assertGreater(np.mean(np.abs(self.pixels()[at] - shown[at].astype(float))), 5)
                self.browser.evaluate("(() => { const s = document.getElementById('overlay'); s.value = 'none'; s.dispatchEvent(new Event('change')); })()")
                self.browser.settle()
        # The error is that of the shown layout: raw is nearly exact.
        self.press_mode('error')
        self.assertLess(np.quantile(self.pixels()[at], 0.99), 30)

    def test_two_layouts_beside_each_other(self):
        self.select('beside', 'raw')
        self.select('layout', 'basis-8')
        self.press_mode('reference')
        left = self.pixels()
        self.press_mode('cooked')
        right = self.pixels()
        self.press_mode('wipe')
        pixels, border = self.pixels(), left.shape[1] // 2
        self.assertGreater(np.abs(left - right).max(), 2)
        np.testing.assert_array_equal(pixels[:, :border - 1], left[:, :border - 1])
        np.testing.assert_array_equal(pixels[:, border + 1:], right[:, border + 1:])
        at, uv, n, _ = self.visible()
        self.press_mode('reference')
        self.check('raw', self.pixels(), at, uv, n)
        self.assertRegex(self.browser.evaluate("document.getElementById('left-tag').textContent"), r'^raw, [0-9.]+ [KM]iB$')
        values = self.shade('lightmap', np.array([[100.0, 100.0]]), np.array([[0.0, 1, 0]]), np.array([[0.0, 1, 0]]))
        np.testing.assert_allclose(values['cooked'][0], self.sh['basis-8'][100, 100], rtol=2e-3, atol=2e-3)

    def test_a_link_reopens_the_layouts(self):
        self.browser.open(self.url + '#layout=raw&beside=basis-8')
        self.wait_for('raw')
        self.wait_for('basis-8')
        self.assertEqual([self.state('layout'), self.state('beside')], ['raw', 'basis-8'])
        self.browser.open(self.url + '#layout=nothing&beside=constructor&memory=x')
        self.assertEqual([self.state('layout'), self.state('beside'), self.state('memory')], ['', '', 'assets'])

    def test_memory_by_charts(self):
        total = sum(texture['bytes_gpu'] for texture in self.asset('light-map')['textures'])
        self.browser.click('#memory-by [data-value="charts"]')
        tiles = self.browser.evaluate("""[...document.querySelectorAll('#memory button')].map((tile) =>
            [tile.title, parseFloat(tile.style.width) * parseFloat(tile.style.height) / 1e4])""")
        self.assertAlmostEqual(sum(area for _, area in tiles), 1, delta=1e-3)
        charts = [(name, area) for name, area in tiles if name.startswith('lightmap, ')]
        count = self.browser.evaluate('lightcook.page.view.maps[0].charts.count')
        self.assertEqual(sum('lightmap, chart ' in name for name, _ in charts), count)
        whole = sum(texture['bytes_gpu'] for asset in self.manifest['assets'] for texture in asset['textures'])
        whole += sum(asset.get('bytes_gpu', 0) for asset in self.manifest['assets'])
        self.assertAlmostEqual(sum(area for _, area in charts), total / whole, delta=2e-3)
        # A click flies to the chart.
        name, _ = max((each for each in charts if 'chart ' in each[0] and 'smaller' not in each[0]), key=lambda each: each[1])
        self.browser.click(f'#memory button[title="{name}"]')
        _, u, v = self.state('picked')
        found = self.browser.evaluate(f'lightcook.page.view.surface(lightcook.page.view.maps[0], {u}, {v}).chart')
        self.assertEqual(f'lightmap, chart {found + 1}', name)
        self.check_errors_of_charts()
        self.browser.click('#memory-by [data-value="assets"]')
        self.assertNotIn(name, self.browser.evaluate("[...document.querySelectorAll('#memory button')].map((tile) => tile.title)"))

    def check_errors_of_charts(self):
        """Each chart of the report colours one of the page, which a click flies to the worst texel of."""
        with open(self.cooked / 'report.json', encoding='utf-8') as file:
            row = next(asset for asset in json.load(file)['assets'] if asset['name'] == 'lightmap')
        coloured = self.browser.evaluate("""[...document.querySelectorAll('#memory button')]
            .filter((tile) => tile.style.background.includes('--error-')).length""")
        self.assertEqual(coloured, len(row['charts']['largest']))
        worst = max(row['charts']['largest'], key=lambda chart: chart['visible_max'])
        places = self.browser.evaluate("""[...document.querySelectorAll('#memory button')].map((tile) => {
            tile.click();
            return [document.querySelector('#memory').parentElement.lastElementChild.textContent, lightcook.page.state.picked];
        })""")
        _, (_, u, v) = next(place for place in places if f'at most {worst["visible_max"]:.2f}' in place[0])
        self.assertEqual([int(u * row['width']), int(v * row['height'])], worst['worst'])

    def test_what_cannot_be_loaded_is_named(self):  # the last by its name: it leaves another page
        broken = self.folder / 'broken'
        shutil.copytree(self.site, broken)
        (broken / 'cooked' / 'candidates' / 'raw' / 'lightmap_sh.ktx2').unlink()
        self.browser.open(self.serve(broken))
        self.select('layout', 'raw')
        self.assertIn('lightmap_sh.ktx2', self.browser.evaluate("document.getElementById('layout-fault').textContent"))
        self.assertEqual(self.state('layout'), '')
        self.browser.events.clear()  # the 404 is logged


class Types(unittest.TestCase):
    def test_the_sources_have_no_errors_of_types(self):
        compiler = VIEWER / 'node_modules' / 'typescript' / 'bin' / 'tsc'
        if not compiler.is_file():
            skip('typescript is missing: run ./dev setup')
        run('node', compiler, '--project', VIEWER / 'tsconfig.json')


if __name__ == '__main__':
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
