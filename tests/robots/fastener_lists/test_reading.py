"""Lists as tables: delimiters, decimal marks, headers, mappings, positions; problems have their rows."""

import numpy as np
import pytest

from robots.definition_file import duplicates
from robots.fastener_lists import table
from robots.fastener_lists.columns import HEADERS, field_of
from tests.robots.fastener_lists.samples import FLAT, HEADER, found, lines, problems, read

ROW = "A,10,20,0,0,0,1,4,solid_rivet"
ENTRY = {
    "id": "A",
    "p_mm": [10.0, 20.0, 0.0],
    "n": [0.0, 0.0, 1.0],
    "diameter_mm": 4.0,
    "grip_mm": "from_stack",
    "process": "solid_rivet",
}


def test_row_becomes_an_entry_of_the_panel_file() -> None:
    result = read(lines(ROW))

    assert result.entries == (ENTRY,)
    assert result.places == ("/rows/2",)
    assert result.columns["x"] == "x_mm"
    assert result.unit == "mm"


def test_optional_cells_are_taken_where_they_are() -> None:
    result = read(
        lines(
            "A,10,20,0,4,3.2,solid_rivet,J20,BJ",
            "B,50,20,0,4,from_stack,slug,,",
            header="id,x_mm,y_mm,z_mm,diameter_mm,grip_mm,process,die,code",
        )
    )

    assert result.entries[0] == {**ENTRY, "grip_mm": 3.2, "die": "J20", "code": "BJ"}
    assert result.entries[1].keys() == ENTRY.keys()


@pytest.mark.parametrize(("delimiter", "told"), [(",", "commas"), (";", "semicolons"), ("\t", "tabs")])
def test_delimiter_is_detected_and_told(delimiter: str, told: str) -> None:
    result = read(lines(ROW).replace(",", delimiter))

    assert result.entries == (ENTRY,)
    assert f"cells parted by {told}" in result.told


def test_delimiter_is_the_one_that_gives_the_columns() -> None:
    header = "id;x [mm];y [mm];z [mm];note, in words, and so on, and on, and on, and on;diameter (mm);process"

    assert read(lines("A;10;20;0;a,b;4;solid_rivet", header=header)).entries == (ENTRY,)


def test_header_that_could_be_parted_twice_is_refused() -> None:
    assert found(lines("A;1,B", header="id;who,id")) == [("/rows/1", "ambiguous_delimiter")]


@pytest.mark.parametrize("text", ["", "\n\n", "id\nA\n", "no header at all"])
def test_text_without_a_header_is_refused(text: str) -> None:
    assert found(text) == [("/rows/1", "no_header")]


def test_spreadsheets_text_is_read_as_it_comes() -> None:
    text = "\ufeffsep=;\r\n" + lines(ROW, "", "").replace(",", ";").replace("\n", "\r\n") + ";;;;;;;;\r\n"

    result = read(text)

    assert result.entries == (ENTRY,)
    assert result.places == ("/rows/3",)
    assert not any("blank" in each for each in result.told)


def test_blank_rows_between_others_count_and_are_told() -> None:
    result = read(lines(ROW, "", ",,,,,,,,", "B,60,20,0,0,0,1,4,solid_rivet"))

    assert result.places == ("/rows/2", "/rows/5")
    assert "2 blank row(s) left out: 3, 4" in result.told


def test_quoted_cells_may_have_delimiters_and_line_breaks() -> None:
    text = lines(
        '"A",10,20,0,0,0,1,4,solid_rivet,"one,\ntwo ""three"""',
        "B,x,20,0,0,0,1,4,solid_rivet,",
        header=HEADER + ",remark",
    )

    assert found(text) == [("/rows/3/x", "not_a_number")]


@pytest.mark.parametrize("text", ['A,"1', 'A,"1"2,3'])
def test_wrong_quotes_are_told_with_their_row(text: str) -> None:
    assert found(lines(ROW, text)) == [("/rows/3", "not_csv")]


