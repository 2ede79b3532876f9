"""The independent verifier: examines a program block by block and writes its certificate.

It starts from the numbers of the NC program and shares no collision code, kinematics or timing with the
planner: the panel as convex pieces, machine solids as support functions, separating planes as proof, its own
forward kinematics (compiled, in `robots.proof`) and its own rest-to-rest profile. It fails closed: what could
not be examined is a finding.

    verify      a certificate for a finished program (its own certificate, if it has one, is checked too)
    certified   a program with proven clearances in its blocks and its certificate in place
"""

from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from planners.arrays import Array
from robots.machine import Machine
from robots.nc import Certificate, Finding, NcBlock, NcChecker, NcClearance, NcMinClearance, NcProgram
from robots.nc_codec import Decimals, DecimalsDown
from robots.nc_digits import as_written
from robots.nc_json import program_sha256, rounded_certificate, with_certificate
from robots.panel import Panel
from robots.proof.items import SHARPNESS
from robots.proof.layout import Ints
from robots.verify_blend import rounded_corners
from robots.verify_clearance import MOST_VIOLATIONS, Clearance, Covered, TooClose, cover, until_next
from robots.verify_fasteners import fastener_findings
from robots.verify_hidden import hidden_findings
from robots.verify_inputs import input_findings, inputs_of
from robots.verify_motion import motion_findings, within_travel
from robots.verify_motions import configurations
from robots.verify_order import order_findings
from robots.verify_profile import profile_of, time_of

CHECKER = NcChecker("rivetplan-verify", "1")
MAX_PER_CODE = 100
"""Findings of one code that are listed; a program for another panel must not give a huge certificate."""
_UNREADABLE = "0" * 64
_DOWN, _DIGITS = DecimalsDown(4), Decimals(6)  # clearances are stated as the file will hold them


@dataclass(frozen=True, eq=False)
class Examination:
    """Findings in block order, proven clearance per block (None: unknown or too close), poses seen."""

    findings: tuple[Finding, ...]
    clearances: tuple[NcClearance | None, ...]
    samples: int


def verify(program: NcProgram, panel: Panel, machine: Machine) -> Certificate:
    """Examine a finished program and certify or reject it."""
    return certificate(program, examine(program, panel, machine), panel, machine)


def certified(program: NcProgram, panel: Panel, machine: Machine) -> NcProgram:
    """Examine a program once, write its blocks' clearances and its certificate into it."""
    program = replace(as_written(program), verification=None)
    examination = examine(program, panel, machine)
    blocks = tuple(
        replace(block, clearance=clearance)
        for block, clearance in zip(program.blocks, examination.clearances, strict=True)
    )
    program = replace(program, blocks=blocks)
    return with_certificate(program, certificate(program, examination, panel, machine))


def examine(program: NcProgram, panel: Panel, machine: Machine) -> Examination:
    """Check everything there is to check; never raises for what the program says."""
    findings: list[Finding] = []
    checks: tuple[tuple[str, Callable[[], Iterator[Finding]]], ...] = (
        ("inputs", lambda: input_findings(program, panel, machine)),
        ("order", lambda: order_findings(program, panel, machine)),
        ("motion", lambda: motion_findings(program, machine)),
        ("fasteners", lambda: fastener_findings(program, panel, machine)),
        ("hidden", lambda: hidden_findings(program, panel, machine)),
    )
    proven: list[tuple[tuple[NcClearance | None, ...], int]] = []
    # What is compiled runs without the interpreter's lock: the clearances are proved meanwhile.
    with ThreadPoolExecutor(1) as beside:
        clearance = beside.submit(
            _guarded, "clearance", lambda: _clearance_findings(program, panel, machine, proven)
        )
        for name, check in checks:
            findings += _guarded(name, check)
        findings += clearance.result()
    clearances, poses = proven[0] if proven else ((None,) * len(program.blocks), 0)
    return Examination(_sorted(findings), clearances, poses)


