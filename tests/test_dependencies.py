"""What rivetplan stands on: installed as locked, unchanged, licences we may use, no known holes."""

import base64
import hashlib
import json
import re
from importlib.metadata import Distribution, distributions
from pathlib import Path

import pytest

from tests.advisories import FILE, ROOT, affecting, locked

INSTALLED = {re.sub(r"[-_.]+", "-", each.metadata["Name"]).lower(): each for each in distributions()}
RUNTIME = set(re.findall(r"^([a-z0-9][^\s=\[]*)[^\s=]*==", (ROOT / "requirements.lock").read_text(), re.M))

#: Words of licences that ask for no more than to be named. A dependency is used, never changed or copied.
PERMISSIVE = re.compile(
    r"\b(0BSD|Apache|BSD|BSL-1\.0|ISC|MIT|PSF|Python Software Foundation|Zlib)\b", re.IGNORECASE
)
#: Others, looked at one by one.
LOOKED_AT = {
    "cmeel-qhull": "Qhull: free to use, its notice stays with it",
    "psycopg": "LGPL-3.0: imported as it is, replaceable",
    "psycopg-binary": "LGPL-3.0: imported as it is, replaceable",
}


def licence(distribution: Distribution) -> str:
    """Return what a distribution says of its licence: an expression, else classifiers, else words."""
    said = distribution.metadata
    listed = [each for each in said.get_all("Classifier") or [] if each.startswith("License ::")]
    expression, words = ((said.get_all(name) or [""])[0] for name in ("License-Expression", "License"))
    return expression or "; ".join(listed) or words[:100]


@pytest.mark.long
def test_what_is_installed_is_what_is_locked() -> None:
    versions = {name: each.version for name, each in INSTALLED.items()}

    assert {name: versions[name] for name in RUNTIME} == {
        name: versions[name] for name in RUNTIME if versions[name] in locked()[name]
    }


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(RUNTIME))
def test_no_installed_file_was_changed(name: str) -> None:
    changed = []
    for file in INSTALLED[name].files or []:
        if file.hash is not None:
            digest = hashlib.new(file.hash.mode, Path(str(file.locate())).read_bytes()).digest()
            if base64.urlsafe_b64encode(digest).decode().rstrip("=") != file.hash.value:
                changed.append(str(file))

    assert INSTALLED[name].files
    assert changed == []


@pytest.mark.long
def test_licences_may_be_used() -> None:
    others = {
        name: licence(INSTALLED[name]) for name in RUNTIME if not PERMISSIVE.search(licence(INSTALLED[name]))
    }

    assert set(others) == set(LOOKED_AT)


@pytest.mark.long
def test_no_locked_version_has_a_known_hole() -> None:
    advisories = json.loads(FILE.read_text())["advisories"]
    found = {
        f"{name} {version}": affecting(name, version, advisories)
        for name, versions in locked().items()
        for version in versions
    }

    assert {name: ids for name, ids in found.items() if ids} == {}


def test_known_holes_are_found() -> None:
    advisories = json.loads(FILE.read_text())["advisories"]

    assert "PYSEC-2022-202" in affecting("pyjwt", "2.3.0", advisories)
    assert "CVE-2024-53861" in affecting("pyjwt", "2.10.0", advisories)
    assert "CVE-2024-53861" not in affecting("pyjwt", "2.10.1", advisories)
    assert "PYSEC-2021-47" in affecting("pydantic", "1.7.3", advisories)
    assert "PYSEC-2021-47" not in affecting("pydantic", "1.7.4", advisories)
