//! Claims: which process works on a run, on any machine that shares the folder.
//!
//! Locks of the operating system do not serve here: on network file systems they may hold between the processes of one machine only, or
//! not be there at all. A claim is a file `claims/NAME.1` with its owner and a number that grows with every beat, and rests on what every
//! shared file system does right:
//!
//! - A file is created exclusively (`O_EXCL`): of several processes that try, on whatever machine, one succeeds.
//! - A file that is opened anew shows what another machine had written and closed before (NFS calls this close-to-open consistency).
//!
//! A claim that does not beat any more is stale: its process was killed, or lost with its node. That is judged by how long it has been
//! watched without a change, by the watcher's own clock, so that the clocks of machines are never compared; on the machine of the owner the
//! end of its process is seen at once. A stale claim `NAME.1` is neither removed nor renamed, which two processes could do in turn; it is
//! overruled by `NAME.2`, which again one process alone can create. A process that was only suspended finds itself overruled at its next
//! beat and stops. For the moment that this takes two processes may be at work; they compute the same bytes, and files are renamed to
//! their places as a whole.

mod owner;
mod waiting;

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use granum_io::{Error, Result};
use serde::{Deserialize, Serialize};

use self::owner::Owner;
pub use self::waiting::Waiting;

/// Folder of the claims of a campaign.
pub const CLAIMS: &str = "claims";
/// How often one who waits looks.
const LOOK_EVERY: Duration = Duration::from_millis(200);
/// A larger file is no claim.
const LARGEST: u64 = 1 << 12;

/// How often a claim beats, and after which time without a beat it is stale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClaimTimes {
    /// Time between two beats.
    pub beat: Duration,
    /// Time without a change after which a claim is stale. Several beats, and more than the minute for which network file systems may
    /// show an earlier state.
    pub stale: Duration,
}

impl Default for ClaimTimes {
    fn default() -> ClaimTimes {
        ClaimTimes { beat: Duration::from_secs(10), stale: Duration::from_secs(90) }
    }
}

/// The content of the file of a claim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Content {
    #[serde(flatten)]
    owner: Owner,
    beat: u64,
}

impl Content {
    fn text(&self) -> String {
        // Texts and numbers can always be written.
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }
}

/// A process that wants a claim, and watches the one that is in its way.
#[derive(Debug)]
pub struct Claimant {
    folder: PathBuf,
    name: String,
    times: ClaimTimes,
    /// The claim in the way: its generation and text, since when they have not changed, and whether they ever did.
    seen: Option<Seen>,
}

#[derive(Clone, Debug)]
struct Seen {
    generation: u64,
    text: String,
    since: Instant,
    beats: bool,
}

impl Claimant {
    /// Wants the claim of a name in the folder of a campaign.
    pub fn new(campaign: &Path, name: &str) -> Claimant {
        Claimant::with_times(campaign, name, ClaimTimes::default())
    }

    /// The same with other times.
    pub fn with_times(campaign: &Path, name: &str, times: ClaimTimes) -> Claimant {
        Claimant { folder: campaign.join(CLAIMS), name: name.replace(' ', "-"), times, seen: None }
    }

    /// Takes the claim, if no other process holds it. To be called again and again by one that waits.
    ///
    /// # Errors
    /// [`Error::File`] if the folder cannot be written.
    pub fn take(&mut self) -> Result<Option<Claim>> {
        self.try_to_take().map_err(Error::file("write", &self.folder))
    }

    /// Takes the claim, or finds that its process lives: on the machine of that process at once, and from another one when it has beaten,
    /// or has not for as long as a claim lasts. Ends without the claim when `stops` says so. `tell` is told for whom it waits.
    ///
    /// # Errors
    /// As [`Claimant::take`].
    pub fn take_unless_alive(
        &mut self,
        stops: &dyn Fn() -> bool,
        tell: &dyn Fn(&str),
    ) -> Result<Option<Claim>> {
        let mut waiting = Waiting::after(self.times.beat / 2);
        loop {
            if let Some(claim) = self.take()? {
                return Ok(Some(claim));
            }
            let owner = self.seen.as_ref().and_then(|seen| serde_json::from_str::<Content>(&seen.text).ok());
            if self.is_at_work() || stops() || owner.is_some_and(|content| content.owner.is_seen_alive()) {
                return Ok(None);
            }
            if let Some(words) = waiting.words(|_| self.in_the_way()) {
                tell(&words);
            }
            thread::sleep(self.times.beat.min(LOOK_EVERY));
        }
    }

    /// Who holds the claim, in words: ` (process 4711 on node12)`.
    pub fn holder(&self) -> String {
        self.owner().map_or_else(String::new, |owner| format!(" ({})", owner.in_words()))
    }

