"""`rivetplan keys`: API keys of the service's clients."""

import fcntl
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar

from service.commands.reading import Unusable
from service.files import write_atomically
from service.security.keys import FILE_NAME, KeyRefused, KeyTable, parse_keys, written_keys
from service.security.scopes import Scope
from service.security.watched import UnusableFile, read_guarded

T = TypeVar("T")

_ONLY_MINE = 0o600


def add(name: str, scopes: Sequence[Scope], data: Path) -> None:
    """Make the first key of a client and print it. Raises Unusable."""
    _show(_changed(data, lambda table: table.added(name, scopes, datetime.now(UTC))))


def rotate(name: str, data: Path) -> None:
    """Make a second key of a client and print it; the first one stays valid. Raises Unusable."""
    _show(_changed(data, lambda table: table.rotated(name, datetime.now(UTC))))


def remove(name: str, key_id: str | None, data: Path) -> None:
    """End a key of a client, or all of theirs. Raises Unusable."""
    _changed(data, lambda table: (table.removed(name, key_id), None))


def show(data: Path) -> None:
    """Print whose keys there are; no secrets, for those are not kept. Raises Unusable."""
    keys = _read(data / FILE_NAME).keys
    rows = [("name", "id", "scopes", "made")]
    rows += [(k.name, k.id, ",".join(k.scopes), k.created.strftime("%Y-%m-%dT%H:%M:%SZ")) for k in keys]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def _show(key: str) -> None:
    """Print a new key alone on stdout, for a script or a vault, and what to know of it beside."""
    print(key)
    print("It is shown this once and kept nowhere; a running service knows it from now on.", file=sys.stderr)


def _changed(data: Path, change: Callable[[KeyTable], tuple[KeyTable, T]]) -> T:
    """Change the file of keys, one at a time, and return what the change returns beside."""
    file = data / FILE_NAME
    try:
        data.mkdir(mode=0o700, parents=True, exist_ok=True)
        with _alone(data / "keys.lock"):
            table, made = change(_read(file))
            write_atomically(file, written_keys(table), mode=_ONLY_MINE)
    except KeyRefused as refused:
        raise Unusable([str(refused)]) from None
    except OSError as error:
        raise Unusable([f"{file}: cannot be written: {error.strerror}. Name another --data."]) from None
    return made


def _read(file: Path) -> KeyTable:
    try:
        return read_guarded(file, parse_keys)
    except UnusableFile as unusable:
        raise Unusable([f"{unusable}."]) from None


@contextmanager
def _alone(lock: Path) -> Iterator[None]:
    """Wait until no other command changes the keys."""
    descriptor = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, _ONLY_MINE)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)
