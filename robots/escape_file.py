"""Escape files: what earlier runs found out about a panel family, as JSON in millimetres and degrees.

An escape is a proposal: whoever reuses one has it certified in the new place. So a file decides which ways
are tried first, never what is free. It belongs to one kinematics: displacements of other axes mean nothing.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from planners.arrays import Array
from planners.escapes import Escape, merged
from robots.errors import InputProblem, InvalidInput
from robots.machine import Machine
from robots.nc import Mm, NcAxes, NcUnits
from robots.nc_codec import decode, encode
from robots.riveter_search import planner_settings
from robots.strict_json import pointer_to
from robots.surroundings import FARTHEST, WAYS, joined, parted

_MM = 1e3
_ROUNDING = 1e-6
"""[m] or [rad] More than the digits of the file can add to a displacement."""


@dataclass(frozen=True, slots=True)
class FileMachine:
    """The machine whose axes the escapes are displacements of."""

    id: str
    kinematics_sha256: str


@dataclass(frozen=True, slots=True)
class FileSurroundings:
    """What stands around the die at one end, see `surroundings`: free ways, and where the die reaches to."""

    free_mm: tuple[Mm, ...]
    die_mm: tuple[Mm, Mm]


@dataclass(frozen=True, slots=True)
class FileEscape:
    """One escape: the fastener it was found at, its two ends, and its waypoints less the first one."""

    name: str
    start: FileSurroundings
    goal: FileSurroundings
    offsets: tuple[NcAxes, ...]


@dataclass(frozen=True, slots=True)
class FileDie:
    """The escapes of one die, oldest first."""

    die_id: str
    escapes: tuple[FileEscape, ...]


@dataclass(frozen=True, slots=True)
class EscapeFile:
    """The whole file."""

    id: str
    machine: FileMachine
    dies: tuple[FileDie, ...]
    units: NcUnits
    schema_version: Literal["1.0"] = "1.0"


@dataclass(frozen=True, eq=False)
class FamilyEscapes:
    """Escapes of one panel family on one machine.

    id: of the panel they began with. of_die: for each die, oldest first, exactly as the file holds them.
    """

    id: str
    machine: Machine
    of_die: Mapping[str, tuple[Escape, ...]]

    @cached_property
    def text(self) -> bytes:
        """The canonical file: one line of ASCII JSON with a newline at the end."""
        machine = FileMachine(self.machine.id, kinematics_sha256(self.machine))
        dies = [
            FileDie(die, tuple(_written(escape) for escape in self.of_die[die]))
            for die in sorted(self.of_die)
            if self.of_die[die]
        ]
        return f"{encode(EscapeFile(self.id, machine, tuple(dies), NcUnits()))}\n".encode("ascii")

    @property
    def sha256(self) -> str:
        """Identity of the content, however a file lays it out."""
        return hashlib.sha256(self.text).hexdigest()

    def with_found(self, found: Mapping[str, Sequence[Escape]]) -> FamilyEscapes:
        """Those known and, for each die in the order given, those `found`; see `planners.escapes.merged`."""
        settings = planner_settings(self.machine)
        of_die = dict(self.of_die)
        for die_id, escapes in found.items():
            as_written = [_read(_written(escape)) for escape in escapes]
            known = of_die.get(die_id, ())
            of_die[die_id] = merged(
                known, as_written, settings.weights, settings.limits, settings.escapes_kept
            )
        return replace(self, of_die=of_die)


def read_escapes(text: bytes, machine: Machine) -> FamilyEscapes:
    """What an escape file says; raises InvalidInput with every problem, so where it is another machine's."""
    file: EscapeFile = decode(EscapeFile, text)
    problems = [*_other_machine(file, machine), *_wrong_dies(file, machine)]
    for i, die in enumerate(file.dies):
        for j, escape in enumerate(die.escapes):
            problems += _wrong_escape(pointer_to("dies", i, "escapes", j), escape, machine)
    if problems:
        raise InvalidInput(problems)
    return FamilyEscapes(
        file.id, machine, {die.die_id: tuple(_read(escape) for escape in die.escapes) for die in file.dies}
    )


