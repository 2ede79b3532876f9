"""Requests through HTTP, worker process, planner and verifier: nothing is faked here."""

import hashlib
import json
from collections.abc import Iterator
from typing import Any

import httpx
import pytest

from robots.nc_json import from_json
from service.app import create_app
from service.settings import Settings
from tests.service.conftest import CROSSING, CrossingRun, serving
from tests.service.test_http_errors import check_problem, pointers
from tests.service.test_openapi import validator


@pytest.fixture(scope="module")
def service() -> Iterator[httpx.Client]:
    with serving(create_app(Settings(max_sync_fasteners=20))) as client:
        yield client


@pytest.fixture
def crossing() -> dict[str, Any]:
    panel: dict[str, Any] = json.loads(CROSSING.read_bytes())
    return panel


@pytest.fixture(scope="module")
def program(service: httpx.Client) -> httpx.Response:
    panel = json.loads(CROSSING.read_bytes())
    return service.post("/v1/programs", json={"panel": panel, "machine": "riveter", "seed": 7})


def test_program_of_the_crossing_is_complete_and_clean(program: httpx.Response) -> None:
    assert program.status_code == 201, program.text[:500]
    assert program.headers["content-type"] == "application/json"

    content = from_json(program.content)

    assert program.headers["etag"] == f'"{hashlib.sha256(program.content).hexdigest()}"'
    assert content.verification is not None
    assert content.verification.result == "clean"
    assert content.summary.counts.total == content.summary.counts.installed == 12


def test_program_fits_its_schema(program: httpx.Response) -> None:
    validator("Program").validate(program.json())


def test_service_and_command_line_give_the_same_bytes(
    program: httpx.Response, crossing_run: CrossingRun
) -> None:
    assert (
        program.content == crossing_run.program.read_bytes()
    )  # other process, other hash seed, more workers


def test_panel_beyond_the_budget_is_refused_with_count_limit_and_remedy(
    service: httpx.Client, crossing: dict[str, Any]
) -> None:
    crossing["rows"][0] |= {"count": 17, "start_mm": 60.0}

    body = check_problem(
        service.post("/v1/programs", json={"panel": crossing}), 413, "panel_too_large_for_synchronous_request"
    )

    assert (body["count"], body["limit"]) == (21, 20)
    assert "rivetplan plan" in str(body["remedy"])


def test_problems_of_panel_machine_and_dies_come_together(
    service: httpx.Client, crossing: dict[str, Any]
) -> None:
    crossing["rows"][0]["die"] = "hook"
    crossing["frames"][0]["x_mm"] = "left"
    crossing["skin"]["thickness_mm"] = 0.0016
    request = {"panel": crossing, "dies": ["straight", "spoon"]}

    body = check_problem(service.post("/v1/programs", json=request), 422, "invalid_input")

    assert {pointer for pointer, _ in pointers(body)} == {
        "/panel/rows/0/die",
        "/panel/frames/0/x_mm",
        "/panel/skin/thickness_mm",
        "/dies/1",
    }


@pytest.mark.parametrize("machine", ["mill", "robots/data/riveter.json", "/etc/hostname"])
def test_unknown_machine_is_a_problem_that_names_those_there_are(
    service: httpx.Client, crossing: dict[str, Any], machine: str
) -> None:
    response = service.post("/v1/programs", json={"panel": crossing, "machine": machine})

    body = check_problem(response, 422, "invalid_input")
    assert pointers(body) == [("/machine", "unknown_machine")]
    assert "riveter" in response.text


def test_motion_between_fasteners_is_timed_and_certified(
    service: httpx.Client, crossing: dict[str, Any]
) -> None:
    request = {
        "panel": crossing,
        "die": "straight",
        "start": {"fastener_id": "SR.S2.001"},
        "goal": {"fastener_id": "SR.S2.008"},
    }

    response = service.post("/v1/motions", json=request)

    assert response.status_code == 200, response.text[:500]
    motion = response.json()
    validator("Motion").validate(motion)
    assert motion["status"] == "success"
    assert motion["min_clearance_mm"] >= 1.0
    times = [waypoint["t_s"] for waypoint in motion["waypoints"]]
    assert times[0] == 0.0 < times[-1] == motion["duration_s"]
    assert times == sorted(set(times))
    assert response.headers["etag"] == f'"{hashlib.sha256(response.content).hexdigest()}"'

    back = request | {"start": {"axes": motion["waypoints"][-1]["axes"]}, "goal": request["start"]}
    assert service.post("/v1/motions", json=back).json()["status"] == "success"


def test_rivet_pattern_comes_from_a_worker(service: httpx.Client, client: httpx.Client) -> None:
    request = json.loads((CROSSING.parent / "pattern_sheet.json").read_bytes())

    response = service.post("/v1/rivet-patterns", json=request)

    assert response.status_code == 200, response.text[:500]
    assert response.content == client.post("/v1/rivet-patterns", json=request).content


def test_accessibility_comes_from_a_worker(service: httpx.Client, client: httpx.Client) -> None:
    request = {"panel": json.loads(CROSSING.read_bytes()), "dies": ["straight"]}

    response = service.post("/v1/accessibility", json=request)

    assert response.status_code == 200, response.text[:500]
    assert response.content == client.post("/v1/accessibility", json=request).content


def test_motion_that_starts_in_collision_is_a_problem_that_names_the_pair(
    service: httpx.Client, crossing: dict[str, Any]
) -> None:
    axes = {"X_mm": 6250.0, "Y_mm": 0.0, "Z_mm": 0.0, "A_deg": 0.0, "B_deg": 0.0, "W_mm": 349.0, "C_deg": 0.0}
    request = {
        "panel": crossing,
        "die": "straight",
        "start": {"axes": axes},
        "goal": {"fastener_id": "SR.S2.001"},
    }

    body = check_problem(service.post("/v1/motions", json=request), 422, "invalid_input")

    assert pointers(body) == [("/start", "start_in_collision")]


def test_wrong_ends_of_a_motion_are_problems_at_their_places(
    service: httpx.Client, crossing: dict[str, Any]
) -> None:
    axes = {"X_mm": 1e308, "Y_mm": 0.0, "Z_mm": 0.0, "A_deg": 76.0, "B_deg": 0.0, "W_mm": 0.0, "C_deg": 0.0}
    request = {"panel": crossing, "die": "straight", "start": {"axes": axes}, "goal": {"fastener_id": "F99"}}

    body = check_problem(service.post("/v1/motions", json=request), 422, "invalid_input")

    assert pointers(body) == [
        ("/start/axes/X_mm", "axis_out_of_limits"),
        ("/start/axes/A_deg", "axis_out_of_limits"),
        ("/goal/fastener_id", "unknown_fastener"),
    ]
