"""Writes an itinerary down as NC blocks.

Numbers are rounded first and timed afterwards (`service.timing`): axis values to the program's digits, path
limits down, durations up to the next microsecond. Time is counted in whole microseconds, so that no sum
depends on its order.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from planners.arrays import Array
from planners.retiming import PathLimits
from robots.cell import Cell
from robots.links import Link
from robots.machine import Machine
from robots.nc import BlockKind, NcAxes, NcBlock, NcEvent
from robots.panel import Panel
from robots.process_record import handshake_record
from robots.processes import Process
from robots.stations import Station
from service.itinerary import DiePass, Itinerary
from service.timing import MICRO, Timing, micro_up, timed_moves

_BLOCK_STEP = 10
"""Block numbers leave room for lines inserted by hand, as on every control."""


class BlockWriter:
    """Collects the blocks of one program: `blocks`, `elapsed_us` and the time by kind, `spent_us`.

    cells: gives the cell with a die, which certifies rounded corners; without it there are none. refused: how
    often the verifier has refused the corner at the end of a block, by its number.
    """

    def __init__(
        self,
        machine: Machine,
        panel: Panel,
        first_die: str,
        timing: Timing | None = None,
        cells: Callable[[str], Cell] | None = None,
        refused: Mapping[int, int] | None = None,
    ) -> None:
        self._machine, self._timing, self._cells = machine, timing or Timing(), cells
        self._refused = refused or {}
        self._stacks = {f.id: s for f, s in zip(panel.fasteners, panel.stacks, strict=True)}
        self._axes = NcAxes.of(machine.home)
        self._die_id = first_die
        self.blocks: list[NcBlock] = []
        self.elapsed_us = 0
        self.spent_us: dict[str, int] = {}
        self.process_block: dict[str, int] = {}
        self._events: dict[str, tuple[tuple[NcEvent, ...], int]] = {}
        self._rest("move", 0, origin="direct")

    def write(self, itinerary: Itinerary) -> None:
        """Write all passes, each from home and back to it, with a die change between them."""
        for each in itinerary.passes:
            if each.die_id != self._die_id:
                self._die_id = each.die_id
                self._rest("die_change", micro_up(self._machine.die_change_duration))
            self._write_pass(each)

    def _write_pass(self, each: DiePass) -> None:
        left: list[Array] = []  # the open pose that a link leaves; none at home
        for stop in each.stops:
            if stop.link is None:
                raise ValueError(f"fastener {stop.station.fastener.id} has no link")
            opened = stop.station.opened
            self._write_link(stop.link, stop.station.fastener.id, [*left, opened])
            self._write_station(stop.station)
            left = [opened]
        self._write_link(each.way_home, None, left)

    def _write_link(self, link: Link, fastener_id: str | None, poses: Sequence[Array]) -> None:
        """poses: the open poses at its ends."""
        origin = link.result.origin
        spent_on = "move" if origin.startswith(("direct", "approach:")) else "escape"
        waypoints = list(link.waypoints[1:])
        self._moves("move", waypoints, fastener_id, origin, spent_on, poses=poses, pace=link.pace)

    def _write_station(self, station: Station) -> None:
        fastener = station.fastener
        process = self._machine.processes[fastener.process]
        contacts = tuple(("tip", part) for part in self._stacks[fastener.id].parts)
        self._moves("approach", [station.clamped], fastener.id, "process", "approach", contacts)
        self._process(process, fastener.id, contacts)
        self._moves("retreat", [station.opened], fastener.id, "process", "approach", contacts)

    def _process(self, process: Process, fastener_id: str, contacts: tuple[tuple[str, str], ...]) -> None:
        if process.id not in self._events:
            self._events[process.id] = process_events(process)
        events, duration_us = self._events[process.id]
        self._rest("process", duration_us, fastener_id, process.id, events, contacts)
        self.process_block[fastener_id] = self.blocks[-1].n

    def _moves(
        self,
        kind: BlockKind,
        waypoints: Sequence[Array],
        fastener_id: str | None,
        origin: str,
        spent_on: str,
        contacts: tuple[tuple[str, str], ...] = (),
        poses: Sequence[Array] | None = None,
        pace: Sequence[PathLimits] | None = None,
    ) -> None:
        """Straight blocks through `waypoints`, each (n,); nothing where the machine stands there already.

        poses: the open poses at the ends of a link, whose corners may be rounded; pace: see `Link`.
        """
        space = None
        if self._timing.law == "overlap" and self._cells and poses is not None and len(waypoints) > 1:
            space = self._cells(self._die_id).corner_space(poses)
        first = self._next_n()

        def refused(corner: int) -> int:
            return self._refused.get(first + _BLOCK_STEP * corner, 0)

        for move in timed_moves(self._machine, self._timing, self._axes, waypoints, space, pace, refused):
            self._axes = move.axes
            block = NcBlock(
                n=self._next_n(),
                kind=kind,
                axes=move.axes,
                t_start_s=self.elapsed_us / MICRO,
                t_end_s=(self.elapsed_us + move.duration_us) / MICRO,
                die_id=self._die_id,
                dynamics=move.dynamics,
                fastener_id=fastener_id,
                allowed_contacts=contacts,
                origin=origin,
                blend=move.blend,
            )
            self._append(block, move.duration_us - move.overlap_us, spent_on)

    def _rest(
        self,
        kind: BlockKind,
        duration_us: int,
        fastener_id: str | None = None,
        process_id: str | None = None,
        events: tuple[NcEvent, ...] = (),
        contacts: tuple[tuple[str, str], ...] = (),
        origin: str = "process",
    ) -> None:
        """A block without motion."""
        block = NcBlock(
            n=self._next_n(),
            kind=kind,
            axes=self._axes,
            t_start_s=self.elapsed_us / MICRO,
            t_end_s=(self.elapsed_us + duration_us) / MICRO,
            die_id=self._die_id,
            events=events,
            fastener_id=fastener_id,
            process_id=process_id,
            allowed_contacts=contacts,
            origin=origin,
        )
        self._append(block, duration_us, kind)

    def _append(self, block: NcBlock, duration_us: int, spent_on: str) -> None:
        self.blocks.append(block)
        self.elapsed_us += duration_us
        self.spent_us[spent_on] = self.spent_us.get(spent_on, 0) + duration_us

    def _next_n(self) -> int:
        return _BLOCK_STEP * (len(self.blocks) + 1)


def process_events(process: Process) -> tuple[tuple[NcEvent, ...], int]:
    """The events of a process block, one after the other, and how long they take together [us]."""
    starts = np.cumsum([0, *(micro_up(step.duration) for step in process.steps)]).tolist()
    events = tuple(
        NcEvent(str(step.code), at / MICRO, handshake_record(step))
        for step, at in zip(process.steps, starts[:-1], strict=True)
    )
    return events, starts[-1]
