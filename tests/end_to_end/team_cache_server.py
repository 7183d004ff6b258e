"""A cache for a team: nginx with the configuration of docs/guide/team-cache.md, and the folders, port and name of this machine."""
import os
import pathlib
import re
import shutil
import socket
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
MAIN = """daemon off;
pid {folder}/nginx.pid;
error_log {folder}/error.log warn;
{user}
events {{}}
http {{
    access_log {folder}/access.log;
{server}
}}
"""


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Server:
    def __init__(self, folder, plain_port=None):
        """plain_port: also listens there without TLS, as the page says for clients that have none"""
        self.folder, self.port, self.plain_port = folder, free_port(), plain_port
        store = folder / "srv/cache"
        (store / "lightcook").mkdir(parents=True)
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost", "-addext",
                        "subjectAltName=DNS:localhost,IP:127.0.0.1", "-addext", "basicConstraints=critical,CA:FALSE", "-keyout",
                        folder / "key.pem", "-out", folder / "certificate.pem"],
                       check=True, capture_output=True)
        hashed = subprocess.run(["openssl", "passwd", "-apr1", "secret"], check=True, capture_output=True, text=True).stdout
        (folder / "htpasswd").write_text(f"ci:{hashed}")
        page = (ROOT / "docs/guide/team-cache.md").read_text()
        server = re.search(r"```nginx\n(.*?)```", page, re.S).group(1)
        plain = f"; listen 127.0.0.1:{plain_port}" if plain_port else ""
        for there, here in {"443 ssl": f"127.0.0.1:{self.port} ssl{plain}", "cache.example.org;": "localhost;",
                            "/etc/ssl/cache.example.org.pem": f"{folder}/certificate.pem",
                            "/etc/ssl/private/cache.example.org.key": f"{folder}/key.pem",
                            "/etc/nginx/lightcook.htpasswd": f"{folder}/htpasswd", "/srv/cache": str(store)}.items():
            assert there in server, there
            server = server.replace(there, here)
        (folder / "nginx.conf").write_text(
            MAIN.format(folder=folder, server=server, user="user root;" if os.geteuid() == 0 else ""))
        self.store, self.process = store / "lightcook", None
        self.start()

    def start(self):
        self.process = subprocess.Popen(["nginx", "-c", self.folder / "nginx.conf", "-e", self.folder / "error.log"])
        for _ in range(200):
            with socket.socket() as client:
                if client.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            time.sleep(0.02)
        raise SystemExit((self.folder / "error.log").read_text())

    def stop(self):
        self.process.terminate()
        self.process.wait()

    def entries(self):
        return sorted(file for file in self.store.rglob("*") if file.is_file())


def is_installed():
    os.environ["PATH"] += ":/usr/sbin"
    return shutil.which("nginx") is not None and shutil.which("openssl") is not None
