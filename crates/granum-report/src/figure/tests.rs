//! Properties of all figures, for arbitrary data.

use super::rose::Series;
use super::*;
use granum_core::assembly::{Assembly, Contact, Sphere};
use proptest::prelude::*;

/// Arbitrary numbers, including those that are not finite.
fn any_value() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -10.0..10.0f64,
        1 => Just(0.0),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(f64::NEG_INFINITY),
        1 => Just(1e300),
        1 => Just(-1e300),
        1 => Just(1e-300),
        1 => Just(f64::MAX),
    ]
}

fn plot_of(data: &[[f64; 3]], log: bool) -> Plot {
    let pairs = || data.iter().map(|d| [d[0], d[1]]).collect::<Vec<_>>();
    let axis = |label: &str| if log { Axis::new(label).logarithmic() } else { Axis::new(label) };
    Plot::new(axis("*x*_{<}"), axis("y & \"z\""))
        .with(Layer::band(data.to_vec(), "#000").named("a <b>"))
        .with(Layer::line(pairs(), "#111").named("a <b>"))
        .with(Layer::points(pairs(), Shape::Diamond, "#222").named("'c'"))
        .with(Layer::horizontal(data.first().map_or(0.0, |d| d[2]), "#333"))
        .with(Layer::vertical(data.first().map_or(0.0, |d| d[0]), "#333"))
        .note(Note::new("n < m", data.first().map_or([0.0, 0.0], |d| [d[0], d[1]])))
}

fn figure_of(data: &[[f64; 3]]) -> Figure {
    let rose = Rose {
        series: vec![Series {
            label: "r".into(),
            values: data.iter().map(|d| d[0]).collect(),
            color: "#00f".into(),
        }],
        reference: Some(1.0),
        ..Default::default()
    };
    let panels = vec![
        Panel::plot(plot_of(data, false)),
        Panel::plot(plot_of(data, true)).titled("a & b"),
        Panel::rose(rose),
        Panel::chains(ForceChains::new(&assembly_of(data), chains::View::strong())),
    ];
    Figure::new("hostile <data> & \"quotes\"", 2, panels)
}

fn assembly_of(data: &[[f64; 3]]) -> Assembly {
    let grains = data.iter().map(|d| Sphere { position: *d, radius: d[0], ..Default::default() });
    let contacts =
        data.iter().map(|d| Contact { i: 0, j: 1, branch: *d, normal_force: d[1], ..Default::default() });
    let cell = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, data.first().map_or(1.0, |d| d[2])]];
    Assembly { cell, contacts: contacts.collect(), ..Default::default() }.with_spheres(grains)
}

/// Checks that a figure is well-formed, contains no invalid numbers and refers to no other file.
fn check(figure: &Figure) {
    let svg = figure.to_svg();
    let document = roxmltree::Document::parse(&svg).unwrap_or_else(|error| panic!("{error}\n{svg}"));
    assert!(!document.root_element().attribute("width").unwrap().is_empty());
    for node in document.descendants() {
        for attribute in node.attributes() {
            if !matches!(attribute.name(), "aria-label" | "font-family") {
                let value = attribute.value();
                assert!(!value.contains("NaN") && !value.contains("inf"), "{} = {value}", attribute.name());
            }
            assert!(!matches!(attribute.name(), "href" | "src" | "id" | "style"), "{}", attribute.name());
        }
    }
    assert_eq!(svg, figure.to_svg(), "the same figure is the same bytes");
    assert!(!figure.to_inline_svg().contains("http"));
}

#[test]
fn figures_without_data_say_so() {
    let figure = figure_of(&[]);
    check(&figure);
    assert!(figure.to_svg().contains("nothing to show"));
    check(&Figure::new("no panels", 0, Vec::new()));
}

#[test]
fn constant_data_are_drawn_inside_the_frame() {
    for value in [0.0, 1.0, -3.5, 1e-12, 1e12] {
        let data: Vec<[f64; 3]> = (0..5).map(|k| [k as f64, value, value]).collect();
        check(&figure_of(&data));
        let figure = Figure::new("c", 1, vec![Panel::plot(plot_of(&data, false))]);
        assert!(figure.to_svg().contains("stroke=\"#111\""), "the line of {value} is there");
    }
}

