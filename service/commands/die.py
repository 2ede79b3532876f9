"""`rivetplan die`: a mesh or a profile in, a die library with its convex solids out."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer

from robots.die_import.libraries import library_document
from robots.die_import.mesh_die import DieRoles, ImportedDie, die_from_mesh
from robots.die_import.profile import profile_body
from robots.meshes.model import Body, Unit
from robots.meshes.quarantine import read_limited
from service.commands.plan import check_target, write
from service.commands.reading import Unusable, as_lines

_PROFILE = ".json"
_ROW = "{:<8}  {:<8}  {:<24}  {:>15}  {:>15}"


@dataclass(frozen=True)
class Told:
    """What the options say; tip as it was written [mm], excess [m]."""

    id: str
    title: str
    unit: Unit | None
    body: str | None
    tip: str
    up: str
    excess: float
    most: int


def die(source: Path, told: Told, *, out: Path | None, quiet: bool) -> None:
    """Print the solids of the die and write its library to `out`. Raises Unusable."""
    roles = DieRoles(told.id, told.title, _tip(told.tip), told.up, told.excess, told.most)
    if out is not None:
        check_target(out, {source: "the file that is read"}, "the die library")
    body = _profile(source, told) if source.suffix.lower() == _PROFILE else _body(source, told)
    with as_lines(f"{source}#"):
        found = die_from_mesh(body, roles)
    if out is not None:
        text = json.dumps(library_document([found.entry]), indent=2, ensure_ascii=False, allow_nan=False)
        write(out, (text + "\n").encode())
    if not quiet:
        for line in _lines(source, found):
            typer.echo(line)


def _tip(text: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(part) / 1000.0 for part in text.split(","))
    except ValueError:
        x = y = z = math.nan
    if not all(map(math.isfinite, (x, y, z))):
        raise Unusable([f"--tip: {text!r} is no position. Write three numbers in mm: --tip 0,0,250."])
    return x, y, z


def _profile(source: Path, told: Told) -> Body:
    if told.unit is not None or told.body is not None:
        option = "--body" if told.unit is None else "--unit"
        raise Unusable([f"{option}: a profile is one body and states its unit. Leave the option out."])
    with as_lines(f"{source}#"):
        return profile_body(source)


def _body(source: Path, told: Told) -> Body:
    try:
        with as_lines(f"{source}#"):
            bodies = read_limited(source, source.name, told.unit).bodies
    except OSError as error:
        raise Unusable([f"{source}: cannot be read: {error.strerror}. Name a readable file."]) from None
    chosen = [body for body in bodies if told.body in (None, body.name)]
    if len(chosen) != 1:
        some = ", ".join(body.name for body in bodies[:12])
        fault = f"has {len(bodies)} bodies" if told.body is None else f"has no body {told.body!r}"
        raise Unusable([f"--body: {source} {fault}. Use one of: {some}."])
    return chosen[0]


def _lines(source: Path, found: ImportedDie) -> Iterator[str]:
    solids = found.entry["solids"]
    turns = "the same at every angle" if found.entry["axisymmetric"] else "not the same at every angle"
    yield f"{source}: die {found.entry['id']}, {len(solids)} solids, {turns}"
    yield ""
    yield _ROW.format("solid", "shape", "size [mm]", "x [mm]", "z [mm]").rstrip()
    for solid in solids:
        yield _row(solid["name"], solid["shape"])
    yield ""
    yield "every triangle of the body is inside the solids"
    yield f"they stand out of it by {found.excess * 1000.0:.3f} mm (sampled every 4 mm)"
    yield f"and have {found.growth:.4f} times its volume"
    yield f"it ends at z = {found.mounting_face_mm:g} mm"
    if abs(found.shifted) >= 5e-7:
        yield f"it was moved by {found.shifted * 1000.0:+.3f} mm along z, so that it ends at z = 0"


def _row(name: str, shape: dict[str, Any]) -> str:
    if shape["type"] == "cylinder":
        (x, y), z, radius = shape["center_xy_mm"], shape["z_mm"], shape["radius_mm"]
        size = f"diameter {2.0 * radius:.2f}" + (f", y {y:.2f}" if abs(y) >= 0.005 else "")
        across = [x - radius, x + radius]
    else:
        across, z = ([corner[i] for corner in shape["profile_xz_mm"]] for i in (0, 1))
        low, high = shape["y_mm"]
        size = f"y {low:.2f} to {high:.2f}"
    ends = [f"{min(each):.2f} {max(each):.2f}" for each in (across, z)]
    return _ROW.format(name, shape["type"], size, *ends)
