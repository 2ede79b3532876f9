"""What jobs compute: the same answers as service.tasks, without its limits. Imports the native libraries."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TypeVar

from pydantic import ValidationError

from robots.errors import InvalidInput
from robots.schema_problems import schema_problems
from service import tasks
from service.access_schemas import AccessibilityRequest
from service.answers import Answer
from service.area_schemas import AreaRequest, VolumeRequest
from service.batches.digest import keep_digest
from service.free_volume_schemas import FreeVolumeRequest
from service.jobs.child import Desk, Task
from service.jobs.chunks import ChunkMemo
from service.jobs.model import Progress
from service.pattern_schemas import RivetPatternRequest
from service.programming import ProgressEvent
from service.schemas import MotionRequest, ProgramRequest, Strict
from service.settings import Settings
from service.strict_json import JsonLimits, parse
from service.verification_schemas import VerificationRequest

_Model = TypeVar("_Model", bound=Strict)
_UNLIMITED = Settings(
    max_sync_fasteners=sys.maxsize,
    max_sync_access_checks=sys.maxsize,
    max_sync_volume_pairs=sys.maxsize,
    max_sync_blocks=sys.maxsize,
)
_JSON = JsonLimits(max_bytes=sys.maxsize)
_PLANNED, _VERIFYING = 0.85, 0.15
"""Shares of a program's time, a rough estimate: the first die's pass stands for all planning, later
passes have little left to do.
"""


def program(request: bytes, desk: Desk) -> Answer:
    """Return a panel's program; runs that were planned before are not planned again."""
    order = _read(request, ProgramRequest)
    memo = ChunkMemo(desk.store, desk.after_chunk)
    answer = tasks.program(order, _UNLIMITED, memo=memo, progress=_teller(desk))
    keep_digest(desk.store, answer.body)
    return answer


def _teller(desk: Desk) -> Callable[[ProgressEvent], None]:
    """What says how far a program is; its share never falls."""
    reached = 0.0

    def tell(event: ProgressEvent) -> None:
        nonlocal reached
        part = event.done / event.total if event.total else 1.0
        share = _PLANNED + _VERIFYING * part if event.phase == "verify" else _PLANNED * part
        reached = max(reached, share)
        desk.tell(Progress(event.phase, event.done, event.total, reached))

    return tell


def _whole(name: str, model: type[Strict]) -> Task:
    """A task that is computed in one piece."""

    def compute(request: bytes, _desk: Desk) -> Answer:
        task: Callable[[Strict, Settings], Answer] = getattr(tasks, name)
        return task(_read(request, model), _UNLIMITED)

    return compute


def _read(request: bytes, model: type[_Model]) -> _Model:
    """The request, checked again: what is stored may be older than the program that reads it."""
    document = parse(request, _JSON)
    assert isinstance(document, dict), "the API keeps JSON objects only"
    try:
        return model.model_validate(document)
    except ValidationError as error:
        raise InvalidInput([each for _, each in schema_problems(error.errors(), document, model)]) from None


TASKS: dict[str, Task] = {
    "program": program,
    "accessibility": _whole("accessibility", AccessibilityRequest),
    "accessibility_areas": _whole("accessibility_areas", AreaRequest),
    "accessibility_volumes": _whole("accessibility_volumes", VolumeRequest),
    "free_volume": _whole("free_volume", FreeVolumeRequest),
    "free_volume_mesh": _whole("free_volume_mesh", FreeVolumeRequest),
    "motion": _whole("motion", MotionRequest),
    "rivet_pattern": _whole("rivet_pattern", RivetPatternRequest),
    "verification": _whole("verification", VerificationRequest),
}
