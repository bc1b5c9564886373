//! What is asked of Slurm, by its own programs: `squeue`, `scontrol`, `sacctmgr`, `sbatch`, `scancel`.
//!
//! Sources: their manual pages, of Slurm 22.05.

use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::jobs::Place;
use crate::scheduler::scheduler_error::SchedulerError;

/// An element of an array of jobs that Slurm knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Queued {
    /// The job.
    pub(super) job: String,
    /// The element; `None` for a job that is no array.
    pub(super) element: Option<usize>,
    /// Its place.
    pub(super) place: Place,
    /// Name of the job.
    pub(super) name: String,
    /// Why it waits.
    pub(super) reason: String,
}

/// The limits of the cluster for this user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Limits {
    /// Most elements of an array (`MaxArraySize`): their numbers are below it.
    pub(super) array: usize,
    /// Most jobs at once, each element counted, with the name of the limit (`MaxSubmitJobs` of an association, `MaxJobCount`).
    pub(super) jobs: Option<(usize, &'static str)>,
}

/// The jobs of this user that wait or go on, each element of an array for itself.
pub(super) fn queued() -> Result<Vec<Queued>, SchedulerError> {
    let text = told("squeue", &["--me", "--noheader", "--array", "--format=%F|%K|%T|%j|%r"])?;
    Ok(text.lines().filter_map(queued_line).collect())
}

fn queued_line(line: &str) -> Option<Queued> {
    let mut parts = line.trim().splitn(5, '|');
    let (job, element, state) = (parts.next()?, parts.next()?, parts.next()?);
    // A name may contain the sign, but not those of granum; a reason does not.
    let (name, reason) = (parts.next()?, parts.next()?);
    let place = match state {
        "PENDING" | "CONFIGURING" | "REQUEUED" | "REQUEUE_FED" | "REQUEUE_HOLD" | "RESV_DEL_HOLD"
        | "SPECIAL_EXIT" => Place::Queued,
        "RUNNING" | "COMPLETING" | "SUSPENDED" | "STOPPED" | "SIGNALING" | "STAGE_OUT" | "RESIZING"
        | "PREEMPTED" => Place::Running,
        _ => Place::Over,
    };
    Some(Queued {
        job: job.to_string(),
        element: element.parse().ok(),
        place,
        name: name.to_string(),
        reason: reason.to_string(),
    })
}

/// The limits that the cluster and the associations of this user have.
pub(super) fn limits(account: Option<&str>, partition: Option<&str>) -> Result<Limits, SchedulerError> {
    let config = told("scontrol", &["show", "config"])?;
    // Where no accounts are kept there is no such limit, and the program says so by an error.
    let user = told("id", &["-un"]).unwrap_or_default();
    let show = format!("user={}", user.trim());
    let arguments = [
        "--noheader",
        "--parsable2",
        "show",
        "assoc",
        "where",
        &show,
        "format=Account,Partition,MaxSubmitJobs",
    ];
    let associations = told("sacctmgr", &arguments).unwrap_or_default();
    Ok(limits_in(&config, &associations, account, partition))
}

fn limits_in(config: &str, associations: &str, account: Option<&str>, partition: Option<&str>) -> Limits {
    let number = |key: &str| {
        let line = config.lines().find_map(|line| line.trim_start().strip_prefix(key));
        line?.trim_start().strip_prefix('=')?.split_whitespace().next()?.parse::<usize>().ok()
    };
    let concerns =
        |asked: Option<&str>, found: &str| found.is_empty() || asked.is_none_or(|asked| asked == found);
    let of_association = |line: &str| {
        let mut parts = line.trim().split('|');
        let (own, part, most) = (parts.next()?, parts.next()?, parts.next()?);
        // Without a partition that is named, limits of one partition do not concern all jobs.
        let here = concerns(account, own) && (part.is_empty() || partition == Some(part));
        if here { most.parse::<usize>().ok() } else { None }
    };
    let submit = associations.lines().filter_map(of_association).min().map(|most| (most, "MaxSubmitJobs"));
    let count = number("MaxJobCount").map(|most| (most, "MaxJobCount"));
    // 1001 is the value if none is configured; a cluster with 0 or 1 takes no arrays.
    Limits {
        array: number("MaxArraySize").unwrap_or(1001).max(1),
        jobs: submit.into_iter().chain(count).min_by_key(|(most, _)| *most),
    }
}

