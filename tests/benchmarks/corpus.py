"""The links that planners are compared on: those of the example panels' own programs, hard and direct.

A link is hard where its straight motion is not free, else direct. Besides the links that a program has, from
fastener to fastener in its order, hard links of the shell lead across a stringer, a frame or both. Links
longer than a bay are left out: ours passes them under the work.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from robots.cell import Cell
from robots.links import LONG_LINK
from robots.machine import Machine
from robots.panel import Panel
from robots.panel_file import load_panel
from robots.stations import Station, find_station
from tests.benchmarks.hard_links import HardLink, spread_out

EXAMPLES = Path("openapi/examples")
SHELL = "a320_shell"
#: Panels and dies, those that reach a good part of the panel.
GROUPS = (
    (SHELL, "straight"),
    (SHELL, "offset35"),
    (SHELL, "j20"),
    ("fuselage", "straight"),
    ("fuselage", "j20"),
    ("fuselage", "offset35"),
    ("fuselage", "long_reach"),
    ("cockpit", "j20"),
    ("cockpit", "offset35"),
    ("wing", "straight"),
    ("wing", "j20"),
    ("wing", "offset35"),
    ("crossing", "offset35"),
    ("crossing_holes", "offset35"),
)


@dataclass(frozen=True, eq=False)
class LinkGroup:
    """Links of one panel and die, each kind in the order of the program."""

    panel_id: str
    cell: Cell
    hard: tuple[HardLink, ...]
    direct: tuple[HardLink, ...]

    def name(self, link: HardLink) -> str:
        """Name of a link within the whole corpus."""
        ends = f"{link.start.fastener.id}-{link.goal.fastener.id}"
        return f"{self.panel_id}/{self.cell.die.id}/{link.kind}/{ends}"


def corpus(
    machine: Machine, panels: Mapping[str, Panel], most: int, across: Mapping[str, Sequence[HardLink]]
) -> list[LinkGroup]:
    """Per panel and die up to `most` hard and as many direct links of its program.

    across: per die links across members of the shell, which are added to the shell's.
    """
    return [
        _group(
            panels[name],
            Cell(machine, machine.dies[die], panels[name]),
            most,
            across.get(die, ()) if name == SHELL else (),
        )
        for name, die in GROUPS
        if name in panels
    ]


def example(name: str) -> Panel:
    """An example panel by its id."""
    return load_panel(EXAMPLES / f"{name}.json")


def _group(panel: Panel, cell: Cell, most: int, across: Sequence[HardLink]) -> LinkGroup:
    hard: list[HardLink] = []
    direct: list[HardLink] = []
    for start, goal in pairwise(_program_stations(panel, cell)):
        space = cell.link_space([start.opened, goal.opened])
        if space.edge_is_free(start.opened, goal.opened):
            direct.append(HardLink("direct", start, goal))
        elif np.linalg.norm(goal.fastener.p - start.fastener.p) < LONG_LINK:
            hard.append(HardLink("program", start, goal))
    chosen = [*spread_out(hard, most), *across]
    order = {fastener.id: i for i, fastener in enumerate(panel.fasteners)}
    chosen.sort(key=lambda link: (order[link.start.fastener.id], order[link.goal.fastener.id]))
    return LinkGroup(panel.id, cell, tuple(chosen), tuple(spread_out(direct, most)))


def _program_stations(panel: Panel, cell: Cell) -> Iterator[Station]:
    """Stations of all fasteners in order, each as a program's pass with this one die would take it."""
    came_from, angle = None, cell.machine.axis("C").home
    for fastener, stack in zip(panel.fasteners, panel.stacks, strict=True):
        station = find_station(cell, fastener, stack, came_from, angle)
        came_from = fastener.p
        if isinstance(station, Station):
            angle = station.die_angle
            yield station


def counted(groups: Sequence[LinkGroup]) -> str:
    """How many links of which kind there are, in one line."""
    hard = [link.kind for group in groups for link in group.hard]
    kinds = ", ".join(f"{hard.count(kind)} {kind}" for kind in sorted(set(hard)))
    direct = sum(len(group.direct) for group in groups)
    panels = sorted({f"{group.panel_id} {group.cell.die.id}" for group in groups})
    return f"{len(hard)} hard links ({kinds}) and {direct} direct ones of {len(panels)} panels and dies"
