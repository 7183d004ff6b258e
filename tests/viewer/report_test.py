"""The page of a report in a headless Chromium: report_test.py LIGHTCOOK SUITE

Each suite is one test of ctest. Exit code 77: skipped, with the reason on a line of its own."""
import copy
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent

from browser import Browser  # noqa: E402

LIGHTCOOK = sys.argv[1] if len(sys.argv) > 1 else 'lightcook'
CACHE = pathlib.Path(LIGHTCOOK).resolve().parent / 'test_cache'  # that of the other tests
EVIL = '</script><!--<script>window.evil = 1</script><img src=x onerror="window.evil = 1">&amp;\u2028'


def run(*command, okay=(0,)):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode not in okay:
        raise AssertionError(f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


class Modules(unittest.TestCase):
    """What needs no browser, and types."""

    @classmethod
    def setUpClass(cls):
        if not shutil.which('node'):
            print('skipped: report: node is not installed')
            sys.exit(77)

    def test_modules(self):
        run('node', '--test', HERE / 'report_test.mjs')

    def test_the_sources_have_no_errors_of_types(self):
        compiler = ROOT / 'viewer' / 'node_modules' / 'typescript' / 'bin' / 'tsc'
        if not compiler.is_file():
            self.skipTest('typescript is missing: run ./dev setup')
        run('node', compiler, '--project', ROOT / 'viewer' / 'tsconfig.report.json')


class Report(unittest.TestCase):
    """Pages of the example, of its report with other figures, and of several scenes."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix='lightcook-report-test-'))
        cls.addClassCleanup(shutil.rmtree, cls.folder, True)
        if not shutil.which('chromium'):
            print('skipped: report: chromium is not installed')
            sys.exit(77)
        cls.browser = Browser(1400, 900)
        cls.addClassCleanup(cls.browser.close)
        cls.cooked = cls.folder / 'cooked'
        run(LIGHTCOOK, 'cook', ROOT / 'examples' / 'cornell' / 'scene.toml', '-o', cls.cooked, '--max-error', 0.1, '--max-converter-error', 1, '--effort', 0, '--cache', CACHE, '--layout', 'hdr')
        cls.report = json.loads((cls.cooked / 'report.json').read_text())

    def tearDown(self):
        self.assertEqual(self.browser.problems(), [])

    def show(self, file, width=1400, unfolded=True):
        self.assertTrue(file.is_file(), file)
        self.browser.resize(width, 900)
        self.browser.show(f'file://{file}')
        if unfolded:
            self.browser.evaluate('document.querySelectorAll("details").forEach((each) => { each.open = true; })')

    def show_report(self, report, *options, width=1400, unfolded=True):
        """Shows the page of the example with another report."""
        folder, page = self.folder / 'edited', self.folder / 'edited.html'
        shutil.copytree(self.cooked, folder, dirs_exist_ok=True)
        (folder / 'report.json').write_text(json.dumps(report))
        page.unlink(missing_ok=True)
        run(LIGHTCOOK, 'report', folder, '--html', page, *options, okay=(4, 5))  # the report is not the one of its cook
        self.show(page, width, unfolded)

    def edited(self):
        report = copy.deepcopy(self.report)
        return report, next(asset for asset in report['assets'] if asset['kind'] == 'light-map')

    def all(self, selector, value='textContent'):
        return self.browser.evaluate(f'[...document.querySelectorAll({json.dumps(selector)})].map((each) => each.{value})')

    def section(self, name):
        """Text of the section or part of a section under a heading."""
        found = self.browser.evaluate(f'[...document.querySelectorAll("h2, h3")].find((each) => each.textContent.startsWith({json.dumps(name)}))?.parentElement.textContent ?? null')
        self.assertIsNotNone(found, name)
        return found

    def assert_in_order(self, text, *parts):
        at = 0
        for part in parts:
            self.assertIn(part, text[at:])
            at = text.index(part, at) + len(part)

    def assert_fits(self, width):
        self.assertLessEqual(self.browser.evaluate('document.documentElement.scrollWidth'), width)

    def test_the_example_at_every_width(self):
        for width in (1400, 800, 420):
            self.show(self.cooked / 'report.html', width)
            self.assert_fits(width)
        self.assertEqual(self.all('h1'), [self.report['scene']])
        self.assertEqual(self.all('header .verdict'), ['✓ passed'])
        self.assertIn('Every asset keeps its limit; ', self.all('.lead')[0])
        self.assertEqual(len(self.all('section.asset')), len(self.report['assets']))
        names = {file['file'] for file in self.report['files'] if file['file'].startswith('preview/')}
        self.assertEqual(len(self.all('figure img')), len(names))
        self.assertEqual(self.all('figure img', 'getAttribute("width")'), [str(width) for width in self.all('figure img', 'naturalWidth')])
        self.assertEqual(self.all('.missing'), [])
        # Each link leads to a section.
        for link in self.all('.assets a', 'hash.slice(1)'):
            self.assertEqual(len(self.all(f'section#{link}')), 1, link)
        for asset in self.report['assets']:
            self.assertGreater(len(self.all(f'.assets [title="{asset["bytes_gpu"]:,} bytes"]')), 0, asset['name'])
        self.assertNotRegex(self.browser.evaluate('document.querySelector("main").innerHTML'), r'\b(NaN|undefined|Infinity|\[object)')

    def boxes(self, selector):
        """Left, top, right and bottom of elements [CSS pixels]."""
        return self.browser.evaluate(f'''[...document.querySelectorAll({json.dumps(selector)})].map((each) => {{
            const {{ left, top, right, bottom }} = each.getBoundingClientRect();
            return [left, top, right, bottom];
        }})''')

    def test_the_first_screen_has_verdict_memory_pictures_and_opportunities(self):
        self.show(self.cooked / 'report.html', unfolded=False)
        for selector in ('header .verdict', 'header .sizes', '.opening .wipe', '.opening .opportunities li:has(code)'):
            boxes = self.boxes(selector)
            self.assertGreater(len(boxes), 0, selector)
            for left, top, right, bottom in boxes:
                self.assertTrue(0 <= left < right <= 1400 and 0 <= top < bottom <= 900, (selector, left, top, right, bottom))
        read = {asset['light'].get('bake', asset['name']) if asset['kind'] in ('light-map', 'dominant') else asset['name']: asset['bytes_in'] for asset in self.report['assets']}
        self.assertEqual(self.all('.sizes dd > *', 'title') + self.all('.sizes b > *', 'title'),
                         [f'{sum(read.values()):,} bytes', '', f'{self.report["budget"]["used_bytes"]:,} bytes'])
        self.assertRegex(self.all('.sizes dd')[0], r'^[0-9.]+ MiB → [0-9.]+ [KM]iB$')

    def test_bake_and_cooked_are_wiped(self):
        report, light_map = self.edited()
        worst = max((place for place in light_map['preview']['worst'] if 'view' in place), key=lambda place: place['visible'])
        self.show(self.cooked / 'report.html')
        pictures = [self.browser.evaluate(f'JSON.parse(document.getElementById("data").textContent).pictures[{json.dumps(worst["view"][side])}]') for side in ('reference', 'cooked')]
        self.assertEqual(self.all('.wipe img', 'src'), pictures)
        self.assertEqual(self.all('.wipe .side'), ['Bake', 'Cooked'])
        self.assertIn(f'around texel {worst["texel"][0]}, {worst["texel"][1]}', self.section('Before and after, at the worst place of diffuse light'))
        # "inset(0px 0px 0px 75%)": the cooked picture begins there.
        begins = lambda: float(self.browser.evaluate('getComputedStyle(document.querySelector(".wipe .after")).clipPath').split()[-1].rstrip('%)'))  # noqa: E731
        self.assertEqual(begins(), float(self.all('.wipe input', 'value')[0]))
        self.browser.click('.wipe input', 0.75)
        at = begins()
        self.assertAlmostEqual(at, 75, delta=3)
        self.browser.press('ArrowLeft', 'ArrowLeft')
        self.assertLess(begins(), at)
        # Without views of the mesh: the texels.
        for place in light_map['preview']['worst']:
            place.pop('view', None)
        self.show_report(report)
        self.assertIn(f'The texels of the light map {light_map["name"]}, not a view of the scene.', self.section('Before and after'))
        self.assertEqual(self.all('.wipe .side'), ['Reference', 'Cooked'])
        self.assertEqual(self.all('.wipe img', 'naturalWidth'), [256, 256])

    def test_assets_that_passed_are_folded(self):
        report, light_map = self.edited()
        light_map['passed'] = report['passed'] = False
        self.show_report(report, unfolded=False)
        opened = [asset['name'] == light_map['name'] for asset in report['assets']]
        self.assertEqual(self.all('.asset > details', 'open'), opened)
        last = self.all('.assets tbody th a', 'getAttribute("href")')[-1]
        self.browser.click(f'.assets a[href="{last}"]')
        self.browser.evaluate('new Promise((done) => setTimeout(done, 50))')
        self.assertEqual(self.all(f'{last} > details', 'open'), [True])
        self.browser.evaluate('dispatchEvent(new Event("beforeprint"))')
        self.assertEqual(set(self.all('.asset > details', 'open')), {True})
        self.browser.evaluate('dispatchEvent(new Event("afterprint"))')
        self.assertEqual(self.all('.asset > details', 'open'), [*opened[:-1], True])

    def test_the_table_of_assets_fits_narrow_screens(self):
        report, light_map = self.edited()
        light_map['limit']['max_visible_bound'] = 50
        light_map['name'] = 'a_long_name_of_a_light_map_of_the_northern_hall'
        for bounded in (False, True):
            for width in (800, 420):
                if bounded:
                    self.show_report(report, width=width)
                else:
                    self.show(self.cooked / 'report.html', width)
                [frame] = self.boxes('.scroll:has(.assets)')
                shown = [box for box in self.boxes('.assets :is(.verdict, .num, .shading)') if box[2] > box[0]]
                self.assertGreaterEqual(len(shown), 5 * len(report['assets']))
                for box in shown:
                    self.assertTrue(frame[0] <= box[0] and box[2] <= frame[2] + 0.5, (width, bounded, box, frame))

    def test_nothing_from_outside_becomes_markup(self):
        report, light_map = self.edited()
        report['scene'] = light_map['name'] = light_map['layout'] = EVIL
        light_map['stages'][0]['name'] = EVIL
        light_map['notes'] = {EVIL: EVIL}
        for key in ('role', 'format'):
            light_map['textures'][0][key] = EVIL
        report['skipped'] = [{'what': EVIL, 'why': EVIL, 'asset': EVIL, 'bytes_saved': 1, 'seconds_saved': 1}]
        self.show_report(report)
        self.assertIsNone(self.browser.evaluate('window.evil ?? null'))
        self.assertEqual(self.all('main script, main img[src=x]'), [])
        self.assertEqual(self.all('h1'), [EVIL])
        self.assertEqual(self.browser.evaluate('document.title'), f'{EVIL}: failed')
        self.assertIn(EVIL, self.section('Skipped'))
        self.assertEqual(len(self.all('section.asset')), len(report['assets']))

    def test_what_is_skipped_for_one_reason_is_one_row(self):
        report, light_map = self.edited()
        report['skipped'] = [{'what': f'levels of probe{i}', 'why': 'too rough', 'asset': f'probe{i}', 'bytes_saved': 1024, 'seconds_saved': None} for i in range(3)]
        report['skipped'] += [{'what': f'{step}/specular', 'why': 'nothing that it depends on has changed', 'bytes_saved': 0, 'seconds_saved': 0.5} for step in ('cook', 'verify')]
        self.show_report(report)
        rows = [' '.join(text.split()) for text in self.all('.skips tbody tr', 'innerText')]
        self.assertEqual(rows, ['levels of probe0 and 2 more too rough 3.00 KiB –', '2 results taken from the cache 0 B 1.00 s', 'Together 3.00 KiB 1.00 s'])

    def test_names_of_figures_are_those_of_the_guide(self):
        report, light_map = self.edited()
        light_map['choice'] = 'basis-4+lit@5.65685'
        light_map['whole'] = {'visible': {'rms': 1, 'p50': 1, 'p95': 2, 'p99': 4.56, 'p999': 5, 'max': 6}, 'rel_rms': 0.01, 'places': 10, 'max_visible': 5}
        self.show_report(report)
        self.assertEqual(self.all('.assets thead th')[5:], ['Shading', 'RMS error', 'Visible error'])
        row = next(text for text in self.all('.assets tbody th') if text.startswith(light_map['name']))
        self.assertIn('basis-4, detail', row)
        self.assertIn('visible error of the whole shading 4.56 of 5', row)
        shown = self.browser.evaluate('document.querySelector("main").innerText').split('What the figures mean')[0]
        for jargon in ('rel_rms', 'p99', '+lit@'):
            self.assertNotIn(jargon, shown)

    SEAM = {'shading': 'diffuse', 'position': [1, 2, 3], 'edge': [[0, 0, 0], [1, 1, 1]], 'normal': [0, 1, 0], 'added': 20.25, 'bake_step': 0.5, 'cooked_step': 20.75,
            'texels': [[1.5, 2], [3, 4]], 'reference': [[0.1, 0.2, 0.3], [0.1, 0.2, 0.3]], 'found': [[0.5, 0.2, 0.3], [0.1, 0.2, 0.3]]}

    def test_failures_are_those_of_the_report(self):
        report, light_map = self.edited()
        light_map['passed'] = report['passed'] = False
        light_map['limit'].update({'value': 0.001, 'max_visible': 0.5})
        message = 'found rel_rms 0.031, expected at most 0.001 (max_error); worst at texel (1, 2)'
        light_map['failures'] = [{'asset': light_map['name'], 'kind': 'light-map', 'stage': 'total', 'subject': f"{light_map['name']}, stage total, diffuse", 'detail': message,
                                  'message': f"{light_map['name']}, stage total, diffuse: {message}"}]
        light_map['failures'][0]['advice'] = 'light_map_layout = "basis-8" keeps the limit. A limit of 0.04 allows it.'
        report['budget'].update({'limit_bytes': 1024, 'advice': 'The largest asset is the light map.'})
        report['incomplete'] = {'assets': ['sky2'], 'errors': []}
        self.show_report(report, width=420)
        self.assert_fits(420)
        self.assertEqual(self.all('header .verdict'), ['✗ failed'])
        self.assert_in_order(self.all('.lead')[0], 'Not cooked: sky2. 1 of ', ' failed; ')
        self.assertRegex(self.all('.first-facts .over')[0], r' % used, .* over$')
        first, memory = self.all('.failures li')
        self.assertEqual(first, f"{light_map['name']}: diffuse: found an RMS error of 0.031, expected at most 0.001 (max_error){light_map['failures'][0]['advice']}"
                         'The worst placeAt texel (1, 2).')
        self.assertEqual(self.all('.failures code'), ['light_map_layout = "basis-8"'])
        self.assertRegex(memory, r'^memory budget: .* of 1\.00 KiB used \(.* %\), .* overThe largest asset is the light map\.$')
        self.assertGreater(len(self.all('.assets .over .meter')), 0, 'figures over their limit')
        # Where seams alone failed, the picture is that of the worst seam.
        light_map['failures'][0]['seam'] = 43
        light_map['seams'] = {**light_map['seams'], 'worst': [self.SEAM]}
        light_map['preview']['seams'] = [light_map['preview']['worst'][0]['view']]
        self.show_report(report, width=420, unfolded=False)
        self.assertEqual(self.all('.opening h2')[0], 'Before and after, at the worst seam')
        self.assertIn('Cooking adds a step of 20.3 there', self.all('.wipe + p')[0])
        self.assertEqual(len(self.all('.bar.over b')), 1)

    def test_every_part_of_an_asset(self):
        report, light_map = self.edited()
        stage = light_map['stages'][-1]
        steps = {'p99': 1.5, 'max': 20.25}
        place = self.SEAM
        seams = {'edges': 7, 'joined_edges': 6, 'hard_edges': 5, 'open_edges': 4, 'places': 1234, 'dark_places': 0, 'bake_diffuse': steps, 'worst': [place], 'worst_of_bake': [place],
                 'stages': [{'name': 'total', 'diffuse': {'added': steps, 'cooked': steps}}]}
        view = {key: light_map['preview']['worst'][0]['view'][key] for key in light_map['preview']['worst'][0]['view']}
        self.assertIn('note', light_map['seams'])
        light_map['seams'], light_map['preview']['seams'] = seams, [view]
        light_map['mips'] = [dict(stage, name='mip 1')]
        light_map['mip_blends'] = [dict(stage, name='mip 0 to 1')]
        light_map['mips_end'] = 'charts would touch'
        light_map['notes'] = {'covered_texels': 812345, 'clamped_high': 0, 'formats_tried': {'bc7': 0.5}}
        light_map['charts']['few_texels'] = [{'shading': 'specular', 'texels': 3.2, 'advice': 'The chart of the largest error has 3 texels.'}]
        light_map['trial_candidates'] = [
            {'layout': name, 'bytes_gpu': size, 'bits_per_texel': size / 100, 'diffuse': error, 'specular': error / 2, 'visible_diffuse': 100 * error, 'visible_specular': 150 * error,
             'fetches': 2, 'decode_ops': size // 10, 'table_bytes': 0, **more}
            for name, size, error, more in (('tiny', 800, 0.2, {}), ('small', 1200, 0.03, {}), ('hdr', 2400, 0.01, {}), ('other', 3000, 0.001, {'excluded': True}), ('large', 4800, 0.002, {}))]
        light_map['better_excluded'] = {'layout': 'other', 'bytes_saved': -600, 'rel_rms': 0.01, 'rel_rms_then': 0.001, 'visible': 1.5, 'visible_then': 0.1}
        report['findings'] = [{'code': 'stale-bake', 'asset': '', 'severity': 'warning', 'file': 'map.exr', 'found': 'an old bake', 'figures': {}, 'advice': 'bake again',
                               'place': {'section': '', 'name': '', 'key': ''}, 'allowed': 'on purpose'}]
        report['budget'].update({'limit_bytes': 300 << 10, 'used_bytes': 200 << 10, 'frontier': [
            {'bytes_gpu': size << 10, 'visible': visible, 'chosen': chosen, 'layouts': [{'light_map': 'map', 'layout': layout}]}
            for size, visible, chosen, layout in ((100, 20, False, 'basis-3'), (200, 8, True, 'basis-4'), (400, 0, False, 'raw'))]})
        self.show_report(report)
        self.assert_in_order(self.section('Seams, in'), '1,234 places of 7 edges that two charts share; 6 edges', 'bake', '1.50', '20.25', 'cooked, whole asset', 'added, whole asset',
                             'Largest steps that cooking adds', 'diffuse, at (1, 2, 3)', '(1.5, 2) | (3, 4)', 'the mesh around the seam diffuse, at (1, 2, 3)', 'Largest steps of the bake itself')
        self.assert_in_order(self.section('Mip levels'), 'mip 0 to 1', 'mip 1', '2 levels with level 0; no further one: charts would touch.')
        notes = self.section('Notes')
        self.assert_in_order(notes, 'Texels inside charts', '812,345', 'Errors of the format bc7', '0.500')
        self.assertNotIn('clamped', notes)
        self.assertIn('The chart of the largest error has 3 texels', self.all('table.worst:not(.seams)')[0])
        self.assert_in_order(self.section('Layouts tried'), 'tiny', 'small (next cheaper)', 'hdr (chosen)', 'other (not in layouts)', 'large (next better)')
        self.assertEqual([len(self.all(f'.candidates tr')), len(self.all('.columns .curve')), len(self.all('.columns .curve .dot')), len(self.all('.columns .curve g.chosen'))], [6, 4, 20, 4])
        self.assert_in_order(self.section('Charts: memory'), ' charts. Areas are GPU memory', 'below 1', 'between charts')
        self.assertGreater(len(self.all('.histogram rect.diffuse')), 3)
        self.assertIn('with layout other in the scene\'s layouts it costs 600 B more', self.section('What limits what'))
        self.assert_in_order(self.section('Plausibility'), 'stale-bake', 'the scene', 'an old bake', 'bake again', 'allowed: on purpose')
        self.assert_in_order(self.section('What another budget buys'), '200 KiB more take the visible error from 8.00 to 0 (map: raw',
                             '100 KiB less take the visible error from 8.00 to 20.0 (map: basis-3).', 'map: basis-4 (chosen)')
        self.assert_in_order(self.section('The '), '100 % less visible error of the whole shading, for 200 KiB more', 'falls from 8.00 to 0: map as raw',
                             'budget = "400 KiB"', 'in [output]')
        self.assert_in_order(self.section('Error of the whole shading'), 'RMS', ' of the squared error (', 'Share of the squared error')
        self.assertEqual(self.all('svg', 'outerHTML.match(/NaN|undefined|Infinity/)'), [None] * len(self.all('svg')))

    def test_figures_that_are_not_finite_or_absent(self):
        report, light_map = self.edited()
        figures = light_map['stages'][-1]['error']['diffuse']
        figures['rel_rms'] = None
        light_map['preview']['cooked'] = 'preview/none.png'
        for key in ('charts', 'seams', 'worst_block', 'key', 'light'):
            light_map.pop(key, None)
        report.pop('whole', None)
        self.show_report(report)
        self.assertIn('not finite', self.all('.assets .over')[0])
        self.assertEqual(self.all('.missing'), ['picture missing: preview/none.png'])

    def test_pictures_at_other_exposures_in_turn_and_enlarged(self):
        self.show(self.cooked / 'report.html')
        self.browser.evaluate('(() => { const range = document.querySelector(".tools input"); range.value = 2; range.dispatchEvent(new Event("input")); })()')
        self.assertEqual(set(self.all('.tools output')), {'2 stops'})
        self.assertEqual(len(self.all('img.light.exposed')), len(self.all('img.light')))
        table = [float(value) for value in self.all('#exposure feFuncR', 'getAttribute("tableValues")')[0].split(' ')]
        light = lambda code: (code / 255) ** 2.2 / (1 - (code / 255) ** 2.2)  # noqa: E731
        for code in (10, 100, 200):
            self.assertAlmostEqual(table[code], (4 * light(code) / (1 + 4 * light(code))) ** (1 / 2.2), delta=1e-4)
        first, second = self.all('.lit:has(img) img.light', 'src')[:2]
        self.browser.evaluate('[...document.querySelectorAll(".tools button")][0].click()')
        self.browser.evaluate(f'''new Promise((done) => {{
            const poll = () => document.querySelector(".lit img").src === {json.dumps(second)} ? done(1) : setTimeout(poll, 20);
            poll();
        }})''')
        self.assertIn('Cooked', self.all('.lit figcaption')[0])
        self.browser.evaluate('[...document.querySelectorAll(".tools button")][0].click()')
        self.assertEqual(self.all('.lit img', 'src')[0], first)
        self.assertIn('Reference', self.all('.lit figcaption')[0])
        self.browser.evaluate('document.querySelector("figure img").click()')
        self.assertEqual(self.all('dialog', 'open'), [True])
        before = self.all('dialog img', 'clientWidth')[0]
        self.browser.evaluate('document.querySelectorAll("dialog button")[1].click()')
        self.assertEqual(self.all('dialog img', 'clientWidth')[0], 2 * before)

    def test_several_scenes_with_budgets_baseline_and_history(self):
        other, page, history = self.folder / 'other', self.folder / 'all.html', self.folder / 'history.jsonl'
        shutil.copytree(self.cooked, other, dirs_exist_ok=True)
        for name in ('report.json', 'cooked.json'):
            document = json.loads((other / name).read_text())
            document['scene'] = 'roof'
            (other / name).write_text(json.dumps(document))
        (self.folder / 'budgets.toml').write_text('schema = 1\n[[platform]]\nname = "phone"\nscene = "1 KiB"\n')
        smaller = copy.deepcopy(self.report)
        light_map = next(asset for asset in smaller['assets'] if asset['kind'] == 'light-map')
        light_map['bytes_gpu'] -= 1024
        light_map['stages'][-1]['error']['diffuse']['rel_rms'] /= 2
        smaller['budget']['used_bytes'] -= 1024
        (self.folder / 'old.json').write_text(json.dumps(smaller))
        for scenes in ([self.cooked], [self.cooked, other]):
            run(LIGHTCOOK, 'report', *scenes, '--html', page, '--history', history, '--budgets', self.folder / 'budgets.toml', '--baseline', self.folder / 'old.json', okay=(0, 3, 4, 5))
            self.show(page, 420)
            self.assert_fits(420)
            self.assert_in_order(self.section('Budgets of platforms'), 'phone', '✗ failed', 'Limit', '✗ failed')
            self.assert_in_order(self.section('Compared with the baseline'), 'old.json', '→', 'Where errors grew', 'errors now')
            history.write_text(history.read_text().replace('"bytes_gpu":', '"bytes_gpu":1'))  # the next report is another step
        self.assertEqual(self.all('h1'), ['2 scenes'])
        self.assert_in_order(self.section('What failed'), 'roof: ', 'phone')
        self.assert_in_order(self.section('Over time'), 'GPU memory of all scenes', '2 steps. Red dots: a scene failed.')
        scene = self.report['scene']
        self.assertEqual(sorted(self.all('.scenes tbody a', 'getAttribute("href")')), ['cooked/report.html', 'other/report.html'])
        self.browser.evaluate('document.querySelector(".scenes .sort").click()')
        self.assertEqual(self.all('.scenes tbody a'), sorted([scene, 'roof'], reverse=True))
        self.browser.evaluate('document.querySelector(".scenes .sort").click()')
        self.assertEqual(self.all('.scenes tbody a'), sorted([scene, 'roof']))
        self.browser.evaluate('(() => { const input = document.querySelector(".search input"); input.value = "ROOF"; input.dispatchEvent(new Event("input")); })()')
        self.assertEqual(self.all('.scenes tbody tr', 'hidden').count(False), 1)
        self.assertEqual(self.all('.search span'), ['1 of 2'])

    def test_without_scripts_there_are_verdict_and_table(self):
        self.browser.call('Emulation.setScriptExecutionDisabled', {'value': True})
        try:
            self.show(self.cooked / 'report.html', 420)
            self.assert_fits(420)
            self.assert_in_order(self.all('main')[0], self.report['scene'], 'passed: 6 of 6 assets passed', *[asset['name'] for asset in self.report['assets']])
            self.assertEqual(self.all('section'), [])
        finally:
            self.browser.call('Emulation.setScriptExecutionDisabled', {'value': False})

    def test_dark_and_printed(self):
        background = 'getComputedStyle(document.body).backgroundColor'
        try:
            for scheme, color in (('light', 'rgb(245, 245, 242)'), ('dark', 'rgb(21, 23, 26)')):
                self.browser.prefer(scheme)
                self.show(self.cooked / 'report.html')
                self.assertEqual(self.browser.evaluate(background), color)
            self.browser.call('Emulation.setEmulatedMedia', {'media': 'print', 'features': [{'name': 'prefers-color-scheme', 'value': 'dark'}]})
            self.assertEqual(self.browser.evaluate(background), 'rgb(255, 255, 255)')
            self.assertEqual(set(self.all('.tools', 'offsetHeight')), {0})
        finally:
            self.browser.call('Emulation.setEmulatedMedia', {'media': ''})
            self.browser.prefer('light')


if __name__ == '__main__':
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
