"""Every error of the service is a problem: the traps of service.md, table and beyond, over real HTTP."""

import json
import logging
import socket
from collections.abc import Iterator

import httpx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.errors import KINDS, ProblemError, problem
from service.strict_json import JsonLimits
from tests.service.conftest import SETTINGS, FakeEngine

PROGRAMS = "/v1/programs"
JSON = {"content-type": "application/json"}


def check_problem(response: httpx.Response, status: int, code: str) -> dict[str, object]:
    """Assert that a response is a problem of this kind; return its body."""
    assert response.status_code == status, response.text[:500]
    assert response.headers["content-type"] == "application/problem+json"
    body: dict[str, object] = json.loads(response.content)
    assert {"type", "title", "status", "code", "detail", "errors", "trace_id"} <= set(body)
    assert (body["status"], body["code"]) == (status, code)
    assert len(str(body["trace_id"])) == 32
    return body


def pointers(body: dict[str, object]) -> list[tuple[str, str]]:
    errors = body["errors"]
    assert isinstance(errors, list)
    assert all(error["remedy"] for error in errors)
    return [(error["pointer"], error["code"]) for error in errors]


MALFORMED = {
    "NaN": (b'{"panel": {"x": NaN}}', "/panel/x", "not_a_number"),
    "Infinity": (b'{"panel": {}, "seed": Infinity}', "/seed", "not_a_number"),
    "5,000 digits": (b'{"panel": {}, "seed": ' + b"9" * 5000 + b"}", "/seed", "number_too_long"),
    "lone surrogate": (rb'{"panel": {}, "machine": "\ud800"}', "/machine", "lone_surrogate"),
    "NUL": (rb'{"panel": {}, "machine": "a\u0000"}', "/machine", "nul_character"),
    "duplicate key": (b'{"panel": {}, "seed": 1, "seed": 2}', "/seed", "duplicate_name"),
    "UTF-16": ('{"panel": {}}'.encode("utf-16"), "", "byte_order_mark"),
    "byte order mark": (b'\xef\xbb\xbf{"panel": {}}', "", "byte_order_mark"),
    "nested 2,000 deep": (b'{"a":' * 2000 + b"1" + b"}" * 2000, "", "nested_too_deeply"),
    "empty body": (b"", "", "empty_document"),
    "not JSON": (b"panel=crossing", "", "syntax_error"),
}
INVALID = {
    "1e999": ({"seed": "1e999"}, "/seed", "number_out_of_range"),
    "400 digits": ({"seed": "9" * 400}, "/seed", "number_out_of_range"),
    "unknown key": ({"sead": "1"}, "/sead", "extra_forbidden"),
    "number as text": ({"seed": '"4"'}, "/seed", "int_type"),
    "true as a number": ({"seed": "true"}, "/seed", "int_type"),
    "negative seed": ({"seed": "-1"}, "/seed", "greater_than_equal"),
    "fraction for an integer": ({"seed": "1.5"}, "/seed", "int_type"),
    "no panel": ({"panel": None}, "/panel", "missing"),
    "panel is a list": ({"panel": "[]"}, "/panel", "dict_type"),
    "no dies": ({"dies": "[]"}, "/dies", "too_short"),
    "die is a number": ({"dies": '["straight", 3]'}, "/dies/1", "string_type"),
    "empty id": ({"machine": '""'}, "/machine", "string_too_short"),
    "id with a line feed": ({"machine": '"a\\nb"'}, "/machine", "string_pattern_mismatch"),
}


@pytest.mark.parametrize(("body", "pointer", "code"), MALFORMED.values(), ids=MALFORMED)
def test_body_that_is_not_strict_json_is_a_400_problem(
    client: httpx.Client, body: bytes, pointer: str, code: str
) -> None:
    response = client.post(PROGRAMS, content=body, headers=JSON)

    assert pointers(check_problem(response, 400, "malformed_json")) == [(pointer, code)]


@pytest.mark.parametrize(("changes", "pointer", "code"), INVALID.values(), ids=INVALID)
def test_json_that_is_no_request_is_a_422_problem(
    client: httpx.Client, changes: dict[str, str | None], pointer: str, code: str
) -> None:
    members = {"panel": "{}"} | changes
    text = ", ".join(f'"{name}": {value}' for name, value in members.items() if value is not None)

    response = client.post(PROGRAMS, content="{" + text + "}", headers=JSON)

    assert pointers(check_problem(response, 422, "invalid_input")) == [(pointer, code)]


