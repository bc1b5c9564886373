//! Sign and order of the components of a host: the one place where they are converted.

use granum_core::geometry::Matrix;
use granum_point::{Increment, PointError};
use serde::Deserialize;

use super::components::{components_of, tensor_from};

/// The order in which a host has the components of stress and strain. In all of them tension is positive, shear strains are angles, and the
/// first three are xx, yy, zz.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ComponentOrder {
    /// xy, yz, xz: Kratos, PLAXIS, OpenSees.
    Kratos,
    /// 12, 13, 23: Abaqus and CalculiX.
    Abaqus,
}

/// An increment as a host gives it.
#[derive(Clone, Copy, Debug)]
pub struct HostIncrement {
    /// Strain, tension positive, in the order of the host; unused components are zero.
    pub strain: [f64; 6],
    /// Stress at the beginning, tension positive, in the order of the host.
    pub stress: [f64; 6],
    /// The rotation of the increment, by which the host has already rotated the stress.
    pub rotation: Option<Matrix>,
}

impl ComponentOrder {
    /// The place of each component of the host among xx, yy, zz, yz, zx, xy.
    pub fn places(self) -> [usize; 6] {
        match self {
            ComponentOrder::Kratos => [0, 1, 2, 5, 3, 4],
            ComponentOrder::Abaqus => [0, 1, 2, 5, 4, 3],
        }
    }

    /// Components of a host as those of granum, with the other sign.
    pub fn from_host(self, components: &[f64; 6]) -> [f64; 6] {
        let mut turned = [0.0; 6];
        for (value, place) in components.iter().zip(self.places()) {
            // The sum makes a minus zero a zero.
            turned[place] = 0.0 - *value;
        }
        turned
    }

    /// Components of granum as those of the host, with the other sign.
    pub fn to_host(self, components: &[f64; 6]) -> [f64; 6] {
        self.places().map(|place| 0.0 - components[place])
    }

    /// A stiffness of granum with rows and columns in the order of the host; both signs turn, so that its entries keep theirs.
    pub fn stiffness_to_host(self, stiffness: &[[f64; 6]; 6]) -> [[f64; 6]; 6] {
        let places = self.places();
        places.map(|row| places.map(|column| stiffness[row][column]))
    }

    /// The stress before the increment, Pa, compression positive, and the increment. A host that gives a rotation has already rotated
    /// its stress by it; granum rotates the sample itself, so that the stress is rotated back.
    ///
    /// # Errors
    /// As [`Increment::after_rotation`].
    pub fn read(self, host: &HostIncrement) -> Result<(Matrix, Increment), PointError> {
        let stress = tensor_from(&self.from_host(&host.stress));
        let increment = Increment::from_components(self.from_host(&host.strain));
        let Some(rotation) = host.rotation else { return Ok((stress, increment)) };
        let increment = increment.after_rotation(&rotation)?;
        if increment.rotation()[0] == [1.0, 0.0, 0.0] && increment.rotation()[1] == [0.0, 1.0, 0.0] {
            return Ok((stress, increment));
        }
        let back = |r: usize, c: usize| {
            let entry = |i: usize, j: usize| rotation[i][r] * stress[i][j] * rotation[j][c];
            PAIRS.iter().map(|[i, j]| entry(*i, *j)).sum::<f64>()
        };
        Ok((std::array::from_fn(|r| std::array::from_fn(|c| back(r, c))), increment))
    }

    /// The stress of granum, Pa, compression positive, as that of the host.
    pub fn stress_to_host(self, stress: &Matrix) -> [f64; 6] {
        self.to_host(&components_of(stress))
    }
}

/// All pairs of axes.
const PAIRS: [[usize; 2]; 9] = [[0, 0], [0, 1], [0, 2], [1, 0], [1, 1], [1, 2], [2, 0], [2, 1], [2, 2]];

#[cfg(test)]
mod tests {
    use super::*;

    /// C1: a shear gamma_yz = 1e-3 alone is a tensor strain of 5e-4, in the fifth place of Kratos and the sixth of Abaqus.
    #[test]
    fn shear_stands_where_the_host_has_it() {
        for (order, slot) in [(ComponentOrder::Kratos, 4), (ComponentOrder::Abaqus, 5)] {
            let mut strain = [0.0; 6];
            strain[slot] = 1e-3;
            let host = HostIncrement { strain, stress: [0.0; 6], rotation: None };
            let (_, increment) = order.read(&host).unwrap();
            assert_eq!(increment.strain()[1][2], -5e-4, "{order:?}");
            assert_eq!(increment.strain()[0][2], 0.0);
            let mut stress = [[0.0; 3]; 3];
            (stress[1][2], stress[2][1]) = (7.0, 7.0);
            let mut expected = [0.0; 6];
            expected[slot] = -7.0;
            assert_eq!(order.stress_to_host(&stress), expected, "{order:?}");
        }
    }

    /// C2: rows and columns are mapped, and nothing is transposed.
    #[test]
    fn a_stiffness_is_mapped_and_not_transposed() {
        let numbered: [[f64; 6]; 6] = std::array::from_fn(|i| std::array::from_fn(|j| (10 * i + j) as f64));
        let kratos = ComponentOrder::Kratos.stiffness_to_host(&numbered);
        // Row xy (5 of granum), column yz (3); row xx, column xz (4).
        assert_eq!((kratos[3][4], kratos[4][3], kratos[0][5]), (53.0, 35.0, 4.0));
        let abaqus = ComponentOrder::Abaqus.stiffness_to_host(&numbered);
        assert_eq!((abaqus[3][5], abaqus[5][3], abaqus[0][4]), (53.0, 35.0, 4.0));
    }

    #[test]
    fn signs_turn_once_and_come_back() {
        let host = [-100.0, -50.0, -70.0, 3.0, -4.0, 5.0];
        for order in [ComponentOrder::Kratos, ComponentOrder::Abaqus] {
            assert_eq!(order.to_host(&order.from_host(&host)), host);
            assert_eq!(order.from_host(&host)[..3], [100.0, 50.0, 70.0]);
        }
        assert!(ComponentOrder::Kratos.from_host(&[0.0; 6])[0].is_sign_positive());
    }

    /// A stress that the host has rotated by a quarter turn about z is rotated back: xx and yy change places.
    #[test]
    fn a_rotated_stress_is_rotated_back() {
        let rotation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let stress = [-10.0, -20.0, -30.0, 0.0, 0.0, 0.0];
        let host = HostIncrement { strain: [0.0; 6], stress, rotation: Some(rotation) };
        let (stress, increment) = ComponentOrder::Abaqus.read(&host).unwrap();
        assert_eq!([stress[0][0], stress[1][1], stress[2][2]], [20.0, 10.0, 30.0]);
        assert_eq!(increment.rotation(), &rotation);
    }
}