def certificate(program: NcProgram, examination: Examination, panel: Panel, machine: Machine) -> Certificate:
    """The certificate of an examined program; it names the hash of the program as it is now."""
    findings = examination.findings
    try:
        identity = program_sha256(program)
    except ValueError as error:  # a number that cannot be written
        identity = _UNREADABLE
        findings = (Finding("not_writable", f"the program has no canonical text: {error}"), *findings)
    flawed = {finding.block_n for finding in findings}
    proven = [
        block
        for block, clearance in zip(program.blocks, examination.clearances, strict=True)
        if clearance is not None and block.n not in flawed
    ]
    written = Certificate(
        checker=CHECKER,
        result="rejected" if findings or len(proven) != len(program.blocks) else "clean",
        findings=_limited(findings),
        min_clearance=_least(program.blocks, examination),
        certified_blocks=len(proven),
        samples=examination.samples,
        program_sha256=identity,
        inputs=inputs_of(panel, machine),
    )
    return rounded_certificate(written)


def _guarded(name: str, check: Callable[[], Iterator[Finding]]) -> list[Finding]:
    """Findings of a check; an error in it is one too, so that nothing unexamined is ever called clean."""
    found: list[Finding] = []
    try:
        found.extend(check())
    except Exception as error:
        text = f"the check of {name} stopped: {type(error).__name__}: {error}"
        found.append(Finding("not_examined", text))
    return found


def _clearance_findings(
    program: NcProgram,
    panel: Panel,
    machine: Machine,
    result: list[tuple[tuple[NcClearance | None, ...], int]],
) -> Iterator[Finding]:
    """Cover all blocks that can be placed; clearances per block and the number of poses go into `result`."""
    q = configurations(program.blocks)
    rows = _placeable(program.blocks, q, machine)
    if len(rows) < len(program.blocks):
        left = sorted({block.n for block in program.blocks} - {program.blocks[row].n for row in rows})
        text = (
            f"{len(left)} blocks, from block {left[0] if left else '?'} on, cannot be placed: travel or die"
        )
        yield Finding("not_examined", text, left[0] if left else None)
    corners, _ = rounded_corners(program, q)
    covered = cover(program.blocks, q, rows, panel, machine, corners)
    for violation in covered.violations:
        yield _too_close(program.blocks[violation.row], violation, machine)
    if not covered.complete:
        text = f"more than {MOST_VIOLATIONS} places are too close: the program was not examined any further"
        yield Finding("not_examined", text)
    for row in covered.undecided:
        n = program.blocks[row].n
        yield Finding("not_examined", f"block {n} needs more room than the examination has", n)
    for row, deviation in covered.astray:
        yield _astray(program.blocks[row], deviation)
    for row in rows if covered.complete else ():
        block = program.blocks[row]
        if block.kind == "process" and int(row) not in covered.touching:
            text = f"block {block.n}: the die tip does not stand on the stack of {block.fastener_id}"
            yield Finding("tip_not_in_contact", text, block.n, block.fastener_id)
    clearances = _stated(program.blocks, covered)
    yield from _overstated(program.blocks, clearances)
    result.append((clearances, covered.poses))


def _placeable(blocks: tuple[NcBlock, ...], q: Array, machine: Machine) -> Ints:
    """Rows of blocks whose two ends, of `q` (B, n), are within travel and whose die is known."""
    inside = within_travel(q, machine)
    known = {die_id: die_id in machine.dies.ids for die_id in {block.die_id for block in blocks}}
    of_known = np.array([known[block.die_id] for block in blocks], dtype=np.bool_)
    return np.flatnonzero(inside & np.concatenate([inside[:1], inside[:-1]]) & of_known)


