"""How compiled functions are compiled: without the GIL, kept on disk, and with plain IEEE arithmetic.

numba looks at one file only when it decides whether a kept result is still good, but a result holds the code
of every function it calls. So results are kept apart by a digest of the whole package (folder) a function is
in: an edited package can never run half old. A compiled function may therefore call compiled functions of its
own folder only; those of another are handed over at run time.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import config

Function = TypeVar("Function", bound=Callable[..., Any])


def source_digest(folder: Path) -> str:
    """Digest of the Python sources of a folder: names and bytes, in the order of the names."""
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


@cache
def cache_folder(folder: Path) -> Path:
    """Where results of a folder are kept: beside the sources, else in the user's cache."""
    home = folder / "__pycache__"
    writable = os.access(home if home.exists() else folder, os.W_OK)
    return (home if writable else Path.home() / ".cache" / "rivetplan") / f"compiled-{source_digest(folder)}"


@contextmanager
def _kept_with(function: Callable[..., Any]) -> Iterator[None]:
    """Let numba keep what is compiled inside in the folder that goes with the function's sources."""
    settings: Any = config  # has what the environment may set, without types
    usual = settings.CACHE_DIR
    kept = cache_folder(Path(function.__code__.co_filename).parent)
    settings.CACHE_DIR = str(Path(usual) / kept.name if usual else kept)
    try:
        yield
    finally:
        settings.CACHE_DIR = usual


def compiled(function: Function) -> Function:
    """Compile `function` on its first call, or load what an earlier process kept; a decorator."""
    with _kept_with(function):
        decorated = numba.njit(nogil=True, cache=True, fastmath=False, error_model="numpy")(function)
    return cast(Function, decorated)


def compiled_on_views(function: Function) -> Function:
    """As `compiled`, for functions that make no arrays: none is counted, and so the caller has to keep alive
    whatever it hands over. Counting references to dozens of arrays costs more than short functions do.
    """
    njit: Any = numba.njit  # its types leave this option out
    with _kept_with(function):
        decorated = njit(_nrt=False, nogil=True, cache=True, fastmath=False, error_model="numpy")(function)
    return cast(Function, decorated)


def compiled_callback(signature: Any) -> Callable[[Callable[..., Any]], Any]:
    """As `compiled`, for a C function of one signature: the result has an `address`; a decorator."""

    def decorator(function: Callable[..., Any]) -> Any:
        with _kept_with(function):
            return numba.cfunc(signature, cache=True, fastmath=False, error_model="numpy")(function)

    return decorator
