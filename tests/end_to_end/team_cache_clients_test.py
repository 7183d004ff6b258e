#!/usr/bin/env python3
"""Runs Bazel, moon and ccache beside lightcook on one nginx: team_cache_clients_test.py LIGHTCOOK FOLDER

The server is that of docs/guide/team-cache.md. Each client uses a prefix of its own and that of lightcook. Clients that are not
installed are named. Skipped (77) without nginx, openssl or any of them.
"""
import base64
import filecmp
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from team_cache_server import ROOT, Server, free_port, is_installed

SCENE = ROOT / "examples/cornell/scene.toml"
INPUT = "the input of every client\n"


def run(*command, code=0, **arguments):
    ended = subprocess.run(command, capture_output=True, text=True, **arguments)
    assert ended.returncode == code, (command, ended.stdout, ended.stderr)
    return ended.stdout + ended.stderr


class Client:
    has_contents = True  # under cas/
    fault = "no record of lightcook"  # that lightcook finds in its records

    def expect_refused(self, prefix, records):
        """Records of lightcook lie under its keys."""
        assert self.build(prefix)[1] > 0


class Bazel(Client):
    """A genrule with two outputs, one of which is a file that lightcook has cooked, and one with an executable."""
    name, needs = "bazel", ("bazel", "keytool")

    def __init__(self, folder, server, cooked):
        self.folder, self.server = folder / "bazel", server
        source = self.folder / "source"
        source.mkdir(parents=True)
        (source / "WORKSPACE").touch()
        (source / "in.txt").write_text(INPUT)
        shutil.copy(cooked, source / "cooked.bin")
        (source / "BUILD").write_text('genrule(name = "copies", srcs = ["in.txt", "cooked.bin"], outs = ["copy.txt", "folder/copy.bin"],\n'
                                      '    cmd = "cp $(location in.txt) $(location copy.txt); '
                                      'cp $(location cooked.bin) $(location folder/copy.bin); echo told")\n'
                                      'genrule(name = "script", outs = ["run.sh"], cmd = "echo exit >$@", executable = True)\n')
        run("keytool", "-importcert", "-noprompt", "-alias", "cache", "-file", server.folder / "certificate.pem", "-keystore",
            self.folder / "trusted", "-storepass", "changeit")

    def forget(self):
        self.call("clean", "--expunge")

    def call(self, *words, code=0):
        trust = [f"--host_jvm_args=-Djavax.net.ssl.{key}={value}" for key, value in
                 (("trustStore", self.folder / "trusted"), ("trustStorePassword", "changeit"))]
        return run("bazel", "--batch", f"--output_user_root={self.folder}/root", *trust, *words, cwd=self.folder / "source",
                   code=code)

    def start_build(self, prefix, code=0):
        return self.call("build", f"--remote_cache=https://ci:secret@localhost:{self.server.port}/{prefix}", "--spawn_strategy=local",
                         "//...", code=code)

    def expect_refused(self, prefix, records):
        """It reads them: it asks for their contents. Its outputs are missing then, which ends the build."""
        log = self.server.folder / "access.log"
        before = len(log.read_text())
        said = self.start_build(prefix, code=1)
        assert "not all outputs were created" in said, said
        asked = log.read_text()[before:]
        names = re.findall("[0-9a-f]{64}", "".join(record.decode("latin-1") for record in records))
        assert any(f"GET /{prefix}/cas/{name} " in asked for name in names), asked

    def build(self, prefix):
        """Returns how many of its actions were hits, and how many ran."""
        said = self.start_build(prefix)
        counts = said[said.index(" processes: "):].split("\n")[0].removeprefix(" processes: ").rstrip(".")
        kinds = {kind: int(number) for number, kind in (part.split(" ", 1) for part in counts.split(", "))}
        made = self.folder / "source/bazel-bin"
        assert (made / "copy.txt").read_text() == INPUT and os.access(made / "run.sh", os.X_OK)
        assert filecmp.cmp(made / "folder/copy.bin", self.folder / "source/cooked.bin", shallow=False)
        return kinds.get("remote cache hit", 0), kinds.get("local", 0)


