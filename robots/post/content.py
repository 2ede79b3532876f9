"""What a text of a program says, in any dialect: what is written, read back and compared."""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import get_args

from robots.nc import BlockKind, NcBlock, NcProgram
from robots.nc_codec import encode
from robots.nc_json import program_sha256
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
START, CHANGE, PROCESS = "start", "change", "process"
"""Kinds of calls that are followed by ":" and the name of a die or a process; other calls are events."""

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
    """A whole text: the values of `HEAD_KEYS`, the names of dies and processes by number, and the blocks.

    head_lines: where the values stand in the text; empty where they are not lines of it.
    """

    head: tuple[str, ...]
    dies: tuple[str, ...]
    processes: tuple[str, ...]
    steps: tuple[Step, ...]
    head_lines: tuple[int, ...] = field(default=(), compare=False)


def content_of(program: NcProgram, form: Form) -> Content:
    """What a text of this program must say with the digits of `form`."""
    blocks = program.blocks
    first = [_step(block, form, is_first=True) for block in blocks[:1]]
    return Content(
        head=_head(program),
        dies=tuple(token(die.id) for die in program.dies),
        processes=tuple(token(process.id) for process in program.processes),
        steps=(*first, *(_step(block, form) for _, block in pairwise(blocks))),
    )


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
        token(program.policy.timing_law),
        f"{policy} sag {clearance.sag_mm:.4f}",
        "mm deg 1/min",
    )


def _step(block: NcBlock, form: Form, *, is_first: bool = False) -> Step:
    calls = [f"{START}:{token(block.die_id)}"] if is_first else []
    if block.kind == "die_change":
        calls.append(f"{CHANGE}:{token(block.die_id)}")
    if block.process_id is not None:
        calls.append(f"{PROCESS}:{token(block.process_id)}")
    return Step(
        n=block.n,
        kind=block.kind,
        axes=form.axes(block.axes),
        feed=None if block.dynamics is None else form.feed(block.dynamics.v_per_s),
        fastener=NO_NAME if block.fastener_id is None else token(block.fastener_id),
        origin=_origin(block.origin),
        calls=(*calls, *(token(event.code) for event in block.events)),
        record=encode(block) if form.whole_blocks else "",
    )


def _origin(origin: str) -> str:
    engine, colon, source = origin.partition(":")
    return f"{token(engine)}/{token(source)}" if colon else token(engine)
