"""The sha256 of a value's content, and of the code that computes: what finished work is kept under."""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Protocol

import numpy as np

_PACKAGES = ("planners", "robots", "service")


class _Hash(Protocol):
    def update(self, data: bytes, /) -> None: ...


def fingerprint(*values: object) -> str:
    """The sha256 of values made of dataclasses, enums, mappings, sequences, arrays and plain values.

    Equal content gives equal digests, in any process; another order of a mapping may give another. Raises
    TypeError for anything else: what is not understood is not kept.
    """
    digest = hashlib.sha256()
    _feed(digest, values)
    return digest.hexdigest()


def _feed(digest: _Hash, value: object) -> None:
    kind = type(value)
    name = f"{kind.__module__}.{kind.__qualname__}"
    if isinstance(value, Enum):
        _mark(digest, name, value.name.encode())
    elif value is None or isinstance(value, bool | int | float | str):
        _mark(digest, name, repr(value).encode("utf-8", "surrogatepass"))
    elif isinstance(value, bytes):
        _mark(digest, name, value)
    elif isinstance(value, np.ndarray | np.generic):
        if value.dtype.hasobject:
            raise TypeError(f"an array of {value.dtype} has no fingerprint")
        _mark(digest, f"{value.dtype.str}{value.shape}", np.ascontiguousarray(value).tobytes())
    elif is_dataclass(value):
        _several(digest, name, [getattr(value, field.name) for field in fields(value)])
    elif isinstance(value, Mapping):
        _several(digest, name, [part for item in value.items() for part in item])
    elif isinstance(value, tuple | list):
        _several(digest, name, value)
    else:
        raise TypeError(f"a {name} has no fingerprint")


def _several(digest: _Hash, name: str, values: list[object] | tuple[object, ...]) -> None:
    _mark(digest, name, str(len(values)).encode())
    for value in values:
        _feed(digest, value)


def _mark(digest: _Hash, name: str, content: bytes) -> None:
    digest.update(f"{name}:{len(content)}:".encode())
    digest.update(content)


@cache
def code_fingerprint() -> str:
    """The sha256 of rivetplan's own files, of what it stands on, and of the interpreter."""
    digest = hashlib.sha256(sys.version.encode())
    for package in _PACKAGES:
        spec = find_spec(package)  # importing them takes longer than reading their files
        assert spec is not None
        assert spec.origin is not None
        root = Path(spec.origin).parent
        for path in sorted(root.rglob("*")):
            if path.suffix in (".py", ".json"):
                _mark(digest, path.relative_to(root.parent).as_posix(), path.read_bytes())
    for requirement in metadata.requires("rivetplan") or ():
        name = re.match(r"[\w.-]+", requirement)
        if name and "extra ==" not in requirement:
            _mark(digest, name[0], metadata.version(name[0]).encode())
    return digest.hexdigest()
