import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from planners.arrays import Array
from robots.nc import NcAxes
from robots.nc_path import as_programmed


@given(arrays(np.float64, (3, 7), elements=st.floats(-50.0, 50.0)))
def test_a_path_gets_the_digits_that_each_configuration_gets_to_the_last_bit(path: Array) -> None:
    # A tie of digits is the one case in which the two roundings may differ, by one digit.
    programmed, one_by_one = as_programmed(path), np.array([NcAxes.of(q).q for q in path])
    same = programmed == one_by_one
    digits = 1.001 * np.array([1e-7, 1e-7, 1e-7, 2e-8, 2e-8, 1e-7, 2e-8])
    assert np.all(np.abs(programmed - path) <= digits)
    assert np.all(same | (np.abs(programmed - one_by_one) <= digits))
    assert np.array_equal(as_programmed(programmed), programmed)
    assert np.array_equal(np.array([NcAxes.of(q).q for q in programmed]), programmed)


def test_values_at_random_are_the_same_bits() -> None:
    path = np.random.default_rng(3).uniform(-4.0, 4.0, (20_000, 7))
    assert np.array_equal(as_programmed(path), np.array([NcAxes.of(q).q for q in path]))
