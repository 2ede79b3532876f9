"""Programs made again after a change: what still holds is kept, digit by digit, the rest is new."""

from __future__ import annotations

import copy
import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planners.approach import Approach
from robots.errors import InvalidInput
from robots.nc import NcBlock, NcProgram
from robots.nc_changes import NcChanges
from robots.nc_json import from_json, program_sha256, to_json
from robots.outline import Outline, read_outline
from robots.panel_file import load_panel
from robots.previous import KeptPass
from robots.verify import verify
from service import programming
from service.change import Change
from service.itinerary import Itinerary
from service.program_writer import program_header
from service.programming import _turns, program_panel
from service.schemas import ProgramRequest
from service.settings import Settings
from service.tasks import program as program_task
from service.timing import Timing
from tests.robots.panels import Document
from tests.robots.remedy_panels import FRAME, RIVETER, sheet
from tests.robots.rigs import crossing
from tests.service.itineraries import made_up_station

DIES = ("straight", "offset35")
PLACES = (
    ("a", -90.0, -40.0),
    ("b", -60.0, -40.0),
    ("c", -20.0, -40.0),
    ("d", 60.0, -40.0),
    ("e", 90.0, 40.0),
)


def clip(arc_mm: float) -> Document:
    return {
        "id": "K1",
        "section": "L80",
        "frame": "F1",
        "side": "-x",
        "arc_mm": arc_mm,
        "length_mm": 60.0,
        "on": "D",
    }


def document(places: Sequence[tuple[str, float, float]] = PLACES, **changes: Any) -> Document:
    """Fasteners on both sides of a frame with a clip; c, near to the frame, needs the second die."""
    frame = {**FRAME, "on": "D"}
    return sheet(places, **{"frames": [frame], "clips": [clip(40.0)], **changes})


def programmed(panel: Document, previous: Outline | None = None, seed: int = 0, **options: Any) -> NcProgram:
    dies = [RIVETER.dies[die] for die in options.pop("dies", DIES)]
    return program_panel(load_panel(panel), RIVETER, dies, seed=seed, previous=previous, **options).program


@cache
def before() -> NcProgram:
    return programmed(document())


@cache
def outline() -> Outline:
    return read_outline(to_json(before()))


def told(program: NcProgram) -> NcChanges:
    assert program.changes is not None
    return program.changes


def bare(block: NcBlock) -> NcBlock:
    """A block apart from where in the program it stands, and from its clearance, which is the panel's."""
    lasts = round(block.t_end_s - block.t_start_s, 6)
    return replace(block, n=0, t_start_s=0.0, t_end_s=lasts, clearance=None)


def assert_clean(program: NcProgram, panel: Document) -> None:
    """And the same certificate as for a program that was planned without a previous one."""
    assert program.verification is not None
    assert program.verification.result == "clean"
    assert verify(from_json(to_json(program)), load_panel(panel), RIVETER) == program.verification


def link_blocks(program: NcProgram) -> dict[tuple[str, str | None, str | None], list[NcBlock]]:
    """The blocks of each link, by its die, what it leaves and leads to."""
    found: dict[tuple[str, str | None, str | None], list[NcBlock]] = {}
    here, way = None, list[NcBlock]()
    for block in program.blocks[1:]:
        if block.kind == "move":
            way.append(bare(block))
        elif way:
            leads = block.fastener_id if block.kind == "approach" else None
            found[way[-1].die_id, here, leads], way, here = way, [], leads
    found[way[-1].die_id, here, None] = way
    return found


def assert_only_told_links_differ(old: NcProgram, new: NcProgram) -> None:
    mentioned = {(each.die_id, each.leaves, each.leads) for each in told(new).links}
    was, now = link_blocks(old), link_blocks(new)
    assert {ends for ends, blocks in now.items() if was.get(ends) != blocks} <= mentioned
    assert told(new).kept_links == len(now) - len(mentioned)


def test_an_unchanged_panel_gives_the_same_blocks() -> None:
    again = programmed(document(), outline())

    assert again.blocks == before().blocks
    assert again.fasteners == before().fasteners
    assert told(again) == NcChanges(None, (), (), (), len(link_blocks(before())), 0.0)
    assert again.header.inputs.previous is not None
    assert again.header.inputs.previous.sha256 == program_sha256(before())
    assert before().header.inputs.previous is None
    assert_clean(again, document())


@pytest.mark.parametrize(
    "options",
    [
        {"timing": Timing("s_curve")},
        {"timing": Timing("overlap", 0.002)},
        {"approach": Approach(2, 0.02, 0.06)},
    ],
    ids=["s_curve", "overlap", "approach"],
)
def test_an_unchanged_panel_gives_the_same_blocks_with_any_options(options: dict[str, Any]) -> None:
    """On the crossing, which has links of several blocks: corners are rounded as they were."""
    dies = list(RIVETER.dies)
    first = program_panel(crossing(), RIVETER, dies, seed=7, **options).program
    previous = read_outline(to_json(first))

    again = program_panel(crossing(), RIVETER, dies, seed=7, previous=previous, **options).program

    assert again.blocks == first.blocks
    assert told(again).links == ()
    assert again.verification is not None
    assert again.verification.result == "clean"


