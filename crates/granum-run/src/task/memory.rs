//! Estimate of the memory that a run needs; a case that does not fit into memory is refused before anything is computed.

use granum_io::Case;

use super::laboratory_error::LaboratoryError;

/// Upper bound on the memory that a run needs for each grain, bytes: the state with its neighbour list, and the old list as
/// well while a new one is built (measured with a million grains; see BENCHMARKS.md).
pub const BYTES_PER_GRAIN: u64 = 2300;
/// Memory that the program needs for any number of grains, bytes.
pub const BYTES_AT_LEAST: u64 = 64 << 20;

/// Upper bound on the memory that a run with the given number of grains needs, bytes.
pub fn needed(grains: usize) -> u64 {
    (grains as u64).saturating_mul(BYTES_PER_GRAIN).saturating_add(BYTES_AT_LEAST)
}

/// Memory that is available to this process, bytes; `None` if the system does not report it.
pub fn available() -> Option<u64> {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let free = Some(system.available_memory()).filter(|bytes| *bytes > 0)?;
    // The limit of a container may be lower than the free memory of the computer.
    Some(system.cgroup_limits().map_or(free, |limits| free.min(limits.free_memory)))
}

/// Refuses a case that does not fit into the available memory.
///
/// # Errors
/// [`LaboratoryError::Memory`] with the estimate.
pub fn check(case: &Case) -> Result<(), LaboratoryError> {
    let (grains, spheres) = (case.grains.count, spheres_of(case));
    check_against(spheres, available()).map_err(|error| match error {
        // In grains of this case, each of which may have several spheres.
        LaboratoryError::Memory { needed, available, fitting, .. } => {
            let fitting = (fitting as f64 * grains as f64 / spheres as f64) as usize;
            LaboratoryError::Memory { grains, needed, available, fitting }
        }
        error => error,
    })
}

/// Number of spheres of which the grains of a case consist: memory and time grow with them.
pub(crate) fn spheres_of(case: &Case) -> usize {
    case.grains.pieces().unwrap_or(case.grains.count)
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
    fn grains_of_several_spheres_need_the_memory_of_their_spheres() {
        let mut case = Case::default();
        assert_eq!(spheres_of(&case), 5000);
        case.set("grains.shape.kind", "tetrapod").unwrap();
        assert_eq!(spheres_of(&case), 20_000);
    }

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
    fn the_memory_of_this_computer_is_known() {
        // Other systems may not report it.
        let known = available().is_some_and(|bytes| bytes > 1 << 20);
        assert!(known || !cfg!(target_os = "linux"));
    }
}
