"""Cycle times of programs: as they are timed, or over the same way by the motion law of the thesis.

The thesis moves one tool point from stop to stop with the quintic of (5.26), within a speed and an
acceleration (`planners.s_curve`; 5.35, corrected). Here that point is the die tip as the panel sees it, and
each straight block is one such motion over the distance between its ends; turning about that point takes no
time. What is no motion (process steps, die changes) takes the program's.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import accumulate, pairwise
from typing import Protocol

import numpy as np
from pydantic import BaseModel

from planners.arrays import Array
from planners.cycle_time import CycleTime
from planners.errors import InvalidSetting
from planners.retiming import PathLimits
from planners.s_curve import rest_to_rest_time
from robots.errors import InputProblem, InvalidInput
from robots.machine import Machine
from robots.nc import NcBlock, NcProgram
from robots.nc_cycle import NcCycle, cycle_of
from robots.verify_kinematics import Kinematics
from robots.verify_motions import configurations

_HOUR = 3600.0  # [s]
Spans = list[tuple[float, float]]


class MotionLaw(Protocol):
    """Another way to time a program's motion."""

    @property
    def title(self) -> str:
        """For people."""
        ...

    def spans(self, program: NcProgram, machine: Machine) -> Spans:
        """Start and end [s] of each block, of which there is at least one."""
        ...


@dataclass(frozen=True)
class ThesisLaw:
    """Limits of the tool point: `speed` [m/s] and `acceleration` [m/s^2]; those that Dakdouk 2016 prints."""

    speed: float = 2.2
    acceleration: float = 14.0

    @property
    def title(self) -> str:
        """For people."""
        return f"thesis: {self.speed:g} m/s, {self.acceleration:g} m/s2"

    def duration(self, distance: float) -> float:
        """From rest to rest over `distance` [m], in [s]."""
        return rest_to_rest_time(distance, PathLimits(self.speed, self.acceleration, np.inf))

    def spans(self, program: NcProgram, machine: Machine) -> Spans:
        """Start and end [s] of each block by this law."""
        blocks = program.blocks
        distances = np.linalg.norm(np.diff(_tips(program, machine), axis=0), axis=1).tolist()
        durations = [blocks[0].t_end_s - blocks[0].t_start_s]
        for block, distance in zip(blocks[1:], distances, strict=True):
            moves = block.dynamics is not None
            durations.append(self.duration(distance) if moves else block.t_end_s - block.t_start_s)
        return list(pairwise(accumulate(durations, initial=0.0)))


class FastenerCycle(BaseModel):
    """One fastener: the arrival at its open pose, the way to it, and the time spent there."""

    fastener_id: str
    at_s: float
    way_s: float
    work_s: float


class ProgramCycle(BaseModel):
    """The cycle time of a program; the figures are those of `NcCycle`."""

    program_id: str
    title: str
    fasteners: int
    to_first_s: float
    cycle_s: float
    per_minute: float
    task_s: float
    back_s: float
    total_s: float
    parts_per_hour: float
    each: list[FastenerCycle]


class CycleReport(BaseModel):
    """What `rivetplan cycle --out` writes."""

    programs: list[ProgramCycle]


def cycle_times(program: NcProgram, machine: Machine, law: MotionLaw | None) -> tuple[CycleTime, Spans]:
    """The cycle time and the blocks' times; as the program is timed without a law.

    Raises InvalidInput where no fastener is done, or the blocks' times do not rise.
    """
    blocks = program.blocks
    spans = [(block.t_start_s, block.t_end_s) for block in blocks]
    if law is not None and blocks:
        spans = law.spans(program, machine)
    try:
        found = cycle_of(blocks, spans) if blocks else None
    except InvalidSetting as error:
        raise _no_cycle(f"the blocks' times do not rise: {error}") from None
    if found is None:
        raise _no_cycle("the program does no fastener")
    return found, spans


def cycle_report(program: NcProgram, found: CycleTime, spans: Spans) -> ProgramCycle:
    """The figures of one program and a row for each fastener."""
    figures = {name: round(value, 6) for name, value in asdict(NcCycle.of(found)).items()}
    return ProgramCycle(
        program_id=program.header.program_id,
        title=program.header.title,
        parts_per_hour=round(found.parts(_HOUR), 6),
        each=list(_visits(program.blocks, spans)),
        **figures,
    )


def _visits(blocks: Sequence[NcBlock], spans: Spans) -> Iterator[FastenerCycle]:
    left, arrived = spans[0][0], 0.0
    for block, (start, end) in zip(blocks, spans, strict=True):
        if block.kind == "approach":
            arrived = start
        elif block.kind == "retreat":
            times = (round(each, 6) for each in (arrived, arrived - left, end - arrived))
            at_s, way_s, work_s = times
            yield FastenerCycle(fastener_id=block.fastener_id or "", at_s=at_s, way_s=way_s, work_s=work_s)
            left = end


def _tips(program: NcProgram, machine: Machine) -> Array:
    """The die tip as the panel sees it at the end of each block, (N, 3) [m]."""
    mounting = np.array(program.datums.panel_frame_mm)
    mounting[:3, 3] /= 1e3
    chain = Kinematics.from_panel(machine, mounting)
    return chain.frames(machine.die_link, configurations(program.blocks))[1]


def _no_cycle(message: str) -> InvalidInput:
    remedy = "Name a program that installs fasteners."
    return InvalidInput([InputProblem("/blocks", "no_cycle", message, None, remedy)])
