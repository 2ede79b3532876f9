"""Reading what the user named, and saying in lines what is wrong with it.

Exception
  Unusable        the input cannot be used; one line per problem
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from robots.errors import InputProblem, InvalidInput
from robots.escape_file import FamilyEscapes, read_escapes
from robots.machine import Machine
from robots.outline import Outline, read_outline
from robots.schema_problems import schema_problems
from robots.strict_json import read_document
from service.commands.folder import read_folder
from service.commands.mesh_files import with_assets
from service.inputs import Inputs, Places, gather

_Model = TypeVar("_Model", bound=BaseModel)

#: The program of the largest panel there may be, 50,000 fasteners, takes half of it.
_MOST_BYTES = 400_000_000


class Unusable(Exception):
    """The input cannot be used; `lines` says why, one problem each."""

    def __init__(self, lines: Sequence[str]) -> None:
        self.lines = tuple(" ".join(line.split()) for line in lines)
        super().__init__(self.lines)


def read_inputs(
    panel_file: Path, machine: str, dies: Sequence[str] | None, processes: Path | None = None
) -> Inputs:
    """Read a panel file, or a folder as `folder` does. Raises Unusable.

    machine: an id, or a definition file where it ends in .json. processes: a file of process templates, if
    others than those that come with rivetplan.
    """
    own_dies: list[dict[str, Any]] = []
    if panel_file.is_dir():
        with as_lines(f"{panel_file}/"):
            document, models, own_dies = read_folder(panel_file, processes)
    else:
        with as_lines(f"{panel_file}#"):
            document, models = with_assets(read_document(panel_file), panel_file.parent)
    is_file = machine.endswith(".json")
    where = Path(machine) if is_file else machine
    places = Places(f"{panel_file}#", f"{machine}#" if is_file else "--machine", "--die", f"{processes}#")
    with as_lines(""):
        return gather(document, where, dies, places, processes, models, own_dies)


def read(file: Path) -> bytes:
    """Return the bytes of a file that rivetplan wrote. Raises Unusable."""
    try:
        with file.open("rb") as opened:
            data = opened.read(_MOST_BYTES + 1)
    except OSError as error:
        raise Unusable([f"{file}: cannot be read: {error.strerror}. Name a readable file."]) from None
    if len(data) > _MOST_BYTES:
        raise Unusable(
            [f"{file}: has more than {_MOST_BYTES // 10**6} MB. Name a file that rivetplan wrote."]
        )
    return data


def read_family(file: Path, machine: Machine) -> FamilyEscapes | None:
    """Read an escape file; None where there is no such file yet. Raises Unusable."""
    if not file.exists():
        return None
    with as_lines(f"{file}#"):
        return read_escapes(read(file), machine)


def read_program_outline(file: Path) -> Outline:
    """The outline of a program file. Raises Unusable."""
    data = read(file)
    with as_lines(f"{file}#"):
        return read_outline(data)


def read_request(file: Path, model: type[_Model]) -> _Model:
    """Return the request in a file: what is posted to the service. Raises Unusable."""
    with as_lines(f"{file}#"):
        return validated(read_document(file), model)


def validated(document: dict[str, object], model: type[_Model]) -> _Model:
    """Return a document as the model that it is of. Raises InvalidInput."""
    try:
        return model.model_validate(document)
    except ValidationError as error:
        problems = [problem for _, problem in schema_problems(error.errors(), document, model)]
        raise InvalidInput(problems) from None


@contextmanager
def as_lines(place: str) -> Iterator[None]:
    """Turn InvalidInput into Unusable, a line for each problem, its pointer after `place`."""
    try:
        yield
    except InvalidInput as invalid:
        raise Unusable([_line(place, each) for each in invalid.problems]) from None


def _line(place: str, problem: InputProblem) -> str:
    value = "" if problem.value is None else f" (got {problem.value!r})"
    where = f"{place}{problem.pointer}".removesuffix("#")  # a pointer to the whole document is none
    return f"{where}: {problem.message}{value}. {problem.remedy}"
