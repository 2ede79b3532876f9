"""What jobs and workers add up to, in their database: counted once, and kept when they are gone."""

from service.errors import problem
from service.jobs import totals
from service.jobs.child import Done
from service.jobs.ledger import Claim, Ledger
from service.jobs.model import Job, JobState, Totals
from service.jobs.retention import tidy
from service.jobs.roll import Roll, note_death
from service.jobs.totals import PLAN_S, read
from service.metrics import Metrics
from tests.service.jobs.site import Site
from tests.service.operations.test_metrics import FIGURES, one


def _begun(site: Site, name: str) -> tuple[Job, Claim]:
    job = site.submit(name)
    return job, Claim(job.id, "", None, 0.0, -2.0)


def test_a_finished_job_is_counted_once_whoever_notes_it(site: Site) -> None:
    ledger = Ledger(site.engine, "w")
    _, claim = _begun(site, "first")
    _, other = _begun(site, "second")

    for _ in range(2):  # the answer of the database was lost, or another took over meanwhile
        ledger.finish(claim, Done("sha", "application/json", 0, 1, FIGURES))
    ledger.finish(other, problem("internal_error", "it failed"))

    with site.engine.connect() as connection:
        found = read(connection)
    assert found.of(totals.LINKS) == {"direct": 7, "planned": 2}
    assert found.of(totals.REFUSED) == {"blocked": 3}
    assert sum(found.of(totals.CLASSES).values()) == 2
    text = Metrics().text({}, found).decode()
    assert one(text, "job_links_total", origin="direct") == 7
    assert one(text, "job_plan_seconds_count", task="chunks") == 2


def test_plan_seconds_fall_into_their_classes(site: Site) -> None:
    with site.engine.begin() as connection:
        for seconds in (PLAN_S[0], PLAN_S[1], PLAN_S[1] + 0.01, 1e6):
            totals.add_task(connection, "program", seconds, None)
        text = Metrics().text(None, read(connection)).decode()

    def up_to(end: str) -> float:
        return one(text, "job_plan_seconds_bucket", task="program", le=end)

    assert [up_to(str(end)) for end in PLAN_S[:3]] == [1, 2, 3]
    assert up_to("+Inf") == one(text, "job_plan_seconds_count", task="program") == 4


def test_jobs_that_retention_removed_stay_counted(site: Site) -> None:
    job = site.submit("old")
    site.use(lambda jobs: jobs.cancel(job.id))

    def finished() -> Totals:
        with site.engine.connect() as connection:
            return read(connection)

    assert finished().finished[JobState.CANCELLED] == 1

    assert tidy(site.engine, site.places.store(), days=-1.0) == 1

    assert finished().finished == {
        JobState.SUCCEEDED: 0,
        JobState.FAILED: 0,
        JobState.CANCELLED: 1,
    }


def test_a_worker_that_ends_without_a_word_is_counted_once(site: Site) -> None:
    for slot in ("good", "bad"):
        dead = Roll(site.engine, slot)
        dead.enter()
        dead.fall_silent()
    good = Roll(site.engine, "good")
    good.enter()
    good.leave()
    for _ in range(2):  # two watchdogs saw it
        note_death(site.engine, "bad")
        note_death(site.engine, "good")
    running = Roll(site.engine, "running")
    running.enter()

    with site.engine.connect() as connection:
        found = read(connection)

    assert found.of(totals.WORKER_DEATHS) == {"": 2}
    assert found.workers == 1
    running.leave()
