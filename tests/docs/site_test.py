#!/usr/bin/env python3
"""Renders the documentation site and reads it: tests/docs/site_test.py ROOT [--pictures FOLDER]

- Every page of the repository has one of the site, and nothing is fetched from elsewhere.
- Every link of a page leads to a file of the site, and to an element of it where the link has a fragment.
- In a browser: the search finds a page and opens it at the place; pages fit 420 pixels; light and dark differ.

Exits with 77, which ctest reports as skipped, where the generator or the browser is not installed.
"""
import argparse
import html.parser
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "viewer"))
from browser import Browser, PATIENCE, serve  # noqa: E402

PAGES = ("index", "docs/guide/your-first-scene", "docs/guide/mistakes", "docs/reference/commands", "docs/theory/layouts", "docs/lab/verify")
LOADING = {"script": "src", "img": "src", "iframe": "src", "link": "href"}


class Page(html.parser.HTMLParser):
    """The ids, the links and the loaded resources of a page."""

    def __init__(self, file):
        super().__init__()
        self.ids, self.links, self.loads = set(), [], []
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.ids.add(values.get("id"))
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        if tag in LOADING and values.get(LOADING[tag]):
            self.loads.append(values[LOADING[tag]])


def render(root, folder):
    program = root / "docs/site/node_modules/vitepress/bin/vitepress.js"
    if not program.exists() or not shutil.which("node"):
        print("skipped: the generator of the site is not installed: run ./dev setup site")
        sys.exit(77)
    done = subprocess.run(["node", program, "build", root / "docs/site"], env={**os.environ, "LIGHTCOOK_SITE": str(folder)}, capture_output=True,
                          text=True)
    if done.returncode:
        sys.exit(f"the site was not rendered:\n{done.stdout}{done.stderr}")


def file_of(folder, page, path):
    """The file of the site that a link names, seen from a page."""
    if path.startswith("/"):
        file = folder / path.lstrip("/")
    else:
        file = page.parent / path if path else page
    return file / "index.html" if file.is_dir() else file.resolve()


def check_files(root, folder):
    """One line for each page that is missing and each link that leads nowhere."""
    names = subprocess.run(["git", "ls-files", "*.md"], cwd=root, capture_output=True, text=True, check=True).stdout.split()
    for name in names:
        rendered = folder / ("index.html" if name == "README.md" else name.replace(".md", ".html"))
        if not rendered.exists():
            yield f"{name}: found no page of the site, expected {rendered.relative_to(folder)}"
            continue
        pictures = len(re.findall(r"^!\[", (root / name).read_text(encoding="utf-8"), re.M))
        if (found := rendered.read_text(encoding="utf-8").count("<img ")) != pictures:
            yield f"{name}: found {found} pictures on the page of the site, expected {pictures}"
    pages = {file: Page(file) for file in folder.rglob("*.html")}
    for file, page in pages.items():
        place = file.relative_to(folder)
        yield from (f"{place}: found {url}, expected nothing that is loaded from elsewhere" for url in page.loads if re.match(r"\w+:|//", url))
        for url in page.links + page.loads:
            if re.match(r"\w+:", url):
                continue
            path, _, fragment = urllib.parse.unquote(url).partition("#")
            target = file_of(folder, file, path)
            if not target.exists():
                yield f"{place}: found a link to {url}, expected a file of the site"
            elif fragment and fragment not in pages[target].ids:
                yield f"{place}: found a link to {url}, expected an element with that id"


def wait_for(browser, expression):
    deadline = time.monotonic() + PATIENCE
    while not (value := browser.evaluate(expression)):
        if time.monotonic() > deadline:
            raise RuntimeError(f"waited in vain for {expression}")
        time.sleep(0.05)
    return value


def go(browser, url):
    browser.call("Page.navigate", {"url": url})
    wait_for(browser, f"location.href == {json.dumps(url)} && document.readyState == 'complete' && !!document.querySelector('#app')?.__vue_app__")


