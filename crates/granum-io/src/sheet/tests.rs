//! Tables as the programs of laboratories and offices save them.

use super::{Sheet, Sought, split};
use crate::error::Result;

/// The numbers of the columns `a` and `b` of a text.
fn numbers(text: &str) -> Result<Vec<[f64; 2]>> {
    let is_name = |cell: &str| ["a", "b"].contains(&split(cell).0);
    let sheet =
        Sheet::read(text.as_bytes(), "t.csv", &Sought { is_name: &is_name, count: 2, may_have_units: true })?;
    let place = |name: &str| sheet.header().iter().position(|cell| split(cell).0 == name).unwrap();
    let columns = ["a", "b"].map(place);
    let mut rows = sheet.rows(&columns)?;
    let mut cells = Vec::new();
    while rows.advance()? {
        cells.push([rows.number(columns[0], "a")?, rows.number(columns[1], "b")?]);
    }
    Ok(cells)
}

#[test]
fn tables_of_many_programs_are_one_table() {
    for text in [
        "a,b\n0.5,1200\n2,-0.125\n",
        "a;b\n0,5;1200\n2;-0,125\n",
        "a;b\r\n0.5;1200\r\n2;-0.125\r\n",
        "a\tb\n0,5\t1200\n2\t-0,125\n",
        "a,b\r0.5,1200\r2,-0.125\r",
        "\"a\",\"b\"\n\"0,5\",\"1200\"\n\"2\",\"-0,125\"\n",
        "a;b;;\n0,5;1200;;\n;;;\n2;-0,125;;\n;;;\n",
        "a,b\n0.5,1200,,\n2,-0.125,,\n",
        "Versuch 12;\"Halle; Nord\"\nDatum;01.02.2024\n\na [%];b [kPa]\n0,5;1200\n2;-0,125\n",
        "a;b\n%;kPa\n0,5;1200\n2;-0,125\n",
        "a;b\n[%];[kPa]\n0,5;1200\na;b\n[%];[kPa]\n2;-0,125\n",
        "Sample: sand, dense\na,b\n(%),(kPa)\n0.5,1200\n\n  \n2,-0.125\n",
        ",a,b\n0,0.5,1200\n1,2,-0.125\n",
        "  # indented, \"comment\na ,b\n0.5, \"1200\" \n2,\u{2212}0.125\n",
        "# decimal = comma;\na;b\n0,5;1200\n2;-0,125\n",
        "a;c;b\n0,5;\"two\nlines; here\";1200\n2;n/a;-0,125\n",
        "\u{feff}a;\u{feff}b\n0,50;1,2E+03\n2,0;-0,125\n",
    ] {
        assert_eq!(numbers(text).unwrap(), [[0.5, 1200.0], [2.0, -0.125]], "{text:?}");
    }
    assert_eq!(numbers("# decimal = comma\na;b\n1,234;2,345\n").unwrap(), [[1.234, 2.345]]);
    assert_eq!(numbers("# decimal = point\na;b\n1.234;2.345\n").unwrap(), [[1.234, 2.345]]);
    assert_eq!(numbers("a,b\n1.234,2.345\n").unwrap(), [[1.234, 2.345]]);
}

#[test]
fn mistakes_have_their_place_and_say_what_would_be_right() {
    for (text, parts) in [
        ("a;b\n1,234;2\n", &["t.csv:2:1: a = \"1,234\" could be", "# decimal = comma"][..]),
        ("a;b\n1;1.234,5\n", &["t.csv:2:3: b = \"1.234,5\" has a thousands separator", "e.g. 1234,5"]),
        ("a;b\n0,5;1\n2;1.200\n", &[":3:3", "b = \"1.200\" has a point", "have a comma in their decimals"]),
        (
            "a;b\n0,5;1\n2;0.25\n",
            &[":2:1", "a = \"0,5\" has a comma in its decimals", "b = \"0.25\" has a point"],
        ),
        ("a;b\n0,5;1 200\n", &[":2:5", "thousands separator", "e.g. 1200"]),
        ("a;b\n0,5;n/a\n", &[":2:5: b = \"n/a\" is not a number", "left out"]),
        ("a;b\n0,5;\n", &[":2:5: the cell of column b is empty"]),
        ("a;b\n0,5;3;4\n", &[":2:1: the row has 3 cells, but the header names 2 columns"]),
        ("a,b\n0,5,1,2\n", &[":2:1", "has 4 cells", "decimal commas"]),
        ("a;b\n0,5;2 kPa\n", &[":2:5", "the unit belongs into the header, as b (kPa)"]),
        ("a;b;a\n1;2;3\n", &[":1:5: two columns have the name a"]),
        ("1;2\n", &[":1:1: 1 is not a column name"]),
        ("a;b\n1;\"2\n", &[":2:3: the quote is not closed"]),
        ("a;b\n\"1\"2;3\n", &[":2:4: a separator must follow the quoted text"]),
        ("# decimal = dot\na;b\n1;2\n", &[":1:1: decimal = dot", "point or comma"]),
        ("", &["t.csv: is empty"]),
        ("a;b\n\n\n\"x\ny\";2\n", &[":4:2", "is not a number"]),
    ] {
        let said = numbers(text).unwrap_err().to_string();
        assert!(parts.iter().all(|part| said.contains(part)), "{text:?}: {said}");
    }
}

#[test]
fn units_stand_in_the_header_or_below_it_and_agree() {
    let is_name = |cell: &str| ["a", "b"].contains(&split(cell).0);
    let open = |text: &str| {
        Sheet::read(text.as_bytes(), "t.csv", &Sought { is_name: &is_name, count: 2, may_have_units: true })
            .unwrap()
    };
    let sheet = open("a (%);c;b\n%;what it is;[kPa]\n1;2;3\n");
    assert_eq!(sheet.name_and_unit(0).unwrap(), ("a", "%"));
    assert_eq!(sheet.name_and_unit(2).unwrap(), ("b", "kPa"));
    let said = open("a (%);b\n-;kPa\n1;3\n").name_and_unit(0).unwrap_err().to_string();
    assert!(said.contains("the header has the unit % of a, and the row below it 1"), "{said}");
}
