//! Every instruction set gives the same bits as the scalar reference.

use crate::*;

const SAMPLE: [f64; 24] = [
    0.0, -0.0, 1.0, -1.0, 0.5, 3.75, 1e-300, 1e300, 0.1, 0.2, 0.7, 2.5e-9, 123456.789, 1e-20, 42.0, 7.0,
    1e-5, 19.99, -0.3, -7.5, 0.999999, 1.000001, 600.0, 0.3333,
];

struct Everything<'a>(&'a [f64; 8], &'a [f64; 8]);

impl Kernel for Everything<'_> {
    type Output = Vec<u64>;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<u64> {
        let (a, b) = (L::load(self.0), L::load(self.1));
        let positive = a.abs();
        let results = [
            a + b,
            a - b,
            a * b,
            a / (b.abs() + L::splat(1.0)),
            -a,
            a.mul_add(b, a),
            positive.sqrt(),
            positive,
            a.min(b),
            a.max(b),
            L::select(a.lt(b), a, b),
            L::select(a.le(b) & !a.eq(b), b, a),
            L::select(a.gt(b) | a.ge(L::splat(1.0)), b, a),
            cbrt(positive),
            exp(a.min(L::splat(500.0)).max(L::splat(-500.0))),
            tanh(a),
            sigmoid(a),
        ];
        let mut bits = Vec::new();
        for r in results {
            let mut out = [0.0; 8];
            r.store(&mut out);
            bits.extend(out.map(f64::to_bits));
            bits.push(r.reduce_add().to_bits());
            bits.push(r.reduce_max().to_bits());
        }
        bits.push(a.lt(b).bits() as u64);
        bits
    }
}

#[test]
fn same_bits_on_every_instruction_set() {
    for s in 0..SAMPLE.len() {
        let a: [f64; 8] = std::array::from_fn(|l| SAMPLE[(s + l) % SAMPLE.len()]);
        let b: [f64; 8] = std::array::from_fn(|l| SAMPLE[(s + 3 * l + 5) % SAMPLE.len()]);
        let reference = dispatch(Isa::Portable, Everything(&a, &b));
        for isa in Isa::ALL.into_iter().filter(|i| i.available()) {
            assert_eq!(dispatch(isa, Everything(&a, &b)), reference, "{}", isa.name());
        }
        for l in 0..8 {
            assert_eq!(reference[l], (a[l] + b[l]).to_bits());
        }
    }
}

fn lanes<L: Lanes>(x: L) -> [u64; 8] {
    let mut out = [0.0; 8];
    x.store(&mut out);
    out.map(f64::to_bits)
}

struct Transposes;
impl Kernel for Transposes {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let rows: Vec<Row8> = (0..20).map(|r| Row8(std::array::from_fn(|c| (100 * r + c) as f64))).collect();
        let short: Vec<Row4> = (0..20).map(|r| Row4(std::array::from_fn(|c| (100 * r + c) as f64))).collect();
        let index = [3, 19, 0, 7, 7, 11, 2, 5];
        let columns = L::gather8(&rows, &index);
        for c in 0..8 {
            let mut out = [0.0; 8];
            columns[c].store(&mut out);
            assert_eq!(out, index.map(|i| (100 * i + c as u32) as f64));
        }
        for (c, column) in L::gather4(&short, &index).into_iter().enumerate() {
            let mut out = [0.0; 8];
            column.store(&mut out);
            assert_eq!(out, index.map(|i| (100 * i + c as u32) as f64));
        }
        let other = [1, 6, 0, 12, 19, 4, 3, 8];
        let tenth =
            |rows: &[Row8]| -> Vec<Row8> { rows.iter().map(|r| Row8(r.0.map(|x| 0.1 * x))).collect() };
        let fractions = tenth(&rows);
        let (from, to) = (L::gather8(&fractions, &index), L::gather8(&fractions, &other));
        for (c, column) in L::differences8(&fractions, &index, &other).into_iter().enumerate() {
            assert_eq!(lanes(column), lanes(to[c] - from[c]));
        }
        let (a, b) = (L::gather4(&short, &index), L::gather4(&short, &other));
        for (c, column) in L::sums4(&short, &index, &other).into_iter().enumerate() {
            assert_eq!(lanes(column), lanes(a[c] + b[c]));
        }
        let mut sums = [0.0; 8];
        L::reduce_add8(columns.map(|c| c * L::splat(0.1))).store(&mut sums);
        for c in 0..8 {
            assert_eq!(sums[c].to_bits(), (columns[c] * L::splat(0.1)).reduce_add().to_bits());
        }
        let mut back = [Row8::default(); 8];
        L::scatter8(columns, &mut back);
        for l in 0..8 {
            assert_eq!(back[l], rows[index[l] as usize]);
        }
    }
}

