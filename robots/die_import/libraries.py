"""Imported dies in a library and in a machine: `library_document`, `library_with`, `with_dies`."""

from __future__ import annotations

import copy
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import shapely

from robots.dies import DieLibrary
from robots.errors import InputProblem, InvalidInput
from robots.machine import Machine
from robots.machine_file import load_machine
from robots.processes import ProcessLibrary
from robots.tooling_file import DATA, load_dies

_SHORT_MM = 0.05
_LONG_MM = 0.001
"""[mm] A die that ends this much above or below the mounting face ends at it: meshes are rounded."""


def library_document(entries: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """A die library of these entries alone, as `load_dies` reads it; mounted where the first of them ends."""
    face = lowest_mm(entries[0])
    head = {"schema_version": "1.0", "id": "own_dies", "title": "Own dies", "source": "Imported"}
    mounted = [_mounted(entry, face, f"/dies/{i}") for i, entry in enumerate(entries)]
    return head | {"link": "C", "mounting_face_mm": face, "dies": mounted}


def library_with(entries: Sequence[dict[str, Any]], *, alone: bool = False) -> DieLibrary:
    """The dies that come with rivetplan and these, or these `alone`; its sha256 is of all of them.

    Raises InvalidInput where one does not end at the mounting face, or has the id of another.
    """
    if alone:
        document = library_document(entries)
    else:
        document = json.loads((DATA / "dies.json").read_text(encoding="utf-8"))
        face, first = document["mounting_face_mm"], len(document["dies"])
        document["dies"] += [_mounted(each, face, f"/dies/{first + i}") for i, each in enumerate(entries)]
    return load_dies(json.dumps(document).encode())


def with_dies(
    machine: str | Path,
    entries: Sequence[dict[str, Any]],
    *,
    alone: bool = False,
    processes: ProcessLibrary | None = None,
) -> Machine:
    """A machine, as `load_machine` takes it, with these dies beside those it comes with, or `alone`.

    Raises InvalidInput, also where the dies do not fit the machine.
    """
    return load_machine(machine, dies=library_with(entries, alone=alone), processes=processes)


def lowest_mm(entry: dict[str, Any]) -> float:
    """Where a die ends [mm]."""
    return min(_low(solid["shape"]) for solid in entry["solids"])


def _low(shape: dict[str, Any]) -> float:
    if shape["type"] == "prism":
        return float(min(z for _, z in shape["profile_xz_mm"]))
    return float(shape["z_mm"][0])


def _mounted(entry: dict[str, Any], face: float, pointer: str) -> dict[str, Any]:
    """The entry with its lowest end at the mounting face [mm]: made longer, shorter only by rounding."""
    low = lowest_mm(entry)
    if not face - _LONG_MM <= low <= face + _SHORT_MM:
        message = f"the die ends at {low} mm, the mounting face of the other dies is at {face} mm"
        remedy = "Export the die with all that is above the die slide, or use it in a library of its own."
        raise InvalidInput([InputProblem(f"{pointer}/solids", "not_mounted", message, low, remedy)])
    moved = copy.deepcopy(entry)
    for solid in moved["solids"]:
        shape = solid["shape"]
        if shape["type"] == "prism":
            if _low(shape) == low:
                shape["profile_xz_mm"] = _ended(shape["profile_xz_mm"], low, face)
        elif shape["z_mm"][0] == low:
            shape["z_mm"][0] = face
    return moved


def _ended(profile: list[list[float]], low: float, face: float) -> list[list[float]]:
    """The convex profile that ends at the face, with all of the one that ended at `low` above it [mm]."""
    ends = [[x, face] for x, z in profile if z == low]
    rest = profile if low > face else [[x, z] for x, z in profile if z != low]
    hull = shapely.MultiPoint(rest + ends).convex_hull
    return [list(corner) for corner in shapely.geometry.polygon.orient(hull).exterior.coords[:-1]]
