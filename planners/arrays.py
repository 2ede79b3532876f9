"""Arrays that are shared are frozen: one type and one helper."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def frozen(values: ArrayLike) -> Array:
    """Return a read-only, contiguous float64 copy of `values`; the caller's array stays as it was."""
    array = np.array(values, dtype=np.float64, order="C")
    array.setflags(write=False)
    return array