def test_with_more_deviation_corners_are_rounded_anew() -> None:
    dies = list(RIVETER.dies)
    first, fresh = (
        program_panel(crossing(), RIVETER, dies, timing=Timing("overlap", deviation)).program
        for deviation in (0.001, 0.004)
    )
    previous = read_outline(to_json(first))

    again = program_panel(
        crossing(), RIVETER, dies, timing=Timing("overlap", 0.004), previous=previous
    ).program

    assert again.verification is not None
    assert again.verification.result == "clean"
    assert again.summary.cycle_time_s < 1.001 * fresh.summary.cycle_time_s


def test_a_forged_pace_is_not_kept() -> None:
    timing, dies = Timing("overlap", 0.002), list(RIVETER.dies)
    content = json.loads(to_json(program_panel(crossing(), RIVETER, dies, timing=timing).program))
    for block in content["blocks"]:
        if block["dynamics"] is not None:
            block["dynamics"]["a_per_s2"] *= 3.0
            block["dynamics"]["j_per_s3"] *= 1e-9

    again = program_panel(
        crossing(), RIVETER, dies, timing=timing, previous=read_outline(json.dumps(content).encode())
    ).program

    assert again.verification is not None
    assert again.verification.result == "clean"
    assert again.summary.cycle_time_s == pytest.approx(content["summary"]["cycle_time_s"], rel=0.001)


def test_the_same_change_gives_the_same_bytes_on_any_number_of_workers() -> None:
    changed = document(clips=[clip(35.0)])

    assert to_json(programmed(changed, outline())) == to_json(programmed(changed, outline(), workers=2))


def test_a_moved_clip_changes_only_what_it_touches() -> None:
    changed = document(clips=[clip(45.0)])

    again = programmed(changed, outline())

    assert_clean(again, changed)
    assert_only_told_links_differ(before(), again)
    assert told(again).kept_links >= 4


def test_a_moved_fastener_is_linked_anew_and_nothing_else() -> None:
    places = [(name, x + 5.0 * (name == "b"), arc) for name, x, arc in PLACES]
    changed = document(places)

    again = programmed(changed, outline())

    assert_clean(again, changed)
    assert_only_told_links_differ(before(), again)
    assert [(each.id, each.what) for each in told(again).fasteners] == [("b", "moved")]
    assert {(each.leaves, each.leads) for each in told(again).links} == {("a", "b"), ("b", "d")}
    assert all("b moved by 5.000 mm" in each.text for each in told(again).links)
    first = next(k for k, block in enumerate(before().blocks) if block.fastener_id == "b")
    assert again.blocks[:first] == before().blocks[:first]  # numbers and times, too


def test_fasteners_are_added_and_removed() -> None:
    more = document([*PLACES[:2], ("new", -40.0, -40.0), *PLACES[2:]])

    added = programmed(more, outline())
    removed = programmed(document(), read_outline(to_json(added)))

    assert_clean(added, more)
    assert_clean(removed, document())
    assert [(each.id, each.what) for each in told(added).fasteners] == [("new", "added")]
    assert {each.text for each in told(added).links} == {"new is new"}
    assert {(each.leaves, each.leads) for each in told(added).links} == {("b", "new"), ("new", "d")}
    assert [(each.id, each.what) for each in told(removed).fasteners] == [("new", "removed")]
    assert [(each.leaves, each.leads, each.text) for each in told(removed).links] == [
        ("b", "d", "there was no such link: new is gone")
    ]
    assert_only_told_links_differ(before(), added)
    assert_only_told_links_differ(added, removed)


def test_what_stands_in_the_way_of_a_link_now_is_named() -> None:
    box = {"id": "B0", "size_mm": [8.0, 8.0, 20.0], "position_mm": [-75.0, -40.0, -13.0]}
    changed = document(boxes=[box])

    again = programmed(changed, outline())

    (link,) = (each for each in told(again).links if (each.leaves, each.leads) == ("a", "b"))
    assert "B0" in link.text
    assert "needs" in link.text
    assert [each.id for each in told(again).members] == ["B0"]
    assert_clean(again, changed)
    assert_only_told_links_differ(before(), again)


@pytest.mark.parametrize(
    ("options", "word"), [({"seed": 1}, "seed"), ({"dies": ("offset35", "straight")}, "dies")]
)
def test_with_other_settings_nothing_is_kept(options: dict[str, Any], word: str) -> None:
    fresh, again = programmed(document(), **options), programmed(document(), outline(), **options)

    assert again.blocks == fresh.blocks
    assert word in (told(again).everything or "")
    assert told(again).links == ()


def test_a_program_of_another_panel_is_of_no_use_and_does_no_harm() -> None:
    other = sheet([("a", 30.0, 0.0), ("z", -30.0, 0.0)])

    again = programmed(other, outline())

    assert again.blocks == programmed(other).blocks
    assert_clean(again, other)


