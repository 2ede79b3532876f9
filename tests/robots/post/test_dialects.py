"""Every dialect says what the program says, and commands nothing that was not certified."""

import re
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest

from robots.errors import InvalidInput, UnknownName
from robots.nc import AXIS_FIELDS, NcProgram
from robots.nc_json import program_sha256
from robots.nc_process import NcHandshake
from robots.post import dialects
from robots.post.content import content_of
from robots.post.dialects import DIALECTS, check, post
from robots.post.form import AXES
from tests.robots.post.programs import golden_program, golden_text, planned, small

CONTROLLERS = ["sinumerik840d", "fanuc30i", "apt"]
EVERY = list(DIALECTS)
PANELS = [
    "crossing",
    "wing",
    *(pytest.param(name, marks=pytest.mark.long) for name in ("a320_shell", "fuselage", "cockpit")),
]


def called(calls: tuple[str, ...]) -> list[tuple[str, NcHandshake | None]]:
    """Events of a block and what they wait for, by other code than the dialect's."""
    found, waiting = list[tuple[str, NcHandshake | None]](), None
    for call in calls:
        kind, colon, name = call.partition(":")
        if kind == "wait":
            signal, _, seconds = name.rpartition("-")
            waiting = NcHandshake(signal, float(seconds.removesuffix("s")))
        elif not colon:
            found.append((call, waiting))
            waiting = None
    assert waiting is None
    return found


@pytest.mark.parametrize("dialect", EVERY)
@pytest.mark.parametrize("panel", PANELS)
def test_text_read_back_says_what_the_program_says(panel: str, dialect: str) -> None:
    program = planned(panel)

    text = post(program, dialect)

    assert check(text.encode(), program, dialect) == ()
    content = dialects.read(text.encode(), dialect)
    assert [step.n for step in content.steps] == [block.n for block in program.blocks]
    for step, block in zip(content.steps, program.blocks, strict=True):
        wanted = np.array([getattr(block.axes, field) for field in AXIS_FIELDS])
        off = np.abs(np.array(step.axes) - wanted)
        assert off[[0, 1, 2, 5]].max() <= 1e-3
        assert off[[3, 4, 6]].max() <= 1e-4
        assert called(step.calls) == [(event.code, event.handshake) for event in block.events]
        assert (step.kind, step.fastener) == (block.kind, block.fastener_id or "*")


@pytest.mark.parametrize("dialect", EVERY)
def test_text_is_the_one_that_was_reviewed(dialect: str) -> None:
    assert post(golden_program(), dialect) == golden_text(dialect).read_text()


def motions(text: str, dialect: str) -> list[dict[str, float]]:
    """Axis words and F of every motion, read by eye: by other expressions than the dialect's."""
    if dialect == "apt":
        starts = re.split(r"^SEQNO/", text, flags=re.M)[1:]
        found = []
        for block in starts:
            turned = dict(re.findall(r"^\w+/([ABCW])AXIS,(?:ATANGL,)?([-\d.]+),NEXT$", block, re.M))
            goto = re.search(r"^GOTO/([-\d.]+),([-\d.]+),([-\d.]+)$", block, re.M)
            feed = re.search(r"^FEDRAT/([\d.]+),INVERS$", block, re.M)
            if goto and feed:
                words = turned | dict(zip("XYZ", goto.groups(), strict=True)) | {"F": feed[1]}
                found.append({axis: float(value) for axis, value in words.items()})
        return found
    lines = [re.sub(r";.*|\(.*\)", "", line) for line in text.splitlines()]
    rows = [re.findall(r"([XYZABWCF])(-?\d+\.\d+)", line) for line in lines if re.match(r"N\d+ G1 ", line)]
    return [{axis: float(value) for axis, value in row} for row in rows]


@pytest.mark.parametrize("dialect", CONTROLLERS)
def test_every_motion_is_there_with_all_axes_and_the_feed_of_its_slowest_axis(dialect: str) -> None:
    program = planned("wing")
    limits = {axis.name: axis.v for axis in program.machine.axes}

    found = motions(post(program, dialect), dialect)

    moving = [(a, b) for a, b in zip(program.blocks, program.blocks[1:], strict=False) if b.dynamics]
    assert len(found) == len(moving)
    for words, (before, block) in zip(found, moving, strict=True):
        assert block.dynamics is not None
        feed = Decimal(repr(words["F"]))
        exact = Decimal(repr(block.dynamics.v_per_s)) * 60
        most = Decimal("9999.999") if dialect == "fanuc30i" else Decimal("999999.999")
        assert feed <= exact
        speeds, is_longer = [], False
        for axis, field in zip(AXES, AXIS_FIELDS, strict=True):
            assert words[axis] == pytest.approx(getattr(block.axes, field), abs=1e-4)
            delta = abs(getattr(block.axes, field) - getattr(before.axes, field))
            digits = 4 if dialect == "fanuc30i" else 6
            of_text = abs(
                round(getattr(block.axes, field), digits) - round(getattr(before.axes, field), digits)
            )
            speeds.append(max(delta, of_text) * words["F"] / 60.0 / limits[axis])
            is_longer = is_longer or of_text > delta
        assert exact - feed <= Decimal("0.001") or feed >= most or is_longer
        assert max(speeds) <= 1.0 + 1e-9
        assert max(speeds) >= 0.995 or feed >= most


@pytest.mark.parametrize(("dialect", "most"), [("sinumerik840d", 999_999.999), ("fanuc30i", 9_999.999)])
def test_block_quicker_than_the_controller_can_be_told_runs_at_its_largest_feed(
    dialect: str, most: float
) -> None:
    form = DIALECTS[dialect].form

    assert form.feed(most / 60.0 + 1.0) == most
    assert form.feed(most / 60.0 - 1.0) == pytest.approx(most - 60.0, abs=0.002)


