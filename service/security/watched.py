"""A file of settings that may change while the service runs.

Exception
  UnusableFile    a file of settings cannot be used
"""

import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Generic, TypeVar

T = TypeVar("T")

_MOST_BYTES = 10_000_000
_OTHERS_MAY_WRITE = stat.S_IWGRP | stat.S_IWOTH


class UnusableFile(Exception):
    """A file that says who may ask cannot be used."""

    def __init__(self, path: Path, why: str) -> None:
        self.path, self.why = path, why
        super().__init__(path, why)

    def __str__(self) -> str:
        return f"{self.path}: {self.why}"


class Watched(Generic[T]):
    """What a file says now: it is read again when it has changed, which costs a look at its date else."""

    def __init__(self, path: Path, parse: Callable[[bytes], T]) -> None:
        """parse: of the file's content, b"" where there is no file; ValueError says why it is unusable."""
        self._path = path
        self._parse = parse
        self._read: tuple[object, T] | None = None

    def value(self) -> T:
        """Return what the file says. Raises UnusableFile, and does not go by what it said before."""
        found = _version(self._path)  # before it is read: what is written meanwhile has another
        if self._read is None or self._read[0] != found:
            self._read = None
            self._read = (found, read_guarded(self._path, self._parse))
        return self._read[1]


def read_guarded(path: Path, parse: Callable[[bytes], T]) -> T:
    """Return what a file says that nobody else may change. Raises UnusableFile."""
    try:
        with path.open("rb") as file:
            if os.fstat(file.fileno()).st_mode & _OTHERS_MAY_WRITE:
                raise UnusableFile(path, "others may write it; take that away with chmod go-w")
            content = file.read(_MOST_BYTES + 1)
    except FileNotFoundError:
        content = b""
    except OSError as error:
        raise UnusableFile(path, f"cannot be read: {error.strerror}") from None
    if len(content) > _MOST_BYTES:
        raise UnusableFile(path, f"has more than {_MOST_BYTES} bytes")
    try:
        return parse(content)
    except ValueError as error:
        raise UnusableFile(path, str(error)) from None


def _version(path: Path) -> object:
    """Return what differs between two versions of a file; None where there is none."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise UnusableFile(path, f"cannot be read: {error.strerror}") from None
    return found.st_dev, found.st_ino, found.st_mtime_ns, found.st_ctime_ns, found.st_size
