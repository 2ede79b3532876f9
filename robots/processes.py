"""Process templates: the steps that install one fastener, in order, with durations, hand-shakes between head
and die, and parameters by fastener code and diameter.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from types import MappingProxyType

from robots.errors import UnknownName


class StepCode(StrEnum):
    """What the head does in a step; the codes of NC events."""

    CLAMP = "CLAMP"
    DRILL = "DRILL"
    PROBE = "PROBE"
    SEAL = "SEAL"
    INSERT = "INSERT"
    UPSET = "UPSET"
    SHAVE = "SHAVE"
    UNCLAMP = "UNCLAMP"


class Signal(StrEnum):
    """What one side of the machine reports to the other."""

    DIE_CONTACT = "DIE_CONTACT"  # die: its tip stands on the stack
    CLAMP_FORCE = "CLAMP_FORCE"  # head: the force is there and the stack's thickness is the expected one
    SPINDLE_CLEAR = "SPINDLE_CLEAR"  # head: the tool is out of the hole
    BUCKING_READY = "BUCKING_READY"  # die: locked, ready to take the force
    UPSET_DONE = "UPSET_DONE"  # die: the tail is formed and the force is gone


_BEFORE = MappingProxyType(
    {
        StepCode.CLAMP: Signal.DIE_CONTACT,
        StepCode.DRILL: Signal.CLAMP_FORCE,
        StepCode.UPSET: Signal.BUCKING_READY,
    }
)
"""Without these the head presses, drills or upsets against a die that is not there."""

_AFTER = MappingProxyType(
    {
        StepCode.DRILL: Signal.SPINDLE_CLEAR,
        StepCode.SHAVE: Signal.SPINDLE_CLEAR,
        StepCode.UPSET: Signal.UPSET_DONE,
    }
)
"""What the step after one of these waits for: nothing moves while a tool is in the stack or under force."""

PARAMETERS: Mapping[StepCode, Mapping[str, tuple[float, float]]] = MappingProxyType(
    {
        StepCode.CLAMP: {"clamp_force_n": (10.0, 20_000.0)},
        StepCode.DRILL: {"spindle_rpm": (10.0, 60_000.0), "feed_mm_per_rev": (0.001, 2.0)},
        StepCode.SEAL: {"seal_volume_mm3": (0.1, 10_000.0)},
        StepCode.UPSET: {"upset_force_n": (100.0, 500_000.0)},
        StepCode.SHAVE: {"shave_height_mm": (0.0, 1.0)},
    }
)
"""What has to be set for a step, each with the least and the largest value that is no slip of the unit."""


@dataclass(frozen=True)
class Handshake:
    """A step begins when the signal is there; after `timeout` [s] without it the machine stops."""

    wait_for: Signal
    timeout: float


@dataclass(frozen=True)
class ProcessStep:
    """One step. code: what is done. duration: [s], with the wait for a signal that is not late. handshake:
    what it waits for, if anything. source: where the duration comes from.
    """

    code: StepCode
    duration: float
    handshake: Handshake | None
    source: str


@dataclass(frozen=True)
class ParameterSet:
    """Settings for fasteners of some codes (of every code where there are none) up to a diameter [m].

    values: by names of `PARAMETERS`, in the units of those names: they are handed on, never computed with.
    """

    codes: tuple[str, ...]
    up_to: float
    values: Mapping[str, float]


@dataclass(frozen=True)
class Process:
    """A process template: first step CLAMP, last step UNCLAMP, no motion in between.

    id: its name in programs and panels. revision: counts its changes. title: for people. source: where the
    total comes from. parameters: none where they are the machine's own affair.
    """

    id: str
    revision: int
    title: str
    source: str
    steps: tuple[ProcessStep, ...]
    parameters: tuple[ParameterSet, ...]

    @property
    def duration(self) -> float:
        """Time of all steps together, without any motion [s]."""
        return sum(step.duration for step in self.steps)

    def parameters_for(self, code: str | None, diameter: float) -> ParameterSet | None:
        """The settings for fasteners of that code and diameter [m]: of the sets that name the code, else of
        those for every code, the one with the least diameter that is not passed. None where there is none.
        """
        of_code = [each for each in self.parameters if code is not None and code in each.codes]
        sets = of_code or [each for each in self.parameters if not each.codes]
        large = [each for each in sets if diameter <= each.up_to]
        return min(large, key=lambda each: each.up_to, default=None)


@dataclass(frozen=True, eq=False)
class ProcessLibrary:
    """The process templates of a machine; iterate over them or look one up by id.

    definition: canonical JSON of the whole library, what `sha256` is taken of.
    """

    id: str
    processes: tuple[Process, ...]
    definition: bytes = field(repr=False)

    @property
    def ids(self) -> tuple[str, ...]:
        return tuple(process.id for process in self.processes)

    @property
    def sha256(self) -> str:
        return hashlib.sha256(self.definition).hexdigest()

    def __getitem__(self, process_id: str) -> Process:
        """Return the process of that id; raise UnknownName with the ids there are."""
        for process in self.processes:
            if process.id == process_id:
                return process
        raise UnknownName("process", process_id, self.ids)

    def __iter__(self) -> Iterator[Process]:
        return iter(self.processes)

    def __len__(self) -> int:
        return len(self.processes)


def needed_signal(code: StepCode, previous: StepCode | None) -> Signal | None:
    """What a step must wait for, after the step before it; None where it may begin at once."""
    return _BEFORE.get(code) or (None if previous is None else _AFTER.get(previous))
