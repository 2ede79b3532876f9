"""The house: sizes of files, names that exist, layers that are listed, locks that can be trusted."""

import importlib
import pkgutil
import re
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import planners
import robots
import service

ROOT = Path(__file__).parents[1]
PACKAGES = ("planners", "robots", "service", "tests", "openapi")
LONGEST = 400  # lines; a longer file is usually two ideas

SOURCES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))


def modules() -> list[ModuleType]:
    found: list[ModuleType] = []
    for package in (planners, robots, service):
        names = [each.name for each in pkgutil.walk_packages(package.__path__, package.__name__ + ".")]
        found += [package, *map(importlib.import_module, names)]
    return found


def pyproject() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())


def test_no_python_file_is_too_long() -> None:
    lengths = {str(path.relative_to(ROOT)): len(path.read_text().splitlines()) for path in SOURCES}

    assert {name: lines for name, lines in lengths.items() if lines > LONGEST} == {}
    assert "service/app.py" in lengths  # the search found the sources


def test_exported_names_exist_and_are_sorted() -> None:
    exporting = [module for module in modules() if hasattr(module, "__all__")]

    for module in exporting:
        assert [name for name in module.__all__ if not hasattr(module, name)] == [], module.__name__
        assert list(module.__all__) == sorted(set(module.__all__)), module.__name__


def test_every_module_of_the_verifier_is_kept_apart_from_the_planners_geometry() -> None:
    contracts = pyproject()["tool"]["importlinter"]["contracts"]
    (contract,) = [each for each in contracts if "verifier" in each["name"]]
    modules_of_it = {f"robots.{path.stem}" for path in (ROOT / "robots").glob("verify*.py")} | {
        "robots.proof"
    }

    assert modules_of_it <= set(contract["source_modules"])
    geometry = {"coal", "pinocchio", "robots.cell", "robots.chain", "robots.kernel"}
    assert geometry <= set(contract["forbidden_modules"])


@pytest.mark.parametrize("name", ["requirements.lock", "requirements-dev.lock", "requirements-bench.lock"])
def test_lock_files_pin_with_hashes_and_name_no_address(name: str) -> None:
    text = (ROOT / name).read_text()
    requirements = re.findall(
        r"^([a-z0-9][^\s=]*)==(\S+)[^\\]*\\\n((?:    --hash=sha256:[0-9a-f]{64}.*\n?)+)", text, re.M
    )

    names = [line.split("==")[0] for line in text.splitlines() if re.match(r"[a-z0-9]", line)]
    assert [each[0] for each in requirements] == names
    assert re.search(r"https?:|file:|--index-url|--find-links", text) is None


@pytest.mark.parametrize("larger", ["requirements-dev.lock", "requirements-bench.lock"])
def test_runtime_lock_is_part_of_the_others(larger: str) -> None:
    def pins(name: str) -> set[str]:
        return set(re.findall(r"^[a-z0-9][^\s;]*==[^\s;]+", (ROOT / name).read_text(), re.M))

    assert pins("requirements.lock") < pins(larger)


def test_version_of_the_distribution_is_in_the_changelog() -> None:
    assert f"## [{service.__version__}]" in (ROOT / "CHANGELOG.md").read_text()
