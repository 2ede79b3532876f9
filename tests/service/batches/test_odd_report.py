"""The morning report on a telephone: whatever panels and reasons are called, nothing is too wide."""

import re

from service.batches.page import page
from service.batches.report import put_together
from tests.service.batches.made import batch, digest, planned


def narrow(style: str) -> str:
    """The rules for narrow screens."""
    return style.partition("@media (max-width")[2].partition("@media")[0]


def test_long_words_break_everywhere_and_in_every_cell_of_a_narrow_screen() -> None:
    panel = planned(1, digest("p" * 64, refused=[("F" * 60, "c" * 60)], title="t" * 120), "a" * 64)
    text = page(put_together(batch(title="n" * 120), [panel], None, (), ())).decode()
    style = text.partition("<style>")[2].partition("</style>")[0]
    assert re.search(r"\nbody \{[^}]*overflow-wrap: break-word", style)
    assert re.search(r"\n  td \{[^}]*overflow-wrap: anywhere", narrow(style))  # break-word widens a table
