#!/usr/bin/env python3
"""Compares docs/reference/commands.md with the help of the program: tests/docs/reference_test.py ROOT LIGHTCOOK

- Every line of code in the notes of a command is a line of a code block in its section.
- Every paragraph of the notes is in its section, with other line breaks.
"""
import json
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from check import code_blocks  # noqa: E402


def sections(page):
    """The text of each section, by its heading."""
    parts = re.split(r"^## (.+)$", page, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2]))


def check(page, commands):
    """One line for each part of the notes that a section lacks."""
    found = sections(page)
    for command in commands:
        name, section = command["name"], found.get(command["name"], "")
        blocks = [lines for _, _, lines, _ in code_blocks(section)]
        words = " ".join(section.split())
        for part in re.split(r"\n{2,}", command["notes"]):
            lines = part.split("\n")
            if all(line.startswith("  ") for line in lines):
                if [line[2:] for line in lines] not in blocks:
                    yield f"{name}: found no code block with the lines {lines}"
            elif " ".join(part.split()) not in words:
                yield f"{name}: found no paragraph {part!r}"


def main():
    root, program = pathlib.Path(sys.argv[1]), sys.argv[2]
    printed = subprocess.run([program, "help", "--json", "-"], capture_output=True, text=True, check=True).stdout
    commands = json.loads(printed)["commands"]
    mistakes = list(check((root / "docs/reference/commands.md").read_text(encoding="utf-8"), commands))
    if not any("\n  " in command["notes"] for command in commands):
        mistakes.append("found no code in the notes of any command, expected that of `plan`")
    print("\n".join(mistakes))
    sys.exit(1 if mistakes else 0)


if __name__ == "__main__":
    main()
