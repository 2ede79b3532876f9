"""The digest of a program: the little of its megabytes that reports are made of.

Made where the program is made, and kept in the artefact store; one that is missing is made again in a process
of its own, because reading a large program holds the interpreter's lock for long.
"""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Iterable, Mapping
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from service.jobs.artefacts import Store
from service.jobs.fingerprint import fingerprint
from service.worker import Worker, WorkerLost

_LOG = logging.getLogger("rivetplan.service")
_FORMAT = 1
_MOST_FINDINGS = 5


class Refused(BaseModel):
    """A fastener that is not installed, and why."""

    model_config = ConfigDict(frozen=True)

    id: str
    status: str
    code: str
    text: str


class ProgramClearance(BaseModel):
    """The smallest guaranteed clearance of a program, and between what."""

    model_config = ConfigDict(frozen=True)

    mm: float
    solid: str
    part: str
    block_n: int


class Digest(BaseModel):
    """What reports tell of a program. installed: ids of fasteners, in the panel's order, as `refused`."""

    model_config = ConfigDict(frozen=True)

    program_id: str
    panel_id: str
    panel_sha256: str
    machine_id: str
    title: str
    installed: tuple[str, ...]
    refused: tuple[Refused, ...]
    cycle_time_s: float
    clearance: ProgramClearance | None
    certificate: str | None
    finding_count: int
    findings: tuple[str, ...]


def digest_of(program: bytes) -> Digest:
    """The digest of a program's file."""
    document = json.loads(program)
    header, certificate = document["header"], document["verification"]
    least = certificate and certificate["min_clearance"]
    fasteners = document["fasteners"]
    return Digest(
        program_id=header["program_id"],
        panel_id=header["inputs"]["panel"]["id"],
        panel_sha256=header["inputs"]["panel"]["sha256"],
        machine_id=document["machine"]["id"],
        title=header["title"],
        installed=tuple(each["id"] for each in fasteners if each["status"] == "installed"),
        refused=tuple(_refused(each) for each in fasteners if each["status"] != "installed"),
        cycle_time_s=document["summary"]["cycle_time_s"],
        clearance=least
        and ProgramClearance(
            mm=least["mm"], solid=least["pair"][0], part=least["pair"][1], block_n=least["block_n"]
        ),
        certificate=certificate and certificate["result"],
        finding_count=len(certificate["findings"]) if certificate else 0,
        findings=tuple(each["text"] for each in certificate["findings"][:_MOST_FINDINGS])
        if certificate
        else (),
    )


def _refused(fastener: Mapping[str, object]) -> Refused:
    reason = fastener["reason"]
    code, text = (reason["code"], reason["text"]) if isinstance(reason, dict) else ("", "")
    return Refused(id=str(fastener["id"]), status=str(fastener["status"]), code=code, text=text)


def keep_digest(store: Store, program: bytes) -> None:
    """Keep the digest of a program's file."""
    key = _key(hashlib.sha256(program).hexdigest())
    store.keep(key, digest_of(program).model_dump_json().encode())


def digests(store: Store, programs: Iterable[str]) -> dict[str, Digest]:
    """The digests of programs by the sha256 of their files; one that cannot be read is left out.

    It may take long and waits for a process: not for an event loop.
    """
    wanted = sorted(set(programs))
    found = {sha256: kept for sha256 in wanted if (kept := _recalled(store, sha256)) is not None}
    missing = [sha256 for sha256 in wanted if sha256 not in found]
    if missing:
        worker = Worker(__name__)
        try:
            worker.wait_until_ready()
            for sha256 in missing:
                worker.call("keep", store.root, sha256)
        except WorkerLost:
            _LOG.error("the process that reads programs for reports ended")
        finally:
            worker.end()
        found |= {sha256: kept for sha256 in missing if (kept := _recalled(store, sha256)) is not None}
    return found


def _recalled(store: Store, sha256: str) -> Digest | None:
    kept = store.recall(_key(sha256))
    return None if kept is None else Digest.model_validate_json(kept)


def _key(sha256: str) -> str:
    return fingerprint("digest of a program", _FORMAT, sha256)


def _keep(root: Path, sha256: str) -> None:
    store = Store(root)
    if store.path(sha256) is not None:
        keep_digest(store, store.get(sha256))


TASKS = {"keep": _keep}
