//! Names that a user chose, with the characters that mean something in HTML, SVG, JSON, CSV, VTP and TOML, come out escaped.
#![cfg(unix)]

use std::fs;

use crate::common::{json, run, stderr};
use crate::{SMALL, done, done_json};

/// A name of a folder or file.
const HOSTILE: &str = "a<b x=\"1\">&amp;'\n]]>,-->*q*_{d}\\";

/// Asserts that a text is well-formed XML that has no element of the hostile name and shows it letter by letter.
fn check_xml(text: &str, name: &str) {
    let document = roxmltree::Document::parse(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    assert!(document.descendants().all(|node| !node.has_tag_name("b")), "an element of a name");
    let flat: String = document.descendants().filter_map(|node| node.text()).collect();
    let squeezed = |text: &str| text.split_whitespace().collect::<String>();
    assert!(squeezed(&flat).contains(&squeezed(name)), "{name:?} is not shown: {flat}");
}

#[test]
fn hostile_names_come_out_as_text() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let packing = format!("{HOSTILE}.csv");
    done(here, &["export", "sample", "-o", &packing]);
    done(here, &["shear", "case.toml", "--packing", &packing, "--out", HOSTILE]);
    let folder = here.join(HOSTILE);
    // The name of the packing is in the case and in the record.
    let record = json(&fs::read_to_string(folder.join("run.json")).unwrap());
    assert_eq!(record["packing"]["file_name"], packing);
    granum_io::Case::read(folder.join("case.toml")).unwrap();
    assert_eq!(done_json(here, &["status", HOSTILE])["folder"], HOSTILE);
    assert_eq!(done_json(here, &["digest", HOSTILE])["digests"][0]["folder"], HOSTILE);

    done(here, &["report", HOSTILE]);
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(!page.contains("<b x=") && page.contains("a&lt;b x="), "the page has an element of a name");
    let title = page.split("<title>").nth(1).unwrap().split("</title>").next().unwrap();
    assert!(title.contains("&lt;b") && title.contains("*q*_{d}\\"), "{title}");

    // A laboratory's test, and the run, in the legend of a figure.
    let test = "T<b>\"\"&amp;1";
    fs::write(
        here.join("lab.csv"),
        format!(
            "test,axial_strain (%),deviator_stress (kPa)\n\"{test}\",0,0\n\"{test}\",1,10\n\"{test}\",2,12\n"
        ),
    )
    .unwrap();
    done(here, &["compare", HOSTILE, "lab.csv", "-o", "compare.svg"]);
    let svg = fs::read_to_string(here.join("compare.svg")).unwrap();
    check_xml(&svg, HOSTILE);
    check_xml(&svg, "T<b>\"&amp;1");

    // A table of runs: the name is one cell, which is read back as it was.
    done(here, &["table", HOSTILE, "-o", "table.csv"]);
    let table = done_json(here, &["table", HOSTILE]);
    assert_eq!(table["runs"][0]["name"], HOSTILE, "{table}");
    let csv = fs::read_to_string(here.join("table.csv")).unwrap();
    assert!(csv.contains(&format!("\"{}\"", HOSTILE.replace('"', "\"\""))), "{csv}");

    done(here, &["export", HOSTILE, "-o", "grains.vtp"]);
    roxmltree::Document::parse(&fs::read_to_string(here.join("grains.vtp")).unwrap()).unwrap();
}

#[test]
fn hostile_names_of_stages_and_materials_are_refused_or_come_out_as_text() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let stages = SMALL.replace("[shear]\ndeviator_strain = 0.02\ninertial_number = 3e-3\n", "");
    for (what, text) in [
        (
            "stage",
            "[[stage]]\nname = '''NAME'''\npath = \"isotropic\"\nmean_stress = \"22 kPa\"\ninertial_number = 1e-2\n",
        ),
        (
            "material",
            "[[material]]\nname = '''NAME'''\nshare = 0.5\n[[material]]\nname = \"other\"\nshare = 0.5\n",
        ),
    ] {
        let name = "a<b x=\"1\">&amp;,c";
        let case = if what == "stage" { &stages } else { SMALL };
        fs::write(here.join("case.toml"), format!("{case}\n{}", text.replace("NAME", name))).unwrap();
        let output = run(here, &["run", "case.toml", "--out", what]);
        if !output.status.success() {
            let told = stderr(&output);
            assert!(told.contains("case.toml:") && told.contains("name"), "{what}: {told}");
            continue;
        }
        done(here, &["report", what]);
        let page = fs::read_to_string(here.join(what).join("report.html")).unwrap();
        assert!(!page.contains("<b x=") && page.contains("&lt;b x="), "{what}");
        for entry in fs::read_dir(here.join(what).join("figures")).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "svg") {
                roxmltree::Document::parse(&fs::read_to_string(&path).unwrap())
                    .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            }
        }
        done(here, &["export", what, "-o", "end.vtp"]);
        roxmltree::Document::parse(&fs::read_to_string(here.join("end.vtp")).unwrap()).unwrap();
        done(here, &["export", what, "-o", "end.xyz"]);
        assert_eq!(done_json(here, &["measure", "end.xyz"])["grains"], 150, "{what}");
        for file in ["end.vtp", "end.xyz"] {
            fs::remove_file(here.join(file)).unwrap();
        }
    }
}
