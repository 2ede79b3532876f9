"""Shapes of triangles from files: STL, OBJ, PLY and GLB meshes, STEP parts.

model      what a file holds: bodies of triangles in metres, with their cylindrical holes
"""
