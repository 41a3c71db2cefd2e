//! Time stamps of instruments: counted since 1970 or 1601, or dates with time of day.

/// Seconds per count of a number without unit that counts since 1970 (or, in steps of 100 ns, since 1601): for
/// the years 2000 to 2100 the size distinguishes seconds, milliseconds, microseconds, nanoseconds and these
/// steps.
pub(super) fn unit_by_size(value: f64) -> Option<f64> {
    const YEAR: f64 = 365.25 * 86_400.0;
    let since_1970 = 30.0 * YEAR..130.0 * YEAR;
    let since_1601 = 399.0 * YEAR..499.0 * YEAR;
    let counts = [1.0, 1e-3, 1e-6, 1e-9].into_iter().find(|unit| since_1970.contains(&(value * unit)));
    counts.or_else(|| since_1601.contains(&(value * 1e-7)).then_some(1e-7))
}

/// Whether a field may be a date or a time of day rather than a number.
pub(super) fn looks_like(field: &str) -> bool {
    let field = field.trim();
    field.starts_with(|c: char| c.is_ascii_digit())
        && (field.contains(':') || field.matches('-').count() == 2)
        && field.chars().all(|c| c.is_ascii_alphanumeric() || "-/.:, +".contains(c))
}

/// Seconds since 1970 of `2026-03-03T11:20:53.419`, with a blank for the T, with Z or an offset behind it, or
/// seconds since midnight of `11:20:53,419`.
pub(super) fn seconds(field: &str) -> Option<f64> {
    let field = field.trim();
    let Some((date, time)) = field.split_once(['T', ' ']).filter(|(date, _)| !date.contains(':')) else {
        return time_of_day(field);
    };
    let (time, offset) = match time.trim().find(['Z', '+']).or_else(|| time.rfind('-')) {
        Some(at) => (&time[..at], offset(&time[at..])?),
        None => (time, 0.0),
    };
    Some(days(date)? * 86_400.0 + time_of_day(time)? - offset)
}

fn digits(text: &str, longest: usize) -> Option<f64> {
    let all = !text.is_empty() && text.len() <= longest && text.bytes().all(|byte| byte.is_ascii_digit());
    if all { text.parse().ok() } else { None }
}

/// Days from 1 January 1970 of `2026-03-03`, `2026/03/03` or `03.03.2026`, by the Gregorian calendar.
fn days(date: &str) -> Option<f64> {
    let parts: Vec<&str> = date.split(['-', '/', '.']).collect();
    let [a, b, c] = parts[..] else { return None };
    // In `03/04/2026` the first number may be the day or the month.
    let (year, day) = match (a.len(), c.len()) {
        (4, _) => (a, c),
        (_, 4) if date.contains('.') => (c, a),
        _ => return None,
    };
    let (year, month, day) = (digits(year, 4)?, digits(b, 2)?, digits(day, 2)?);
    if !(1.0..=12.0).contains(&month) || !(1.0..=31.0).contains(&day) {
        return None;
    }
    // With years that begin in March the leap day is the last one.
    let (year, month) = if month > 2.0 { (year, month - 3.0) } else { (year - 1.0, month + 9.0) };
    let leap_days = (year / 4.0).floor() - (year / 100.0).floor() + (year / 400.0).floor();
    let day_of_year = ((153.0 * month + 2.0) / 5.0).floor() + day - 1.0;
    Some(365.0 * year + leap_days + day_of_year - 719_468.0)
}

fn time_of_day(time: &str) -> Option<f64> {
    let parts: Vec<&str> = time.trim().split(':').collect();
    let [hours, minutes, seconds] = parts[..] else { return None };
    let (whole, decimals) = seconds.split_once(['.', ',']).unwrap_or((seconds, "0"));
    let (hours, minutes) = (digits(hours, 2)?, digits(minutes, 2)?);
    let decimals = digits(decimals, 9)? / 10_f64.powi(decimals.len() as i32);
    Some(3600.0 * hours + 60.0 * minutes + digits(whole, 2)? + decimals)
}

/// Seconds of `Z`, `+01:00` or `-0130`.
fn offset(text: &str) -> Option<f64> {
    if text == "Z" {
        return Some(0.0);
    }
    let (sign, rest) = match text.split_at_checked(1)? {
        ("+", rest) => (1.0, rest),
        ("-", rest) => (-1.0, rest),
        _ => return None,
    };
    let plain: String = rest.chars().filter(|c| *c != ':').collect();
    let (hours, minutes) = plain.split_at_checked(2)?;
    let minutes = if minutes.is_empty() { 0.0 } else { digits(minutes, 2)? };
    Some(sign * (3600.0 * digits(hours, 2)? + 60.0 * minutes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_count_from_1970() {
        for (text, right) in [
            ("1970-01-01T00:00:00Z", 0.0),
            ("2000-03-01 00:00:00", 951_868_800.0),
            ("2024-02-29T12:30:15.25", 1_709_209_815.25),
            ("03.03.2026 11:20:53,419", 1_772_536_853.419),
            ("2026/03/03T12:20:53.419+01:00", 1_772_536_853.419),
            ("2026-03-03T09:50:53.419-0130", 1_772_536_853.419),
            ("11:20:53.5", 40_853.5),
        ] {
            assert!((seconds(text).unwrap() - right).abs() < 1e-6, "{text}: {:?}", seconds(text));
            assert!(looks_like(text), "{text}");
        }
        for text in ["", "12", "03/04/2026 11:20:53", "2026-13-01 00:00:00", "2026-01-01T11", "a:b:c", "1.5"]
        {
            assert_eq!(seconds(text), None, "{text}");
        }
    }

    #[test]
    fn units_of_stamps_follow_from_their_size() {
        let now = 1.772e9;
        for unit in [1.0, 1e-3, 1e-6, 1e-9] {
            assert_eq!(unit_by_size(now / unit), Some(unit));
        }
        assert_eq!(unit_by_size(132_907_764_534_190_000.0), Some(1e-7));
        assert_eq!((unit_by_size(0.0), unit_by_size(5e5), unit_by_size(-1.0)), (None, None, None));
    }
}
