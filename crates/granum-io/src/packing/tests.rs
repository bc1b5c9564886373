use super::*;
use proptest::prelude::*;

const HEAD: &str = "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=10 yhi=10 zhi=10\nid,x,y,z,radius\n";

fn shipped() -> &'static str {
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/packing-5000.csv")
}

fn parse(body: &str) -> Result<Packing> {
    crate::formats::packing_csv::read_from(format!("{HEAD}{body}").as_bytes(), "p.csv")
}

fn message(body: &str) -> String {
    parse(body).unwrap_err().to_string()
}

#[test]
fn the_shipped_packing_is_what_its_readme_says() {
    let packing = crate::read_packing(shipped()).unwrap();
    assert_eq!(packing.grains.len(), 5000);
    assert!((packing.solid_fraction() - 0.6078).abs() < 5e-5, "{}", packing.solid_fraction());
    assert_eq!(packing.grains[0].position[0], 1.7791878558753196e-05);
    assert_eq!(packing.cell[0][0], 0.813_503_139_576_526_7e-3 * 2.0);
}

#[test]
fn what_is_written_reads_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.csv");
    let packing = crate::read_packing(shipped()).unwrap();
    crate::write_packing(&path, &packing).unwrap();
    assert_eq!(crate::read_packing(&path).unwrap(), packing);
    let grains = vec![PackedGrain { id: 1, position: [0.1, 0.2, 0.3], radius: 0.1 }];
    for cell in [
        [[1.0, 0.2, 0.1], [0.0, 1.0, -0.3], [0.0, 0.0, 1.0]],
        [[1.0, 0.2, 0.1], [0.1, 1.0, -0.3], [0.0, 0.05, 1.0 / 3.0]],
    ] {
        let packing = Packing::new([-0.1, 0.0, 0.1], cell, grains.clone());
        crate::write_packing(&path, &packing).unwrap();
        assert_eq!(crate::read_packing(&path).unwrap(), packing);
    }
}

