"""Process templates: the steps that install one fastener, in order, with their durations."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum

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


@dataclass(frozen=True)
class ProcessStep:
    """One step. code: what is done. duration: [s]. source: where the duration comes from."""

    code: StepCode
    duration: float
    source: str


@dataclass(frozen=True)
class Process:
    """A process template: first step CLAMP, last step UNCLAMP, no motion in between.

    id: its name in programs and panels. title: for people. source: where the total comes from.
    """

    id: str
    title: str
    source: str
    steps: tuple[ProcessStep, ...]

    @property
    def duration(self) -> float:
        """Time of all steps together, without any motion [s]."""
        return sum(step.duration for step in self.steps)


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
