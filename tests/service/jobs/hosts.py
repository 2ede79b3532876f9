"""Two hosts on one machine: network namespaces on a bridge, which tests cut and mend."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

MISSING = "Network namespaces are not allowed here, so no host is cut off: run the long tests as root."


class Hosts:
    """Network namespaces whose processes reach this one at `address`, and each other through it."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self._mark = os.urandom(2).hex()
        self._bridge, self._names = f"rpb{self._mark}", names
        self.address = f"10.{200 + os.getpid() % 50}.{int(self._mark[:2], 16)}.1"

    @staticmethod
    def are_allowed() -> bool:
        """Whether this process may make them."""
        if shutil.which("ip") is None or os.geteuid() != 0:
            return False
        return subprocess.run(["unshare", "--net", "true"], capture_output=True, check=False).returncode == 0

    @contextmanager
    def made(self) -> Iterator[None]:
        """While inside, they are there."""
        try:
            _ip(f"link add {self._bridge} type bridge")
            _ip(f"addr add {self.address}/24 dev {self._bridge}")
            _ip(f"link set {self._bridge} up")
            for number, name in enumerate(self._names, 2):
                space, ours = self._space(name), self._cable(name)
                _ip(f"netns add {space}")
                _ip(f"link add {ours} type veth peer name eth0 netns {space}")
                _ip(f"link set {ours} master {self._bridge} up")
                address = f"{self.address.rpartition('.')[0]}.{number}"
                _ip(f"-n {space} addr add {address}/24 dev eth0")
                _ip(f"-n {space} link set eth0 up")
                _ip(f"-n {space} link set lo up")
            yield
        finally:
            for name in self._names:
                _ip(f"netns del {self._space(name)}", check=False)
            _ip(f"link del {self._bridge}", check=False)

    def command(self, name: str) -> list[str]:
        """What is put before a command that runs on a host."""
        return ["ip", "netns", "exec", self._space(name)]

    def cut(self, name: str) -> None:
        """Let no packet pass from or to a host; neither end is told."""
        _ip(f"link set {self._cable(name)} down")

    def mend(self, name: str) -> None:
        """Let packets pass again."""
        _ip(f"link set {self._cable(name)} up")

    def _space(self, name: str) -> str:
        return f"rp-{self._mark}-{name}"

    def _cable(self, name: str) -> str:
        return f"rp{self._mark}{name}"


def _ip(arguments: str, *, check: bool = True) -> None:
    subprocess.run(["ip", *arguments.split()], check=check, capture_output=not check)
