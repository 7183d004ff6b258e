#!/usr/bin/env python3
"""Cooks on a cluster, set up as docs/guide/cluster.md says: cluster_test.py LIGHTCOOK FOLDER slurm|ssh|kills [KILLS]

Two nodes of Slurm or of sshd on loopback, nginx as the cache, and the commands of the page. Skipped (77) without them.
"""
import filecmp
import hashlib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from cluster_engines import NODES, Slurm, Ssh
from team_cache_server import ROOT, Server, is_installed

PAGE = (ROOT / "docs/guide/cluster.md").read_text()
# As if each byte of an input took a second: then everything that reads files is launched.
KINDS = ("light-map", "dominant", "cubemap", "rsrm", "lut", "mesh", "light-map-trial")
SLOW = {prefix + kind: {"texels": 1e12, "seconds": 1e12} for kind in KINDS for prefix in ("", "verify-")}


class Cluster:
    def __init__(self, program, work, engine):
        self.program = program
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=work, prefix="cluster."))
        self.folder.chmod(0o755)  # else munged takes no socket in it
        self.server = Server(self.folder / "server")
        os.environ.update(LIGHTCOOK_REMOTE_CACHE=f"https://localhost:{self.server.port}/lightcook", LIGHTCOOK_REMOTE_CREDENTIALS="ci:secret",
                          SSL_CERT_FILE=str(self.folder / "server/certificate.pem"), TMPDIR=str(self.folder))
        self.engine = (Slurm if engine == "slurm" else Ssh)(self.folder / engine)

    def set_up(self):
        self.engine.set_up()
        self.scene = self.folder / "scene"
        shutil.copytree(ROOT / "examples/cornell", self.scene)
        # The launcher of the page. Root also hides the scene from the nodes: they have nothing but the cache.
        if isinstance(self.engine, Slurm):
            self.launcher = re.search(r"--launcher '(srun .*)'", PAGE).group(1)
        else:
            script = self.engine.folder / "bin/on-a-free-node"
            script.write_text(re.search(r"```sh\n(#!/bin/sh\n# on-a-free-node.*?)```", PAGE, re.S).group(1))
            script.chmod(0o755)
            self.launcher = re.search(r"--launcher '(on-a-free-node .*)'", PAGE).group(1)
            os.environ.update(NODES=" ".join(NODES), PATH=f"{script.parent}:{os.environ['PATH']}")
        if os.geteuid() == 0:
            hide = self.folder / "hide"
            hide.write_text(f'#!/bin/sh\nexec unshare -m sh -c \'mount -t tmpfs none {self.scene} && exec "$@"\' sh "$@"\n')
            hide.chmod(0o755)
            self.launcher += f" {hide}"

    def stop(self):
        self.engine.stop()
        self.server.stop()
        shutil.rmtree(self.folder)

    def forget(self, *machines):
        """Gives the cook, the cache or the nodes nothing that they had."""
        for machine in machines or ("cook", "cache", *NODES):
            if machine == "cache":
                for entry in self.server.entries():
                    entry.unlink()
            elif machine == "cook":
                for name in ("cook.cache", "out", "out.assets"):
                    shutil.rmtree(self.folder / name, ignore_errors=True)
            else:
                shutil.rmtree(self.engine.cache(machine), ignore_errors=True)

    def start(self, *options, slow=False, launcher=None, threads=2):
        cache = self.folder / "cook.cache"
        cache.mkdir(parents=True, exist_ok=True)
        if slow:
            (cache / "launch_seconds.json").write_text(json.dumps(SLOW))
        return subprocess.Popen([self.program, "-j", str(threads), "cook", self.scene / "scene.toml", "-o", self.folder / "out", "--cache", cache,
                                 "--log", "json", "--trace", self.folder / "trace.json", "--launcher", launcher or self.launcher, *options],
                                stderr=subprocess.PIPE, text=True, start_new_session=True)

    def cook(self, *options, **arguments):
        running = self.start(*options, **arguments)
        return Ended(running, running.communicate()[1], self.folder)

    def cook_directly(self, name, *options):
        subprocess.run([self.program, "-q", "cook", self.scene / "scene.toml", "-o", self.folder / name, "--cache", self.folder / f"{name}.cache",
                        *options], check=True, env={**os.environ, "LIGHTCOOK_REMOTE_CACHE": ""})

    def expect_same(self, name="direct", made="out"):
        one, other = self.folder / name, self.folder / made
        names = {file.name for file in one.iterdir() if file.is_file() and not file.name.startswith("report")}
        assert names == {file.name for file in other.iterdir() if file.is_file() and not file.name.startswith("report")}
        equal, different, missing = filecmp.cmpfiles(one, other, names, shallow=False)
        assert len(equal) > 5 and not different and not missing, (different, missing)

    def workers(self):
        """Processes of nodes that run an action."""
        found = subprocess.run(["pgrep", "-f", f"^{self.program} work [0-9a-f]+ "], capture_output=True, text=True).stdout
        return [int(word) for word in found.split()]

    def kill_worker(self, running):
        """At once: a moment later it may have written its result."""
        while not (workers := self.workers()):
            assert running.poll() is None, "it ended before a worker was killed"
        kill(workers[0])


