"""Dies that a shop could make of those it has: lower under the tip, or with one solid narrower.

A changed die is a whole definition of its own, in the terms of the library's document [mm], and passes all
checks of a library.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import chain, count
from typing import Any

from robots.dies import TIP, Die, DieLibrary
from robots.errors import InvalidInput
from robots.tooling_file import load_dies

_LONGEST_NAME = 64
_LONGEST_TITLE = 500
_DIGITS = 4

Definition = dict[str, Any]


class DieChanges:
    """The dies of one library, changed."""

    def __init__(self, library: DieLibrary) -> None:
        self._document: Definition = json.loads(library.definition)
        self._definitions: dict[str, Definition] = {die["id"]: die for die in self._document["dies"]}

    def lowered(self, die_id: str, by_mm: float) -> Definition:
        """The die with a tip longer by that much: all else of it goes down, but for the face it is mounted
        by.
        """
        mounting = self._document["mounting_face_mm"]

        def down(z: float) -> float:
            return z if z == mounting else round(z - by_mm, _DIGITS)

        old = self._definitions[die_id]
        solids = [{**solid, "shape": _with_heights(solid["shape"], down)} for solid in old["solids"]]
        tip = solids[0]["shape"]
        tip["z_mm"] = [tip["z_mm"][0], 0.0]
        return self._named(old, solids, f"low{_told(by_mm)}", f"{by_mm:g} mm lower")

    def narrowed(self, die_id: str, solid_name: str, by_mm: float) -> Definition:
        """The die with one solid narrower by that much across: half of it on each side."""
        old = self._definitions[die_id]
        solids = [
            {**solid, "shape": _narrower(solid["shape"], by_mm)} if solid["name"] == solid_name else solid
            for solid in old["solids"]
        ]
        change = f"{solid_name} {by_mm:g} mm narrower"
        return self._named(old, solids, f"{solid_name}_narrow{_told(by_mm)}", change)

    def widths(self, die_id: str) -> dict[str, float]:
        """Widths across [mm] of the die's solids, the tip's left out: it forms the tail of the fastener."""
        solids = self._definitions[die_id]["solids"]
        return {solid["name"]: _width(solid["shape"]) for solid in solids if solid["name"] != TIP}

    def built(self, definition: Mapping[str, Any]) -> Die | None:
        """The die of that definition; None where the checks of a library refuse it."""
        alone = {**self._document, "dies": [dict(definition)]}
        try:
            (die,) = load_dies(json.dumps(alone).encode())
        except InvalidInput:
            return None
        return die

    def _named(self, old: Definition, solids: list[Definition], suffix: str, change: str) -> Definition:
        """The changed die with a name that the library does not have yet."""
        for ending in chain([suffix], (f"{suffix}_{k}" for k in count(2))):
            name = f"{old['id'][: _LONGEST_NAME - len(ending) - 1]}_{ending}"
            if name not in self._definitions:
                break
        title = f"{old['title'][: _LONGEST_TITLE - len(change) - 2]}; {change}"
        return {**old, "id": name, "title": title, "solids": solids}


def _with_heights(shape: Definition, down: Any) -> Definition:
    if "profile_xz_mm" in shape:
        return {**shape, "profile_xz_mm": [[x, down(z)] for x, z in shape["profile_xz_mm"]]}
    return {**shape, "z_mm": [down(z) for z in shape["z_mm"]]}


def _width(shape: Definition) -> float:
    if "radius_mm" in shape:
        return 2.0 * float(shape["radius_mm"])
    low, high = shape["y_mm"]
    return float(high - low)


def _narrower(shape: Definition, by_mm: float) -> Definition:
    half = 0.5 * by_mm
    if "radius_mm" in shape:
        return {**shape, "radius_mm": round(shape["radius_mm"] - half, _DIGITS)}
    low, high = shape["y_mm"]
    return {**shape, "y_mm": [round(low + half, _DIGITS), round(high - half, _DIGITS)]}


def _told(mm: float) -> str:
    """An amount as a part of a name, which has no dots."""
    return f"{mm:g}".replace(".", "_")
