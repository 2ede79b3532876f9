"""What a text of a program says, in any dialect: what is written, read back and compared."""

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import get_args

from robots.nc import AXIS_FIELDS, BlockKind, NcBlock, NcProgram
from robots.nc_blend import TimingLaw
from robots.nc_codec import encode
from robots.nc_json import program_sha256
from robots.nc_numbers import SignificantDown
from robots.nc_process import NcHandshake
from robots.post.form import NO_NAME, Form, token

HEAD_KEYS = (
    "program",
    "sha256",
    "machine",
    "machine-sha256",
    "panel",
    "generator",
    "law",
    "policy-mm",
    "units",
)
START, CHANGE, PROCESS, WAIT = "start", "change", "process", "wait"
"""Kinds of calls that are followed by ":" and the name of a die, a process or a hand-shake; other calls are
events. A wait belongs to the event after it."""

_LIMIT = SignificantDown(6)
"""Of path limits, as in the program: so that a reader of the feed finds none that is larger."""

KINDS: tuple[str, ...] = get_args(BlockKind)


@dataclass(frozen=True, slots=True)
class Step:
    """One block as its text says it.

    axes: end values X Y Z A B W C [mm] and [deg]. feed: inverse time feed [1/min], None at rest. fastener:
    `*` where there is none. calls: what the machine is told to do there, in order. record: the whole block
    as the JSON master has it, where the dialect says that much. line: where it stands in the text, from 1; no
    part of what is compared.
    """

    n: int
    kind: str
    axes: tuple[float, ...]
    feed: float | None
    fastener: str
    origin: str
    calls: tuple[str, ...]
    record: str = ""
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Content:
    """A whole text: the values of `HEAD_KEYS`, names of dies, processes and hand-shakes, and the blocks.

    head_lines: where the values stand in the text; empty where they are not lines of it.
    """

    head: tuple[str, ...]
    dies: tuple[str, ...]
    processes: tuple[str, ...]
    steps: tuple[Step, ...]
    head_lines: tuple[int, ...] = field(default=(), compare=False)
    waits: tuple[str, ...] = ()


def content_of(program: NcProgram, form: Form) -> Content:
    """What a text of this program must say with the digits of `form`."""
    blocks = program.blocks
    first = [_step(block, form, is_first=True) for block in blocks[:1]]
    return Content(
        head=_head(program),
        dies=tuple(token(die.id) for die in program.dies),
        processes=tuple(token(process.id) for process in program.processes),
        steps=(*first, *(_within(_step(b, form), a, b, program, form) for a, b in pairwise(blocks))),
        waits=wait_names(program),
    )


def wait_names(program: NcProgram) -> tuple[str, ...]:
    """The hand-shakes of the program's processes, each once, in the order of its steps."""
    given = [step.handshake for process in program.processes for step in process.steps]
    return tuple(dict.fromkeys(wait_name(handshake) for handshake in given if handshake is not None))


def wait_name(handshake: NcHandshake) -> str:
    """What stands in a text for a hand-shake: its signal and its timeout, `DIE_CONTACT-2s`."""
    seconds = f"{handshake.timeout_s:.6f}".rstrip("0").rstrip(".")
    return token(f"{handshake.wait_for}-{seconds}s")


def _head(program: NcProgram) -> tuple[str, ...]:
    header, inputs, clearance = program.header, program.header.inputs, program.policy.clearance_mm
    policy = (
        f"{clearance.default:.4f} near {clearance.near_fastener:.4f} within {clearance.near_radius_mm:.4f}"
    )
    return (
        token(header.program_id),
        program_sha256(program),
        token(program.machine.id),
        token(inputs.machine.sha256[:16]),
        token(inputs.panel.id),
        f"{token(header.planner.name)} {token(header.planner.version)} seed {header.planner.seed}",
        _law(program.policy.timing_law),
        f"{policy} sag {clearance.sag_mm:.4f}",
        "mm deg 1/min",
    )


def _law(law: TimingLaw) -> str:
    """What the text commands, and by which other law the program's times are."""
    return "exact_stop" if law == "exact_stop" else f"exact_stop times by {token(law)}"


def _step(block: NcBlock, form: Form, *, is_first: bool = False) -> Step:
    calls = [f"{START}:{token(block.die_id)}"] if is_first else []
    if block.kind == "die_change":
        calls.append(f"{CHANGE}:{token(block.die_id)}")
    if block.process_id is not None:
        calls.append(f"{PROCESS}:{token(block.process_id)}")
    for event in block.events:
        if event.handshake is not None:
            calls.append(f"{WAIT}:{wait_name(event.handshake)}")
        calls.append(token(event.code))
    return Step(
        n=block.n,
        kind=block.kind,
        axes=form.axes(block.axes),
        feed=None if block.dynamics is None else form.feed(block.dynamics.v_per_s),
        fastener=NO_NAME if block.fastener_id is None else token(block.fastener_id),
        origin=_origin(block.origin),
        calls=tuple(calls),
        record=encode(block) if form.whole_blocks else "",
    )


def _within(step: Step, before: NcBlock, block: NcBlock, program: NcProgram, form: Form) -> Step:
    """The step no faster than the axes are on the way of the text, which its digits may make longer."""
    if block.dynamics is None:
        return step
    speed = block.dynamics.v_per_s
    starts = form.axes(before.axes)
    for axis, field_name, a, b in zip(program.machine.axes, AXIS_FIELDS, starts, step.axes, strict=True):
        way = abs(b - a)
        if way > abs(getattr(block.axes, field_name) - getattr(before.axes, field_name)):
            speed = min(speed, axis.v / way)
    return step if speed == block.dynamics.v_per_s else replace(step, feed=form.feed(_LIMIT.rounded(speed)))


def _origin(origin: str) -> str:
    engine, colon, source = origin.partition(":")
    return f"{token(engine)}/{token(source)}" if colon else token(engine)
