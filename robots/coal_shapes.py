"""Machine shapes as coal geometry; apart from `robots.solids` so that shapes can be used without coal."""

import coal

from robots.solids import Box, Cylinder, Prism, Shape, shape_vertices


def to_coal(shape: Shape) -> coal.CollisionGeometry:
    """The same solid in the same frame as a coal geometry: Box, Cylinder (about z) or Convex."""
    if isinstance(shape, Box):
        return coal.Box(*map(float, shape.size))
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.length)
    return _convex_prism(shape)


def _convex_prism(prism: Prism) -> coal.Convex:
    """Corners i at y = -width/2 and k + i at +width/2 (`shape_vertices`), triangles turned outwards."""
    k = len(prism.profile)
    points = coal.StdVec_Vec3s()
    for vertex in shape_vertices(prism):
        points.append(vertex)
    triangles = coal.StdVec_Triangle()
    for i in range(1, k - 1):
        triangles.append(coal.Triangle(0, i, i + 1))
        triangles.append(coal.Triangle(k, k + i + 1, k + i))
    for i in range(k):
        j = (i + 1) % k
        triangles.append(coal.Triangle(i, k + i, k + j))
        triangles.append(coal.Triangle(i, k + j, j))
    return coal.Convex(points, triangles)
