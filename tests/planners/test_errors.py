import pickle

import pytest

from planners import errors

EXAMPLES = [
    errors.WrongShape("start", "(2,)", "(3,)"),
    errors.NotFinite("goal"),
    errors.InvalidSetting("step", -1.0, "above 0"),
    errors.LimitExceeded("v", 2.0, 1.0),
    errors.Collinear("F"),
]


@pytest.mark.parametrize("error", EXAMPLES, ids=lambda error: type(error).__name__)
def test_every_error_survives_a_process_with_its_facts_and_sentence(error: errors.PlannerError) -> None:
    copy = pickle.loads(pickle.dumps(error))

    assert type(copy) is type(error)
    assert vars(copy) == vars(error)
    assert str(copy) == str(error)
    assert all(str(fact) in str(error) for fact in vars(error).values())


def test_every_error_has_an_example() -> None:
    assert {type(error) for error in EXAMPLES} == set(errors.PlannerError.__subclasses__())
