"""Texts with random changes are refused, different, or the same in meaning: judged by another reader."""

import random
import re
from collections.abc import Callable, Sequence

import pytest

from robots.errors import InvalidInput
from robots.post.dialects import DIALECTS, check, post
from tests.robots.post.programs import meaning, small

Mutation = Callable[[random.Random, bytes], bytes]


def _cut(rng: random.Random, text: bytes) -> bytes:
    a = rng.randrange(len(text) + 1)
    return text[:a] + text[a + rng.choice((1, 1, 2, 7)) :]


def _put(rng: random.Random, text: bytes) -> bytes:
    a = rng.randrange(len(text) + 1)
    return text[:a] + bytes([rng.choice(b"0123456789-.,;()$%/XYZABCWFGNM =\n\r\t\0\xff")]) + text[a:]


def _swap(rng: random.Random, text: bytes) -> bytes:
    a = rng.randrange(len(text) + 1)
    return text[:a] + bytes([rng.choice(b"0123456789-.,;()$ \nXYZM\x85")]) + text[a + 1 :]


def _any(rng: random.Random, pattern: bytes, text: bytes) -> re.Match[bytes]:
    """One of the places where the pattern matches, or else a place between two characters."""
    return rng.choice(list(re.finditer(pattern, text)) or list(re.finditer(b"", text)))


def _number(rng: random.Random, text: bytes) -> bytes:
    at = _any(rng, rb"\d", text)
    return text[: at.start()] + str(rng.randrange(10)).encode() + text[at.end() :]


def _sign(rng: random.Random, text: bytes) -> bytes:
    at = _any(rng, rb"(?<=[XYZABWC,/:])-?(?=\d)", text)
    return text[: at.start()] + (b"" if at[0] else b"-") + text[at.end() :]


def _line(rng: random.Random, text: bytes) -> bytes:
    rows = text.split(b"\n")
    a, b = sorted((rng.randrange(len(rows)), rng.randrange(len(rows))))
    choices = (
        rows[:a] + rows[b:],
        [*rows[:a], rows[b], *rows[a:]],
        [*rows[:a], rows[b], *rows[a + 1 : b], rows[a], *rows[b + 1 :]],
        rows[:a],
        [*rows[:a], b"  " + rows[a].replace(b" ", b"   "), *rows[a + 1 :]],
    )
    return b"\n".join(rng.choice(choices))


MUTATIONS: Sequence[Mutation] = (_cut, _put, _swap, _number, _sign, _line)


def outcome_of(text: bytes, dialect: str) -> str:
    """What the text is found to be; every problem of one that cannot be read names its line."""
    try:
        return "different" if check(text, small(), dialect) else "same"
    except InvalidInput as invalid:
        lines = [problem.pointer for problem in invalid.problems]
    assert all(line.startswith("line ") for line in lines)
    return "refused"


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("count", [300, pytest.param(10_000, marks=pytest.mark.long)])
def test_mutated_text_is_refused_different_or_the_same_in_meaning(dialect: str, count: int) -> None:
    rng = random.Random(count)
    text = post(small(), dialect).encode()
    meant = meaning(text.decode(), dialect)
    outcomes = {"refused": 0, "different": 0, "same": 0}

    for _ in range(count):
        changed = text
        for _ in range(rng.choice((1, 1, 1, 2, 5))):
            changed = rng.choice(MUTATIONS)(rng, changed)
        outcome = outcome_of(changed, dialect)
        outcomes[outcome] += 1
        if outcome == "same":
            assert meaning(changed.decode("ascii"), dialect) == meant

    assert min(outcomes.values()) > 0, outcomes
