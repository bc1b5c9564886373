//! Products of vectors of numbers or lanes, in a fixed order of fused operations.

use crate::Real;

/// Dot product: `a_0 b_0 + (a_1 b_1 + (... + a_n b_n))`, where each sum with a product is fused.
#[inline(always)]
pub fn dot<R: Real, const D: usize>(a: [R; D], b: [R; D]) -> R {
    let mut sum = a[D - 1] * b[D - 1];
    for k in (0..D - 1).rev() {
        sum = a[k].mul_add(b[k], sum);
    }
    sum
}

/// Cross product.
#[inline(always)]
pub fn cross<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [
        a[1].mul_add(b[2], -(a[2] * b[1])),
        a[2].mul_add(b[0], -(a[0] * b[2])),
        a[0].mul_add(b[1], -(a[1] * b[0])),
    ]
}

/// `a + s b`.
#[inline(always)]
pub fn add_scaled<R: Real, const D: usize>(a: [R; D], s: R, b: [R; D]) -> [R; D] {
    let mut sum = a;
    for k in 0..D {
        sum[k] = s.mul_add(b[k], a[k]);
    }
    sum
}

/// `a - b`.
#[inline(always)]
pub fn subtract<R: Real, const D: usize>(a: [R; D], b: [R; D]) -> [R; D] {
    let mut difference = a;
    for k in 0..D {
        difference[k] = a[k] - b[k];
    }
    difference
}

/// `s a`.
#[inline(always)]
pub fn scale<R: Real, const D: usize>(s: R, a: [R; D]) -> [R; D] {
    let mut product = a;
    for k in 0..D {
        product[k] = s * a[k];
    }
    product
}

/// One vector where the mask is true, else the other.
#[inline(always)]
pub fn select<R: Real, const D: usize>(mask: R::Mask, yes: [R; D], no: [R; D]) -> [R; D] {
    let mut chosen = yes;
    for k in 0..D {
        chosen[k] = R::select(mask, yes[k], no[k]);
    }
    chosen
}

/// The vector where the mask is true, else zero.
#[inline(always)]
pub fn keep<R: Real, const D: usize>(mask: R::Mask, a: [R; D]) -> [R; D] {
    let mut kept = a;
    for k in 0..D {
        kept[k] = a[k].keep(mask);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_geometry() {
        let (a, b) = ([1.0, 2.0, 3.0], [4.0, -5.0, 6.0]);
        assert_eq!(dot(a, b), 12.0);
        assert_eq!(dot([3.0, 4.0], [3.0, 4.0]), 25.0);
        assert_eq!(cross(a, b), [27.0, 6.0, -13.0]);
        assert_eq!(add_scaled(a, 2.0, b), [9.0, -8.0, 15.0]);
        assert_eq!(subtract(a, b), [-3.0, 7.0, -3.0]);
        assert_eq!(scale(2.0, a), [2.0, 4.0, 6.0]);
        assert_eq!(select::<f64, 3>(true, a, b), a);
        assert_eq!(select::<f64, 3>(false, a, b), b);
        assert_eq!(keep::<f64, 3>(false, a), [0.0; 3]);
    }

    /// The order of the sum is that in which a chain of fused operations ends with the first component.
    #[test]
    fn the_order_of_a_sum_is_fixed() {
        let (a, b) = ([1e16, 1.0, -1e16], [1.0, 3.0, 1.0]);
        assert_eq!(dot(a, b), crate::mul_add(1e16, 1.0, crate::mul_add(1.0, 3.0, -1e16)));
    }
}
