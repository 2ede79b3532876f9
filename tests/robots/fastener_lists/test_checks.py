"""What fasteners have against each other and against their skin."""

import numpy as np
import pytest

from robots.fastener_lists.reading import read_fasteners
from robots.fastener_lists.skin import SurfaceSkin
from robots.fastener_lists.writing import csv_of
from robots.surface import Surface
from tests.robots.fastener_lists.samples import (
    CURVED,
    FLAT,
    HEADER,
    THICKNESS,
    curved_points,
    found,
    lines,
    problems,
    read,
)

UP = "0,0,1"


def row(name: str, x: float, y: float = 0.0, z: float = 0.0, normal: str = UP, diameter: float = 4.0) -> str:
    return f"{name},{x!r},{y!r},{z!r},{normal},{diameter!r},solid_rivet"


def test_ids_are_given_once() -> None:
    text = lines(row("A", 0), row("B", 20), row("A", 40), row("A", 60))

    assert found(text) == [("/rows/4/id", "duplicate_id"), ("/rows/5/id", "duplicate_id")]


def test_ids_are_compared_in_rows_with_other_problems_too() -> None:
    assert found(lines(row("A", 0), "A,x,0,0,0,0,1,4,slug")) == [
        ("/rows/3/x", "not_a_number"),
        ("/rows/3/id", "duplicate_id"),
    ]


@pytest.mark.parametrize(
    ("apart", "codes"),
    [
        (0.0, ["duplicate_place"]),
        (0.1, ["duplicate_place"]),
        (0.11, ["fasteners_overlap"]),
        (3.99, ["fasteners_overlap"]),
        (4.0, []),
    ],
)
def test_fasteners_have_places_of_their_own(apart: float, codes: list[str]) -> None:
    text = lines(row("A", 0), row("B", apart))

    if codes:
        assert found(text) == [("/rows/3", code) for code in codes]
    else:
        assert len(read(text).entries) == 2


def test_fasteners_of_two_diameters_meet_at_half_of_both() -> None:
    assert found(lines(row("A", 0), row("B", 4.9, diameter=6.0))) == [("/rows/3", "fasteners_overlap")]
    assert len(read(lines(row("A", 0), row("B", 5.0, diameter=6.0))).entries) == 2


def test_overlaps_are_those_of_brute_force() -> None:
    rng = np.random.default_rng(7)
    points, sizes = rng.uniform(-60.0, 60.0, (150, 2)).round(2), rng.choice([3.0, 4.0, 6.0], 150)
    text = lines(
        *(
            row(f"F{i}", x, y, diameter=d)
            for i, ((x, y), d) in enumerate(zip(points.tolist(), sizes.tolist(), strict=True))
        )
    )

    told = [(each.pointer, each.code) for each in problems(text)]

    expected = [
        (f"/rows/{j + 2}", "duplicate_place" if apart <= 0.1 else "fasteners_overlap")
        for j in range(150)
        for i in range(j)
        if (apart := float(np.hypot(*(points[i] - points[j])))) < 0.5 * (sizes[i] + sizes[j])
    ]
    assert told == expected
    assert len(told) > 10


@pytest.mark.parametrize(
    ("z", "code"),
    [
        (0.5, None),
        (0.51, "off_skin"),
        (-0.5, None),
        (-0.51, "off_skin"),
        (-1.6, "wrong_side"),
        (-1.2, "wrong_side"),
        (-3.0, "off_skin"),
    ],
)
def test_points_are_on_the_outer_face(z: float, code: str | None) -> None:
    text = lines(row("A", 0, z=z))

    assert ([] if code is None else [("/rows/2", code)]) == ([] if code is None else found(text))
    assert code is not None or read(text).entries


def test_points_are_within_the_outline() -> None:
    assert len(read(lines(row("A", 500.4))).entries) == 1
    assert found(lines(row("A", 501.0))) == [("/rows/2", "off_skin")]


@pytest.mark.parametrize(
    ("degrees", "code"), [(1.99, None), (2.01, "off_normal"), (90.1, "wrong_side"), (180.0, "wrong_side")]
)
def test_normals_are_those_of_the_skin(degrees: float, code: str | None) -> None:
    turn = np.radians(degrees)
    text = lines(row("A", 0, normal=f"0,{np.sin(turn):.9f},{np.cos(turn):.9f}"))

    assert code is None or found(text) == [("/rows/2", code)]
    assert code is not None or read(text).entries


def test_remedy_of_a_wrong_normal_is_the_right_one() -> None:
    (problem,) = problems(lines(row("A", 0, 200.0, -10.1528, normal="0,0,1")), CURVED)

    y, z = (float(c) for c in problem.remedy.removeprefix("There it is ").split(";")[0].split(", ")[1:])
    assert (y, z) == pytest.approx((200.0 / 1975.0, np.sqrt(1.0 - (200.0 / 1975.0) ** 2)), abs=1e-5)


