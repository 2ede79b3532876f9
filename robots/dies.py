"""Dies: the tools that work from inside the panel between stringers and frames.

Die frame: origin at the centre of the tip face, z towards the skin, x ("u") to the side where the neck and
shank of an offset die lie. Every die is a set of convex solids on the link that turns it; the solid named
`TIP` is the only one that may touch the panel, and only the stack it clamps.
"""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field

from robots.errors import UnknownName
from robots.solids import Solid

#: Name of the one solid of a die that touches the stack.
TIP = "tip"


@dataclass(frozen=True, eq=False)
class Die:
    """One die.

    id: its name in programs. title: for people.
    solids: convex pieces in the die frame, the tip first; nothing lies above z = 0.
    axisymmetric: turning it about z changes nothing, so its angle is free.
    mounting_z: height of the face that sits on the die slide, in the die frame [m], negative.
    """

    id: str
    title: str
    solids: tuple[Solid, ...]
    axisymmetric: bool
    mounting_z: float

    @property
    def solid_names(self) -> tuple[str, ...]:
        return tuple(solid.name for solid in self.solids)


@dataclass(frozen=True, eq=False)
class DieLibrary:
    """The dies a machine can be given; iterate over them or look one up by id.

    definition: canonical JSON of the whole library, what `sha256` is taken of.
    """

    id: str
    dies: tuple[Die, ...]
    definition: bytes = field(repr=False)

    @property
    def ids(self) -> tuple[str, ...]:
        return tuple(die.id for die in self.dies)

    @property
    def sha256(self) -> str:
        return hashlib.sha256(self.definition).hexdigest()

    def __getitem__(self, die_id: str) -> Die:
        """Return the die of that id; raise UnknownName with the ids there are."""
        for die in self.dies:
            if die.id == die_id:
                return die
        raise UnknownName("die", die_id, self.ids)

    def __iter__(self) -> Iterator[Die]:
        return iter(self.dies)

    def __len__(self) -> int:
        return len(self.dies)
