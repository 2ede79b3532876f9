"""Static trees of axis-parallel boxes, and what may be asked of them; compiled.

tree       the tree over a set of boxes
meeting    which of the boxes meet others
rays       whether points lie within closed surfaces of triangles
crossing   which triangles pass through each other
"""