class Ended:
    def __init__(self, process, text, folder):
        self.code, self.text = process.returncode, text
        lines = [json.loads(line) for line in text.splitlines() if line.startswith("{")]
        self.warnings = [line["detail"] for line in lines if line.get("level") == "warning"]
        self.errors = [line for line in lines if line.get("level") == "error"]
        self.summary = lines[-1] if lines else {}
        self.events = json.loads((folder / "trace.json").read_text())["traceEvents"] if process.returncode == 0 else []

    def launches(self):
        return [event for event in self.events if event["cat"] == "launch"]


def kill(process):
    try:
        os.kill(process, signal.SIGKILL)
    except ProcessLookupError:
        pass


def check_agreement(cluster):
    """The same bytes for -j1, -j2, local, Ninja and the cluster, with a cold and a warm remote cache."""
    cluster.cook_directly("direct", "-j", "1")
    cluster.cook_directly("two", "-j", "2")
    cluster.expect_same("direct", "two")
    cold = cluster.cook(slow=True)
    assert cold.code == 0 and not cold.warnings, cold.text
    for folder in cluster.folder / "out", *(cluster.engine.cache(node) for node in NODES):
        assert not list(folder.rglob(".lightcook-*")), list(folder.iterdir())
    assert len(cold.launches()) > 8, cold.launches()
    asked = [event["args"]["launcher"] for event in cold.launches()]
    assert not any("{" in words for words in asked), asked
    cluster.expect_same()
    assert all(any(cluster.engine.cache(node).glob("cas/*")) for node in NODES), "both nodes have worked"
    cluster.forget("cook")
    warm = cluster.cook(slow=True)
    assert warm.code == 0 and not warm.launches(), warm.text
    cluster.expect_same()
    # The commands of Ninja.
    cluster.forget()
    cache = cluster.folder / "cook.cache"
    cache.mkdir(parents=True)
    (cache / "launch_seconds.json").write_text(json.dumps(SLOW))
    subprocess.run([cluster.program, "plan", cluster.scene / "scene.toml", "--ninja", cluster.folder / "scene.ninja", "-o",
                    cluster.folder / "out", "--cache", cache, "--launcher", cluster.launcher], check=True)
    subprocess.run(["ninja", "-f", cluster.folder / "scene.ninja", "-j", "4"], cwd=cluster.folder, check=True, stdout=subprocess.DEVNULL)
    cluster.expect_same()


