"""Process libraries from JSON: `load_processes`, `load_process`."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated

from pydantic import BeforeValidator, Field, model_validator

from robots.definition_file import (
    Name,
    SchemaVersion,
    Strict,
    Text,
    duplicates,
    invalid,
    meters,
    read_definition,
    select_names,
    whole,
)
from robots.errors import InputProblem
from robots.processes import (
    PARAMETERS,
    Handshake,
    ParameterSet,
    Process,
    ProcessLibrary,
    ProcessStep,
    Signal,
    StepCode,
    needed_signal,
)
from robots.strict_json import Document, pointer_to

DATA = Path(__file__).parent / "data"


class HandshakeFile(Strict):
    """The signal a step waits for; timeouts beyond a minute are in the wrong unit."""

    wait_for: Signal
    timeout_s: Annotated[float, Field(gt=0.0, le=60.0)]


class ProcessStepFile(Strict):
    """One step; durations beyond two minutes are in the wrong unit."""

    code: StepCode
    duration_s: Annotated[float, Field(gt=0.0, le=120.0)]
    handshake: HandshakeFile | None
    source: Text


class ParameterSetFile(Strict):
    """Settings for fasteners of some codes up to a diameter."""

    codes: Annotated[list[Name], Field(max_length=1000)]
    up_to_mm: Annotated[float, Field(ge=1.0, le=20.0)]
    values: dict[str, float]
    source: Text


class ProcessFile(Strict):
    """One process template."""

    id: Name
    revision: Annotated[int, Field(ge=1, le=1_000_000), BeforeValidator(whole)]
    title: Text
    source: Text
    steps: Annotated[list[ProcessStepFile], Field(min_length=2, max_length=64)]
    parameters: Annotated[list[ParameterSetFile], Field(max_length=1000)]

    @model_validator(mode="after")
    def _check(self) -> "ProcessFile":
        problems = list(_clamping(self.steps)) or [*_handshakes(self.steps), *_parameters(self)]
        if problems:
            raise invalid(problems)
        return self

    def build(self) -> Process:
        """The template in SI units."""
        return Process(
            id=self.id,
            revision=self.revision,
            title=self.title,
            source=self.source,
            steps=tuple(_step(step) for step in self.steps),
            parameters=tuple(
                ParameterSet(tuple(each.codes), meters(each.up_to_mm), dict(each.values))
                for each in self.parameters
            ),
        )


class ProcessLibraryFile(Strict):
    """All process templates of a shop."""

    schema_version: SchemaVersion
    id: Name
    title: Text
    source: Text
    processes: Annotated[list[ProcessFile], Field(min_length=1, max_length=1000)]


def load_processes(path: Path = DATA / "processes.json") -> ProcessLibrary:
    """Read a library of process templates; raise InvalidInput with every problem of the file."""
    file, definition = read_definition(path, ProcessLibraryFile, [_process_names])
    return ProcessLibrary(file.id, tuple(process.build() for process in file.processes), definition)


def load_process(process_id: str) -> Process:
    """The process template of that id from the default library; raise UnknownName with the ids there are."""
    return load_processes()[process_id]


def _step(step: ProcessStepFile) -> ProcessStep:
    given = step.handshake
    handshake = None if given is None else Handshake(given.wait_for, given.timeout_s)
    return ProcessStep(step.code, step.duration_s, handshake, step.source)


def _process_names(document: Document) -> Iterable[InputProblem]:
    return duplicates(select_names(document, "/processes/*/id"), "process")


def _clamping(steps: list[ProcessStepFile]) -> Iterator[InputProblem]:
    expected = {0: StepCode.CLAMP, len(steps) - 1: StepCode.UNCLAMP}
    for i, step in enumerate(steps):
        is_inside = i not in expected and step.code in (StepCode.CLAMP, StepCode.UNCLAMP)
        if step.code != expected.get(i, step.code) or is_inside:
            yield InputProblem(
                f"/steps/{i}/code",
                "clamp_not_paired",
                f"step {i} is {step.code} where {expected.get(i, 'a step between them')} must be",
                step.code,
                "Begin with CLAMP and end with UNCLAMP, each once.",
            )


def _handshakes(steps: list[ProcessStepFile]) -> Iterator[InputProblem]:
    for i, step in enumerate(steps):
        needed = needed_signal(step.code, steps[i - 1].code if i else None)
        if needed is None:
            continue
        remedy = f"Let it wait for {needed}."
        if step.handshake is None:
            message = f"step {i}, {step.code}, must not begin without {needed}"
            yield InputProblem(f"/steps/{i}/handshake", "handshake_missing", message, None, remedy)
        elif step.handshake.wait_for != needed:
            found = step.handshake.wait_for
            message = f"step {i}, {step.code}, must not begin without {needed}"
            yield InputProblem(f"/steps/{i}/handshake/wait_for", "handshake_swapped", message, found, remedy)


def _parameters(process: ProcessFile) -> Iterator[InputProblem]:
    """Each set has what its process has to have set, and no two sets are for the same fasteners."""
    ranges: dict[str, tuple[float, float]] = {}
    for step in process.steps:
        ranges |= PARAMETERS.get(step.code, {})
    seen: set[tuple[str, float]] = set()
    for i, each in enumerate(process.parameters):
        at = f"/parameters/{i}"
        for code in each.codes or [""]:
            if (code, each.up_to_mm) in seen:
                message = f"there is another set for {code or 'every code'} up to {each.up_to_mm} mm"
                yield InputProblem(at, "duplicate_parameters", message, code, "Keep one of them.")
            seen.add((code, each.up_to_mm))
        for name in sorted(ranges.keys() - each.values.keys()):
            message = f"the steps of the process need {name}"
            yield InputProblem(f"{at}/values{pointer_to(name)}", "missing_field", message, None, "Add it.")
        for name, value in each.values.items():
            yield from _value(f"{at}/values{pointer_to(name)}", name, value, ranges)


def _value(
    at: str, name: str, value: float, ranges: dict[str, tuple[float, float]]
) -> Iterator[InputProblem]:
    if name not in ranges:
        message = f"no step of the process has {name}"
        remedy = f"Remove it or use one of: {', '.join(sorted(ranges))}."
        yield InputProblem(at, "unknown_field", message, value, remedy)
    elif not ranges[name][0] <= value <= ranges[name][1]:
        low, high = ranges[name]
        message = f"{name} goes from {low:g} to {high:g}"
        yield InputProblem(at, "out_of_range", message, value, "Check the value and the unit in its name.")
