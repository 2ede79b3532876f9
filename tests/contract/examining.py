"""Runs schemathesis on the application, in this process, and tells what it found."""

import os
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import schemathesis
from fastapi import FastAPI
from schemathesis import engine
from schemathesis.engine import events

from tests.contract import checks as checks  # registers them
from tests.contract.document import prepared

#: Fixed, so that a failure in continuous integration is one that can be looked at.
SEED = 20261123
PHASES = ("examples", "coverage", "fuzzing", "stateful")


@dataclass
class Examined:
    """What a run did: requests by status, and what is wrong, a line each."""

    answers: Counter[tuple[str, int]] = field(default_factory=Counter)
    failures: dict[str, str] = field(default_factory=dict)

    @property
    def cases(self) -> int:
        return self.answers.total()

    def __add__(self, other: "Examined") -> "Examined":
        return Examined(self.answers + other.answers, self.failures | other.failures)


def examine(
    app: FastAPI,
    *,
    key: str,
    operations: list[str] | None = None,
    phases: tuple[str, ...] = PHASES,
    examples: int = 10,
    seed: int | None = SEED,
    one_panel: bool = False,
    program: str | None = None,
    headers: Mapping[str, str] | None = None,
) -> Examined:
    """Ask the application what schemathesis makes of its document.

    operations: names ("GET /v1/machines"), all without. examples: how many requests are made up for each
    operation by `fuzzing`, and how many chains of requests by `stateful`. seed: None takes a new one.
    one_panel, program: see `prepared`. headers: of every request.
    """
    chosen = seed if seed is not None else int.from_bytes(os.urandom(4), "big")
    asked = settings(key, phases, examples, chosen)
    asked["headers"] |= headers or {}
    config = schemathesis.Config.from_dict(asked)
    document = prepared(app.openapi(), one_panel=one_panel, program=program)
    schema: schemathesis.BaseSchema = schemathesis.openapi.from_dict(document, config=config)
    schema.app = app
    if operations is not None:
        schema = schema.include(name=operations)
    found = Examined()
    for event in engine.from_schema(schema).execute():
        _note(event, found)
    if found.failures:
        found.failures["seed"] = str(chosen)
    return found


def settings(key: str, phases: tuple[str, ...], examples: int, seed: int) -> dict[str, Any]:
    """Return what schemathesis' own file of settings has.

    DELETE cancels a job; what was asked for and became of it stays to be read, so that is no use after free.
    """
    return {
        "seed": seed,
        "suppress-health-check": ["all"],
        "continue-on-failure": True,
        "workers": 1,
        "request-timeout": 60.0,
        "max-stream-events": 1,
        "headers": {"Authorization": f"Bearer {key}"},
        "generation": {
            "max-examples": examples,
            "allow-x00": False,
            "no-shrink": True,
            "database": "none",
        },
        "phases": {name: {"enabled": name in phases} for name in PHASES},
        "checks": {"use_after_free": {"enabled": False}},
    }


def _note(event: events.EngineEvent, found: Examined) -> None:
    if isinstance(event, events.NonFatalError):
        found.failures[f"{event.label}: error"] = str(event.value)
    elif isinstance(event, events.FatalError):
        found.failures["error"] = repr(event.exception)
    elif isinstance(event, events.ScenarioFinished):
        recorder = event.recorder
        for case_id, interaction in recorder.interactions.items():
            if interaction.response is not None:
                label = recorder.cases[case_id].value.operation.label
                found.answers[label, interaction.response.status_code] += 1
        for case_id, nodes in recorder.checks.items():
            for node in nodes:
                if node.failure_info is not None:
                    label = recorder.cases[case_id].value.operation.label
                    name = f"{label}: {node.name}: {node.failure_info.failure.title}"
                    answer = recorder.interactions[case_id].response
                    text = "" if answer is None else answer.content.decode(errors="replace")
                    sample = node.failure_info.code_sample
                    found.failures.setdefault(name, f"{node.failure_info.failure}\n{text}\n{sample[:2000]}")