class Moon(Client):
    """A task with a file and a folder as outputs."""
    name, needs = "moon", ("moon", "git")

    def __init__(self, folder, server, cooked):
        self.folder, self.server = folder / "moon", server
        for name in (".moon", "app"):
            (self.folder / name).mkdir(parents=True)
        (self.folder / "app/in.txt").write_text(INPUT)
        shutil.copy(cooked, self.folder / "app/cooked.bin")
        (self.folder / "app/make.sh").write_text("mkdir -p out/folder; cp in.txt out/copy.txt; cp cooked.bin out/folder; echo told\n")
        # moon connects beside its tasks: one that starts before it has, such as the first one, does not ask the cache.
        (self.folder / "app/moon.yml").write_text(
            "language: bash\ntasks:\n  wait:\n    command: sleep 1\n    options: {cache: false}\n  make:\n    command: sh make.sh\n"
            "    deps: ['~:wait']\n    inputs: [in.txt, cooked.bin, make.sh]\n    outputs: [out/copy.txt, out/folder]\n")
        run("git", "init", "-q", self.folder)
        run("git", "-c", "user.name=me", "-c", "user.email=me@localhost", "commit", "-q", "--allow-empty", "-m", "nothing", cwd=self.folder)

    def forget(self):
        for name in (".moon/cache", "app/out"):
            shutil.rmtree(self.folder / name, ignore_errors=True)

    def build(self, prefix):
        secret = base64.b64encode(b"ci:secret").decode()
        # Not localhost: moon takes that for a mistake where it believes to run on a server.
        (self.folder / ".moon/workspace.yml").write_text(
            f"projects: [app]\nremote:\n  api: http\n  host: 'https://127.0.0.1:{self.server.port}'\n  auth:\n    headers:\n"
            f"      Authorization: 'Basic {secret}'\n  cache:\n    instanceName: '{prefix}'\n  tls:\n"
            f"    cert: '{self.server.folder}/certificate.pem'\n")
        said = run("moon", "run", "app:make", cwd=self.folder,
                   env={**os.environ, "PROTO_HOME": str(self.folder / "proto"), "MOON_HOME": str(self.folder / "home")})
        made = self.folder / "app/out"
        assert (made / "copy.txt").read_text() == INPUT
        assert filecmp.cmp(made / "folder/cooked.bin", self.folder / "app/cooked.bin", shallow=False)
        is_hit = "cached from remote" in said
        return int(is_hit), int(not is_hit)


class Ccache(Client):
    """A compilation, with the keys of each layout of ccache. It has no TLS."""
    name, needs = "ccache", ("ccache", "gcc")
    has_contents, fault = False, "no ActionResult with an output file"
    layouts = ("subdirs", "flat", "bazel")

    def __init__(self, folder, server, cooked):
        self.folder, self.server = folder / "ccache", server
        self.folder.mkdir()
        (self.folder / "a.c").write_text("int answer(void) { return 42; }\n")

    def forget(self):
        shutil.rmtree(self.folder / "cache", ignore_errors=True)

    def build(self, prefix):
        hits = 0
        for layout in self.layouts:
            self.forget()
            address = f"http://ci:secret@localhost:{self.server.plain_port}/{prefix}|layout={layout}"
            environment = {**os.environ, "CCACHE_DIR": str(self.folder / "cache"), "CCACHE_REMOTE_STORAGE": address}
            run("ccache", "gcc", "-c", "a.c", "-o", "a.o", cwd=self.folder, env=environment)
            counts = dict(line.split("\t") for line in run("ccache", "--print-stats", env=environment).splitlines())
            hits += int(counts["direct_cache_hit"]) + int(counts["preprocessed_cache_hit"])
        return hits, len(self.layouts) - hits