    fn owner(&self) -> Option<Owner> {
        let seen = self.seen.as_ref()?;
        serde_json::from_str::<Content>(&seen.text).ok().map(|content| content.owner)
    }

    /// For whom it waits, what is known of it, and when the wait is over, in words.
    pub fn in_the_way(&self) -> String {
        let who = self.owner().map_or_else(|| "another process".to_string(), |owner| owner.in_words());
        let Some(seen) = &self.seen else { return who };
        let silent = seen.since.elapsed();
        let file = format!("{}.{}", self.name, seen.generation);
        if silent < 2 * self.times.beat {
            return format!("{who}, which has the claim {file} and is at work");
        }
        format!(
            "{who}, which has the claim {file} and has not been heard of for {} s; after {} s without a sign of it this process goes on",
            silent.as_secs(),
            self.times.stale.as_secs()
        )
    }

    /// True if the claim in the way has beaten while it was watched, so that its process is at work.
    pub fn is_at_work(&self) -> bool {
        self.seen.as_ref().is_some_and(|seen| seen.beats)
    }

    fn path(&self, generation: u64) -> PathBuf {
        self.folder.join(format!("{}.{generation}", self.name))
    }

    fn try_to_take(&mut self) -> io::Result<Option<Claim>> {
        fs::create_dir_all(&self.folder)?;
        let before = newest(&self.folder, &self.name);
        if before > 0 && !self.is_stale(before) {
            return Ok(None);
        }
        let generation = before + 1;
        let path = self.path(generation);
        let mut file = match OpenOptions::new().write(true).create_new(true).open(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Ok(None),
            file => file?,
        };
        let content = Content { owner: Owner::here(), beat: 0 };
        let written = file.write_all(content.text().as_bytes()).and_then(|()| file.sync_all());
        drop(file);
        let stale_is_as_it_was = before == 0
            || read(&self.path(before))
                .is_none_or(|text| self.seen.as_ref().is_some_and(|seen| seen.text == text));
        if written.is_err() || !stale_is_as_it_was || newest(&self.folder, &self.name) != generation {
            // A claim that was released and taken anew in between is not overruled.
            let _ = fs::remove_file(&path);
            return written.map(|()| None);
        }
        for older in 1..generation {
            // What stays is overruled all the same.
            let _ = fs::remove_file(self.path(older));
        }
        let above = self.path(generation + 1);
        Ok(Some(Claim::kept(path, above, content, self.times.beat)))
    }

    /// True if a claim is that of a process that has ended, or has not changed for long enough.
    fn is_stale(&mut self, generation: u64) -> bool {
        let Some(text) = read(&self.path(generation)) else { return false };
        let now = Instant::now();
        let is_same =
            self.seen.as_ref().is_some_and(|seen| (seen.generation, &seen.text) == (generation, &text));
        if !is_same {
            let beats = self.seen.as_ref().is_some_and(|seen| seen.generation == generation);
            self.seen = Some(Seen { generation, text: text.clone(), since: now, beats });
        }
        let has_ended = serde_json::from_str::<Content>(&text).is_ok_and(|content| content.owner.has_ended());
        has_ended || self.seen.as_ref().is_some_and(|seen| now.duration_since(seen.since) >= self.times.stale)
    }
}

/// True if a process holds the claim of a name, as far as that can be known at one look: a claim that is stale on another machine counts.
pub fn is_claimed(campaign: &Path, name: &str) -> bool {
    let (folder, name) = (campaign.join(CLAIMS), name.replace(' ', "-"));
    let generation = newest(&folder, &name);
    let text = (generation > 0).then(|| read(&folder.join(format!("{name}.{generation}")))).flatten();
    text.is_some_and(|text| {
        serde_json::from_str::<Content>(&text).map_or(true, |content| !content.owner.has_ended())
    })
}

/// The newest generation of a claim; 0 if there is none.
fn newest(folder: &Path, name: &str) -> u64 {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let generation = |entry: fs::DirEntry| {
        let file = entry.file_name();
        let (own, number) = file.to_str()?.rsplit_once('.')?;
        if own == name { number.parse::<u64>().ok() } else { None }
    };
    entries.filter_map(generation).max().unwrap_or(0)
}

fn read(path: &Path) -> Option<String> {
    granum_core::input::read_text(path, LARGEST).ok()
}

/// A claim that this process holds until it is dropped.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    overruled: Arc<AtomicBool>,
    over: Arc<AtomicBool>,
    beating: Option<JoinHandle<()>>,
}

