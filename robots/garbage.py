"""The collector of cyclic garbage, put off while a program is made or read.

A program is hundreds of thousands of small objects that are kept and have no cycles. The collector looks
through all of them again and again as they become more, which takes a quarter of the time.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def collection_put_off() -> Iterator[None]:
    """Collect no cyclic garbage inside, unless nobody collected it before either."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
