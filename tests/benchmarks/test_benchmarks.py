"""What the bench computes of its measurements; nothing here looks at a clock."""

import json
import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.retiming import exact_stop
from robots.machine_file import load_machine
from robots.panel_file import load_panel
from tests.benchmarks import growth
from tests.benchmarks.comparison import (
    ESCAPES,
    Binding,
    path_time_ratios,
    ratio_table,
    ratios,
    rows,
    table,
    verdict_table,
    verdicts,
)
from tests.benchmarks.hard_links import spread_out
from tests.benchmarks.path_time import BlockTimer, path_time, rest_to_rest
from tests.benchmarks.runs import Run
from tests.benchmarks.statistics import aligned, as_json, exponent, ratio, shown, spread

FREE = Binding(call=0.0, answer=0.0)
PEER = "peer"


def run(planner: str, link: str, seconds: float, path_time: float | None = 1.0) -> Run:
    """A run that smoothed for a quarter of its time, solved if it has a path time."""
    ok = path_time is not None
    return Run(link, planner, 0, ok, "", seconds, seconds / 4.0, 10, 5, 3, path_time, 0.001 if ok else None)


@given(st.lists(st.floats(0.0, 1e6), min_size=1, max_size=50))
def test_percentiles_are_those_of_the_sorted_values(values: list[float]) -> None:
    found = spread(values)

    ordered = sorted(values)
    for value, part in ((found.median, 0.5), (found.p95, 0.95), (found.p99, 0.99)):
        place = part * (len(ordered) - 1)
        low, high = ordered[math.floor(place)], ordered[math.ceil(place)]
        assert value == pytest.approx(low + (place - math.floor(place)) * (high - low), rel=1e-9, abs=1e-9)
    assert found.count == len(values)


def test_nothing_has_no_percentiles_and_no_ratio() -> None:
    assert spread([]).count == 0
    assert math.isnan(spread([]).median)
    assert math.isnan(ratio(1.0, 0.0))
    assert ratio(1.0, 4.0) == 0.25


@given(st.floats(-1.0, 3.0), st.floats(1e-6, 1e3))
def test_the_exponent_of_a_power_is_found(power: float, factor: float) -> None:
    sizes = [100.0, 300.0, 1000.0, 10_000.0]

    assert exponent(sizes, [factor * size**power for size in sizes]) == pytest.approx(power, abs=1e-6)


def test_the_exponent_is_the_least_squares_slope_in_log_log() -> None:
    # In powers of ten (0, 0), (1, 3), (3, 3): about the means, 4 over 14/3.
    assert exponent([1.0, 10.0, 1000.0], [1.0, 1000.0, 1000.0]) == pytest.approx(6.0 / 7.0)


def test_json_holds_dataclasses_as_objects_and_null_for_what_is_no_number() -> None:
    @dataclass(frozen=True)
    class Point:
        at: tuple[float, ...]

    text = as_json({"points": [Point((1.0, math.nan))], "spread": spread([]), "some": 3, "none": None})

    read = json.loads(text)
    assert read["points"] == [{"at": [1.0, None]}]
    assert read["spread"] == {"count": 0, "median": None, "p95": None, "p99": None}
    assert (read["some"], read["none"]) == (3, None)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1234.5, "1234"),
        (12.345, "12.3"),
        (0.0012345, "0.00123"),
        (math.nan, "-"),
        (math.inf, "-"),
    ],
)
def test_numbers_are_shown_with_three_digits(value: float, text: str) -> None:
    assert shown(value) == text


def test_columns_are_aligned() -> None:
    assert aligned([["a", "10"], ["long", "2"]]) == "a     10\nlong   2"


def test_links_are_spread_over_the_whole_list() -> None:
    assert spread_out(list(range(10)), 5) == [0, 2, 4, 6, 8]
    assert spread_out(list(range(3)), 5) == [0, 1, 2]


def test_rows_count_only_links_that_some_planner_solves() -> None:
    runs = [run(ESCAPES, "a", 1.0), run(ESCAPES, "b", 3.0), run(ESCAPES, "c", 9.0, None)]
    runs += [run(PEER, "a", 4.0), run(PEER, "b", 9.0, None), run(PEER, "c", 9.0, None)]

    mine, peer = rows(runs, FREE)

    assert (mine.planner, mine.runs, mine.solved, mine.reference) == (ESCAPES, 3, 2, (2, 2))
    assert (peer.planner, peer.runs, peer.solved, peer.reference) == (PEER, 3, 1, (1, 2))
    assert (mine.planning.median, mine.search.median) == (2.0, 1.5)
    assert mine.over_certifying.median == pytest.approx(2000.0)


def test_the_binding_is_taken_off_a_peers_search_and_never_more_than_all_of_it() -> None:
    peer = replace(run(PEER, "a", 4.0), in_python=1.5, in_space=1.0, calls=20, setup=0.25)

    assert FREE.without(peer) == pytest.approx(2.25)  # 3.0 of search less 0.25 and 0.5 of callbacks
    assert Binding(call=0.01, answer=0.02).without(peer) == pytest.approx(2.25 - 20 * 0.01 - 10 * 0.02)
    assert Binding(call=1.0, answer=1.0).without(peer) == 0.0