def check_cost(cluster):
    """A launch costs less than a twentieth of the actions that are launched, as predicted from nothing and from the cook before."""
    for machines in (("cook", "cache", *NODES), ("cache", *NODES)):
        cluster.forget(*machines)
        shutil.rmtree(cluster.folder / "out", ignore_errors=True)
        for record in cluster.folder.glob("cook.cache/[ac]*/*"):
            record.unlink()
        cooked = cluster.cook()
        launched = {event["name"].removeprefix("launch ") for event in cooked.launches()}
        for event in cooked.events:
            if event["cat"] == "action" and event["name"] in launched:
                seconds = event["args"]["seconds"]
                cost = event["dur"] / 1e6 - seconds
                print(f"{event['name']}: {seconds:.2f} s, launch {cost:.3f} s, {100 * cost / seconds:.1f} %")
        cluster.expect_same()


def check_faults(cluster):
    def after(fault, **arguments):
        cluster.forget()
        running = cluster.start(slow=True, **arguments)
        fault(running)
        ended = Ended(running, running.communicate()[1], cluster.folder)
        assert ended.code == 0, ended.text
        cluster.expect_same()
        return ended

    warnings = after(cluster.kill_worker).warnings
    # ssh returns 255 after a signal, as for a dead node, and the script goes on to the next one.
    assert isinstance(cluster.engine, Ssh) or any("launched again" in words for words in warnings), warnings

    def kill_node(running):
        """With all that it runs."""
        while not cluster.workers():
            time.sleep(0.02)
        cluster.engine.running[NODES[0]].kill()
        cluster.engine.running[NODES[0]].wait()
        own = str(cluster.engine.cache(NODES[0]))
        for worker in cluster.workers():
            if f"LIGHTCOOK_CACHE={own}\0" in pathlib.Path(f"/proc/{worker}/environ").read_text():
                kill(worker)

    after(kill_node)
    cluster.engine.start_node(NODES[0])
    if isinstance(cluster.engine, Slurm):
        cluster.engine.wait_for_nodes()

    def lose_entries(running):
        while running.poll() is None:
            for entry in cluster.server.entries()[::3]:
                entry.unlink(missing_ok=True)
                time.sleep(0.05)
            time.sleep(0.3)

    cluster.forget()
    running = cluster.start(slow=True)
    lose_entries(running)
    ended = Ended(running, running.communicate()[1], cluster.folder)
    # A cache that loses a third of all again and again may lose one three times.
    if ended.code != 0:
        assert ended.code == 1 and "remote cache" in ended.text, ended.text
        ended = cluster.cook(slow=True)
    assert ended.code == 0, ended.text
    cluster.expect_same()

    def restart_server(running):
        time.sleep(1)
        cluster.server.stop()
        time.sleep(0.5)
        cluster.server.start()

    after(restart_server)

    # A full disk: of the first node, while the other one is free; then of both.
    full = cluster.folder / "full"
    full.write_text(f'#!/bin/sh\n[ "$LIGHTCOOK_CACHE" = {cluster.engine.cache(NODES[0])} ] && ulimit -f 8\nexec "$@"\n')
    full.chmod(0o755)
    ended = after(lambda running: None, launcher=f"{cluster.launcher} {full}", threads=1)
    assert any("cannot be written" in words for words in ended.warnings), ended.text
    cluster.forget()
    full.write_text('#!/bin/sh\nulimit -f 8\nexec "$@"\n')
    ended = cluster.cook(slow=True, launcher=f"{cluster.launcher} {full}")
    assert ended.code == 1 and "cannot be written" in ended.errors[0]["detail"], ended.text
    assert not (cluster.folder / "out").exists()

    # Another version of the program on the nodes.
    content = pathlib.Path(cluster.program).read_bytes()
    digest = re.search(rb"sources ([0-9a-f]{12})", ended_of_other(cluster)).group(1)
    whole = re.search(digest + rb"[0-9a-f]{52}", content).group(0)
    other = cluster.folder / "other"
    other.write_bytes(content.replace(whole, whole[::-1]))
    other.chmod(0o755)
    swap = cluster.folder / "swap"
    swap.write_text(f'#!/bin/sh\nshift\nexec {other} "$@"\n')
    swap.chmod(0o755)
    cluster.forget()
    ended = cluster.cook(slow=True, launcher=f"{cluster.launcher} {swap}")
    assert ended.code == 2 and "install the same on every machine" in ended.errors[0]["detail"], ended.text


