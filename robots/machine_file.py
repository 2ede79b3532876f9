"""Machine definitions from JSON: `machine_ids`, `load_machine`.

The file's models state fields, units and ranges; what needs the whole document is in `robots.machine_checks`.
"""

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from planners.arrays import Array
from robots.axis_file import PrismaticFile, RevoluteFile
from robots.definition_file import Name, SchemaVersion, Strict, Text, Vector, invalid, meters, read_definition
from robots.dies import DieLibrary
from robots.errors import InputProblem, InvalidInput, UnknownName
from robots.machine import CLAMPED_FOOT, FOOT, ChainJoint, ClearancePolicy, Machine
from robots.machine_checks import CROSS_CHECKS, machine_problems
from robots.process_file import load_process, load_processes
from robots.processes import ProcessLibrary
from robots.shape_file import ShapeFile, SolidFile, build_solid
from robots.tooling_file import DATA, load_dies

__all__ = ["load_dies", "load_machine", "load_process", "load_processes", "machine_ids"]

#: Machines that come with rivetplan: id -> file.
_MACHINES = {"riveter": DATA / "riveter.json"}

ClearanceMm = Annotated[float, Field(ge=0.01, le=50.0)]


class JointFile(Strict):
    """A joint of a chain: its axis and its origin in the parent frame."""

    axis: Name
    offset_mm: Vector

    def build(self) -> ChainJoint:
        """The joint in [m]."""
        return ChainJoint(self.axis, np.array(self.offset_mm) / 1000.0)


class FootFile(Strict):
    """The pressure foot in its two states."""

    link: Name
    open: ShapeFile
    clamped: ShapeFile


class PairFile(Strict):
    """A clearance for two solids, or a solid and the panel."""

    solids: tuple[Name, Name]
    clearance_mm: ClearanceMm


class ClearanceFile(Strict):
    """The clearance policy."""

    default_mm: ClearanceMm
    near_fastener_mm: ClearanceMm
    near_radius_mm: Annotated[float, Field(ge=1.0, le=1000.0)]
    contact_depth_mm: Annotated[float, Field(ge=0.0, le=1.0)]
    sag_mm: Annotated[float, Field(ge=0.0, le=20.0)]
    pairs: Annotated[list[PairFile], Field(max_length=1000)]

    @model_validator(mode="after")
    def _check(self) -> "ClearanceFile":
        if self.near_fastener_mm > self.default_mm:
            raise invalid(
                [
                    InputProblem(
                        "/near_fastener_mm",
                        "clearances_swapped",
                        f"near a fastener more is asked than elsewhere ({self.default_mm} mm)",
                        self.near_fastener_mm,
                        "Give at most default_mm.",
                    )
                ]
            )
        return self

    def build(self) -> ClearancePolicy:
        """The policy in [m]."""
        return ClearancePolicy(
            default=meters(self.default_mm),
            near_fastener=meters(self.near_fastener_mm),
            near_radius=meters(self.near_radius_mm),
            contact_depth=meters(self.contact_depth_mm),
            sag=meters(self.sag_mm),
            pairs={pair.solids: meters(pair.clearance_mm) for pair in self.pairs},
        )


class ProcessDataFile(Strict):
    """What all processes of the machine share."""

    retract_margin_mm: Annotated[float, Field(ge=0.1, le=100.0)]
    tail_height_factor: Annotated[float, Field(ge=0.0, le=3.0)]
    die_change_duration_s: Annotated[float, Field(ge=0.0, le=3600.0)]


class MachineFile(Strict):
    """A machine definition file."""

    schema_version: SchemaVersion
    id: Name
    title: Text
    source: Text
    kinematics: Literal["riveter", "chain"]
    axes: Annotated[
        list[Annotated[PrismaticFile | RevoluteFile, Field(discriminator="kind")]],
        Field(min_length=1, max_length=32),
    ]
    gantry_base_mm: Vector
    panel_chain: Annotated[list[JointFile], Field(max_length=32)]
    tool_chain: Annotated[list[JointFile], Field(min_length=1, max_length=32)]
    solids: Annotated[list[SolidFile], Field(max_length=256)]
    foot: FootFile
    self_pairs: Annotated[list[tuple[Name, Name]], Field(max_length=10_000)]
    clearance: ClearanceFile
    process: ProcessDataFile


def machine_ids() -> tuple[str, ...]:
    """Ids of the machines that come with rivetplan."""
    return tuple(_MACHINES)


def load_machine(
    id_or_path: str | Path, dies: DieLibrary | None = None, processes: ProcessLibrary | None = None
) -> Machine:
    """Read a machine: a `str` is the id of one that comes with rivetplan, a `Path` is a definition file.

    The two are kept apart by type so that a name from a request never opens a file. dies, processes: the
    libraries it works with, by default those that come with rivetplan.
    Raises UnknownName for an id that is not there, InvalidInput with every problem of the file.
    """
    path = _path(id_or_path)
    file, definition = read_definition(path, MachineFile, CROSS_CHECKS)
    machine = Machine(
        id=file.id,
        title=file.title,
        kinematics=file.kinematics,
        axes=tuple(axis.build() for axis in file.axes),
        panel_chain=tuple(joint.build() for joint in file.panel_chain),
        tool_chain=tuple(joint.build() for joint in file.tool_chain),
        T_world_gantry=_translation(file.gantry_base_mm),
        solids=tuple(build_solid(solid.name, solid.link, solid.shape) for solid in file.solids),
        foot={
            "open": build_solid(FOOT, file.foot.link, file.foot.open),
            "clamped": build_solid(CLAMPED_FOOT, file.foot.link, file.foot.clamped),
        },
        self_pairs=tuple(file.self_pairs),
        policy=file.clearance.build(),
        retract_margin=meters(file.process.retract_margin_mm),
        tail_height_factor=file.process.tail_height_factor,
        die_change_duration=file.process.die_change_duration_s,
        dies=load_dies() if dies is None else dies,
        processes=load_processes() if processes is None else processes,
        definition=definition,
    )
    problems = machine_problems(machine)
    if problems:
        raise InvalidInput(problems)
    return machine


def _path(id_or_path: str | Path) -> Path:
    if isinstance(id_or_path, Path):
        return id_or_path
    if id_or_path not in _MACHINES:
        raise UnknownName("machine", id_or_path, machine_ids())
    return _MACHINES[id_or_path]


def _translation(mm: tuple[float, float, float]) -> Array:
    T: Array = np.eye(4)
    T[:3, 3] = np.array(mm) / 1000.0
    return T