def test_ratios_divide_ours_by_theirs() -> None:
    runs = [run(ESCAPES, "a", 1.0, 2.0), run(ESCAPES, "b", 1.0, 3.0), run(PEER, "a", 4.0, 1.0)]

    (against,) = ratios(rows(runs, FREE), runs)

    assert against.planner == PEER
    assert against.planning == against.search == (0.25, 0.25)
    assert against.checks == 1.0


def test_path_times_are_compared_link_by_link_with_the_best_of_all_seeds() -> None:
    runs = [run(ESCAPES, "a", 1.0, 2.0), run(ESCAPES, "b", 1.0, 3.0), run(ESCAPES, "a", 1.0, 4.0)]
    runs += [run(PEER, "a", 1.0, seconds) for seconds in (8.0, 1.0, 5.0)]
    runs += [run(PEER, "b", 1.0, None)]

    assert path_time_ratios(runs, PEER) == [2.0, 4.0]


def test_a_bar_holds_up_to_its_value_and_no_further() -> None:
    hard = [run(ESCAPES, "a", 0.010, 1.05), run(PEER, "a", 0.020, 1.0)]
    direct = [run(ESCAPES, "d", 0.0031)]

    found = {verdict.what: verdict for verdict in verdicts(hard, direct, FREE, PEER, PEER)}

    assert [verdict.holds for verdict in found.values()] == [True, True, True, True, False, True]
    assert found["hard links solved, of those that any planner solves"].value == 1.0
    assert found["planning over certifying once, direct links, median"].value == pytest.approx(3.1)
    assert "MISSED" in verdict_table(list(found.values()))


def test_medians_are_judged_by_medians_and_the_slow_by_the_slow() -> None:
    hard = [run(ESCAPES, "a", seconds) for seconds in (0.01, 0.01, 0.01, 0.25, 0.25)]
    hard += [run(PEER, "a", seconds) for seconds in (0.02, 0.02, 0.02, 1.0, 1.0)]

    _, typical, slow, *_ = verdicts(hard, [run(ESCAPES, "d", 0.001)], FREE, PEER, PEER)

    assert (typical.value, slow.value) == (0.5, 0.25)


def test_a_link_that_only_a_peer_solves_is_missed() -> None:
    hard = [run(ESCAPES, "a", 0.01), run(ESCAPES, "b", 0.01, None), run(PEER, "a", 0.1), run(PEER, "b", 0.1)]

    first, *_ = verdicts(hard, [run(ESCAPES, "d", 0.001)], FREE, PEER, PEER)

    assert (first.value, first.holds) == (0.5, False)


def test_tables_have_a_line_for_every_planner() -> None:
    runs = [run(ESCAPES, "a", 1.0), run(PEER, "a", 4.0, None), replace(run("third", "a", 1.0), in_python=0.5)]
    made = rows(runs, FREE)

    assert [line.split("  ")[0] for line in table(made).splitlines()[1:]] == [ESCAPES, PEER, "third"]
    assert len(ratio_table(ratios(made, runs)).splitlines()) == 3


limit = st.floats(0.01, 100.0)


@given(limit, limit, limit)
def test_the_time_from_rest_to_rest_is_that_of_the_program(v: float, a: float, j: float) -> None:
    assert rest_to_rest(v, a, j) == pytest.approx(exact_stop([1.0], [v], [a], [j]).duration, rel=1e-6)


@given(st.lists(st.floats(-2.0, 2.0), min_size=7, max_size=7), st.integers(0, 2**20))
def test_the_time_of_a_block_in_closed_form_is_that_of_the_program(moves: list[float], seed: int) -> None:
    rng, machine = np.random.default_rng(seed), load_machine("riveter")
    scales, start = rng.uniform(0.05, 3.0, 7), rng.uniform(-1.0, 1.0, 7)
    step = np.where(rng.random(7) < 0.5, np.array(moves), 0.0) * 10.0 ** rng.uniform(-4.0, 0.0)
    timer = BlockTimer(scales, machine.v_max, machine.a_max, machine.j_max)

    found = timer((scales * start).tolist(), (scales * (start + step)).tolist())

    expected = exact_stop(start + step - start, machine.v_max, machine.a_max, machine.j_max).duration
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6)
    assert path_time(machine, np.array([start, start + step])) == pytest.approx(expected)


def test_panels_of_the_growth_curves_have_the_sizes_they_are_made_for() -> None:
    (bare, crossed), (long,) = growth.members_shells(((1, 0), (3, 1))), growth.longer_shells((300,))

    panels = [load_panel(growth.document(shell)) for shell in (bare, crossed, long)]

    assert [len(panel.fasteners) for panel in panels] == [120, 120, 299]
    assert len(panels[0].pieces()[0]) <= 10 < len(panels[1].pieces()[0])


def test_a_curve_shows_every_size_and_its_exponents() -> None:
    sizes = [growth.Grown(10, 120, 120, {"plan": 1.0}), growth.Grown(1000, 120, 119, {"plan": 10.0})]
    curve = growth.Curve("pieces", sizes, growth.exponents("pieces", sizes))

    assert curve.exponents == {"plan": pytest.approx(0.5)}
    assert growth.curve_table(curve).splitlines()[-1].split() == ["exponent", "over", "pieces", "0.50"]
