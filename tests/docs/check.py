#!/usr/bin/env python3
"""Checks the documents of the repository: tests/docs/check.py ROOT

- Prose wraps at 100 columns. Tables, code blocks and images may be longer.
- The fence of a code block has a line of its own, with the language at most, and every block is closed.
- A block of TOML can be parsed.
- Every row of a table has as many cells as its head.
- Every relative link names a file of the repository, and a heading of it where the link has a fragment.
- Every page that a source file names exists (docs/theory/lighting.md).
- Nothing names notes outside the repository.
"""
import pathlib
import re
import subprocess
import sys
import tomllib

WIDTH = 100
OUTSIDE_NOTES = re.compile(r"shared/design|product\.md|lighting-math|debian\.md|targets\.md|architecture\.md")
PAGE = r"\bdocs/[a-z/-]+\.md\b"
THIS = "tests/docs/check.py"
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")  # its text may wrap


def prose_lines(text):
    """(line number, line) outside of code blocks."""
    in_code = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            in_code = not in_code
        elif not in_code:
            yield number, line


def code_blocks(text):
    """(line number of the opening fence, the fence, the lines, True if it is closed) of every code block."""
    opening = None
    for number, line in enumerate(text.splitlines(), 1):
        is_fence = line.lstrip().startswith("```")
        if opening is None and is_fence:
            opening, lines = (number, line.strip()), []
        elif opening is not None and is_fence:
            yield *opening, lines, True
            opening = None
        elif opening is not None:
            lines.append(line)
    if opening is not None:
        yield *opening, lines, False


def check_code(name, text):
    """One line for each mistake in the code blocks of a page."""
    for number, fence, lines, is_closed in code_blocks(text):
        place = f"{name}:{number}"
        if not re.fullmatch(r"```\w*", fence):
            yield f"{place}: found {fence}, expected a fence with the language at most"
        if not is_closed:
            yield f"{place}: found a code block without an end, expected a line ```"
        if fence == "```toml":
            try:
                tomllib.loads("\n".join(lines))
            except tomllib.TOMLDecodeError as mistake:
                yield f"{place}: found TOML that cannot be parsed ({mistake})"


def cell_count(row):
    return len(re.findall(r"(?<!\\)\|", row.strip())) - 1


def anchors(text):
    """The fragments that GitHub makes of the headings."""
    found = set()
    for _, line in prose_lines(text):
        if match := re.match(r"#+ +(.*)", line):
            heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", match.group(1)).lower()
            slug = re.sub(r"[^\w\- ]", "", heading).replace(" ", "-")
            copies = 0
            while (slug if copies == 0 else f"{slug}-{copies}") in found:
                copies += 1
            found.add(slug if copies == 0 else f"{slug}-{copies}")
    return found


def links(name, text):
    """(place, target) of every link outside of code."""
    lines = [""] * (text.count("\n") + 1)
    for number, line in prose_lines(text):
        lines[number - 1] = re.sub(r"`[^`]*`", "", line)
    prose = "\n".join(lines)
    for match in LINK.finditer(prose):
        yield f"{name}:{prose.count(chr(10), 0, match.start()) + 1}", match.group(1)


def check_sources(root):
    """One line for each page that a source file names and that does not exist."""
    listed = subprocess.run(["git", "grep", "-nIoE", PAGE, "--", ".", ":!*.md"], cwd=root, capture_output=True, text=True)
    for found in listed.stdout.splitlines():
        file, number, page = found.split(":", 2)
        if not (root / page).exists():
            yield f"{file}:{number}: found {page}, expected a page that exists"
    named = subprocess.run(["git", "grep", "-nIoE", OUTSIDE_NOTES.pattern, "--", ".", ":!*.md", f":!{THIS}"], cwd=root, capture_output=True,
                           text=True)
    for found in named.stdout.splitlines():
        file, number, note = found.split(":", 2)
        yield f"{file}:{number}: found {note}, expected no reference to notes outside the repository"


def check(root):
    """One line for each mistake."""
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=root, capture_output=True, text=True, check=True).stdout.split()
    for name in listed:
        page = root / name
        text = page.read_text(encoding="utf-8")
        head = None  # cells of the first row of the table that the line is in
        for number, line in prose_lines(text):
            place = f"{name}:{number}"
            if not line.lstrip().startswith("|"):
                head = None
            elif head is None:
                head = cell_count(line)
            elif cell_count(line) != head:
                yield f"{place}: found {cell_count(line)} cells, expected {head} as in the head of the table"
            if len(line) > WIDTH and not line.lstrip().startswith(("|", "![")):
                yield f"{place}: found {len(line)} columns, expected at most {WIDTH}"
            if match := OUTSIDE_NOTES.search(line):
                yield f"{place}: found \"{match.group()}\", expected no reference to notes outside the repository"
        yield from check_code(name, text)
        for place, target in links(name, text):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, fragment = target.partition("#")
            file = (page.parent / path).resolve() if path else page
            if not file.exists():
                yield f"{place}: found a link to {target}, expected a file that exists"
            elif fragment and fragment not in anchors(file.read_text(encoding="utf-8")):
                yield f"{place}: found a link to {target}, expected a heading of that page"


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    mistakes = [*check(root), *check_sources(root)]
    print("\n".join(mistakes))
    sys.exit(1 if mistakes else 0)


if __name__ == "__main__":
    main()
