//! What the data cannot say of a table of contacts, and its owner can.

use granum_core::names::nearest;

/// Answers to what cannot be decided from a table of contacts and the grains beside it. Without an answer the data are refused, with the
/// answers that are possible.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ContactOptions {
    /// What pairs are that do not touch, in a table without forces.
    pub pairs_apart: Option<PairsApart>,
    /// What pairs are that overlap and that the table lacks.
    pub missing_pairs: Option<MissingPairs>,
    /// What forces are that pull in every row between grains that overlap.
    pub contact_forces: Option<ContactForces>,
    /// What rows of the same pair are that differ in their forces.
    pub repeated_pairs: Option<RepeatedPairs>,
}

impl ContactOptions {
    /// Answers by which nothing is refused and the rows are taken as they are.
    pub fn as_given() -> ContactOptions {
        ContactOptions {
            pairs_apart: Some(PairsApart::Contacts),
            missing_pairs: Some(MissingPairs::NoContacts),
            contact_forces: Some(ContactForces::AsGiven),
            repeated_pairs: Some(RepeatedPairs::Sum),
        }
    }

    /// The same with these answers by name; what is `None` stays as it is.
    ///
    /// # Errors
    /// The name of the option, and what is wrong with its value.
    pub fn with_names(
        mut self,
        pairs_apart: Option<&str>,
        missing_pairs: Option<&str>,
        contact_forces: Option<&str>,
        repeated_pairs: Option<&str>,
    ) -> Result<ContactOptions, (&'static str, String)> {
        choose(&mut self.pairs_apart, ContactOptions::PAIRS_APART, &PairsApart::NAMES, pairs_apart)?;
        choose(&mut self.missing_pairs, ContactOptions::MISSING_PAIRS, &MissingPairs::NAMES, missing_pairs)?;
        choose(
            &mut self.contact_forces,
            ContactOptions::CONTACT_FORCES,
            &ContactForces::NAMES,
            contact_forces,
        )?;
        choose(
            &mut self.repeated_pairs,
            ContactOptions::REPEATED_PAIRS,
            &RepeatedPairs::NAMES,
            repeated_pairs,
        )?;
        Ok(self)
    }

    /// Name of the option of pairs that do not touch.
    pub const PAIRS_APART: &'static str = "pairs-apart";
    /// Name of the option of pairs that the table lacks.
    pub const MISSING_PAIRS: &'static str = "missing-pairs";
    /// Name of the option of forces that pull.
    pub const CONTACT_FORCES: &'static str = "contact-forces";
    /// Name of the option of rows of the same pair.
    pub const REPEATED_PAIRS: &'static str = "repeated-pairs";
}

/// Chooses the value of a name, if one is given.
fn choose<T: Copy>(
    into: &mut Option<T>,
    option: &'static str,
    names: &[(&'static str, T)],
    name: Option<&str>,
) -> Result<(), (&'static str, String)> {
    let Some(name) = name else { return Ok(()) };
    let all: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
    *into =
        Some(names.iter().find(|(known, _)| *known == name).map(|(_, value)| *value).ok_or_else(|| {
            let near = nearest(name, all.iter().copied())
                .map_or(String::new(), |near| format!(" (did you mean {near}?)"));
            (option, format!("{name:?} is not possible{near}; possible are {}", all.join(" and ")))
        })?);
    Ok(())
}

/// What pairs are that do not touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairsApart {
    /// Contacts, as bridges of liquid are.
    Contacts,
    /// No contacts: the table lists what is near each other.
    NoContacts,
}

impl PairsApart {
    /// The values by name.
    pub const NAMES: [(&'static str, PairsApart); 2] =
        [("contacts", PairsApart::Contacts), ("no-contacts", PairsApart::NoContacts)];
}

/// What pairs are that overlap and that the table lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissingPairs {
    /// No contacts.
    NoContacts,
    /// Contacts without a force.
    WithoutForce,
}

impl MissingPairs {
    /// The values by name.
    pub const NAMES: [(&'static str, MissingPairs); 2] =
        [("no-contacts", MissingPairs::NoContacts), ("without-force", MissingPairs::WithoutForce)];
}

/// What forces are that pull in every row between grains that overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactForces {
    /// Right as they are: all contacts are in tension.
    AsGiven,
    /// Those on the second grain, or positive in tension: they are turned round.
    Reversed,
}

impl ContactForces {
    /// The values by name.
    pub const NAMES: [(&'static str, ContactForces); 2] =
        [("as-given", ContactForces::AsGiven), ("reversed", ContactForces::Reversed)];
}

/// What rows of the same pair are that differ in their forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RepeatedPairs {
    /// The first counts.
    First,
    /// Parts of one force.
    Sum,
}

impl RepeatedPairs {
    /// The values by name.
    pub const NAMES: [(&'static str, RepeatedPairs); 2] =
        [("first", RepeatedPairs::First), ("sum", RepeatedPairs::Sum)];
}
