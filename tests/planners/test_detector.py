import numpy as np

from planners.detector import Detector
from tests.planners.toy_spaces import BoxSpace

A, B, C = np.array([0.0]), np.array([1.0]), np.array([2.0])


def line() -> BoxSpace:
    return BoxSpace([-5.0], [5.0], [((1.5,), (1.6,))])


def test_every_question_is_one_detection() -> None:
    space = line()
    detector = Detector(space, 10)

    answers = detector.is_free(A), detector.edge_is_free(A, B), detector.edge_is_free(B, C)

    assert answers == (True, True, False)
    assert detector.detections == space.asked == 3


def test_the_edge_certified_last_is_not_asked_twice() -> None:
    space = line()
    detector = Detector(space, 10)

    answers = [detector.edge_is_free(*edge) for edge in ((A, B), (A, B), (B, C), (B, C), (B, A))]

    assert answers == [True, True, False, False, True]
    assert detector.detections == space.asked == 4


def test_a_spent_detector_refuses_without_asking() -> None:
    space = line()
    detector = Detector(space, 1)
    detector.is_free(A)

    assert detector.spent
    assert not detector.is_free(A)
    assert not detector.edge_is_free(A, B)
    assert space.asked == 1


def test_once_stopped_it_stays_stopped() -> None:
    answers = iter([False, True, False, False])
    space = line()
    detector = Detector(space, 10, lambda: next(answers))

    assert detector.is_free(A)
    assert not detector.is_free(A)
    assert not detector.is_free(A)
    assert detector.cancelled
    assert detector.spent
    assert space.asked == 1
