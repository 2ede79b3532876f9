"""The skin that a panel definition has, parametric or of meshes, for fasteners that are not in it yet."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import ValidationError

from robots.bodies import pose
from robots.errors import InputProblem, InvalidInput
from robots.fastener_lists.mesh_skin import MeshSkin
from robots.fastener_lists.skin import SkinView, SurfaceSkin
from robots.meshes.model import Body
from robots.panel_meshes import Models, no_models
from robots.panel_schema import MeshDefinition, PanelDefinition
from robots.schema_problems import schema_problems
from robots.surface import Surface


def panel_skin(document: Mapping[str, Any], models: Models = no_models) -> SkinView:
    """The skin of a panel document, whatever fasteners that has. Raises InvalidInput."""
    bare = {key: value for key, value in document.items() if key not in ("fasteners", "rows", "adjustments")}
    try:
        definition = PanelDefinition.model_validate(bare)
    except ValidationError as error:
        found = schema_problems(error.errors(include_url=False), bare, PanelDefinition)
        raise InvalidInput([problem for _, problem in found]) from None
    if definition.skin is not None:
        radii = (definition.surface.section_radius_mm, definition.surface.length_radius_mm)
        skin = definition.skin
        sizes = (skin.length_mm / 1e3, skin.width_mm / 1e3, skin.thickness_mm / 1e3)
        return SurfaceSkin(Surface(*(None if radius is None else radius / 1e3 for radius in radii)), *sizes)
    bodies = [
        body
        for i, mesh in enumerate(definition.meshes)
        if mesh.kind == "skin"
        for body in _bodies(mesh, f"/meshes/{i}", models)
    ]
    if not bodies:
        message, remedy = "the panel has no skin", "Give it a skin, or a mesh of kind skin."
        raise InvalidInput([InputProblem("/skin", "no_skin", message, None, remedy)])
    return MeshSkin(bodies)


def _bodies(mesh: MeshDefinition, place: str, models: Models) -> list[Body]:
    T = pose(np.array(mesh.position_mm) / 1e3, np.radians(mesh.rotation_deg))
    model = models(mesh.asset, mesh.unit)
    chosen = [body for body in model.bodies if mesh.body in (None, body.name)]
    if not chosen:
        names = ", ".join(body.name for body in model.bodies[:12])
        message, remedy = f"the file has no body {mesh.body!r}", f"Use one of: {names}."
        raise InvalidInput([InputProblem(f"{place}/body", "unknown_body", message, mesh.body, remedy)])
    return [
        Body(body.name, body.vertices @ T[:3, :3].T + T[:3, 3], body.triangles, (), body.deviation)
        for body in chosen
    ]
