"""A headless Chromium with one page, controlled by the DevTools protocol over two pipes, and a web server for a folder."""
import functools
import http.server
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
import threading
import time

PATIENCE = 120  # [s] timeout of an answer: software rasterization on a busy machine


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


def serve(folder):
    """Serves a folder on loopback in a thread. Returns the server and its URL."""
    server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), functools.partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return server, f'http://127.0.0.1:{server.server_address[1]}/'


class Browser:
    """Raises RuntimeError with the browser's reason where a call fails."""

    def __init__(self, width=1000, height=700):
        self.profile = tempfile.mkdtemp(prefix='lightcook-viewer-')
        to_read, to_write = os.pipe()
        from_read, from_write = os.pipe()

        def pipes():
            # Duplicated to free numbers first, so that neither dup2 overwrites the other's source.
            a, b = os.dup(to_read), os.dup(from_write)
            while a in (3, 4) or b in (3, 4):
                a, b = os.dup(a), os.dup(b)
            os.dup2(a, 3)
            os.dup2(b, 4)

        self.child = subprocess.Popen(
            ['chromium', '--headless', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist',
             '--disable-dev-shm-usage', '--no-first-run', '--hide-scrollbars', '--force-prefers-reduced-motion', f'--window-size={width},{height}',
             f'--user-data-dir={self.profile}', '--remote-debugging-pipe', 'about:blank'],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, preexec_fn=pipes, close_fds=False,
            start_new_session=True)
        os.close(to_read)
        os.close(from_write)
        self.to, self.from_ = to_write, from_read
        self.pending, self.last, self.session, self.events = b'', 0, None, []
        target = self.call('Target.createTarget', {'url': 'about:blank'})['targetId']
        self.session = self.call('Target.attachToTarget', {'targetId': target, 'flatten': True})['sessionId']
        self.call('Runtime.enable')
        self.call('Page.enable')

    def close(self):
        os.close(self.to)
        os.close(self.from_)
        try:
            os.killpg(self.child.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.child.wait()
        shutil.rmtree(self.profile, ignore_errors=True)

    def receive(self, deadline):
        while b'\0' not in self.pending:
            left = deadline - time.monotonic()
            if left <= 0 or not select.select([self.from_], [], [], left)[0]:
                raise RuntimeError('the browser does not answer')
            piece = os.read(self.from_, 1 << 20)
            if not piece:
                raise RuntimeError('the browser has ended')
            self.pending += piece
        message, self.pending = self.pending.split(b'\0', 1)
        return json.loads(message)

    def call(self, method, parameters=None):
        self.last += 1
        message = {'id': self.last, 'method': method, 'params': parameters or {}}
        if self.session:
            message['sessionId'] = self.session
        data = json.dumps(message).encode() + b'\0'
        while data:
            data = data[os.write(self.to, data):]
        deadline = time.monotonic() + PATIENCE
        while True:
            answer = self.receive(deadline)
            if answer.get('id') != self.last:
                self.events.append(answer)
                continue
            if 'error' in answer:
                raise RuntimeError(f"{method}: {answer['error'].get('message')}")
            return answer['result']

    def evaluate(self, expression):
        """Returns the value of an expression. Waits for a promise."""
        answer = self.call('Runtime.evaluate', {'expression': expression, 'returnByValue': True, 'awaitPromise': True})
        if 'exceptionDetails' in answer:
            details = answer['exceptionDetails']
            raise RuntimeError(details.get('exception', {}).get('description') or details.get('text'))
        return answer['result'].get('value')

    def resize(self, width, height, is_mobile=False):
        self.call('Emulation.setDeviceMetricsOverride', {'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': is_mobile})

    def prefer(self, scheme):
        self.call('Emulation.setEmulatedMedia', {'features': [{'name': 'prefers-color-scheme', 'value': scheme},
                                                              {'name': 'prefers-reduced-motion', 'value': 'reduce'}]})

    def open(self, url):
        """Opens a page of the viewer and waits until it has loaded. Raises RuntimeError with the page's own message."""
        self.events.clear()
        self.call('Page.navigate', {'url': 'about:blank'})
        self.call('Page.navigate', {'url': url})
        deadline = time.monotonic() + PATIENCE
        while not self.evaluate('!!window.lightcook'):
            if time.monotonic() > deadline:
                raise RuntimeError(f'{url}: the page did not start')
            time.sleep(0.05)
        self.evaluate('lightcook.ready')
        if self.evaluate('document.getElementById("loading").classList.contains("failed")'):
            raise RuntimeError(self.evaluate('document.getElementById("loading-text").textContent'))
        self.settle()

    def show(self, url):
        """Opens another page than the viewer's, and waits until it is complete."""
        self.events.clear()
        self.call('Page.navigate', {'url': 'about:blank'})
        self.call('Page.navigate', {'url': url})
        deadline = time.monotonic() + PATIENCE
        while self.evaluate('location.href + " " + document.readyState') != f'{url} complete':
            if time.monotonic() > deadline:
                raise RuntimeError(f'{url}: the page is not complete')
            time.sleep(0.05)

    def without_extensions(self, names):
        """Pages that are opened from now on see a WebGL2 without these extensions."""
        self.call('Page.addScriptToEvaluateOnNewDocument', {'source': f'''{{
            const names = {json.dumps(list(names))}, original = WebGL2RenderingContext.prototype.getExtension;
            WebGL2RenderingContext.prototype.getExtension = function (name) {{ return names.includes(name) ? null : original.call(this, name); }};
        }}'''})

    def place_of(self, selector, across=0.5):
        """A point of an element that is scrolled into view [CSS pixels]: its middle, or another share of its width."""
        box = self.evaluate(f'''(() => {{
            const element = document.querySelector({json.dumps(selector)});
            if (!element) return null;
            element.scrollIntoView({{ block: 'nearest' }});
            const {{ left, top, width, height }} = element.getBoundingClientRect();
            return width * height > 0 ? [left, top, width, height] : null;
        }})()''')
        if box is None:
            raise RuntimeError(f'{selector}: not on the page')
        return box[0] + across * box[2], box[1] + 0.5 * box[3]

    def mouse(self, kind, x, y, held=True):
        self.call('Input.dispatchMouseEvent', {'type': kind, 'x': x, 'y': y, 'button': 'left' if held else 'none', 'buttons': 1 if held else 0,
                                               'clickCount': 1})

    def click(self, selector, across=0.5):
        self.click_at(*self.place_of(selector, across))

    def click_at(self, x, y):
        self.mouse('mouseMoved', x, y, False)
        self.mouse('mousePressed', x, y)
        self.mouse('mouseReleased', x, y)
        self.settle()

    def drag(self, start, end):
        self.mouse('mouseMoved', *start, False)
        self.mouse('mousePressed', *start)
        for t in (0.25, 0.5, 0.75, 1):
            self.mouse('mouseMoved', *(a + t * (b - a) for a, b in zip(start, end)))
        self.mouse('mouseReleased', *end)
        self.settle()

    def drop(self, path, x, y):
        """Drops a file or a folder of this machine."""
        data = {'items': [], 'files': [str(path)], 'dragOperationsMask': 1}
        for kind in ('dragEnter', 'dragOver', 'drop'):
            self.call('Input.dispatchDragEvent', {'type': kind, 'x': x, 'y': y, 'data': data})

    def touch(self, moves):
        """Fingers that go down at the first of `moves` (a list of points each) and through the others."""
        for i, points in enumerate(moves):
            self.call('Input.dispatchTouchEvent', {'type': 'touchStart' if i == 0 else 'touchMove',
                                                   'touchPoints': [{'x': x, 'y': y, 'id': k} for k, (x, y) in enumerate(points)]})
        self.call('Input.dispatchTouchEvent', {'type': 'touchEnd', 'touchPoints': []})
        self.settle()

    def press(self, key, code, seconds=0.0):
        text = {'text': key} if len(key) == 1 else {}
        self.call('Input.dispatchKeyEvent', {'type': 'keyDown', 'key': key, 'code': code, **text})
        time.sleep(seconds)
        self.call('Input.dispatchKeyEvent', {'type': 'keyUp', 'key': key, 'code': code})
        self.settle()

    def settle(self):
        """Waits until everything is drawn."""
        self.evaluate('new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))')

    def problems(self):
        """Exceptions and errors that the page logged."""
        found = []
        for event in self.events:
            parameters = event.get('params', {})
            if event.get('method') == 'Runtime.exceptionThrown':
                found.append(parameters['exceptionDetails'].get('text', '') + ' ' +
                             str(parameters['exceptionDetails'].get('exception', {}).get('description', '')))
            if event.get('method') == 'Runtime.consoleAPICalled' and parameters['type'] in ('error', 'warning'):
                found.append(' '.join(str(a.get('value', a.get('description', ''))) for a in parameters['args']))
        return found

    def screenshot(self):
        """PNG of the page [bytes]."""
        import base64
        return base64.b64decode(self.call('Page.captureScreenshot', {'format': 'png'})['data'])
