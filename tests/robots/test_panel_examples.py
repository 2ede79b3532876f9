import runpy
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from robots.panel import Panel
from robots.panel_file import load_panel
from tests.robots.panels import assert_sound, inside

EXAMPLES = Path(__file__).parents[2] / "openapi" / "examples"
NAMES = ("a320_shell", "crossing", "crossing_holes", "wing", "fuselage", "cockpit")


@pytest.fixture(scope="module")
def panels() -> dict[str, Panel]:
    return {name: load_panel(EXAMPLES / f"{name}.json") for name in NAMES}


def test_generator_reproduces_the_committed_files() -> None:
    made = runpy.run_path(str(EXAMPLES / "make_panels.py"))

    for name in NAMES:
        assert made["text"](made[name]()) == (EXAMPLES / f"{name}.json").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_every_piece_is_a_convex_hexahedron_with_planar_faces(panels: dict[str, Panel], name: str) -> None:
    assert_sound(panels[name].pieces()[0])


@pytest.mark.parametrize("name", NAMES)
def test_every_fastener_joins_the_skin_and_its_member(panels: dict[str, Panel], name: str) -> None:
    panel = panels[name]

    for fastener, stack in zip(panel.fasteners, panel.stacks, strict=True):
        assert stack.parts == ("skin", fastener.member)
        assert fastener.grip == stack.grip
        assert stack.depth >= stack.grip - 1e-6
        assert stack.depth <= stack.grip + panel.chord_deviation + 0.2e-3
        assert np.linalg.norm(fastener.n) == pytest.approx(1.0)
        assert fastener.n[2] > 0.0


@pytest.mark.parametrize("name", NAMES)
def test_die_tip_finds_the_inner_surface_at_the_stack_depth(panels: dict[str, Panel], name: str) -> None:
    panel = panels[name]
    pieces, _ = panel.pieces()

    for i in np.random.default_rng(5).integers(0, len(panel.fasteners), 12):
        p, n, depth = panel.fasteners[i].p, panel.fasteners[i].n, panel.stacks[i].depth
        assert inside(pieces, p - (depth - 1e-6) * n)
        assert not inside(pieces, p - (depth + 1e-6) * n)


@pytest.mark.parametrize("name", NAMES)
def test_chords_keep_within_a_sixth_of_a_millimetre(panels: dict[str, Panel], name: str) -> None:
    assert 0.0 < panels[name].chord_deviation < 0.17e-3


def test_shell_is_the_default_panel(panels: dict[str, Panel]) -> None:
    shell = panels["a320_shell"]
    kinds = Counter(part.kind for part in shell.parts)
    rows = Counter((fastener.row or "")[:2] for fastener in shell.fasteners)

    assert kinds == {"skin": 1, "stringer": 13, "frame": 9, "clip": 108, "doubler": 1, "strap": 2, "box": 1}
    assert rows == {"SR": 13 * 204, "KR": 540, "DR": 20, "TR": 10}
    assert 3000 <= len(shell.fasteners) <= 3500
    assert np.allclose(np.ptp(shell.part("skin").pieces[..., 0]), 4.5672)
    assert shell.surface.section_radius == 1.975
    width = np.ptp(shell.surface.locate(shell.part("skin").pieces)[1])
    assert np.degrees(width / 1.975) == pytest.approx(71.95, abs=0.01)


def test_frames_of_the_shell_stand_midway_between_two_rivets(panels: dict[str, Panel]) -> None:
    shell = panels["a320_shell"]
    x = np.array([fastener.p[0] for fastener in shell.fasteners if fastener.row == "SR"])

    for k in range(9):
        web = shell.part(f"F{k + 1}").pieces
        middle = 0.5334 * (k - 4)
        near = np.unique(np.round(x[np.abs(x - middle) < 0.0223] - middle, 9))
        assert np.allclose(near, [-0.5334 / 48, 0.5334 / 48])
        assert web[..., 0].min() == pytest.approx(middle - 0.0009)


def test_frames_of_the_shell_float_over_the_stringers(panels: dict[str, Panel]) -> None:
    shell = panels["a320_shell"]

    for kind, shallowest, deepest in (("stringer", 0.0016, 0.0317), ("frame", 0.0376, 0.1376)):
        for part in (part for part in shell.parts if part.kind == kind):
            _, _, depth = shell.surface.locate(part.pieces)
            assert depth.min() >= shallowest - 0.12e-3
            assert depth.max() <= deepest + 1e-4


def test_shell_is_riveted_forward_and_back(panels: dict[str, Panel]) -> None:
    """Along the stringers no step is longer than that from one stringer to the next."""
    points = np.array([f.p for f in panels["a320_shell"].fasteners if f.row == "SR"])

    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)

    assert steps.max() < 0.1905


def test_crossing_is_cut_from_the_shell(panels: dict[str, Panel]) -> None:
    crossing = panels["crossing"]

    assert len(crossing.fasteners) == 12
    x = sorted(1000.0 * f.p[0] for f in crossing.fasteners if f.row == "SR")
    assert np.allclose(x, [22.225 * (k - 3.5) for k in range(8)])


@pytest.mark.parametrize(
    ("name", "rows", "count", "length", "width", "thickness"),
    [
        ("wing", 4, 29, 650.0, 567.0, 1.7),
        ("fuselage", 3, 88, 2180.0, 1130.0, 2.0),
        ("cockpit", 3, 54, 1370.0, 1242.6, 2.0),
    ],
)
def test_thesis_panels_have_their_printed_sizes_and_counts(
    panels: dict[str, Panel], name: str, rows: int, count: int, length: float, width: float, thickness: float
) -> None:
    panel = panels[name]
    u, v, depth = panel.surface.locate(panel.part("skin").pieces)

    assert Counter(fastener.member for fastener in panel.fasteners) == {
        f"S{i + 1}": count for i in range(rows)
    }
    assert 1000.0 * np.ptp(u) == pytest.approx(length)
    assert 1000.0 * np.ptp(v) == pytest.approx(width)
    assert 1000.0 * depth.max() == pytest.approx(thickness)


def test_number_of_obstacles_is_that_of_the_thesis(panels: dict[str, Panel]) -> None:
    members = {
        name: sum(
            part.kind in ("stringer", "frame", "box", "extrusion", "strap") for part in panels[name].parts
        )
        for name in ("wing", "fuselage", "cockpit")
    }

    assert members == {"wing": 6, "fuselage": 10, "cockpit": 9}
