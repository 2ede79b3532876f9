"""The dialects there are, and what can be done with one: post a program, read a text, check one."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from robots.errors import InputProblem, InvalidInput, UnknownName
from robots.nc import NcProgram
from robots.post import apt, coordinates_csv, fanuc30i, ndjson, rapid, sinumerik840d
from robots.post.compare import Difference, differences
from robots.post.content import Content, content_of
from robots.post.events import EVENT_CALLS
from robots.post.form import Form
from robots.post.grammar import Grammar
from robots.post.refusals import uncertified, unsayable


@dataclass(frozen=True)
class Dialect:
    """One way to write a program.

    title: its name for people. suffix: how its files end. refusals: why a program has no text in it. write:
    the text of a program that is not refused. read: what a text says, `InvalidInput` naming a line otherwise.
    form: digits of the content that is compared.
    """

    title: str
    suffix: str
    refusals: Callable[[NcProgram], Iterator[InputProblem]]
    write: Callable[[NcProgram], str]
    read: Callable[[bytes], Content]
    form: Form


def post(program: NcProgram, dialect: str) -> str:
    """The program as a text of a dialect, ASCII with line feeds.

    The text is read back before it is handed out. Raises `UnknownName` for a dialect there is not, and
    `InvalidInput` with every reason where the dialect cannot say what the program says.
    """
    chosen = _chosen(dialect, program)
    problems = list(chosen.refusals(program))
    if problems:
        raise InvalidInput(problems)
    text = chosen.write(program)
    found = check(text.encode("ascii"), program, dialect)
    if found:
        raise RuntimeError(f"{dialect}: the text does not say what the program says: {found[0]}")
    return text


def read(data: bytes, dialect: str) -> Content:
    """What a text says. Raises `UnknownName`, and `InvalidInput` naming the line that cannot be read."""
    return _named(dialect).read(data)


def check(data: bytes, program: NcProgram, dialect: str) -> tuple[Difference, ...]:
    """What a text says otherwise than the program; empty where they say the same. Raises as `read` does."""
    chosen = _chosen(dialect, program)
    return differences(content_of(program, chosen.form), chosen.read(data))


def _chosen(name: str, program: NcProgram) -> Dialect:
    if name == "rapid":
        raise InvalidInput([rapid.refusal(program)])
    return _named(name)


def _named(name: str) -> Dialect:
    if name not in DIALECTS:
        raise UnknownName("dialect", name, tuple(DIALECTS))
    return DIALECTS[name]


def _controller(title: str, suffix: str, grammar: Grammar) -> Dialect:
    def refusals(program: NcProgram) -> Iterator[InputProblem]:
        yield from uncertified(program)
        yield from unsayable(program, grammar.form, grammar.calls.events)

    def write(program: NcProgram) -> str:
        return grammar.write(content_of(program, grammar.form))

    return Dialect(title, suffix, refusals, write, grammar.read, grammar.form)


def _csv() -> Dialect:
    def refusals(program: NcProgram) -> Iterator[InputProblem]:
        return unsayable(program, coordinates_csv.FORM, EVENT_CALLS)

    def write(program: NcProgram) -> str:
        return coordinates_csv.write(content_of(program, coordinates_csv.FORM))

    return Dialect("Coordinates", ".csv", refusals, write, coordinates_csv.read, coordinates_csv.FORM)


def _ndjson() -> Dialect:
    form = Form(whole_blocks=True)

    def refusals(_: NcProgram) -> Iterator[InputProblem]:
        return iter(())

    def read(data: bytes) -> Content:
        program, lines = ndjson.read(data)
        content = content_of(program, form)
        steps = zip(content.steps, lines, strict=True)
        return replace(content, steps=tuple(replace(step, line=line) for step, line in steps))

    return Dialect("NDJSON", ".ndjson", refusals, ndjson.write, read, form)


GRAMMARS = MappingProxyType(
    {"sinumerik840d": sinumerik840d.GRAMMAR, "fanuc30i": fanuc30i.GRAMMAR, "apt": apt.GRAMMAR}
)
"""The dialects of controllers."""

DIALECTS: Mapping[str, Dialect] = MappingProxyType(
    {
        "sinumerik840d": _controller("SINUMERIK 840D", ".mpf", GRAMMARS["sinumerik840d"]),
        "fanuc30i": _controller("FANUC 30i", ".nc", GRAMMARS["fanuc30i"]),
        "apt": _controller("APT", ".apt", GRAMMARS["apt"]),
        "csv": _csv(),
        "ndjson": _ndjson(),
    }
)
"""Dialects by the name people use; "rapid" is refused with a reason."""
