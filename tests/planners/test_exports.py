from types import ModuleType

import planners


def test_every_public_name_is_exported_and_exists() -> None:
    public = {
        name
        for name, value in vars(planners).items()
        if not name.startswith("_") and not isinstance(value, ModuleType)
    }

    assert public == set(planners.__all__)
    assert planners.__all__ == sorted(planners.__all__)
