"""Why a program has no text for a controller: what the text could not say, or must not."""

import math
from collections.abc import Collection, Iterator
from itertools import pairwise

from robots.errors import InputProblem
from robots.nc import AXIS_FIELDS, NcBlock, NcProgram
from robots.nc_json import program_sha256
from robots.post.content import wait_name, wait_names
from robots.post.form import Form

_LAWS = frozenset({"exact_stop", "overlap", "s_curve"})
"""The texts command an exact stop at every block. That runs as certified, because straight blocks are
certified whole, their corners rounded or not; it takes longer than a program with rounded corners says.
"""
_LARGEST_NUMBER = 99_999_999
_LARGEST_VALUE = 1e6  # [mm] or [deg]; no controller takes more digits
_MOST_NUMBERED = 99  # dies and processes: two digits


def uncertified(program: NcProgram) -> Iterator[InputProblem]:
    """Why a program must not reach a controller: no clean certificate for exactly these numbers."""
    certificate = program.verification
    if certificate is None:
        message, remedy = "the program has no certificate", "Plan it with rivetplan, which verifies it."
    elif certificate.result != "clean":
        message, remedy = "the verifier rejected the program", "Mend what its findings say and plan it again."
    elif certificate.program_sha256 != program_sha256(program):
        message, remedy = "the certificate is for another program", "Plan it anew; an edited file has none."
    else:
        return
    yield InputProblem("/verification", "uncertified", message, None, remedy)


def unsayable(program: NcProgram, form: Form, events: Collection[str]) -> Iterator[InputProblem]:
    """What a text with the digits of `form` and calls for these events cannot say."""
    policy, blocks = program.policy, program.blocks
    if not blocks:
        yield InputProblem("/blocks", "no_blocks", "the program has no blocks", None, "Plan it anew.")
    if policy.timing_law not in _LAWS or not policy.exact_stop_at_events:
        message = "the text stops exactly at every block, where the program may not"
        yield InputProblem(
            "/policy", "timing_law", message, policy.timing_law, "Plan it with the law exact_stop."
        )
    for name, items in (("dies", program.dies), ("processes", program.processes)):
        ids = [item.id for item in items]
        if len(set(ids)) != len(ids) or len(ids) > _MOST_NUMBERED:
            message = f"the text numbers {name} up to {_MOST_NUMBERED}, each once"
            yield InputProblem(f"/{name}", "not_numbered", message, len(ids), "List each id once.")
    yield from _waits(program)
    dies, processes = {die.id for die in program.dies}, {process.id for process in program.processes}
    for i, block in enumerate(blocks):
        for field, code, message, value in _of_block(block, form, events, dies, processes):
            yield InputProblem(f"/blocks/{i}/{field}", code, message, value, "Plan the program anew.")
    for i, (before, block) in enumerate(pairwise(blocks), start=1):
        for field, code, message, value in _of_pair(before, block):
            yield InputProblem(f"/blocks/{i}/{field}", code, message, value, "Plan the program anew.")
    if blocks and blocks[0].dynamics is not None:
        message = "the first block must state where the machine stands, without motion"
        yield InputProblem("/blocks/0/dynamics", "no_start", message, None, "Plan the program anew.")


def _waits(program: NcProgram) -> Iterator[InputProblem]:
    names = wait_names(program)
    if len(names) > _MOST_NUMBERED:
        message = f"the text numbers hand-shakes up to {_MOST_NUMBERED}"
        yield InputProblem("/processes", "not_numbered", message, len(names), "Use fewer timeouts.")
    for i, block in enumerate(program.blocks):
        for event in block.events:
            if event.handshake is not None and wait_name(event.handshake) not in names:
                message, at = "no process has the hand-shake of the event", f"/blocks/{i}/events"
                yield InputProblem(at, "unknown_handshake", message, event.code, "Plan the program anew.")


_Flaw = tuple[str, str, str, str | int | float | None]


def _of_block(
    block: NcBlock, form: Form, events: Collection[str], dies: Collection[str], processes: Collection[str]
) -> Iterator[_Flaw]:
    if not 1 <= block.n <= _LARGEST_NUMBER:
        yield "n", "block_number", f"block numbers go from 1 to {_LARGEST_NUMBER}", block.n
    for field in AXIS_FIELDS:
        value = getattr(block.axes, field)
        if not (math.isfinite(value) and abs(value) < _LARGEST_VALUE):
            yield f"axes/{field}", "axis_value", "the value has too many digits for a controller", value
    if block.dynamics is not None:
        if block.dynamics.law not in _LAWS:
            yield "dynamics/law", "timing_law", "the text stops exactly at every block", block.dynamics.law
        if not form.feed(block.dynamics.v_per_s) > 0.0:
            speed = block.dynamics.v_per_s
            yield "dynamics/v_per_s", "feed", "the feed is too small for the controller", speed
        if block.events or block.process_id is not None or block.kind == "die_change":
            yield "events", "event_in_motion", "the machine must rest where it is told to do something", None
    yield from _of_calls(block, events, dies, processes)


def _of_calls(
    block: NcBlock, events: Collection[str], dies: Collection[str], processes: Collection[str]
) -> Iterator[_Flaw]:
    if block.die_id not in dies:
        yield "die_id", "unknown_die", "the die is not among the program's", block.die_id
    if block.process_id is not None and block.process_id not in processes:
        yield "process_id", "unknown_process", "the process is not among the program's", block.process_id
    if block.events and block.process_id is None:
        yield "events", "no_process", "the events belong to no process", None
    for event in block.events:
        if event.code not in events:
            yield "events", "unknown_event", "the dialect has no call for the event", event.code


def _of_pair(before: NcBlock, block: NcBlock) -> Iterator[_Flaw]:
    if block.n <= before.n:
        yield "n", "block_number", "block numbers must rise", block.n
    if block.dynamics is None and block.axes != before.axes:
        yield "dynamics", "no_feed", "the block moves and has no dynamics", None
    if block.kind != "die_change" and block.die_id != before.die_id:
        yield (
            "die_id",
            "no_die_change",
            "the die differs from the block before, without a change",
            block.die_id,
        )
