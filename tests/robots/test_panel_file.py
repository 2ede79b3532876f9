"""What a sound panel file becomes."""

import json
from pathlib import Path

import numpy as np
import pytest

from robots.panel_file import load_panel
from robots.panel_schema import PanelDefinition
from tests.robots.panels import RIVET, SURFACES, Document, changed, found, small_panel


@pytest.mark.parametrize("surface", SURFACES)
def test_small_panel_loads_on_every_surface(surface: Document) -> None:
    panel = load_panel(small_panel(surface=surface, fasteners=[]))

    assert [(part.id, part.kind) for part in panel.parts] == [
        ("skin", "skin"),
        ("S1", "stringer"),
        ("F1", "frame"),
        ("K1", "clip"),
    ]
    for fastener, stack in zip(panel.fasteners, panel.stacks, strict=True):
        u, v, depth = panel.surface.locate(fastener.p)
        assert abs(depth) < 1e-12
        assert np.allclose(fastener.n, panel.surface.normal(u, v))
        assert stack.parts == ("skin", fastener.member)
        assert fastener.grip == stack.grip == pytest.approx(3.2e-3, abs=1e-5)
        assert stack.depth == pytest.approx(3.2e-3, abs=panel.chord_deviation + 1e-6)


def test_sizes_become_metres() -> None:
    panel = load_panel(
        small_panel(
            sag_mm=0.4, mounting={"position_mm": [10.0, 20.0, 30.0], "rotation_deg": [0.0, 0.0, 90.0]}
        )
    )
    tack = panel.fasteners[0]

    assert panel.sag == pytest.approx(0.4e-3)
    assert np.allclose(panel.mounting[:3, 3], [0.01, 0.02, 0.03])
    assert np.allclose(panel.mounting[:3, 0], [0.0, 1.0, 0.0])
    assert np.allclose(tack.p, [0.1, 0.0132, 0.0])
    assert tack.diameter == pytest.approx(0.004)
    assert tack.grip == pytest.approx(0.0032)
    assert np.allclose(panel.bounds[0][:2], -0.2)


def test_mounting_is_the_identity_when_not_given() -> None:
    assert np.array_equal(load_panel(small_panel()).mounting, np.eye(4))


def test_order_is_explicit_fasteners_then_rows_as_listed() -> None:
    names = [fastener.id for fastener in load_panel(small_panel()).fasteners]

    assert names[:3] == ["tack", "R1.S1.001", "R1.S1.002"]
    assert names[-5:] == [f"R2.K1.{k:03d}" for k in range(1, 6)]


def test_rows_turn_back_when_asked_and_keep_their_names() -> None:
    document = small_panel(fasteners=[])
    document["stringers"].append({"id": "S2", "section": "Z30", "arc_mm": -150.0})
    row = {"id": "R", "members": ["S1", "S2"], "count": 3, **RIVET}
    orders = {}
    for reverse in (False, True):
        document["rows"] = [{**row, "serpentine": True, "reverse": reverse}]
        orders[reverse] = [fastener.id for fastener in load_panel(document).fasteners]

    assert orders[False] == [f"R.S1.00{k}" for k in (1, 2, 3)] + [f"R.S2.00{k}" for k in (3, 2, 1)]
    assert orders[True] == [f"R.S1.00{k}" for k in (3, 2, 1)] + [f"R.S2.00{k}" for k in (1, 2, 3)]


def test_source_may_be_path_bytes_or_document(tmp_path: Path) -> None:
    path = tmp_path / "panel.json"
    path.write_text(json.dumps(small_panel(), indent=3))

    hashes = {
        load_panel(source).sha256
        for source in (path, str(path), json.dumps(small_panel()).encode(), small_panel())
    }

    assert len(hashes) == 1


def test_hash_is_of_the_content_not_of_its_form() -> None:
    base = load_panel(small_panel()).sha256
    document = small_panel(sag_mm=0)  # a default spelled out, as an integer
    document["skin"]["id"] = "skin"
    turned_round = dict(reversed(list(document.items())))

    assert load_panel(turned_round).sha256 == base
    assert load_panel(changed("skin/thickness_mm", 1.7) | {"fasteners": []}).sha256 != base


