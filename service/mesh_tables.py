"""What `rivetplan mesh check` prints: for eighty columns."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator

from robots.meshes.audit_thickness import Place
from service.mesh_schemas import MeshBody, MeshCheck, MeshFinding

_WIDTH = 80
_FEW = 5  # bodies, up to which the figures of those without findings are told, too
_ROW = "{:<22.22}  {:>24}  {:>9}  {:<6}  {:>9}"


def lines(answer: MeshCheck) -> Iterator[str]:
    """A table with a row for each body, then what is to be said of each."""
    said = "as the file says" if answer.told else "as you say"
    bodies = "1 body" if len(answer.bodies) == 1 else f"{len(answer.bodies)} bodies"
    yield from _wrapped(f"{answer.file}: {bodies}, in {answer.unit} ({said})", "", "  ")
    yield ""
    yield _ROW.format("body", "size [mm]", "triangles", "closed", "thick[mm]")
    for body in answer.bodies:
        thick = "-" if body.thickness is None else f"{body.thickness.least_mm:.3f}"
        size = " x ".join(f"{b - a:.5g}" for a, b in zip(body.low_mm, body.high_mm, strict=True))
        yield _ROW.format(body.name, size, body.triangles, "yes" if body.closed else "no", thick)
    for body in answer.bodies:
        yield from _about(body, whole=len(answer.bodies) <= _FEW)
    yield ""
    wrong = sum(not body.sound for body in answer.bodies)
    yield "a panel takes all of it" if not wrong else f"a panel refuses {wrong} of {bodies}"


def _about(body: MeshBody, *, whole: bool) -> Iterator[str]:
    said = [*(_figures(body) if whole or body.findings else ()), *body.repairs]
    if not said and not body.findings:
        return
    yield ""
    yield from _wrapped(body.name, "", "  ")
    for each in said:
        yield from _wrapped(each, "  ", "    ")
    for finding in body.findings:
        yield from _finding(finding)


def _figures(body: MeshBody) -> Iterator[str]:
    if body.thickness is not None:
        thick = body.thickness
        figures = f"{thick.least_mm:.3f} mm at {_shown(thick.where_mm)}; a twentieth is below"
        yield f"thickness: {figures} {thick.twentieth_mm:.3f}, half below {thick.median_mm:.3f}"
    if body.skin is not None and not body.skin.crossing:
        yield f"skin: {body.skin.distance_mm:.4g} mm away at {_shown(body.skin.where_mm)}"


def _finding(finding: MeshFinding) -> Iterator[str]:
    where = "" if finding.where_mm is None else f" at {_shown(finding.where_mm)}"
    yield from _wrapped(f"{finding.severity}: {finding.message}{where}", "  ", "    ")
    yield from _wrapped(finding.remedy, "    ", "    ")


def _shown(place: Place) -> str:
    return "(" + ", ".join(f"{round(each, 3) + 0.0:g}" for each in place) + ")"


def _wrapped(text: str, first: str, other: str) -> list[str]:
    return textwrap.wrap(text, _WIDTH, initial_indent=first, subsequent_indent=other)
