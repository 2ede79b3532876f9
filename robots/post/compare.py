"""What a text says otherwise than the program it is held against."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from robots.post.content import HEAD_KEYS, Content, Step
from robots.post.form import AXES


@dataclass(frozen=True)
class Difference:
    """One thing that the text says otherwise: a stable code, one sentence, and where.

    line: in the text, from 1; None where the text lacks something.
    """

    code: str
    text: str
    line: int | None = None
    block_n: int | None = None


def differences(wanted: Content, found: Content) -> tuple[Difference, ...]:
    """Everything `found` says otherwise than `wanted`; empty where they say the same."""
    heads = tuple(_of_heads(wanted, found))
    if wanted.steps == found.steps:
        return heads
    steps = (*_of_order(wanted, found), *_of_blocks(wanted, found))
    unnamed = Difference("blocks", "the blocks differ")  # fail closed: equal is only what is found equal
    return (*heads, *(steps or (unnamed,)))


def _of_heads(wanted: Content, found: Content) -> Iterator[Difference]:
    lines = found.head_lines or (None,) * len(HEAD_KEYS)
    for key, right, wrong, line in zip(HEAD_KEYS, wanted.head, found.head, lines, strict=True):
        if right != wrong:
            yield Difference("header", f"the header's {key} is {wrong!r}, the program's {right!r}", line)
    for what, names, others in (
        ("dies", wanted.dies, found.dies),
        ("processes", wanted.processes, found.processes),
        ("waits", wanted.waits, found.waits),
    ):
        if names != others:
            yield Difference(
                "header", f"the header's {what} are {' '.join(others)}, the program's {' '.join(names)}"
            )


def _of_order(wanted: Content, found: Content) -> Iterator[Difference]:
    numbers = [step.n for step in wanted.steps]
    known = set(numbers)
    there = Counter(step.n for step in found.steps)
    for n in numbers:
        if n not in there:
            yield Difference("block_missing", f"block {n} is missing", None, n)
    seen: set[int] = set()
    for step in found.steps:
        if step.n not in known:
            yield Difference("block_extra", f"the program has no block {step.n}", step.line, step.n)
        elif step.n in seen:
            yield Difference("block_doubled", f"block {step.n} is there again", step.line, step.n)
        seen.add(step.n)
    once = [step for step in found.steps if step.n in known and there[step.n] == 1]
    for n, step in zip((n for n in numbers if there[n] == 1), once, strict=False):
        if n != step.n:
            text = f"block {step.n} stands where block {n} belongs"
            yield Difference("block_order", text, step.line, step.n)
            return


def _of_blocks(wanted: Content, found: Content) -> Iterator[Difference]:
    by_number = {step.n: step for step in wanted.steps}
    for step in found.steps:
        if step.n in by_number and step != by_number[step.n]:
            yield from _of_steps(by_number[step.n], step)


def _of_steps(wanted: Step, found: Step) -> Iterator[Difference]:
    for axis, right, wrong in zip(AXES, wanted.axes, found.axes, strict=True):
        if right != wrong:
            unit, digits = ("deg", 6) if axis in "ABC" else ("mm", 4)
            stated = f"{axis} is {wrong:.{digits}f} {unit}"
            yield _difference(found, "axis_value", stated, f"{right:.{digits}f} {unit}")
    others: tuple[tuple[str, str | float | None, str | float | None], ...] = (
        ("feed", found.feed, wanted.feed),
        ("kind", found.kind, wanted.kind),
        ("fastener", found.fastener, wanted.fastener),
        ("origin", found.origin, wanted.origin),
        ("calls", " ".join(found.calls), " ".join(wanted.calls)),
    )
    for code, says, ours in others:
        if says != ours:
            yield _difference(found, code, f"{code} is {says or 'none'}", f"{ours or 'none'}")
    if found.record != wanted.record:
        yield Difference("record", f"block {found.n} has other values in the program", found.line, found.n)


def _difference(found: Step, code: str, says: str, wanted: str) -> Difference:
    return Difference(code, f"block {found.n}: {says}, the program's is {wanted}", found.line, found.n)
