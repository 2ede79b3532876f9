"""POST /v1/accessibility: the answer, its budget and its problems."""

import hashlib
import json
from typing import Any

import httpx
import pytest

from service import tasks
from service.access_schemas import AccessibilityRequest, PanelAccessibility
from service.canonical import canonical_json
from service.errors import ProblemError
from service.settings import Settings
from tests.service.conftest import CROSSING
from tests.service.test_access_report import checked
from tests.service.test_check import IN_THE_WAY
from tests.service.test_http_errors import check_problem, pointers
from tests.service.test_openapi import validator

ACCESSIBILITY = "/v1/accessibility"


def crossing(**changes: Any) -> dict[str, Any]:
    panel: dict[str, Any] = json.loads(CROSSING.read_bytes())
    return panel | changes


def test_the_answer_is_the_report_with_its_hash(client: httpx.Client) -> None:
    request = {"panel": crossing(), "dies": ["straight"]}

    response = client.post(ACCESSIBILITY, json=request)

    assert response.status_code == 200, response.text[:500]
    assert response.content == canonical_json(checked("crossing", "straight"))
    assert response.headers["etag"] == f'"{hashlib.sha256(response.content).hexdigest()}"'
    assert response.headers["content-type"] == "application/json"


def test_answer_and_request_fit_their_schemas(client: httpx.Client) -> None:
    request = {"panel": crossing(), "dies": ["straight"], "remedies": 1.0}
    validator("AccessibilityRequest").validate(request)

    answer = client.post(ACCESSIBILITY, json=request).json()

    validator("Accessibility").validate(answer)
    assert answer["remedies"]["searched"] == 1
    assert [each["remedies"] is not None for each in answer["fasteners"]].count(True) == 1
    PanelAccessibility.model_validate(answer)


def test_a_panel_beyond_the_budget_is_refused_with_count_limit_and_remedy() -> None:
    request = AccessibilityRequest(panel=crossing())

    with pytest.raises(ProblemError) as refused:
        tasks.accessibility(request, Settings(max_sync_fasteners=11))

    problem = refused.value.problem
    assert (problem.status, problem.code) == (413, "panel_too_large_for_synchronous_request")
    assert (problem.count, problem.limit) == (12, 11)
    assert "rivetplan check" in str(problem.remedy)


@pytest.mark.parametrize(
    ("changes", "pointer", "code"),
    [
        ({"dies": ["straight", "spoon"]}, "/dies/1", "unknown_die"),
        ({"dies": ["straight", "straight"]}, "/dies/1", "duplicate_die"),
        ({"dies": []}, "/dies", "too_short"),
        ({"machine": "mill"}, "/machine", "unknown_machine"),
        ({"remedies": -1}, "/remedies", "greater_than_equal"),
        ({"remedies": 21}, "/remedies", "less_than_equal"),
        ({"seed": 1}, "/seed", "extra_forbidden"),
        ({"panel": crossing(clips="none")}, "/panel/clips", "wrong_type"),
        ({"panel": crossing(mounting=IN_THE_WAY)}, "/panel/mounting", "home_in_collision"),
    ],
)
def test_what_is_wrong_is_a_problem_with_its_place(
    client: httpx.Client, changes: dict[str, Any], pointer: str, code: str
) -> None:
    response = client.post(ACCESSIBILITY, json={"panel": crossing()} | changes)

    assert pointers(check_problem(response, 422, "invalid_input")) == [(pointer, code)]
