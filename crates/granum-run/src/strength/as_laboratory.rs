//! The curves of a test in the measures of a laboratory.

use granum_dem::loading::Stage;
use granum_io::LaboratoryTest;
use granum_sensors::Record;

use super::curves::Curves;

/// Strain over the initial length, from a logarithmic strain.
fn engineering(strain: &f64) -> f64 {
    1.0 - libm::exp(-strain)
}

/// The curves of the test proper of a record with these stages ([`Curves::test_rows`]) as a laboratory gives them: engineering strains that
/// count from its start, compression positive, `q = sigma_axial - sigma_lateral`, SI units.
pub fn as_laboratory(name: &str, record: &Record, stages: &[Stage]) -> LaboratoryTest {
    let curves = Curves::new(record, stages);
    let rows = curves.test_rows();
    let take = |values: &[f64]| values.get(rows.clone()).map_or(Vec::new(), <[f64]>::to_vec);
    let strain = |values: Vec<f64>| -> Vec<f64> { take(&values).iter().map(engineering).collect() };
    LaboratoryTest {
        name: name.to_owned(),
        axial_strain: strain(curves.axial_strain(rows.start)),
        volumetric_strain: strain(curves.volumetric_strain(rows.start)),
        deviator_stress: take(&curves.axial_deviator()),
        mean_stress: take(curves.mean_stress()),
        void_ratio: take(&curves.void_ratio()),
        doubts: Vec::new(),
    }
}