def ended_of_other(cluster):
    """A job of another program is refused by a line that has the sources of this one."""
    job = json.dumps({"program": {"version": "0", "sources": "0" * 64, "compiler": ""}}).encode()
    name = hashlib.sha256(job).hexdigest()
    cache = cluster.folder / "other.cache"
    (cache / "cas").mkdir(parents=True)
    (cache / "cas" / name).write_bytes(job)
    return subprocess.run([cluster.program, "work", name, "--cache", cache], capture_output=True,
                          env={**os.environ, "LIGHTCOOK_REMOTE_CACHE": ""}).stderr


def check_kills(cluster, count):
    """Kills at random moments: of the cook, a launcher, a worker, a node or the server. Every following cook has the bytes."""
    scene = cluster.scene / "scene.toml"
    text = scene.read_text().replace('target = "bc"', 'target = "bc"\nlight_map_layout = "ratio"\neffort = 0', 1)
    scene.write_text(re.sub(r"max_(converter_)?error = .*", "", text).replace('mesh = "cornell.glb"', "").replace("[[probe]]", "[[probe]]\nsize = 16"))
    cluster.cook_directly("direct")
    start = time.monotonic()
    assert cluster.cook(slow=True).code == 0
    whole = time.monotonic() - start
    seeds = random.Random(int(os.environ.get("LIGHTCOOK_SOAK_SEED", 1)))
    until = start + float(os.environ.get("LIGHTCOOK_SOAK_SECONDS", "inf"))
    counts = {}
    for number in range(count):
        if time.monotonic() > until:
            break
        cluster.forget(*seeds.sample(("cook", "cache", *NODES), seeds.randint(1, 4)))
        running = cluster.start("--force", slow=True)
        time.sleep(seeds.uniform(0, whole))
        victim = seeds.choice(("cook", "cook", "launcher", "worker", "worker", "node", "server"))
        counts[victim] = counts.get(victim, 0) + 1
        if victim == "cook":
            kill(running.pid)
        elif victim == "launcher":
            found = subprocess.run(["pgrep", "-P", str(running.pid)], capture_output=True, text=True).stdout.split()
            for launcher in found[:1]:
                kill(int(launcher))
        elif victim == "worker":
            for worker in cluster.workers()[:1]:
                kill(worker)
        elif victim == "node":
            node = seeds.choice(NODES)
            cluster.engine.running[node].kill()
            cluster.engine.running[node].wait()
            cluster.engine.start_node(node)
        else:
            cluster.server.stop()
            time.sleep(seeds.uniform(0, 0.5))
            cluster.server.start()
        ended = Ended(running, running.communicate()[1], cluster.folder)
        if ended.code == 0:
            cluster.expect_same()
        else:
            assert victim in ("cook", "server"), (victim, ended.text)
        cooked = cluster.cook(slow=True)
        assert cooked.code == 0, (number, victim, cooked.text)
        cluster.expect_same()
        if number % 20 == 19:
            print(f"{number + 1} kills: {counts}", flush=True)
    print(f"soak: {sum(counts.values())} kills")


def main():
    program, work, kind = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    engine = Ssh if kind == "ssh" else Slurm
    missing = engine.missing() + ([] if is_installed() else ["nginx or openssl"]) + ([] if shutil.which("ninja") else ["ninja"])
    if missing:
        print(f"skipped: needs {', '.join(missing)}")
        sys.exit(77)
    cluster = Cluster(program, work, "ssh" if kind == "ssh" else "slurm")
    try:
        cluster.set_up()
        if kind == "kills":
            check_kills(cluster, int(sys.argv[4]) if len(sys.argv) > 4 else 200)
        elif kind == "cost":
            cluster.cook_directly("direct")
            check_cost(cluster)
        else:
            check_agreement(cluster)
            check_faults(cluster)
        print("passed")
    finally:
        cluster.stop()


main()
