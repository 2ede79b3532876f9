"""What the tables are made of: percentiles, ratios, a growth exponent, and rows as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, is_dataclass

import numpy as np


@dataclass(frozen=True)
class Spread:
    """Median, 95th and 99th percentile of `count` values (linear between the two nearest); NaN of none."""

    count: int
    median: float
    p95: float
    p99: float


def spread(values: Iterable[float]) -> Spread:
    """Spread of the values."""
    kept = list(values)
    if not kept:
        return Spread(0, math.nan, math.nan, math.nan)
    median, p95, p99 = np.percentile(kept, [50.0, 95.0, 99.0]).tolist()
    return Spread(len(kept), median, p95, p99)


def ratio(ours: float, theirs: float) -> float:
    """`ours / theirs`; NaN where there is nothing to divide by."""
    return ours / theirs if theirs > 0.0 else math.nan


def exponent(sizes: Sequence[float], seconds: Sequence[float]) -> float:
    """The b of seconds = a sizes^b, by least squares in log-log; all values above 0, at least two sizes."""
    slope, _ = np.polyfit(np.log(sizes), np.log(seconds), 1)
    return float(slope)


def as_json(document: Mapping[str, object]) -> str:
    """The document as JSON text: dataclasses as objects, what is not a number as null."""
    return json.dumps(_plain(document), indent=1, allow_nan=False) + "\n"


def _plain(value: object) -> object:
    if is_dataclass(value) and not isinstance(value, type):
        return _plain(asdict(value))
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def shown(value: float, digits: int = 3) -> str:
    """A number with so many significant digits, "-" where there is none."""
    if not math.isfinite(value):
        return "-"
    if value == 0.0:
        return "0"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:.{decimals}f}"


def aligned(rows: Sequence[Sequence[str]]) -> str:
    """Rows of one length as text: the first column to the left, the others to the right."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join(
        "  ".join(
            cell.rjust(w) if i else cell.ljust(w) for i, (cell, w) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    )
