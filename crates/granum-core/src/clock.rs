//! Wall time: that of the standard library, and in a browser that of the page, where the standard library has none.
//!
//! No result depends on it: it paces checkpoints and reports, and times what is reported as time.

#[cfg(not(all(target_arch = "wasm32", target_os = "unknown")))]
pub use std::time::Instant;

#[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
pub use of_a_page::Instant;

#[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
mod of_a_page {
    use std::time::Duration;

    #[link(wasm_import_module = "page")]
    unsafe extern "C" {
        /// Milliseconds since some moment that stays (`performance.now`).
        safe fn milliseconds() -> f64;
    }

    /// A moment, as the page measures it.
    #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
    pub struct Instant(f64);

    impl Instant {
        /// The present moment.
        pub fn now() -> Instant {
            Instant(milliseconds())
        }

        /// The time since then; zero if the clock of the page was set back.
        pub fn elapsed(&self) -> Duration {
            Duration::try_from_secs_f64((milliseconds() - self.0) / 1e3).unwrap_or_default()
        }

        /// The time from an earlier moment to this one; zero if that is later.
        pub fn duration_since(&self, earlier: Instant) -> Duration {
            Duration::try_from_secs_f64((self.0 - earlier.0) / 1e3).unwrap_or_default()
        }
    }
}
