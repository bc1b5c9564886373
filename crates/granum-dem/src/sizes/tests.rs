use rand_chacha::rand_core::SeedableRng;

use super::*;

/// Karlsruhe fine sand (Wichtmann and Triantafyllidis 2016): diameter in mm, per cent finer by weight.
const KARLSRUHE: [[f64; 2]; 7] = [
    [0.0631, 1.53],
    [0.0795, 4.83],
    [0.1002, 11.96],
    [0.1249, 28.24],
    [0.1581, 84.99],
    [0.2441, 99.75],
    [0.3135, 100.0],
];

fn karlsruhe() -> Sizes {
    Sizes::new(SizeKind::SIEVE_CURVE)
        .with_curve(KARLSRUHE.map(|[d, finer]| [1e-3 * d, 1e-2 * finer]).to_vec())
}

fn grains(count: usize, sizes: Sizes) -> Grains {
    Grains { count, diameter: 1e-3, sizes, ..Grains::default() }
}

fn drawn(grains: &Grains) -> Vec<f64> {
    grains.diameters(&mut ChaCha8Rng::seed_from_u64(3)).unwrap()
}

fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0), |(sum, count), x| (sum + x, count + 1));
    sum / f64::from(count)
}

/// Share of the mass of grains below a diameter.
fn finer(diameters: &[f64], diameter: f64) -> f64 {
    let mass = |all: &mut dyn Iterator<Item = &f64>| all.map(|d| d.powi(3)).sum::<f64>();
    mass(&mut diameters.iter().filter(|d| **d < diameter)) / mass(&mut diameters.iter())
}

fn every_kind() -> Vec<Sizes> {
    let cut = |kind| Sizes::new(kind).between(4e-4, 3e-3);
    let mut all: Vec<Sizes> =
        [SizeKind::NORMAL, SizeKind::LOGNORMAL, SizeKind::WEIBULL, SizeKind::FRACTAL].map(cut).to_vec();
    all.extend([Sizes::new(SizeKind::TWO_SIZES), Sizes::new(SizeKind::EQUAL), karlsruhe()]);
    all
}

#[test]
fn quantiles_are_the_inverse_of_shares() {
    for sizes in every_kind() {
        let grains = grains(1000, sizes);
        grains.check_sizes().unwrap();
        let distribution = grains.sizes.distribution.distribution();
        let smooth = ![SizeKind::EQUAL, SizeKind::TWO_SIZES].contains(&grains.sizes.distribution);
        for share in [0.001, 0.1, 0.5, 0.77, 0.999] {
            let diameter = distribution.quantile(&grains, share);
            if smooth {
                let back = distribution.share_below(&grains, diameter);
                assert!((back - share).abs() < 1e-12, "{} {share}: {back}", grains.sizes.distribution.name());
            } else {
                assert!(distribution.share_below(&grains, diameter) <= share);
            }
        }
    }
}

#[test]
fn the_mean_and_the_deviation_are_those_asked_for() {
    for kind in [SizeKind::NORMAL, SizeKind::LOGNORMAL] {
        let grains = grains(20_000, Sizes::new(kind).with("size_deviation", 0.15));
        let diameters = drawn(&grains);
        let average = mean(diameters.iter().copied());
        let square = mean(diameters.iter().map(|d| (d - average).powi(2)));
        assert!((average / 1e-3 - 1.0).abs() < 1e-4, "{kind:?} {average}");
        assert!((square.sqrt() / 1.5e-4 - 1.0).abs() < 2e-3, "{kind:?} {}", square.sqrt());
        assert!((grains.mean_diameter().unwrap() / average - 1.0).abs() < 1e-4);
    }
    let weibull = grains(20_000, Sizes::new(SizeKind::WEIBULL).with("size_modulus", 4.0));
    assert!((mean(drawn(&weibull)) / 1e-3 - 1.0).abs() < 1e-4);
    // Gamma(1 + 1/4) = 0.906402477055477; the median is the scale times (ln 2)^(1/4).
    let median = weibull.sizes.distribution.distribution().quantile(&weibull, 0.5);
    assert!((median / (1e-3 / 0.906402477055477 * 2f64.ln().powf(0.25)) - 1.0).abs() < 1e-12);
    let two =
        grains(50_000, Sizes::new(SizeKind::TWO_SIZES).with("size_ratio", 3.0).with("fine_share", 0.25));
    let diameters = drawn(&two);
    assert!((mean(diameters.iter().copied()) / 1e-3 - 1.0).abs() < 1e-4);
    let limit = diameters[0] * 1.5;
    assert!((finer(&diameters, limit) - 0.25).abs() < 1e-3);
}

/// Three times the fractal dimension of one: the mass is uniform in the logarithm, and so is a two-point sieve curve.
#[test]
fn a_fractal_of_dimension_three_is_a_straight_sieve_curve() {
    let fractal =
        grains(5000, Sizes::new(SizeKind::FRACTAL).with("fractal_dimension", 3.0).between(1e-4, 1e-3));
    let curve = grains(5000, Sizes::new(SizeKind::SIEVE_CURVE).with_curve(vec![[1e-4, 0.0], [1e-3, 1.0]]));
    for (a, b) in drawn(&fractal).iter().zip(drawn(&curve)) {
        assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    }
}

