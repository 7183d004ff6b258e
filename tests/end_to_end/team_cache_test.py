#!/usr/bin/env python3
"""Shares results through nginx, set up as docs/guide/team-cache.md says: team_cache_test.py LIGHTCOOK FOLDER

The configuration is that of the page, with the folders, port and name of this machine. Skipped (77) without nginx and openssl.
"""
import filecmp
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

from team_cache_server import ROOT, Server, is_installed

SCENE = ROOT / "examples/cornell/scene.toml"


def main():
    program, work = sys.argv[1], pathlib.Path(sys.argv[2])
    if not is_installed():
        print("skipped: needs nginx and openssl")
        sys.exit(77)
    folder = pathlib.Path(tempfile.mkdtemp(dir=work, prefix="team_cache."))
    server = Server(folder)

    def cook(machine, *options, wrong_password=False, **variables):
        environment = {**os.environ, "LIGHTCOOK_REMOTE_CACHE": f"https://localhost:{server.port}/lightcook",
                       "SSL_CERT_FILE": str(folder / "certificate.pem"), **variables}
        run = subprocess.run([program, "cook", SCENE, "-o", folder / machine / "out", "--cache", folder / machine / "cache", "--log", "json",
                              *options], env=environment, capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
        lines = [json.loads(line) for line in run.stderr.splitlines()]
        return lines[-1]["remote_cache"], [line for line in lines if line["level"] == "warning"], run.stderr

    def is_same(machine):
        one, other = folder / "ci/out", folder / machine / "out"
        names = [file.name for file in one.iterdir() if file.is_file() and not file.name.startswith("report")]
        equal, different, missing = filecmp.cmpfiles(one, other, names, shallow=False)
        return len(equal) > 5 and not different and not missing

    try:
        # Without a password nothing is written, and that is said.
        counts, warnings, _ = cook("stranger", "--remote-upload")
        assert counts["refused"] > 0 and counts["written"] == 0, counts
        assert any("status 401" in warning["detail"] for warning in warnings), warnings
        assert server.entries() == [] and not list((server.store.parent / "incoming").rglob("lightcook")), server.entries()

        # CI writes: credentials of a file, then of the environment.
        (folder / "credentials").write_text("ci:secret\n")
        counts, warnings, log = cook("ci", "--remote-upload", "--remote-credentials", folder / "credentials")
        assert counts["written"] == counts["not_there"] > 10 and not warnings, (counts, warnings)
        assert "secret" not in log
        written = counts["written"]
        counts, warnings, log = cook("ci", LIGHTCOOK_REMOTE_UPLOAD="1", LIGHTCOOK_REMOTE_CREDENTIALS="ci:secret")
        assert counts["written"] == 0 and not warnings, (counts, warnings)

        # People read. On a busy machine a short action may be done before the answer.
        def has_read(counts):
            return counts["read"] > written / 2 and counts["read"] + counts["late"] == written

        url = f"https://localhost:{server.port}/lightcook/"
        counts, warnings, _ = cook("reader", "--remote-cache", url, "--trace", folder / "trace.json", LIGHTCOOK_REMOTE_CACHE="")
        assert has_read(counts) and not warnings and is_same("reader"), (counts, warnings)
        events = json.loads((folder / "trace.json").read_text())["traceEvents"]
        assert sum(event["cat"] == "action" for event in events) == written
        assert sum(event["name"].startswith("GET ac/") for event in events) >= counts["read"]

        # A server that is not known is not read from.
        counts, warnings, _ = cook("unknown", SSL_CERT_FILE="/dev/null")
        assert counts["read"] == 0 and "certificate" in warnings[0]["detail"] and is_same("unknown"), (counts, warnings)

        # Every entry is damaged in its turn: half of it gone, another bit, empty. Each cook has the right bytes.
        for index, file in enumerate(server.entries()):
            content = file.read_bytes()
            middle = len(content) // 2
            file.write_bytes([content[:middle], content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1:], b""][index % 3])
        counts, warnings, _ = cook("damaged")
        assert counts["read"] == 0 and counts["damaged"] > 0 and is_same("damaged"), (counts, warnings)
        # The next cook of CI repairs them: a new machine, or --force.
        cook("ci2", "--remote-upload", "--force", LIGHTCOOK_REMOTE_CREDENTIALS="ci:secret")
        counts, warnings, _ = cook("repaired")
        assert has_read(counts) and not warnings and is_same("repaired"), (counts, warnings)

        # The oldest half is removed, whatever it is.
        for file in server.entries()[::2]:
            file.unlink()
        counts, warnings, _ = cook("cleaned")
        assert counts["damaged"] + counts["not_there"] + counts["late"] > 0 and is_same("cleaned"), (counts, warnings)

        # The server goes and comes back while a cook runs.
        environment = {**os.environ, "LIGHTCOOK_REMOTE_CACHE": f"https://localhost:{server.port}/lightcook",
                       "SSL_CERT_FILE": str(folder / "certificate.pem")}
        running = subprocess.Popen([program, "cook", SCENE, "-o", folder / "restarted/out", "--cache", folder / "restarted/cache", "-q"],
                                   env=environment)
        for _ in range(10):
            time.sleep(0.1)
            server.stop()
            server.start()
        assert running.wait() == 0 and is_same("restarted")

        server.stop()
        counts, warnings, _ = cook("alone")
        assert counts["read"] == 0 and "connection refused" in warnings[0]["detail"] and is_same("alone"), (counts, warnings)
        print("passed")
    finally:
        if server.process.poll() is None:
            server.stop()
        shutil.rmtree(folder)


main()
