"""Shapes of triangles from files: STL, OBJ, PLY and GLB meshes, STEP parts.

model      what a file holds: bodies of triangles in metres, with their cylindrical holes
packed     a model as bytes
formats    which format a file has, by its name and by what it begins with
units      what the numbers of a file are taken as
read       a file's bytes, read: stl, obj, ply, glb (with its checks), step (with its units)
quarantine the same in a process of its own, with limits: for files from others
audit      what is wrong with a body: edges, faces, crossings, thickness, distance to the skin
repair     the same body mended, as far as it is told to be
writing    a body as GLB or STL
"""