def _too_close(block: NcBlock, found: TooClose, machine: Machine) -> Finding:
    at = f"block {block.n} ({block.kind}" + (f", {block.fastener_id})" if block.fastener_id else ")")
    gap, need, time = 1e3 * found.gap, 1e3 * found.need, _time(block, found.s)
    if found.corner_at is not None:
        at, time = f"{at}, in the corner at its end", until_next(block) + found.corner_at
    if found.in_stack:
        depth = 1e3 * machine.policy.contact_depth
        text = (
            f"{at}: {found.solid} is {gap:.3f} mm from {found.other} at {time:.3f} s; "
            f"it may touch it face to face, at most {depth:.3f} mm deep, or keep {need:.3f} mm"
        )
        code = "contact_too_deep"
    else:
        text = f"{at}: {found.solid} is {gap:.3f} mm from {found.other} at {time:.3f} s, needs {need:.3f} mm"
        code = "clearance"
    if found.corner_at is not None and gap >= need:
        text = f"{text}, which is not proven: the axes may be a little off there"
    pair = (found.solid, found.other)
    return Finding(code, text, block.n, block.fastener_id, pair, gap, need, time)


def _astray(block: NcBlock, deviation: float) -> Finding:
    stated = 0.0 if block.blend is None else block.blend.deviation_mm
    text = (
        f"block {block.n}: in the corner at its end the tip may be {1e3 * deviation:.4f} mm off its way, "
        f"{stated:.4f} mm are stated"
    )
    return Finding("blend_deviation", text, block.n, block.fastener_id)


def _stated(blocks: tuple[NcBlock, ...], covered: Covered) -> tuple[NcClearance | None, ...]:
    def stated(block: NcBlock, found: Clearance | None) -> NcClearance | None:
        if found is None:
            return None
        time = _time(block, found.s) if found.at is None else found.at
        mm, at = _DOWN.text(1e3 * found.proven), _DIGITS.text(time)
        return NcClearance(float(mm), found.pair, float(at))

    return tuple(stated(block, found) for block, found in zip(blocks, covered.clearances, strict=True))


def _overstated(blocks: tuple[NcBlock, ...], clearances: tuple[NcClearance | None, ...]) -> Iterator[Finding]:
    """A stated clearance may be sharper than the proven one by the sharpness of the proof, not more."""
    for block, proven in zip(blocks, clearances, strict=True):
        if block.clearance is None or proven is None:
            continue
        if not block.clearance.min_mm <= proven.min_mm + 1e3 * SHARPNESS:
            text = (
                f"block {block.n} states a clearance of {block.clearance.min_mm:.4f} mm, "
                f"{proven.min_mm:.4f} mm are proven"
            )
            yield Finding("clearance_overstated", text, block.n, block.fastener_id)


def _time(block: NcBlock, s: float) -> float:
    """Offset from the start of the block at which the path parameter is s, [s]."""
    duration = block.t_end_s - block.t_start_s
    if not (np.isfinite(duration) and duration > 0.0):
        return 0.0
    profile = None if block.dynamics is None else profile_of(block.dynamics)
    return s * duration if profile is None else min(time_of(profile, s), duration)


def _least(blocks: tuple[NcBlock, ...], examination: Examination) -> NcMinClearance | None:
    """The smallest clearance of the program, violations included."""
    stated = zip(blocks, examination.clearances, strict=True)
    found = [NcMinClearance(c.min_mm, c.pair, b.n, c.at_s) for b, c in stated if c is not None and c.pair]
    found += [
        NcMinClearance(f.clearance_mm, f.pair, f.block_n, f.at_s or 0.0)
        for f in examination.findings
        if f.pair is not None and f.clearance_mm is not None and f.block_n is not None
    ]
    return min(found, key=lambda least: (least.mm, least.block_n), default=None)


def _sorted(findings: list[Finding]) -> tuple[Finding, ...]:
    """In block order, findings about no block first; the order within a block is that of the checks."""
    return tuple(sorted(findings, key=lambda f: -1 if f.block_n is None else f.block_n))


def _limited(findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """The first findings of each code: a common one must not hide a rare one. The rest are counted."""
    seen: Counter[str] = Counter()
    listed = []
    for finding in findings:
        seen[finding.code] += 1
        if seen[finding.code] <= MAX_PER_CODE:
            listed.append(finding)
    left = {code: count - MAX_PER_CODE for code, count in sorted(seen.items()) if count > MAX_PER_CODE}
    if left:
        text = "not listed: " + ", ".join(f"{count} more of {code}" for code, count in left.items())
        listed.append(Finding("more_findings", text))
    return tuple(listed)
