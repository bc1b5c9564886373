//! Energy by mechanism: one list of what the contacts of a simulation take up and lose, from which its sums, its ledger, the
//! columns of the series, the check of the balance and the figure of the report follow. Energies that a contact law alone knows
//! have channels, which the law declares.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Where a mechanism belongs: which sensor measures it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MechanismGroup {
    /// Forces at contacts.
    Forces,
    /// Couples at contacts that resist rolling or twisting.
    Couples,
    /// Attractions beyond touch.
    Attraction,
}

/// One of the mechanisms by which contacts take up energy, and its place in a series and a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mechanism {
    /// Where it belongs.
    pub group: MechanismGroup,
    /// Its column in a series.
    pub column: &'static str,
    /// What the column holds.
    pub meaning: &'static str,
    /// How a report names what is lost in it; `None` for work that is stored or lost in other mechanisms.
    pub loss: Option<&'static str>,
    /// The column of the work of which it is a part, so that a balance counts it once.
    pub part_of: Option<&'static str>,
}

/// Declares the mechanisms: the fields of both structs, in the order of [`MECHANISMS`].
macro_rules! mechanisms {
    ($(
        $(#[doc = $text:literal])+
        $(#[serde($($rule:tt)*)])?
        $name:ident: $group:ident, $column:literal, $meaning:literal, $loss:expr, $part_of:expr;
    )*) => {
        /// Energy by mechanism since the start of the phase, J. `boundary_work = sum of the rest + change of stored energy`.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct EnergyBalance {
            /// Work done on the grains by the deformation of the cell.
            pub boundary_work: f64,
            $(
                $(#[doc = $text])+
                $(#[serde($($rule)*)])?
                pub $name: f64,
            )*
            /// Energies in the channels that contact laws declare, by key; those without energy are left out.
            #[serde(flatten)]
            pub channels: BTreeMap<String, f64>,
        }

        /// Energy by mechanism in one step or a part of it, J.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct MechanismEnergies {
            $(
                $(#[doc = $text])+
                pub $name: f64,
            )*
        }

        /// The mechanisms, in the order of the fields of [`MechanismEnergies`].
        pub const MECHANISMS: [Mechanism; [$($column),*].len()] = [$(
            Mechanism {
                group: MechanismGroup::$group,
                column: $column,
                meaning: $meaning,
                loss: $loss,
                part_of: $part_of,
            },
        )*];

        impl EnergyBalance {
            /// The energies of all mechanisms.
            #[inline]
            pub fn mechanisms(&self) -> MechanismEnergies {
                MechanismEnergies { $($name: self.$name),* }
            }

            /// Adds energies to those of the same mechanisms.
            #[inline]
            pub fn add(&mut self, energies: &MechanismEnergies) {
                $(self.$name += energies.$name;)*
            }
        }

        impl MechanismEnergies {
            /// The energies, in the order of [`MECHANISMS`].
            #[inline]
            pub fn values(&self) -> [f64; MECHANISMS.len()] {
                [$(self.$name),*]
            }

            /// Adds the energies of the same mechanisms.
            #[inline]
            pub fn add(&mut self, other: &MechanismEnergies) {
                $(self.$name += other.$name;)*
            }
        }
    };
}

const OF_FORCES: Option<&str> = Some("tangential_work");
const OF_COUPLES: Option<&str> = Some("rolling_work");

mechanisms! {
    /// Work of the elastic tangential forces, positive where energy is absorbed: stored, lost in micro-slip and in sliding.
    tangential_work: Forces, "tangential_work", "work taken up by the elastic tangential forces", None, None;
    /// Lost to sliding at the friction limit (part of `tangential_work`).
    friction: Forces, "friction_loss", "lost to sliding at the friction limit, part of tangential_work",
        Some("sliding friction"), OF_FORCES;
    /// Lost without sliding, in the slip zones of the contact areas (part of `tangential_work`).
    micro_slip: Forces, "micro_slip_loss", "lost in the slip zones of contacts that do not slide, part of tangential_work",
        Some("micro-slip"), OF_FORCES;
    /// Lost in the contact dashpots.
    damping: Forces, "damping_loss", "lost in the contact dashpots", Some("contact damping"), None;
    /// Lost when adhesive contacts formed: no force returns the energy that the surfaces release.
    adhesion_made: Forces, "adhesion_made_loss", "lost when adhesive contacts were made",
        Some("making adhesive contacts"), None;
    /// Lost when adhesive contacts broke.
    adhesion_broken: Forces, "adhesion_broken_loss", "lost when adhesive contacts broke",
        Some("breaking adhesive contacts"), None;
    /// Work of the elastic couples of rolling and twisting, positive where energy is absorbed.
    #[serde(default, skip_serializing_if = "is_zero")]
    rolling_work: Couples, "rolling_work", "work taken up by the elastic couples of rolling and twisting", None, None;
    /// Lost by rolling and twisting, without dashpots (part of `rolling_work`).
    #[serde(default, skip_serializing_if = "is_zero")]
    rolling: Couples, "rolling_loss", "lost by rolling and twisting without dashpots, part of rolling_work",
        Some("rolling"), OF_COUPLES;
    /// Lost where attractions beyond touch begin or end: bridges that rupture.
    #[serde(default, skip_serializing_if = "is_zero")]
    attraction_loss: Attraction, "attraction_loss", "lost where attractions beyond touch begin or end",
        Some("attraction ended"), None;
}

impl EnergyBalance {
    /// Energy in the channel of a law, J; zero if there is none.
    pub fn channel(&self, key: &str) -> f64 {
        self.channels.get(key).copied().unwrap_or(0.0)
    }

    /// What the mechanisms and the channels of laws took up in addition to a stored energy, J: each counted once, in a fixed order.
    pub fn accounted(&self, stored: f64) -> f64 {
        let whole = MECHANISMS.iter().zip(self.mechanisms().values());
        let whole = whole.filter(|(mechanism, _)| mechanism.part_of.is_none()).map(|(_, energy)| energy);
        whole.chain(self.channels.values().copied()).fold(stored, |sum, energy| sum + energy)
    }
}

impl MechanismGroup {
    /// Its mechanisms.
    pub fn mechanisms(self) -> impl Iterator<Item = &'static Mechanism> {
        MECHANISMS.iter().filter(move |mechanism| mechanism.group == self)
    }

    /// The energies of its mechanisms, J.
    pub fn values(self, energies: &EnergyBalance) -> impl Iterator<Item = f64> {
        let all = MECHANISMS.iter().zip(energies.mechanisms().values());
        all.filter(move |(mechanism, _)| mechanism.group == self).map(|(_, energy)| energy)
    }
}

/// True for what files without a law of moments, of adhesion or with memory leave out.
pub(crate) fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_balance_counts_each_energy_once() {
        let mut balance = EnergyBalance { boundary_work: 7.0, ..EnergyBalance::default() };
        let energies = MechanismEnergies {
            tangential_work: 1.0,
            friction: 0.75,
            rolling_work: 2.0,
            rolling: 1.5,
            attraction_loss: 0.5,
            ..MechanismEnergies::default()
        };
        balance.add(&energies);
        balance.channels.insert("crushing_loss".into(), 0.25);
        assert_eq!(balance.mechanisms(), energies);
        // The losses by sliding and rolling are parts of the work of the forces and couples.
        assert_eq!(balance.accounted(3.0), 3.0 + 1.0 + 2.0 + 0.5 + 0.25);
        assert_eq!(MechanismGroup::Couples.values(&balance).collect::<Vec<_>>(), [2.0, 1.5]);
        for mechanism in MECHANISMS.iter().filter_map(|mechanism| mechanism.part_of) {
            assert!(MECHANISMS.iter().any(|whole| whole.column == mechanism && whole.part_of.is_none()));
        }
    }

    #[test]
    fn a_file_leaves_out_what_sets_without_rolling_and_attraction_do_not_have() {
        let balance = EnergyBalance { friction: 0.5, rolling: 0.25, ..EnergyBalance::default() };
        let text = serde_json::to_string(&balance).unwrap();
        assert_eq!(
            text,
            "{\"boundary_work\":0.0,\"tangential_work\":0.0,\"friction\":0.5,\"micro_slip\":0.0,\"damping\":0.0,\
             \"adhesion_made\":0.0,\"adhesion_broken\":0.0,\"rolling\":0.25}"
        );
        assert_eq!(serde_json::from_str::<EnergyBalance>(&text).unwrap(), balance);
        assert!(serde_json::from_str::<EnergyBalance>("{\"boundary_work\":0.0}").is_err());
    }
}
