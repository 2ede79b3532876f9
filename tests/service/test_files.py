"""Files are written whole or not at all."""

import os
from pathlib import Path

import pytest

from service.files import write_atomically


def test_file_is_written_and_replaced(tmp_path: Path) -> None:
    file = tmp_path / "a.json"

    write_atomically(file, b"one")
    write_atomically(file, b"two")

    assert file.read_bytes() == b"two"
    assert list(tmp_path.iterdir()) == [file]


def test_file_that_cannot_take_its_place_leaves_nothing_behind(tmp_path: Path) -> None:
    occupied = tmp_path / "a.json"
    occupied.mkdir()

    with pytest.raises(OSError, match="directory"):
        write_atomically(occupied, b"new")

    assert list(tmp_path.iterdir()) == [occupied]


def test_file_gets_the_permissions_every_new_file_gets(tmp_path: Path) -> None:
    (tmp_path / "plain").touch()

    write_atomically(tmp_path / "a.json", b"")

    assert (tmp_path / "a.json").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_link_stays_a_link_and_the_file_it_names_is_written(tmp_path: Path) -> None:
    link, file = tmp_path / "latest.json", tmp_path / "a.json"
    link.symlink_to(file)

    write_atomically(link, b"new")

    assert link.is_symlink()
    assert file.read_bytes() == b"new"
    assert set(tmp_path.iterdir()) == {link, file}


def test_what_a_process_of_the_same_number_left_behind_is_in_nobodys_way(tmp_path: Path) -> None:
    (tmp_path / f".a.json.{os.getpid()}.tmp").write_bytes(b"half of")

    write_atomically(tmp_path / "a.json", b"new")

    assert (tmp_path / "a.json").read_bytes() == b"new"


def test_the_longest_name_a_file_can_have_is_written(tmp_path: Path) -> None:
    file = tmp_path / ("n" * 255)

    write_atomically(file, b"new")

    assert file.read_bytes() == b"new"
