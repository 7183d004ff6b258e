#!/usr/bin/python3
"""Runs the long tests for some time and prints one table of what was tried:
  run.py [MINUTES] [-R REGEX] [--sanitized PROGRAM...] [--not-sanitized TESTS]

Parts are the suites and scripts that ctest labels "soak", the test programs of the sanitizers' builds, and the fuzzers; REGEX selects some
by name. Each part gets an equal share of the time that is left when it begins, so what one does not need goes to those after it. Suites end
their loops, and begin no further test, when their share is over (soak.h). Tests come in another order each day, and parts that have waited
longest come first, so that each has its turn however short a run is. A script cannot be cut: all of them have a third of the time, and one
begins if its last run says that it ends within that.

Counts are the lines "soak: NUMBER UNIT" that the parts print. build/soak has the table, what every part printed, and those that failed in
build/soak/failed; bytes that break a parser lie in build/fuzz/found. Exit code 1: something failed.
"""
import argparse
import collections
import datetime
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
OUT = ROOT / "build/soak"
# Shares of parts that have many long cases.
LONG = {"Mutants.AreCaughtSoak": 8, "Cluster.KillsSoak": 8, "FaultsSoak": 4, "RightWorkSoak": 4, "Scenes/MagnifiedScenesSoak": 4,
        "Scenes/VisibleScenesSoak": 4}
SANITIZED = "under address and undefined-behaviour sanitizers"
SKIPPED = 77


class Part:
    def __init__(self, name, what, command, folder=ROOT, shares=1, timeout=1800):
        self.name, self.what, self.command, self.folder, self.shares, self.timeout = name, what, command, folder, shares, timeout
        self.is_script = not any("--gtest" in word for word in command)
        self.result, self.reasons = "", []
        self.passed = self.failed = self.skipped = self.not_begun = 0
        self.seconds = self.cpu = 0.0
        self.counts = collections.Counter()

    def run(self, seconds, left, environment):
        """Runs for `seconds`; a script as long as it takes, `left` at most."""
        log = OUT / "logs" / (self.name.replace("/", ".") + ".txt")
        limit = min(left, self.timeout) if self.is_script else seconds + self.timeout
        begin, used = time.monotonic(), children_seconds()
        with open(log, "wb") as output:
            process = subprocess.Popen(self.command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                                       env={**environment, "LIGHTCOOK_SOAK_SECONDS": f"{seconds:.1f}"}, start_new_session=True)
            try:
                code = process.wait(limit)
            except subprocess.TimeoutExpired:
                end(process)
                code = None
        self.seconds, self.cpu = time.monotonic() - begin, children_seconds() - used
        self.judge(code, log.read_text(errors="replace"), is_cut=code is None and limit == left)
        if self.failed:
            shutil.copy(log, OUT / "failed" / log.name)

    def judge(self, code, text, is_cut):
        for count, unit in re.findall(r"^soak: (\d+) (.+)$", text, re.M):
            self.counts[unit] += int(count)
        if self.is_script:
            self.passed, self.skipped, self.not_begun = int(code == 0), int(code == SKIPPED), int(is_cut)
            self.failed = 1 - self.passed - self.skipped - self.not_begun
            if is_cut:
                self.reasons = [f"takes longer than {self.seconds / 60:.0f} min"]
            elif code == SKIPPED:
                self.reasons = [re.sub("^skipped: ", "", line) for line in text.splitlines() if line.strip()][-1:]
            return
        self.passed = len(re.findall(r"^\[       OK \]", text, re.M))
        self.failed = len(re.findall(r"^\[  FAILED  \] .*\(\d+ ms\)$", text, re.M)) or int(code != 0)
        self.not_begun = len(re.findall(r"^no time left$", text, re.M))
        self.skipped = len(re.findall(r"^\[  SKIPPED \] .*\(\d+ ms\)$", text, re.M)) - self.not_begun
        self.reasons = sorted(set(re.findall(r": Skipped\n(?!no time left)(.+)", text)))