/// Submits a script from its folder; returns the number of the job.
pub(super) fn submit(folder: &Path, arguments: &[String], script: &OsStr) -> Result<String, SchedulerError> {
    let mut command = Command::new("sbatch");
    command.arg("--parsable").args(arguments).arg(script).current_dir(folder);
    let text = output("sbatch", &mut command)?;
    // `JOB` or `JOB;CLUSTER`.
    let job = text.lines().next_back().unwrap_or_default().split(';').next().unwrap_or_default().trim();
    if job.is_empty() || !job.chars().all(|c| c.is_ascii_digit()) {
        return Err(SchedulerError::Command {
            command: "sbatch".into(),
            reason: format!("it gave no number of a job: {text}"),
        });
    }
    Ok(job.to_string())
}

/// Ends a job with all of its elements.
pub(super) fn cancel(job: &str) -> Result<(), SchedulerError> {
    told("scancel", &[job]).map(drop)
}

fn told(program: &str, arguments: &[&str]) -> Result<String, SchedulerError> {
    output(program, Command::new(program).args(arguments))
}

fn output(program: &str, command: &mut Command) -> Result<String, SchedulerError> {
    let failed = |reason: String| SchedulerError::Command { command: program.to_string(), reason };
    // The format of times and numbers does not depend on the language of the user.
    let output = command.env("LC_ALL", "C").stdin(Stdio::null()).output().map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => failed(
            "there is no such program; Slurm's programs are needed here, as on the machine of a cluster from which jobs are submitted".into(),
        ),
        _ => failed(error.to_string()),
    })?;
    if !output.status.success() {
        let told = String::from_utf8_lossy(&output.stderr);
        let told = told.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ");
        return Err(failed(if told.is_empty() { output.status.to_string() } else { told }));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_queue_is_read() {
        let text = "12|3|PENDING|granum-ab|JobArrayTaskLimit\n 12|0|RUNNING|granum-ab|None\n13|N/A|COMPLETING|my job|None\n\
                    14|0|PREEMPTED|x|None\n15|1|REQUEUED|x|None\n16|2|TIMEOUT|x|None\nnonsense\n";
        let found: Vec<Queued> = text.lines().filter_map(queued_line).collect();
        assert_eq!(found.len(), 6);
        assert_eq!(
            (found[0].job.as_str(), found[0].element, found[0].reason.as_str()),
            ("12", Some(3), "JobArrayTaskLimit")
        );
        assert_eq!((found[2].name.as_str(), found[2].element), ("my job", None));
        let places: Vec<Place> = found.iter().map(|element| element.place).collect();
        use Place::{Over, Queued as Waits, Running};
        assert_eq!(places, [Waits, Running, Running, Running, Waits, Over]);
    }

    #[test]
    fn the_smallest_limit_that_concerns_the_user_is_kept() {
        let config = "Configuration data as of 2026\nMaxArraySize            = 8\nMaxJobCount             = 10000\nMaxJobId = 5\n";
        let associations = "physics||200\nphysics|short|12\nart||7\nart|long|\n";
        let of = |account, partition| limits_in(config, associations, account, partition);
        assert_eq!(of(None, None), Limits { array: 8, jobs: Some((7, "MaxSubmitJobs")) });
        assert_eq!(of(Some("physics"), None).jobs, Some((200, "MaxSubmitJobs")));
        assert_eq!(of(Some("physics"), Some("short")).jobs, Some((12, "MaxSubmitJobs")));
        assert_eq!(limits_in(config, "", None, None).jobs, Some((10_000, "MaxJobCount")));
        assert_eq!(limits_in("", "", None, None), Limits { array: 1001, jobs: None });
    }
}
