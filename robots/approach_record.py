"""What a program says of its approach orders."""

from __future__ import annotations

import hashlib

from planners.approach import Approach
from robots.nc import NcInput
from robots.nc_approach import NcApproach
from robots.nc_codec import encode

_MM = 1e3


def approach_record(approach: Approach | None) -> NcApproach | None:
    """As the program's policy states it."""
    if approach is None:
        return None
    return NcApproach(approach.order, _MM * approach.clear_height, _MM * approach.max_height)


def approach_input(approach: Approach | None) -> NcInput | None:
    """As the header names it among what the program was made from."""
    record = approach_record(approach)
    if record is None:
        return None
    return NcInput(f"order {record.order}", hashlib.sha256(encode(record).encode("ascii")).hexdigest())
