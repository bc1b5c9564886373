use super::*;

fn near(found: f64, golden: f64, tolerance: f64) {
    assert!((found - golden).abs() <= tolerance * golden.abs().max(1e-3), "{found} {golden}");
}

/// Volumes, surfaces, inertia and sphericity of the union of equal spheres of diameter 1.
#[test]
fn the_moments_of_known_shapes_are_met() {
    let row = |xs: &[f64]| -> Vec<(Vector, f64)> { xs.iter().map(|x| ([*x, 0.0, 0.0], 0.5)).collect() };
    let q = 0.25;
    let tetrapod = vec![([q, q, q], 0.5), ([q, -q, -q], 0.5), ([-q, q, -q], 0.5), ([-q, -q, q], 0.5)];
    let cases = [
        (row(&[0.0]), std::f64::consts::PI / 6.0, std::f64::consts::PI, [0.1; 3], 1.0),
        (row(&[-0.25, 0.25]), 0.8835729338221, 4.712388980385, [0.10625, 0.184375, 0.184375], 0.9449407874),
        (
            row(&[0.0, 1.0]),
            std::f64::consts::FRAC_PI_3,
            std::f64::consts::TAU,
            [0.1, 0.35, 0.35],
            0.7937005260,
        ),
        (
            row(&[-0.5, 0.0, 0.5]),
            1.243547092046,
            std::f64::consts::TAU,
            [0.108881578947, 0.308717105263, 0.308717105263],
            0.8900459199,
        ),
        (tetrapod, 1.7752003059736, 8.235120734032, [0.251204377166; 3], 0.8609522457),
    ];
    for (spheres, volume, surface, inertia, sphericity) in cases {
        let found = ShapeOfSpheres::new(&spheres).unwrap();
        near(found.shape.volume, volume, 2e-12);
        near(found.surface, surface, 2e-12);
        for k in 0..3 {
            near(found.shape.inertia_over_mass[k], inertia[k], 1e-11);
        }
        near(found.sphericity(), sphericity, 1e-9);
    }
}

/// Four unlike spheres.
pub(crate) const ASYMMETRIC: [(Vector, f64); 4] =
    [([0.0; 3], 0.5), ([0.45, 0.1, 0.0], 0.35), ([-0.2, 0.4, 0.1], 0.3), ([0.1, -0.15, 0.5], 0.25)];

/// Centre, inertia in the given axes and principal moments of four unlike spheres.
#[test]
fn an_asymmetric_shape_has_its_centre_and_its_axes() {
    let spheres = ASYMMETRIC;
    let found = moments(&spheres);
    near(found.volume, 0.7260173672085, 1e-11);
    near(found.surface, 4.418893287345, 1e-11);
    for (k, golden) in [0.0641825704637, 0.0464705577759, 0.0439973258698].into_iter().enumerate() {
        near(found.centre[k], golden, 1e-10);
    }
    let inertia = found.inertia_over_volume();
    for ((r, c), golden) in [
        ((0, 0), 0.122602012166),
        ((1, 1), 0.144570647036),
        ((2, 2), 0.146988051635),
        ((0, 1), 0.004352260758),
        ((0, 2), 0.001446280677),
        ((1, 2), 0.002943169375),
    ] {
        near(inertia[r][c], golden, 1e-9);
        near(inertia[c][r], golden, 1e-9);
    }
    let shape = ShapeOfSpheres::new(&spheres).unwrap();
    for (k, golden) in [0.121740791939, 0.142948051739, 0.149471867159].into_iter().enumerate() {
        near(shape.shape.inertia_over_mass[k], golden, 1e-10);
    }
    // In its own axes the shape is about its centre, and its products of inertia vanish.
    let pieces: Vec<(Vector, f64)> = shape.shape.pieces.iter().map(|p| (p.centre, p.radius)).collect();
    let own = moments(&pieces);
    assert!(own.centre.iter().all(|x| x.abs() < 1e-10), "{:?}", own.centre);
    let inertia = own.inertia_over_volume();
    assert!([inertia[0][1], inertia[0][2], inertia[1][2]].iter().all(|x| x.abs() < 1e-10), "{inertia:?}");
    near(shape.sphericity(), 0.8840332851, 1e-9);
}

#[test]
fn spheres_inside_others_count_for_nothing_and_impossible_ones_are_named() {
    let alone = ShapeOfSpheres::new(&[([1.0, 2.0, 3.0], 0.5), ([1.1, 2.0, 3.0], 0.2)]).unwrap();
    assert_eq!(alone.shape.as_sphere(), Some(0.5));
    let said = |spheres: &[(Vector, f64)], text: &str| {
        let message = ShapeOfSpheres::new(spheres).unwrap_err();
        assert!(message.contains(text), "{message}");
    };
    said(&[], "at least one sphere");
    said(&[([0.0; 3], -1.0)], "sphere 0 is -1 m");
    said(&[([f64::NAN, 0.0, 0.0], 1.0)], "not finite");
    said(&[([0.0; 3], 1.0), ([0.0; 3], 1.0)], "the spheres 0 and 1 are equal");
}

/// Overlapping spheres on an ellipsoid.
pub(crate) fn spiral(count: usize) -> Vec<(Vector, f64)> {
    let sphere = |k: usize| {
        let (sine, cosine) = libm::sincos(2.4 * k as f64);
        let z = 1.0 - 2.0 * (k as f64 + 0.5) / count as f64;
        let rho = (1.0 - z * z).sqrt();
        ([0.5 * rho * cosine, 0.6 * rho * sine, 0.9 * z], 0.4 + 0.1 * libm::sin(5.0 * k as f64))
    };
    (0..count).map(sphere).collect()
}

/// Thirty spheres and more take milliseconds, and their moments are those of a simple count of points.
#[test]
fn many_spheres_have_the_volume_of_a_count_of_points() {
    let spheres = spiral(40);
    let start = std::time::Instant::now();
    let found = moments(&spheres);
    println!("{:?}", start.elapsed());
    let (n, edge) = (120, 3.0);
    let step = edge / n as f64;
    let at = |k: usize| (k as f64 + 0.5) * step - 0.5 * edge;
    let inside = |p: Vector| cuts::is_covered(&p, &spheres, [usize::MAX; 2]);
    let count = (0..n * n * n).filter(|k| inside([at(k % n), at(k / n % n), at(k / n / n)])).count();
    near(found.volume, count as f64 * step * step * step, 2e-3);
}
