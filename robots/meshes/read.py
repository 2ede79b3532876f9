"""A file's bytes, read: in this process, and with no limits but on what the file declares.

Whoever takes files from others goes through `robots.meshes.quarantine`, which runs this in a process of its
own.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import PurePosixPath

from robots.errors import InvalidInput
from robots.meshes import soup, units
from robots.meshes.formats import check_content, format_of
from robots.meshes.glb import read_glb
from robots.meshes.model import METERS, Format, Model, Unit
from robots.meshes.obj import read_obj
from robots.meshes.ply import read_ply
from robots.meshes.refusals import refused, unreadable
from robots.meshes.soup import Soup
from robots.meshes.step import read_step
from robots.meshes.stl import read_stl

_READERS: dict[Format, Callable[[bytes, str], list[Soup]]] = {
    "stl": read_stl,
    "obj": read_obj,
    "ply": read_ply,
    "glb": read_glb,
}


def read_model(content: bytes, name: str, unit: Unit | None) -> Model:
    """The model in a file of these bytes.

    name: of the file; its extension tells the format, its stem names a body that has no name. unit: what the
    numbers of STL, OBJ and PLY are taken in, which do not tell; glTF is in metres and STEP tells, where any
    other `unit` is an error. Raises InvalidInput, with the pointer "/unit" where the unit is at fault.
    """
    format_ = format_of(name)
    check_content(content, format_)
    sha256, stem = hashlib.sha256(content).hexdigest(), PurePosixPath(name).stem
    try:
        found, told = _found(content, format_, stem)
    except InvalidInput:
        raise
    except MemoryError:
        message, remedy = (
            "reading the file takes more memory than there is",
            "Export with a coarser tolerance.",
        )
        raise refused("too_expensive", message, remedy, value=len(content)) from None
    except Exception as error:  # a library met something that its own checks do not foresee
        raise unreadable(
            f"the {format_.upper()} data is damaged", f"{type(error).__name__}: {error}"
        ) from None
    soup.check(found)
    sizes = soup.extent(found)
    if told is None and unit is None:
        raise units.unit_missing(sizes)
    if told is not None:
        units.check_told(told, unit, sizes)
    taken: Unit = told or unit or "m"
    units.check_plausible(sizes, taken)
    return Model(sha256, format_, taken, told is not None, soup.to_bodies(found, METERS[taken]))


def _found(content: bytes, format_: Format, stem: str) -> tuple[list[Soup], Unit | None]:
    """The bodies, and the unit that the file tells."""
    if format_ == "step":
        return read_step(content, stem)
    return _READERS[format_](content, stem), "m" if format_ == "glb" else None
