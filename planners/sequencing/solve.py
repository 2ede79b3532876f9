"""The order of a `SequenceProblem`: starts, the cheapest of them made better."""

from __future__ import annotations

from collections.abc import Sequence

from planners.sequencing.chains import rejoined
from planners.sequencing.problem import SequenceProblem
from planners.sequencing.start import nearest_allowed, saved
from planners.sequencing.windows import EXACT, improved


def sequence(problem: SequenceProblem, given: Sequence[int]) -> list[int]:
    """The stops of `problem` in an order that keeps its rules and costs no more than `given`, if that keeps
    them.

    The optimum up to `windows.EXACT` stops; beyond, savings made better. given: all stops, in any order.
    """
    if len(problem) < 2:
        return list(given)
    starts = [order for order in (list(given), saved(problem)) if problem.keeps(order)]
    if not starts:
        starts = [nearest_allowed(problem)]
    start = min(starts, key=problem.length)
    if len(problem) <= EXACT:
        return improved(problem, start)
    return rejoined(problem, improved(problem, rejoined(problem, start)))