def test_text_that_does_not_read_back_as_the_program_is_not_handed_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right = DIALECTS["apt"]
    wrong = replace(right, write=lambda program: right.write(program).replace("AUXFUN/102", "AUXFUN/103"))
    monkeypatch.setattr(dialects, "DIALECTS", {"apt": wrong})

    with pytest.raises(
        RuntimeError, match=r"block 50: calls is process:solid_rivet wait:.* CLAMP wait:.* PROBE"
    ):
        post(small(), "apt")


EXACT_STOP = {"sinumerik840d": r"^G60 G601 ", "fanuc30i": r"\bG61\b", "apt": r"^MCHTOL/0$"}
ROUNDING = {
    "sinumerik840d": r"G64|G0\b|ADIS|G5\b|CYCLE832|COMPO[NC]|COMPCAD|G9\b",
    "fanuc30i": r"\bG6[234]\b|G0\b|G5\.1 Q1|G8\b|G64",
    "apt": r"RAPID|MCHTOL/(?!0$)|GODLTA",
}


@pytest.mark.parametrize("dialect", CONTROLLERS)
def test_exact_stop_is_commanded_before_the_first_motion_and_never_taken_back(dialect: str) -> None:
    text = post(planned("crossing"), dialect)

    command = re.search(EXACT_STOP[dialect], text, re.M)
    first = re.search(r"^N\d+ G1|^GOTO", text, re.M)
    assert command is not None
    assert first is not None
    assert command.start() < first.start()
    assert re.search(ROUNDING[dialect], text, re.M) is None


@pytest.mark.parametrize("dialect", EVERY)
def test_header_names_program_hash_machine_dies_policy_and_generator(dialect: str) -> None:
    program = planned("crossing")

    text = post(program, dialect)

    head = "\n".join(text.splitlines()[:20])
    version = program.header.planner.version
    for said in (program.header.program_id, program.machine.id, "j20", "2.0000", version, "exact_stop"):
        assert said in head
    assert program_sha256(program) in head or dialect == "ndjson"


@pytest.mark.parametrize(("dialect", "width"), [("sinumerik840d", 512), ("fanuc30i", 250), ("apt", 72)])
def test_lines_are_plain_and_no_longer_than_the_controller_takes(dialect: str, width: int) -> None:
    program = small()
    strange = "F1) M30 ; \n$$ (G0) \u2028 \xe4" + 50 * "x"
    renamed = tuple(
        replace(block, fastener_id=block.fastener_id and strange, origin=f"reused:{strange}")
        for block in program.blocks
    )
    content = content_of(replace(program, blocks=renamed), DIALECTS[dialect].form)

    text = dialects.GRAMMARS[dialect].write(content)

    assert text.isascii()
    assert "\r" not in text
    assert max(len(line) for line in text.splitlines() if not line.startswith("$$")) <= width
    commands = re.compile(r";.*|\(.*\)|\$\$.*|PPRINT .*")
    assert commands.sub("", text) == commands.sub("", post(program, dialect))
    assert dialects.read(text.encode(), dialect) == content


@pytest.mark.parametrize("dialect", EVERY)
def test_certificate_is_no_part_of_a_text_and_the_same_program_gives_the_same_text(dialect: str) -> None:
    program = planned("crossing")

    assert post(program, dialect) == post(planned("crossing"), dialect)
    bare: NcProgram = replace(program, verification=None)
    assert check(post(program, dialect).encode(), bare, dialect) == ()


def test_an_unknown_dialect_is_told_with_those_there_are() -> None:
    with pytest.raises(UnknownName, match="sinumerik840d"):
        post(small(), "heidenhain")


@pytest.mark.parametrize("action", [post, lambda program, dialect: check(b"", program, dialect)])
def test_a_riveters_program_has_no_rapid_text_and_is_told_why(action: object) -> None:
    assert callable(action)
    with pytest.raises(InvalidInput, match="RAPID moves the joints of a robot") as refused:
        action(small(), "rapid")

    assert [problem.code for problem in refused.value.problems] == ["no_robot"]


@pytest.mark.parametrize(
    ("dialect", "right", "wrong"),
    [
        ("sinumerik840d", "H3=1 M62", "H3=2 M62"),
        ("fanuc30i", "M801", "M802"),
        ("apt", "AUXFUN/801", "AUXFUN/802"),
        ("csv", "wait:DIE_CONTACT-2s CLAMP", "CLAMP"),
        ("csv", "wait:DIE_CONTACT-2s CLAMP", "CLAMP wait:DIE_CONTACT-2s"),
        ("csv", "wait:DIE_CONTACT-2s", "wait:DIE_CONTACT-3s"),
    ],
)
def test_a_missing_or_swapped_handshake_in_a_text_is_found(dialect: str, right: str, wrong: str) -> None:
    text = post(small(), dialect)

    found = check(text.replace(right, wrong, 1).encode(), small(), dialect)

    assert [(each.code, each.block_n) for each in found] == [("calls", 50)]


@pytest.mark.parametrize(("dialect", "line"), [("sinumerik840d", "H3=1 M62"), ("fanuc30i", "M801")])
def test_a_handshake_that_is_left_out_of_a_text_is_found(dialect: str, line: str) -> None:
    text = post(small(), dialect)

    found = check(text.replace(f"{line}\n", "", 1).encode(), small(), dialect)

    assert [(each.code, each.block_n) for each in found] == [("calls", 50)]
