//! Speed of a stage and its remaining time.

use std::time::Duration;

/// Below this share or this time the rate is too uncertain.
const TOO_EARLY: (f64, Duration) = (0.01, Duration::from_secs(1));

/// The pace of one stage, from its first report.
#[derive(Debug, Clone, PartialEq)]
pub struct Pace {
    pub stage: String,
    began: Duration,
    share_at_begin: f64,
}

impl Pace {
    pub fn new(stage: &str, now: Duration, share: f64) -> Pace {
        Pace { stage: stage.to_owned(), began: now, share_at_begin: share }
    }

    /// Share, rate and remaining time as text: `43 %  2.1 %/s  27 s left`. An incomplete stage is never at 100
    /// %, and before its first report it has neither rate nor remaining time.
    pub fn words(&self, now: Duration, share: f64) -> String {
        let elapsed = now.saturating_sub(self.began);
        let done = share - self.share_at_begin;
        let percent = (100.0 * share.clamp(0.0, 1.0)).floor().min(99.0);
        if done < TOO_EARLY.0 || elapsed < TOO_EARLY.1 || share >= 1.0 {
            return format!("{percent:.0} %  {}", clock(elapsed));
        }
        let rate = done / elapsed.as_secs_f64();
        let left = Duration::from_secs_f64(((1.0 - share) / rate).clamp(0.0, 1e6));
        let rate = match 100.0 * rate {
            fast if fast >= 1.0 => format!("{fast:.0} %/s"),
            slow if 60.0 * slow >= 1.0 => format!("{:.0} %/min", 60.0 * slow),
            crawling => format!("{:.1} %/min", 60.0 * crawling),
        };
        format!("{percent:.0} %  {rate}  {} left", clock(left))
    }
}

/// `27 s`, `3:05 min`, `2:07 h`.
fn clock(time: Duration) -> String {
    let seconds = time.as_secs_f64().round() as u64;
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{}:{:02} min", seconds / 60, seconds % 60),
        _ => format!("{}:{:02} h", seconds / 3600, seconds / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_and_a_time_left() {
        let at = Duration::from_secs;
        let pace = Pace::new("wear", at(10), 0.0);
        assert_eq!(pace.words(at(10), 0.0), "0 %  0 s");
        assert_eq!(pace.words(at(20), 0.25), "25 %  2 %/s  30 s left");
        assert_eq!(pace.words(at(310), 0.5), "50 %  10 %/min  5:00 min left");
        assert_eq!(pace.words(at(20_010), 0.2), "20 %  0.1 %/min  22:13 h left");
        // A computation that was resumed half-way is judged by its second half.
        assert_eq!(Pace::new("wear", at(0), 0.5).words(at(10), 0.75), "75 %  2 %/s  10 s left");
    }

    #[test]
    fn a_stage_that_is_not_over_is_not_done() {
        let pace = Pace::new("wear", Duration::ZERO, 0.0);
        assert_eq!(pace.words(Duration::from_secs(75), 1.0), "99 %  1:15 min");
        assert!(pace.words(Duration::from_secs(75), 0.999).starts_with("99 %"));
    }
}
