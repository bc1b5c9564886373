//! The script of a job, and the arguments with which it is submitted.

use std::path::Path;
use std::time::Duration;

use granum_io::shell::{quoted, quoted_path};

use crate::scheduler::job_record::{JOBS, JobRecord};
use crate::scheduler::scheduler_trait::SchedulerOptions;

/// The script: the header, then this program with the number of the job and of the element. It takes the place of the shell, so that
/// signals of Slurm reach it.
///
/// It does not say where the campaign is: it is submitted from the folder of jobs, which Slurm tells it. Only commands of a header need the
/// folder in which the user gave the command.
pub(super) fn script(options: &SchedulerOptions, here: &Path, record: &JobRecord) -> String {
    let header = options.header.as_deref().unwrap_or_default();
    let (directives, commands) = divided(header);
    let mut text = String::from("#!/bin/sh\n");
    text += directives;
    if !commands.is_empty() {
        text += &format!("cd {} || exit 1\n", quoted_path(here));
        text += commands;
    }
    let words: Vec<String> = options.arguments.iter().map(|word| quoted(&word.to_string_lossy())).collect();
    text += &format!(
        "exec {} campaign run {} --job {} --element \"$SLURM_ARRAY_TASK_ID\" -- \"${{SLURM_SUBMIT_DIR%/{JOBS}}}\"\n",
        quoted_path(&options.program),
        words.join(" "),
        record.number,
    );
    text
}

/// The lines of a header up to its first command, which alone Slurm reads for `#SBATCH`, and the rest. Both end with a line.
fn divided(header: &str) -> (&str, &str) {
    let mut at = 0;
    for line in header.split_inclusive('\n') {
        if !(line.trim().is_empty() || line.starts_with('#')) {
            break;
        }
        at += line.len();
    }
    header.split_at(at)
}

/// The arguments of `sbatch`.
pub(super) fn arguments(options: &SchedulerOptions, record: &JobRecord, after: &[String]) -> Vec<String> {
    let last = record.elements.len().saturating_sub(1);
    let at_once = options.workers.map_or_else(String::new, |count| format!("%{count}"));
    let mut all = vec![
        format!("--job-name={}", record.name),
        format!("--array=0-{last}{at_once}"),
        // Relative to the folder of jobs, so that signs in its path have no meaning.
        format!("--output={:04}-%a.log", record.number),
        "--open-mode=append".into(),
        // After the failure of a node or a preemption an element goes on by itself.
        "--requeue".into(),
    ];
    all.extend(options.time.map(|time| format!("--time={}", minutes(time))));
    all.extend(options.partition.as_ref().map(|name| format!("--partition={name}")));
    all.extend(options.account.as_ref().map(|name| format!("--account={name}")));
    if !after.is_empty() {
        all.push(format!("--dependency=afterany:{}", after.join(":")));
    }
    all
}

/// A time in whole minutes, the unit of Slurm.
fn minutes(time: Duration) -> u64 {
    time.as_secs().div_ceil(60).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directives_of_a_header_come_before_all_commands() {
        let base = tempfile::tempdir().unwrap();
        let record = JobRecord::new(base.path(), "slurm", vec![Vec::new(); 8]).unwrap();
        let options = SchedulerOptions {
            program: "/opt/my tools/granum".into(),
            arguments: vec!["--checkpoint-every".into(), "30".into()],
            header: Some("#SBATCH --mem-per-cpu=1G\n\n. ./modules.sh\n#SBATCH --nice\n".into()),
            workers: Some(3),
            time: Some(Duration::from_secs(61)),
            partition: Some("short".into()),
            account: Some("physics".into()),
            ..SchedulerOptions::default()
        };
        let text = script(&options, Path::new("/home/it's me"), &record);
        assert_eq!(
            text,
            "#!/bin/sh\n#SBATCH --mem-per-cpu=1G\n\ncd '/home/it'\\''s me' || exit 1\n. ./modules.sh\n#SBATCH --nice\n\
             exec '/opt/my tools/granum' campaign run --checkpoint-every 30 --job 1 --element \"$SLURM_ARRAY_TASK_ID\" -- \
             \"${SLURM_SUBMIT_DIR%/jobs}\"\n"
        );
        let options = SchedulerOptions { header: Some("#SBATCH --nice\n".into()), ..options };
        let text = script(&options, Path::new("/home/me"), &record);
        assert!(text.starts_with("#!/bin/sh\n#SBATCH --nice\nexec "), "{text}");
        let given = arguments(&options, &record, &["12".into(), "13".into()]);
        assert_eq!(
            given[1..],
            [
                "--array=0-7%3",
                "--output=0001-%a.log",
                "--open-mode=append",
                "--requeue",
                "--time=2",
                "--partition=short",
                "--account=physics",
                "--dependency=afterany:12:13"
            ]
        );
        assert_eq!(divided("module load x\n"), ("", "module load x\n"));
        assert_eq!(divided(""), ("", ""));
    }

    /// A script that was moved or copied with its campaign names the campaign where it is now.
    #[cfg(unix)]
    #[test]
    fn a_script_does_not_depend_on_where_its_campaign_is() {
        let base = tempfile::tempdir().unwrap();
        let record = JobRecord::new(base.path(), "slurm", vec![Vec::new()]).unwrap();
        let options = SchedulerOptions { program: "/bin/echo".into(), ..SchedulerOptions::default() };
        let text = script(&options, Path::new("/no such folder"), &record);
        for place in ["/data/study", "/it's elsewhere/jobs/a $(study)"] {
            let mut shell = std::process::Command::new("/bin/sh");
            shell.args(["-c", &text]).env("SLURM_ARRAY_TASK_ID", "3");
            let output = shell.env("SLURM_SUBMIT_DIR", format!("{place}/jobs")).output().unwrap();
            let told = String::from_utf8(output.stdout).unwrap();
            assert_eq!(told, format!("campaign run  --job 1 --element 3 -- {place}\n").replace("  ", " "));
        }
    }
}
