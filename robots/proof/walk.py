"""The direction in which two convex bodies are farthest apart.

Gilbert, Johnson, Keerthi 1988: walk towards the origin in the Minkowski difference B - A on simplices of up
to four support points. The nearest point v of the simplex gives the direction d = v/|v|; gap(d) bounds the
distance from below, |v| from above; the walk ends when they meet. The newest point of a simplex always
carries its nearest point, so only the corners, edges, faces and the inside that have it are tried, all of
them: the nearest valid one is taken, which needs no case tree.

A wrong step can only cost sharpness: what counts as proof is gap(d), evaluated with the support functions.
"""

from __future__ import annotations

import math

from planners.arrays import Array
from robots.proof.bodies import difference
from robots.proof.layout import Pair
from robots.proof.uncounted import uncounted

TOLERANCE = 1e-7
"""[m] How near the bracket on the distance is closed."""
OVERLAP = 1e-9
"""[m] Nearest points this close are rounding: the bodies overlap."""
ROUNDS = 60
_FLAT = 1e-12  # relative size below which a face or tetrahedron of the simplex is taken as degenerate
_AT_ORIGIN = 1e-12  # [m]

Step = tuple[int, float, float, float]


@uncounted
def walk(
    solids: Array, pieces: Array, pair: Pair, P: Array, at: int, dx: float, dy: float, dz: float, S: Array
) -> tuple[float, float, float, float, float]:
    """Close the bracket on the distance of a placed pair: direction, lower, upper [m].

    d: a unit direction to begin with. S (4, 3): work space. Of bodies that overlap, upper is 0 and lower the
    best (negative) gap seen on the way. The bracket may stay open, never the wrong way round.
    """
    x, y, z = difference(solids, pieces, pair, P, at, dx, dy, dz)
    lower, upper = dx * x + dy * y + dz * z, math.inf
    S[0, 0], S[0, 1], S[0, 2] = x, y, z
    n = 1
    for _ in range(ROUNDS):
        length = math.sqrt(x * x + y * y + z * z)
        if not length < upper:
            break
        upper = length
        if upper - lower <= TOLERANCE or length <= _AT_ORIGIN:
            break
        ux, uy, uz = x / length, y / length, z / length
        px, py, pz = difference(solids, pieces, pair, P, at, ux, uy, uz)
        found = ux * px + uy * py + uz * pz
        if found > lower:
            lower, dx, dy, dz = found, ux, uy, uz
        if upper - lower <= TOLERANCE:
            break
        S[n, 0], S[n, 1], S[n, 2] = px, py, pz
        n, x, y, z = nearest(S, n + 1)
    return dx, dy, dz, lower, upper


@uncounted
def nearest(S: Array, n: int) -> Step:
    """Nearest point to the origin of the first n corners of S, among what the last of them carries.

    Leaves the corners that carry it in front; returns how many, and the point.
    """
    p = n - 1
    px, py, pz = S[p, 0], S[p, 1], S[p, 2]
    best, i, j = px * px + py * py + pz * pz, p, p
    x, y, z = px, py, pz
    for a in range(p):
        u, v, w, square = _on_edge(S, p, a)
        if square < best:
            best, i, j, x, y, z = square, a, p, u, v, w
    for a in range(p - 1):
        for b in range(a + 1, p):
            u, v, w, square = _on_face(S, p, a, b)
            if square < best:
                best, i, j, x, y, z = square, a, b, u, v, w
    if n == 4 and _inside(S):
        return 4, 0.0, 0.0, 0.0
    return _kept(S, i, j, p), x, y, z


@uncounted
def _kept(S: Array, i: int, j: int, p: int) -> int:
    """Move corners i < j to the front, those that are not p itself, and then p; how many."""
    n = 0
    for k in (i, j):
        if k < p:
            S[n, 0], S[n, 1], S[n, 2] = S[k, 0], S[k, 1], S[k, 2]
            n += 1
    S[n, 0], S[n, 1], S[n, 2] = S[p, 0], S[p, 1], S[p, 2]
    return n + 1


@uncounted
def _on_edge(S: Array, p: int, a: int) -> tuple[float, float, float, float]:
    """Foot of the origin on an edge, and its square; infinite where it is beyond the ends."""
    px, py, pz = S[p, 0], S[p, 1], S[p, 2]
    ex, ey, ez = S[a, 0] - px, S[a, 1] - py, S[a, 2] - pz
    along, whole = -(px * ex + py * ey + pz * ez), ex * ex + ey * ey + ez * ez
    if not 0.0 < along < whole:
        return 0.0, 0.0, 0.0, math.inf
    u = along / whole
    x, y, z = px + u * ex, py + u * ey, pz + u * ez
    return x, y, z, x * x + y * y + z * z


@uncounted
def _on_face(S: Array, p: int, a: int, b: int) -> tuple[float, float, float, float]:
    """Foot of the origin on a face, and its square; infinite where it is beside the face."""
    px, py, pz = S[p, 0], S[p, 1], S[p, 2]
    ex, ey, ez = S[a, 0] - px, S[a, 1] - py, S[a, 2] - pz
    fx, fy, fz = S[b, 0] - px, S[b, 1] - py, S[b, 2] - pz
    nx, ny, nz = ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx
    nn = nx * nx + ny * ny + nz * nz
    ee, ff = ex * ex + ey * ey + ez * ez, fx * fx + fy * fy + fz * fz
    if not nn > _FLAT * ee * ff:
        return 0.0, 0.0, 0.0, math.inf
    # Weights of the corners a and b: areas, signed by the normal.
    u = ((pz * fy - py * fz) * nx + (px * fz - pz * fx) * ny + (py * fx - px * fy) * nz) / nn
    v = ((ez * py - ey * pz) * nx + (ex * pz - ez * px) * ny + (ey * px - ex * py) * nz) / nn
    if not (u > 0.0 and v > 0.0 and u + v < 1.0):
        return 0.0, 0.0, 0.0, math.inf
    height = (nx * px + ny * py + nz * pz) / nn
    return height * nx, height * ny, height * nz, height * height * nn


@uncounted
def _inside(S: Array) -> bool:
    """Whether the tetrahedron of all four corners holds the origin."""
    px, py, pz = S[3, 0], S[3, 1], S[3, 2]
    ex, ey, ez = S[0, 0] - px, S[0, 1] - py, S[0, 2] - pz
    fx, fy, fz = S[1, 0] - px, S[1, 1] - py, S[1, 2] - pz
    gx, gy, gz = S[2, 0] - px, S[2, 1] - py, S[2, 2] - pz
    ax, ay, az = fy * gz - fz * gy, fz * gx - fx * gz, fx * gy - fy * gx
    bx, by, bz = gy * ez - gz * ey, gz * ex - gx * ez, gx * ey - gy * ex
    cx, cy, cz = ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx
    det = ex * ax + ey * ay + ez * az
    ee, ff, gg = ex * ex + ey * ey + ez * ez, fx * fx + fy * fy + fz * fz, gx * gx + gy * gy + gz * gz
    if not abs(det) > _FLAT * math.sqrt(ee * ff * gg):
        return False
    u = -(px * ax + py * ay + pz * az) / det
    v = -(px * bx + py * by + pz * bz) / det
    w = -(px * cx + py * cy + pz * cz) / det
    return bool(u >= 0.0 and v >= 0.0 and w >= 0.0 and u + v + w <= 1.0)
