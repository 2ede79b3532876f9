"""A program made again after a change: what is kept of the previous one, and what became of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from robots.cell import Blockage, Cell
from robots.changes import changes, other_settings
from robots.nc import NcHeader, NcProgram
from robots.outline import Between, Outline, outline_of
from robots.panel import Panel
from robots.previous import KeptPass, kept_pass
from service.timing import Timing


class Change:
    """The change from a `previous` program to the one with `header`, timed by `timing`."""

    def __init__(self, previous: Outline, header: NcHeader, timing: Timing | None = None) -> None:
        self._previous = previous
        self._paced = (timing or Timing()).rounds_as(previous.policy)
        self._everything = other_settings(previous.header, header)
        self._blocked: dict[tuple[str, Between], Blockage] = {}

    def unknown(self, panel: Panel) -> int:
        """How many fasteners the previous program says nothing about."""
        known = {name for each in self._previous.passes.values() for name in each.stations}
        return len(panel.fasteners) - (0 if self._everything else sum(f.id in known for f in panel.fasteners))

    def kept(self, cell: Cell) -> KeptPass:
        """What is left of the pass with the cell's die."""
        before = self._previous.passes.get(cell.die.id)
        return (
            KeptPass() if before is None or self._everything else kept_pass(cell, before, paced=self._paced)
        )

    def found(self, die_id: str, blocked: Mapping[Between, Blockage]) -> None:
        """Keep what is in the way of links that were there with a die."""
        self._blocked.update({(die_id, ends): blockage for ends, blockage in blocked.items()})

    def told(self, program: NcProgram) -> NcProgram:
        """The new program with what is not as before."""
        found = changes(self._previous, outline_of(program), self._everything, self._blocked)
        return replace(program, changes=found)
