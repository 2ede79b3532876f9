"""Posts: a program as text for a controller, and that text read back and compared (design.md section 8).

`dialects.py` has the table of dialects and what can be done with one: `post`, `read`, `check`. Each dialect
is a file; those of controllers are a `Grammar` (`grammar.py`): templates of lines, one declaration for
writing and for reading. What the texts have in common, and what is compared, is `content.py`.
"""