def test_decimal_commas_are_read_where_the_delimiter_is_none() -> None:
    result = read(lines("A;10,5;-0,25;0;0;0;1;4;solid_rivet", header=HEADER.replace(",", ";")))

    assert result.entries[0]["p_mm"] == [10.5, -0.25, 0.0]
    assert "decimal commas" in result.told


@pytest.mark.parametrize(
    ("cells", "place"),
    [(["1,5", "2,5", "3.5"], "/rows/2/z"), (["1.5", "2,5", "3.5"], "/rows/2/y")],
)
def test_decimal_marks_are_never_mixed(cells: list[str], place: str) -> None:
    text = lines(";".join(["A", *cells, "0;0;1;4;solid_rivet"]), header=HEADER.replace(",", ";"))

    assert found(text) == [(place, "decimal_mark")]


def test_mark_of_ids_says_nothing_of_numbers() -> None:
    text = lines("1.5;10,5;20;0;0;0;1;4;solid_rivet", header=HEADER.replace(",", ";"))

    assert read(text).entries[0]["p_mm"] == [10.5, 20.0, 0.0]


def test_decimal_commas_between_commas_are_refused() -> None:
    bare, quoted = lines("A,10,5,20,0,0,0,1,4,solid_rivet"), lines('A,"10,5",20,0,0,0,1,4,solid_rivet')

    assert found(bare) == [("/rows/2", "wrong_length")]
    assert found(quoted) == [("/rows/2/x", "decimal_mark")]


@pytest.mark.parametrize(
    ("cell", "code"),
    [
        ("", "empty_cell"),
        ("nan", "not_finite"),
        ("-INF", "not_finite"),
        ("1e999", "not_finite"),
        ("12mm", "not_a_number"),
        ("1 000", "not_a_number"),
        ("1.000.5", "not_a_number"),
        ("1_000", "not_a_number"),
        ("\u0661", "not_a_number"),  # a digit, but none of ours
        ("#REF!", "not_a_number"),
        ("0x10", "not_a_number"),
        (".", "not_a_number"),
        ("1e5", "out_of_range"),
    ],
)
def test_cell_that_is_no_coordinate_is_refused(cell: str, code: str) -> None:
    assert found(lines(ROW.replace("20", cell))) == [("/rows/2/y", code)]


def test_every_problem_is_told_at_once_in_the_order_of_rows() -> None:
    text = lines(
        "A,10,20,0,0,0,1,4,solid_rivet",
        "A,x,20,0,0,0,1,,solid_rivet",
        "C d,50,20,0,0,0,1,4,welding",
        "D,10.05,20,0,0,0,1,4,solid_rivet",
        ",90,20,9,0,0,1,400,",
    )

    assert found(text) == [
        ("/rows/3/x", "not_a_number"),
        ("/rows/3/diameter", "empty_cell"),
        ("/rows/3/id", "duplicate_id"),
        ("/rows/4/id", "bad_name"),
        ("/rows/4/process", "unknown_process"),
        ("/rows/5", "duplicate_place"),
        ("/rows/6/id", "empty_cell"),
        ("/rows/6/process", "empty_cell"),
        ("/rows/6/diameter", "out_of_range"),
    ]


def test_problems_beyond_a_thousand_are_counted() -> None:
    rows = [f"F{i},x,20,0,0,0,1,4,solid_rivet" for i in range(1200)]

    *first, last = problems(lines(*rows))

    assert len(first) == table.MAX_PROBLEMS
    assert (first[-1].pointer, last.code, last.value) == ("/rows/1001/x", "more_problems", 200)


def test_row_of_another_length_is_refused() -> None:
    assert found(lines(ROW, "B,1,2", f"{ROW},,,", f"{ROW},,7")) == [
        ("/rows/3", "wrong_length"),
        ("/rows/5", "wrong_length"),
    ]


def test_known_headers_are_of_one_field_each() -> None:
    every = [("", header) for headers in HEADERS.values() for header in headers]

    assert duplicates(every, "header") == []
    assert all(field_of(header) == field for field, headers in HEADERS.items() for header in headers)


