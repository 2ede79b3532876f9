"""Lists that mean harm, or are damaged: refused with a reason, in bounded time."""

import contextlib
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.errors import InvalidInput
from robots.fastener_lists import table
from robots.fastener_lists.reading import read_fasteners
from tests.robots.fastener_lists.samples import FLAT, HEADER, found, lines, read

ROW = '<fastener id="A" x="0" y="0" z="0" nx="0" ny="0" nz="1" diameter="4" process="slug"/>'
GOOD = f'<fasteners version="1.0" unit="mm">{ROW}</fasteners>'


def laughs() -> str:
    entities = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 10))
    return f'<!DOCTYPE lolz [<!ENTITY l0 "lol">{entities}]>{GOOD.replace("A", "&l9;")}'


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (laughs(), "forbidden_xml"),
        (
            f'<!DOCTYPE f [<!ENTITY e SYSTEM "file:///etc/hostname">]>{GOOD.replace("A", "&e;")}',
            "forbidden_xml",
        ),
        (f'<!DOCTYPE f SYSTEM "http://localhost/f.dtd">{GOOD}', "forbidden_xml"),
        (f"<!DOCTYPE fasteners>{GOOD}", "forbidden_xml"),
        (f'<!DOCTYPE f [<!ENTITY % p SYSTEM "p.dtd"> %p;]>{GOOD}', "forbidden_xml"),
        ("<a>" * 200_000, "unknown_element"),
        (f"<fasteners>{'<fastener>' * 100_000}", "unknown_element"),
        (GOOD.replace("<fasteners", '<fasteners xmlns="urn:x"'), "unknown_element"),
        (GOOD.replace("/></f", ">text</fastener></f"), "unknown_text"),
        (
            GOOD.replace(
                "<fastener ", '<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="a"/><fastener ', 1
            ),
            "unknown_element",
        ),
        (GOOD[:-5], "not_xml"),
        (GOOD + "<more/>", "not_xml"),
        (GOOD.replace('id="A"', 'id="A" id="B"'), "not_xml"),
        ("", "not_xml"),
        ('<?xml version="1.0" encoding="klingon"?>' + GOOD, "not_utf8"),
        (GOOD.replace("A", "&undefined;"), "not_xml"),
    ],
)
def test_xml_that_is_more_than_a_list_is_refused(text: str, code: str) -> None:
    began = time.monotonic()

    assert [each[1] for each in found(text, name="list.xml")][:1] == [code]
    assert time.monotonic() - began < 5.0  # not a measurement: expanded entities would take minutes


@pytest.mark.parametrize("content", [GOOD.encode("utf-16"), GOOD.encode("utf-32"), b"\0" + GOOD.encode()])
def test_xml_in_other_encodings_is_refused(content: bytes) -> None:
    assert found(content, name="list.xml") == [("", "not_utf8")]


def test_xml_problems_have_xpaths() -> None:
    text = (
        '<fasteners version="2" unit="feet" scale="3">'
        f'{ROW}<fastener id="A" x="0" y="20" z="0,5" colour="red" diameter="4" process="slug"/></fasteners>'
    )

    assert found(text, name="list.xml") == [
        ("/fasteners/@scale", "unknown_field"),
        ("/fasteners/@version", "unknown_version"),
        ("/fasteners/@unit", "unknown_unit"),
        ("/fasteners/fastener[2]/@colour", "unknown_field"),
    ]
    sound = text.replace('version="2" unit="feet" scale="3"', 'version="1.0" unit="mm"').replace(
        'colour="red"', ""
    )
    assert found(sound, name="list.xml") == [
        ("/fasteners/fastener[2]/@z", "decimal_mark"),
        ("/fasteners/fastener[2]/@id", "duplicate_id"),
    ]


def test_xml_without_a_unit_is_refused() -> None:
    text = GOOD.replace(' unit="mm"', "")

    assert found(text, name="list.xml", unit="mm") == [("/fasteners/@unit", "missing_unit")]


def test_too_many_rows_and_bytes_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    row = "{},1,2,3,0,0,1,4,slug"
    text = lines(*(row.format(i) for i in range(table.MAX_ROWS + 1)))

    assert found(text) == [("", "too_many_rows")]
    assert found(HEADER + "\n" * (2 * table.MAX_ROWS + 1)) == [("", "too_many_rows")]
    assert found(GOOD.replace(ROW, ROW * (table.MAX_ROWS + 1)), name="l.xml") == [("", "too_many_rows")]
    assert found("[" + "{}," * table.MAX_ROWS + "{}]", name="l.json") == [("", "too_many_rows")]
    assert found(b" " * (table.MAX_BYTES + 1)) == [("", "file_too_large")]


def test_too_many_columns_are_refused() -> None:
    header = HEADER + "".join(f",c{i}" for i in range(table.MAX_COLUMNS))

    assert found(lines(header=header)) == [("/rows/1", "too_many_columns")]
    assert found("[{" + ",".join(f'"c{i}": 1' for i in range(300)) + "}]", name="l.json") == [
        ("/0", "too_many_columns")
    ]


def test_cell_of_a_megabyte_is_refused() -> None:
    assert found(lines("A" * 1_000_000 + ",0,0,0,0,0,1,4,slug")) == [("/rows/2", "not_csv")]


def test_fasteners_all_in_one_place_are_refused_at_once() -> None:
    rows = [f"F{i},{i * 1e-5:.6f},0,0,0,0,1,4,slug" for i in range(20_000)]

    assert ("", "too_crowded") in found(lines(*rows))


@settings(max_examples=150, deadline=None)
@given(data=st.data())
@pytest.mark.parametrize("form", [".csv", ".xml", ".json"])
def test_damaged_lists_are_read_or_refused(form: str, data: st.DataObject) -> None:
    good = {
        ".csv": lines("A,0,0,0,0,0,1,4,slug", "B;20,0,0,0,0,1,4,slug").encode(),
        ".xml": GOOD.encode(),
        ".json": b'[{"id": "A", "p_mm": [0, 0, 0], "n": [0, 0, 1], "diameter_mm": 4, "process": "slug"}]',
    }[form]
    at = data.draw(st.integers(0, len(good)))
    cut = data.draw(st.integers(0, 20))
    content = good[:at] + data.draw(st.binary(max_size=12)) + good[at + cut :]

    with contextlib.suppress(InvalidInput):  # nothing else is raised
        assert read_fasteners(content, f"list{form}", None, FLAT).entries


def test_good_list_is_read() -> None:
    assert read(GOOD, name="list.xml").entries[0]["id"] == "A"
