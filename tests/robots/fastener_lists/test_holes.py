"""Fasteners from holes: those through the skin, one for each axis; the others with a reason."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from planners.arrays import Array
from robots.errors import InvalidInput
from robots.fastener_lists.holes import by_reason, from_holes
from robots.fastener_lists.mapping import Mapping
from robots.fastener_lists.mesh_skin import MeshSkin
from robots.fastener_lists.reading import FastenerList
from robots.meshes.model import Body, Hole
from tests.robots.fastener_lists.samples import CURVED, FLAT, THICKNESS, arched, body, drilled, plate

UP = np.array([0.0, 0.0, 1.0])
MAPPING = {
    "holes": [{"hole_mm": 4.1, "diameter_mm": 4.0}, {"hole_mm": 5.1, "diameter_mm": 5.0}],
    "defaults": {"process": "slug"},
}


def hole(p: Array, n: Array, begins: float, ends: float, diameter: float = 0.0041) -> Hole:
    """A hole between two depths below p."""
    return Hole(p - begins * n, p - ends * n, 0.5 * diameter)


def part(name: str, *holes: Hole) -> Body:
    return Body(name, np.zeros((1, 3)), np.empty((0, 3), dtype=np.int64), holes)


def at(x: float, y: float = 0.0) -> Array:
    return np.array([x, y, 0.0])


def through(x: float, y: float = 0.0, **sizes: float) -> Hole:
    return hole(at(x, y), UP, 0.0, THICKNESS, **sizes)


def taken(*bodies: Body, **changes: Any) -> FastenerList:
    return from_holes(bodies, FLAT, Mapping.model_validate(MAPPING | changes))


def reasons(found: FastenerList) -> list[str]:
    return [each.code for each in found.left_out]


def test_hole_through_the_skin_takes_a_fastener() -> None:
    found = taken(part("skin", through(0.02, 0.1)))

    assert found.entries == (
        {
            "id": "H0001",
            "p_mm": [20.0, 100.0, 0.0],
            "n": [0.0, 0.0, 1.0],
            "diameter_mm": 4.0,
            "grip_mm": "from_stack",
            "process": "slug",
        },
    )
    assert found.left_out == ()


def test_coaxial_holes_of_several_bodies_are_one() -> None:
    skin = part("skin", through(0.0), through(0.02))
    strap = part("strap", hole(at(0.0), UP, THICKNESS, 0.0028))
    foot = part("S1", hole(at(0.0), UP, 0.0028, 0.0044), hole(at(0.02), UP, THICKNESS + 0.0005, 0.003))

    found = taken(foot, skin, strap)

    assert [entry["p_mm"] for entry in found.entries] == [[0.0, 0.0, 0.0], [20.0, 0.0, 0.0]]
    assert found.left_out == ()


def test_order_and_ids_do_not_depend_on_that_of_holes_and_their_ends() -> None:
    rng = np.random.default_rng(1)
    places = [(x, y) for x in (-0.2, 0.0, 0.1) for y in (-0.05, 0.04)]
    holes = [through(x, y) for x, y in places]
    shuffled = [holes[i] for i in rng.permutation(len(holes))]
    turned = [Hole(each.last, each.first, each.radius) for each in shuffled]

    first, second = taken(part("skin", *holes)), taken(part("skin", *turned))

    assert first.entries == second.entries
    assert [entry["p_mm"][:2] for entry in first.entries] == [[1000.0 * x, 1000.0 * y] for x, y in places]
    assert [entry["id"] for entry in first.entries] == [f"H{i:04d}" for i in range(1, 7)]


@pytest.mark.parametrize(
    ("odd", "code"),
    [
        (hole(at(0.1), UP, 0.0, 0.001), "blind"),
        (hole(at(0.1), UP, THICKNESS, 0.004), "not_in_skin"),
        (hole(at(0.1), UP, 0.05, 0.06), "not_in_skin"),
        (hole(at(0.8), UP, 0.0, THICKNESS), "off_skin"),
        (hole(at(0.1), np.array([0.0, 0.06, np.sqrt(1.0 - 0.0036)]), 0.0, THICKNESS), "tilted"),
        (hole(at(0.1), UP, 0.0, THICKNESS, 0.0064), "no_diameter"),
        (hole(at(0.1), UP, 0.0, THICKNESS, 0.00416), "no_diameter"),
    ],
)
def test_holes_of_no_fastener_are_left_out_with_a_reason(odd: Hole, code: str) -> None:
    found = taken(part("skin", through(0.0), odd))

    assert len(found.entries) == 1
    assert reasons(found) == [code]
    assert "in skin" in found.left_out[0].what


def test_hole_that_is_countersunk_begins_below_the_face() -> None:
    found = taken(part("skin", hole(at(0.0), UP, 0.0009, THICKNESS)))

    assert found.entries[0]["p_mm"] == [0.0, 0.0, 0.0]


def test_hole_of_two_diameters_is_left_out() -> None:
    bodies = (
        part("skin", through(0.0), through(0.05)),
        part("S1", hole(at(0.0), UP, THICKNESS, 0.003, 0.0051)),
    )

    assert reasons(taken(*bodies)) == ["mixed_diameters"]


def test_hole_far_behind_on_the_same_axis_is_another() -> None:
    found = taken(part("skin", through(0.0)), part("frame", hole(at(0.0), UP, 0.09, 0.092, 0.02)))

    assert len(found.entries) == 1
    assert reasons(found) == ["not_in_skin"]


@pytest.mark.parametrize(
    "other",
    [
        hole(at(0.0), UP, 0.003, 0.004),  # a gap
        hole(at(0.001), UP, THICKNESS, 0.003),  # another axis
        hole(at(0.0), np.array([0.0, 0.03, np.sqrt(1.0 - 0.0009)]), THICKNESS, 0.003),  # another direction
    ],
)
def test_holes_are_one_only_where_they_follow_each_other_on_one_axis(other: Hole) -> None:
    found = taken(part("skin", through(0.0)), part("S1", other))

    assert (len(found.entries), reasons(found)) == (1, ["not_in_skin"])


def test_tolerance_of_a_hole_is_what_the_mapping_says() -> None:
    tight = [{"hole_mm": 4.1, "diameter_mm": 4.0, "tolerance_mm": 0.01}]
    skin = part("skin", through(0.0), through(0.05, diameter=0.00412))

    assert reasons(taken(skin)) == []
    assert reasons(taken(skin, holes=tight)) == ["no_diameter"]


def test_reasons_are_counted() -> None:
    found = taken(part("skin", through(0.0), *(hole(at(x), UP, 0.0, 0.001) for x in (0.1, 0.2))))

    ((code, count, first),) = by_reason(found.left_out)

    assert (code, count, first) == ("blind", 2, found.left_out[0])


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"defaults": {}}, [("/defaults", "no_process")]),
        ({"defaults": {"process": "glue"}}, [("/defaults/process", "unknown_process")]),
        ({"holes": []}, [("/holes", "no_diameter")]),
    ],
)
def test_what_holes_do_not_tell_must_be_said(
    changes: dict[str, Any], expected: list[tuple[str, str]]
) -> None:
    with pytest.raises(InvalidInput) as caught:
        taken(part("skin", through(0.0)), **changes)

    assert [(each.pointer, each.code) for each in caught.value.problems] == expected


@pytest.mark.parametrize("holes", [(), (hole(at(0.1), UP, 0.0, 0.001),)])
def test_part_without_holes_for_fasteners_is_refused(holes: Sequence[Hole]) -> None:
    with pytest.raises(InvalidInput) as caught:
        taken(part("skin", *holes))

    assert [each.code for each in caught.value.problems] == ["no_fasteners"]


def test_holes_that_run_into_each_other_are_told() -> None:
    with pytest.raises(InvalidInput) as caught:
        taken(part("skin", through(0.0), through(0.003)))

    assert [each.code for each in caught.value.problems] == ["fasteners_overlap"]


@pytest.mark.parametrize("on_triangles", [True, False])
def test_holes_of_a_curved_skin_have_its_points_and_normals(on_triangles: bool) -> None:
    turns, x = np.linspace(-0.18, 0.18, 7), np.linspace(-0.15, 0.2, 7)
    normals = np.stack([np.zeros(7), np.sin(turns), np.cos(turns)], axis=1)
    points = CURVED.surface.point(x, 1.975 * turns)
    holes = [hole(p, n, -0.0003, THICKNESS + 0.0002) for p, n in zip(points, normals, strict=True)]
    shape = body(drilled(arched(20.0, 150), points, normals, 0.00205), "skin", holes)
    skin = MeshSkin([shape]) if on_triangles else CURVED

    found = from_holes([shape], skin, Mapping.model_validate(MAPPING))

    assert found.left_out == ()
    np.testing.assert_allclose([entry["p_mm"] for entry in found.entries], 1000.0 * points, atol=0.02)
    np.testing.assert_allclose([entry["n"] for entry in found.entries], normals, atol=1e-9)


def test_thousands_of_holes_are_taken() -> None:
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-0.45, 0.45, 80), np.linspace(-0.25, 0.25, 50)))
    holes = [through(a, b) for a, b in zip(x.tolist(), y.tolist(), strict=True)]

    assert len(taken(part("skin", *holes)).entries) == 4000


def test_drilled_plate_of_triangles_is_a_skin_for_its_holes() -> None:
    made = drilled(plate(0.5, 0.4, (-THICKNESS, 0.0)), [at(0.0), at(0.05)], [UP, UP], 0.00205)
    shape = body(made, "skin", [through(0.0), through(0.05)])

    found = from_holes([shape], MeshSkin([shape]), Mapping.model_validate(MAPPING))

    assert [entry["p_mm"] for entry in found.entries] == [[0.0, 0.0, 0.0], [50.0, 0.0, 0.0]]
