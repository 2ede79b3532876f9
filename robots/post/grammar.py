"""Texts of controllers: templates of lines that say both how a text is written and how it is read.

A template is a line with places: {n} the block number; {X} {Y} {Z} {A} {B} {W} {C} axis values; {F} the
inverse time feed; {why} kind, fastener and origin of the block. A reader accepts what the templates can make,
more spaces, fewer decimals and whole lines of comment, and nothing else.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from string import Formatter

from robots.post.content import CHANGE, HEAD_KEYS, KINDS, PROCESS, START, WAIT, Content, Step
from robots.post.form import AXES, NO_NAME, TOKEN, Form
from robots.post.lines import Scanner, lines_of

_WHY = rf"(?P<kind>{'|'.join(KINDS)}) (?P<fastener>\{NO_NAME}|{TOKEN}) (?P<origin>{TOKEN}(?:/{TOKEN})?)"
_VALUE = r"[A-Za-z0-9._=/ -]+"

Templates = tuple[str, ...]


@dataclass(frozen=True)
class Calls:
    """Lines by which the machine is told what to do; {k} numbers dies, processes or hand-shakes from 1.

    start: this die must be in the machine. change: put this die in. process: what the next events belong to.
    wait: acknowledged when the hand-shake's signal is there, an alarm when its time is over. events: line by
    event code. The machine acknowledges each before the next line runs.
    """

    start: str
    change: str
    process: str
    wait: str
    events: Mapping[str, str]

    def lines(self, dies: Sequence[str], processes: Sequence[str], waits: Sequence[str]) -> dict[str, str]:
        """Every call there can be, and its line."""
        named = {f"{START}:{die}": self.start.format(k=k) for k, die in enumerate(dies, 1)}
        named |= {f"{CHANGE}:{die}": self.change.format(k=k) for k, die in enumerate(dies, 1)}
        named |= {f"{PROCESS}:{name}": self.process.format(k=k) for k, name in enumerate(processes, 1)}
        named |= {f"{WAIT}:{name}": self.wait.format(k=k) for k, name in enumerate(waits, 1)}
        return named | dict(self.events)


@dataclass(frozen=True)
class Grammar:
    """A dialect of a controller.

    top: lines before the header. note: a line of comment around {}. opening: lines that set the controller's
    state. rest: a block without motion. motion: a block with motion. position: lines by which the controller
    itself makes sure that it stands where the program starts. closing: the end. width: the most characters a
    line may have.
    """

    form: Form
    top: Templates
    note: str
    opening: Templates
    rest: Templates
    motion: Templates
    position: Templates
    closing: Templates
    calls: Calls
    width: int

    def write(self, content: Content) -> str:
        """The text, lines ended by line feeds."""
        lines = list(self._lines(content))
        longest = max(lines, key=len)
        if len(longest) > self.width:
            raise RuntimeError(f"the controller takes {self.width} characters a line: {longest}")
        return "".join(f"{line}\n" for line in lines)

    def read(self, data: bytes) -> Content:
        """What a text says; raises `InvalidInput` naming the line that is not of this dialect."""
        scanner = Scanner(lines_of(data))
        for line in self.top:
            scanner.expect(line)
        head = [(scanner.here.number, self._named(scanner, f"{key} ", _VALUE)) for key in HEAD_KEYS]
        dies = tuple(self._numbered(scanner, "die"))
        processes = tuple(self._numbered(scanner, "process"))
        waits = tuple(self._numbered(scanner, "wait"))
        scanner = Scanner([line for line in scanner.rest() if not self._comment.fullmatch(line)])
        for line in self.opening:
            scanner.expect(line)
        calls = {line: call for call, line in self.calls.lines(dies, processes, waits).items()}
        steps = tuple(self._steps(scanner, calls))
        for line in self.closing:
            scanner.expect(line)
        if scanner.here:
            scanner.fail("the program has ended before this line")
        lines = tuple(line for line, _ in head)
        return Content(tuple(v for _, v in head), dies, processes, steps, lines, waits)

    def _lines(self, content: Content) -> Iterator[str]:
        yield from self.top
        for key, value in zip(HEAD_KEYS, content.head, strict=True):
            yield self.note.format(f"{key} {value}")
        named = ("die", content.dies), ("process", content.processes), ("wait", content.waits)
        for what, names in named:
            for k, name in enumerate(names, 1):
                yield self.note.format(f"{what} {k} {name}")
        yield from self.opening
        calls = self.calls.lines(content.dies, content.processes, content.waits)
        for i, step in enumerate(content.steps):
            places = self._places(step)
            for template in self.rest if step.feed is None else self.motion:
                yield template.format_map(places)
            for call in step.calls:
                yield calls[call]
            for template in self.position if i == 0 else ():
                yield template.format_map(places)
        yield from self.closing

    def _places(self, step: Step) -> dict[str, str]:
        axes = zip(AXES, step.axes, strict=True)
        return {axis: self.form.axis_text(axis, value) for axis, value in axes} | {
            "n": str(step.n),
            "F": self.form.feed_text(step.feed or 0.0),
            "why": f"{step.kind} {step.fastener} {step.origin}",
        }

    def _steps(self, scanner: Scanner, calls: Mapping[str, str]) -> Iterator[Step]:
        axes: tuple[float, ...] | None = None
        while scanner.here != self.closing[0]:
            line = scanner.here
            groups = scanner.take(self._motion)
            moves = groups is not None
            groups = groups or scanner.take(self._rest)
            if groups is None:
                scanner.fail("the line is none that can stand here")
            called = tuple(_calls(scanner, calls))
            if axes is None:
                values = None if moves else scanner.take(self._position)
                if values is None:
                    scanner.fail("the first block must state where the machine stands")
                axes = _axes(values)
            elif moves:
                axes = _axes(groups)
            feed = float(groups["F"]) if moves else None
            said = groups["kind"], axes, feed, groups["fastener"], groups["origin"], called
            yield Step(int(groups["n"]), *said, line=line.number)

    def _named(self, scanner: Scanner, start: str, value: str) -> str:
        pattern = re.compile(_escaped(self.note.format("\0")).replace("\0", f"{start}(?P<value>{value})"))
        groups = scanner.take([pattern])
        if groups is None:
            scanner.fail(f"the line must be the header's {start.strip()}")
        return groups["value"]

    def _numbered(self, scanner: Scanner, what: str) -> Iterator[str]:
        k = 1
        while scanner.here.startswith(self.note.partition("{")[0] + f"{what} {k} "):
            yield self._named(scanner, f"{what} {k} ", TOKEN)
            k += 1

    @cached_property
    def _comment(self) -> re.Pattern[str]:
        text = r"[^()]*" if "(" in self.note else ".*"
        return re.compile(_escaped(self.note.replace(" ", "").format("\0")).replace("\0", text))

    @cached_property
    def _rest(self) -> list[re.Pattern[str]]:
        return self._patterns(self.rest)

    @cached_property
    def _motion(self) -> list[re.Pattern[str]]:
        return self._patterns(self.motion)

    @cached_property
    def _position(self) -> list[re.Pattern[str]]:
        return self._patterns(self.position)

    def _patterns(self, templates: Templates) -> list[re.Pattern[str]]:
        return [re.compile("".join(self._parts(template))) for template in templates]

    def _parts(self, template: str) -> Iterator[str]:
        """A regular expression for each part of a template."""
        for literal, name, _, _ in Formatter().parse(template):
            yield _escaped(literal)
            if name == "why":
                yield _WHY
            elif name == "n":
                yield r"(?P<n>[0-9]{1,8})"
            elif name == "F":
                yield rf"(?P<F>[0-9]{{1,8}}(?:\.[0-9]{{0,{self.form.feed_digits}}})?)"
            elif name is not None:
                yield rf"(?P<{name}>-?[0-9]{{1,7}}(?:\.[0-9]{{0,{self.form.digits(name)}}})?)"


def _escaped(text: str) -> str:
    return re.escape(text).replace("\\\0", "\0")


def _axes(groups: Mapping[str, str]) -> tuple[float, ...]:
    return tuple(float(groups[axis]) for axis in AXES)


def _calls(scanner: Scanner, calls: Mapping[str, str]) -> Iterator[str]:
    while scanner.here in calls:
        yield calls[scanner.here]
        scanner.pass_line()