@pytest.mark.parametrize(
    "header", ["x_mm", "X [mm]", "x (mm)", " X mm ", "POS-X_mm", "Pos X [ mm ]", "px_mm"]
)
def test_headers_are_known_in_many_spellings(header: str) -> None:
    assert read(lines(ROW, header=HEADER.replace("x_mm", header, 1))).entries == (ENTRY,)


@pytest.mark.parametrize("names", ["i,j,k", "nx,ny,nz", "NX [-],NY [-],NZ [-]", "normal x,normal y,normal z"])
def test_normals_are_known_by_their_headers(names: str) -> None:
    assert read(lines(ROW, header=HEADER.replace("nx,ny,nz", names))).entries == (ENTRY,)


@pytest.mark.parametrize(
    ("header", "expected"),
    [
        (HEADER.replace("y_mm", "why"), [("/rows/1/y", "missing_column")]),
        (HEADER.replace("id", "number"), [("/rows/1/id", "missing_column")]),
        (HEADER.replace("nz", "remark"), [("/rows/1/nz", "missing_column")]),
        (HEADER.replace("y_mm", "y [furlong]"), [("/rows/1/y", "unknown_unit")]),
        (HEADER.replace("nx", "nx_mm"), [("/rows/1/nx", "unit_of_direction")]),
        (
            HEADER.replace("nx", "pos_x"),
            [("/rows/1/x", "ambiguous_column"), ("/rows/1/nx", "missing_column")],
        ),
        (HEADER.replace("nx", "ny"), [("/rows/1", "duplicate_column")]),
    ],
)
def test_header_that_is_not_understood_is_refused(header: str, expected: list[tuple[str, str]]) -> None:
    assert found(lines(ROW, header=header)) == expected


def test_columns_of_no_field_are_told() -> None:
    result = read(lines(f"{ROW},7,", header=f"{HEADER},Torque,"))

    assert "columns not used: Torque" in result.told


def test_mapping_names_columns_units_and_defaults() -> None:
    text = lines("7,10,20,0", header="No,POS_A,POS_B,POS_C")
    columns = {"id": "No", "x": "POS_A", "y": "POS_B", "z": "POS_C"}
    defaults = {"process": "slug", "diameter_mm": 4.8, "grip_mm": 3.0, "code": "BJ", "die": "J20"}

    (entry,) = read(text, columns=columns, unit="mm", defaults=defaults).entries

    assert entry == {**ENTRY, "id": "7", **defaults}


def test_mapping_is_before_what_headers_say() -> None:
    text = lines("A,10,20,0,99,0,0,1,4,solid_rivet", header=HEADER.replace("z_mm", "z_mm,x_old"))

    swapped = read(text, columns={"x": "y_mm", "y": "x_mm"})

    assert swapped.entries[0]["p_mm"] == [20.0, 10.0, 0.0]
    assert found(text, columns={"x": "nowhere"}) == [("/rows/1/x", "missing_column")]


def test_header_that_the_mapping_gives_away_is_no_other_field() -> None:
    text = lines("A,10,20,0,30,4,slug", header="id,x_mm,y_mm,z_mm,pos_x_mm,diameter_mm,process")

    given = read(text, columns={"x": "pos_x_mm"})

    assert given.entries[0]["p_mm"] == [30.0, 20.0, 0.0]
    assert "columns not used: x_mm" in given.told


def test_column_is_of_the_field_that_the_mapping_says() -> None:
    text = lines("A,0,20,30,4,slug", header="id,x_mm,y_mm,pos_x_mm,diameter_mm,process")

    assert read(text, columns={"z": "x_mm"}).entries[0]["p_mm"] == [30.0, 20.0, 0.0]


def test_columns_without_names_may_be_left_out_of_rows() -> None:
    assert read(lines(ROW, header=f"{HEADER},,")).entries == (ENTRY,)


def test_cell_is_before_a_default() -> None:
    header = "id,x_mm,y_mm,z_mm,diameter_mm,process"

    result = read(
        lines("A,10,20,0,,", "B,40,20,0,4,slug", header=header),
        defaults={"diameter_mm": 6, "process": "solid_rivet"},
    )

    assert [(e["diameter_mm"], e["process"]) for e in result.entries] == [(6.0, "solid_rivet"), (4.0, "slug")]


