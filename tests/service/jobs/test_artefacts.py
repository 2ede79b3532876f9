"""The artefact store: what is put comes back, whole or not at all."""

import gzip
import hashlib
import os
from pathlib import Path

import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st

from service.jobs.artefacts import Store

KEY = hashlib.sha256(b"inputs").hexdigest()


def aged(path: Path, seconds: float) -> None:
    at = path.stat().st_mtime - seconds
    os.utime(path, (at, at))


@given(content=st.binary(max_size=2000))
@settings(max_examples=30)
def test_what_is_put_comes_back_under_its_sha256(
    tmp_path_factory: pytest.TempPathFactory, content: bytes
) -> None:
    store = Store(tmp_path_factory.mktemp("store"))
    sha256 = store.put(content, served=True)

    assert sha256 == hashlib.sha256(content).hexdigest()
    assert store.get(sha256) == content
    packed = {encoding: store.path(sha256, encoding) for encoding in ("identity", "zstd", "gzip")}
    assert packed["identity"] is not None
    assert packed["zstd"] is not None
    assert packed["gzip"] is not None
    assert zstandard.decompress(packed["zstd"].read_bytes()) == content
    assert gzip.decompress(packed["gzip"].read_bytes()) == content
    assert store.put(content, served=True) == sha256


def test_only_a_sha256_names_a_file(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("secret")
    store = Store(tmp_path / "store")
    for name in ("../secret", "", "ab", "../" * 21 + "a", KEY.upper(), KEY):
        assert store.path(name) is None
        with pytest.raises(KeyError):
            store.get(name)


def test_what_was_computed_is_recalled_unless_it_is_damaged(tmp_path: Path) -> None:
    store = Store(tmp_path)
    assert store.recall(KEY) is None
    store.keep(KEY, b"result")
    assert store.recall(KEY) == b"result"

    path = tmp_path / "memo" / KEY[:2] / KEY
    for damaged in (b"", path.read_bytes()[:-1], path.read_bytes()[:-1] + b"!"):
        path.write_bytes(damaged)
        assert store.recall(KEY) is None
    store.keep(KEY, b"result")
    assert store.recall(KEY) == b"result"


def test_a_writer_that_fails_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        Store(tmp_path).put(b"content")

    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_sweeping_spares_what_is_wanted_and_what_is_young(tmp_path: Path) -> None:
    store = Store(tmp_path)
    wanted, young, old = (
        store.put(b"wanted", served=True),
        store.put(b"young"),
        store.put(b"old", served=True),
    )
    store.keep(KEY, b"result")
    unfinished = tmp_path / wanted[:2] / f"{wanted}.00.new"
    unfinished.write_bytes(b"")
    for path in tmp_path.rglob("*"):
        if path.is_file() and path.name != young:
            aged(path, 100.0)

    assert (
        store.sweep({wanted}, spare_s=50.0, memo_s=200.0) == 4
    )  # old with both encodings, and the unfinished
    assert store.get(wanted) == b"wanted"
    assert store.path(wanted, "gzip") is not None
    assert store.get(young) == b"young"
    assert store.path(old) is None
    assert not unfinished.exists()
    assert store.recall(KEY) == b"result"  # which makes it young
    assert store.sweep({wanted}, spare_s=50.0, memo_s=50.0) == 0
