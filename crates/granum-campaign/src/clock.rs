//! Times for people to read. Nothing is decided by the clock of the machine, which may jump.

use std::time::{Duration, SystemTime};

/// A time as `2026-11-24T09:30:00Z`.
pub fn utc(time: SystemTime) -> String {
    let seconds = time.duration_since(SystemTime::UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    let [year, month, day] = date(days);
    format!("{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z", rest / 3600, rest / 60 % 60, rest % 60)
}

/// Year, month and day of a number of days since 1970, by the Gregorian calendar. Years are counted from March, so that the day of
/// a leap year is the last. Source: E. G. Richards, Mapping Time (Oxford University Press, 1998).
fn date(days: u64) -> [u64; 3] {
    let since_march_of_year_0 = days + 719_468;
    let era = since_march_of_year_0 / 146_097;
    let day_of_era = since_march_of_year_0 % 146_097;
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    [year_of_era + 400 * era + u64::from(month <= 2), month, day]
}

/// A readable duration such as "48 s", "3 min 20 s" or "2 h 05 min".
pub fn readable(time: Duration) -> String {
    let whole = time.as_secs_f64().round() as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

/// A duration as it is written by a user: "90 s", "30 min", "8 h", "2 d"; a number alone is in seconds.
///
/// # Errors
/// A sentence that says what is possible.
pub fn duration(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let seconds = match unit.trim() {
        "" | "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        "d" => 86_400.0,
        _ => return Err("must be a time such as 90 s, 30 min, 8 h or 2 d".into()),
    };
    let number: f64 = number.parse().map_err(|_| "must be a time such as 90 s, 30 min, 8 h or 2 d")?;
    Duration::try_from_secs_f64(number * seconds).map_err(|_| "is too long".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_those_of_the_calendar() {
        let shown = |seconds: u64| utc(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(shown(0), "1970-01-01T00:00:00Z");
        assert_eq!(shown(951_827_696), "2000-02-29T12:34:56Z");
        assert_eq!(shown(1_709_251_199), "2024-02-29T23:59:59Z");
        assert_eq!(shown(4_107_542_400), "2100-03-01T00:00:00Z");
        // A clock before 1970 gives no negative date.
        assert_eq!(utc(SystemTime::UNIX_EPOCH - Duration::from_secs(5)), "1970-01-01T00:00:00Z");
    }

    #[test]
    fn durations_are_read_and_shown() {
        let read = |text: &str| duration(text).unwrap().as_secs();
        assert_eq!(
            [read("90"), read("90 s"), read("1.5min"), read("2 h"), read("1 d")],
            [90, 90, 90, 7200, 86_400]
        );
        for wrong in ["", "h", "5 weeks", "-1 s", "1e3 s", "1..2 s"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
        let shown = |seconds| readable(Duration::from_secs_f64(seconds));
        assert_eq!([shown(47.8), shown(200.0), shown(7500.0)], ["48 s", "3 min 20 s", "2 h 05 min"]);
    }
}
