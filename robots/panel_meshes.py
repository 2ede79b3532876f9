"""Parts whose shapes are in files: bodies of triangles, placed in the panel frame."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from robots import bodies, hexahedra
from robots.errors import InputProblem, InvalidInput
from robots.meshes.model import Body, Model, Unit
from robots.panel import Panel, Part
from robots.panel_reading import Findings, Reading
from robots.panel_schema import MeshDefinition
from robots.schema_problems import Keys
from robots.surface import Surface

#: What the files of a panel hold, by their sha256 and the unit their numbers are taken in; raises
#: InvalidInput where there is no such file, or it cannot be read in that unit.
Models = Callable[[str, Unit | None], Model]

#: More triangles than any real panel needs: the planner has a gigabyte for these.
MAX_TRIANGLES = 1_000_000


def no_models(sha256: str, _unit: Unit | None) -> Model:
    """Models where there are no files."""
    message, remedy = "there is no file with this sha256", "Bring the file first."
    raise InvalidInput([InputProblem("/asset", "unknown_asset", message, sha256, remedy)])


class MeshParts:
    """The sound parts among the meshes of a definition; faults go to `findings`.

    models: or a panel that has the same meshes, and other parts beside. places: in the document, by part id.
        deviation: of their triangles from the true surfaces, at most [m].
    """

    def __init__(self, reading: Reading, findings: Findings, models: Models | Panel) -> None:
        self._reading, self._findings, self._models = reading, findings, models
        self.parts: list[Part] = []
        self.places: dict[str, Keys] = {}
        self.deviation = 0.0
        self._triangles = 0
        for position, entry in enumerate(reading.definition.meshes):
            if entry.id not in self.places:  # a duplicate id is reported elsewhere
                keys = self.places[entry.id] = reading.keys("meshes", position)
                self._add(entry, keys)

    def extent(self, surface: Surface) -> tuple[float, float]:
        """Length and width [m], both about the middle of `surface`, that hold the skin."""
        skins = [part.pieces.reshape(-1, 3) for part in self.parts if part.kind == "skin"]
        if not skins:
            return 0.0, 0.0
        u, v, _ = surface.locate(np.concatenate(skins))
        return 2.0 * float(np.abs(u).max()), 2.0 * float(np.abs(v).max())

    def _add(self, entry: MeshDefinition, keys: Keys) -> None:
        if isinstance(self._models, Panel):
            self.parts.append(self._models.part(entry.id))
            self.deviation = self._models.mesh_deviation
            return
        chosen = self._bodies(self._models, entry, keys)
        if chosen is not None and self._is_sound(entry, chosen, keys):
            self.deviation = max(self.deviation, *(body.deviation for body in chosen))
            self.parts.append(_part(entry, chosen))

    def _bodies(self, models: Models, entry: MeshDefinition, keys: Keys) -> list[Body] | None:
        try:
            model = models(entry.asset, entry.unit)
        except InvalidInput as invalid:
            for each in invalid.problems:
                member = each.pointer.strip("/") or "asset"
                self._findings.add((*keys, member), each.code, each.message, each.value, each.remedy)
            return None
        chosen = [body for body in model.bodies if entry.body in (None, body.name)]
        if not chosen:
            names = ", ".join(body.name for body in model.bodies[:12])
            message, remedy = f"the file has no body {entry.body!r}", f"Use one of: {names}."
            self._findings.add((*keys, "body"), "unknown_body", message, entry.body, remedy)
            return None
        return chosen

    def _is_sound(self, entry: MeshDefinition, chosen: list[Body], keys: Keys) -> bool:
        """Whether there is room for the bodies, and each closes a volume that its triangles face out of.

        An open one has no inside: what is in it could not be told from what is outside, nor could the
        thickness under a fastener.
        """
        before, self._triangles = self._triangles, self._triangles + sum(len(b.triangles) for b in chosen)
        if self._triangles > MAX_TRIANGLES:
            if before <= MAX_TRIANGLES:
                message = f"from here on the panel has more than {MAX_TRIANGLES} triangles"
                remedy = "Export the parts with a coarser tolerance, or divide the panel."
                self._findings.add(keys, "too_large", message, self._triangles, remedy)
            return False
        faults = list(_faults(chosen))
        for code, message, remedy in faults:
            self._findings.add((*keys, "asset"), code, message, entry.id, remedy)
        return not faults


def _faults(chosen: Iterable[Body]) -> Iterator[tuple[str, str, str]]:
    for body in chosen:
        name = f"the body {body.name!r}"
        open_edges = _unpaired_edges(body.triangles)
        if open_edges:
            message = f"{name} is not closed, or its triangles do not all face out: {open_edges} edges"
            yield "mesh_not_closed", message, "See `rivetplan mesh check`, which also repairs, if told to."
        elif _is_inside_out(body):
            message = f"{name}, or a piece of it, is inside out: its triangles face inwards"
            yield "mesh_inside_out", message, "Repair it with `rivetplan mesh check --fix orient`."


def _unpaired_edges(triangles: NDArray[np.int64]) -> int:
    """How many directed edges are not met by exactly one the other way."""
    first = triangles.ravel().astype(np.int64)
    second = np.roll(triangles, -1, axis=1).ravel().astype(np.int64)
    size = int(triangles.max()) + 1
    forth, counts = np.unique(first * size + second, return_counts=True)
    back = second * size + first
    unmet = ~np.isin(back, forth)
    return int(unmet.sum()) + int((counts - 1).sum())


def _is_inside_out(body: Body) -> bool:
    """Whether triangles of a closed body face inwards, other than those of a cavity in its material."""
    # Imported when first used, as in `cell`: loading compiled code takes time.
    from robots.meshes.audit import inverted_pieces
    from robots.meshes.audit_edges import components, edges_of

    corners = body.corners()
    count, piece = components(len(corners), edges_of(body.triangles))
    return bool(inverted_pieces(corners, piece, count).any())


def _part(entry: MeshDefinition, chosen: list[Body]) -> Part:
    T = bodies.pose(np.array(entry.position_mm) / 1000.0, np.radians(entry.rotation_deg))
    corners = np.concatenate([body.corners() for body in chosen])
    pieces = hexahedra.flat(corners @ T[:3, :3].T + T[:3, 3])
    return Part(entry.id, entry.kind, pieces, is_mesh=True)
