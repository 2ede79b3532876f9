import pickle

import numpy as np
import pytest

from robots import hexahedra
from robots.panel import Fastener, Panel, Part, Stack
from robots.panel_file import load_panel
from robots.surface import Surface
from tests.robots.panels import small_panel


@pytest.fixture(scope="module")
def panel() -> Panel:
    return load_panel(small_panel())


def test_triangles_enclose_the_volume_of_the_pieces(panel: Panel) -> None:
    vertices, triangles, part_index = panel.triangles()
    pieces, piece_part = panel.pieces()
    corners = vertices[triangles]
    six_volumes = np.einsum("tk,tk->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))

    for i in range(len(panel.parts)):
        by_pieces = hexahedra.volumes(pieces[piece_part == i]).sum()
        assert six_volumes[part_index == i].sum() / 6.0 == pytest.approx(by_pieces, rel=1e-9)


def test_pieces_and_triangles_come_part_by_part(panel: Panel) -> None:
    pieces, piece_part = panel.pieces()
    _, triangles, triangle_part = panel.triangles()

    assert np.array_equal(triangle_part, np.repeat(piece_part, 12))
    assert len(triangles) == 12 * len(pieces)
    for i, part in enumerate(panel.parts):
        assert np.array_equal(pieces[piece_part == i], part.pieces)


def test_bounds_hold_every_vertex(panel: Panel) -> None:
    lower, upper = panel.bounds
    vertices, _, _ = panel.triangles()

    assert np.allclose(lower, vertices.min(axis=0))
    assert np.allclose(upper, vertices.max(axis=0))
    assert upper[2] == 0.0


def test_parts_are_found_by_id_and_others_named(panel: Panel) -> None:
    assert panel.part("K1").kind == "clip"
    with pytest.raises(KeyError, match="the panel has skin, S1, F1, K1"):
        panel.part("K2")


def test_arrays_are_read_only_also_after_pickling(panel: Panel) -> None:
    copy = pickle.loads(pickle.dumps(panel))

    for one in (panel, copy):
        arrays = [one.mounting, one.parts[0].pieces, one.fasteners[0].p, one.fasteners[0].n, one.pieces()[0]]
        assert not any(array.flags.writeable for array in arrays)
    assert copy.sha256 == panel.sha256
    assert np.array_equal(copy.pieces()[0], panel.pieces()[0])
    assert copy.stacks == panel.stacks


def test_parts_without_pieces_are_refused() -> None:
    with pytest.raises(ValueError, match="part X: pieces must have shape"):
        Part("X", "box", np.zeros((0, 8, 3)))


def test_every_fastener_needs_its_stack() -> None:
    fastener = Fastener("f", np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.004, 0.0032, "solid_rivet")

    with pytest.raises(ValueError, match="1 fasteners but 2 stacks"):
        Panel("p", "", Surface(), (), (fastener,), (Stack((), 0.0, 0.0),) * 2, np.eye(4), 0.0, 0.0, "")
