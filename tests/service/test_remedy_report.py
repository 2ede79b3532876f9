"""Remedies in a report: words, numbers, and changes of the input documents."""

import math

import pytest

from robots.access.remedy import Remedies, Remedy, RemedyKind, Tried
from robots.access.remedy_edits import AddDie, Adjust, Edit, ShiftClip, UseDie
from robots.cell import Blockage
from tests.service.test_access_report import reported

EDITS: dict[RemedyKind, tuple[str, str, float, Edit, str]] = {
    "other_die": (
        "offset35",
        "",
        0.0,
        UseDie("offset35", ("rows", 0, "die")),
        "use die offset35: reached at",
    ),
    "tilt": (
        "F1",
        "+arc",
        math.radians(0.25),
        Adjust("F1", tilt_arc_deg=0.25),
        "tilt the axis of F1 by 0.25 deg towards +arc: reached with die j20 at",
    ),
    "move_fastener": (
        "F1",
        "-x",
        0.0032,
        Adjust("F1", x_mm=-3.2),
        "move F1 by 3.2 mm towards -x: reached with die j20 at",
    ),
    "shift_clip": (
        "K1",
        "+arc",
        0.004,
        ShiftClip("K1", -91.0),
        "shift clip K1 by 4 mm towards +arc: reached with die j20 at",
    ),
    "lower_die": (
        "j20",
        "",
        0.002,
        AddDie({"id": "low"}),
        "make die j20 2 mm lower under its tip: reached at",
    ),
    "narrower_die": (
        "j20.neck",
        "",
        0.0015,
        AddDie({"id": "thin"}, ("fasteners", 3, "die")),
        "make j20.neck 1.5 mm narrower: reached at",
    ),
}


@pytest.mark.parametrize("kind", EDITS)
def test_a_remedy_is_told_in_words_and_numbers_and_as_a_change_of_the_inputs(kind: RemedyKind) -> None:
    subject, direction, amount, edit, words = EDITS[kind]
    gap = Blockage("neck", "S1", 0.00123456, 0.00105)
    remedy = Remedy(kind, subject, direction, amount, "j20", math.radians(-70.0), gap, edit)
    tried = Tried(kind, (subject,), amount, 1)

    told = reported((), Remedies("F1", (remedy,), (tried,))).remedies

    assert told is not None
    (found,), (looked,) = told.found, told.tried
    assert found.text == f"{words} -70 deg; then neck and S1 are 1.23 mm apart, 1.05 mm are needed"
    assert (found.clearance_mm, found.needs_mm, found.angle_deg) == (1.2345, 1.05, -70.0)
    assert (looked.kind, looked.subjects, looked.found, looked.skipped) == (kind, [subject], 1, "")
    for one in (found.amount_mm, looked.limit_mm):
        assert one == (None if kind in ("other_die", "tilt") else pytest.approx(1e3 * amount))
    for one in (found.amount_deg, looked.limit_deg):
        assert one == (0.25 if kind == "tilt" else None)
    assert found.edit.model_dump(exclude_none=True) == TOLD[kind]


TOLD: dict[RemedyKind, dict[str, object]] = {
    "other_die": {"die": "offset35", "unbind": "/rows/0/die"},
    "tilt": {"adjustment": {"fastener": "F1", "tilt_arc_deg": 0.25}},
    "move_fastener": {"adjustment": {"fastener": "F1", "x_mm": -3.2}},
    "shift_clip": {"clip": "K1", "arc_mm": -91.0},
    "lower_die": {"new_die": {"id": "low"}},
    "narrower_die": {"new_die": {"id": "thin"}, "unbind": "/fasteners/3/die"},
}


def test_remedies_are_not_told_of_fasteners_for_which_they_were_not_searched() -> None:
    assert reported(()).remedies is None
    assert reported((), Remedies("F1", (), ())).remedies is not None
