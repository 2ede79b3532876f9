"""The program that a dialect's text stands for, so that it can be verified like any other.

A text says less than a program. What it says is taken from it: where each block ends, how fast at most, what
the machine is told to do; and from its comments what a block is for, which decides how it is judged. Blocks
are timed anew by the one law that a text commands, an exact stop at every block, with the machine's own
acceleration and jerk. The rest is that of the machine and the panel it is verified with. What the text lacks,
or says otherwise, is a finding: nothing is filled in that could make it pass.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, Context, Decimal

from planners.arrays import Array
from planners.retiming import PathLimits, path_limits, rest_to_rest
from robots.machine import Machine
from robots.nc import (
    BlockKind,
    Finding,
    NcAxes,
    NcBlock,
    NcDie,
    NcDynamics,
    NcEvent,
    NcFastener,
    NcHeader,
    NcPlanner,
    NcPolicy,
    NcProgram,
    NcReason,
)
from robots.nc_json import rounded
from robots.nc_numbers import SignificantDown
from robots.panel import Panel
from robots.post.content import CHANGE, HEAD_KEYS, KINDS, PROCESS, START, Content, Step, content_of
from robots.post.form import NO_NAME, Form, token
from robots.process_record import process_record
from robots.verify_inputs import inputs_of
from robots.verify_motions import AT_FASTENER
from service.block_writer import process_events
from service.program_writer import datums_record, fastener_record, machine_record, policy_record
from service.timing import MICRO, Timing, micro_up
from service.verification_summary import summary_of

_SECONDS_PER_MINUTE = 60
_LIMIT = SignificantDown(6)
_UP = Context(prec=6, rounding=ROUND_CEILING)
_LAW = re.compile(r"exact_stop(?: times by [a-z_]{1,22})?")
_UNITS = "mm deg 1/min"
_NUMBER = r"([0-9]{1,6}\.[0-9]{4})"
_POLICY = re.compile(rf"{_NUMBER} near {_NUMBER} within {_NUMBER} sag {_NUMBER}")
_GENERATOR = re.compile(r"(\S+) (\S+) seed ([0-9]{1,16})")


@dataclass(frozen=True)
class Meaning:
    """A program, and what is wrong with the text that the program cannot show."""

    program: NcProgram
    findings: tuple[Finding, ...]


def meaning_of(
    content: Content, form: Form, panel: Panel, machine: Machine, left_out: Collection[str] = ()
) -> Meaning:
    """The program that a text with these digits stands for, on this panel and machine.

    left_out: ids of fasteners that the text need not install.
    """
    head = dict(zip(HEAD_KEYS, content.head, strict=True))
    findings = [*_head_findings(head, panel, machine)]
    names = _Names.of(content, panel, machine)
    blocks = tuple(_blocks(content, names, panel, machine))
    findings += _still(content, blocks)
    fasteners = tuple(_fasteners(blocks, panel, left_out))
    findings += _missed(fasteners, left_out)
    policy, problems = _policy(head["policy-mm"], panel, machine)
    program = NcProgram(
        header=NcHeader(head["program"], panel.title, _planner(head), inputs_of(panel, machine)),
        machine=machine_record(machine),
        datums=datums_record(panel),
        policy=policy,
        dies=tuple(
            NcDie(each, machine.dies[each].axisymmetric) for each in _listed(content.dies, names.dies)
        ),
        processes=tuple(
            process_record(machine.processes[each], panel.fasteners, machine.retract_margin)
            for each in _listed(content.processes, names.processes)
        ),
        blocks=(),
        fasteners=fasteners,
        summary=summary_of(blocks, fasteners),
    )
    program = replace(rounded(program), blocks=blocks)
    return Meaning(program, (*findings, *problems, *_unsaid(content, program, form)))


@dataclass(frozen=True)
class _Names:
    """Ids by what stands for them in the text. Other names stay as they are, for the verifier to find."""

    dies: Mapping[str, str]
    processes: Mapping[str, str]
    fasteners: Mapping[str, str]

    @staticmethod
    def of(content: Content, panel: Panel, machine: Machine) -> _Names:
        dies, processes = set(content.dies), set(content.processes)
        return _Names(
            {token(die.id): die.id for die in machine.dies if token(die.id) in dies},
            {
                token(process.id): process.id
                for process in machine.processes
                if token(process.id) in processes
            },
            {token(fastener.id): fastener.id for fastener in panel.fasteners},
        )


def _listed(names: Sequence[str], ids: Mapping[str, str]) -> list[str]:
    """The ids of those that are known, each once, in the order of the header."""
    return list(dict.fromkeys(ids[name] for name in names if name in ids))


def _head_findings(head: Mapping[str, str], panel: Panel, machine: Machine) -> Iterator[Finding]:
    wanted = (
        ("machine", token(machine.id), "machine_data"),
        ("machine-sha256", token(machine.sha256[:16]), "input_hash"),
        ("panel", token(panel.id), "input_hash"),
        ("units", _UNITS, "units"),
    )
    for key, right, code in wanted:
        if head[key] != right:
            yield Finding(code, f"the text's header names the {key} {head[key]!r}, checked against {right!r}")
    if not _LAW.fullmatch(head["law"]):
        text = f"the text's header names the law {head['law']!r}; a text can only command exact_stop"
        yield Finding("timing_law", text)


def _policy(said: str, panel: Panel, machine: Machine) -> tuple[NcPolicy, list[Finding]]:
    """What the header says of clearances; pairs and depth of contact are the machine's."""
    policy = policy_record(panel, machine, Timing())
    numbers = _POLICY.fullmatch(said)
    if numbers is None:
        return policy, [Finding("policy_weakened", f"the header's clearances cannot be read: {said!r}")]
    default, near, radius, sag = map(float, numbers.groups())
    clearance = replace(
        policy.clearance_mm, default=default, near_fastener=near, near_radius_mm=radius, sag_mm=sag
    )
    return replace(policy, clearance_mm=clearance), []


