"""Reading a big request in a process of its own: parsed, checked, and folded."""

import json
from typing import Any

from pydantic import ValidationError

from robots.errors import InvalidInput
from service.canonical import canonical_json
from service.field_problems import field_problems
from service.schema_base import Strict
from service.settings import Settings
from service.strict_json import JsonLimits, parse

_SMALL = 4096
"""[byte] Members of a request that are shorter as JSON stay with it."""


def read(model: type[Strict], text: bytes, limits: JsonLimits, _settings: Settings) -> Strict:
    """Return a request, folded. Raises InvalidInput as for one that is read where it arrives."""
    document = parse(text, limits)
    try:
        request = model.model_validate(document)
    except ValidationError as error:
        found = [{**each, "loc": ("body", *each["loc"])} for each in error.errors()]
        raise InvalidInput(list(field_problems(found, document))) from None
    small = {name: getattr(request, name) for name in model.model_fields if _is_small(document, name)}
    return model.folded(canonical_json(request), small)


def _is_small(document: Any, name: str) -> bool:
    return name not in document or len(json.dumps(document[name])) < _SMALL
