"""How compiled functions are compiled: without the GIL, kept on disk, and with plain IEEE arithmetic.

numba looks at one file only when it decides whether a kept result is still good, but a result holds the code
of every function it calls. So results are kept apart by a digest of the whole package (folder) a function is
in: an edited package can never run half old. A compiled function may therefore call compiled functions of its
own folder only; those of another are handed over at run time.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
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


def compiled(function: Function) -> Function:
    """Compile `function` on its first call, or load what an earlier process kept; a decorator."""
    settings: Any = config  # has what the environment may set, without types
    usual = settings.CACHE_DIR
    kept = cache_folder(Path(function.__code__.co_filename).parent)
    settings.CACHE_DIR = str(Path(usual) / kept.name if usual else kept)
    try:
        decorated = numba.njit(nogil=True, cache=True, fastmath=False, error_model="numpy")(function)
    finally:
        settings.CACHE_DIR = usual
    return cast(Function, decorated)
