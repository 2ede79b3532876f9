import dataclasses
import math
import pickle
from typing import Any, cast

import numpy as np
import pytest

from planners.errors import InvalidSetting
from planners.settings import AxisRule, PlannerSettings
from tests.planners.toy_spaces import rules


@pytest.mark.parametrize(
    "fields",
    [
        {"step": 0.0},
        {"step": math.nan},
        {"step": math.inf},
        {"step": 1.0, "weight": 0.0},
        {"step": 1.0, "random": "sideways"},
        {"step": 1.0, "margin": -0.1},
    ],
)
def test_axis_rule_refuses_what_has_no_meaning(fields: dict[str, Any]) -> None:
    with pytest.raises(InvalidSetting) as caught:
        AxisRule(**fields)

    assert caught.value.field in fields


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("axes", ()),
        ("walk_start", 0),
        ("walk_growth", 0),
        ("walk_limit", -1),
        ("max_detections", -1),
        ("engine_detections", 0),
        ("smoothing_detections", -1),
        ("escapes_tried", -1),
        ("escapes_kept", 0),
        ("escape_detections", -1),
        ("region_margin", 0.0),
        ("region_growth", 1.0),
        ("branch_reach", math.nan),
    ],
)
def test_settings_refuse_what_would_never_end_or_never_begin(field: str, value: Any) -> None:
    with pytest.raises(InvalidSetting) as caught:
        dataclasses.replace(PlannerSettings(rules(2)), **{field: value})

    assert caught.value.field == field


def test_every_numeric_setting_has_a_rule_that_is_tested() -> None:
    settings = PlannerSettings(rules(1))

    for field in dataclasses.fields(settings):
        if field.name != "axes":
            with pytest.raises(InvalidSetting):
                dataclasses.replace(settings, **cast(dict[str, Any], {field.name: -1}))


def test_axis_rules_become_arrays_in_axis_order() -> None:
    settings = PlannerSettings(
        (
            AxisRule(0.1, 2.0),
            AxisRule(0.2, 0.5, "frozen"),
            AxisRule(0.3, 1.0, "negative", margin=0.7),
            AxisRule(0.4, 1.0, "positive"),
        ),
        region_margin=0.1,
    )

    assert settings.steps.tolist() == [0.1, 0.2, 0.3, 0.4]
    assert settings.weights.tolist() == [2.0, 0.5, 1.0, 1.0]
    assert settings.walking.tolist() == [1.0, 0.0, 0.0, 0.0]
    assert settings.forced.tolist() == [0.0, 0.0, -1.0, 1.0]
    assert settings.margins.tolist() == [0.05, 0.2, 0.7, 0.1]


def test_settings_cross_a_process_and_a_changed_copy_forgets_what_was_computed() -> None:
    settings = PlannerSettings(rules(2, 0.5))
    assert settings.steps.tolist() == [0.5, 0.5]

    copy = pickle.loads(pickle.dumps(dataclasses.replace(settings, axes=rules(1, 0.1))))

    assert np.array_equal(copy.steps, [0.1])
