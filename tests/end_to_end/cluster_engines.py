"""Two nodes of a cluster on loopback: Slurm, and sshd. Each has keys, sockets and ports of its own, and needs no special rights."""
import getpass
import os
import pathlib
import shutil
import socket
import subprocess
import time

os.environ["PATH"] += ":/usr/sbin"
NODES = ("node1", "node2")


def free_ports(count):
    held = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [each.getsockname()[1] for each in held]
    for each in held:
        each.close()
    return ports


def wait_for(condition, seconds, what):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, what()
        time.sleep(0.05)


class Daemons:
    def __init__(self, folder):
        self.folder, self.running = folder, {}
        folder.mkdir(parents=True)

    def start(self, name, *command):
        log = open(self.folder / f"{name}.out", "a")
        self.running[name] = subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL)

    def stop(self):
        for process in reversed(list(self.running.values())):
            process.terminate()
        for process in self.running.values():
            process.wait()


SLURM = """ClusterName=lightcook
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
TaskProlog={folder}/prolog
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
ReturnToService=2
SlurmdTimeout=5
KillWait=2
SlurmdParameters=config_overrides
MpiDefault=none
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class Slurm(Daemons):
    @staticmethod
    def missing():
        return [name for name in ("munged", "slurmctld", "slurmd", "srun") if not shutil.which(name)]

    def set_up(self):
        folder = self.folder
        (folder / "state").mkdir()
        key = folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o600)
        port, *ports = free_ports(1 + len(NODES))
        host = socket.gethostname()
        configuration = SLURM.format(folder=folder, port=port, host=host, user=getpass.getuser())
        for node, port in zip(NODES, ports):
            (folder / node).mkdir()
            configuration += f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1 RealMemory=64000\n"
        (folder / "slurm.conf").write_text(configuration)
        # Each node has a cache folder of its own.
        (folder / "prolog").write_text(f"#!/bin/sh\necho export LIGHTCOOK_CACHE={folder}/$SLURMD_NODENAME/cache\n")
        (folder / "prolog").chmod(0o755)
        os.environ["SLURM_CONF"] = str(folder / "slurm.conf")
        self.start("munged", "munged", "-F", "--key-file", key, *(word for name in ("socket", "pid", "log", "seed") for word in (
            {"socket": "--socket"}.get(name, f"--{name}-file"), folder / f"munge.{name}")))
        wait_for((folder / "munge.socket").exists, 10, lambda: (folder / "munged.out").read_text())
        self.start("slurmctld", "slurmctld", "-D", "-c")
        for node in NODES:
            self.start_node(node)
        self.wait_for_nodes()

    def start_node(self, node):
        self.start(node, "slurmd", "-D", "-N", node)

    def wait_for_nodes(self):
        states = lambda: subprocess.run(["sinfo", "-h", "-N", "-o", "%N %T"], capture_output=True, text=True).stdout
        wait_for(lambda: states().split().count("idle") == len(NODES), 60, lambda: states() + (self.folder / "slurmctld.log").read_text())

    def cache(self, node):
        return self.folder / node / "cache"


class Ssh(Daemons):
    @staticmethod
    def missing():
        return [name for name in ("sshd", "ssh", "ssh-keygen") if not shutil.which(name)]

    def set_up(self):
        folder = self.folder
        for key in ("host", "key"):
            subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", folder / key], check=True)
        if os.geteuid() == 0:
            os.makedirs("/run/sshd", exist_ok=True)
        configuration = ""
        for node, port in zip(NODES, free_ports(len(NODES))):
            (folder / node / "lightcook").mkdir(parents=True)
            (folder / node / "lightcook/secret").write_text("ci:secret\n")
            (folder / node / "lightcook/config.toml").write_text(
                f'[cache]\nremote_cache = "{os.environ["LIGHTCOOK_REMOTE_CACHE"]}"\nremote_credentials = "secret"\n')
            environment = {"LIGHTCOOK_CACHE": self.cache(node), "XDG_CONFIG_HOME": folder / node,
                           "SSL_CERT_FILE": os.environ.get("SSL_CERT_FILE", "")}
            (folder / f"{node}.conf").write_text(
                f"Port {port}\nListenAddress 127.0.0.1\nHostKey {folder}/host\nPidFile none\nAuthorizedKeysFile {folder}/key.pub\n"
                "StrictModes no\nUsePAM no\nPermitRootLogin yes\n"
                f"SetEnv {' '.join(f'{name}={value}' for name, value in environment.items())}\n")
            (folder / f"{node}.known").write_text(f"{node} {(folder / 'host.pub').read_text()}")
            configuration += (f"Host {node}\n  HostName 127.0.0.1\n  Port {port}\n  HostKeyAlias {node}\n"
                              f"  UserKnownHostsFile {folder}/{node}.known\n")
            self.start_node(node)
        (folder / "config").write_text(f"{configuration}Host *\n  User {getpass.getuser()}\n  IdentityFile {folder}/key\n"
                                       "  IdentitiesOnly yes\n")
        # `ssh` of this folder knows the nodes, as that of a user does by ~/.ssh/config.
        program = folder / "bin/ssh"
        program.parent.mkdir()
        program.write_text(f'#!/bin/sh\nexec {shutil.which("ssh")} -F {folder}/config "$@"\n')
        program.chmod(0o755)
        for node in NODES:
            wait_for(lambda: subprocess.run([program, node, "true"], stderr=subprocess.DEVNULL).returncode == 0, 20,
                     lambda: (folder / f"{node}.out").read_text())

    def start_node(self, node):
        self.start(node, shutil.which("sshd"), "-D", "-e", "-f", self.folder / f"{node}.conf")

    def cache(self, node):
        return self.folder / node / "cache"
