"""Reading texts line by line, trusting nothing: whatever is wrong is an `InvalidInput` naming the line."""

import re
from collections.abc import Mapping, Sequence
from typing import NoReturn

from robots.errors import InputProblem, InvalidInput

_MOST_CHARACTERS = 2_000  # of a line; no controller takes as many
_CONTROL = re.compile(r"[\x00-\x08\x0a-\x1f\x7f]")


class Line(str):
    """The text of a line with single spaces and none at its ends, and where it stands, from 1."""

    number: int

    @staticmethod
    def of(text: str, number: int) -> "Line":
        """Line `number` of a text."""
        line = Line(" ".join(text.split()))
        line.number = number
        return line


def unreadable(number: int, message: str, text: str, remedy: str) -> InvalidInput:
    """The error for one line. `pointer` says which."""
    return InvalidInput([InputProblem(f"line {number}", "unreadable_line", message, text, remedy)])


def lines_of(data: bytes) -> list[Line]:
    """The lines of a text that are not blank; raises `InvalidInput` for what no controller takes."""
    found = []
    for number, raw in enumerate(data.split(b"\n"), start=1):
        text = raw.removesuffix(b"\r").decode("ascii", "backslashreplace")
        if not raw.isascii() or _CONTROL.search(text):
            raise unreadable(number, "the line has characters that are not plain ASCII", text, "Remove them.")
        if len(text) > _MOST_CHARACTERS:
            raise unreadable(number, "the line is too long", text, f"At most {_MOST_CHARACTERS} characters.")
        if text.strip():
            found.append(Line.of(text, number))
    return found


class Scanner:
    """A place in the lines of a text."""

    def __init__(self, lines: Sequence[Line]) -> None:
        self._lines = lines
        self._at = 0
        self._farthest = 0

    @property
    def here(self) -> Line:
        """The line that comes next; empty behind the last one."""
        if self._at < len(self._lines):
            return self._lines[self._at]
        return Line.of("", self._lines[-1].number + 1 if self._lines else 1)

    def take(self, patterns: Sequence[re.Pattern[str]]) -> Mapping[str, str] | None:
        """Go past a line for each pattern; their named groups, or None where one does not match."""
        groups: dict[str, str] = {}
        for i, pattern in enumerate(patterns):
            self._farthest = max(self._farthest, self._at + i)
            at = self._at + i
            match = pattern.fullmatch(self._lines[at]) if at < len(self._lines) else None
            if match is None:
                return None
            groups |= match.groupdict()
        self._at += len(patterns)
        return groups

    def expect(self, text: str) -> None:
        """Go past a line that must be exactly this one."""
        if self.here != text:
            self.fail(f"the line must be {text!r}")
        self._at += 1

    def rest(self) -> list[Line]:
        """The lines from here to the end."""
        return list(self._lines[self._at :])

    def pass_line(self) -> None:
        """Go on to the next line."""
        self._at += 1

    def fail(self, message: str) -> NoReturn:
        """Raise `InvalidInput` for the farthest line that was looked at."""
        self._at = max(self._at, min(self._farthest, len(self._lines)))
        line = self.here
        ended = "" if line else "; the text ends here"
        raise unreadable(line.number, message + ended, line, "Restore the line as it was posted.")
