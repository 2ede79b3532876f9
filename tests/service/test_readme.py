"""What the README shows is what the commands print."""

from robots.nc_json import from_json
from service.summary import program_rows
from tests.service.conftest import ROOT, CrossingRun


def test_the_readme_shows_the_program_of_the_crossing_as_it_is_planned_today(
    crossing_run: CrossingRun,
) -> None:
    lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    begin = lines.index("$ rivetplan plan openapi/examples/crossing.json --seed 7")
    shown = [tuple(cell.strip() for cell in line.split("│")[1:3]) for line in lines[begin + 3 : begin + 24]]

    rows = program_rows(from_json(crossing_run.program.read_bytes()))

    assert [row for row in shown if len(row) == 2] == [(name.strip(), value) for name, value in rows]
