"""Texts with random changes: never a crash, never certified wrongly, judged by other code and by coal."""

import random
import re
import sys
from collections import Counter

import pytest

from robots.errors import InvalidInput
from robots.post.dialects import DIALECTS, post
from service.verification import not_understood, of_text, verification
from service.verification_schemas import Verification
from tests.robots.nc_samples import flat_panel
from tests.robots.post.programs import small
from tests.robots.post.test_fuzz import MUTATIONS
from tests.robots.rigs import MACHINE
from tests.service.text_judge import objections, said


def _axis_digit(rng: random.Random, text: bytes) -> bytes:
    """Another digit, mostly of few consequences, in a number that is an axis value or a feed."""
    places = list(re.finditer(rb'(?<=[XYZABWCF])-?\d+\.\d+|(?<=[,/:"])-?\d+\.\d+', text))
    if not places:
        return text
    number = rng.choice(places)
    at = rng.choice([k for k in range(number.start(), number.end()) if text[k : k + 1].isdigit()])
    return text[:at] + str(rng.randrange(10)).encode() + text[at + 1 :]


def _truncated(rng: random.Random, text: bytes) -> bytes:
    return text[: rng.randrange(len(text) + 1)]


def _garbage(rng: random.Random, text: bytes) -> bytes:
    at = rng.randrange(len(text) + 1)
    return text[:at] + rng.randbytes(rng.randrange(1, 30)) + text[at:]


CHOICES = (*MUTATIONS, *(_axis_digit,) * 8, _truncated, _garbage)


def verified(data: bytes, dialect: str) -> Verification:
    try:
        judged = of_text(data, dialect, flat_panel(), MACHINE)
    except InvalidInput as invalid:
        return not_understood(invalid, data, dialect, flat_panel(), MACHINE)
    return verification(judged, flat_panel(), MACHINE)


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize(("count", "step"), [(60, 0.01), pytest.param(2_000, 0.002, marks=pytest.mark.long)])
def test_no_changed_text_is_certified_wrongly(dialect: str, count: int, step: float) -> None:
    """step: of motion between two samples of the judge [m]."""
    rng = random.Random(count)
    text = post(small(), dialect).encode()
    right = said(text.decode(), dialect)
    dies = [die.id for die in small().dies]
    outcomes: Counter[str] = Counter()
    crashed = 0

    for _ in range(count):
        changed = text
        for _ in range(rng.choice((1, 1, 1, 2, 5))):
            changed = rng.choice(CHOICES)(rng, changed)
        found = verified(changed, dialect)
        crashed += any(
            finding.code == "not_examined" and "stopped" in finding.text for finding in found.findings
        )
        if found.program_sha256 is None:
            outcomes["not understood"] += 1
            assert all(finding.line is not None for finding in found.findings), found.findings
        elif found.result == "rejected":
            outcomes["rejected"] += 1
        else:
            edited = said(changed.decode("ascii"), dialect)
            assert objections(right, edited, dies, step) == []
            outcomes["passed unchanged" if edited == right else "passed with other numbers"] += 1

    understood = count - outcomes["not understood"]
    sys.stdout.write(f"{dialect}: {count} texts, {understood} understood: {dict(sorted(outcomes.items()))}\n")
    assert crashed == 0
    assert outcomes["rejected"] > 0
    assert outcomes["not understood"] > 0
