import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from planners.arrays import Array
from planners.errors import InvalidSetting, NotFinite, WrongShape
from planners.time_optimal import RoundedPath, TimedSamples, time_optimal

LIMITS = np.array([[0.5, 0.3, 1.5], [1.0, 0.8, 6.0]])
WEIGHTS = np.array([1.0, 1.0, 0.1])
DEVIATION = 0.002


@st.composite
def paths(draw: st.DrawFn) -> Array:
    """Waypoints of blocks from 10 um to 12 m (or as many rad), some of one axis alone."""
    count = draw(st.integers(1, 6))
    ways = draw(arrays(np.float64, (count, 3), elements=st.floats(-1.0, 1.0)))
    ways[np.abs(ways) < 0.1] = 0.0
    sizes = draw(arrays(np.float64, (count, 1), elements=st.floats(-5.0, 1.08)))
    steps = ways * 10.0**sizes
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def timed(waypoints: Array, deviation: float = DEVIATION) -> TimedSamples:
    found = time_optimal(waypoints, LIMITS, deviation, WEIGHTS)
    assert found is not None
    return found


def to_the_path(q: Array, waypoints: Array) -> Array:
    """Weighted distances of configurations (m, n) from the straight blocks."""
    nearest = np.full(len(q), np.inf)
    for a, b in zip(waypoints[:-1] * WEIGHTS, waypoints[1:] * WEIGHTS, strict=True):
        way = b - a
        share = np.clip((q * WEIGHTS - a) @ way / max(float(way @ way), 1e-300), 0.0, 1.0)
        away = q * WEIGHTS - a - share[:, np.newaxis] * way
        nearest = np.minimum(nearest, np.linalg.norm(away, axis=1))
    return nearest


@settings(max_examples=60, deadline=None)
@given(paths())
def test_no_sample_is_beyond_a_limit_nor_farther_from_the_path_than_agreed(waypoints: Array) -> None:
    motion = timed(waypoints)

    assert np.all(np.diff(motion.t) > 0.0)
    assert np.all(np.abs(motion.v) <= LIMITS[0] * (1.0 + 1e-9))
    assert np.all(np.abs(motion.a) <= LIMITS[1] * (1.0 + 1e-9))
    assert np.allclose(motion.q[0], waypoints[0])
    assert np.allclose(motion.q[-1], waypoints[-1])
    assert np.allclose(motion.v[[0, -1]], 0.0, atol=1e-9)
    assert np.all(to_the_path(motion.q, waypoints) <= DEVIATION + 1e-12)


@settings(max_examples=30, deadline=None)
@given(paths())
def test_the_samples_are_one_motion(waypoints: Array) -> None:
    """Integrated by the trapezoidal rule, velocities give the positions and accelerations the velocities."""
    motion = timed(waypoints)
    steps = np.diff(motion.t)[:, np.newaxis]
    moved = steps * (motion.v[1:] + motion.v[:-1]) / 2.0
    widest = np.abs(np.diff(motion.q, axis=0)).sum(axis=0) if len(motion.t) > 1 else np.zeros(3)

    assert np.all(np.abs(np.diff(motion.q, axis=0) - moved).sum(axis=0) <= 0.02 * widest + 1e-9)


def test_a_single_block_is_the_bang_bang_motion() -> None:
    block = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]])
    assert timed(block).duration == pytest.approx(0.4 / 0.5 + 0.5 / 1.0, rel=1e-3)


def test_a_larger_deviation_is_quicker_and_a_tiny_one_stops_at_the_corner() -> None:
    corner = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.4, 0.3, 0.0]])
    stop = timed(corner[:2]).duration + timed(corner[1:]).duration
    durations = [timed(corner, deviation).duration for deviation in (1e-6, 0.0005, 0.002, 0.02)]

    assert durations == sorted(durations, reverse=True)
    assert durations[0] == pytest.approx(stop, rel=2e-2)
    assert durations[2] < 0.98 * stop


def test_a_path_that_turns_back_on_itself_is_followed() -> None:
    there_and_back = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.1, 0.0, 0.0]])
    motion = timed(there_and_back)

    assert motion.q[:, 0].max() == pytest.approx(0.4, abs=1.001 * DEVIATION)
    assert motion.duration <= timed(there_and_back[:2]).duration + timed(there_and_back[1:]).duration


def test_the_rounded_path_has_a_second_derivative_without_steps() -> None:
    path = RoundedPath(np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.4, 0.3, 1.0]]), DEVIATION, WEIGHTS)
    joints = path.grid[1:-1]

    for order in (0, 1, 2):
        before, after = path(joints - 1e-9, order), path(joints + 1e-9, order)
        assert np.allclose(before, after, atol=1e-4), order


def test_no_move_takes_no_time() -> None:
    still = timed(np.zeros((3, 3)))
    assert still.duration == 0.0
    assert np.array_equal(still.q, np.zeros((1, 3)))


@pytest.mark.parametrize(
    ("changed", "error"),
    [
        ({"waypoints": np.zeros(3)}, WrongShape),
        ({"limits": LIMITS[0]}, WrongShape),
        ({"waypoints": np.array([[0.0, 0.0, np.nan]])}, NotFinite),
        ({"deviation": 0.0}, InvalidSetting),
        ({"weights": np.zeros(3)}, InvalidSetting),
    ],
)
def test_wrong_requests_are_errors(changed: dict[str, object], error: type[Exception]) -> None:
    request = {"waypoints": np.zeros((2, 3)), "limits": LIMITS, "deviation": 0.001, "weights": WEIGHTS}
    with pytest.raises(error):
        time_optimal(**{**request, **changed})  # type: ignore[arg-type]