impl Claim {
    fn kept(path: PathBuf, above: PathBuf, content: Content, every: Duration) -> Claim {
        let (overruled, over) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let beat =
            Beat { path: path.clone(), above, content, overruled: overruled.clone(), over: over.clone() };
        // Where the system refuses a thread, the claim becomes stale after a while, and another process may take it.
        let beating = thread::Builder::new().spawn(move || beat.go_on(every)).ok();
        Claim { path, overruled, over, beating }
    }

    /// True if another process has taken the claim, since this one did not beat for long: it should end its work.
    pub fn is_overruled(&self) -> bool {
        self.overruled.load(Ordering::Relaxed)
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.beating.take() {
            thread.thread().unpark();
            let _ = thread.join();
        }
        // If it was overruled, its file is gone or counts no more.
        let _ = fs::remove_file(&self.path);
    }
}

/// What the thread of a claim does.
struct Beat {
    path: PathBuf,
    above: PathBuf,
    content: Content,
    overruled: Arc<AtomicBool>,
    over: Arc<AtomicBool>,
}

impl Beat {
    fn go_on(mut self, every: Duration) {
        let mut last = Instant::now();
        while !self.over.load(Ordering::Relaxed) {
            thread::park_timeout(every.saturating_sub(last.elapsed()));
            if last.elapsed() < every {
                continue;
            }
            last = Instant::now();
            if self.above.exists() || !self.is_ours() {
                self.overruled.store(true, Ordering::Relaxed);
                return;
            }
            self.content.beat += 1;
            // A beat that cannot be written is made up by the next one. The file is closed, so that other machines see it.
            let open = OpenOptions::new().write(true).open(&self.path);
            let _ = open.and_then(|mut file| {
                file.write_all(self.content.text().as_bytes())?;
                file.sync_all()
            });
        }
    }

    /// False if the file is gone or has another owner; a file that cannot be read for another reason is still that of this process.
    fn is_ours(&self) -> bool {
        match granum_core::input::read_text(&self.path, LARGEST) {
            Ok(text) => serde_json::from_str::<Content>(&text)
                .map_or(true, |content| content.owner == self.content.owner),
            Err(error) => error.kind() != io::ErrorKind::NotFound,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: ClaimTimes = ClaimTimes { beat: Duration::from_millis(5), stale: Duration::from_millis(60) };

    fn claimant(folder: &Path) -> Claimant {
        Claimant::with_times(folder, "sample 1", TIMES)
    }

    /// A claim as a process of another machine would have left it.
    fn foreign(folder: &Path, generation: u64, beat: u64) {
        let owner = Owner { host: "node12".into(), machine: "elsewhere".into(), ..Owner::here() };
        fs::create_dir_all(folder.join(CLAIMS)).unwrap();
        fs::write(folder.join(CLAIMS).join(format!("sample-1.{generation}")), Content { owner, beat }.text())
            .unwrap();
    }

    fn files(folder: &Path) -> usize {
        fs::read_dir(folder.join(CLAIMS)).unwrap().count()
    }

    #[test]
    fn one_holds_a_claim_until_it_is_dropped() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path();
        let claim = claimant(folder).take().unwrap().unwrap();
        let mut other = claimant(folder);
        let since = Instant::now();
        while since.elapsed() < 3 * TIMES.stale {
            assert!(other.take().unwrap().is_none(), "it beats");
            thread::sleep(Duration::from_millis(2));
        }
        assert!(other.is_at_work() && !claim.is_overruled() && is_claimed(folder, "sample 1"));
        assert!(
            other.holder().contains(&format!("process {} on ", std::process::id())),
            "{}",
            other.holder()
        );
        assert!(Claimant::with_times(folder, "sample 2", TIMES).take().unwrap().is_some(), "another name");
        drop(claim);
        assert!(!is_claimed(folder, "sample 1"));
        drop(other.take().unwrap().unwrap());
        assert_eq!(files(folder), 0);
    }

    /// Of many that find a stale claim, again and again, one takes it over.
    #[test]
    fn a_stale_claim_is_taken_by_one() {
        for round in 0..20 {
            let base = tempfile::tempdir().unwrap();
            let folder = base.path();
            foreign(folder, 1 + round % 3, 7);
            let claims: Vec<Claim> = thread::scope(|scope| {
                let takes = |_| {
                    scope.spawn(|| {
                        let mut one = claimant(folder);
                        let since = Instant::now();
                        while since.elapsed() < 2 * TIMES.stale {
                            if let Some(claim) = one.take().unwrap() {
                                assert!(since.elapsed() >= TIMES.stale, "it was watched for long enough");
                                return Some(claim);
                            }
                        }
                        None
                    })
                };
                let threads: Vec<_> = (0..4).map(takes).collect();
                threads.into_iter().filter_map(|thread| thread.join().unwrap()).collect()
            });
            assert_eq!(claims.len(), 1);
            assert!(!claims[0].is_overruled());
        }
    }

    #[test]
    fn a_claim_that_beats_elsewhere_is_left_and_the_end_of_a_process_here_is_seen() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path();
        let mut one = claimant(folder);
        let since = Instant::now();
        for beat in 0.. {
            foreign(folder, 3, beat);
            assert!(one.take().unwrap().is_none());
            if since.elapsed() > 2 * TIMES.stale {
                break;
            }
        }
        assert!(one.is_at_work());
        // A process of this machine with the same number, but of another time.
        let owner = Owner { began: "1".into(), ..Owner::here() };
        fs::write(folder.join(CLAIMS).join("sample-1.3"), Content { owner, beat: 0 }.text()).unwrap();
        let known = !Owner::here().machine.is_empty();
        assert_eq!(is_claimed(folder, "sample 1"), !known);
        assert_eq!(claimant(folder).take().unwrap().is_some(), known);
    }

