"""What pydantic finds wrong in a request, in the service's words."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from robots.errors import InputProblem
from service.strict_json import pointer

#: pydantic's kind of error -> what to do about it.
_REMEDIES: Mapping[str, str] = {
    "missing": "Add it.",
    "extra_forbidden": "Remove it or correct its name.",
}
#: The same for messages, where pydantic's own words speak of Python.
_MESSAGES: Mapping[str, str] = dict.fromkeys(
    ["model_type", "model_attributes_type", "dict_type"], "Input should be an object"
) | {"list_type": "Input should be an array"}
_REMEDY = "Send a value as /openapi.json describes it."


def field_problems(errors: Sequence[Any], body: object) -> Iterator[InputProblem]:
    """Yield what pydantic found in a request. body: the parsed body, whose errors are placed at "body"."""
    for error in errors:
        place, *path = error["loc"]
        kind = error["type"]
        at = _pointer(path, body, missing=kind == "missing") if place == "body" else str(path[0])
        value = None if kind == "missing" else error["input"]
        yield InputProblem(at, kind, _MESSAGES.get(kind, error["msg"]), value, _REMEDIES.get(kind, _REMEDY))


def _pointer(path: Sequence[str | int], body: object, *, missing: bool) -> str:
    """Return the JSON pointer of a pydantic location, leaving out the names of union members in it.

    missing: the last step is not in the body.
    """
    at = ""
    for place, step in enumerate(path):
        is_member = isinstance(body, dict) and step in body
        is_item = isinstance(body, list) and isinstance(step, int) and step < len(body)
        if is_member or is_item:
            body = body[step]  # type: ignore[index]
            at = pointer(at, str(step))
        elif missing and place == len(path) - 1:
            at = pointer(at, str(step))
    return at
