"""The plugin and the scene of the guide's section on bevy: bevy_test.py LIGHTCOOK SUITE

bevy is not at hand: rustc compiles the plugin against declarations of what it uses. Exit code 77: skipped, with the reason on a line of its
own."""
import json
import shutil
import sys
import unittest

from viewer_test import CACHE, LIGHTCOOK, ROOT, Folder, np, run, skip
import lighting

HERE = ROOT / 'tests' / 'viewer' / 'bevy'

if not shutil.which('rustc'):
    skip('rustc is not installed')


class Bevy(Folder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        guide = (ROOT / 'docs' / 'guide' / 'into-an-engine.md').read_text()
        section = guide.split('\n## bevy\n')[1].split('\n## ')[0]
        plugin, setup = (part.split('\n```')[0] + '\n' for part in section.split('```rust\n')[1:])
        setup = setup.replace('fn setup', 'pub fn setup').replace('"assets/cooked/cooked.json"', json.dumps(str(cls.folder / 'cooked' / 'cooked.json')))
        (cls.folder / 'guide.rs').write_text(plugin + setup)
        example = ROOT / 'examples' / 'cornell'
        shutil.copy(example / 'cornell_lightmap.exr', cls.folder / 'room.exr')
        shutil.copy(example / 'cornell.glb', cls.folder / 'room.glb')
        (cls.folder / 'scene.toml').write_text('schema = 1\nname = "bevy"\n' + section.split('```toml\n')[1].split('\n```')[0])
        run(LIGHTCOOK, 'cook', cls.folder / 'scene.toml', '-o', cls.folder / 'cooked', '--cache', CACHE)
        shutil.copy(HERE / 'main.rs', cls.folder)
        rustc = ['rustc', '--edition', '2021', '--out-dir', cls.folder, '-L', cls.folder]
        run(*rustc, '--crate-type', 'proc-macro', '--crate-name', 'derive', HERE / 'derive.rs')
        run(*rustc, '--crate-type', 'lib', '--crate-name', 'bevy', '--extern', 'derive', HERE / 'declarations.rs')
        run(*rustc, '--crate-type', 'lib', '--crate-name', 'serde_json', HERE / 'serde_json.rs')
        run(*rustc, '--extern', 'bevy', '--extern', 'serde_json', '-D', 'warnings', '-A', 'dead_code', cls.folder / 'main.rs')

    def said(self, *arguments, manifest='cooked/cooked.json'):
        return run(self.folder / 'main', self.folder / manifest, *arguments).splitlines()

    def test_the_plugin_shows_what_the_decoder_says(self):
        lines = self.said()
        self.assertEqual([line.rsplit(' ', 1)[0] for line in lines[:2]], [f'mesh {mesh}: cooked/room_exit.ktx2 false' for mesh in (1, 2)])
        self.assertEqual(lines[2:], ['shared: 1'])
        shown = float(lines[0].split()[-1])
        key = next(asset['key'] for asset in json.loads((self.folder / 'cooked' / 'cooked.json').read_text())['assets'])
        exr = self.folder / 'map.exr'
        run(LIGHTCOOK, 'decode', self.folder / 'cooked' / 'room_exit.ktx2', exr)
        texels = np.stack([lighting.read_exr(exr)[c] for c in 'RGB'], -1).astype(float)
        run(LIGHTCOOK, 'reconstruct', self.folder / 'cooked', 'room', exr)
        channels = lighting.read_exr(exr)
        normals = np.stack([channels[f'normal.{c}'] for c in 'XYZ'], -1).reshape(-1, 3)
        covered = channels['coverage.Y'].ravel() > 0
        light = lighting.exit_radiance(lighting.sh_of(channels).reshape(-1, 9, 3)[covered], normals[covered])
        np.testing.assert_allclose(shown * texels.reshape(-1, 3)[covered], 0.18 / key * light, rtol=1e-3, atol=1e-4)

    def test_another_layout_and_another_name_are_refused(self):
        self.assertEqual(self.said('hall'), ['refused: cooked: 0 light maps; name one'])
        text = (self.folder / 'cooked' / 'cooked.json').read_text()
        (self.folder / 'other.json').write_text(text.replace('"layout": "flat"', '"layout": "sh4"'))
        self.assertNotEqual((self.folder / 'other.json').read_text(), text)
        self.assertEqual(self.said(manifest='other.json'), ['refused: cooked: cook with light_map_layout = "flat"'])


if __name__ == '__main__':
    unittest.main(argv=[sys.argv[0], sys.argv[2]], verbosity=2)
