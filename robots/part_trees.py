"""The tree over each part's pieces, made once per part."""

from __future__ import annotations

from weakref import WeakKeyDictionary

from robots import hexahedra
from robots.panel import Part
from robots.trees.tree import Tree, build

_trees: WeakKeyDictionary[Part, Tree] = WeakKeyDictionary()


def tree_of(part: Part) -> Tree:
    """The tree over the boxes of a part's pieces, in their order."""
    found = _trees.get(part)
    if found is None:
        found = _trees[part] = build(*hexahedra.bounds(part.pieces))
    return found
