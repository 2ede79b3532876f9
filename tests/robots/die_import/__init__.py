"""Dies from meshes."""
