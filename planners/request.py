"""Checks of a planning request, once, on entry."""

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from planners.errors import NotFinite, WrongShape
from planners.region import Searched
from planners.settings import PlannerSettings


def checked_ends(
    space: Searched, start: ArrayLike, goal: ArrayLike, settings: PlannerSettings
) -> tuple[Array, Array]:
    """Return frozen copies of start and goal, shape (n,) each; raise `WrongShape` or `NotFinite`.

    n is the number of axis rules; the bounds of the space must have that many finite values.
    """
    n = len(settings.axes)
    together = [np.asarray(each, dtype=np.float64) for each in (space.lower, space.upper, start, goal)]
    if all(each.shape == (n,) for each in together):
        rows = frozen(together)  # most requests are in order: one look at all four
        if np.isfinite(rows).all():
            return rows[2], rows[3]
    for name, bound in (("space.lower", space.lower), ("space.upper", space.upper)):
        checked(name, bound, (n,))
    return checked("start", start, (n,)), checked("goal", goal, (n,))


def checked(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return a frozen copy of `values`, which must have `shape` and be finite."""
    array = frozen(values)
    if array.shape != shape:
        raise WrongShape(name, str(shape), str(array.shape))
    if not np.isfinite(array).all():
        raise NotFinite(name)
    return array
