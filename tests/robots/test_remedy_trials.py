"""Fasteners tried out: the same that the changed document makes, refused where its checks would refuse it."""

import numpy as np
import pytest

from robots.access.adjust_remedies import ways
from robots.access.clip_remedies import alone
from robots.access.remedy_edits import changed_panel
from robots.access.trials import PanelTrials
from robots.contact import panel_pieces
from robots.panel_file import load_panel
from tests.robots.panels import SURFACES, small_panel
from tests.robots.remedy_panels import Bench, beside_a_frame


@pytest.mark.parametrize("row", [0, 1])
def test_a_clip_alone_has_its_fasteners_as_the_panel_has(row: int) -> None:
    document = small_panel()
    bench = Bench(document, ("long_reach",))
    name = [f.id for f in bench.panel.fasteners if f.row == document["rows"][row]["id"]][1]
    _, access = bench.access(name)

    panel = load_panel(alone(document, "K1", access))

    (index,) = (i for i, f in enumerate(panel.fasteners) if f.id == name)
    assert np.array_equal(panel.fasteners[index].p, access.fastener.p)
    assert panel.stacks[index] == access.stack
    assert {f.member for f in panel.fasteners} == {access.fastener.member}


@pytest.mark.parametrize("by", [{"x_mm": 3.0}, {"arc_mm": -2.0}, {"tilt_x_deg": 0.3, "tilt_arc_deg": -0.2}])
@pytest.mark.parametrize("surface", SURFACES)
def test_a_trial_is_the_fastener_that_the_document_makes(
    surface: dict[str, float], by: dict[str, float]
) -> None:
    document = small_panel(surface=surface, fasteners=[])
    panel = load_panel(document)
    index = [f.id for f in panel.fasteners].index("R1.S1.004")

    trials = PanelTrials(panel, document)

    trial = trials.trial(index, **by)

    assert trial is not None
    assert trials.trial(index, **by) is trial
    assert panel_pieces(panel).stack_of(trial.fastener) is trial.stack
    assert panel_pieces(panel).stack_of(panel.fasteners[index]) is panel.stacks[index]
    other = trials.trial(index + 1, **by)
    assert other is not None
    assert other.fastener.id == panel.fasteners[index + 1].id
    loaded = load_panel(changed_panel(trial.edit, document))
    assert np.array_equal(loaded.fasteners[index].p, trial.fastener.p)
    assert np.array_equal(loaded.fasteners[index].n, trial.fastener.n)
    assert loaded.fasteners[index].grip == pytest.approx(trial.fastener.grip, abs=1e-12)
    assert loaded.stacks[index].parts == trial.stack.parts
    assert loaded.stacks[index].depth == pytest.approx(trial.stack.depth, abs=1e-12)


@pytest.mark.parametrize(
    "by", [{"arc_mm": 60.0}, {"arc_mm": 8.5}, {"x_mm": 600.0}, {"x_mm": 15.0}, {"tilt_x_deg": 2.1}]
)
def test_what_the_panels_checks_refuse_is_no_trial(by: dict[str, float]) -> None:
    document = small_panel()
    panel = load_panel(document)

    assert PanelTrials(panel, document).trial(4, **by) is None


def test_fasteners_are_moved_along_the_rows_of_what_they_join() -> None:
    panel = load_panel(small_panel())
    along_x, across, both = {(1, 0), (-1, 0)}, {(0, 1), (0, -1)}, {(1, 0), (-1, 0), (0, 1), (0, -1)}
    for fastener, stack in zip(panel.fasteners, panel.stacks, strict=True):
        expected = across if fastener.member == "K1" else along_x
        assert set(ways(fastener, stack, panel)) == expected
    sheets = load_panel(beside_a_frame())
    assert set(ways(sheets.fasteners[0], sheets.stacks[0], sheets)) == both