def children_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def end(process):
    """Ends a process and all that it started. An interrupt lets scripts stop their servers."""
    for number, patience in ((signal.SIGINT, 30), (signal.SIGKILL, 10)):
        try:
            os.killpg(process.pid, number)
            process.wait(patience)
        except (ProcessLookupError, subprocess.TimeoutExpired):
            pass


def parts_of_ctest():
    listing = subprocess.run(["ctest", "--test-dir", ROOT / "build/release", "--show-only=json-v1", "-L", "soak"], capture_output=True,
                             check=True, text=True).stdout
    for test in json.loads(listing)["tests"]:
        properties = {each["name"]: each["value"] for each in test.get("properties", [])}
        name = test["name"]
        command = list(test.get("command", ["false"]))
        if any("--gtest" in word for word in command):
            yield Part(name, "suites", command + ["--gtest_shuffle"], properties.get("WORKING_DIRECTORY", ROOT), LONG.get(name, 1))
        else:
            yield Part(name, "scripts", command, properties.get("WORKING_DIRECTORY", ROOT), LONG.get(name, 1),
                       properties.get("TIMEOUT", 1500))


def parts_of_sanitizers(programs, left_out):
    for program in programs:
        path = ROOT / "build/asan/tests" / program.split("_")[0] / program
        yield Part(f"asan:{program}", SANITIZED, [str(path), f"--gtest_filter=-{left_out}", "--gtest_shuffle"], path.parent, 2)


def fuzz(seconds, environment, part):
    """Fuzzes each target for `seconds`, and counts inputs and files that broke a parser."""
    begin, used = time.monotonic(), children_seconds()
    with open(OUT / "logs/fuzz.txt", "wb") as output:
        command = ["./dev", "fuzz", str(max(1, round(seconds)))]
        code = subprocess.run(command, cwd=ROOT, env=environment, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                              check=False).returncode
    part.seconds, part.cpu = time.monotonic() - begin, children_seconds() - used
    for log in sorted((ROOT / "build/fuzz/found").glob("*.log")):
        text = log.read_text(errors="replace")
        done = re.search(r"^Done (\d+) runs", text, re.M)
        part.counts["inputs of parsers"] += int(done[1]) if done else 0
        part.passed += 1 if done else 0
        part.failed += 0 if done else 1
        if not done:
            shutil.copy(log, OUT / "failed" / f"fuzz.{log.stem}.txt")
    part.failed = max(part.failed, int(code != 0))


def table(parts, minutes, seed):
    """Returns the table, with a row for each unit that was counted and for the other parts of a kind."""
    rows = collections.defaultdict(collections.Counter)
    for part in parts:
        counts = {} if part.what == SANITIZED else part.counts
        for unit, count in counts.items():
            rows[part.what, unit]["count"] += count
        for name in ("passed", "failed", "skipped", "not_begun", "cpu", "seconds"):
            rows[part.what, next(iter(counts), "")][name] += getattr(part, name)
    lines = ["| tried | count | tests passed | failed | skipped | not begun | CPU [min] | time [min] |",
             "|---|---:|---:|---:|---:|---:|---:|---:|"]
    total = collections.Counter()
    for (what, unit), row in sorted(rows.items(), key=lambda each: (each[0][0] != "suites", each[0])):
        name = f"{what}: {unit}" if unit and what != "suites" else unit or ("other suites" if what == "suites" else what)
        total.update({key: value for key, value in row.items() if key != "count"})
        lines.append("| " + " | ".join([name, amount(row["count"])] + figures(row)) + " |")
    lines.append("| " + " | ".join(["all", ""] + figures(total)) + " |")
    processors = os.cpu_count()
    head = (f"`./dev soak {minutes:g}` of {datetime.date.today()}, seed {seed}, {processors} processors, "
            f"{total['cpu'] / 3600:.1f} CPU hours in {total['seconds'] / 3600:.1f} hours.")
    notes = [f"- not run: {part.name}: {reason}" for part in parts for reason in part.reasons]
    notes += [f"- failed: {part.name}: {OUT.relative_to(ROOT) / 'failed'}" for part in parts if part.failed]
    return "\n".join([head, "", *lines, *([""] + notes if notes else [])]) + "\n"


