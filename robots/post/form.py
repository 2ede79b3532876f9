"""How a dialect writes numbers and names."""

import hashlib
import math
import re
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Decimal

from robots.nc import AXIS_FIELDS, NcAxes
from robots.nc_codec import Decimals

AXES = tuple(field.partition("_")[0] for field in AXIS_FIELDS)
"""Axis letters in their order."""

NO_NAME = "*"
TOKEN = r"[A-Za-z0-9][A-Za-z0-9._=-]{0,21}"
"""What stands in a text for a name."""

_LENGTH_DIGITS = 4
_SECONDS_PER_MINUTE = 60
_LONGEST = 22  # [characters]: a comment with two names fits into the 72 columns of APT
_SAFE = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,21}")
_UNSAFE = re.compile(r"[^A-Za-z0-9._-]+")


@dataclass(frozen=True)
class Form:
    """The digits of a dialect and the feeds its controller takes.

    angle_digits: decimals of degrees; millimetres have 4. feed_digits: decimals of inverse time feeds
    [1/min]. max_feed: the largest feed that can be commanded [1/min]; a block that could be quicker runs at
    it. whole_blocks: the text has every field of a block.
    """

    angle_digits: int = 6
    feed_digits: int = 4
    max_feed: float = 9_999_999.0
    whole_blocks: bool = False

    def digits(self, axis: str) -> int:
        """Decimals of an axis value."""
        return self.angle_digits if axis in "ABC" else _LENGTH_DIGITS

    def axes(self, axes: NcAxes) -> tuple[float, ...]:
        """The seven values as a reader of the text gets them, [mm] and [deg]."""
        values = zip(AXES, AXIS_FIELDS, strict=True)
        return tuple(Decimals(self.digits(axis)).rounded(getattr(axes, field)) for axis, field in values)

    def feed(self, v_per_s: float) -> float:
        """Inverse time feed F [1/min] of a block whose path parameter runs at most at `v_per_s` [1/s].

        Rounded down, so that no axis exceeds its speed; 0 where the block is too slow to be commanded.
        """
        if not math.isfinite(v_per_s):
            return 0.0
        exact = Decimal(repr(v_per_s)) * _SECONDS_PER_MINUTE
        limited = min(exact, Decimal(repr(self.max_feed)))
        return float(limited.quantize(Decimal(1).scaleb(-self.feed_digits), rounding=ROUND_FLOOR))

    def axis_text(self, axis: str, value: float) -> str:
        """The value as it stands in the text."""
        return Decimals(self.digits(axis)).text(value)

    def feed_text(self, feed: float) -> str:
        """The feed as it stands in the text."""
        return Decimals(self.feed_digits).text(feed)


def token(name: str) -> str:
    """What stands in a text for a name: the name itself where every controller can hold it.

    Another name loses what is unsafe (comment ends, line feeds, what is not ASCII) or too long, and ends in
    "=" and 8 digits of its sha256, so that two names stay two.
    """
    if _SAFE.fullmatch(name):
        return name
    digest = hashlib.sha256(name.encode("utf-8", "surrogatepass")).hexdigest()[:8]
    readable = _UNSAFE.sub("-", name).lstrip("._-")[: _LONGEST - len(digest) - 1]
    return f"{readable or 'x'}={digest}"
