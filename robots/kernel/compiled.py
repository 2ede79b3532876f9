"""How the kernel's functions are compiled: without the GIL, kept on disk, and with plain IEEE arithmetic.

numba looks at one file only when it decides whether a kept result is still good, but a result holds the code
of every function it calls. So results are kept apart by a digest of the whole package: an edited kernel can
never run half old.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import config

Function = TypeVar("Function", bound=Callable[..., Any])
_HERE = Path(__file__).parent


def source_digest(folder: Path) -> str:
    """Digest of the Python sources of a folder: names and bytes, in the order of the names."""
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Where compiled results are kept: beside the sources, or in the user's cache if they are read-only."""
    home = _HERE / "__pycache__"
    writable = os.access(home if home.exists() else _HERE, os.W_OK)
    return (home if writable else Path.home() / ".cache" / "rivetplan") / f"kernel-{source_digest(_HERE)}"


_FOLDER = cache_folder()


def compiled(function: Function) -> Function:
    """Compile `function` on its first call, or load what an earlier process kept; a decorator."""
    settings: Any = config  # has what the environment may set, without types
    usual = settings.CACHE_DIR
    settings.CACHE_DIR = str(Path(usual) / _FOLDER.name if usual else _FOLDER)
    try:
        decorated = numba.njit(nogil=True, cache=True, fastmath=False, error_model="numpy")(function)
    finally:
        settings.CACHE_DIR = usual
    return cast(Function, decorated)
