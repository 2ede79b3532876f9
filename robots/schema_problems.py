"""What a pydantic model has against a document, as input problems with a way out.

Beyond pydantic's own words: a size outside its range that would fit a thousand times larger or smaller is
told so, and an unknown field is told the name it was probably meant to be.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from robots.errors import InputProblem, shown
from robots.strict_json import Document, pointer_to

Keys = tuple[str | int, ...]


def schema_problems(
    errors: Iterable[ErrorDetails], document: Document, model: type[BaseModel]
) -> list[tuple[Keys, InputProblem]]:
    """Problems with the place of each; one per place and code (unions report once per member)."""
    found: dict[tuple[Keys, str], InputProblem] = {}
    for error in errors:
        keys = _place(error, document)
        code, remedy = _CODES.get(error["type"], ("invalid_value", "Correct the value."))
        value = (
            None
            if error["type"] == "missing"
            else "null"
            if error["input"] is None
            else shown(error["input"])
        )
        message = _MESSAGES.get(error["type"]) or error["msg"][0].lower() + error["msg"][1:]
        if code == "unknown_field":
            remedy = _spelling(keys, model) or remedy
        if code == "out_of_range":
            remedy = _unit(error, keys, model) or remedy
        known = found.get((keys, code))
        if known is not None and known.message != message:
            message = f"{known.message}, or {message}"
        found[keys, code] = InputProblem(pointer_to(*keys), code, message, value, remedy)
    return [(keys, p) for (keys, _), p in _without_echoes(found).items()]


def unit_hint(value: float, lower: float, upper: float) -> str:
    """The remedy for a length in the wrong unit; "" when no unit brings it into its range [mm]."""
    for factor, unit in ((1000.0, "metres"), (0.001, "micrometres"), (25.4, "inches")):
        if value > 0.0 and lower <= value * factor <= upper:
            return f"It looks like {unit}: the field is in millimetres, {value * factor:g} would fit."
    return ""


def _without_echoes(found: dict[tuple[Keys, str], InputProblem]) -> dict[tuple[Keys, str], InputProblem]:
    """A union of number and word reports both: "not that word" is no news about a number out of range."""
    kept: dict[tuple[Keys, str], InputProblem] = {}
    for (keys, code), problem in found.items():
        if code == "unknown_value" and ((keys, "out_of_range") in found or (keys, "not_finite") in found):
            continue
        if code == "unknown_value" and (keys, "wrong_type") in found:
            number = kept[keys, "wrong_type"]
            kept[keys, "wrong_type"] = replace(number, message=f"{number.message}, or {problem.message}")
            continue
        kept[keys, code] = problem
    return kept


def _place(error: ErrorDetails, document: Document) -> Keys:
    """The error's location without what is not in the document: tags of unions, the mark of a key."""
    keys: Keys = ()
    here: object = document
    for part in error["loc"]:
        if isinstance(here, dict) and part in here:
            here = here[part]
        elif isinstance(here, list) and isinstance(part, int):
            here = here[part] if part < len(here) else None
        elif error["type"] == "missing" and part == error["loc"][-1]:
            return (*keys, part)
        else:
            continue
        keys = (*keys, part)
    return keys


def _field(keys: Keys, model: type[BaseModel]) -> tuple[type[BaseModel], FieldInfo | None]:
    """The innermost model on the way to `keys` and its field there (None: it has none)."""
    field: FieldInfo | None = None
    for key in keys:
        if isinstance(key, int):
            continue
        inner = None if field is None else _model_in(field.annotation)
        if field is not None and inner is not None:
            if field.annotation is not None and getattr(field.annotation, "__origin__", None) is dict:
                field = FieldInfo(annotation=inner)  # the key is a name chosen by the author
                continue
            model = inner
        field = model.model_fields.get(str(key))
        if field is None:
            return model, None
    return model, field


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """The model inside list[...], dict[str, ...], ... | None."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((m for m in map(_model_in, get_args(annotation)) if m is not None), None)


def _spelling(keys: Keys, model: type[BaseModel]) -> str:
    owner, _ = _field(keys, model)
    unknown, names = str(keys[-1]), list(owner.model_fields)
    close = [name for name in names if name.startswith(unknown + "_")] + difflib.get_close_matches(
        unknown, names, 1
    )
    return f"Did you mean {close[0]!r}? Otherwise remove the field." if close else ""


def _unit(error: ErrorDetails, keys: Keys, model: type[BaseModel]) -> str:
    """A hint where the field is in millimetres; its range is that of all constraints around the value."""
    name = next((key for key in reversed(keys) if isinstance(key, str)), "")
    _, field = _field(keys, model)
    if field is None or not name.endswith("_mm") or not isinstance(error["input"], int | float):
        return ""
    bounds = list(_bounds(field.annotation)) + list(_bounds_of(field.metadata))
    lower = max((b for kind, b in bounds if kind in ("ge", "gt")), default=0.0)
    upper = min((b for kind, b in bounds if kind in ("le", "lt")), default=0.0)
    return unit_hint(float(error["input"]), lower, upper)


def _bounds(annotation: Any) -> Iterable[tuple[str, float]]:
    yield from _bounds_of(getattr(annotation, "__metadata__", ()))
    for inner in get_args(annotation):
        yield from _bounds(inner)


def _bounds_of(metadata: Iterable[Any]) -> Iterable[tuple[str, float]]:
    for item in metadata:
        for constraint in [item, *getattr(item, "metadata", [])]:
            for kind in ("ge", "gt", "le", "lt"):
                bound = getattr(constraint, kind, None)
                if bound is not None:
                    yield kind, float(bound)


#: Where pydantic's own words speak of Python.
_MESSAGES = {
    "dict_type": "input should be an object",
    "model_type": "input should be an object",
    "list_type": "input should be a list",
}

_TYPE = ("wrong_type", "Give a value of the stated type; numbers are not quoted.")
_RANGE = ("out_of_range", "Check the value and the unit in the field's name.")
_LENGTH = ("wrong_length", "Give the stated number of items.")
_NAME = ("bad_name", "Begin with a letter or digit, go on with letters, digits, '_', '-' and '.', up to 64.")

#: pydantic's error type -> our code and remedy.
_CODES: dict[str, tuple[str, str]] = {
    "missing": ("missing_field", "Add the field."),
    "extra_forbidden": ("unknown_field", "Remove the field or correct its spelling."),
    "finite_number": ("not_finite", "Give a finite number."),
    "literal_error": ("unknown_value", "Use one of the values the message lists."),
    "string_pattern_mismatch": _NAME,
    "string_too_short": _NAME,
    "string_too_long": ("too_long", "Shorten the text."),
    "control_character": ("bad_text", "Write plain text in one line."),
    **dict.fromkeys(["greater_than", "greater_than_equal", "less_than", "less_than_equal"], _RANGE),
    **dict.fromkeys(["too_short", "too_long"], _LENGTH),
    **dict.fromkeys(
        ["float_type", "int_type", "string_type", "bool_type", "list_type", "dict_type", "model_type"], _TYPE
    ),
}