#[test]
fn gathers_and_scatters_transpose() {
    for isa in Isa::ALL.into_iter().filter(|i| i.available()) {
        dispatch(isa, Transposes);
    }
}

struct Checks([u32; 8], usize);
impl Kernel for Checks {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        L::check(&self.0, self.1);
    }
}

/// An index out of bounds is detected in any lane; with the largest bound nothing is out of bounds.
#[test]
fn rows_that_are_not_there_are_refused() {
    for isa in Isa::ALL.into_iter().filter(|i| i.available()) {
        dispatch(isa, Checks([0, 1, 2, 3, 4, 5, 6, 19], 20));
        dispatch(isa, Checks([u32::MAX - 1; 8], usize::MAX));
        for lane in 0..8 {
            for row in [20, 1 << 31, u32::MAX] {
                let mut index = [7, 0, 19, 3, 3, 18, 2, 5];
                index[lane] = row;
                let refused = std::panic::catch_unwind(|| dispatch(isa, Checks(index, 20)));
                let words = refused.unwrap_err().downcast::<String>().unwrap();
                assert_eq!(*words, format!("row {row} of 20"), "{}", isa.name());
            }
            assert!(std::panic::catch_unwind(|| dispatch(isa, Checks([0; 8], 0))).is_err());
        }
    }
}

#[test]
fn elementary_functions_are_accurate() {
    for k in 0..20_000 {
        let x = -18.0 + 36.0 * k as f64 / 19_999.0;
        assert!((exp(x) / x.exp() - 1.0).abs() < 5e-16, "exp {x}");
        assert!((tanh(x) - x.tanh()).abs() < 5e-16, "tanh {x}");
        assert!((sigmoid(x) - 1.0 / (1.0 + (-x).exp())).abs() < 4e-16, "sigmoid {x}");
        let y = (x * 10.0).exp();
        assert!((cbrt(y) / y.cbrt() - 1.0).abs() < 1e-15, "cbrt {y}");
    }
    assert_eq!(cbrt(0.0), 0.0);
}

struct SideBySide<'a>(&'a [f64; 8], &'a [f64; 8]);

impl Kernel for SideBySide<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        fn formula<R: Real>(a: R, b: R) -> (R, R::Mask) {
            let s = (a.abs() + R::splat(0.5)).sqrt();
            let m = a.lt(b) | !(a.le(s) & b.eq(s));
            let x = cbrt(s) / (b.abs() + s) - (-a).mul_add(s, b).min(a).max(R::splat(-3.0));
            (R::select(m, x, exp(a.min(R::splat(9.0)).max(R::splat(-9.0)))), m)
        }
        let (a, b) = (L::load(self.0), L::load(self.1));
        let both = formula(Twice(a, b), Twice(b, a));
        for (found, expected) in [(both.0.0, formula(a, b).0), (both.0.1, formula(b, a).0)] {
            let (mut x, mut y) = ([0.0; 8], [0.0; 8]);
            found.store(&mut x);
            expected.store(&mut y);
            assert_eq!(x.map(f64::to_bits), y.map(f64::to_bits));
        }
        assert_eq!(both.1.bits(), formula(a, b).1.bits() | (formula(b, a).1.bits() << 8));
        assert_eq!(both.1.any(), both.1.bits() != 0);
        assert_eq!(both.1.all(), both.1.bits() == 0xffff);
        assert_eq!(both.0.reduce_add(), both.0.0.reduce_add() + both.0.1.reduce_add());
        assert_eq!(both.0.reduce_max(), f64::max(both.0.0.reduce_max(), both.0.1.reduce_max()));
    }
}

#[test]
fn two_side_by_side_have_the_bits_of_one() {
    for s in 0..SAMPLE.len() {
        let a: [f64; 8] = std::array::from_fn(|l| SAMPLE[(s + l) % SAMPLE.len()]);
        let b: [f64; 8] = std::array::from_fn(|l| SAMPLE[(s + 5 * l + 2) % SAMPLE.len()]);
        for isa in Isa::ALL.into_iter().filter(|i| i.available()) {
            dispatch(isa, SideBySide(&a, &b));
        }
    }
}

/// Powers against the standard library, for arguments and exponents of all sizes.
#[test]
fn powers_are_accurate() {
    for k in -400..400 {
        let x = (f64::from(k) * 0.3).exp();
        for exponent in [-2.5, -0.4, 0.0, 1.0 / 3.0, 1.0, 1.4, 2.6] {
            let within = 2e-15 * (1.0 + (exponent * x.ln()).abs());
            let (found, wanted) = (crate::power(x, exponent), x.powf(exponent));
            assert!((found / wanted - 1.0).abs() < within, "{x} ^ {exponent}: {found} {wanted}");
        }
    }
    assert_eq!(crate::power(1.0, 7.0), 1.0);
}
