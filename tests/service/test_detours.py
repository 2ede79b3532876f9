"""What `check` reaches from home, `plan` installs with the same die, wherever it comes from."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planners.detector import never
from robots.access.panel_access import Desk, FastenerAccess, panel_access
from robots.errors import InvalidInput
from robots.nc_json import to_json
from robots.panel import Panel
from robots.panel_file import load_panel
from service import programming
from service.programming import program_panel
from tests.robots.mazes import maze, pocket
from tests.robots.remedy_panels import RIVETER

DIE = "offset35"


def checked(panel: Panel) -> list[FastenerAccess]:
    desk = Desk(RIVETER, panel, 0, "heuristics_and_escapes")
    access = panel_access(desk, [RIVETER.dies[DIE]], never, lambda _: None)
    assert access is not None
    return list(access.fasteners)


def assert_installs_what_is_checked(panel: Panel) -> None:
    program = program_panel(panel, RIVETER, [RIVETER.dies[DIE]]).program
    for access, written in zip(checked(panel), program.fasteners, strict=True):
        if access.chosen is not None:
            assert (written.status, written.die_id) == ("installed", DIE), written
        assert (written.status == "installed") == (written.reason is None)
    assert program.verification is not None
    assert program.verification.result == "clean"


@pytest.mark.parametrize("run_length", [1, programming.RUN_LENGTH])
def test_a_fastener_that_only_home_leads_to_is_installed(
    run_length: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within a run and between two of them."""
    monkeypatch.setattr(programming, "RUN_LENGTH", run_length)
    panel = load_panel(pocket())

    assert [access.chosen is not None for access in checked(panel)] == [True, True]
    assert_installs_what_is_checked(panel)


@pytest.mark.long
def test_detours_are_the_same_on_any_number_of_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(programming, "RUN_LENGTH", 1)
    panel, dies = load_panel(pocket()), [RIVETER.dies[DIE]]

    programs = [to_json(program_panel(panel, RIVETER, dies, workers=workers).program) for workers in (1, 2)]

    assert programs[0] == programs[1]


@st.composite
def mazes(draw: st.DrawFn) -> Panel:
    """Mazes that are panels: fasteners far enough from each other."""
    cells, dense = st.integers(0, 9), draw(st.integers(2, 7))
    plan = ["".join("#" if draw(cells) < dense else "." for _ in range(6)) for _ in range(6)]
    at = st.integers(-8, 8).map(lambda tens: 10.0 * tens)
    places = draw(st.lists(st.tuples(at, at), min_size=2, max_size=5, unique=True))
    document = maze(
        plan,
        {f"f{k}": place for k, place in enumerate(places)},
        draw(st.sampled_from([25.0, 30.0, 40.0])),
        draw(st.sampled_from([13.0, 25.0, 60.0])),
        draw(st.sampled_from([18.0, 26.0, 32.0])),
    )
    try:
        return load_panel(document)
    except InvalidInput as error:
        pytest.fail(str(error))


@pytest.mark.long
@pytest.mark.parametrize("run_length", [1, programming.RUN_LENGTH])
@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
@given(panel=mazes())
def test_what_check_reaches_plan_installs(run_length: int, panel: Panel) -> None:
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(programming, "RUN_LENGTH", run_length)
        assert_installs_what_is_checked(panel)