#[test]
fn labels_are_escaped_and_described() {
    let svg = figure_of(&[[1.0, 2.0, 3.0], [2.0, 3.0, 4.0]]).to_svg();
    assert!(svg.contains("a &lt;b&gt;") && svg.contains("hostile &lt;data&gt; &amp; &quot;quotes&quot;"));
    assert!(!svg.contains("<b>"));
}

#[test]
fn a_legend_gets_room_above_the_data_or_goes_above_the_frame() {
    let full: Vec<[f64; 2]> = (0..4000).map(|k| [(k % 63) as f64, (k / 63) as f64]).collect();
    let crowded = |name: &str| {
        Plot::new(Axis::new("x"), Axis::new("y"))
            .with(Layer::points(full.clone(), Shape::Circle, "#000").named(name))
    };
    let shift = |plot: Plot| {
        let svg = Figure::new("f", 1, vec![Panel::plot(plot)]).to_svg();
        let at = svg.find("translate(0 ").unwrap() + 12;
        svg[at..].split(')').next().unwrap().parse::<f64>().unwrap()
    };
    assert!(shift(crowded(&"too long for the frame ".repeat(6))) > 10.0);
    assert_eq!(shift(crowded("short")), 0.0);
    let frame = clip::Rect::new(60.0, 10.0, 460.0, 220.0);
    let entries = legend::entries(crowded("short").layers.iter());
    assert_eq!(crowded("short").legend_place(&frame, &entries), None);
    let roomy = Plot { headroom: 0.3, ..crowded("short") };
    assert!(roomy.legend_place(&frame, &entries).is_some_and(|place| place[1] < 60.0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn no_data_can_break_a_figure(data in prop::collection::vec(prop::array::uniform3(any_value()), 0..12)) {
        check(&figure_of(&data));
    }
}

/// Stresses of a few pascals beside others of kilopascals have the unit of those, on linear and on logarithmic axes.
#[test]
fn axes_of_one_unit_have_one_prefix() {
    let plot = |y: f64, log: bool| {
        let x = Axis::new("Stress").unit("Pa");
        let x = if log { x.logarithmic() } else { x };
        Plot::new(x, Axis::new("Other").unit("Pa"))
            .with(Layer::line(vec![[2.0, 0.0], [20.0 * y, y], [30.0 * y, 0.5 * y]], "#000"))
    };
    for panels in [[plot(3e3, false), plot(2.0, false)], [plot(3e3, false), plot(5e3, true)]] {
        let svg = Figure::new("f", 2, panels.map(Panel::plot).to_vec()).to_svg();
        assert!(svg.contains("(kPa)") && !svg.contains("(Pa)"), "{svg}");
    }
    // A single axis keeps the unit that suits it.
    let svg = Figure::new("f", 1, vec![Panel::plot(plot(2.0, false))]).to_svg();
    assert!(svg.contains("(Pa)") && !svg.contains("(kPa)"));
}

#[test]
fn a_single_plot_has_larger_type() {
    let figure =
        |count: usize| Figure::new("f", 2, vec![Panel::plot(plot_of(&[[0.0; 3], [1.0; 3]], false)); count]);
    assert!(figure(1).to_svg().contains("width=\"480\" height=\"270\" viewBox=\"0 0 384 216\""));
    assert!(figure(2).to_svg().contains("width=\"720\" height=\"270\" viewBox=\"0 0 720 270\""));
}

#[test]
fn a_heading_stands_above_everything_and_is_broken_where_lines_are_full() {
    let plot =
        || Plot::new(Axis::new("x"), Axis::new("y")).with(Layer::line(vec![[0.0, 0.0], [1.0, 1.0]], "#000"));
    let plain = Figure::new("a figure", 2, vec![Panel::plot(plot()), Panel::plot(plot())]);
    let parts: Vec<String> = (0..12).map(|k| format!("input number {k} = 0.{k}")).collect();
    let headed = plain.clone().headed(&parts).to_svg();
    assert!(parts.iter().all(|part| headed.contains(part.as_str())), "{headed}");
    let height = |svg: &str| -> f64 {
        svg.split("height=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap().parse().unwrap()
    };
    assert!(height(&headed) > height(&plain.to_svg()) + 2.0 * HEADING_ROW, "more than one line");
}