/// Shares and errors that were computed independently of this program.
#[test]
fn a_sieve_curve_is_met_by_mass() {
    let shares = [0.17376660, 0.18763435, 0.21715822, 0.38293426, 0.03828488, 0.00022170];
    let sand = grains(1000, karlsruhe());
    let curve = sand.sizes.distribution.distribution();
    for (k, share) in shares.iter().enumerate() {
        let below = |point: usize| curve.share_below(&sand, 1e-3 * KARLSRUHE[point][0]);
        assert!((below(k + 1) - below(k) - share).abs() < 1e-7, "{k}");
    }
    assert!((sand.mass_left_out().unwrap() - 0.0153).abs() < 1e-12);
    for (count, error) in [(1000, 0.0026), (5000, 0.0004), (20_000, 0.0003)] {
        let diameters = drawn(&grains(count, karlsruhe()));
        let cube = mean(diameters.iter().map(|d| (1e3 * d).powi(3))).cbrt();
        assert!((cube / 0.1217766844 - 1.0).abs() < 3e-3, "{cube}");
        let largest = KARLSRUHE.iter().map(|[d, percent]| {
            let wanted = (0.01 * percent - 0.0153) / (1.0 - 0.0153);
            (finer(&diameters, 1e-3 * d * (1.0 + 1e-12)) - wanted).abs()
        });
        let largest = largest.fold(0.0, f64::max);
        assert!(largest < error, "{count}: {largest}");
    }
}

#[test]
fn cuts_leave_out_what_lies_beyond_and_keep_the_rest() {
    let uncut = grains(20_000, Sizes::new(SizeKind::LOGNORMAL).with("size_deviation", 0.4));
    let cut = grains(20_000, Sizes::new(SizeKind::LOGNORMAL).with("size_deviation", 0.4).between(6e-4, 2e-3));
    let (all, kept) = (drawn(&uncut), drawn(&cut));
    assert!(kept.iter().all(|d| (6e-4..=2e-3).contains(d)));
    let within: Vec<f64> = all.into_iter().filter(|d| (6e-4..=2e-3).contains(d)).collect();
    assert!((mean(within.iter().copied()) / mean(kept.iter().copied()) - 1.0).abs() < 1e-3);
    // The curve by mass between the cuts keeps its shape.
    let sand = Grains { sizes: karlsruhe().between(0.09e-3, 0.2e-3), ..grains(20_000, karlsruhe()) };
    let diameters = drawn(&sand);
    let ratio = (0.8499 - 0.2824) / (finer(&diameters, 0.1581e-3) - finer(&diameters, 0.1249e-3));
    assert!((1.0 - sand.mass_left_out().unwrap() - ratio).abs() < 2e-3, "{ratio}");
}

#[test]
fn sizes_do_not_depend_on_the_seed_except_where_they_are_drawn() {
    for sizes in every_kind() {
        let grains = grains(100, sizes);
        let other = grains.diameters(&mut ChaCha8Rng::seed_from_u64(4)).unwrap();
        assert_eq!(drawn(&grains), other);
    }
    let uniform = Grains { spread: 0.2, ..grains(100, Sizes::default()) };
    assert_ne!(drawn(&uniform), uniform.diameters(&mut ChaCha8Rng::seed_from_u64(4)).unwrap());
}

#[test]
fn impossible_sizes_are_refused_with_the_key() {
    let of = |sizes: Sizes| grains(1000, sizes).check_sizes().unwrap_err();
    let curve = |points: &[[f64; 2]]| of(Sizes::new(SizeKind::SIEVE_CURVE).with_curve(points.to_vec()));
    for (error, key, part) in [
        (of(Sizes::new(SizeKind::NORMAL).with("size_deviation", 0.5)), "distribution", "diameters of zero"),
        (of(Sizes::new(SizeKind::WEIBULL).with("size_modulus", 1.0)), "distribution", "a ratio of 50"),
        (of(Sizes::new(SizeKind::WEIBULL).with("size_deviation", 0.1)), "size_deviation", "means nothing"),
        (of(Sizes::new(SizeKind::TWO_SIZES).with("size_ratio", 0.5)), "size_ratio", "from 1 to 50"),
        (of(Sizes::new(SizeKind::TWO_SIZES).between(1e-4, 1e-3)), "smallest", "means nothing"),
        (of(Sizes::new(SizeKind::FRACTAL)), "distribution", "needs grains.smallest"),
        (of(Sizes::new(SizeKind::LOGNORMAL).between(2e-3, 1e-3)), "smallest", "must be below"),
        (of(Sizes::new(SizeKind::NORMAL).between(3e-3, 4e-3)), "smallest", "leaves no grains"),
        (of(Sizes::new(SizeKind::SIEVE_CURVE)), "distribution", "needs grains.sieve_curve"),
        (curve(&[[1e-4, 0.0]]), "sieve_curve", "at least two points"),
        (curve(&[[1e-4, 0.0], [2e-4, 0.9]]), "sieve_curve", "100 %"),
        (curve(&[[2e-4, 0.0], [1e-4, 1.0]]), "sieve_curve", "point 2 does not rise"),
        (curve(&[[1e-4, 0.0], [2e-4, 30.0]]), "sieve_curve", "3000 % finer"),
        (of(Sizes::default().with_curve(vec![[1e-4, 0.0], [2e-4, 1.0]])), "sieve_curve", "sieve-curve"),
    ] {
        assert!(error.key == key && error.message.contains(part), "{error}");
    }
    let spread = Grains { spread: 0.1, ..grains(100, Sizes::new(SizeKind::EQUAL)) };
    assert!(spread.check_sizes().unwrap_err().to_string().starts_with("grains.spread = 0.1 means nothing"));
}