@pytest.mark.parametrize("value", ["null", "[]", "3", '"text"', "true"])
def test_json_that_is_no_object_is_a_422_problem(client: httpx.Client, value: str) -> None:
    response = client.post(PROGRAMS, content=value, headers=JSON)

    check_problem(response, 422, "invalid_input")


def test_integral_float_is_an_integer(client: httpx.Client, engine: FakeEngine) -> None:
    response = client.post(PROGRAMS, content='{"panel": {}, "seed": 3.0}', headers=JSON)

    assert response.status_code == 201
    assert engine.requests[-1].seed == 3


def test_pointers_of_unions_are_pointers_into_the_body(client: httpx.Client) -> None:
    axes = {"X_mm": 0, "Y_mm": 0, "Z_mm": "high", "A_deg": 0, "B_deg": 0, "W_mm": 0}
    body = {"panel": {}, "die": "straight", "start": {"axes": axes}, "goal": {"fastener_id": "F1"}}

    found = pointers(check_problem(client.post("/v1/motions", json=body), 422, "invalid_input"))

    assert ("/start/axes/Z_mm", "float_type") in found
    assert ("/start/axes/C_deg", "missing") in found


@pytest.mark.parametrize(
    "media_type",
    [
        "text/plain",
        "application/xml",
        "application/json; charset=latin-1",
        "application/x-www-form-urlencoded",
    ],
)
def test_other_media_types_are_a_415_problem(client: httpx.Client, media_type: str) -> None:
    response = client.post(PROGRAMS, content=b'{"panel": {}}', headers={"content-type": media_type})

    check_problem(response, 415, "unsupported_media_type")


def test_body_without_media_type_is_a_415_problem(client: httpx.Client) -> None:
    check_problem(client.post(PROGRAMS, content=b'{"panel": {}}'), 415, "unsupported_media_type")


@pytest.mark.parametrize(
    "media_type", ["application/json;charset=UTF-8", 'Application/JSON; charset="utf-8"']
)
def test_media_type_of_json_is_read_as_http_means_it(client: httpx.Client, media_type: str) -> None:
    response = client.post(PROGRAMS, content=b'{"panel": {}}', headers={"content-type": media_type})

    assert response.status_code == 201


