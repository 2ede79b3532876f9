"""From a parsed panel document and names to a panel, a machine and dies: every problem at once."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from robots.die_import.libraries import with_dies
from robots.dies import Die
from robots.errors import InputProblem, InvalidInput, UnknownName
from robots.machine import Machine
from robots.machine_file import load_machine, machine_ids
from robots.panel import Panel
from robots.panel_file import load_panel
from robots.panel_meshes import Models, no_models
from robots.process_file import load_processes
from robots.processes import ProcessLibrary
from service.process_inputs import unset_fasteners
from service.strict_json import pointer

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Inputs:
    """What programming a panel starts from. document: what the panel was loaded from."""

    panel: Panel
    machine: Machine
    dies: tuple[Die, ...]
    document: Mapping[str, Any]


@dataclass(frozen=True)
class Places:
    """Where each input came from, put before the pointers of its problems.

    Members of the body of a request; at the command line the file and the names of the options.
    """

    panel: str = "/panel"
    machine: str = "/machine"
    dies: str = "/dies"
    processes: str = "/processes"


def gather(
    panel: Mapping[str, Any],
    machine: str | Path,
    dies: Sequence[str] | None,
    places: Places,
    processes: Path | None = None,
    models: Models = no_models,
    own_dies: Sequence[dict[str, Any]] = (),
) -> Inputs:
    """Load the inputs.

    panel: the parsed panel document. machine: an id, or the path of a definition file; a client's text is
    always an id. dies: ids, or None for every die of the machine's library. processes: a file of process
    templates, or None for those that come with rivetplan. models: the files that the panel's meshes refer
    to. own_dies: entries of a die library, beside those the machine comes with.
    Raises InvalidInput with the problems of all of them, each pointer starting at its place.
    """
    problems: list[InputProblem] = []
    library = _collected(problems, places.processes, lambda: load_processes(processes)) if processes else None
    the_machine = _collected(problems, places.machine, lambda: _machine(machine, library, own_dies))
    known = None if the_machine is None or problems else the_machine.processes.ids
    the_panel = _collected(problems, places.panel, lambda: load_panel(panel, known, models))
    the_dies: tuple[Die, ...] = ()
    if the_machine is not None:
        the_dies = _dies(problems, the_machine, dies, places.dies)
        problems += _unknown_dies(the_machine.dies.ids, panel, places.panel)
    if the_machine is not None and the_panel is not None and not problems:
        unset = unset_fasteners(the_panel, the_machine, panel)
        problems += [replace(each, pointer=places.panel + each.pointer) for each in unset]
    if problems or the_panel is None or the_machine is None:
        raise InvalidInput(problems)
    return Inputs(the_panel, the_machine, the_dies, panel)


@contextmanager
def placed(place: str) -> Iterator[None]:
    """Put `place` before the pointers of problems raised inside."""
    try:
        yield
    except InvalidInput as invalid:
        raise InvalidInput(_under(place, invalid)) from None


def _under(place: str, invalid: InvalidInput) -> list[InputProblem]:
    return [replace(each, pointer=place + each.pointer) for each in invalid.problems]


def _collected(problems: list[InputProblem], place: str, load: Callable[[], T]) -> T | None:
    """Return what `load` returns, or None with its problems added under `place`."""
    try:
        return load()
    except InvalidInput as invalid:
        problems += _under(place, invalid)
        return None


def _machine(
    machine: str | Path, processes: ProcessLibrary | None, own_dies: Sequence[dict[str, Any]]
) -> Machine:
    if isinstance(machine, str) and machine not in machine_ids():
        raise UnknownName("machine", machine, machine_ids())
    if own_dies:
        return with_dies(machine, own_dies, processes=processes)
    return load_machine(machine, processes=processes)


def _dies(
    problems: list[InputProblem], machine: Machine, names: Sequence[str] | None, place: str
) -> tuple[Die, ...]:
    if names is None:
        return tuple(machine.dies)
    found = []
    for index, name in enumerate(names):
        at = f"{place}/{index}" if len(names) > 1 else place
        if name in names[:index]:
            message, remedy = "a die is named twice", "Name each die once."
            problems.append(InputProblem(at, "duplicate_die", message, name, remedy))
        elif name in machine.dies.ids:
            found.append(machine.dies[name])
        else:
            problems += _under(at, UnknownName("die", name, machine.dies.ids))
    return tuple(found)


def _unknown_dies(known: Collection[str], value: Any, at: str) -> Iterator[InputProblem]:
    """Yield a problem for every `die` member within the document whose name is not known to the machine."""
    if isinstance(value, dict):
        name = value.get("die")
        if isinstance(name, str) and name not in known:
            remedy = f"Use one of: {', '.join(known)}."
            yield InputProblem(
                f"{at}/die", "unknown_die", "the machine has no die of this name", name, remedy
            )
        for member, item in value.items():
            yield from _unknown_dies(known, item, pointer(at, member))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _unknown_dies(known, item, f"{at}/{index}")
