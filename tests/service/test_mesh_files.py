"""Panels on disk that name files: the example bay in four forms, and files that are wrong."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from robots.errors import InvalidInput
from robots.panel import Panel
from robots.panel_file import load_panel
from service import openapi
from service.commands.mesh_files import with_assets
from service.inputs import Places, gather
from service.panel_check import check_panel

BAY = openapi.FILE.parent / "examples" / "bay"
FORMS = ("panel", "panel_stl", "panel_glb", "panel_step")


def document_of(form: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((BAY / f"{form}.json").read_bytes())
    return found


@pytest.fixture(scope="module")
def panels() -> dict[str, Panel]:
    pytest.importorskip("cascadio")
    found = {}
    for form in FORMS:
        document, models = with_assets(document_of(form), BAY)
        found[form] = load_panel(document, None, models)
    return found


def test_all_forms_have_the_same_fasteners_and_stacks(panels: dict[str, Panel]) -> None:
    plain = panels["panel"]
    for panel in panels.values():
        assert [f.id for f in panel.fasteners] == [f.id for f in plain.fasteners]
        assert [s.parts for s in panel.stacks] == [s.parts for s in plain.stacks]
        for one, other in zip(panel.stacks, plain.stacks, strict=True):
            assert abs(one.grip - other.grip) < 0.2e-3  # the parametric one's chords
    assert panels["panel_step"].mesh_deviation > 0.0 == panels["panel_stl"].mesh_deviation


def test_all_forms_have_the_same_statuses(panels: dict[str, Panel]) -> None:
    statuses = []
    for form in FORMS:
        document, models = with_assets(document_of(form), BAY)
        found = check_panel(gather(document, "riveter", None, Places(), None, models), remedies=False)
        statuses.append([(each.id, each.status) for each in found.fasteners])
    assert all(each == statuses[0] for each in statuses)


def test_wrong_files_are_told_with_their_places(tmp_path: Path) -> None:
    shutil.copytree(BAY / "stl", tmp_path / "stl")
    (tmp_path / "stl" / "clip.stl").write_bytes(b"solid nothing")
    document = document_of("panel_stl")
    document["meshes"][0].pop("unit")
    document["meshes"][1]["file"] = "stl/missing.stl"

    with pytest.raises(InvalidInput) as refused:
        with_assets(document, tmp_path)

    found = {(problem.pointer, problem.code) for problem in refused.value.problems}
    assert ("/meshes/0/unit", "unit_missing") in found
    assert ("/meshes/1/file", "unreadable") in found
    assert {pointer for pointer, _ in found} >= {f"/meshes/{i}/file" for i in range(6, 10)}


def test_panels_without_meshes_are_left_as_they_are(tmp_path: Path) -> None:
    document = document_of("panel")

    assert with_assets(document, tmp_path)[0] == document
    assert with_assets({"meshes": "none"}, tmp_path)[0] == {"meshes": "none"}
