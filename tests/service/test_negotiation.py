"""Which form a client gets, beside an oracle made of the words of RFC 9110 (12.4.2, 12.5, 13.1.2)."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.requests import Request

from service.jobs.model import Encoding
from service.negotiation import encodings, is_known, preferred, weight

OFFERS = ("application/json", "application/x-ndjson", "text/csv", "text/x-apt", "model/gltf-binary")
RANGES = (*OFFERS, "application/*", "text/*", "model/*", "image/*", "*/*", "text/html", "application/pdf")
CODINGS: tuple[Encoding, ...] = ("zstd", "gzip", "identity")
LISTED = (*CODINGS, "*", "br", "deflate")
THOUSANDTHS = st.sampled_from([0, 1, 100, 500, 999, 1000])
"""Few weights, so that many are equal."""
PARAMETERS = st.sampled_from(["", ";charset=utf-8", '; x="a, */*;q=0"', ';x="\\", text/csv"', ";q2=0"])
Wanted = Mapping[str, int]


def asked(**headers: str | Sequence[str]) -> Request:
    """A request with headers; several of one name where a list is given."""
    found = [
        (name.replace("_", "-").encode(), line.encode("latin-1"))
        for name, lines in headers.items()
        for line in ([lines] if isinstance(lines, str) else lines)
    ]
    return Request({"type": "http", "method": "GET", "path": "/", "headers": found})


@st.composite
def written(draw: st.DrawFn, wanted: Wanted, parameters: st.SearchStrategy[str]) -> list[str]:
    """The lines of a header that say this: in any order, case and spacing, on one line or several."""
    members = []
    for name in draw(st.permutations(sorted(wanted))):
        shown = draw(st.sampled_from([name, name.upper(), name.title()])) + draw(parameters)
        q = f"{wanted[name] / 1000:.3f}"
        digits = draw(st.sampled_from([q, q.rstrip("0"), q.rstrip("0").rstrip(".")]))
        weighed = draw(st.sampled_from([f";q={digits}", f" ; Q={digits}", f"\t;q={digits} "]))
        members.append(shown + ("" if wanted[name] == 1000 and draw(st.booleans()) else weighed))
    lines: list[str] = []
    line = ""
    for member in members:
        if line and draw(st.booleans()):
            lines, line = [*lines, line], ""
        line += (draw(st.sampled_from([",", ", ", " ,, "])) if line else "") + member
    return [*lines, line]


def weight_by_the_words(wanted: Wanted, offer: str) -> int:
    """12.5.1: "the most specific reference has precedence"; 12.4.2: 0 is "not acceptable"."""
    for reference in (offer, offer[: offer.index("/")] + "/*", "*/*"):
        if reference in wanted:
            return wanted[reference]
    return 0


def acceptable_by_the_words(wanted: Wanted, coding: str) -> bool:
    """12.5.3, its list of rules; `*` matches what is not listed explicitly."""
    if coding in wanted:
        return wanted[coding] > 0
    if coding == "identity":
        return wanted.get("*") != 0
    return wanted.get("*", 0) > 0


@given(st.data(), st.dictionaries(st.sampled_from(RANGES), THOUSANDTHS, min_size=1))
def test_the_media_type_is_the_one_the_words_say(data: st.DataObject, wanted: Wanted) -> None:
    offers = data.draw(st.permutations(OFFERS))
    request = asked(accept=data.draw(written(wanted, PARAMETERS)))

    for offer in offers:
        assert weight(request, offer) == weight_by_the_words(wanted, offer) / 1000
    best = max(weight_by_the_words(wanted, offer) for offer in offers)
    equals = [offer for offer in offers if weight_by_the_words(wanted, offer) == best]
    assert preferred(request, offers) == (equals[0] if best else None)


@given(st.data(), st.dictionaries(st.sampled_from(LISTED), THOUSANDTHS))
def test_the_encodings_are_those_the_words_say_best_first(data: st.DataObject, wanted: Wanted) -> None:
    found = encodings(asked(accept_encoding=data.draw(written(wanted, st.just("")))))

    assert set(found) == {coding for coding in CODINGS if acceptable_by_the_words(wanted, coding)}
    assert len(found) == len(set(found))
    weights = [wanted.get(coding, wanted.get("*", 0)) for coding in found]
    if "identity" not in wanted and "identity" in found:
        assert found[-1] == "identity"  # nobody asked for it
        weights.pop()
    assert weights == sorted(weights, reverse=True)
    for one, other in pairwise(found):
        if wanted.get(one, wanted.get("*")) == wanted.get(other, wanted.get("*")):
            assert CODINGS.index(one) < CODINGS.index(other)


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        ([], ["identity"]),
        ([""], ["identity"]),
        (["gzip, deflate, br, zstd"], ["zstd", "gzip", "identity"]),
        (["gzip;q=1.0, zstd;q=0.5"], ["gzip", "zstd", "identity"]),
        (["gzip", "identity;q=0"], ["gzip"]),
        (["x-gzip, identity;q=0"], ["gzip"]),  # 8.4.1.3: equivalent to gzip
        (["*"], ["zstd", "gzip", "identity"]),
        (["*;q=0"], []),
        (["identity;q=0"], []),
        (["identity;q=0, *"], ["zstd", "gzip"]),
        (["*;q=0, identity"], ["identity"]),
        (["*;q=0, gzip"], ["gzip"]),
        (["identity, gzip;q=0.5"], ["identity", "gzip"]),
        (["gzip;q=0"], ["identity"]),
        (["gzip;q=2, zstd;q=nan, *;q=x"], []),  # a weight that is none wants nothing
    ],
)
def test_encodings_that_clients_ask_for(lines: list[str], found: list[str]) -> None:
    assert encodings(asked(accept_encoding=lines)) == found


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        ([], "application/json"),
        ([""], "application/json"),  # nothing is said
        ([" , "], "application/json"),
        (["text/csv, */*;q=0.1"], "text/csv"),
        (["text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8"], "application/json"),
        (["text/*"], "text/csv"),
        (["text/*, text/csv;q=0"], "text/x-apt"),
        (["*/*", "application/*;q=0"], "text/csv"),
        (["text/html"], None),
        (["application/json;q=0"], None),
        (["*/*;q=0"], None),
        (["*"], None),  # no media range
        (["json"], None),
        (["text/"], None),
        (["text/csv;q=high"], None),  # a weight that is none wants nothing
        (["text/csv;q=inf, text/x-apt;q=-0.5"], None),
        (["text/csv;q=1.001, text/x-apt;q=0.001"], "text/x-apt"),
        (['image/png;x="a, text/csv", text/x-apt'], "text/x-apt"),
        (['text/csv;x="never ended, text/x-apt'], "text/csv"),
    ],
)
def test_media_types_that_clients_ask_for(lines: list[str], found: str | None) -> None:
    assert preferred(asked(accept=lines), OFFERS) == found


@given(
    st.text(st.characters(max_codepoint=255)),
    st.lists(st.sampled_from(['"', "\\", ",", ";q=", "*/*", "a/b"])),
)
def test_whatever_is_sent_is_answered(text: str, more: list[str]) -> None:
    header = text + "".join(more)
    assert preferred(asked(accept=header), OFFERS) in (*OFFERS, None)
    assert set(encodings(asked(accept_encoding=header))) <= set(CODINGS)
    assert is_known(asked(if_none_match=header), '"abc"') in (True, False)


@given(st.data(), st.dictionaries(st.sampled_from(RANGES), THOUSANDTHS, min_size=1))
def test_what_is_no_range_changes_nothing(data: st.DataObject, wanted: Wanted) -> None:
    lines = data.draw(written(wanted, st.just("")))
    junk = st.sampled_from(["", "text", "/", "*/csv", "text/**", ";q=1", "q=1", "text/csv2", "=", "\xe4/*"])
    more = data.draw(st.lists(junk))
    assert preferred(asked(accept=[*more, *lines, *more]), OFFERS) == preferred(asked(accept=lines), OFFERS)


@pytest.mark.parametrize(
    ("lines", "known"),
    [
        ([], False),
        ([""], False),
        (['"abc"'], True),
        (['W/"abc"'], True),  # compared weakly
        (["*"], True),
        (['"x", "abc"'], True),
        (['"x"', 'W/"y" ,"abc"'], True),
        (["abc"], False),  # no entity tag
        (['"abcd"'], False),
        (['"ABC"'], False),
        (['"*"'], False),
        (['w/"abc"'], False),
    ],
)
def test_what_a_client_has_is_known(lines: list[str], known: bool) -> None:
    assert is_known(asked(if_none_match=lines), '"abc"') is known


@given(st.lists(st.text("abc*/W-", min_size=0, max_size=4), max_size=4), st.text("abc-", max_size=3))
def test_a_tag_is_known_where_it_is_listed(tags: list[str], own: str) -> None:
    listed: Any = [f'"{tag}"' for tag in tags]
    assert is_known(asked(if_none_match=", ".join(listed)), f'"{own}"') == (own in tags)