def test_loading_changes_nothing_in_the_document() -> None:
    document = small_panel()

    load_panel(document)

    assert document == small_panel()


def test_drill_only_needs_no_member() -> None:
    document = changed("fasteners/0/p_mm", [100.0, 60.0, 0.0])
    document["fasteners"][0] |= {"process": "drill_only", "grip_mm": "from_stack"}

    panel = load_panel(document)

    assert panel.stacks[0].parts == ("skin",)
    assert panel.fasteners[0].grip == pytest.approx(1.6e-3)


def test_grip_may_differ_from_the_stack_within_its_tolerance() -> None:
    assert found(changed("fasteners/0/grip_mm", 3.49)) == []
    assert load_panel(changed("fasteners/0/grip_mm", 3.49)).fasteners[0].grip == pytest.approx(3.49e-3)


def test_normals_are_made_unit() -> None:
    panel = load_panel(changed("fasteners/0/n", [0.0, 0.0, 250.0]))

    assert np.allclose(panel.fasteners[0].n, [0.0, 0.0, 1.0])


def test_members_on_doublers_join_three_parts() -> None:
    document = small_panel(fasteners=[])
    document["doublers"] = [
        {"id": "D1", "x_mm": [-200.0, 200.0], "arc_mm": [-20.0, 24.0], "thickness_mm": 1.2},
        {"id": "D2", "x_mm": [-200.0, 200.0], "arc_mm": [-20.0, 24.0], "thickness_mm": 0.8, "on": "D1"},
    ]
    document["stringers"][0]["on"] = "D2"

    stack = load_panel(document).stacks[0]

    assert stack.parts == ("skin", "D1", "D2", "S1")
    assert stack.depth == pytest.approx(5.2e-3)


def test_rows_on_plates_need_and_use_a_direction() -> None:
    document = small_panel(fasteners=[])
    document["straps"] = [{"id": "T", "x_mm": [60.0, 180.0], "arc_mm": [-150.0, -50.0], "thickness_mm": 1.2}]
    row: Document = {"id": "RT", "members": ["T"], "count": 3, **RIVET}
    document["rows"] = [row]
    assert found(document) == [("/rows/0/direction", "missing_field")]

    row |= {"direction": "arc", "offset_mm": 30.0, "start_mm": 10.0, "end_mm": 10.0}
    points = np.array([fastener.p for fastener in load_panel(document).fasteners])

    assert np.allclose(points, [[0.15, y, 0.0] for y in (-0.14, -0.10, -0.06)])


@pytest.mark.parametrize("surface", SURFACES)
def test_frames_on_the_skin_get_holes_at_their_stringers(surface: Document) -> None:
    document = small_panel(surface=surface, fasteners=[], clips=[], rows=[])
    document["stringers"].append({"id": "S2", "section": "Z30", "arc_mm": -120.0})
    document["frames"][0] |= {
        "standoff_mm": 0.0,
        "mouse_holes_at_stringers": {"side_clearance_mm": 4.0, "top_clearance_mm": 3.0},
    }
    document["rows"] = [{"id": "RF", "members": ["F1"], "pitch_mm": 10.0, **RIVET}]

    panel = load_panel(document)

    assert {stack.parts for stack in panel.stacks} == {("skin", "F1")}
    numbers = [int(fastener.id[-3:]) for fastener in panel.fasteners]
    assert len(numbers) < max(numbers)  # those over the holes are left out
    document["frames"][0]["mouse_holes_at_stringers"] = None
    document["frames"][0]["mouse_holes"] = [{"arc_mm": 0.0, "width_mm": 70.0, "height_mm": 40.0}]
    assert ("/frames/0", "parts_pierce") in found(document)  # S2 has no hole


def test_unknown_names_are_judged_by_the_processes_given() -> None:
    panel = load_panel(changed("rows/0/process", "glue"), processes=["glue", "solid_rivet"])

    assert {fastener.process for fastener in panel.fasteners} == {"glue", "solid_rivet"}


def test_schema_can_be_published() -> None:
    schema = PanelDefinition.model_json_schema()

    assert schema["additionalProperties"] is False
    assert schema["required"] == ["schema_version", "id"]
