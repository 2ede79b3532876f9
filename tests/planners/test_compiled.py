from pathlib import Path

from planners.compiled import source_digest


def test_any_change_to_a_folders_sources_sends_its_compiled_results_elsewhere(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text("one = 1")
    (tmp_path / "b.py").write_text("")
    digests = [source_digest(tmp_path)]
    (tmp_path / "a.py").write_text("one = 2")
    digests.append(source_digest(tmp_path))
    (tmp_path / "a.py").rename(tmp_path / "c.py")
    digests.append(source_digest(tmp_path))

    assert len(set(digests)) == 3
    assert source_digest(tmp_path) == digests[-1]
