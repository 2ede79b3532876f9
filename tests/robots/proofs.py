"""Geometry for the tests of `robots.proof`: random panels and motions, and an oracle of coal and formulas.

Nothing of the oracle is the verifier's: poses come from the machine's formula, distances from coal.
"""

from functools import cache

import coal
import numpy as np

from planners.arrays import Array
from robots.hexahedra import HEX_TRIANGLES, box
from robots.machine_file import load_machine
from robots.panel import Panel, Part
from robots.proof.examine import examine
from robots.proof.layout import Blocks, Found, Scene
from robots.solids import Box, Cylinder, Shape, Solid, shape_vertices
from robots.surface import Surface
from robots.verify_kinematics import Kinematics
from robots.verify_obstacles import Obstacles
from robots.verify_scene import Task, scene_of

MACHINE = load_machine("riveter")
CAP = 0.05
"""[m] Distances are told apart up to this."""


def turns(rng: np.random.Generator, n: int) -> Array:
    """Random rotations (n, 3, 3)."""
    q = rng.normal(size=(n, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def plates(rng: np.random.Generator, n: int, longest: float = 0.5) -> Array:
    """Convex hexahedra (n, 8, 3) around the origin: from 1.6 mm sheets to thick blocks, some tapered."""
    half = 0.5 * np.exp(rng.uniform(np.log(0.0016), np.log(longest), (n, 3)))
    vertices = box(-half, half)
    taper = 1.0 - 0.4 * rng.random((n, 1, 1)) * (vertices[:, :, 2:] > 0.0)
    vertices[:, :, :2] *= taper  # a frustum: its side faces stay flat
    return vertices


def panel_of(vertices: Array) -> Panel:
    """A panel with one part for each piece (H, 8, 3)."""
    parts = tuple(Part(f"P{i}", "box", vertices[i : i + 1]) for i in range(len(vertices)))
    return Panel("random", "", Surface(), parts, (), (), np.eye(4), 0.0, 0.0, "00" * 32)


@cache
def random_panel(seed: int, pieces: int = 60) -> Panel:
    """Thin plates and blocks, slightly turned, spread where the die works under the panel's origin."""
    rng = np.random.default_rng(seed)
    vertices = plates(rng, pieces, 0.2)
    angle = rng.uniform(-0.3, 0.3, pieces)
    c, s, o = np.cos(angle), np.sin(angle), np.zeros(pieces)
    R = np.array([[c, -s, o], [s, c, o], [o, o, o + 1.0]]).transpose(2, 0, 1)
    places = rng.uniform([-0.4, -0.4, -0.35], [0.4, 0.4, 0.0], (pieces, 1, 3))
    return panel_of(vertices @ R.transpose(0, 2, 1) + places)


def random_motions(seed: int, n: int) -> tuple[Array, Array]:
    """Start and delta (n, 7) around the datum: short and long, some turning the panel, some the die."""
    rng = np.random.default_rng(seed)
    middle = np.array([6.25, 0.0, 0.0, 0.0, 0.0, 0.15, 0.0])
    spread = np.array([0.3, 0.3, 0.05, 0.1, 0.1, 0.15, 3.0])
    start = middle + spread * rng.uniform(-1.0, 1.0, (n, 7))
    delta = spread * rng.uniform(-1.0, 1.0, (n, 7)) * (rng.random((n, 7)) < 0.5)
    delta *= 10.0 ** rng.uniform(-2.0, 0.3, (n, 1))
    return start, delta


def blocks_of(start: Array, delta: Array) -> Blocks:
    """Motions of the first assembly with no fastener near and nothing to touch."""
    anchors, what = np.full((len(start), 2, 3), np.nan), np.zeros((len(start) + 1, 3), dtype=np.int64)
    return Blocks(start, delta, np.zeros_like(delta), anchors, what, np.zeros(0, dtype=np.int64))


def scene_with(panel: Panel, *tasks: Task) -> Scene:
    """One assembly with these tasks."""
    kinematics = Kinematics.from_panel(MACHINE, panel.mounting)
    return scene_of(MACHINE, Obstacles.of(panel), kinematics, [tasks])[0]


def against_panel(solid: Solid, need: float = 0.002) -> Task:
    return Task(solid, None, True, False, (need, need))


def link_poses(q: Array, link: str) -> tuple[Array, Array]:
    """R (N, 3, 3), t (N, 3) of T_panel_link by the machine's formula, without mounting; q (N, 7)."""
    X, Y, Z, A, B, W, C = q.T
    o, i = np.zeros(len(q)), np.ones(len(q))
    Rx = np.array([[i, o, o], [o, np.cos(A), -np.sin(A)], [o, np.sin(A), np.cos(A)]])
    Ry = np.array([[np.cos(B), o, np.sin(B)], [o, i, o], [-np.sin(B), o, np.cos(B)]])
    Rz = np.array([[np.cos(C), -np.sin(C), o], [np.sin(C), np.cos(C), o], [o, o, i]])
    R_panel = np.einsum("ijn,jkn->nik", Rx, Ry)
    rise = o if link == "X" else W - 0.340
    t = np.column_stack([X - 6.25, -Y, rise - Z])
    R = R_panel.transpose(0, 2, 1)
    return (R @ Rz.transpose(2, 0, 1) if link == "C" else R), np.einsum("nij,nj->ni", R, t)


def to_coal(shape: Shape) -> coal.CollisionGeometry:
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.length)
    if isinstance(shape, Box):
        return coal.Box(*shape.size)
    k = len(shape.profile)
    fan = [(0, i, i + 1) for i in range(1, k - 1)]
    ends = [t for a, b, c in fan for t in ((a, b, c), (k + a, k + c, k + b))]
    sides = [t for i in range(k) for t in ((i, (i + 1) % k, k + i), ((i + 1) % k, k + (i + 1) % k, k + i))]
    return convex(shape_vertices(shape), np.array(ends + sides))


def convex(vertices: Array, triangles: np.ndarray) -> coal.CollisionGeometry:
    points, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    points.extend(list(vertices))
    faces.extend([coal.Triangle(*(int(i) for i in t)) for t in triangles])
    return coal.Convex(points, faces)


def hexahedron(vertices: Array) -> coal.CollisionGeometry:
    return convex(vertices, HEX_TRIANGLES)


def true_distance(first: coal.CollisionGeometry, R: Array, t: Array, second: coal.CollisionGeometry) -> float:
    """Distance by coal, solved far below its default tolerance; the second stands at the origin."""
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.gjk_tolerance, request.gjk_max_iterations = 1e-10, 2000
    here, there = coal.Transform3s(R, t), coal.Transform3s.Identity()
    return float(coal.distance(first, here, second, there, request, result))


def sampled_clearance(panel: Panel, solid: Solid, q: Array) -> tuple[float, float]:
    """Smallest distance of a solid from the panel over configurations q (N, 7), at most CAP, and how far a
    point of the solid moves between two of them, at most [m].
    """
    R, t = link_poses(q, solid.link)
    T = solid.T_link_solid
    R_solid, t_solid = R @ T[:3, :3], np.einsum("nij,j->ni", R, T[:3, 3]) + t
    shape = solid.shape
    if isinstance(shape, Cylinder):
        half = np.array([shape.radius, shape.radius, shape.length / 2.0])
        corners = box(-half, half)
    else:
        corners = shape_vertices(shape)
    cloud = np.einsum("nij,kj->nki", R_solid, corners) + t_solid[:, None, :]
    low, high = cloud.min(axis=1), cloud.max(axis=1)
    pieces, _ = panel.pieces()
    apart = np.maximum(low[:, None] - pieces.max(axis=1), pieces.min(axis=1) - high[:, None]).max(axis=2)
    mover, found = to_coal(shape), CAP
    for piece in np.flatnonzero((apart < CAP).any(axis=0)):
        other = hexahedron(pieces[piece])
        for k in np.flatnonzero(apart[:, piece] < CAP):
            found = min(found, max(0.0, true_distance(mover, R_solid[k], t_solid[k], other)))
    steps = np.linalg.norm(np.diff(cloud, axis=0), axis=2)
    return found, float(steps.max(initial=0.0))


def examined(scene: Scene, start: Array, delta: Array, most: int = 1000) -> Found:
    return examine(scene, blocks_of(start, delta), np.arange(len(start)), CAP, most)


def web(y: float) -> Panel:
    """A stringer's web, 1.6 mm thick, that begins `y` [m] from the panel's middle line."""
    return panel_of(box(np.array([[-0.5, y, -0.4]]), np.array([[0.5, y + 0.0016, -0.05]])))


TIP = MACHINE.dies["straight"].solids[0]
RADIUS = 0.007
FLAT = np.array([6.25, 0.0, 0.0, 0.0, 0.0, 0.2, 0.0])


ASIDE = 0.3
"""[m] How far from the axis the panel turns about the tip passes a web; there it comes nearest on the way."""


def web_aside() -> Panel:
    return panel_of(
        box(np.array([[-0.5, ASIDE + RADIUS, -0.03]]), np.array([[0.5, ASIDE + RADIUS + 0.0016, -0.02]]))
    )


def turns_beside(gap: Array, turn: Array) -> Array:
    """Configurations with the tip `gap` from the web, if the panel were not turned by `turn`, each (n,)."""
    q = np.tile(FLAT, (len(turn), 1))
    q[:, 1], q[:, 3], q[:, 5] = gap - ASIDE, turn, 0.34
    return q
