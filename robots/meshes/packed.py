"""A model as bytes: a line of JSON, then the numbers as they are in memory, little end first.

    RIVETPLAN MODEL 1\\n  {"bodies": [...], "format": ...}\\n  of each body (V, 3) <f8 and (T, 3) <i4

The same model gives the same bytes; what is read is checked, and nothing in it is run.
"""

from __future__ import annotations

import json
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from robots.errors import InvalidInput
from robots.meshes.model import Body, Format, Hole, Model, Unit
from robots.meshes.refusals import MAX_TRIANGLES, refused

_MAGIC = b"RIVETPLAN MODEL 1\n"
_VERTEX_BYTES, _TRIANGLE_BYTES = 24, 12

Count = Annotated[int, Field(ge=0, le=3 * MAX_TRIANGLES)]
Length = Annotated[FiniteFloat, Field(ge=0.0)]
Place = tuple[FiniteFloat, FiniteFloat, FiniteFloat]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class _Hole(_Strict):
    first: Place
    last: Place
    radius: Length


class _Body(_Strict):
    name: str
    vertices: Count
    triangles: Count
    holes: list[_Hole]
    deviation: Length


class _Head(_Strict):
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    format: Format
    unit: Unit
    told: bool
    bodies: list[_Body]


def pack(model: Model) -> bytes:
    """`model` as bytes, which `unpack` reads."""
    head = {
        "sha256": model.sha256,
        "format": model.format,
        "unit": model.unit,
        "told": model.told,
        "bodies": [_entry(body) for body in model.bodies],
    }
    text = json.dumps(head, sort_keys=True, separators=(",", ":"), allow_nan=False).encode("ascii")
    parts = [_MAGIC, text, b"\n"]
    for body in model.bodies:
        parts += [body.vertices.astype("<f8").tobytes(), body.triangles.astype("<i4").tobytes()]
    return b"".join(parts)


def _entry(body: Body) -> dict[str, object]:
    holes = [
        {"first": hole.first.tolist(), "last": hole.last.tolist(), "radius": float(hole.radius)}
        for hole in body.holes
    ]
    return {
        "name": body.name,
        "vertices": len(body.vertices),
        "triangles": len(body.triangles),
        "holes": holes,
        "deviation": float(body.deviation),
    }


def unpack(content: bytes) -> Model:
    """The model that `pack` wrote; raises InvalidInput where the bytes are anything else."""
    end = content.find(b"\n", len(_MAGIC))
    if not content.startswith(_MAGIC) or end < 0:
        raise _damaged("they do not begin as a model does")
    try:
        head = _Head.model_validate_json(content[len(_MAGIC) : end])
    except ValidationError as error:
        raise _damaged(error.errors()[0]["msg"]) from None
    needed = sum(_VERTEX_BYTES * each.vertices + _TRIANGLE_BYTES * each.triangles for each in head.bodies)
    if len(content) - end - 1 != needed:
        raise _damaged(f"{needed} bytes of numbers are declared, {len(content) - end - 1} are there")
    bodies, place = [], end + 1
    for entry in head.bodies:
        bodies.append(_body(entry, content, place))
        place += _VERTEX_BYTES * entry.vertices + _TRIANGLE_BYTES * entry.triangles
    return Model(head.sha256, head.format, head.unit, head.told, tuple(bodies))


def _body(entry: _Body, content: bytes, place: int) -> Body:
    vertices = np.frombuffer(content, "<f8", 3 * entry.vertices, place)
    place += _VERTEX_BYTES * entry.vertices
    triangles = np.frombuffer(content, "<i4", 3 * entry.triangles, place).astype(np.int64)
    if not np.isfinite(vertices).all():
        raise _damaged("a vertex is not finite")
    if len(triangles) and not (int(triangles.min()) >= 0 and int(triangles.max()) < entry.vertices):
        raise _damaged("a triangle uses a vertex that is not there")
    holes = tuple(Hole(np.array(h.first), np.array(h.last), h.radius) for h in entry.holes)
    shape = vertices.astype(np.float64).reshape(-1, 3)
    return Body(entry.name, shape, triangles.reshape(-1, 3), holes, entry.deviation)


def _damaged(why: str) -> InvalidInput:
    message = f"the bytes are not a packed model: {why}"
    return refused("packed_model_damaged", message, "Read the model from its file again.")
