"""The texts of whole panels: every dialect's is clean, for just the motion of its program."""

import pytest

from robots.post.dialects import DIALECTS, post
from robots.strict_json import read_document
from service.inputs import Places, gather
from service.verification import of_text, verification
from tests.robots.post.programs import ROOT, planned


@pytest.mark.long
@pytest.mark.parametrize("panel", ["a320_shell", "wing", "fuselage", "cockpit"])
@pytest.mark.parametrize("dialect", DIALECTS)
def test_posted_text_of_a_panel_is_clean(panel: str, dialect: str) -> None:
    document = read_document(ROOT / "openapi" / "examples" / f"{panel}.json")
    inputs = gather(document, "riveter", None, Places())
    program = planned(panel)
    left_out = [fastener.id for fastener in program.fasteners if fastener.status != "installed"]
    data = post(program, dialect).encode()

    found = verification(
        of_text(data, dialect, inputs.panel, inputs.machine, left_out), inputs.panel, inputs.machine
    )

    assert (found.result, found.findings) == ("clean", [])
    assert found.fasteners.installed == program.summary.counts.installed
    assert found.fasteners.not_installed == left_out
    assert found.cycle_time_s == pytest.approx(program.summary.cycle_time_s, rel=1e-3)
