"""How the numbers of a program's text are rounded and written: the formats that fields are annotated with."""

from dataclasses import dataclass
from decimal import ROUND_FLOOR, Context, Decimal

MAX_NUMBER = 1e15
"""Beyond it a float no longer holds the digits that the formats state."""
_FEW_DIGITS = 1e10  # below it the digits that the formats state are fewer than the 15 every float holds
_PLAIN = 1e-4  # from here to MAX_NUMBER `repr` writes no exponent


@dataclass(frozen=True)
class Decimals:
    """Fixed number of decimals, rounded half to even on the exact binary value."""

    digits: int

    def text(self, value: float) -> str:
        text = f"{value:.{self.digits}f}"
        return text[1:] if text[0] == "-" and float(text) == 0.0 else text

    def rounded(self, value: float) -> float:
        """The float that `text` reads back as."""
        return round(float(value), self.digits) + 0.0  # plus zero: there is no negative one


@dataclass(frozen=True)
class DecimalsDown:
    """Fixed number of decimals, rounded down."""

    digits: int

    def text(self, value: float) -> str:
        # The shortest decimal that reads back as `value` is what is rounded: writing twice changes nothing.
        if abs(value) < _FEW_DIGITS and round(float(value), self.digits) == value:
            return Decimals(self.digits).text(value)
        rounded = Decimal(repr(float(value))).quantize(Decimal(1).scaleb(-self.digits), rounding=ROUND_FLOOR)
        return f"{abs(rounded) if rounded == 0 else rounded:f}"

    def rounded(self, value: float) -> float:
        """The float that `text` reads back as."""
        nearest = round(float(value), self.digits) + 0.0
        return nearest if abs(value) < _FEW_DIGITS and nearest == value else float(self.text(value))


@dataclass(frozen=True)
class SignificantDown:
    """A number of significant digits, rounded down."""

    digits: int

    def text(self, value: float) -> str:
        text = repr(float(value))
        if _PLAIN <= value < MAX_NUMBER:
            whole, _, decimals = text.partition(".")
            excess = len(f"{whole}{decimals}".lstrip("0")) - self.digits
            if excess <= len(decimals):
                return text[:-excess].removesuffix(".") if excess > 0 else text
        rounded = Context(prec=self.digits, rounding=ROUND_FLOOR).plus(Decimal(text))
        return f"{abs(rounded) if rounded == 0 else rounded:f}"

    def rounded(self, value: float) -> float:
        """The float that `text` reads back as."""
        return float(self.text(value))
