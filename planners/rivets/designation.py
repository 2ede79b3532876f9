"""Codes of solid rivets, MS20426AD5-8: standard, head, alloy, diameter, length (Dakdouk 2016, A.1)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal, get_args

from planners.errors import InvalidSetting
from planners.rivets.sizing import DIAMETER_GRID, LENGTH_GRID, RivetSize

#: National aircraft, military, and air force-navy standard.
Standard = Literal["NAS", "MS20", "AN"]

_CODE = re.compile(r"(NAS|MS20|AN)\s*(\d{3,4})\s*([A-Z]{1,2})\s*(\d{1,3})\s*-\s*(\d{1,3})", re.ASCII)
_HEAD = re.compile(r"\d{3,4}", re.ASCII)
_ALLOY = re.compile(r"[A-Z]{1,2}", re.ASCII)
_LARGEST = 999


@dataclass(frozen=True)
class Designation:
    """A rivet's code, taken apart.

    head: number of the head's shape, as "426" or "470". alloy: its letters, as "AD" (2117-T4).
    diameter_32nds: in 1/32 in. length_16ths: in 1/16 in.
    """

    standard: Standard
    head: str
    alloy: str
    diameter_32nds: int
    length_16ths: int

    def __post_init__(self) -> None:
        if self.standard not in get_args(Standard):
            raise InvalidSetting("standard", self.standard, "NAS, MS20 or AN")
        if not _HEAD.fullmatch(self.head):
            raise InvalidSetting("head", self.head, "three or four digits")
        if not _ALLOY.fullmatch(self.alloy):
            raise InvalidSetting("alloy", self.alloy, "one or two capital letters")
        for field in ("diameter_32nds", "length_16ths"):
            if not 1 <= getattr(self, field) <= _LARGEST:
                raise InvalidSetting(field, getattr(self, field), f"from 1 to {_LARGEST}")

    @property
    def diameter(self) -> float:
        """[m]."""
        return self.diameter_32nds * DIAMETER_GRID

    @property
    def length(self) -> float:
        """[m]."""
        return self.length_16ths * LENGTH_GRID

    def __str__(self) -> str:
        return f"{self.standard}{self.head}{self.alloy}{self.diameter_32nds}-{self.length_16ths}"


def parse_designation(code: str) -> Designation:
    """Return what a code says; blanks between its parts do not count. Raises InvalidSetting."""
    match = _CODE.fullmatch(code.strip())
    if match is None:
        raise InvalidSetting("code", code, "like MS20426AD5-8, with NAS, MS20 or AN in front")
    standard: Standard = next(each for each in get_args(Standard) if each == match[1])
    return Designation(standard, match[2], match[3], int(match[4]), int(match[5]))


def designation_of(size: RivetSize, standard: Standard, head: str, alloy: str) -> Designation | None:
    """Return the code of a rivet of this size; None where it is not rounded to the standard's grid."""
    diameter, length = size.diameter_32nds, size.length_16ths
    if diameter is None or length is None:
        return None
    return Designation(standard, head, alloy, diameter, length)
