"""Dies from meshes: an entry of a die library whose convex solids enclose the body."""