def test_dies_are_asked_once_more_where_a_kept_station_was_of_no_use() -> None:
    """a is kept with the second die: the first one is not asked about it, until the second one fails."""
    panel, dies = load_panel(document()), [RIVETER.dies[die] for die in DIES]
    kept = {"straight": KeptPass(), "offset35": KeptPass({"a": made_up_station(0, "offset35")})}

    turns = [(die.id, indices) for die, indices in _turns(panel, dies, kept, Itinerary())]

    assert turns == [("straight", (1, 2, 3, 4)), ("offset35", (0, 1, 2, 3, 4)), ("straight", (0,))]


def forged(how: st.DataObject) -> bytes:
    """The previous program's file with some of its numbers and names exchanged."""
    content = json.loads(to_json(before()))
    for _ in range(how.draw(st.integers(1, 4))):
        block = content["blocks"][how.draw(st.integers(0, len(content["blocks"]) - 1))]
        member = how.draw(
            st.sampled_from(["axes", "axes", "axes", "die_id", "fastener_id", "kind", "origin"])
        )
        if member == "axes":
            axis = how.draw(st.sampled_from(sorted(block["axes"])))
            by = how.draw(st.sampled_from([1e-4, 0.01, 1.0, 15.0, 90.0, 1e6]))
            block["axes"][axis] += by
        else:
            block[member] = content["blocks"][how.draw(st.integers(0, len(content["blocks"]) - 1))][member]
    return json.dumps(content).encode()


@pytest.mark.parametrize("examples", [5, pytest.param(150, marks=pytest.mark.long)])
def test_a_forged_previous_program_does_no_harm(examples: int) -> None:
    fates = [(each.id, each.status) for each in before().fasteners]

    @settings(max_examples=examples, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
    @given(how=st.data())
    def check(how: st.DataObject) -> None:
        again = programmed(document(), read_outline(forged(how)))
        assert_clean(again, document())
        assert [(each.id, each.status) for each in again.fasteners] == fates

    check()


@pytest.mark.long
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(how=st.data())
def test_after_any_change_the_same_fasteners_are_installed_as_without_a_previous_program(
    how: st.DataObject,
) -> None:
    """Clip, fasteners and boxes elsewhere."""
    by = st.integers(-12, 12).map(float)
    places = [(name, x + how.draw(by), arc + how.draw(by)) for name, x, arc in PLACES]
    keep = how.draw(st.lists(st.sampled_from(places), min_size=1, max_size=5, unique=True))
    boxes = [
        {"id": f"B{k}", "size_mm": [8.0, 8.0, 20.0], "position_mm": [x, arc, -13.0]}
        for k, (x, arc) in enumerate(
            how.draw(st.lists(st.sampled_from([(-75.0, -40.0), (90.0, 20.0), (-40.0, 0.0)]), unique=True))
        )
    ]
    changed = document(keep, clips=[clip(40.0 + how.draw(by))], boxes=boxes)
    try:
        load_panel(changed)
    except InvalidInput:
        return

    again, fresh = programmed(changed, outline()), programmed(changed)

    assert_clean(again, changed)
    assert_only_told_links_differ(before(), again)
    assert [(each.id, each.status) for each in again.fasteners] == [
        (each.id, each.status) for each in fresh.fasteners
    ]


def test_a_request_with_a_previous_program_gives_what_the_command_line_gives() -> None:
    changed = document(clips=[clip(45.0)])
    request = ProgramRequest(panel=changed, dies=list(DIES), previous_program=json.loads(to_json(before())))

    answer = program_task(request, Settings())

    assert answer.body == to_json(programmed(changed, outline()))


def test_a_previous_program_that_is_none_is_a_problem_of_the_request() -> None:
    content = copy.deepcopy(json.loads(to_json(before())))
    content["blocks"][3]["axes"]["W_mm"] = "high"
    request = ProgramRequest(panel=document(), previous_program=content)

    with pytest.raises(InvalidInput) as caught:
        program_task(request, Settings())

    assert caught.value.problems[0].pointer == "/previous_program/blocks/3/axes/W_mm"


def test_a_change_knows_how_much_is_unknown() -> None:
    panel = load_panel(document([*PLACES, ("new", -40.0, 40.0)]))
    header = program_header(panel, RIVETER, [RIVETER.dies[die] for die in DIES], 0)
    other = program_header(panel, RIVETER, [RIVETER.dies[die] for die in DIES], 1)

    assert Change(outline(), header).unknown(panel) == 1
    assert Change(outline(), other).unknown(panel) == 6


@pytest.mark.long
def test_what_is_kept_is_kept_in_any_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs of one fastener on two workers: what is kept goes to them and comes back."""
    monkeypatch.setattr(programming, "RUN_LENGTH", 1)
    monkeypatch.setattr(Change, "unknown", lambda _self, panel: len(panel.fasteners))
    changed = document(clips=[clip(45.0)])

    programs = [programmed(changed, outline(), workers=workers) for workers in (1, 2)]

    assert to_json(programs[0]) == to_json(programs[1])
    assert told(programs[0]).kept_links >= 4
