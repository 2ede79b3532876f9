"""Traces: a client's is continued, whatever else it sends begins one, and a job belongs to its request's."""

import re

import httpx
import pytest

from service.trace import Trace, bound, of_job, working_on

GIVEN = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"
HEADER = re.compile(r"00-([0-9a-f]{32})-([0-9a-f]{16})-([0-9a-f]{2})")


def test_a_trace_is_continued_with_a_span_of_our_own() -> None:
    trace = Trace.of(GIVEN)

    assert trace.id == "4bf92f3577b34da6a3ce929d0e0e4736"
    assert trace.flags == "01"
    assert trace.span != "00f067aa0ba902b7"
    assert Trace.of(trace.header).id == trace.id


@pytest.mark.parametrize("later", ["", "-more", "-more-and-more"])
def test_a_header_of_a_later_version_is_read_as_far_as_it_is_known(later: str) -> None:
    assert Trace.of(f"cc{GIVEN[2:]}{later}").id == "4bf92f3577b34da6a3ce929d0e0e4736"


@pytest.mark.parametrize(
    "header",
    [
        None,
        "",
        "4bf92f3577b34da6a3ce929d0e0e4736",
        GIVEN.upper(),
        f"ff{GIVEN[2:]}",
        f"{GIVEN}-more",
        f"00-{'0' * 32}-00f067aa0ba902b7-01",
        f"00-4bf92f3577b34da6a3ce929d0e0e4736-{'0' * 16}-01",
        f"{GIVEN}\n",
    ],
)
def test_what_is_no_trace_begins_one(header: str | None) -> None:
    trace = Trace.of(header)

    assert HEADER.fullmatch(trace.header)
    assert trace.id not in {"4bf92f3577b34da6a3ce929d0e0e4736", "0" * 32}
    assert trace.id != Trace.of(header).id


@pytest.mark.parametrize("path", ["/health/live", "/v1/machines/nope", "/nowhere"])
def test_every_answer_names_its_trace(client: httpx.Client, path: str) -> None:
    answer = client.get(path, headers={"traceparent": GIVEN})

    assert answer.headers["traceparent"].startswith(GIVEN[:36])
    assert answer.headers["traceparent"] != GIVEN
    if answer.status_code != 200:
        assert answer.json()["trace_id"] == GIVEN[3:35]


def test_a_problem_without_a_trace_of_the_clients_has_the_one_in_its_header(client: httpx.Client) -> None:
    answer = client.get("/nowhere")

    found = HEADER.fullmatch(answer.headers["traceparent"])
    assert found is not None
    assert answer.json()["trace_id"] == found[1]


def test_a_job_belongs_to_the_trace_of_its_request() -> None:
    assert of_job("j1", None) == {"job": "j1"}
    assert of_job("j1", GIVEN)["trace_id"] == GIVEN[3:35]

    with working_on(of_job("j1", GIVEN)):
        assert bound()["job"] == "j1"
    assert "job" not in bound()
