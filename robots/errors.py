"""Errors of the robots layer.

    Exception
      ValueError
        InvalidInput        a definition (machine, dies, panel, program ...) is wrong; every problem at once

An `InputProblem` is plain data, so an `InvalidInput` crosses process borders and becomes JSON without loss.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

#: What a problem shows of the offending value: always fit for JSON (no NaN, no containers).
Shown = str | int | float | bool | None

_SHOWN_CHARACTERS = 80


def shown(value: object) -> Shown:
    """Return `value` in a form fit for JSON and for a person: scalars as they are, the rest as short text."""
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, float) and math.isfinite(value):
        return value
    if isinstance(value, int) and abs(value) < 2**53:
        return value
    if isinstance(value, int):
        return f"an integer of {value.bit_length()} bits"
    text = value if isinstance(value, str) else repr(value)
    return text if len(text) <= _SHOWN_CHARACTERS else text[: _SHOWN_CHARACTERS - 3] + "..."


@dataclass(frozen=True)
class InputProblem:
    """One thing that is wrong with an input, with the way out.

    pointer: JSON pointer (RFC 6901) to the value, "" for the whole document.
    code: stable lower_snake_case name of the kind of problem, for programs.
    message: what is wrong, one sentence, for people.
    value: the offending value, kept as `shown` gives it.
    remedy: what to do about it, one sentence.
    """

    pointer: str
    code: str
    message: str
    value: Shown
    remedy: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", shown(self.value))

    def __str__(self) -> str:
        where = self.pointer or "(whole document)"
        return f"{where}: {self.message} (got {self.value!r}). {self.remedy}"


class InvalidInput(ValueError):
    """An input cannot be used; `problems` lists everything that is wrong, not only the first thing."""

    def __init__(self, problems: Sequence[InputProblem]) -> None:
        if not problems:
            raise ValueError("InvalidInput needs at least one problem")
        self.problems = tuple(problems)
        super().__init__(self.problems)  # the same argument again, so that unpickling works

    def __str__(self) -> str:
        count = len(self.problems)
        head = "1 problem" if count == 1 else f"{count} problems"
        return "\n".join([f"{head} in the input:", *(f"  {problem}" for problem in self.problems)])


class UnknownName(InvalidInput):
    """No machine, die, process, axis or link has this name; `known` lists the names there are.

    kind: what was looked for ("machine", "die", ...). name: what was asked. known: the names that exist.
    """

    def __init__(self, kind: str, name: str, known: Sequence[str]) -> None:
        self.kind, self.name, self.known = kind, name, tuple(known)
        super().__init__(
            [
                InputProblem(
                    pointer="",
                    code=f"unknown_{kind}",
                    message=f"there is no {kind} {shown(name)!r}",
                    value=shown(name),
                    remedy=f"Use one of: {', '.join(self.known) or '(none)'}.",
                )
            ]
        )
        self.args = (self.kind, self.name, self.known)  # what unpickling calls the constructor with
