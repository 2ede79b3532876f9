"""The point of a simplex closest to the origin, and the smaller simplex that holds it.

`S` (11, 3) holds the corners in its first rows, `n` of them in use; the rest is work space. Every function
leaves the corners that carry the closest point in the first rows and returns their number with the point.
Regions after Ericson 2005, Real-Time Collision Detection, 5.1.
"""

from __future__ import annotations

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.plain import number

Closest = tuple[int, float, float, float]


@compiled_on_views
def closest_of(S: Array, n: int) -> Closest:
    """Closest point of the simplex of the first `n` corners; of four, (4, 0, 0, 0) if the origin is in it."""
    if n == 1:
        return 1, S[0, 0], S[0, 1], S[0, 2]
    first = number(0)
    if n == 2:
        return _of_segment(S, first, first + 1)
    if n == 3:
        return _of_triangle(S, first, first + 1, first + 2)
    return _of_tetrahedron(S)


@compiled_on_views
def _keep(S: Array, first: int, second: int, third: int, n: int) -> None:
    """Move the named corners to the front; `n` of them are meant."""
    x0, y0, z0 = S[first, 0], S[first, 1], S[first, 2]
    x1, y1, z1 = S[second, 0], S[second, 1], S[second, 2]
    x2, y2, z2 = S[third, 0], S[third, 1], S[third, 2]
    S[0, 0], S[0, 1], S[0, 2] = x0, y0, z0
    if n > 1:
        S[1, 0], S[1, 1], S[1, 2] = x1, y1, z1
    if n > 2:
        S[2, 0], S[2, 1], S[2, 2] = x2, y2, z2


@compiled_on_views
def _of_segment(S: Array, i: int, j: int) -> Closest:
    ax, ay, az = S[i, 0], S[i, 1], S[i, 2]
    ux, uy, uz = S[j, 0] - ax, S[j, 1] - ay, S[j, 2] - az
    along, whole = -(ax * ux + ay * uy + az * uz), ux * ux + uy * uy + uz * uz
    if along <= 0.0:
        _keep(S, i, i, i, 1)
        return 1, ax, ay, az
    if along >= whole:
        _keep(S, j, j, j, 1)
        return 1, S[0, 0], S[0, 1], S[0, 2]
    t = along / whole
    _keep(S, i, j, j, 2)
    return 2, ax + t * ux, ay + t * uy, az + t * uz


@compiled_on_views
def _of_triangle(S: Array, i: int, j: int, k: int) -> Closest:
    ax, ay, az = S[i, 0], S[i, 1], S[i, 2]
    bx, by, bz = S[j, 0], S[j, 1], S[j, 2]
    cx, cy, cz = S[k, 0], S[k, 1], S[k, 2]
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    d1, d2 = -(ux * ax + uy * ay + uz * az), -(vx * ax + vy * ay + vz * az)
    d3, d4 = -(ux * bx + uy * by + uz * bz), -(vx * bx + vy * by + vz * bz)
    d5, d6 = -(ux * cx + uy * cy + uz * cz), -(vx * cx + vy * cy + vz * cz)
    if d1 <= 0.0 and d2 <= 0.0:
        return _of_segment(S, i, i)
    if d3 >= 0.0 and d4 <= d3:
        return _of_segment(S, j, j)
    if d6 >= 0.0 and d5 <= d6:
        return _of_segment(S, k, k)
    over_ab = d1 * d4 - d3 * d2
    if over_ab <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return _of_segment(S, i, j)
    over_ac = d5 * d2 - d1 * d6
    if over_ac <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return _of_segment(S, i, k)
    over_bc = d3 * d6 - d5 * d4
    if over_bc <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        return _of_segment(S, j, k)
    # The foot on the plane, by the plane's normal: weights of the corners lose digits in slender triangles.
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    height = (nx * ax + ny * ay + nz * az) / (nx * nx + ny * ny + nz * nz)
    _keep(S, i, j, k, 3)
    return 3, height * nx, height * ny, height * nz


@compiled_on_views
def _beyond(S: Array, i: int, j: int, k: int, other: int) -> bool:
    """Whether the origin is not strictly on the same side of the plane i j k as corner `other`."""
    ax, ay, az = S[i, 0], S[i, 1], S[i, 2]
    ux, uy, uz = S[j, 0] - ax, S[j, 1] - ay, S[j, 2] - az
    vx, vy, vz = S[k, 0] - ax, S[k, 1] - ay, S[k, 2] - az
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    origin = -(nx * ax + ny * ay + nz * az)
    corner = nx * (S[other, 0] - ax) + ny * (S[other, 1] - ay) + nz * (S[other, 2] - az)
    return not origin * corner > 0.0


@compiled_on_views
def _copy(S: Array, source: int, target: int) -> None:
    for c in range(3):
        S[target, c] = S[source, c]


@compiled_on_views
def _of_tetrahedron(S: Array) -> Closest:
    """Best of the faces the origin may see; rows 4 to 7 keep the corners, rows 8 to 10 the best face."""
    for row in range(4):
        _copy(S, row, 4 + row)
    best, n, x, y, z, first = -1.0, 4, 0.0, 0.0, 0.0, number(0)
    for face in range(4):
        i, j, k = 4 + (face + 1) % 4, 4 + (face + 2) % 4, 4 + (face + 3) % 4
        if not _beyond(S, i, j, k, 4 + face):
            continue
        _copy(S, i, 0)
        _copy(S, j, 1)
        _copy(S, k, 2)
        m, px, py, pz = _of_triangle(S, first, first + 1, first + 2)
        square = px * px + py * py + pz * pz
        if best < 0.0 or square < best:
            best, n, x, y, z = square, m, px, py, pz
            for row in range(3):
                _copy(S, row, 8 + row)
    if best >= 0.0:
        for row in range(3):
            _copy(S, 8 + row, row)
    return n, x, y, z