def _chunks(size: int) -> Iterator[bytes]:
    for _ in range(size // 1000):
        yield b" " * 1000


@pytest.mark.parametrize("chunked", [False, True], ids=["content-length", "chunked"])
def test_body_beyond_the_limit_is_a_413_problem(client: httpx.Client, chunked: bool) -> None:
    size = SETTINGS.json.max_bytes + 1000
    content = _chunks(size) if chunked else b" " * size

    body = check_problem(client.post(PROGRAMS, content=content, headers=JSON), 413, "body_too_large")

    assert body["limit"] == SETTINGS.json.max_bytes


def test_unknown_address_is_a_404_problem(client: httpx.Client) -> None:
    check_problem(client.get("/v1/program"), 404, "not_found")
    check_problem(client.get("/v1/programs/"), 404, "not_found")
    check_problem(client.get("/docs"), 404, "not_found")


@pytest.mark.parametrize(
    ("method", "path", "allow"),
    [
        ("GET", "/v1/programs", "POST"),
        ("DELETE", "/v1/motions", "POST"),
        ("POST", "/v1/machines", "GET, HEAD"),
        ("PUT", "/v1/machines/riveter", "GET, HEAD"),
        ("PATCH", "/health/live", "GET, HEAD"),
        ("POST", "/openapi.json", "GET, HEAD"),
    ],
)
def test_wrong_method_is_a_405_problem_with_the_methods_there_are(
    client: httpx.Client, method: str, path: str, allow: str
) -> None:
    response = client.request(method, path)

    check_problem(response, 405, "method_not_allowed")
    assert response.headers["allow"] == allow


@pytest.mark.parametrize("path", ["/health/live?limit=-1", "/v1/machines?limit=-1", "/openapi.json?x=1"])
def test_unknown_query_parameter_is_a_422_problem(client: httpx.Client, path: str) -> None:
    (found,) = pointers(check_problem(client.get(path), 422, "invalid_input"))

    assert found[1] == "unknown_parameter"


def test_compressed_body_is_a_415_problem(client: httpx.Client) -> None:
    headers = JSON | {"content-encoding": "gzip"}

    check_problem(
        client.post(PROGRAMS, content=b'{"panel": {}}', headers=headers), 415, "unsupported_media_type"
    )


@pytest.mark.parametrize(
    ("end", "expected"),
    [
        (5, [("/start", "model_attributes_type")]),
        ({}, [("/start/fastener_id", "missing")]),
        ({"fastener": "f"}, [("/start/fastener_id", "missing"), ("/start/fastener", "extra_forbidden")]),
        ({"axes": []}, [("/start/axes", "model_attributes_type")]),
        ({"fastener_id": 3}, [("/start/fastener_id", "string_type")]),
    ],
)
def test_wrong_end_of_a_motion_is_judged_as_what_it_is_meant_to_be(
    client: httpx.Client, end: object, expected: list[tuple[str, str]]
) -> None:
    order = {"panel": {}, "die": "straight", "start": end, "goal": {"fastener_id": "f"}}

    body = check_problem(client.post("/v1/motions", json=order), 422, "invalid_input")

    assert pointers(body) == expected
    assert "dictionary" not in str(body)


def test_wrong_value_is_shown(client: httpx.Client) -> None:
    body = check_problem(client.post(PROGRAMS, json={"panel": {}, "seed": -7}), 422, "invalid_input")

    (error,) = json.loads(json.dumps(body["errors"]))
    assert error["value"] == -7


def test_client_that_leaves_while_it_sends_is_no_fault(
    client: httpx.Client, caplog: pytest.LogCaptureFixture
) -> None:
    with socket.create_connection((client.base_url.host, client.base_url.port or 0)) as leaving:
        head = f"POST {PROGRAMS} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        leaving.sendall(f"{head}Content-Length: 100\r\n\r\n{{".encode())
        client.get("/health/live")  # the service has begun to read
    for _ in range(20):
        client.get("/health/live")

    assert [record for record in caplog.records if record.levelno >= logging.ERROR] == []


def test_unknown_machine_is_a_404_problem_that_names_those_there_are(client: httpx.Client) -> None:
    body = check_problem(client.get("/v1/machines/nonesuch"), 404, "unknown_machine")

    assert "riveter" in str(body["remedy"])


@pytest.mark.parametrize("machine_id", ["..%2f..%2fetc%2fpasswd", "%2Fetc%2Fpasswd", "riveter.json"])
def test_a_machine_id_is_never_a_path(client: httpx.Client, machine_id: str) -> None:
    response = client.get(f"/v1/machines/{machine_id}")

    assert response.status_code == 404
    check_problem(response, 404, response.json()["code"])


def test_problem_of_the_engine_is_answered_with_its_headers(client: httpx.Client, engine: FakeEngine) -> None:
    engine.fault = ProblemError(problem("queue_full", "full", count=8, limit=8), {"Retry-After": "5"})

    try:
        response = client.post(PROGRAMS, json={"panel": {}})
    finally:
        engine.fault = None

    check_problem(response, 429, "queue_full")
    assert response.headers["retry-after"] == "5"


def test_fault_of_ours_is_a_500_problem_that_says_nothing_of_the_inside(
    client: httpx.Client, engine: FakeEngine
) -> None:
    engine.fault = RuntimeError("secret")

    try:
        response = client.post(PROGRAMS, json={"panel": {}})
    finally:
        engine.fault = None

    check_problem(response, 500, "internal_error")
    assert "secret" not in response.text


def test_trace_id_of_the_client_is_kept(client: httpx.Client) -> None:
    trace_id = "4bf92f3577b34da6a3ce929d0e0e4736"

    response = client.get("/nowhere", headers={"traceparent": f"00-{trace_id}-00f067aa0ba902b7-01"})

    assert response.json()["trace_id"] == trace_id


def test_every_kind_of_problem_has_an_error_status_and_a_title() -> None:
    assert all(400 <= status < 600 and title for status, title in KINDS.values())


names = st.sampled_from(["panel", "machine", "die", "dies", "start", "goal", "axes", "fastener_id", "seed"])
json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(["panel", "die", "start", "goal", "axes", "seed", "dies"]) | st.text(),
            inner,
            max_size=4,
        )
    ),
    max_leaves=15,
)


@given(value=json_values, path=st.sampled_from(["/v1/programs", "/v1/motions"]))
def test_no_json_makes_the_service_fail(client: httpx.Client, value: object, path: str) -> None:
    response = client.post(path, content=json.dumps(value).encode(), headers=JSON)

    assert response.status_code in (200, 201, 400, 422)
    if response.status_code >= 400:
        check_problem(response, response.status_code, response.json()["code"])


@given(body=st.binary(max_size=200))
def test_no_bytes_make_the_service_fail(client: httpx.Client, body: bytes) -> None:
    response = client.post(PROGRAMS, content=body, headers=JSON)

    assert response.status_code in (201, 400, 422)


def test_limits_of_the_tests_are_tighter_than_those_of_the_service() -> None:
    assert SETTINGS.json.max_bytes < JsonLimits().max_bytes