def test_off_skin_lists_are_told_the_unit_that_would_fit() -> None:
    points, _ = curved_points(12)
    rows = [row(f"F{i}", x, y, z, normal=",,") for i, (x, y, z) in enumerate((points / 25.4).tolist())]

    told = [each for each in problems(lines(*rows), CURVED) if each.code == "off_skin"]

    assert told
    assert all(each.remedy.startswith("The list fits the skin when its unit is inch") for each in told)


@pytest.mark.parametrize(
    ("order", "names"), [([1, 0, 2], "x and y"), ([0, 2, 1], "y and z"), ([2, 1, 0], "x and z")]
)
def test_off_skin_lists_are_told_swapped_columns(order: list[int], names: str) -> None:
    points, _ = curved_points(12)
    rows = [row(f"F{i}", x, y, z, normal=",,") for i, (x, y, z) in enumerate(points[:, order].tolist())]

    told = [each for each in problems(lines(*rows), CURVED) if each.code == "off_skin"]

    assert len(told) > 6
    assert all(each.remedy == f"The list fits the skin when {names} change places." for each in told)


def test_single_point_off_the_skin_is_told_no_fancy() -> None:
    points, _ = curved_points(12)
    rows = [row(f"F{i}", x, y, z, normal=",,") for i, (x, y, z) in enumerate(points.tolist())]

    (problem,) = problems(lines(*rows, row("Z", 20, 0, 1)), CURVED)

    assert (problem.pointer, problem.remedy) == (
        "/rows/14",
        "Give points of the skin's outer face, in the panel's frame.",
    )


def test_list_that_also_fits_in_another_unit_says_so() -> None:
    result = read(lines(row("A", 0), row("B", 15.0, 5.0)))

    assert "every point would be on the skin in inch, too" in result.told
    assert "every point would be on the skin in m, too" not in result.told


def test_normals_left_out_are_those_of_the_skin() -> None:
    points, normals = curved_points(9)
    rows = [row(f"F{i}", x, y, z, normal=",,") for i, (x, y, z) in enumerate(points.tolist())]

    result = read(lines(*rows), CURVED)

    np.testing.assert_allclose([entry["n"] for entry in result.entries], normals, atol=1e-9)
    assert "9 normals are taken from the skin, at most 0 degrees off" in result.told


def test_parametric_skin_tells_thickness_and_distance() -> None:
    skin = SurfaceSkin(Surface(1.5, 3.0), 1.0, 0.8, THICKNESS)
    p = skin.surface.at(np.array([0.1, -0.4]), np.array([0.3, 0.0]), np.array([0.0, -0.002]))

    on = skin.outer_point(p)

    np.testing.assert_allclose(on.distances, [0.0, 0.002], atol=1e-12)
    np.testing.assert_allclose(skin.inner_distances(p), [THICKNESS, THICKNESS + 0.002], atol=1e-12)
    assert skin.normal_error == 0.0


def test_whole_panel_of_fasteners_is_read() -> None:
    u, v = (
        each.ravel() for each in np.meshgrid(np.linspace(-0.48, 0.48, 200), np.linspace(-0.38, 0.38, 100))
    )
    entries = [
        {
            "id": f"F{i}",
            "p_mm": (1000.0 * p).tolist(),
            "n": n.tolist(),
            "diameter_mm": 3.0,
            "grip_mm": 3.2,
            "process": "slug",
        }
        for i, (p, n) in enumerate(zip(CURVED.surface.point(u, v), CURVED.surface.normal(u, v), strict=True))
    ]

    assert len(read_fasteners(csv_of(entries), "all.csv", None, CURVED).entries) == 20_000


def test_header_of_samples_is_on_the_flat_skin() -> None:
    assert read(lines(row("A", 0), header=HEADER), FLAT).entries[0]["n"] == [0.0, 0.0, 1.0]


def test_point_near_both_faces_of_a_thin_skin_is_on_the_nearer_one() -> None:
    thin = SurfaceSkin(Surface(), 1.0, 0.6, 0.0004)

    assert len(read(lines(row("A", 0, z=0.09), row("B", 20, z=-0.19)), thin).entries) == 2
    assert found(lines(row("A", 0, z=-0.21)), thin) == [("/rows/2", "wrong_side")]


def test_points_that_any_smaller_unit_brings_onto_the_skin_are_told_none() -> None:
    text = lines(
        *(row(f"F{i}", 0.02 * i, 0.03 * i, 0.005) for i in range(3)), header=HEADER.replace("_mm", "_m", 3)
    )

    assert {each.remedy for each in problems(text)} == {
        "Give points of the skin's outer face, in the panel's frame."
    }


def test_list_that_is_right_but_for_one_point_is_told_no_swap() -> None:
    text = lines(*(row(f"F{i}", 20.0 * i, 10.0 * i) for i in range(12)), row("Z", -50.0, z=1.0))

    assert [each.remedy for each in problems(text)] == [
        "Give points of the skin's outer face, in the panel's frame."
    ]