def _planner(head: Mapping[str, str]) -> NcPlanner:
    """Who made the program, as the header says: nothing depends on it."""
    said = _GENERATOR.fullmatch(head["generator"])
    return NcPlanner(said[1], said[2], int(said[3])) if said else NcPlanner(head["generator"], "", 0)


def _blocks(content: Content, names: _Names, panel: Panel, machine: Machine) -> Iterator[NcBlock]:
    stacks = {f.id: s.parts for f, s in zip(panel.fasteners, panel.stacks, strict=True)}
    before: Array | None = None
    die_id, now = "", 0
    for step in content.steps:
        axes = NcAxes(*step.axes)
        die_id = _called(step, START if before is None else CHANGE, names.dies) or die_id
        block = NcBlock(
            n=step.n,
            kind=_kind(step.kind),
            axes=axes,
            t_start_s=now / MICRO,
            t_end_s=now / MICRO,
            die_id=die_id,
            fastener_id=None
            if step.fastener == NO_NAME
            else names.fasteners.get(step.fastener, step.fastener),
            process_id=_called(step, PROCESS, names.processes),
            origin=step.origin.replace("/", ":", 1),
        )
        if block.kind in AT_FASTENER:
            parts = stacks.get(block.fastener_id or "", ())
            block = replace(block, allowed_contacts=tuple(("tip", part) for part in parts))
        events, lasts = _at_rest(step, block, machine)
        dynamics = None
        if step.feed is not None:
            dynamics, lasts = _in_motion(step.feed, axes.q - (axes.q if before is None else before), machine)
        now += lasts
        yield replace(block, t_end_s=now / MICRO, events=events, dynamics=dynamics)
        before = axes.q


def _kind(name: str) -> BlockKind:
    (kind,) = (known for known in KINDS if known == name)
    return kind  # type: ignore[return-value]  # KINDS are those of the literal


def _called(step: Step, what: str, ids: Mapping[str, str]) -> str | None:
    """The die or process that the block calls for last; None where it calls for none."""
    said = [call.partition(":")[2] for call in step.calls if call.startswith(f"{what}:")]
    return ids.get(said[-1], said[-1]) if said else None


