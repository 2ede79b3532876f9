"""Metrics: what is counted, once each, with labels of our own, and what outlives processes and retention."""

import re

import httpx
from prometheus_client.parser import text_string_to_metric_families

from service.answers import Answer
from service.figures import Figures
from service.metrics import Metrics

FIGURES = Figures({"direct": 7, "planned": 2}, {"blocked": 3}, 0)


def values(text: str) -> dict[tuple[str, frozenset[tuple[str, str]]], float]:
    """Every sample that a scraper reads."""
    return {
        (sample.name, frozenset(sample.labels.items())): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


def one(text: str, name: str, **labels: str) -> float:
    return values(text).get((f"rivetplan_{name}", frozenset(labels.items())), 0.0)


def test_requests_are_counted_by_template_and_problems_by_code(client: httpx.Client) -> None:
    before = client.get("/metrics").text
    client.get("/v1/machines/riveter")
    for path in ("nope", "nada"):
        client.get(f"/v1/machines/{path}")
        client.get(f"/{path}")
    after = client.get("/metrics").text

    def grew(name: str, **labels: str) -> float:
        return one(after, name, **labels) - one(before, name, **labels)

    route = "/v1/machines/{machine_id}"
    assert grew("http_requests_total", method="GET", route=route, status="200") == 1
    assert grew("http_requests_total", method="GET", route=route, status="404") == 2
    assert grew("http_requests_total", method="GET", route="none", status="404") == 2
    assert grew("http_request_seconds_count", method="GET", route=route) == 3
    assert grew("problems_total", code="not_found") == 2
    assert grew("problems_total", code="unknown_machine") == 2
    assert one(after, "http_requests_under_way") == 1  # this one
    assert one(after, "event_loop_lag_seconds_count") > 0


def test_labels_are_of_our_own_choosing(client: httpx.Client) -> None:
    for method in ("BREW", "SPAM"):
        client.request(method, "/v1/machines")
    client.get("/attack-path?attack-query=1", headers={"traceparent": "attack-header"})

    text = client.get("/metrics").text

    assert "attack" not in text
    assert "BREW" not in text
    assert 'method="other"' in text


def test_every_application_counts_for_itself() -> None:
    first, second = Metrics(), Metrics()

    first.observe_task("program", 0.7, FIGURES)

    assert one(first.text(None, None).decode(), "links_total", origin="direct") == 7
    assert one(first.text(None, None).decode(), "refused_fasteners_total", reason="blocked") == 3
    assert one(second.text(None, None).decode(), "links_total", origin="direct") == 0
    assert not re.search("^(process|python)_", first.text(None, None).decode(), re.MULTILINE)


def test_an_answer_without_figures_counts_as_a_task_only() -> None:
    metrics = Metrics()

    metrics.observe_task("motion", 0.01, Answer(b"", "").figures)

    assert one(metrics.text(None, None).decode(), "plan_seconds_count", task="motion") == 1
