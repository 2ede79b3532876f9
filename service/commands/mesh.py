"""`rivetplan mesh check`: a file in, what is to be known of its bodies out; mended where asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import typer

from robots.meshes.audit import audit
from robots.meshes.audit_findings import counted
from robots.meshes.model import Body, Model, Unit
from robots.meshes.quarantine import read_limited
from robots.meshes.repair import Fix, Repaired, repair
from robots.meshes.writing import WRITERS
from service.canonical import canonical_json
from service.commands.plan import check_target, write
from service.commands.reading import Unusable, as_lines
from service.mesh_schemas import MeshBody, MeshCheck
from service.mesh_tables import lines

Form = Literal["table", "json", "none"]


@dataclass(frozen=True)
class Source:
    """A file, the unit of its numbers where that is told, and which of its bodies; none for all."""

    file: Path
    unit: Unit | None
    bodies: tuple[str, ...] = ()


@dataclass(frozen=True)
class Mending:
    """Where mended bodies go, what to mend, and how far: [m]."""

    file: Path | None
    fixes: tuple[Fix, ...]
    tolerance: float
    longest_rim: float


def check(source: Source, *, skin: Source | None, mending: Mending, form: Form) -> bool:
    """Print what is to be known of a file's bodies, mended first where asked for; return whether all are
    sound. Raises Unusable.
    """
    _check_mending(source, skin, mending)
    model = _read(source)
    bodies = _chosen(source, model)
    repairs: dict[str, tuple[str, ...]] = {}
    shown = source.file
    if mending.file is not None:
        mended = [_mended(source, body, mending) for body in bodies]
        with as_lines(f"{mending.file}#"):
            content = WRITERS[mending.file.suffix.lower()]([each.body for each in mended])
        write(mending.file, content)
        repairs = {each.body.name: (*each.done, *_untold(each.body)) for each in mended}
        shown = mending.file
        model, bodies = _as_written(mending.file, [each.body for each in mended])
    surface = None if skin is None else _one(_chosen(skin, _read(skin)))
    found = [MeshBody.of(audit(each, surface), each.deviation, repairs.get(each.name, ())) for each in bodies]
    answer = MeshCheck.of(str(shown), model, found)
    if form == "json":
        typer.echo(canonical_json(answer), nl=False)
    elif form == "table":
        for line in lines(answer):
            typer.echo(line)
    return answer.sound


def _check_mending(source: Source, skin: Source | None, mending: Mending) -> None:
    if mending.file is None:
        if mending.fixes:
            raise Unusable(["--fix: nothing is written. Say where with --repair OUT.glb."])
        return
    if not mending.fixes:
        raise Unusable(["--repair: what to mend is not said. Say it: --fix merge --fix orient."])
    if mending.file.suffix.lower() not in WRITERS:
        raise Unusable(
            [f"{mending.file}: the name does not tell the form. End it in {' or '.join(WRITERS)}."]
        )
    taken = {source.file: "the file that is checked"}
    check_target(mending.file, taken if skin is None else taken | {skin.file: "the skin"}, "the repair")


def _read(source: Source) -> Model:
    try:
        with as_lines(f"{source.file}#"):
            return read_limited(source.file, source.file.name, source.unit)
    except OSError as error:
        raise Unusable([f"{source.file}: cannot be read: {error.strerror}. Name a readable file."]) from None


def _chosen(source: Source, model: Model) -> list[Body]:
    names = [body.name for body in model.bodies]
    for name in source.bodies:
        if name not in names:
            some = ", ".join(names[:12])
            raise Unusable([f"--body: {source.file} has no body {name!r}. Use one of: {some}."])
    return [body for body in model.bodies if not source.bodies or body.name in source.bodies]


def _mended(source: Source, body: Body, mending: Mending) -> Repaired:
    with as_lines(f"{source.file}#"):
        return repair(body, mending.fixes, tolerance=mending.tolerance, longest_rim=mending.longest_rim)


def _untold(body: Body) -> list[str]:
    """What a mesh file does not say of a body, and so is lost."""
    said = []
    if body.deviation:
        off = f"up to {1000.0 * body.deviation:.3g} mm off the true surface"
        said.append(f"note: the file that was written does not tell that triangles are {off}")
    if body.holes:
        said.append(f"note: it does not tell {counted(len(body.holes), 'cylindrical hole')} either")
    return said


def _as_written(file: Path, bodies: Sequence[Body]) -> tuple[Model, list[Body]]:
    """What was written, read again: the file has single precision, so that this is what is to be checked."""
    model = _read(Source(file, "mm" if file.suffix.lower() == ".stl" else None))
    written = zip(bodies, model.bodies, strict=True)
    return model, [Body(a.name, b.vertices, b.triangles, a.holes, a.deviation) for a, b in written]


def _one(bodies: Sequence[Body]) -> Body:
    """Bodies as one: a skin may be several."""
    firsts = np.cumsum([0, *(len(body.vertices) for body in bodies)])
    return Body(
        "skin",
        np.concatenate([body.vertices for body in bodies]),
        np.concatenate([body.triangles + first for body, first in zip(bodies, firsts, strict=False)]),
        deviation=max(body.deviation for body in bodies),
    )
