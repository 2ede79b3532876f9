"""Fasteners from lists: CSV, XML and JSON files, and the holes of a CAD part, as entries of a panel file.

mapping      what a list's columns and numbers are, where the list itself does not say so
table        rows of named cells, each with its place: what every form of a list becomes first
csv_table, xml_table, json_table   from bytes to a table
columns      which column is which field, in which unit
cells        what one cell says: a number, a name
rows         from a table to fasteners
checks       what fasteners have against each other, and against the skin they are on
skin         the outer face of a skin: of the parametric surface
mesh_skin    the same of bodies of triangles
panel_skin   the same of a panel definition
holes        fasteners from holes of bodies
reading      all of it: `read_fasteners`
writing      entries as a list again
"""
