"""Errors of the planners: wrong requests only. "No path" is an answer (see `PlanStatus`), not an error.

    PlannerError
      WrongShape      an array does not have the shape the request needs
      NotFinite       an array holds NaN or infinity
      InvalidSetting  a setting breaks its rule
      LimitExceeded   a given path limit is faster than the axes allow
      Collinear       points that must span a plane lie on one line

Each passes its arguments on to `Exception.__init__`, so that it survives pickling between processes.
"""


class PlannerError(Exception):
    """Root of the planners' errors."""


class WrongShape(PlannerError):
    """The array `name` has shape `actual`, not `expected` (both as text)."""

    def __init__(self, name: str, expected: str, actual: str) -> None:
        super().__init__(name, expected, actual)
        self.name = name
        self.expected = expected
        self.actual = actual

    def __str__(self) -> str:
        return f"{self.name} must have shape {self.expected}, not {self.actual}"


class NotFinite(PlannerError):
    """The array `name` holds NaN or infinity."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name

    def __str__(self) -> str:
        return f"{self.name} must hold finite numbers only"


class InvalidSetting(PlannerError):
    """The setting `field` has `value`, which breaks `rule`."""

    def __init__(self, field: str, value: object, rule: str) -> None:
        super().__init__(field, value, rule)
        self.field = field
        self.value = value
        self.rule = rule

    def __str__(self) -> str:
        return f"{self.field} must be {self.rule}, not {self.value!r}"


class LimitExceeded(PlannerError):
    """The path limit `name` is `value`, more than its axes allow: `allowed`, both in [1/s^k]."""

    def __init__(self, name: str, value: float, allowed: float) -> None:
        super().__init__(name, value, allowed)
        self.name = name
        self.value = value
        self.allowed = allowed

    def __str__(self) -> str:
        return f"path limit {self.name} = {self.value!r} is more than the {self.allowed!r} its axes allow"


class Collinear(PlannerError):
    """The points `name` lie on one line or coincide, so they span no plane."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name

    def __str__(self) -> str:
        return f"{self.name} must not lie on one line"
