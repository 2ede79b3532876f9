"""The smallest amount of a change that does what it should, on a grid of amounts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from planners.arrays import Array
from robots.access.reach import DieReach
from robots.cell import Blockage, Cell
from robots.panel import Fastener

SEARCHES = 2
"""Ways that are searched in vain before a change is given up: where one is shut in, the next mostly is, and a
search in vain costs a thousand times what the question does whether a die fits.
"""


class Patience:
    """How many more ways may be searched in vain."""

    def __init__(self) -> None:
        self.left = SEARCHES


@dataclass(frozen=True, eq=False)
class Success:
    """A fastener as it is after a change, the cell with the die that then reaches it, and how."""

    cell: Cell
    fastener: Fastener
    reach: DieReach

    @property
    def die_angle(self) -> float:
        """C [rad] at the station."""
        return float(self._ends[0][-1])

    def clearance(self) -> Blockage:
        """The pair that has least to spare in the process there; asks coal."""
        return self.cell.process_blockage(self.fastener, *self._ends)

    @property
    def _ends(self) -> tuple[Array, Array]:
        if self.reach.station is None:
            raise ValueError(f"fastener {self.fastener.id} is not reached")
        return self.reach.station.opened, self.reach.station.clamped


@dataclass(frozen=True, eq=False)
class Outcome:
    """What one amount comes to. no_way: the die fits then, but has no way in and out."""

    success: Success | None = None
    no_way: bool = False


def smallest(
    ask: Callable[[int], Outcome], coarse: int, limit: int, patience: Patience | None = None
) -> tuple[int, Success] | None:
    """The smallest amount in 1..limit that succeeds, and its success; None where none was found.

    Amounts `coarse` apart, and two that are less, are asked in turn until one succeeds; what lies between the
    last failure and the success is halved. Where the die fits without a way, no less than half of the limit
    is asked next, as long as there is `patience`, by default of its own.
    """
    low, patience = 0, patience or Patience()
    first = {coarse // 5, coarse // 2, limit // 2, limit}
    for high in sorted(amount for amount in first.union(range(coarse, limit, coarse)) if 0 < amount <= limit):
        if patience.left == 0 or (patience.left < SEARCHES and high < limit // 2):
            continue
        outcome = ask(high)
        if outcome.success is not None:
            return _halved(ask, low, high, outcome.success)
        patience.left -= outcome.no_way
        low = high
    return None


def smallest_of_easing(ask: Callable[[int], Outcome], limit: int) -> tuple[int, Success] | None:
    """As `smallest` where more of the change never does harm: what fails at the limit fails everywhere."""
    success = ask(limit).success if limit > 0 else None
    return None if success is None else _halved(ask, 0, limit, success)


def _halved(ask: Callable[[int], Outcome], low: int, high: int, success: Success) -> tuple[int, Success]:
    while high - low > 1:
        middle = (low + high) // 2
        outcome = ask(middle)
        if outcome.success is None:
            low = middle
        else:
            high, success = middle, outcome.success
    return high, success
