"""What a search has recorded, as lists that tests can look at."""

from __future__ import annotations

from dataclasses import dataclass

from planners.arrays import Array
from planners.motions import RECORDED, SADDLES, WALKS, Motion, Search, height


@dataclass(frozen=True, eq=False)
class Record:
    """configurations: each (n,), the start first; motions: what recorded the later ones; saddles: indices."""

    search: Search
    configurations: list[Array]
    motions: list[Motion]
    saddles: list[int]
    walks: list[int]

    @staticmethod
    def of(search: Search) -> Record:
        recorded, saddles, walks = (int(search.sizes[k]) for k in (RECORDED, SADDLES, WALKS))
        return Record(
            search,
            list(search.configurations[:recorded]),
            [Motion(int(motion)) for motion in search.motions[1:recorded]],
            search.saddles[:saddles].tolist(),
            search.walks[:walks].tolist(),
        )

    def potential(self, q: Array) -> float:
        return float(height(self.search, q))
