"""What moves in a cell and what must keep apart: the machine's solids with one die and one foot, and their
pairs.
"""

from __future__ import annotations

from dataclasses import dataclass

from robots.dies import Die
from robots.machine import PANEL, FootState, Machine
from robots.solids import Solid


@dataclass(frozen=True)
class Pair:
    """Two things that must keep apart: a machine solid and the panel, or two machine solids."""

    solid: str
    other: str
    of_die: bool

    @property
    def with_panel(self) -> bool:
        return self.other == PANEL


@dataclass(frozen=True, eq=False)
class Assembly:
    """Solids and pairs, both in the order in which everything here counts them; panel pairs come first."""

    solids: tuple[Solid, ...]
    pairs: tuple[Pair, ...]


def assembled(machine: Machine, die: Die, foot: FootState) -> Assembly:
    """The machine with that die and its foot "open" or "clamped"."""
    # Die first: it is what usually meets the panel, and a test stops at the first pair that fails.
    solids = machine.assembly(die, foot)[::-1]
    of_die = set(die.solid_names)
    against_panel = [Pair(solid.name, PANEL, solid.name in of_die) for solid in solids]
    own = [Pair(one, other, one in of_die) for one, other in machine.self_pairs_with(die, foot)]
    return Assembly(solids, (*against_panel, *own))
