"""Whether a program has the digits of its file already: asked of all its numbers together, where `rounded`
takes them one by one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from operator import attrgetter
from typing import Any, get_args

import numpy as np

from robots import nc_codec
from robots.nc import AXIS_FIELDS, Deg, Mm, NcBlock, NcProgram, Seconds
from robots.nc_json import rounded

_KINDS = [Mm if name.endswith("_mm") else Deg for name in AXIS_FIELDS] + [Seconds, Seconds]
_SCALE = np.array([10.0 ** get_args(kind)[1].digits for kind in _KINDS])
_LARGEST = 2.0**52  # digits: more than a double tells apart
_axis_values = attrgetter(*AXIS_FIELDS)


def as_written(program: NcProgram) -> NcProgram:
    """The program as `rounded` gives it; blocks that have their digits already are taken as they are.

    Raises as `rounded` does.
    """
    if not have_digits(program.blocks):
        return rounded(program)
    return replace(rounded(replace(program, blocks=())), blocks=program.blocks)


def have_digits(blocks: Sequence[NcBlock]) -> bool:
    """Whether every number of the blocks is, to the last bit, what is read back from its text."""
    numbers = np.array(
        [(*_axis_values(block.axes), block.t_start_s, block.t_end_s) for block in blocks], dtype=np.float64
    ).reshape(-1, len(_KINDS))
    digits = np.rint(numbers * _SCALE)
    if not (np.abs(digits) < _LARGEST).all():  # or NaN
        return False
    # Whole digits over a power of ten are the double nearest to the decimal, which is what is read.
    if not np.array_equal(digits / _SCALE, numbers) or (np.signbit(numbers) & (numbers == 0.0)).any():
        return False
    return all(nc_codec.rounded(each) == each for each in _parts(blocks))


def _parts(blocks: Sequence[NcBlock]) -> set[Any]:
    """What the blocks are made of besides, each once."""
    found: set[Any] = set()
    for block in blocks:
        found.update((block.dynamics, block.blend, block.clearance), block.events)
    return found - {None}
