//! When a server is asked again.

use std::time::{Duration, SystemTime};

/// How often one question is sent.
pub(super) const ATTEMPTS: u32 = 3;
/// Longest wait that a server may ask for.
pub(super) const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// Whether a server that answers with `status` may answer otherwise later.
pub(super) const fn is_worth_another_try(status: u16) -> bool {
    matches!(status, 408 | 409 | 429 | 500..=599)
}

/// How long to wait after try `failed` (from 1): `first`, doubled each time, and up to a quarter more so that many workers
/// do not come back at once. The part more follows from `seed`, not from chance: runs can be repeated.
pub(super) fn backoff(first: Duration, failed: u32, seed: &str) -> Duration {
    let base = first * 2_u32.pow(failed.saturating_sub(1).min(6));
    let hash = blake3::hash(format!("{seed} {failed}").as_bytes());
    base + base * u32::from(hash.as_bytes()[0]) / 1024
}

/// What `Retry-After` asks for: seconds, or a date as HTTP writes it (RFC 9110, 5.6.7).
pub(super) fn retry_after(text: &str, now: SystemTime) -> Option<Duration> {
    let text = text.trim();
    if let Ok(seconds) = text.parse::<f64>() {
        return Duration::try_from_secs_f64(seconds).ok();
    }
    let then = SystemTime::UNIX_EPOCH + Duration::from_secs(http_date(text)?);
    Some(then.duration_since(now).unwrap_or_default())
}

/// Unix time of `Sun, 06 Nov 1994 08:49:37 GMT`.
fn http_date(text: &str) -> Option<u64> {
    let (_, text) = text.split_once(", ")?;
    let mut words = text.strip_suffix(" GMT")?.split(' ');
    let day: u64 = words.next()?.parse().ok()?;
    let months = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
    let name = words.next()?;
    let month = months.iter().position(|month| *month == name)? as u64;
    let year: u64 = words.next()?.parse().ok().filter(|year| (1970..=9999).contains(year))?;
    let mut clock = words.next()?.split(':').map(|part| part.parse::<u64>().ok());
    let (hour, minute, second) = (clock.next()??, clock.next()??, clock.next()??);
    if !(1..=31).contains(&day) || hour > 23 || minute > 59 || second > 60 {
        return None;
    }
    // Days since the epoch, with the year beginning in March so that a leap day comes last.
    let (year, month) = if month < 2 { (year - 1, month + 10) } else { (year, month - 2) };
    let days = 365 * year + year / 4 - year / 100 + year / 400 + (153 * month + 2) / 5 + day - 1;
    let days = days.checked_sub(719_468)?;
    Some(86_400 * days + 3600 * hour + 60 * minute + second)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waits_double_and_stay_near_their_base() {
        let first = Duration::from_millis(500);
        for (failed, base) in [(1, 500), (2, 1000), (3, 2000)] {
            let wait = backoff(first, failed, "seed").as_millis();
            assert!((base..=base + base / 4).contains(&wait), "{failed}: {wait}");
            assert_eq!(backoff(first, failed, "seed"), backoff(first, failed, "seed"));
        }
    }

    #[test]
    fn servers_say_when_in_seconds_or_as_a_date() {
        let now = SystemTime::UNIX_EPOCH + Duration::from_secs(784_111_777);
        let after = |text| retry_after(text, now);
        assert_eq!(after(" 7 "), Some(Duration::from_secs(7)));
        assert_eq!(after("0.5"), Some(Duration::from_millis(500)));
        assert_eq!(after("Sun, 06 Nov 1994 08:50:37 GMT"), Some(Duration::from_secs(60)));
        assert_eq!(after("Sun, 06 Nov 1994 08:00:00 GMT"), Some(Duration::ZERO), "gone by");
        for nonsense in [
            "-1",
            "soon",
            "NaN",
            "1e300",
            "Sun, 06 Nov 1994",
            "x, 1 Foo 2000 1:1:1 GMT",
            ", 1 Jan 1 1:1:1 GMT",
        ] {
            assert_eq!(after(nonsense), None, "{nonsense}");
        }
        assert_eq!(http_date("Tue, 29 Feb 2000 00:00:00 GMT"), Some(951_782_400));
        assert_eq!(http_date("Thu, 01 Jan 1970 00:00:00 GMT"), Some(0));
    }
}
