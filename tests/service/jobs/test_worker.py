"""The worker's process: its name, its lock, and who starts it again."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from service.jobs import worker as worker_module
from service.jobs.locks import locks_of
from service.jobs.supervisor import Supervisor, embedded_slots
from service.jobs.worker import SLOT, SlotTaken
from tests.service.jobs.site import ROOT, Site


@pytest.mark.parametrize("slot", ["", "../x", "a b", "-a", "a" * 64, "ä"])
def test_a_slot_is_a_plain_name(tmp_path: Path, slot: str) -> None:
    assert SLOT.fullmatch(slot) is None
    command = [sys.executable, "-m", "service.cli", "worker", "--data", str(tmp_path), "--", slot]
    if slot == "../x":
        done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
        assert done.returncode == 2
        assert done.stderr.startswith("SLOT: ../x is no name of a worker.")
        assert len(done.stderr.splitlines()) == 1


def test_embedded_workers_have_names_of_their_own() -> None:
    slots = embedded_slots(3)
    assert len(set(slots)) == 3
    assert all(SLOT.fullmatch(slot) for slot in slots)
    assert embedded_slots(2) == slots[:2]


def test_a_name_is_one_workers(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_module, "_PATIENCE_S", 0.1)
    locks = locks_of(site.places)
    assert locks.hold("one")
    with pytest.raises(SlotTaken):
        worker_module._held(site.places, "one", threading.Event())
    other = worker_module._held(site.places, "two", threading.Event())
    assert other is not None
    other.release()
    locks.release()


def test_a_supervisor_starts_again_what_ends_and_leaves_nothing(tmp_path: Path) -> None:
    site = Site(tmp_path)
    supervisor = Supervisor(site.places, 1, 1.0)
    supervisor.start()
    try:
        site.wait_for(lambda: len(supervisor.pids) == 1)
        (first,) = supervisor.pids
        os.kill(first, signal.SIGKILL)
        site.wait_for(lambda: supervisor.pids not in ([], [first]))
        assert supervisor.deaths == 1
        slot = embedded_slots(1)[0]
        site.wait_for((site.places.locks / f"{slot}.lock").exists)
    finally:
        supervisor.stop()
        assert supervisor.pids == []
        site.close()


def test_a_worker_itself_brings_no_native_code() -> None:
    """Its child does: the worker begins in a moment, and survives what that code does."""
    code = "import sys, service.jobs.worker; print({'numba', 'coal', 'pinocchio'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)

    assert done.stdout == "set()\n"
