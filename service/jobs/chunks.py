"""Finished runs of a panel, kept in the artefact store: a job that is begun again computes only the rest.

A run is kept under the sha256 of everything it depends on: the code and what it stands on, machine, dies,
processes, panel, options, the task and the escapes it begins with. It is kept pickled, as it travels between
the processes of a crew; what is read back may consist of arrays and of our own value classes only, and a
panel's fasteners are named by their index.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Callable
from dataclasses import is_dataclass
from enum import Enum
from typing import Any

import zstandard

from robots.panel import Panel
from service.die_pass import Run
from service.jobs.artefacts import Store
from service.jobs.fingerprint import code_fingerprint, fingerprint

_OURS = ("planners.", "robots.", "service.")
_ARRAYS = {
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
    ("numpy._core.numeric", "_frombuffer"),
}
_LEVEL = 1


class ChunkMemo:
    """Runs that were planned before, by any worker.

    after: told after each run whether it was recalled; may raise to stop there.
    """

    def __init__(self, store: Store, after: Callable[[bool], None]) -> None:
        self._store, self._after = store, after

    def run(self, inputs: tuple[object, ...], panel: Panel, plan: Callable[[], Run]) -> Run:
        """Return what `plan` returned earlier for the same inputs, or what it returns now."""
        key = fingerprint(code_fingerprint(), inputs)
        kept = self._store.recall(key)
        if kept is not None:
            run = decoded(kept, panel)
        else:
            run = plan()
            self._store.keep(key, encoded(run, panel))
        self._after(kept is not None)
        return run


def encoded(run: Run, panel: Panel) -> bytes:
    """A run as bytes; what belongs to the panel is named, not copied."""
    buffer = io.BytesIO()
    _Writer(buffer, panel).dump(run)
    return zstandard.ZstdCompressor(level=_LEVEL).compress(buffer.getvalue())


def decoded(content: bytes, panel: Panel) -> Run:
    """The run in bytes; raises pickle.UnpicklingError where something else is in them."""
    run = _Reader(io.BytesIO(zstandard.ZstdDecompressor().decompress(content)), panel).load()
    if not isinstance(run, Run):
        raise pickle.UnpicklingError(f"a {type(run).__name__} is not a run")
    return run


class _Writer(pickle.Pickler):
    def __init__(self, file: io.BytesIO, panel: Panel) -> None:
        super().__init__(file, protocol=5)
        owned = [*panel.fasteners, *panel.stacks]
        self._owned = {id(each): index for index, each in enumerate(owned)}

    def persistent_id(self, value: Any) -> int | None:
        return self._owned.get(id(value))


class _Reader(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, panel: Panel) -> None:
        super().__init__(file)
        self._owned = [*panel.fasteners, *panel.stacks]

    def persistent_load(self, index: Any) -> object:
        return self._owned[index]

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) in _ARRAYS:
            return super().find_class(module, name)
        if module.startswith(_OURS):
            found = super().find_class(module, name)
            if isinstance(found, type) and (is_dataclass(found) or issubclass(found, Enum | tuple)):
                return found
        raise pickle.UnpicklingError(f"{module}.{name} does not belong into a run")