def _at_rest(step: Step, block: NcBlock, machine: Machine) -> tuple[tuple[NcEvent, ...], int]:
    """The events of a block and how long they take [us]; out of the process's order all begin at once."""
    codes = [call for call in step.calls if ":" not in call]
    if block.kind == "process" and block.process_id in machine.processes.ids:
        events, duration_us = process_events(machine.processes[block.process_id])
        if [event.code for event in events] == codes:
            return events, duration_us
    duration_us = micro_up(machine.die_change_duration) if block.kind == "die_change" else 0
    return tuple(NcEvent(code, 0.0) for code in codes), duration_us


def _in_motion(feed: float, delta: Array, machine: Machine) -> tuple[NcDynamics | None, int]:
    """Limits and time [us] of a motion; None where nothing moves.

    The speed is rounded up, so that it is never less than the text commands: a text of ours has that of its
    program again, wherever its digits reach.
    """
    if not delta.any():
        return None, 0
    own = path_limits(delta, machine.v_max, machine.a_max, machine.j_max)
    speed = float(_UP.divide(Decimal(repr(feed)), Decimal(_SECONDS_PER_MINUTE)))
    limits = PathLimits(speed, _LIMIT.rounded(own.a), _LIMIT.rounded(own.j))
    lasts = micro_up(rest_to_rest(limits).duration) if speed > 0.0 else 0
    return NcDynamics(limits.v, limits.a, limits.j), lasts


def _still(content: Content, blocks: tuple[NcBlock, ...]) -> Iterator[Finding]:
    for step, block in zip(content.steps, blocks, strict=True):
        if step.feed is not None and block.dynamics is None:
            text = f"block {block.n} commands a motion to where the machine stands"
            yield Finding("no_motion", text, block.n, block.fastener_id)


def _fasteners(blocks: tuple[NcBlock, ...], panel: Panel, left_out: Collection[str]) -> Iterator[NcFastener]:
    at = {block.fastener_id: block for block in blocks if block.kind == "process"}
    for fastener, stack in zip(panel.fasteners, panel.stacks, strict=True):
        record, block = fastener_record(fastener, stack), at.get(fastener.id)
        if block is not None:
            yield replace(record, die_id=block.die_id, die_angle_deg=block.axes.C_deg, block_n=block.n)
            continue
        said = "the request leaves it out" if fastener.id in left_out else "the text says nothing of it"
        yield replace(record, status="excluded", reason=NcReason("not_in_text", said))


def _missed(fasteners: tuple[NcFastener, ...], left_out: Collection[str]) -> Iterator[Finding]:
    for each in fasteners:
        if each.status != "installed" and each.id not in left_out:
            text = f"fastener {each.id} is not installed by the text, which cannot say why"
            yield Finding("fastener_missed", text, None, each.id)
        if each.status == "installed" and each.id in left_out:
            text = f"fastener {each.id} is installed by the text, and the request leaves it out"
            yield Finding("fastener_status", text, each.block_n, each.id)


def _unsaid(content: Content, program: NcProgram, form: Form) -> Iterator[Finding]:
    """What a text of the program would say otherwise: then this one does not stand for it.

    Feeds are not compared: the program's speeds are theirs, rounded. Origins neither: nothing depends on
    them.
    """
    wanted = content_of(program, form)
    for what in ("dies", "processes", "waits"):
        listed, ours = getattr(content, what), getattr(wanted, what)
        if listed != ours:
            text = f"the header lists the {what} {' '.join(listed)!r}; these are {' '.join(ours)!r}"
            yield Finding("header", text)
    for step, ours in zip(content.steps, wanted.steps, strict=True):
        if replace(ours, feed=step.feed, origin=step.origin, record=step.record) != step:
            says, wants = " ".join(step.calls) or "nothing", " ".join(ours.calls) or "nothing"
            text = f"block {step.n} ({step.kind}) calls for {says}; what it stands for is {wants}"
            yield Finding("calls", text, step.n)