    /// One who does not wait for the end of another process finds out whether it lives.
    #[test]
    fn a_claim_of_another_machine_is_watched_before_it_is_taken_or_left() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path();
        let never = || false;
        let held = claimant(folder).take().unwrap().unwrap();
        let slow = ClaimTimes { beat: Duration::from_secs(1000), stale: Duration::from_secs(1000) };
        let mut other = Claimant::with_times(folder, "sample 1", slow);
        assert!(other.take_unless_alive(&never, &|_| ()).unwrap().is_none(), "known at once on this machine");
        drop(held);
        foreign(folder, 1, 0);
        assert!(
            Claimant::with_times(folder, "sample 1", slow)
                .take_unless_alive(&|| true, &|_| ())
                .unwrap()
                .is_none()
        );
        let since = Instant::now();
        let taken = claimant(folder).take_unless_alive(&never, &|_| ()).unwrap();
        assert!(taken.is_some() && since.elapsed() >= TIMES.stale, "it did not beat");
        drop(taken);
        foreign(folder, 1, 0);
        let stop = AtomicBool::new(false);
        thread::scope(|scope| {
            scope.spawn(|| {
                for beat in 1.. {
                    foreign(folder, 1, beat);
                    thread::sleep(Duration::from_millis(5));
                    if stop.load(Ordering::Relaxed) {
                        break;
                    }
                }
            });
            assert!(claimant(folder).take_unless_alive(&never, &|_| ()).unwrap().is_none(), "it beats");
            stop.store(true, Ordering::Relaxed);
        });
    }

    /// Who waits is told for whom, and how long that one has been silent.
    #[test]
    fn the_process_in_the_way_is_named() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path();
        foreign(folder, 2, 0);
        let mut one = claimant(folder);
        assert!(one.take().unwrap().is_none());
        let process = std::process::id();
        let begin = format!("process {process} on node12, which has the claim sample-1.2 and ");
        assert_eq!(one.in_the_way(), format!("{begin}is at work"));
        thread::sleep(3 * TIMES.beat);
        let words = one.in_the_way();
        assert!(words.starts_with(&format!("{begin}has not been heard of for 0 s; after 0 s")), "{words}");
        let told = std::sync::Mutex::new(Vec::new());
        let slow = ClaimTimes { stale: Duration::from_secs(1000), ..TIMES };
        let mut other = Claimant::with_times(folder, "sample 1", slow);
        let since = Instant::now();
        let stops = || since.elapsed() > 10 * TIMES.beat;
        let tell = |words: &str| told.lock().unwrap().push(words.to_string());
        assert!(other.take_unless_alive(&stops, &tell).unwrap().is_none());
        let told = told.into_inner().unwrap();
        assert!(told.len() == 1 && told[0].starts_with("has waited 0 s for process "), "{told:?}");
    }

    #[test]
    fn who_is_overruled_learns_of_it_and_leaves_the_claim_of_the_other() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path();
        let claim = claimant(folder).take().unwrap().unwrap();
        foreign(folder, 2, 0);
        let since = Instant::now();
        while !claim.is_overruled() {
            assert!(since.elapsed() < Duration::from_secs(5));
            thread::sleep(Duration::from_millis(1));
        }
        drop(claim);
        assert!(is_claimed(folder, "sample 1"));
        assert_eq!(files(folder), 1);
        // A claim that is being written by another machine is not yet readable, and counts.
        fs::write(folder.join(CLAIMS).join("sample-1.2"), "").unwrap();
        assert!(is_claimed(folder, "sample 1") && claimant(folder).take().unwrap().is_none());
    }
}
