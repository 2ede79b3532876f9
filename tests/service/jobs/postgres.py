"""A private PostgreSQL server on a free port, from Debian's package."""

import os
import pwd
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from pathlib import Path

import psycopg

MISSING = (
    "PostgreSQL is not installed, so jobs are tested on SQLite only: apt-get install postgresql brings it."
)


def binaries() -> Path | None:
    """The directory of initdb and postgres; None where there is none."""
    found = shutil.which("initdb")
    if found is not None:
        return Path(found).resolve().parent
    # Debian keeps them out of PATH, a directory for each version; clients alone bring no initdb
    versions = {
        float(path.parts[-3]): path.parent for path in Path("/usr/lib/postgresql").glob("*/bin/initdb")
    }
    return versions[max(versions)] if versions else None


class Server:
    """A server in a temporary directory; it trusts everybody who reaches its address."""

    def __init__(self, address: str = "127.0.0.1") -> None:
        directory = binaries()
        assert directory is not None, MISSING
        self._binaries = directory
        self.address, self.port = address, _free_port()
        self._root = Path(tempfile.mkdtemp(prefix="rivetplan-postgres-"))
        self._user = _user()
        if self._user is not None:
            os.chown(self._root, pwd.getpwnam(self._user).pw_uid, -1)
        self._data = self._root / "data"
        self._run("initdb", "-D", self._data, "-U", "test", "--auth=trust", "--no-sync", "-E", "UTF8")
        self._process: subprocess.Popen[bytes] | None = None
        with (self._data / "pg_hba.conf").open("a") as trusted:
            trusted.write(f"host all all {address}/24 trust\n")

    def url(self, database: str) -> str:
        """The URL of a database; jobs make it where there is none."""
        return f"postgresql://test@{self.address}:{self.port}/{database}"

    def start(self) -> None:
        """Start it and wait until it answers."""
        listen = f"listen_addresses=127.0.0.1,{self.address}"
        options = ["-c", listen, "-c", "unix_socket_directories=", "-c", "fsync=off", "-p", str(self.port)]
        command = [str(self._binaries / "postgres"), "-D", str(self._data), *options]
        with (self._root / "log").open("ab") as log:
            self._process = subprocess.Popen(
                command, stdout=log, stderr=log, user=self._user, cwd=self._root, extra_groups=self._groups
            )
        until = time.monotonic() + 20.0
        while True:
            try:
                psycopg.connect(self.url("postgres"), connect_timeout=2).close()
                return
            except psycopg.OperationalError:
                if time.monotonic() > until:
                    raise
                time.sleep(0.05)

    def stop(self, how: int) -> None:
        """End it by a signal: SIGINT shuts down and drops clients, SIGQUIT is a crash."""
        assert self._process is not None
        self._process.send_signal(how)
        self._process.wait(20.0)
        self._process = None

    def remove(self) -> None:
        """End it and remove its files."""
        if self._process is not None:
            self.stop(signal.SIGQUIT)  # nobody wants what it would still write
        shutil.rmtree(self._root)

    @property
    def _groups(self) -> list[int] | None:
        return None if self._user is None else []

    def _run(self, program: str, *arguments: str | Path) -> None:
        subprocess.run(
            [self._binaries / program, *arguments],
            check=True,
            capture_output=True,
            user=self._user,
            extra_groups=self._groups,
            cwd=self._root,
        )


def _user() -> str | None:
    """Whom to run it as: a server refuses to be root's."""
    if os.geteuid() != 0:
        return None
    return next(name for name in ("postgres", "nobody") if name in {user.pw_name for user in pwd.getpwall()})


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
