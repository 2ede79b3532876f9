"""Answers as canonical JSON: the same content, the same bytes."""

import json

from pydantic import BaseModel


def canonical_json(model: BaseModel) -> bytes:
    """Return the model as sorted, compact JSON in one line of ASCII."""
    content = model.model_dump(mode="json")
    return (json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False) + "\n").encode(
        "ascii"
    )
