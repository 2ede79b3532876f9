"""Keys: what is kept, what is shown, what a change does; the command line that changes them."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner, Result

from service.cli import app
from service.security import keys
from service.security.caller import Caller
from service.security.keys import KeyRefused, KeyRing, KeyTable, parse_keys, written_keys
from service.security.scopes import Scope
from service.security.watched import UnusableFile, read_guarded
from tests.service.security.guarded import NOW, key_file

READ = [Scope.READ]
printable = st.text(st.characters(min_codepoint=33, max_codepoint=255), max_size=90)


def command(tmp_path: Path, *arguments: str) -> Result:
    return CliRunner().invoke(app, ["keys", *arguments, "--data", str(tmp_path / "data")])


def test_a_key_is_kept_as_a_hash_only() -> None:
    table, key = KeyTable().added("mes", READ, NOW)

    secret = key.split("_")[2]
    assert secret not in written_keys(table).decode()
    assert parse_keys(written_keys(table)) == table


def test_keys_are_different_and_each_has_256_random_bits() -> None:
    made = {KeyTable().added("mes", READ, NOW)[1] for _ in range(100)}

    assert len({key.split("_")[1] for key in made}) == 100
    assert {len(key.split("_")[2]) * 5 // 8 for key in made} == {32}


def test_two_keys_are_valid_while_a_client_changes_over(tmp_path: Path) -> None:
    file = key_file(tmp_path)
    ring = KeyRing(file.path)
    old = file.add("mes", Scope.PLAN)
    new = file.rotate("mes")

    assert old != new
    mes = Caller("key:mes", frozenset({Scope.PLAN}))
    assert [ring.caller(key) for key in (old, new)] == [mes, mes]

    file.remove("mes", old.split("_")[1])
    assert ring.caller(old) is None
    assert ring.caller(new) == mes


def test_third_key_of_a_client_is_refused_with_the_one_to_end() -> None:
    table, first = KeyTable().added("mes", READ, NOW)
    table, _ = table.rotated("mes", NOW)

    with pytest.raises(KeyRefused, match=f"remove mes --id {first.split('_')[1]}"):
        table.rotated("mes", NOW)


def test_removing_a_client_ends_all_of_its_keys_and_no_other() -> None:
    table, _ = KeyTable().added("mes", READ, NOW)
    table, _ = table.rotated("mes", NOW)
    table, _ = table.added("office", READ, NOW)

    assert [key.name for key in table.removed("mes", None).keys] == ["office"]


@pytest.mark.parametrize("name", ["", "a b", "-x", "a\n", "ä", "a/b", "x" * 65])
def test_names_that_would_be_awkward_in_a_log_are_refused(name: str) -> None:
    with pytest.raises(KeyRefused):
        KeyTable().added(name, READ, NOW)


def test_only_the_whole_key_is_its_owner(tmp_path: Path) -> None:
    file = key_file(tmp_path)
    key = file.add("mes", Scope.READ)
    ring = KeyRing(file.path)

    assert ring.caller(key) is not None
    for place in range(len(key)):
        other = "b" if key[place] == "a" else "a"
        assert ring.caller(key[:place] + other + key[place + 1 :]) is None
        assert ring.caller(key[:place]) is None
    for wrong in (key.upper(), f" {key}", f"{key}\n", f"{key}a", key + key):
        assert ring.caller(wrong) is None


@given(credential=printable | st.text())
def test_no_other_text_is_a_key(tmp_path_factory: pytest.TempPathFactory, credential: str) -> None:
    file = key_file(tmp_path_factory.getbasetemp() / "fuzzed")
    if not file.path.exists():
        file.path.parent.mkdir()
        file.add("mes", Scope.READ)

    assert KeyRing(file.path).caller(credential) is None


def test_whatever_is_wrong_with_a_key_the_same_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = key_file(tmp_path)
    key = file.add("mes", Scope.READ)
    ring = KeyRing(file.path)
    ring.caller(key)  # the file is read
    done: list[str] = []
    for name in ("_sha256", "compare_digest"):
        monkeypatch.setattr(keys, name, _noted(done, name, getattr(keys, name)))

    steps = []
    wrong_secret = key[:-52] + "a" * 52
    for credential in (key, wrong_secret, f"rvp_{'0' * 12}_{'a' * 52}", "nonsense", ""):
        done.clear()
        ring.caller(credential)
        steps.append(tuple(done))

    assert set(steps) == {("_sha256(str)", "compare_digest(32, 32)")}


def _noted(done: list[str], name: str, function: object) -> object:
    def noting(*arguments: str | bytes) -> object:
        sizes = [str(len(each)) if isinstance(each, bytes) else "str" for each in arguments]
        done.append(f"{name}({', '.join(sizes)})")
        return function(*arguments)  # type: ignore[operator]

    return noting


@pytest.mark.parametrize(
    ("content", "why"),
    [
        ("{", "no file of rivetplan's keys"),
        ('{"format": "rivetplan-keys/2", "keys": []}', "format"),
        ('{"keys": [{"name": "mes"}]}', "keys/0/id"),
        ('{"keys": [], "more": 1}', "more"),
    ],
)
def test_file_that_is_not_understood_lets_nobody_in(tmp_path: Path, content: str, why: str) -> None:
    file = key_file(tmp_path)
    key = file.add("mes", Scope.READ)
    ring = KeyRing(file.path)
    assert ring.caller(key) is not None

    file.path.write_text(content)

    for _ in range(2):
        with pytest.raises(UnusableFile, match=why):
            ring.caller(key)


def test_same_id_twice_is_not_understood() -> None:
    table, _ = KeyTable().added("mes", READ, NOW)

    with pytest.raises(ValueError, match="same id"):
        parse_keys(written_keys(KeyTable(table.keys * 2)))


def test_file_that_others_may_write_is_not_believed(tmp_path: Path) -> None:
    file = key_file(tmp_path)
    file.add("mes", Scope.READ)
    file.path.chmod(0o620)

    with pytest.raises(UnusableFile, match="chmod go-w"):
        read_guarded(file.path, parse_keys)


def test_key_is_printed_once_and_alone(tmp_path: Path) -> None:
    made = command(tmp_path, "add", "mes", "--scope", "read", "--scope", "plan")

    key = made.stdout.strip()
    ring = KeyRing(tmp_path / "data" / "keys.json")
    caller = ring.caller(key)
    assert made.stdout == f"{key}\n"
    assert caller is not None
    assert caller.scopes == {Scope.READ, Scope.PLAN}
    listed = command(tmp_path, "list").stdout
    assert key not in listed
    assert key.split("_")[1] in listed
    assert "plan,read" in listed


def test_only_its_owner_reads_the_file(tmp_path: Path) -> None:
    command(tmp_path, "add", "mes", "--scope", "read")
    command(tmp_path, "rotate", "mes")

    file = tmp_path / "data" / "keys.json"
    assert file.stat().st_mode & 0o777 == 0o600
    assert len(json.loads(file.read_bytes())["keys"]) == 2


def test_refusals_of_the_command_are_one_line(tmp_path: Path) -> None:
    for arguments in (["remove", "nobody"], ["rotate", "nobody"], ["add", "a b", "--scope", "read"]):
        refused = command(tmp_path, *arguments)
        assert (refused.exit_code, refused.stdout) == (2, "")
        assert len(refused.stderr.splitlines()) == 1