def test_what_every_fastener_needs_must_be_said() -> None:
    text = lines("A,10,20,0", header="id,x_mm,y_mm,z_mm")

    assert found(text) == [("/rows/1/diameter", "no_diameter"), ("/rows/1/process", "no_process")]
    assert found(text, defaults={"diameter_mm": 4, "process": "gluing"}) == [
        ("/rows/1/process", "unknown_process")
    ]


def test_empty_grip_is_not_guessed() -> None:
    header = "id,x_mm,y_mm,z_mm,diameter_mm,process,grip_mm"

    assert found(lines("A,10,20,0,4,slug,", header=header)) == [("/rows/2/grip", "empty_cell")]


BOTH = "id,x_mm,y_mm,z_mm,mx_mm,my_mm,mz_mm,diameter_mm,process"


def test_position_must_be_chosen_where_there_are_two() -> None:
    text = lines("A,10,20,0,10.2,20.1,0,4,slug", header=BOTH)

    assert found(text) == [("/rows/1", "position_not_chosen")]
    assert read(text, position="design").entries[0]["p_mm"] == [10.0, 20.0, 0.0]
    assert read(text, position="manufacturing").entries[0]["p_mm"] == [10.2, 20.1, 0.0]


def test_only_position_there_is_counts() -> None:
    text = lines("A,10,20,0,4,slug", header="id,mx_mm,my_mm,mz_mm,diameter_mm,process")

    assert read(text).entries[0]["p_mm"] == [10.0, 20.0, 0.0]
    assert found(text, position="design") == [("/rows/1", "missing_column")]


def test_positions_far_from_each_other_are_listed() -> None:
    text = lines("A,10,20,0,10.4,20.3,0,4,slug", "B,40,20,0,40.4,20.31,0,4,slug", header=BOTH)

    assert found(text, position="design") == [("/rows/3", "positions_apart")]
    assert len(read(text, position="design", most_apart_mm=2.0).entries) == 2


def test_names_of_files_tell_their_form() -> None:
    assert found("", name="list.xlsx") == [("", "unknown_format")]
    assert read(lines(ROW), name="LIST.TXT").entries == (ENTRY,)


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (HEADER.encode("utf-16"), "not_utf8"),
        (lines("\u00c4" + ROW).encode("latin-1"), "not_utf8"),
        (lines(ROW + "\0").encode(), "not_text"),
    ],
)
def test_text_that_is_not_utf8_is_refused(content: bytes, code: str) -> None:
    assert [each.code for each in problems(content)] == [code]


def test_header_alone_is_no_list() -> None:
    assert found(HEADER) == [("/rows/1", "no_fasteners")]


def test_normals_are_made_of_length_1_and_nothing_else() -> None:
    slanted = lines("A,10,20,0,0,0.0099,0.9999,4,solid_rivet")

    (entry,) = read(slanted).entries

    assert float(np.linalg.norm(entry["n"])) == pytest.approx(1.0, abs=1e-9)
    assert found(lines("A,10,20,0,0,0,0,4,solid_rivet")) == [("/rows/2/nx", "no_direction")]
    assert found(lines("A,10,20,0,0,0,90,4,solid_rivet")) == [("/rows/2/nx", "no_direction")]


def test_normals_are_needed_where_there_is_no_skin() -> None:
    text = lines("A,10,20,0,,,,4,slug", "B,50,20,0,0,0,1,4,slug", "C,90,20,0,0,,1,4,slug")
    bare = lines("A,10,20,0,4,slug", header="id,x_mm,y_mm,z_mm,diameter_mm,process")

    assert found(text, None) == [("/rows/2/nx", "no_normal"), ("/rows/4/ny", "empty_cell")]
    assert found(bare, None) == [("", "no_normal")]
    assert "not compared with a skin" in read(lines(ROW), None).told
    assert read(bare, FLAT).entries[0]["n"] == [0.0, 0.0, 1.0]
