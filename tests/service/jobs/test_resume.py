"""A real program whose makers are killed: its bytes are those of an undisturbed run."""

import json
import os
import re
import signal
from pathlib import Path

import pytest

from robots.machine_file import load_machine
from robots.nc_json import to_json
from robots.panel_file import load_panel
from service.jobs.model import Job, JobState, NewJob
from service.programming import RUN_LENGTH, program_panel
from tests.service.conftest import ROOT
from tests.service.jobs.site import Site

ZSTD = bytes.fromhex("28b52ffd")
PANELS = ROOT / "openapi" / "examples"


def test_the_next_service_goes_on_where_a_killed_one_was(tmp_path: Path) -> None:
    """A process dies after two runs of the panel; so does a service; the next one plans only the rest."""
    site, panel = Site(tmp_path), PANELS / "fuselage.json"
    try:
        killed = ["tests.service.jobs.killed_planner", str(panel), str(site.places.artefacts), "2"]
        assert site.start(killed, "planner.log").wait() == -signal.SIGKILL
        finished = chunks(site)
        assert len(finished) == 2
        job = ordered(site, panel)
        service = site.serve()
        site.wait_for(lambda: "is ready" in site.log("serve"))
        service.kill()
        service.wait()
        site.wait_for(lambda: not site.left())  # its worker ends by itself
        site.serve()
        job = site.final(job)
        same_as_undisturbed(site, job, panel)
        not_computed_again(site, finished)
    finally:
        site.close()


@pytest.mark.long
def test_a_whole_shell_survives_kills_of_everything(site: Site) -> None:
    """Service, worker and child are killed at once, again and again, each time a little later."""
    panel, finished = PANELS / "a320_shell.json", dict[str, int]()
    job = ordered(site, panel)
    for count in (1, 10, 30):
        service = site.serve()
        site.wait_for(lambda count=count: len(chunks(site)) >= count)  # type: ignore[misc]
        os.kill(service.pid, signal.SIGKILL)  # first: it would start others
        service.wait()
        for each in site.left():
            os.kill(each, signal.SIGKILL)
        site.wait_for(lambda: not site.left())
        assert finished.items() <= chunks(site).items()
        finished = chunks(site)
    site.serve()
    job = site.final(job)
    same_as_undisturbed(site, job, panel)
    not_computed_again(site, finished)


def ordered(site: Site, panel: Path) -> Job:
    """A job for a panel's program."""
    request = {"panel": json.loads(panel.read_bytes()), "machine": "riveter", "dies": ["straight"], "seed": 7}
    return site.use(lambda jobs: jobs.submit(NewJob("program", json.dumps(request).encode(), "test")))


def same_as_undisturbed(site: Site, job: Job, file: Path) -> None:
    assert job.state is JobState.SUCCEEDED
    machine, panel = load_machine("riveter"), load_panel(file)
    undisturbed = program_panel(panel, machine, [machine.dies["straight"]], seed=7)
    assert site.answer(job) == to_json(undisturbed.program)
    assert len(chunks(site)) == -(-len(panel.fasteners) // RUN_LENGTH)


def not_computed_again(site: Site, finished: dict[str, int]) -> None:
    found = chunks(site)
    assert finished.items() <= found.items()
    (told,) = re.findall(r"done, (\d+) chunks computed, (\d+) recalled", site.log("serve"))
    assert int(told[0]) + int(told[1]) == len(found)
    assert int(told[1]) >= len(finished)


def chunks(site: Site) -> dict[str, int]:
    """The finished chunks and the files they are in: one that is written again is in another.

    Programs' digests lie among them; a run is compressed.
    """
    found = (site.places.artefacts / "memo").glob("??/*")
    runs = [path for path in found if "." not in path.name and path.read_bytes()[32:].startswith(ZSTD)]
    return {path.name: path.stat().st_ino for path in runs}
