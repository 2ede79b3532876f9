"""The service as the contract's tests ask it: with a key, without limits of rate, computing at once."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

from fastapi import FastAPI

from service import tasks
from service.app import create_app
from service.batches.batches import Batches
from service.engine import ProcessEngine
from service.jobs.database import prepare
from service.jobs.places import JobPlaces
from service.jobs.queue import DbosJobs
from service.schema_base import Strict
from service.security.keys import FILE_NAME
from service.security.scopes import Scope
from service.security.settings import SecuritySettings
from service.settings import Settings
from service.strict_json import JsonLimits
from tests.service.security.guarded import key_file

#: Small budgets: what does not fit them is refused, which is an answer as good as another here.
_SETTINGS = Settings(
    max_sync_fasteners=4,
    max_sync_access_checks=20_000,
    max_sync_volume_pairs=60,
    max_sync_blocks=200,
    json=JsonLimits(max_bytes=1_000_000),
)


class InThisProcess(ProcessEngine):
    """Computes what the worker processes would, here and now; the same request once."""

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        self._known: dict[tuple[str, bytes], object] = {}

    @property
    def ready(self) -> bool:
        return True

    async def start(self) -> None:
        pass

    async def close(self) -> None:
        pass

    async def _outcome(self, task: str, *arguments: object) -> object:
        order = arguments[0]
        compute: Callable[..., object] = cast("dict[str, Any]", tasks.TASKS)[task]
        if not isinstance(order, Strict):
            return compute(*arguments, self._settings)
        name = (task, order.canonical())
        if name not in self._known:
            self._known[name] = compute(order.unfolded(), self._settings)
        return self._known[name]


@dataclass(frozen=True)
class Site:
    """An application and a key that may do everything there."""

    app: FastAPI
    key: str


def unlimited(directory: Path) -> SecuritySettings:
    """Return settings that ask for keys, and let their owners send as much as they like."""
    return SecuritySettings(
        keys=directory / FILE_NAME, requests_per_s=1_000_000.0, burst=1_000_000, at_once=1_000
    )


def build(directory: Path, create: Callable[..., FastAPI] = create_app) -> Site:
    """Return the service with its data in `directory`. create: makes it, with a fault perhaps.

    Its jobs are kept as everywhere and computed by nobody.
    """
    key = key_file(directory).add("contract", Scope.ADMIN)
    settings = replace(_SETTINGS, security=unlimited(directory))
    places = JobPlaces.of(directory, {})
    prepare(places)
    jobs = DbosJobs(places)
    batching, store = Batches(jobs, places), places.store()
    return Site(create(settings, InThisProcess(settings), jobs, batching=batching, artefacts=store), key)