def kinematics_sha256(machine: Machine) -> str:
    """Digest of what displacements of the axes mean: the axes' names, kinds, directions, and the chains."""
    axes = [[axis.name, axis.kind, axis.direction.tolist()] for axis in machine.axes]
    chains = [
        [[joint.axis, joint.offset.tolist()] for joint in chain]
        for chain in (machine.panel_chain, machine.tool_chain)
    ]
    content = json.dumps([axes, chains, machine.T_world_gantry.tolist()])
    return hashlib.sha256(content.encode("ascii")).hexdigest()


def _written(escape: Escape) -> FileEscape:
    start, goal = (_surroundings(end) for end in escape.where)
    return FileEscape(escape.name, start, goal, tuple(NcAxes.of(offset) for offset in escape.offsets))


def _surroundings(end: Array) -> FileSurroundings:
    free, die = parted(end)
    x, y = (_MM * die).tolist()
    return FileSurroundings(tuple((_MM * free).tolist()), (x, y))


def _read(escape: FileEscape) -> Escape:
    ends = [
        joined(np.array(end.free_mm) / _MM, np.array(end.die_mm) / _MM) for end in (escape.start, escape.goal)
    ]
    return Escape(escape.name, np.array(ends), np.array([offset.q for offset in escape.offsets]))


def _other_machine(file: EscapeFile, machine: Machine) -> Iterator[InputProblem]:
    stated, remedy = file.machine, "Name this machine's file, or a new file to begin one."
    if stated.id != machine.id:
        message = f"these are escapes of machine {stated.id}, the program is for machine {machine.id}"
        yield InputProblem("/machine/id", "other_machine", message, stated.id, remedy)
    elif stated.kinematics_sha256 != kinematics_sha256(machine):
        message = f"these are escapes of a machine {machine.id} with other axes"
        found = stated.kinematics_sha256
        yield InputProblem("/machine/kinematics_sha256", "other_kinematics", message, found, remedy)


def _wrong_dies(file: EscapeFile, machine: Machine) -> Iterator[InputProblem]:
    kept = planner_settings(machine).escapes_kept
    for i, die in enumerate(file.dies):
        at = pointer_to("dies", i)
        if die.die_id not in machine.dies.ids:
            remedy = f"Remove it, or use one of: {', '.join(machine.dies.ids)}."
            message = "the machine has no die of this name"
            yield InputProblem(f"{at}/die_id", "unknown_die", message, die.die_id, remedy)
        if any(die.die_id == other.die_id for other in file.dies[:i]):
            message = "this die has come before"
            yield InputProblem(f"{at}/die_id", "duplicate_die", message, die.die_id, "Keep one of them.")
        if len(die.escapes) > kept:
            message, remedy = f"more than {kept} escapes are kept for no die", "Remove the first ones."
            yield InputProblem(f"{at}/escapes", "too_many", message, len(die.escapes), remedy)


def _wrong_escape(at: str, escape: FileEscape, machine: Machine) -> Iterator[InputProblem]:
    for name, end in (("start", escape.start), ("goal", escape.goal)):
        count = len(end.free_mm)
        if count != WAYS:
            message, remedy = f"there must be {WAYS} free ways", f"Give {WAYS} lengths."
            yield InputProblem(f"{at}/{name}/free_mm", "wrong_length", message, count, remedy)
        for k, way in enumerate(end.free_mm):
            if not 0.0 <= way <= _MM * FARTHEST:
                message = f"a free way is from 0 to {_MM * FARTHEST:g} mm"
                remedy = "Correct the value; it is in millimetres."
                yield InputProblem(f"{at}/{name}/free_mm/{k}", "out_of_range", message, way, remedy)
    if len(escape.offsets) < 2 or escape.offsets[0].q.any():
        message = "an escape begins with a waypoint of zeros and has another one"
        remedy = "Give the waypoints less the first one."
        yield InputProblem(f"{at}/offsets", "bad_path", message, len(escape.offsets), remedy)
    travel = machine.upper - machine.lower + _ROUNDING
    for k, offset in enumerate(escape.offsets):
        beyond = np.flatnonzero(np.abs(offset.q) > travel)
        for axis in beyond.tolist():
            name = machine.axis_names[axis]
            message = f"axis {name} does not travel so far"
            value = round(float(offset.q[axis]), 6)
            remedy = "Check the unit in the field's name."
            yield InputProblem(f"{at}/offsets/{k}", "out_of_range", message, value, remedy)
