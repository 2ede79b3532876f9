"""Reading definition files (JSON): strict schemas, and every problem of a file reported at once.

A file is judged twice, independently: by its pydantic model (fields, types, ranges, each object by itself)
and by cross checks over the raw document (names that must exist or be unique). The cross checks look at
whatever parts are there (`select`), so a wrong number in one place does not hide a wrong name in another.
"""

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from robots.errors import InputProblem, InvalidInput, shown
from robots.strict_json import Document, pointer_to, read_document

Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,63}$")]
Text = Annotated[str, Field(max_length=500)]
SchemaVersion = Literal["1.0"]

#: A position in a machine [mm]: beyond 100 m the unit is wrong.
PositionMm = Annotated[float, Field(ge=-100_000.0, le=100_000.0)]
Vector = tuple[PositionMm, PositionMm, PositionMm]

CrossCheck = Callable[[Document], Iterable[InputProblem]]
_Model = TypeVar("_Model", bound=BaseModel)


class Strict(BaseModel):
    """Base of all file models: no conversions, no unknown fields, no NaN or infinity."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def whole(value: object) -> object:
    """Let 3.0 be the integer 3, as JSON Schema does."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def meters(mm: float) -> float:
    """[mm] -> [m]."""
    return mm / 1000.0


def read_definition(
    path: Path | bytes, model: type[_Model], cross_checks: Sequence[CrossCheck]
) -> tuple[_Model, bytes]:
    """Read a definition file (a path, or its text); return its model and its canonical JSON, of which hashes
    are taken.

    Raises InvalidInput with every problem of the file, an unreadable file included.
    """
    document = read_document(path)
    problems = [problem for check in cross_checks for problem in check(document)]
    try:
        parsed = model.model_validate_json(json.dumps(document))
    except ValidationError as error:
        found = [problem for detail in error.errors() for problem in _problems_of(detail, document)]
        raise InvalidInput(sorted(found + problems, key=_place)) from None
    if problems:
        raise InvalidInput(sorted(problems, key=_place))
    return parsed, canonical_json(parsed)


def canonical_json(model: BaseModel) -> bytes:
    """The model's content as sorted, compact JSON: the same for every layout of the same file."""
    content = model.model_dump(mode="json")
    return json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def select(document: object, pattern: str) -> list[tuple[str, Any]]:
    """Values of a raw document with their JSON pointers; `*` in the pattern stands for every index of a list.

    Parts that are missing or of another type are passed over: the schema reports them.
    """
    found: list[tuple[str, Any]] = [("", document)]
    for key in pattern.strip("/").split("/"):
        step: list[tuple[str, Any]] = []
        for pointer, value in found:
            if key == "*" and isinstance(value, list):
                step += [(f"{pointer}/{i}", item) for i, item in enumerate(value)]
            elif isinstance(value, dict) and key in value:
                step.append((f"{pointer}/{key}", value[key]))
        found = step
    return found


def select_names(document: object, pattern: str) -> list[tuple[str, str]]:
    """As `select`, only the values that are strings."""
    return [(pointer, value) for pointer, value in select(document, pattern) if isinstance(value, str)]


def duplicates(named: Sequence[tuple[str, str]], what: str) -> list[InputProblem]:
    """A problem for every name that has come before; `named` as from `select_names`."""
    return [
        InputProblem(
            pointer,
            "duplicate_name",
            f"{what} {name!r} is there more than once",
            name,
            f"Give every {what} its own name.",
        )
        for i, (pointer, name) in enumerate(named)
        if any(name == earlier for _, earlier in named[:i])
    ]


def unknown_names(named: Sequence[tuple[str, str]], known: Sequence[str], what: str) -> list[InputProblem]:
    """A problem for every name that is not among `known`."""
    return [
        InputProblem(
            pointer,
            f"unknown_{what}",
            f"there is no {what} {shown(name)!r}",
            shown(name),
            f"Use one of: {', '.join(known) or '(none)'}.",
        )
        for pointer, name in named
        if name not in known
    ]


def invalid(problems: Sequence[InputProblem]) -> PydanticCustomError:
    """What a model's validator raises to report several problems; their pointers start at that model."""
    content = [(p.pointer, p.code, p.message, p.value, p.remedy) for p in problems]
    return PydanticCustomError("problems", "several problems", {"problems": content})


def _place(problem: InputProblem) -> tuple[list[tuple[int, str]], str]:
    """Sort key: order of the pointers with list indices as numbers, then the code."""
    parts = problem.pointer.split("/")
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts], problem.code


def _problems_of(detail: ErrorDetails, document: Document) -> list[InputProblem]:
    """Translate one pydantic error."""
    context = detail.get("ctx", {})
    pointer = _pointer(detail, document)
    if detail["type"] == "problems":
        return [
            InputProblem(pointer + inner, code, message, value, remedy)
            for inner, code, message, value, remedy in context["problems"]
        ]
    code, remedy = _CODES.get(detail["type"], ("invalid_value", "Correct the value."))
    value = None if detail["type"] == "missing" else shown(detail["input"])
    return [InputProblem(pointer, code, detail["msg"][0].lower() + detail["msg"][1:], value, remedy)]


def _pointer(detail: ErrorDetails, document: Document) -> str:
    """JSON pointer of an error: pydantic's location without the tags of unions (not in the document)."""
    pointer = ""
    here: Any = document
    for place, part in enumerate(detail["loc"]):
        last = place == len(detail["loc"]) - 1
        if (isinstance(here, dict) and part in here) or (isinstance(here, list) and isinstance(part, int)):
            here = _child(here, part)
        elif not (last and detail["type"] == "missing"):
            continue
        pointer += pointer_to(part)
    return pointer


def _child(container: Any, key: int | str) -> Any:
    """The member, or None for the missing items of a list that is too short."""
    if isinstance(container, list):
        return container[int(key)] if int(key) < len(container) else None
    return container[key]


_TYPE = ("wrong_type", "Give a value of the stated type; numbers are not quoted.")
_RANGE = (
    "out_of_range",
    "Check the value and the unit in the field's name; it may be off by a factor of 1000.",
)
_LENGTH = ("wrong_length", "Give the stated number of items.")
_CHOICE = ("unknown_value", "Use one of the values the message lists.")

#: pydantic's error type -> our code and remedy.
_CODES = {
    "missing": ("missing_field", "Add the field."),
    "extra_forbidden": ("unknown_field", "Remove the field or correct its spelling."),
    "finite_number": ("not_finite", "Give a finite number."),
    "string_pattern_mismatch": (
        "bad_name",
        "Use a letter first, then letters, digits and underscores, up to 64.",
    ),
    "string_too_long": ("too_long", "Shorten the text."),
    "union_tag_invalid": _CHOICE,
    "union_tag_not_found": ("missing_field", "Add the field that states the kind."),
    "literal_error": _CHOICE,
    "enum": _CHOICE,
    **dict.fromkeys(["greater_than", "greater_than_equal", "less_than", "less_than_equal"], _RANGE),
    **dict.fromkeys(["too_short", "too_long"], _LENGTH),
    **dict.fromkeys(
        [
            "float_type",
            "string_type",
            "bool_type",
            "list_type",
            "tuple_type",
            "dict_type",
            "model_type",
            "model_attributes_type",
            "int_type",
        ],
        _TYPE,
    ),
}
