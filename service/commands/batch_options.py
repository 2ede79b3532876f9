"""The options of `rivetplan batch` as what is asked of each panel."""

from __future__ import annotations

from collections.abc import Sequence

from robots.machine_file import load_machine, machine_ids
from robots.nc_blend import TimingLaw
from service.approach_schemas import ApproachChoice
from service.commands.plan import approach_of
from service.commands.reading import Unusable
from service.order_schemas import Objective, OrderRequest
from service.schemas import ProgramRequest, TimingChoice

Approach = tuple[int | None, float | None, float | None]
"""Order, clear height and maximum height [mm], as far as they are given."""


def options(
    *,
    machine: str,
    dies: Sequence[str] | None,
    seed: int,
    timing: TimingLaw,
    deviation_mm: float | None,
    order: Objective,
    approach: Approach,
) -> ProgramRequest:
    """The request of a panel, which is still to be put in. Raises Unusable where all would fail."""
    _check_names(machine, dies)
    if deviation_mm is not None and timing != "overlap":
        raise Unusable([f"--deviation-mm: {deviation_mm:g} is for --timing overlap; {timing} has none."])
    number, clear_mm, max_mm = approach
    chosen = None
    if approach_of(number, clear_mm, max_mm) is not None and number is not None:
        chosen = ApproachChoice(order=number, clear_height_mm=clear_mm or 0.0, max_height_mm=max_mm)
    return ProgramRequest(
        panel={},
        machine=machine,
        dies=None if dies is None else list(dies),
        seed=seed,
        timing=TimingChoice(law=timing, deviation_mm=deviation_mm),
        order=OrderRequest(objective=order),
        approach=chosen,
    )


def _check_names(machine: str, dies: Sequence[str] | None) -> None:
    if machine not in machine_ids():
        known = ", ".join(machine_ids())
        raise Unusable([f"--machine: there is no machine {machine!r}. Use one of: {known}."])
    known_dies = load_machine(machine).dies.ids
    for name in dies or ():
        if name not in known_dies:
            raise Unusable([f"--die: there is no die {name!r}. Use one of: {', '.join(known_dies)}."])
    if dies is not None and len(set(dies)) < len(dies):
        raise Unusable(["--die: a die is named twice. Name each die once."])
