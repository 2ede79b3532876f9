"""A die from a profile is the die that the profile is a section of."""

import json

import pytest

from robots.die_import.mesh_die import DieRoles, die_from_mesh
from robots.die_import.profile import profile_body
from robots.errors import InvalidInput

TURNED: dict[str, object] = {"unit": "mm", "profile_rz": [[7, 0], [7, -45], [30, -45], [30, -250]]}
SWEPT: dict[str, object] = {
    "unit": "mm",
    "profile_xz": [[-7, -4], [31, -4], [31, -250], [9, -250], [9, -22], [-7, -12]],
    "y": [-7, 7],
    "tip_radius": 7,
}


def _text(document: dict[str, object], **changes: object) -> bytes:
    return json.dumps(document | changes).encode()


def test_a_turned_profile_is_axisymmetric() -> None:
    die = die_from_mesh(profile_body(_text(TURNED)), DieRoles("mine"))
    shapes = [solid["shape"] for solid in die.entry["solids"]]
    assert die.entry["axisymmetric"]
    assert [shape["radius_mm"] for shape in shapes] == pytest.approx([7.0, 30.0], abs=0.01)
    assert [shape["radius_mm"] >= true for shape, true in zip(shapes, (7.0, 30.0), strict=True)] == [True] * 2


@pytest.mark.long
def test_a_cone_is_enclosed_in_as_many_discs_as_the_excess_asks_for() -> None:
    cone = _text(TURNED, profile_rz=[[7, 0], [7, -20], [9, -60], [9, -250]])
    counts = [
        len(die_from_mesh(profile_body(cone), DieRoles("mine", excess=excess)).entry["solids"])
        for excess in (0.5e-3, 1e-3, 3e-3)
    ]
    assert counts[0] > counts[1] > counts[2]


def test_a_swept_profile_may_be_a_hook_with_a_round_tip() -> None:
    die = die_from_mesh(profile_body(_text(SWEPT)), DieRoles("mine"))
    assert not die.entry["axisymmetric"]
    assert die.entry["solids"][0]["shape"]["type"] == "cylinder"
    assert {solid["shape"]["type"] for solid in die.entry["solids"][1:]} == {"prism"}


@pytest.mark.parametrize(
    ("document", "place"),
    [
        (_text(TURNED, y=[0, 1]), ""),
        (_text(SWEPT, y=None), ""),
        (_text(SWEPT, y=[7, -7]), "/y"),
        (_text(TURNED, unit="furlong"), "/unit"),
        (_text(TURNED, profile_rz=[[7, 0], [-7, -45], [30, -250]]), "/profile_rz"),
        (_text(SWEPT, profile_xz=[[0, -4], [10, -14], [10, -4], [0, -14]]), "/profile_xz"),
        (_text(SWEPT, profile_xz=[[-7, 0], [7, 0], [7, -250], [-7, -250]]), "/profile_xz"),
    ],
)
def test_what_is_no_profile_is_refused_at_its_place(document: bytes, place: str) -> None:
    with pytest.raises(InvalidInput) as refused:
        profile_body(document)
    assert [problem.pointer for problem in refused.value.problems] == [place]
