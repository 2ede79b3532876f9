"""The process that reads one file: its bytes on standard input, the packed model or the problems on output.

Run by `robots.meshes.quarantine`, which gives the name, the unit and the limits as arguments.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
from dataclasses import asdict
from typing import IO


def main() -> None:
    """Limit this process, read the file, answer."""
    name, unit, limits = sys.argv[1:4]
    _limit(json.loads(limits))
    answer = _quiet()
    try:
        parts = _read(name, unit)
    except MemoryError:
        parts = (b"problems\n", _too_expensive())
    with answer:
        for part in parts:
            answer.write(part)
    answer.close()
    os._exit(0)  # nothing that a library does as it ends can matter


def _limit(limits: dict[str, float]) -> None:
    memory, processor = int(limits["memory"]), int(limits["processor"])
    for kind, most in (
        (resource.RLIMIT_AS, memory),
        (resource.RLIMIT_CPU, processor),
        (resource.RLIMIT_FSIZE, int(limits["written"])),
        (resource.RLIMIT_NOFILE, int(limits["open_files"])),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(kind, (most, most))
    signal.alarm(int(limits["seconds"]) + 1)  # should nobody be left to end this process


def _quiet() -> IO[bytes]:
    """The answer; what libraries print goes nowhere, so that it is not taken for one."""
    answer = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    return answer


def _read(name: str, unit: str) -> tuple[bytes, bytes]:
    from robots.errors import InvalidInput
    from robots.meshes.formats import MAX_BYTES
    from robots.meshes.model import METERS
    from robots.meshes.packed import pack
    from robots.meshes.read import read_model

    content = sys.stdin.buffer.read(MAX_BYTES + 1)
    stated = next((each for each in METERS if each == unit), None)
    try:
        return b"model\n", pack(read_model(content, name, stated))
    except InvalidInput as invalid:
        return b"problems\n", json.dumps([asdict(each) for each in invalid.problems]).encode()


def _too_expensive() -> bytes:
    problem = {
        "pointer": "",
        "code": "too_expensive",
        "message": "reading the file takes more memory than it may take",
        "value": None,
        "remedy": "Export with a coarser tolerance, divide the part, or bring it as GLB.",
    }
    return json.dumps([problem]).encode()


if __name__ == "__main__":
    main()
