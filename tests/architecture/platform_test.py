#!/usr/bin/env python3
"""Keeps what only Linux has (beyond POSIX) in the files named here: tests/architecture/platform_test.py ROOT

A port to another system replaces these files and no others.
"""
import pathlib
import re
import subprocess
import sys

MODULES = ("lighting", "formats", "atlas", "compress", "fit", "shaders", "verify", "pipeline")
ALLOWED = {
    "formats/memory.h": "free memory of machine and control group",
    "formats/process.h": "folder of the program",
    "formats/reader/one_file.cpp": "files that a reader can open",
    "formats/reader/reader_process.cpp": "memory that a reader shares",
    "formats/reader/reader_server.cpp": "end of a reader with the program",
    "formats/reader/walls.cpp": "Landlock, seccomp",
}
LINUX = re.compile(
    r'"/(proc|sys)/|<linux/|<sys/(epoll|eventfd|inotify|prctl|random|sendfile|signalfd|syscall|sysinfo|timerfd|vfs)\.h>|\b(O_TMPFILE|O_PATH|'
    r"AT_EMPTY_PATH|SOCK_CLOEXEC|accept4|copy_file_range|fallocate|getauxval|getrandom|gettid|mallinfo2?|malloc_trim|memfd_create|pidfd_\w+|"
    r"pipe2|prctl|renameat2|sched_\w+affinity|signalfd|sync_file_range|syscall)\b")


def found_in(text):
    """(line number, match) outside of comments that fill a line."""
    for number, line in enumerate(text.splitlines(), 1):
        match = LINUX.search(line)
        if match and not line.lstrip().startswith("//"):
            yield number, match.group()


def check(texts, allowed):
    """One line for each mistake. `texts`: file name -> content."""
    used = {name: list(found_in(text)) for name, text in texts.items()}
    for name, places in used.items():
        if name not in allowed:
            yield from (f"{name}:{number}: found {what}, which only Linux has; expected it in {', '.join(allowed)}" for number, what in places)
    yield from (f"{name}: found nothing that only Linux has, expected no row for it in {pathlib.Path(__file__).name}" for name in allowed
                if not used.get(name))


def check_itself():
    planted = {"a.cpp": 'read("/proc/self/exe");\n', "b.cpp": "// /proc\nint prctl_count = open(name);\n", "c.cpp": "int x;\n"}
    found = list(check(planted, {"c.cpp": ""}))
    assert len(found) == 2 and found[0].startswith("a.cpp:1:") and found[1].startswith("c.cpp:"), found


def main():
    check_itself()
    root = pathlib.Path(sys.argv[1])
    patterns = [f"{module}/*.{suffix}" for module in MODULES for suffix in ("cpp", "h")]
    names = subprocess.run(["git", "ls-files", *patterns], cwd=root, capture_output=True, text=True, check=True).stdout.split()
    mistakes = list(check({name: (root / name).read_text(encoding="utf-8") for name in names}, ALLOWED))
    print("\n".join(mistakes) or f"{len(names)} sources, {len(ALLOWED)} of them with what only Linux has")
    sys.exit(1 if mistakes or not names else 0)


if __name__ == "__main__":
    main()
