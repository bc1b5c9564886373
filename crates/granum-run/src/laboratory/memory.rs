//! What a run needs of the machine's memory; a size that it cannot hold is refused before anything is made.

use granum_io::Case;

use super::LaboratoryError;

/// Most memory that a run takes for a grain, bytes: the state with its pair list, and while a new list is made the old one
/// beside it (measured at a million grains; see BENCHMARKS.md).
pub const BYTES_PER_GRAIN: u64 = 2300;
/// What the program takes whatever the size, bytes.
pub const BYTES_AT_LEAST: u64 = 64 << 20;

/// Most memory that a run with so many grains takes, bytes.
pub fn needed(grains: usize) -> u64 {
    (grains as u64).saturating_mul(BYTES_PER_GRAIN).saturating_add(BYTES_AT_LEAST)
}

/// Memory that this process may have, bytes; nothing where the system does not tell.
pub fn available() -> Option<u64> {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let free = Some(system.available_memory()).filter(|bytes| *bytes > 0)?;
    // A container may be allowed less than the machine has.
    Some(system.cgroup_limits().map_or(free, |limits| free.min(limits.free_memory)))
}

/// Refuses a case that the machine cannot hold.
///
/// # Errors
/// [`LaboratoryError::Memory`] with the estimate.
pub fn check(case: &Case) -> Result<(), LaboratoryError> {
    check_grains(case.grains.count)
}

/// As [`check`] for a number of grains.
///
/// # Errors
/// As [`check`].
pub fn check_grains(grains: usize) -> Result<(), LaboratoryError> {
    check_against(grains, available())
}

fn check_against(grains: usize, available: Option<u64>) -> Result<(), LaboratoryError> {
    let needed = needed(grains);
    match available {
        Some(available) if needed > available => Err(LaboratoryError::Memory {
            grains,
            needed: needed as f64 / 1e9,
            available: available as f64 / 1e9,
            fitting: (available.saturating_sub(BYTES_AT_LEAST) / BYTES_PER_GRAIN) as usize,
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_with_the_estimate() {
        assert!(check_against(5000, available()).is_ok());
        assert!(check_against(1_000_000_000, None).is_ok());
        assert!(check_against(1_000_000, Some(24 << 30)).is_ok());
        let error = check_against(1_000_000, Some(1 << 30)).unwrap_err().to_string();
        assert!(error.contains("1000000 grains need up to 2.4 GB of memory"), "{error}");
        assert!(error.contains("has 1.1 GB free") && error.contains("at most 437666"), "{error}");
    }

    #[test]
    fn this_machine_tells_its_memory() {
        assert!(available().is_none_or(|bytes| bytes > 1 << 20));
    }
}
