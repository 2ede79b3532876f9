"""Addresses of jobs that nobody was told: whatever they are made of, they lead nowhere."""

import pytest

from tests.service.jobs.http import api, refused
from tests.service.jobs.site import Site

ODD = ("%00", "a%00b", "%ED%A0%80", "%F0%9F%9B%A9", "..%00", "a" * 5000, "%27%20OR%201=1")


@pytest.mark.parametrize("form", ["", "/events", "/result"])
def test_no_job_is_at_an_odd_address(site: Site, form: str) -> None:
    with api(site) as client:
        for job_id in ODD:
            refused(client.get(f"/v1/jobs/{job_id}{form}"), 404, "not_found")


def test_what_no_job_has_as_its_address_cannot_be_cancelled(site: Site) -> None:
    with api(site) as client:
        for job_id in ODD:
            refused(client.delete(f"/v1/jobs/{job_id}"), 404, "not_found")


def test_no_batch_of_an_odd_name_has_jobs(site: Site) -> None:
    with api(site) as client:
        for batch in ("%00", "a%00b", "%ED%A0%80", "%F0%9F%9B%A9"):
            answer = client.get(f"/v1/jobs?batch_id={batch}")
            assert (answer.status_code, answer.json()["jobs"]) == (200, [])
