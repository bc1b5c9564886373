//! The radius of bonds from a content of cement.
//!
//! Cement fills the cylinder of radius r_b between two grains outside of their surfaces. Between equal spheres that touch its volume is
//! `2 pi (r_b^2 R - 2/3 (R^3 - (R^2 - r_b^2)^(3/2)))`, about `pi/2 r_b^4 / R`.

/// Volume of the cement between two pieces, m3: of a cylinder of this radius, m, whose ends are the centres of two spheres of given radii, m,
/// at a distance, m, without what is inside of the spheres.
pub fn cement_volume(radius: f64, radii: [f64; 2], distance: f64) -> f64 {
    let r = radius.min(radii[0]).min(radii[1]);
    let sphere = |big: f64| {
        let rest = (big * big - r * r).max(0.0);
        2.0 / 3.0 * std::f64::consts::PI * (big.powi(3) - rest * rest.sqrt())
    };
    // Spheres that overlap are flattened where they touch: they are taken as touching.
    let length = distance.max(radii[0] + radii[1]);
    (std::f64::consts::PI * r * r * length - sphere(radii[0]) - sphere(radii[1])).max(0.0)
}

/// The share lambda of the smaller radius of its two pieces that the radius of every bond has, so that the cement of all bonds has a volume,
/// m3; `None` if not even bonds as wide as their pieces hold it. Each bond is given as the radii of its pieces and their distance, m.
pub(super) fn share_of_radius(bonds: &[([f64; 2], f64)], volume: f64) -> Option<f64> {
    let held = |share: f64| -> f64 {
        let of = |(radii, distance): &([f64; 2], f64)| {
            cement_volume(share * radii[0].min(radii[1]), *radii, *distance)
        };
        bonds.iter().map(of).sum()
    };
    if volume.is_nan() || held(1.0) < volume {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if held(middle) < volume { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_neck_between_equal_spheres_has_the_golden_volume() {
        let volume = cement_volume(0.3, [1.0; 2], 2.0);
        assert!((volume - 0.012_921_049_3).abs() < 1e-10, "{volume}");
        assert!((volume / (0.5 * std::f64::consts::PI * 0.3f64.powi(4)) - 1.0).abs() < 0.03);
        // A gap adds a disc.
        let apart = cement_volume(0.3, [1.0; 2], 2.1);
        assert!((apart - volume - 0.1 * std::f64::consts::PI * 0.09).abs() < 1e-12);
    }

    #[test]
    fn the_share_of_the_radius_gives_back_the_volume() {
        let bonds = [([1.0, 1.0], 2.0), ([1.0, 0.5], 1.5), ([0.7, 0.5], 1.25)];
        let share = share_of_radius(&bonds, 0.05).unwrap();
        let held: f64 = bonds.iter().map(|(r, d)| cement_volume(share * r[0].min(r[1]), *r, *d)).sum();
        assert!((held / 0.05 - 1.0).abs() < 1e-9);
        assert_eq!(share_of_radius(&bonds, 50.0), None);
    }
}
