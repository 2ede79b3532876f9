"""Known vulnerabilities of the packages that are locked.

Plants and this project's continuous integration are offline, and pip-audit asks a server. So the advisories
are a file, made from a clone of github.com/pypa/advisory-database (CC BY 4.0):

    python -m tests.advisories CLONE DATE

It knows nothing younger than its date; with a network, `pip-audit -r requirements.lock` does.
"""

import json
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped]
from packaging.specifiers import SpecifierSet

ROOT = Path(__file__).parents[1]
FILE = Path(__file__).with_suffix(".json")
#: Younger than the clone at hand; added by hand, each as public threads of its fix tell it.
LATER = [
    {"id": "CVE-2024-12797", "package": "cryptography", "affected": [">=42.0.0,<44.0.1"]},
    {"id": "CVE-2024-47874", "package": "starlette", "affected": ["<0.40.0"]},
    {"id": "CVE-2024-53861", "package": "pyjwt", "affected": ["==2.10.0"]},
    {"id": "CVE-2025-43859", "package": "h11", "affected": ["<0.16.0"]},
    {"id": "CVE-2025-47273", "package": "setuptools", "affected": ["<78.1.1"]},
    {"id": "CVE-2025-54121", "package": "starlette", "affected": ["<0.47.2"]},
    {"id": "CVE-2025-62727", "package": "starlette", "affected": [">=0.39.0,<0.49.1"]},
    {"id": "CVE-2026-32597", "package": "pyjwt", "affected": ["<2.12.0"]},
    {"id": "CVE-2026-48526", "package": "pyjwt", "affected": ["<2.13.0"]},
    {"id": "CVE-2026-54282", "package": "starlette", "affected": ["<1.3.1"]},
    {"id": "CVE-2026-54283", "package": "starlette", "affected": ["<1.3.1"]},
    {"id": "GHSA-537c-gmf6-5ccf", "package": "cryptography", "affected": [">=0.5.0,<48.0.1"]},
]
LOCKS = ("requirements.lock", "requirements-dev.lock", "requirements-bench.lock")


def locked() -> dict[str, set[str]]:
    """Return the locked versions of every package."""
    found: dict[str, set[str]] = {}
    for name in LOCKS:
        for package, version in re.findall(r"^([a-z0-9][^\s=]*)==([^\s;]+)", (ROOT / name).read_text(), re.M):
            found.setdefault(package.partition("[")[0], set()).add(version)
    return found


def affecting(package: str, version: str, advisories: list[dict[str, Any]]) -> list[str]:
    """Return the ids of the advisories that a version of a package is affected by."""
    return [
        each["id"]
        for each in advisories
        if each["package"] == package
        and any(SpecifierSet(affected).contains(version, prereleases=True) for affected in each["affected"])
    ]


def read_database(clone: Path, packages: set[str]) -> Iterator[dict[str, Any]]:
    """Yield the advisories of packages; one that was withdrawn is none."""
    for file in sorted(clone.glob("vulns/*/*.yaml")):
        if re.sub(r"[-_.]+", "-", file.parent.name).lower() not in packages:
            continue
        advisory = yaml.safe_load(file.read_text())
        if "withdrawn" not in advisory:
            yield from map(_entry(advisory["id"]), advisory["affected"])


def _entry(its_id: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
    def entry(affected: dict[str, Any]) -> dict[str, Any]:
        name = re.sub(r"[-_.]+", "-", affected["package"]["name"]).lower()
        ranges = [each["events"] for each in affected.get("ranges", ()) if each["type"] == "ECOSYSTEM"]
        named = [f"=={version}" for version in affected.get("versions", ())]
        return {"id": its_id, "package": name, "affected": _intervals(ranges) if ranges else named}

    return entry


def _intervals(ranges: list[list[dict[str, str]]]) -> list[str]:
    """Return the versions from each `introduced` to what ends it."""
    signs = {"introduced": ">=", "fixed": "<", "last_affected": "<="}
    found: list[list[str]] = []
    for kind, version in (item for events in ranges for event in events for item in event.items()):
        if kind == "introduced":
            found.append([])
        found[-1].append(f"{signs[kind]}{version}")
    return [",".join(each) for each in found]


def main(clone: Path, date: str) -> None:
    """Write the file anew."""
    entries = [*read_database(clone, set(locked())), *LATER]
    document = {"source": "github.com/pypa/advisory-database, CC BY 4.0", "date": date, "advisories": entries}
    FILE.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
