"""Problems: what they hold, and that they cross process borders."""

import pickle

from robots.errors import InputProblem, InvalidInput, shown
from service.errors import Problem, ProblemError, of_invalid_input, problem
from service.strict_json import MalformedJson


def wrong(value: object) -> InputProblem:
    return InputProblem("/a", "some_code", "is wrong", shown(value), "Mend it.")


def test_problem_error_survives_pickling() -> None:
    error = ProblemError(problem("queue_full", "full", count=1, limit=2), {"Retry-After": "5"})

    copy = pickle.loads(pickle.dumps(error))

    assert (copy.problem, copy.headers, str(copy)) == (error.problem, error.headers, str(error))


def test_malformed_json_is_a_400_and_other_input_a_422() -> None:
    assert of_invalid_input(MalformedJson([wrong(1)])).status == 400
    assert of_invalid_input(InvalidInput([wrong(1)])).status == 422


def test_problem_never_shows_what_json_cannot_hold() -> None:
    found = of_invalid_input(
        InvalidInput([wrong(float("nan")), wrong(float("inf")), wrong([1.0]), wrong(10**400)])
    )

    text = found.model_dump_json()

    assert Problem.model_validate_json(text) == found
    assert not any(word in text for word in ("NaN", "Infinity"))


def test_problem_lists_the_first_errors_and_counts_all() -> None:
    found = of_invalid_input(InvalidInput([wrong(index) for index in range(1000)]))

    assert (len(found.errors), found.error_count) == (200, 1000)
    assert found.detail == "/a: is wrong, and 999 more"
