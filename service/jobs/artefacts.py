"""The artefact store: requests, answers and finished pieces of work as files.

    <root>/<ab>/<sha256>          bytes under their sha256
    <root>/<ab>/<sha256>.zst .gz  the same, compressed: what the API serves as it is
    <root>/memo/<ab>/<key>        what was computed, under the sha256 of everything it was computed from

A file is written beside its place, synced and renamed: whoever sees it sees all of it, also after a power
cut. Workers on several hosts may share the directory. What is read is checked against its sha256.

    Exception
      Damaged           what lies under a sha256 has another one
      StoreUnusable     the disk is full, or the directory cannot be read or written
"""

from __future__ import annotations

import gzip
import hashlib
import os
import re
import secrets
import time
import zlib
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, cast

import zstandard

from service.jobs.model import Encoding

_SUFFIXES: dict[Encoding, str] = {"identity": "", "zstd": ".zst", "gzip": ".gz"}
_OPENED: dict[Encoding, Callable[[Path], BinaryIO]] = {
    "identity": lambda path: path.open("rb"),
    "zstd": lambda path: cast("BinaryIO", zstandard.open(path, "rb")),
    "gzip": lambda path: cast("BinaryIO", gzip.GzipFile(path, "rb")),
}
_PIECE = 1024 * 1024
"""[byte] Read at a time."""
_SHA256 = re.compile(r"[0-9a-f]{64}")
_FOLDER = re.compile(r"[0-9a-f]{2}")
_ZSTD_LEVEL, _GZIP_LEVEL = 1, 6
_DIGEST = hashlib.sha256().digest_size
_UNFINISHED = ".new"
_MOST_CHECKED = 10_000


class Damaged(KeyError):
    """Bytes are not those that were put."""


class StoreUnusable(OSError):
    """The file system does not do what it is asked; another time it may."""


class Store:
    """A directory of artefacts; any number of processes may use it."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._checked: dict[str, tuple[int, ...]] = {}

    def put(self, content: bytes, *, served: bool = False) -> str:
        """Keep bytes and return their sha256. served: compressed as well, for clients.

        Raises StoreUnusable.
        """
        sha256 = hashlib.sha256(content).hexdigest()
        path = self._place(sha256)
        if served:  # before the bytes themselves: where those are, the others are
            _write(path.with_name(path.name + ".gz"), gzip.compress(content, _GZIP_LEVEL, mtime=0))
            compressor = zstandard.ZstdCompressor(level=_ZSTD_LEVEL)
            _write(path.with_name(path.name + ".zst"), compressor.compress(content))
        _write(path, content)
        return sha256

    def get(self, sha256: str) -> bytes:
        """Return bytes; KeyError where there are none, Damaged where there are others, StoreUnusable."""
        path = self.path(sha256)
        if path is None:
            raise KeyError(sha256)
        try:
            with _tried():
                content = path.read_bytes()
        except FileNotFoundError:
            raise KeyError(sha256) from None
        if hashlib.sha256(content).hexdigest() != sha256:
            raise Damaged(sha256)
        return content

    def is_whole(self, sha256: str, encoding: Encoding = "identity") -> bool:
        """Whether a file holds its bytes in an encoding; one that has not changed since is not read again.

        Raises StoreUnusable.
        """
        path = self.path(sha256, encoding)
        if path is None:
            return False
        try:
            with _tried():
                found = path.stat()
                mark = (found.st_ino, found.st_size, found.st_mtime_ns)
                if self._checked.get(path.name) == mark:
                    return True
                if _sha256_of(path, encoding) != sha256:
                    return False
        except FileNotFoundError:
            return False
        if len(self._checked) >= _MOST_CHECKED:
            self._checked.clear()
        self._checked[path.name] = mark
        return True

    def path(self, sha256: str, encoding: Encoding = "identity") -> Path | None:
        """Return the file of bytes in an encoding; None where there is none."""
        if not _SHA256.fullmatch(sha256):  # it comes from outside
            return None
        place = self._place(sha256)
        path = place.with_name(place.name + _SUFFIXES[encoding])
        return path if path.is_file() else None

    def keep(self, key: str, content: bytes) -> None:
        """Keep what was computed. key: sha256 of what it was computed from. Raises StoreUnusable."""
        _write(self._memo(key), hashlib.sha256(content).digest() + content)

    def recall(self, key: str) -> bytes | None:
        """Return what was computed; None where nothing is kept or what is kept is damaged."""
        path = self._memo(key)
        try:
            kept = path.read_bytes()
            os.utime(path)  # what is used is not swept
        except OSError:
            return None
        content = kept[_DIGEST:]
        return content if hashlib.sha256(content).digest() == kept[:_DIGEST] else None

    def sweep(self, wanted: Collection[str], *, spare_s: float, memo_s: float) -> int:
        """Remove what is neither wanted nor young; return how many files.

        wanted: sha256 of the artefacts to keep. spare_s: [s], what was written or asked for since then stays:
        a job that is being made is not listed yet. memo_s: [s], the same for what was computed.
        """
        now, removed = time.time(), 0
        for folder in self._folders(self.root):
            removed += _sweep(folder, now - spare_s, wanted)
        for folder in self._folders(self.root / "memo"):
            removed += _sweep(folder, now - memo_s, ())
        return removed

    @staticmethod
    def _folders(root: Path) -> list[Path]:
        return [each for each in root.iterdir() if _FOLDER.fullmatch(each.name)] if root.is_dir() else []

    def _place(self, sha256: str) -> Path:
        return self.root / sha256[:2] / sha256

    def _memo(self, key: str) -> Path:
        return self.root / "memo" / key[:2] / key


def _sha256_of(path: Path, encoding: Encoding) -> str | None:
    """The sha256 of what a file holds in an encoding; None where it is not in that encoding."""
    digest = hashlib.sha256()
    try:
        with _OPENED[encoding](path) as file:
            while piece := file.read(_PIECE):
                digest.update(piece)
    except (EOFError, gzip.BadGzipFile, zlib.error, zstandard.ZstdError):
        return None
    return digest.hexdigest()


@contextmanager
def _tried() -> Iterator[None]:
    """Errors of the file system, but for a file that is not there, as StoreUnusable."""
    try:
        yield
    except FileNotFoundError:
        raise
    except OSError as error:
        raise StoreUnusable(error.errno, error.strerror) from error


def _write(path: Path, content: bytes) -> None:
    with _tried():
        try:
            if path.read_bytes() == content:  # it may be there and damaged
                os.utime(path)
                return
        except FileNotFoundError:
            path.parent.mkdir(parents=True, exist_ok=True)
        new = path.with_name(f"{path.name}.{secrets.token_hex(8)}{_UNFINISHED}")
        try:
            with new.open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            new.replace(path)
        except BaseException:
            new.unlink(missing_ok=True)
            raise
        _sync(path.parent)


def _sync(directory: Path) -> None:
    opened = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def _sweep(folder: Path, before: float, wanted: Collection[str]) -> int:
    """Remove the files of a folder that are older than `before` [s since the epoch] and not wanted.

    Each is put aside first: one that is put again meanwhile is either young then and comes back, or is
    written anew.
    """
    removed = 0
    for path in folder.iterdir():
        if path.name[:64] in wanted and not path.name.endswith(_UNFINISHED):
            continue
        try:
            if path.stat().st_mtime < before:
                aside = path.with_name(path.name + _UNFINISHED)
                path.replace(aside)
                if aside.stat().st_mtime < before:
                    aside.unlink()
                    removed += 1
                else:
                    aside.replace(path)
        except FileNotFoundError:  # another worker sweeps, too
            continue
    return removed
