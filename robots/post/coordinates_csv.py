"""Coordinates as CSV: one row a block, for spreadsheets and scripts, not for a controller.

Comma, decimal point, no quotes: names stand as `form.token` makes them. The first rows begin with "#" and say
what the other texts' headers say. `feed_per_min` is the inverse time feed of the controllers' texts, empty at
rest; `calls` are what the machine is told there, in order, `wait:` before the event that waits.
"""

import re
from collections.abc import Iterator

from robots.nc import AXIS_FIELDS
from robots.post.content import HEAD_KEYS, KINDS, Content, Step
from robots.post.form import AXES, NO_NAME, TOKEN, Form
from robots.post.lines import Scanner, lines_of

FORM = Form()
COLUMNS = ("n", "kind", *AXIS_FIELDS, "feed_per_min", "fastener", "origin", "calls")

_NUMBER = r"-?[0-9]{1,7}(?:\.[0-9]{0,%d})?"
_CALL = rf"(?:[a-z]+:)?{TOKEN}"
_ROW = re.compile(
    ",".join(
        (
            r"(?P<n>[0-9]{1,8})",
            f"(?P<kind>{'|'.join(KINDS)})",
            *(f"(?P<{axis}>{_NUMBER % FORM.digits(axis)})" for axis in AXES),
            rf"(?P<feed>(?:[0-9]{{1,8}}(?:\.[0-9]{{0,{FORM.feed_digits}}})?)?)",
            rf"(?P<fastener>\{NO_NAME}|{TOKEN})",
            f"(?P<origin>{TOKEN}(?:/{TOKEN})?)",
            f"(?P<calls>(?:{_CALL}(?: {_CALL})*)?)",
        )
    )
)


def write(content: Content) -> str:
    """The table, lines ended by line feeds."""
    head = [f"# {key} {value}" for key, value in zip(HEAD_KEYS, content.head, strict=True)]
    named = ("dies", content.dies), ("processes", content.processes), ("waits", content.waits)
    head += [f"# {key} {' '.join(names)}".rstrip() for key, names in named]
    return "".join(f"{line}\n" for line in (*head, ",".join(COLUMNS), *map(_row, content.steps)))


def read(data: bytes) -> Content:
    """What a table says; raises `InvalidInput` naming the line that is none of it."""
    scanner = Scanner(lines_of(data))
    head = [(scanner.here.number, _named(scanner, key)) for key in HEAD_KEYS]
    dies, processes, waits = (tuple(_named(scanner, key).split()) for key in ("dies", "processes", "waits"))
    scanner.expect(",".join(COLUMNS))
    steps = tuple(_steps(scanner))
    lines = tuple(line for line, _ in head)
    return Content(tuple(v for _, v in head), dies, processes, steps, lines, waits)


def _row(step: Step) -> str:
    axes = (FORM.axis_text(axis, value) for axis, value in zip(AXES, step.axes, strict=True))
    feed = "" if step.feed is None else FORM.feed_text(step.feed)
    return ",".join((str(step.n), step.kind, *axes, feed, step.fastener, step.origin, " ".join(step.calls)))


def _named(scanner: Scanner, key: str) -> str:
    groups = scanner.take([re.compile(rf"# {key}(?P<value>(?: .*)?)")])
    if groups is None:
        scanner.fail(f"the line must be the header's {key}")
    return groups["value"].strip()


def _steps(scanner: Scanner) -> Iterator[Step]:
    while scanner.here:
        line = scanner.here
        groups = scanner.take([_ROW])
        if groups is None:
            scanner.fail("the line is no row of the table")
        yield Step(
            n=int(groups["n"]),
            kind=groups["kind"],
            axes=tuple(float(groups[axis]) for axis in AXES),
            feed=float(groups["feed"]) if groups["feed"] else None,
            fastener=groups["fastener"],
            origin=groups["origin"],
            calls=tuple(groups["calls"].split()),
            line=line.number,
        )
