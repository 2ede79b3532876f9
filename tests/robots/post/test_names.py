"""Names and numbers of any kind survive a text."""

import re
from dataclasses import replace
from decimal import Decimal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.post import coordinates_csv
from robots.post.compare import differences
from robots.post.content import HEAD_KEYS, KINDS, Content, Step
from robots.post.dialects import GRAMMARS
from robots.post.form import AXES, NO_NAME, TOKEN, Form, token
from robots.processes import StepCode

ANY = st.text(max_size=60) | st.from_regex(r"[A-Za-z0-9._=-]{0,30}", fullmatch=True)
FORMS = {name: grammar.form for name, grammar in GRAMMARS.items()} | {"csv": coordinates_csv.FORM}


@given(ANY)
def test_token_is_plain_short_and_final(name: str) -> None:
    kept = token(name)

    assert re.fullmatch(TOKEN, kept)
    assert len(kept) <= 22
    assert kept != NO_NAME


@given(ANY, ANY)
def test_two_names_stay_two(one: str, other: str) -> None:
    assert (token(one) == token(other)) == (one == other)


@given(ANY)
def test_what_another_name_becomes_is_not_kept_as_a_name(name: str) -> None:
    assert token(token(name)) != token(name) or token(name) == name


@pytest.mark.parametrize("name", ["SR.S2.001", "long_reach", "KR4.K4-05.005", "7"])
def test_usual_names_stay_as_they_are(name: str) -> None:
    assert token(name) == name


@given(st.sampled_from(sorted(FORMS)), st.floats(1e-9, 1e9) | st.floats(1e-3, 1e6))
def test_feed_is_never_quicker_than_the_block_and_as_quick_as_its_digits_allow(
    dialect: str, v: float
) -> None:
    form = FORMS[dialect]

    feed = form.feed(v)

    exact = Decimal(repr(v)) * 60
    assert 0 <= Decimal(repr(feed)) <= exact
    assert feed <= form.max_feed
    assert exact - Decimal(repr(feed)) < Decimal(1).scaleb(-form.feed_digits) or feed == form.max_feed
    assert float(form.feed_text(feed)) == feed


def contents(form: Form) -> st.SearchStrategy[Content]:
    """Whole texts with any names and values a program can have, at the digits of the dialect."""

    def rounded(axis: str) -> st.SearchStrategy[float]:
        return st.floats(-999_999.0, 999_999.0).map(lambda v: round(v, form.digits(axis)) + 0.0)

    tokens = ANY.map(token)
    axes = st.tuples(*(rounded(axis) for axis in AXES))
    feeds = st.floats(1.0, 100.0).map(form.feed)
    origins = tokens | st.tuples(tokens, tokens).map("/".join)

    @st.composite
    def content(draw: st.DrawFn) -> Content:
        dies = draw(st.lists(tokens, min_size=1, max_size=3, unique=True))
        processes = draw(st.lists(tokens, min_size=1, max_size=2, unique=True))
        waits = draw(st.lists(tokens, max_size=3, unique=True))
        events = [*map(str, StepCode), *(f"wait:{name}" for name in waits)]
        here = draw(axes)
        steps = []
        for i in range(draw(st.integers(1, 5))):
            moves = i > 0 and draw(st.booleans())
            here = draw(axes) if moves else here
            calls = [f"start:{draw(st.sampled_from(dies))}"] if i == 0 else []
            if not moves and draw(st.booleans()):
                calls += [
                    f"process:{draw(st.sampled_from(processes))}",
                    *draw(st.lists(st.sampled_from(events), max_size=6)),
                ]
            elif not moves and draw(st.booleans()):
                calls.append(f"change:{draw(st.sampled_from(dies))}")
            steps.append(
                Step(
                    n=draw(st.integers(1, 99_999_999)),
                    kind=draw(st.sampled_from(KINDS)),
                    axes=here,
                    feed=draw(feeds) if moves else None,
                    fastener=draw(tokens | st.just(NO_NAME)),
                    origin=draw(origins),
                    calls=tuple(calls),
                )
            )
        head = tuple(draw(tokens) for _ in HEAD_KEYS)
        return Content(head, tuple(dies), tuple(processes), tuple(steps), waits=tuple(waits))

    return content()


@pytest.mark.parametrize("dialect", sorted(FORMS))
@settings(max_examples=25)
@given(data=st.data())
def test_any_content_is_read_as_it_was_written(dialect: str, data: st.DataObject) -> None:
    content = data.draw(contents(FORMS[dialect]))
    post = coordinates_csv if dialect == "csv" else GRAMMARS[dialect]

    found = post.read(post.write(content).encode("ascii"))

    assert found == content
    assert differences(content, found) == ()


@settings(max_examples=25)
@given(contents(FORMS["csv"]), contents(FORMS["csv"]), st.data())
def test_nothing_differs_only_where_contents_are_equal(
    one: Content, another: Content, data: st.DataObject
) -> None:
    """Steps of one text are taken from another, dropped, doubled or moved."""
    pool = st.sampled_from((*one.steps, *another.steps))
    other = replace(one, steps=tuple(data.draw(st.just(one.steps) | st.lists(pool, max_size=5))))

    assert (differences(one, other) == ()) == (one == other)
