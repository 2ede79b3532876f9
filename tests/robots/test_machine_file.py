"""Machine files: what is read, what is hashed, what may be given instead of the defaults."""

import json
from pathlib import Path

import numpy as np
import pytest

from robots.definition_file import canonical_json, select
from robots.errors import InvalidInput, UnknownName
from robots.machine_file import MachineFile, load_machine
from robots.process_file import ProcessLibraryFile
from robots.tooling_file import DieLibraryFile, load_dies
from tests.robots.test_machine_faults import DATA, DIES, RIVETER, problems_of, with_change


@pytest.mark.parametrize(
    ("text", "pointer", "code"),
    [
        ("", "", "not_json"),
        ("[1, 2]", "", "wrong_type"),
        ('{"id": "a", "id": "b"}', "/id", "duplicate_field"),
        ('{"id": ' + "9" * 5000 + "}", "", "not_json"),
    ],
)
def test_a_file_that_is_no_document_is_refused(text: str, pointer: str, code: str, tmp_path: Path) -> None:
    (problem,) = problems_of(load_machine, tmp_path / "m.json", text)

    assert (problem.pointer, problem.code) == (pointer, code)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput) as caught:
        load_machine(tmp_path / "none.json")

    assert caught.value.problems[0].code == "unreadable_file"


@pytest.mark.parametrize(
    "name", ["riveter2", "../riveter", "robots/data/riveter.json", str(DATA / "riveter.json"), ""]
)
def test_a_text_is_an_id_and_never_opens_a_file(name: str) -> None:
    with pytest.raises(UnknownName) as caught:
        load_machine(name)

    assert caught.value.known == ("riveter",)


def test_a_machine_file_elsewhere_is_the_same_machine(tmp_path: Path) -> None:
    """Other layout, order of fields and way to write numbers: same content, same hash."""
    text = (
        json.dumps(RIVETER, indent=7, sort_keys=True).replace(" 12500", " 1.25e4").replace(": 0,", ": 0.0,")
    )
    (tmp_path / "m.json").write_text(text)

    machine, original = load_machine(tmp_path / "m.json"), load_machine("riveter")

    assert machine.definition == original.definition
    assert machine.sha256 == original.sha256
    np.testing.assert_array_equal(machine.upper, original.upper)


def test_every_change_of_content_changes_the_hash(tmp_path: Path) -> None:
    original = load_machine("riveter").sha256
    changes = [("/axes/0/upper_mm", 12500.001), ("/clearance/default_mm", 2.0001), ("/title", "other")]
    for pointer, value in changes:
        (tmp_path / "m.json").write_text(json.dumps(with_change(RIVETER, pointer, value)))

        assert load_machine(tmp_path / "m.json").sha256 != original


@pytest.mark.parametrize(
    ("name", "model"), [("riveter", MachineFile), ("dies", DieLibraryFile), ("processes", ProcessLibraryFile)]
)
def test_data_files_survive_a_round_trip(name: str, model: type[MachineFile]) -> None:
    """Read, write, read: the same values, and nothing of the file is lost on the way."""
    document = json.loads((DATA / f"{name}.json").read_text())

    written = canonical_json(model.model_validate_json(json.dumps(document)))

    assert json.loads(written) == document
    assert written == json.dumps(json.loads(written), sort_keys=True, separators=(",", ":")).encode()
    assert canonical_json(model.model_validate_json(written)) == written


def test_other_tooling_can_be_given(tmp_path: Path) -> None:
    document = with_change(DIES, "/dies/0/id", "thin")
    (tmp_path / "d.json").write_text(json.dumps(document))

    machine = load_machine("riveter", dies=load_dies(tmp_path / "d.json"))

    assert machine.dies.ids[0] == "thin"


def test_dies_for_another_link_are_refused(tmp_path: Path) -> None:
    (tmp_path / "d.json").write_text(json.dumps(with_change(DIES, "/link", "W")))

    with pytest.raises(InvalidInput) as caught:
        load_machine("riveter", dies=load_dies(tmp_path / "d.json"))

    assert {problem.code for problem in caught.value.problems} == {"die_on_wrong_link"}


def test_a_chain_machine_may_have_any_layout(tmp_path: Path) -> None:
    document = with_change(RIVETER, "/kinematics", "chain")
    document = with_change(document, "/panel_chain/3/offset_mm", [0, 0, 10])
    document = with_change(document, "/gantry_base_mm/0", -99_000)

    assert problems_of(load_machine, tmp_path / "m.json", document) == ()


def test_select_walks_lists_and_passes_over_what_is_missing() -> None:
    document = {"a": [{"b": 1}, {"c": 2}, 3, {"b": [4]}]}

    assert select(document, "/a/*/b") == [("/a/0/b", 1), ("/a/3/b", [4])]
    assert select(document, "/x/*/b") == []
    assert select(None, "/a") == []
