"""Writes an itinerary down as NC blocks, timed as exact stops.

Numbers are rounded first and timed afterwards: axis values to the program's digits, path limits down,
durations up to the next microsecond. Time is counted in whole microseconds, so that no sum depends on its
order.
"""

from __future__ import annotations

import math

import numpy as np

from planners.arrays import Array
from planners.retiming import PathLimits, path_limits, rest_to_rest
from robots.links import Link
from robots.machine import Machine
from robots.nc import BlockKind, NcAxes, NcBlock, NcDynamics, NcEvent
from robots.nc_codec import SignificantDown
from robots.panel import Panel
from robots.processes import Process
from robots.stations import Station
from service.itinerary import DiePass, Itinerary

_BLOCK_STEP = 10
"""Block numbers leave room for lines inserted by hand, as on every control."""
_MICRO = 1_000_000
_LIMIT_DIGITS = SignificantDown(6)


class BlockWriter:
    """Collects the blocks of one program: `blocks`, `elapsed_us` and the time by kind, `spent_us`."""

    def __init__(self, machine: Machine, panel: Panel, first_die: str) -> None:
        self._machine = machine
        self._stacks = {f.id: s for f, s in zip(panel.fasteners, panel.stacks, strict=True)}
        self._axes = NcAxes.of(machine.home)
        self._q = self._axes.q
        self._die_id = first_die
        self.blocks: list[NcBlock] = []
        self.elapsed_us = 0
        self.spent_us: dict[str, int] = {}
        self.process_block: dict[str, int] = {}
        self._rest("move", 0, origin="direct")

    def write(self, itinerary: Itinerary) -> None:
        """Write all passes, each from home and back to it, with a die change between them."""
        for each in itinerary.passes:
            if each.die_id != self._die_id:
                self._die_id = each.die_id
                self._rest("die_change", _micro_up(self._machine.die_change_duration))
            self._write_pass(each)

    def _write_pass(self, each: DiePass) -> None:
        for stop in each.stops:
            if stop.link is None:
                raise ValueError(f"fastener {stop.station.fastener.id} has no link")
            self._write_link(stop.link, stop.station.fastener.id)
            self._write_station(stop.station)
        self._write_link(each.way_home, None)

    def _write_link(self, link: Link, fastener_id: str | None) -> None:
        origin = link.result.origin
        for q in link.waypoints[1:]:
            self._move("move", q, fastener_id, origin, "move" if origin == "direct" else "escape")

    def _write_station(self, station: Station) -> None:
        fastener = station.fastener
        process = self._machine.processes[fastener.process]
        contacts = tuple(("tip", part) for part in self._stacks[fastener.id].parts)
        self._move("approach", station.clamped, fastener.id, "process", "approach", contacts)
        self._process(process, fastener.id, contacts)
        self._move("retreat", station.opened, fastener.id, "process", "approach", contacts)

    def _process(self, process: Process, fastener_id: str, contacts: tuple[tuple[str, str], ...]) -> None:
        starts = np.cumsum([0, *(_micro_up(step.duration) for step in process.steps)]).tolist()
        events = tuple(
            NcEvent(str(step.code), at / _MICRO) for step, at in zip(process.steps, starts[:-1], strict=True)
        )
        self._rest("process", starts[-1], fastener_id, process.id, events, contacts)
        self.process_block[fastener_id] = self.blocks[-1].n

    def _move(
        self,
        kind: BlockKind,
        q: Array,
        fastener_id: str | None,
        origin: str,
        spent_on: str,
        contacts: tuple[tuple[str, str], ...] = (),
    ) -> None:
        """One straight block to `q` (n,); nothing where the machine stands there already."""
        axes = NcAxes.of(q)
        if axes == self._axes:
            return
        machine, written = self._machine, axes.q
        limits = _written(path_limits(written - self._q, machine.v_max, machine.a_max, machine.j_max))
        duration_us = _micro_up(rest_to_rest(limits).duration)
        dynamics = NcDynamics(v_per_s=limits.v, a_per_s2=limits.a, j_per_s3=limits.j)
        self._axes, self._q = axes, written
        self._append(
            NcBlock(
                n=self._next_n(),
                kind=kind,
                axes=axes,
                t_start_s=self.elapsed_us / _MICRO,
                t_end_s=(self.elapsed_us + duration_us) / _MICRO,
                die_id=self._die_id,
                dynamics=dynamics,
                fastener_id=fastener_id,
                allowed_contacts=contacts,
                origin=origin,
            ),
            duration_us,
            spent_on,
        )

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
            t_start_s=self.elapsed_us / _MICRO,
            t_end_s=(self.elapsed_us + duration_us) / _MICRO,
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


def _written(limits: PathLimits) -> PathLimits:
    """The limits as they will be written: rounded down, so never above what the axes allow."""
    return PathLimits(*[_LIMIT_DIGITS.rounded(value) for value in (limits.v, limits.a, limits.j)])


def _micro_up(seconds: float) -> int:
    """Whole microseconds, rounded up; a nanosecond of rounding error above a whole one does not count."""
    return math.ceil(seconds * _MICRO - 1e-3)
