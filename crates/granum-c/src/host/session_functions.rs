//! The session of a process, which user materials have in common: opened by the first call, or by the host's script.

use std::ffi::{c_char, c_int};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use super::session::Session;
use crate::failure::{Failure, guarded, keep_message};
use crate::point_handles::text;

/// The environment variable that names the configuration.
const VARIABLE: &str = "GRANUM_MATERIALS";
/// The configuration in the working folder, where the variable is not set.
const USUAL: &str = "granum-materials.toml";

static SESSION: RwLock<Option<Arc<Session>>> = RwLock::new(None);
/// The last reason for a refusal, of whichever thread.
static REFUSAL: Mutex<String> = Mutex::new(String::new());

/// The session of this process, opened if there is none.
///
/// # Errors
/// As [`Session::open`].
pub fn current() -> Result<Arc<Session>, Failure> {
    if let Some(session) = SESSION.read().unwrap_or_else(PoisonError::into_inner).as_ref() {
        return Ok(session.clone());
    }
    let mut place = SESSION.write().unwrap_or_else(PoisonError::into_inner);
    if let Some(session) = place.as_ref() {
        return Ok(session.clone());
    }
    let path = std::env::var_os(VARIABLE).map_or_else(|| PathBuf::from(USUAL), PathBuf::from);
    let session = Arc::new(Session::open(&path)?);
    *place = Some(session.clone());
    Ok(session)
}

/// Keeps the reason why a user material answered with NaN, since its host has no place for a message.
pub fn refused(message: &str) {
    *REFUSAL.lock().unwrap_or_else(PoisonError::into_inner) = message.to_string();
}

/// Opens a configuration for the user materials of this process, in place of the one that is open. Without this call the first question of
/// the host opens the one that the environment variable GRANUM_MATERIALS names, or granum-materials.toml in the working folder.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_points_open(configuration: *const c_char) -> c_int {
    guarded(|| {
        let path = unsafe { text(configuration, "path of the configuration") }?;
        let session = Session::open(Path::new(path))?;
        *SESSION.write().unwrap_or_else(PoisonError::into_inner) = Some(Arc::new(session));
        Ok(())
    })
}

/// Writes the states of all points of the user materials of this process to a file.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_points_save(path: *const c_char) -> c_int {
    guarded(|| {
        let path = unsafe { text(path, "path of the states") }?;
        Ok(current()?.store().save(Path::new(path))?)
    })
}

/// Reads the states of all points of the user materials of this process from a file, in place of those that there are.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_points_load(path: *const c_char) -> c_int {
    guarded(|| {
        let path = unsafe { text(path, "path of the states") }?;
        let session = current()?.with_states(Path::new(path))?;
        *SESSION.write().unwrap_or_else(PoisonError::into_inner) = Some(Arc::new(session));
        Ok(())
    })
}

/// Why a user material last answered with NaN or stopped the host, on any thread; an empty text if it never did. The text is valid until
/// the next call of a function of granum on this thread.
#[unsafe(no_mangle)]
pub extern "C" fn granum_points_message() -> *const c_char {
    let message = REFUSAL.lock().unwrap_or_else(PoisonError::into_inner).clone();
    keep_message(&message);
    crate::failure::granum_last_error()
}
