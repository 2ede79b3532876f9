"""How the riveter's axes take part in a search."""

import math
from dataclasses import replace

import numpy as np
import pytest

from planners.region import growing_regions
from planners.settings import AxisRule
from robots.cell import Cell
from robots.machine import Machine
from robots.riveter_search import Heuristics, planner_settings
from tests.robots.rigs import MACHINE, crossing, riveted, shifted


def rule(name: str, heuristics: Heuristics, machine: Machine = MACHINE) -> AxisRule:
    return planner_settings(machine, heuristics).axes[machine.index(name)]


@pytest.mark.parametrize("heuristics", ["heuristics", "heuristics_and_escapes"])
def test_the_heuristics_of_the_paper_freeze_the_panel_and_send_the_die_down(heuristics: Heuristics) -> None:
    random = {name: rule(name, heuristics).random for name in MACHINE.axis_names}

    assert random == {
        "X": "free",
        "Y": "free",
        "Z": "frozen",
        "A": "frozen",
        "B": "frozen",
        "W": "negative",
        "C": "free",
    }


def test_without_heuristics_every_axis_walks_freely() -> None:
    settings = planner_settings(MACHINE, "none")

    assert {axis.random for axis in settings.axes} == {"free"}
    assert settings.margins.min() > 0.0


def test_only_the_full_setting_tries_escapes_and_it_is_the_default() -> None:
    assert planner_settings(MACHINE, "none").escapes_tried == 0
    assert planner_settings(MACHINE, "heuristics").escapes_tried == 0
    assert planner_settings(MACHINE).escapes_tried > 0
    assert planner_settings(MACHINE).axes == planner_settings(MACHINE, "heuristics_and_escapes").axes


@pytest.mark.parametrize("heuristics", ["none", "heuristics_and_escapes"])
def test_steps_are_the_machines_and_rules_follow_its_order_of_axes(heuristics: Heuristics) -> None:
    reordered = replace(MACHINE, axes=MACHINE.axes[::-1])

    assert planner_settings(MACHINE, heuristics).steps.tolist() == MACHINE.step.tolist()
    assert planner_settings(reordered, heuristics).axes == planner_settings(MACHINE, heuristics).axes[::-1]


def test_a_search_without_heuristics_has_the_larger_budget() -> None:
    """It is tried where the guided one found nothing, so it must look farther."""
    assert planner_settings(MACHINE, "none").max_detections > planner_settings(MACHINE).max_detections


def first_region(where: Cell, heuristics: Heuristics, start: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """Size of the first region of a search on each axis, (n,)."""
    space = where.link_space([start, goal])
    region, _ = next(growing_regions(space, start, goal, planner_settings(MACHINE, heuristics)))
    return np.asarray(region.upper - region.lower)


def test_the_inhibited_axes_stay_between_their_ends_in_the_guided_search_only() -> None:
    where = riveted(crossing(), "straight")
    start = shifted(MACHINE.home, X=6.0, W=0.2)
    goal = shifted(start, X=0.1, Z=0.03, A=0.02, B=-0.01, W=0.05)

    guided = first_region(where, "heuristics", start, goal)
    free = first_region(where, "none", start, goal)

    for name, difference in (("Z", 0.03), ("A", 0.02), ("B", 0.01)):
        assert guided[MACHINE.index(name)] == pytest.approx(difference)
        assert free[MACHINE.index(name)] > difference + 0.1
    assert guided[MACHINE.index("X")] >= 0.1 + 2 * 0.1
    assert guided[MACHINE.index("C")] > math.pi


def test_the_first_region_lets_the_die_pass_below_a_frame_with_its_standoff() -> None:
    """The deepest frame of the examples ends 136 mm below the skin."""
    for heuristics in ("none", "heuristics"):
        assert (rule("W", heuristics).margin or 0.0) > 0.136


def test_a_turn_weighs_as_the_way_it_moves_what_can_collide() -> None:
    """An offset die's tip moves 35 mm per radian of C, a shell's edge more than a metre per radian of A."""
    weights = {name: rule(name, "heuristics").weight for name in MACHINE.axis_names}

    assert weights["X"] == weights["Y"] == weights["Z"] == weights["W"] == 1.0
    assert 0.035 <= weights["C"] < 0.1
    assert weights["A"] == weights["B"] > 1.0
