"""Checking a panel: which fasteners the machine reaches with which die, and what would help at the others.

No HTTP and no files here.
"""

from __future__ import annotations

from collections.abc import Callable

from planners.detector import never
from robots.access.panel_access import Desk, PanelAccess, panel_access
from robots.access.remedies import Remedies, RemedyFinder
from service.access_report import accessibility_report
from service.access_schemas import PanelAccessibility
from service.die_pass import Cancelled
from service.inputs import Inputs
from service.programming import Progress, ProgressEvent, require_free_home


def check_panel(
    inputs: Inputs,
    *,
    remedies: int = 0,
    progress: Progress | None = None,
    stop: Callable[[], bool] = never,
) -> PanelAccessibility:
    """Find which fasteners of the panel the machine reaches with the dies, the first one preferred.

    The same input gives the same report. remedies: for how many of the fasteners that are not reached they
    are searched, in the panel's order. progress: told how many are done. Raises `die_pass.Cancelled` when
    `stop` says so, InvalidInput where the machine's home pose is in collision with the panel, ValueError
    without a die.
    """
    tell, total = progress or (lambda _: None), len(inputs.panel.fasteners)
    desk = Desk(inputs.machine, inputs.panel, seed=0, heuristics="heuristics_and_escapes")
    for die in inputs.dies:
        if stop():
            raise Cancelled
        require_free_home(desk.at(die)[0])
    tell(ProgressEvent("check", 0, total))
    access = panel_access(desk, inputs.dies, stop, lambda done: tell(ProgressEvent("check", done, total)))
    if access is None:
        raise Cancelled
    return accessibility_report(access, _remedies(desk, inputs, access, remedies, tell, stop))


def _remedies(
    desk: Desk, inputs: Inputs, access: PanelAccess, most: int, tell: Progress, stop: Callable[[], bool]
) -> dict[str, Remedies]:
    """What would help at the first of the fasteners that are not reached, by their ids."""
    asked = [each for each in access.fasteners if each.status == "inaccessible"][:most]
    if not asked:
        return {}
    finder, found = RemedyFinder(desk, inputs.document, inputs.dies), dict[str, Remedies]()
    tell(ProgressEvent("remedies", 0, len(asked)))
    for each in asked:
        remedies = finder.remedies(each, stop)
        if remedies is None:
            raise Cancelled
        found[each.fastener.id] = remedies
        tell(ProgressEvent("remedies", len(found), len(asked)))
    return found