def amount(count):
    """A count in words: 12345 -> 12,345 and 1234567890 -> 1.23e9."""
    return "" if not count else f"{count:,}" if count < 1e7 else re.sub(r"e\+0?", "e", f"{count:.3g}")


def figures(row):
    return [str(int(row[name])) if row[name] else "" for name in ("passed", "failed", "skipped", "not_begun")] + [
        f"{row['cpu'] / 60:.1f}", f"{row['seconds'] / 60:.1f}"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("minutes", type=float, nargs="?", default=60)
    parser.add_argument("-R", dest="regex", default="")
    parser.add_argument("--sanitized", nargs="*", default=[])
    parser.add_argument("--not-sanitized", default="")
    options = parser.parse_args()
    for folder in ("logs", "failed"):
        shutil.rmtree(OUT / folder, ignore_errors=True)
        (OUT / folder).mkdir(parents=True)
    seed = int(os.environ.get("LIGHTCOOK_SOAK_SEED", time.time() // 86400))
    environment = {**os.environ, "LIGHTCOOK_SOAK": "1", "LIGHTCOOK_SOAK_SEED": str(seed), "GTEST_RANDOM_SEED": str(seed % 99999),
                   "XDG_CONFIG_HOME": str(ROOT / "build/release/no_configuration")}
    history_file = OUT / "history.json"
    history = json.loads(history_file.read_text()) if history_file.exists() else {}

    parts = [*parts_of_ctest(), *parts_of_sanitizers(options.sanitized, options.not_sanitized)]
    targets = [folder.name for folder in ROOT.glob("tests/*/fuzz/corpus/*")]
    fuzzers = Part("fuzz", "fuzzers", [], shares=len(targets))
    fuzzers.is_script = False
    parts = [part for part in [*parts, fuzzers] if re.search(options.regex, part.name)]
    # Scripts first: what they leave is shared out. The fuzzers last, which use any time.
    parts.sort(key=lambda part: (part is fuzzers, not part.is_script, history.get(part.name, {}).get("begun", 0), part.name))
    begin = time.monotonic()
    until, scripts_until = begin + 60 * options.minutes, begin + 20 * options.minutes
    for number, part in enumerate(parts):
        left = max(0.0, until - time.monotonic())
        share = left * part.shares / sum(each.shares for each in parts[number:])
        if part.is_script:
            left = max(0.0, scripts_until - time.monotonic())
        if left == 0 or (part.is_script and history.get(part.name, {}).get("seconds", 0) > left):
            part.not_begun = 1
            part.reasons = ["no time left"]
        elif part.what == SANITIZED and not pathlib.Path(part.command[0]).exists():
            part.not_begun = 1
            part.reasons = ["not built"]
        elif part is fuzzers:
            fuzz(left / len(targets), environment, part)
        else:
            part.run(share, left, environment)
        if part.seconds:
            history[part.name] = {"begun": int(time.time()), "seconds": round(part.seconds)}
            history_file.write_text(json.dumps(history, indent=1))
        counted = ", ".join(f"{amount(count)} {unit}" for unit, count in part.counts.items())
        print(f"{number + 1}/{len(parts)} {part.name}: {part.passed} passed, {part.failed} failed, {part.skipped} skipped, "
              f"{part.not_begun} not begun, {part.seconds:.0f} s of {share:.0f}, CPU {part.cpu:.0f} s; {counted}", flush=True)
    text = table(parts, options.minutes, seed)
    (OUT / "table.md").write_text(text)
    print(text)
    sys.exit(any(part.failed for part in parts))


if __name__ == "__main__":
    main()