/// Grains may stand in any order; their materials go with their ids.
#[test]
fn a_column_says_what_grains_are_made_of() {
    let text = "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=10 yhi=10 zhi=10\nid,x,y,z,material,radius\n\
                2,3,3,3,steel,0.5\n1,1,1,1,glass,0.5\n3,5,5,5,steel,0.5\n";
    let packing = crate::formats::packing_csv::read_from(text.as_bytes(), "p.csv").unwrap();
    let names: Vec<_> = (0..3).map(|k| packing.materials.name(k).unwrap()).collect();
    assert_eq!(names, ["glass", "steel", "steel"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.csv");
    crate::write_packing(&path, &packing).unwrap();
    assert_eq!(crate::read_packing(&path).unwrap(), packing);
    let bad = text.replace("glass", "a b");
    let said = crate::formats::packing_csv::read_from(bad.as_bytes(), "p.csv").unwrap_err().to_string();
    assert!(said.starts_with("p.csv:4:9: grain 1: material = \"a b\" is not a name"), "{said}");
}

#[test]
fn grains_that_are_wrong_are_named_with_their_line() {
    assert_eq!(message("1,1,1,1,0.5\n2,nan,3,3,0.5\n"), "p.csv:4:3: grain 2: x = nan must be finite");
    assert_eq!(message("1,1,1,1,-0.5\n"), "p.csv:3:9: grain 1: radius = -0.5 must be positive");
    assert_eq!(message("1,1,1,x,0.5\n"), "p.csv:3:7: z = \"x\" is not a number");
    assert_eq!(message("0,1,1,1,0.5\n"), "p.csv:3:1: id = \"0\" is not a whole number from 1");
    assert_eq!(
        message("1,1,10.5,1,0.5\n"),
        "p.csv:3:1: grain 1: (1e0, 1.05e1, 1e0) is outside the cell: 1.05 of edge b from its corner; \
         wrap it into the periodic cell"
    );
    assert_eq!(
        message("1,1,1,1,0.5\n3,5,5,5,0.5\n"),
        "p.csv:4:1: grain 2 is missing: after 1 comes 3; ids must be 1, 2, ... each once"
    );
    assert_eq!(
        message("1,1,1,1,0.5\n1,5,5,5,0.5\n"),
        "p.csv:4:1: grain 1 is already given in line 3; ids must be 1, 2, ... each once"
    );
    assert_eq!(message("1,1,1,1\n"), "p.csv:3:1: the row has 4 cells, but the header names 5 columns");
    assert!(message("1,1,1,1,6\n").contains("grain 1: radius = 6e0 m does not fit in the cell"));
    assert_eq!(message(""), "p.csv: is not a packing: it needs a cell and grains");
}

#[test]
fn gross_overlaps_are_refused_also_across_the_boundary_and_between_sizes() {
    assert_eq!(
        message("1,1,1,1,0.5\n2,1.9,1,1,0.5\n"),
        "p.csv:3:1: grain 1 overlaps grain 2 (line 4) by 1.000e-1 m, 10.0 % of the smaller diameter; \
         at most 5 % is accepted in a packing; are the radii right?"
    );
    assert!(parse("1,1,1,1,0.5\n2,1.96,1,1,0.5\n").is_ok());
    assert!(message("1,0.1,1,1,0.5\n2,9.5,1,1,0.5\n").contains("grain 1 overlaps grain 2"));
    assert!(message("1,5,5,5,3\n2,5,5,7,0.001\n").contains("grain 1 overlaps grain 2"));
    assert!(parse("1,5,5,5,3\n2,5,5,8.001,0.001\n").is_ok());
}

#[test]
fn a_cell_that_is_none_is_refused() {
    let cell_message = |text: &str| {
        crate::formats::packing_csv::read_from(
            format!("{text}\nid,x,y,z,radius\n1,1,1,1,1\n").as_bytes(),
            "p.csv",
        )
    };
    let message = |text: &str| cell_message(text).unwrap_err().to_string();
    assert!(
        message("# grains")
            .starts_with("p.csv:2:1: the periodic cell is not given; the first line must be like")
    );
    assert!(
        message("# periodic box, m: xlo=0").starts_with("p.csv:1:1: the value ylo of the cell is missing")
    );
    assert!(message("# periodic box, m: xlow=0").starts_with("p.csv:1:1: unknown value xlow of the cell"));
    assert!(message("# periodic box: xlo=a").starts_with("p.csv:1:1: xlo=a is not a finite number"));
    let flat = message("# periodic box: xlo=0 ylo=0 zlo=0 xhi=1 yhi=1 zhi=0");
    assert!(flat.starts_with("p.csv:1:1: the cell has the volume 0e0 m3; it must be positive"), "{flat}");
}

/// The overlap by a search over all pairs and 125 images.
fn brute_force(packing: &Packing) -> bool {
    let grains = &packing.grains;
    (0..grains.len()).any(|i| {
        (i + 1..grains.len()).any(|j| {
            (0..125).any(|n| {
                let image = [n % 5, n / 5 % 5, n / 25].map(|a| f64::from(a) - 2.0);
                let shift = apply(&packing.cell, image);
                let square: f64 =
                    (0..3).map(|a| (grains[j].position[a] + shift[a] - grains[i].position[a]).powi(2)).sum();
                let overlap = grains[i].radius + grains[j].radius - square.sqrt();
                overlap > GROSS_OVERLAP * 2.0 * grains[i].radius.min(grains[j].radius)
            })
        })
    })
}

proptest! {
    #[test]
    fn the_search_agrees_with_brute_force(
        tilt in proptest::array::uniform3(-0.4..0.4f64),
        grains in proptest::collection::vec((proptest::array::uniform3(0.0..1.0f64), 0.0..1.0f64), 1..12),
        smallest in 0.001..0.2f64,
    ) {
        let cell = [[1.0, tilt[0], tilt[1]], [0.0, 1.0, tilt[2]], [0.0, 0.0, 1.0]];
        let grains: Vec<PackedGrain> = grains.iter().enumerate().map(|(at, (place, size))| PackedGrain {
            id: at as u64 + 1,
            position: apply(&cell, *place),
            radius: 0.2 * smallest.powf(*size),
        }).collect();
        let packing = Packing::new([0.0; 3], cell, grains);
        let lined: Vec<_> = packing.grains.iter().map(|grain| (*grain, 0)).collect();
        prop_assert_eq!(overlap::check("p.csv", &cell, &lined, &[]).is_err(), brute_force(&packing));
    }

    #[test]
    fn any_text_gives_a_packing_or_a_message(text in "(# periodic (box|cell) ?([a-z]{2,3}=-?[0-9]e?[0-9]? ){0,9}|id,x,y,z,radius|[0-9.,e-]{1,20}|\n|\\PC){0,12}") {
        let _ = crate::formats::packing_csv::read_from(text.as_bytes(), "p.csv");
    }
}
