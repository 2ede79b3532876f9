"""The rules of an order, for the fasteners of a panel: read from a request and checked."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise

import numpy as np

from planners.sequencing.problem import FREE, IntArray
from robots.errors import InputProblem, InvalidInput
from robots.panel import Panel
from service.canonical import canonical_json
from service.order_schemas import Objective, OrderRequest

_SHOWN_CYCLE = 6


@dataclass(frozen=True, eq=False)
class OrderRules:
    """What is asked of the order, by index in the panel; see `SequenceProblem` for phases and groups.

    precedence: pairs, those of groups with an inner order included. sha256: of the request, canonical.
    """

    objective: Objective
    phases: IntArray
    groups: IntArray
    precedence: tuple[tuple[int, int], ...]
    return_home: bool
    sha256: str

    @property
    def units(self) -> list[int]:
        """For every fastener what is done without a break: its group, or itself, numbered after
        all groups.
        """
        count = len(self.groups)
        return [count + i if group == FREE else int(group) for i, group in enumerate(self.groups)]

    def allows_late(self, index: int, installed: frozenset[int]) -> bool:
        """Whether a fastener may be done after those that are installed: none of them must come after it."""
        after = {b for a, b in self.precedence if a == index}
        phase = int(self.phases[index])
        return not any(i in after or self.phases[i] > phase for i in installed)


def order_rules(request: OrderRequest, panel: Panel) -> OrderRules | None:
    """The rules that `request` makes for `panel`; None where it asks for nothing but the given order.

    Raises InvalidInput, its pointers from the request, where an id is unknown or named twice, or rules
    contradict each other.
    """
    if request == OrderRequest(return_home=request.return_home):
        return None
    index = {fastener.id: i for i, fastener in enumerate(panel.fasteners)}
    problems = [*_unknown(request, index), *_named_twice(request)]
    if problems:
        raise InvalidInput(problems)
    phases = _phases(request, index)
    groups = np.full(len(index), FREE, dtype=np.int64)
    pairs = [(index[a], index[b], f"/precedence/{k}") for k, (a, b) in enumerate(request.precedence)]
    for number, group in enumerate(request.groups):
        members = [index[name] for name in group.fasteners]
        groups[members] = number
        if group.in_order:
            pairs += [(a, b, f"/groups/{number}") for a, b in pairwise(members)]
    rules = OrderRules(
        request.objective,
        phases,
        groups,
        tuple((a, b) for a, b, _ in pairs),
        request.return_home,
        hashlib.sha256(canonical_json(request)).hexdigest(),
    )
    problems = [*_contradictions(request, rules, pairs, panel)]
    if problems:
        raise InvalidInput(problems)
    return rules


def _named(request: OrderRequest) -> Iterator[tuple[str, str]]:
    """Every id with its place."""
    lists = {"first": [request.first], "tack": [request.tack]}
    for field, (names,) in lists.items():
        yield from ((f"/{field}/{k}", name) for k, name in enumerate(names))
    for field, several in (("zones", request.zones), ("precedence", request.precedence)):
        for number, names in enumerate(several):
            yield from ((f"/{field}/{number}/{k}", name) for k, name in enumerate(names))
    for number, group in enumerate(request.groups):
        yield from ((f"/groups/{number}/fasteners/{k}", name) for k, name in enumerate(group.fasteners))


def _unknown(request: OrderRequest, index: dict[str, int]) -> Iterator[InputProblem]:
    for place, name in _named(request):
        if name not in index:
            message, remedy = "the panel has no fastener of this id", "Name a fastener of the panel."
            yield InputProblem(place, "unknown_fastener", message, name, remedy)


def _named_twice(request: OrderRequest) -> Iterator[InputProblem]:
    """Ids that are twice among pilot holes, tack fasteners and zones, or twice among the groups."""
    seen: dict[tuple[bool, str], str] = {}
    for place, name in _named(request):
        if place.startswith("/precedence"):
            continue
        key = (place.startswith("/groups"), name)
        if key in seen:
            message = f"the fastener is named at {seen[key]} already"
            remedy = "Name it once: in one group, and in one of first, tack and the zones."
            yield InputProblem(place, "duplicate_fastener", message, name, remedy)
        seen.setdefault(key, place)


def _phases(request: OrderRequest, index: dict[str, int]) -> IntArray:
    """Pilot holes one by one, tack fasteners, zones, all others."""
    steps = [*([name] for name in request.first), request.tack, *request.zones]
    phases = np.full(len(index), len(steps), dtype=np.int64)
    for phase, names in enumerate(steps):
        phases[[index[name] for name in names]] = phase
    return phases


def _contradictions(
    request: OrderRequest, rules: OrderRules, pairs: Sequence[tuple[int, int, str]], panel: Panel
) -> Iterator[InputProblem]:
    ids = [fastener.id for fastener in panel.fasteners]
    for number, group in enumerate(request.groups):
        members = np.flatnonzero(rules.groups == number)
        if len(set(rules.phases[members].tolist())) > 1:
            message = "the group cannot be kept together: first, tack and zones put its fasteners apart"
            remedy = "Put all of its fasteners into one zone, or divide the group."
            yield InputProblem(f"/groups/{number}", "group_apart", message, group.fasteners[0], remedy)
    for a, b, place in pairs:
        if rules.phases[a] > rules.phases[b]:
            message = f"{ids[a]} cannot come before {ids[b]}: first, tack and zones put it after"
            yield InputProblem(
                place, "order_contradiction", message, ids[a], "Leave out one of the two rules."
            )
    units = rules.units
    inner = _cycle([(a, b) for a, b, _ in pairs if units[a] == units[b]])
    outer = _cycle([(units[a], units[b]) for a, b, _ in pairs if units[a] != units[b]])
    member = {unit: ids[i] for i, unit in reversed(list(enumerate(units)))}
    for names in ([ids[i] for i in inner], [member[unit] for unit in outer]):
        if names:
            more = ["..."] if len(names) > _SHOWN_CYCLE else []
            shown = " before ".join([*names[:_SHOWN_CYCLE], *more])
            message = f"pairs and groups go round in a circle: {shown}"
            remedy = "Leave out one of the pairs, or divide a group."
            yield InputProblem("/precedence", "order_cycle", message, names[0], remedy)


def _cycle(pairs: Sequence[tuple[int, int]]) -> list[int]:
    """A cycle of the pairs, its first member also its last; empty where there is none."""
    sorter: TopologicalSorter[int] = TopologicalSorter()
    for a, b in pairs:
        sorter.add(b, a)
    try:
        sorter.prepare()
    except CycleError as error:
        return [int(each) for each in error.args[1]]
    return []