def found_by_search(browser, address, words):
    """The addresses of the results of a search, best first."""
    go(browser, address)
    wait_for(browser, "document.querySelector('#local-search button') && (document.querySelector('#local-search button').click(), true)")
    wait_for(browser, "!!document.querySelector('#localsearch-input')")
    browser.call("Input.insertText", {"text": words})
    wait_for(browser, "document.querySelectorAll('#localsearch-list a.result').length > 0")
    return browser.evaluate("[...document.querySelectorAll('#localsearch-list a.result')].map((a) => a.href)")


def check_search(browser, address):
    for words, page in (("fireflies", "docs/guide/from-a-baker-to-a-scene"), ("Condon-Shortley", "docs/theory/lighting"),
                        ("max_visible_bound", "docs/reference/scene-file")):
        found = found_by_search(browser, address, words)
        if not any(page in url for url in found):
            yield f"search for {words!r}: found {found}, expected also {page}"
    browser.evaluate("document.querySelector('#localsearch-list a.result').click()")
    wait_for(browser, "location.hash != '' && !!document.getElementById(decodeURIComponent(location.hash.slice(1)))")


def check_widths(browser, address):
    """Only tables and code may be wider than a small screen; they scroll on their own."""
    browser.resize(420, 800, True)
    for page in PAGES:
        go(browser, f"{address}{page}.html")
        width = browser.evaluate("document.documentElement.scrollWidth")
        if width > 420:
            yield f"{page}: found a page {width} pixels wide, expected at most 420"


def check_schemes(browser, address):
    luminances = {}
    for scheme in ("light", "dark"):
        browser.prefer(scheme)
        go(browser, f"{address}docs/theory/error.html?{scheme}")
        colour = browser.evaluate("getComputedStyle(document.body).backgroundColor")
        luminances[scheme] = sum(map(int, re.findall(r"\d+", colour)[:3]))
    if luminances["light"] < 600 or luminances["dark"] > 150:
        yield f"found backgrounds {luminances}, expected a light and a dark one"


def take_pictures(browser, address, folder):
    import base64

    folder.mkdir(parents=True, exist_ok=True)
    for width in (1400, 800, 420):
        for scheme in ("light", "dark"):
            browser.resize(width, 1000, width == 420)
            browser.prefer(scheme)
            for page in PAGES:
                go(browser, f"{address}{page}.html?{scheme}{width}")
                browser.settle()
                picture = base64.b64decode(browser.call("Page.captureScreenshot")["data"])
                (folder / f"{page.replace('/', '-')}-{width}-{scheme}.png").write_bytes(picture)


def check_in_browser(folder, pictures):
    if not shutil.which("chromium"):
        print("skipped: the search of the site was not tried: chromium is missing")
        sys.exit(77)
    server, address = serve(str(folder))
    browser = Browser(1400, 1000)
    try:
        browser.call("Network.enable")
        yield from check_search(browser, address)
        yield from check_widths(browser, address)
        yield from check_schemes(browser, address)
        if pictures:
            take_pictures(browser, address, pictures)
        requests = [event["params"]["request"]["url"] for event in browser.events if event.get("method") == "Network.requestWillBeSent"]
        yield from (f"the browser fetched {url}, expected nothing from elsewhere" for url in requests
                    if not url.startswith((address, "data:", "blob:")))
    finally:
        browser.close()
        server.shutdown()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("--pictures", type=pathlib.Path)
    arguments = parser.parse_args()
    root = arguments.root.resolve()
    with tempfile.TemporaryDirectory(prefix="lightcook-site-") as name:
        folder = pathlib.Path(name).resolve()
        render(root, folder)
        mistakes = [*check_files(root, folder)]
        mistakes += [] if mistakes else [*check_in_browser(folder, arguments.pictures)]
    print("\n".join(mistakes) or "every link leads somewhere, and the search finds")
    sys.exit(1 if mistakes else 0)


if __name__ == "__main__":
    main()