class Team:
    """The server, the cooks of lightcook that use it, and the clients."""

    def __init__(self, program, folder, clients):
        self.program, self.folder = program, folder
        self.server = Server(folder, plain_port=free_port())
        self.written = self.cook("ci", "--remote-upload")[0]["written"]
        self.own = sorted(self.records())
        assert self.written == len(self.own) > 10, (self.written, len(self.own))
        cooked = sorted(file for file in (folder / "ci/out").iterdir() if file.is_file())
        self.shared = next(file for file in cooked if self.content(file).exists())
        self.clients = [client(folder, self.server, self.shared) for client in clients]

    def cook(self, machine, *options):
        """Returns the figures of the remote cache and the warnings. The bytes are those of the first cook."""
        folder = self.folder / machine
        shutil.rmtree(folder, ignore_errors=True)
        environment = {**os.environ, "LIGHTCOOK_REMOTE_CACHE": f"https://localhost:{self.server.port}/lightcook",
                       "LIGHTCOOK_REMOTE_CREDENTIALS": "ci:secret", "SSL_CERT_FILE": str(self.folder / "certificate.pem")}
        said = run(self.program, "--log", "json", "cook", SCENE, "-o", folder / "out", "--cache", folder / "cache", *options,
                   env=environment)
        lines = [json.loads(line) for line in said.splitlines() if line.startswith("{")]
        first = self.folder / "ci/out"
        names = [file.name for file in first.iterdir() if file.is_file() and not file.name.startswith("report")]
        equal, different, absent = filecmp.cmpfiles(first, folder / "out", names, shallow=False)
        assert len(equal) > 5 and not different and not absent, (machine, different, absent)
        return lines[-1]["remote_cache"], [line["detail"] for line in lines if line["level"] == "warning"]

    def expect_all_read(self):
        """On a busy machine a short action may be done before the answer."""
        counts, warnings = self.cook("reader")
        assert counts["read"] > self.written / 2 and counts["read"] + counts["late"] == self.written and not warnings, (counts, warnings)

    def build(self, client, prefix="lightcook"):
        client.forget()
        return client.build(prefix)

    def content(self, file):
        return self.server.store / "cas" / hashlib.sha256(file.read_bytes()).hexdigest()

    def records(self, prefix=""):
        return set(self.server.store.glob(f"{prefix}ac/*"))


def check_side_by_side(team):
    """Each client writes and has hits. Nobody misses what is its own."""
    for client in team.clients:
        for prefix in (f"lightcook/{client.name}", "lightcook"):
            hits, ran = team.build(client, prefix)
            assert hits == 0 and ran > 0, (client.name, prefix, hits, ran)
            assert team.build(client, prefix) == (ran, 0), (client.name, prefix)
            team.expect_all_read()
    team.cook("writer", "--remote-upload", "--force")
    for client in team.clients:
        assert team.build(client)[1] == 0, client.name


def check_shared_contents(team):
    """A content that only lightcook wrote is a hit of a client, and the other way round."""
    for client in team.clients:
        if client.has_contents:
            team.content(team.shared).unlink()
            team.cook("writer", "--remote-upload", "--force")
            assert team.build(client)[1] == 0, client.name
            team.content(team.shared).unlink()
            assert team.build(client)[1] > 0, client.name
            team.expect_all_read()


def check_swapped_records(team):
    """Records of a client lie under keys of lightcook, and the other way round: read as what they are, and refused."""
    whole = {file: file.read_bytes() for file in team.records()}
    for client in team.clients:
        for file in team.records() - set(team.own):
            file.unlink()
        team.build(client)
        theirs = sorted(team.records() - set(team.own))
        for index, file in enumerate(team.own):
            file.write_bytes(theirs[index % len(theirs)].read_bytes())
        counts, warnings = team.cook("reader")
        assert counts["read"] == 0 and 0 < counts["damaged"] == team.written - counts["late"], counts
        assert len(warnings) == 1 and client.fault in warnings[0], (client.name, warnings)
        ours = [whole[file] for file in team.own[:len(theirs)]]
        for file, record in zip(theirs, ours):
            file.write_bytes(record)
        client.forget()
        client.expect_refused("lightcook", ours)
        for file in team.own:
            file.write_bytes(whole[file])
    team.expect_all_read()


def main():
    every = (Bazel, Moon, Ccache)
    clients = [client for client in every if all(map(shutil.which, client.needs))]
    if not is_installed() or not clients:
        print("skipped: needs nginx and openssl, and one of Bazel (with keytool), moon and ccache")
        sys.exit(77)
    for client in set(every) - set(clients):
        print(f"{client.name} was not tried: needs {' and '.join(client.needs)}")
    folder = pathlib.Path(tempfile.mkdtemp(dir=sys.argv[2], prefix="team_cache_clients."))
    team = Team(sys.argv[1], folder, clients)
    try:
        for check in check_side_by_side, check_shared_contents, check_swapped_records:
            check(team)
        print(f"passed: {', '.join(client.name for client in clients)}")
    finally:
        team.server.stop()
        shutil.rmtree(folder)


main()
