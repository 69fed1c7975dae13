//! How far a render has come, on stderr: a bar on a terminal, a plain line every 10 s elsewhere, nothing under `-q`.
//!
//! Comes in: [`Progress`] several times a second. Goes out: text, and the wish to stop where a signal asked for it.

use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use texray::render::{Observer, Progress};

use super::signals::Signals;
use super::streams::say;

/// Time between plain lines.
const LINE_EVERY: Duration = Duration::from_secs(10);
/// Steps of the bar.
const BAR_STEPS: f64 = 1e4;
/// Columns of a terminal that does not tell.
const COLUMNS: usize = 80;
/// Seconds of rendering, and least share of a time limit, that a remaining time can be told from.
const FORESEEABLE: (f64, f64) = (1.0, 1e-3);
/// A remaining time beyond this says no more than that it is not known, in seconds: ten years.
const UNFORESEEABLE: f64 = 10.0 * 365.0 * 86400.0;

/// Shows progress and passes on the wish to stop.
pub struct Reporter {
    shown: Shown,
    signals: Signals,
}

enum Shown {
    Bar(ProgressBar),
    Lines { last: Instant },
    Nothing,
}

impl Reporter {
    /// A bar or lines, as stderr is; nothing if `quiet`.
    pub fn new(quiet: bool, signals: Signals) -> Reporter {
        let shown = match (quiet, stderr().is_terminal()) {
            (true, _) => Shown::Nothing,
            (false, true) => {
                let bar = ProgressBar::with_draw_target(Some(BAR_STEPS as u64), ProgressDrawTarget::stderr());
                Shown::Bar(bar)
            }
            (false, false) => Shown::Lines { last: Instant::now() },
        };
        Reporter { shown, signals }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        if let Shown::Bar(bar) = &self.shown {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Reporter {
    fn progress(&mut self, progress: &Progress) {
        match &mut self.shown {
            Shown::Bar(bar) => {
                let columns = terminal_size::terminal_size_of(stderr()).map_or(COLUMNS, |(width, _)| width.0.into());
                let length = bar_length(columns);
                // The terminal may have been resized: the style goes by its width of now.
                if let Ok(style) = ProgressStyle::with_template(&format!("{{bar:{length}}} {{msg}}")) {
                    bar.set_style(style);
                }
                bar.set_position((progress.fraction.clamp(0.0, 1.0) * BAR_STEPS) as u64);
                bar.set_message(line(progress, columns.saturating_sub(length + 2)));
            }
            Shown::Lines { last } if last.elapsed() >= LINE_EVERY => {
                *last = Instant::now();
                say(&line(progress, usize::MAX));
            }
            Shown::Lines { .. } | Shown::Nothing => {}
        }
    }

    fn stop_requested(&self) -> bool {
        self.signals.received().is_some()
    }
}

/// Columns of the bar on a terminal of so many.
fn bar_length(columns: usize) -> usize {
    (columns / 8).clamp(6, 24)
}

/// Where the render stands, in at most `columns` columns: what matters least is left out first, the time left never.
fn line(progress: &Progress, columns: usize) -> String {
    // Floored, so that 100 % means done.
    let share = format!("{:3.0} %", (progress.fraction.clamp(0.0, 1.0) * 100.0).floor());
    let spp = format!("{}{} spp", progress.spp_done, of(progress.spp_target));
    let speed = (progress.seconds > 0.0 && progress.paths > 0)
        .then(|| format!("{:.2} Mpaths/s", progress.paths as f64 / progress.seconds / 1e6));
    let error = progress.relative_rmse.map(|error| format!("error {}", percent(error)));
    let left = left(progress);
    let short = format!("{} spp", progress.spp_done);
    let joined = |spp: Option<&String>, speed: Option<&String>, error: Option<&String>| {
        [Some(&share), spp, speed, error, left.as_ref()].into_iter().flatten().cloned().collect::<Vec<_>>().join(", ")
    };
    let (speed, error) = (speed.as_ref(), error.as_ref());
    [
        joined(Some(&spp), speed, error),
        joined(Some(&spp), None, error),
        joined(Some(&spp), None, None),
        joined(Some(&short), None, None),
    ]
    .into_iter()
    .find(|line| line.chars().count() <= columns)
    .unwrap_or_else(|| joined(None, None, None))
}

/// ` of N` where there is an end by samples.
fn of(spp_target: u32) -> String {
    if spp_target == u32::MAX { String::new() } else { format!(" of {spp_target}") }
}

/// The time left in words, once it is known: by the forecast of the target, else by the share of the work that is done.
fn left(progress: &Progress) -> Option<String> {
    let seconds = progress.seconds;
    if let Some((target, Some(forecast))) = progress.target {
        let left = (forecast.seconds - seconds).max(0.0);
        return (left < UNFORESEEABLE).then(|| format!("{} in about {}", percent(target.error), duration(left)));
    }
    // Until a sample is finished, a time limit tells nothing of the end: the first sample is always finished.
    let fraction = progress.fraction.clamp(0.0, 1.0);
    // Without an end by samples, the share is that of a time limit, or next to nothing.
    let least = if progress.spp_target == u32::MAX { FORESEEABLE.1 } else { f64::MIN_POSITIVE };
    let known = seconds >= FORESEEABLE.0 && fraction >= least && progress.spp_done > 0;
    let left = seconds * (1.0 - fraction) / fraction;
    (known && left < UNFORESEEABLE).then(|| format!("{} left", duration(left)))
}

/// A ratio as a percentage of three significant digits.
pub fn percent(ratio: f64) -> String {
    let percent = ratio * 100.0;
    match percent {
        0.0 => "0 %".into(),
        1e-3..100.0 => format!("{percent:.*} %", (2.0 - percent.log10().floor()) as usize),
        100.0..1e6 => format!("{percent:.0} %"),
        _ => format!("{percent:.2e} %"),
    }
}

/// Seconds in words.
pub fn duration(seconds: f64) -> String {
    match seconds {
        0.0..60.0 => format!("{seconds:.1} s"),
        60.0..3600.0 => format!("{} min {:02} s", (seconds / 60.0) as u64, (seconds % 60.0) as u64),
        3600.0..360_000.0 => format!("{} h {:02} min", (seconds / 3600.0) as u64, (seconds % 3600.0 / 60.0) as u64),
        360_000.0..UNFORESEEABLE => format!("{:.0} days", seconds / 86400.0),
        _ => "more than 10 years".into(),
    }
}

#[cfg(test)]
mod tests {
    use texray::render::{Forecast, Target};

    use super::*;

    #[test]
    fn a_line_tells_it_all() {
        let progress = Progress {
            spp_done: 128,
            spp_target: 256,
            fraction: 0.5099,
            paths: 6_200_000,
            seconds: 20.0,
            relative_rmse: Some(0.0234),
            target: None,
        };
        let line = |progress: &Progress| line(progress, usize::MAX);
        assert_eq!(line(&progress), " 50 %, 128 of 256 spp, 0.31 Mpaths/s, error 2.34 %, 19.2 s left");
        let target = Target { error: 0.01, confidence: 0.95 };
        let forecast = Forecast { made_at_spp: 32, spp: 1024, seconds: 203.0 };
        let open = Progress { spp_target: u32::MAX, fraction: 0.0, target: Some((target, None)), ..progress };
        assert_eq!(line(&open), "  0 %, 128 spp, 0.31 Mpaths/s, error 2.34 %");
        let forecast = Progress { spp_target: 1024, target: Some((target, Some(forecast))), ..progress };
        assert_eq!(line(&forecast), " 50 %, 128 of 1024 spp, 0.31 Mpaths/s, error 2.34 %, 1.00 % in about 3 min 03 s");
        assert_eq!(line(&Progress { spp_target: 4, ..Progress::default() }), "  0 %, 0 of 4 spp");
    }

    /// Of 2^32 - 1 samples without another rule, in the first moment, and of a time limit that the first sample
    /// overruns.
    #[test]
    fn no_time_left_is_told_before_it_is_known() {
        let target = Target { error: 0.01, confidence: 0.95 };
        let begun =
            Progress { spp_done: 16, spp_target: u32::MAX, fraction: 4e-9, seconds: 5.0, ..Progress::default() };
        let first = Progress { spp_done: 0, fraction: 1.0, seconds: 9.0, ..begun };
        let moment = Progress { spp_done: 1, spp_target: 256, fraction: 0.004, seconds: 0.2, ..begun };
        let hopeless = Forecast { made_at_spp: 32, spp: 1 << 32, seconds: 1e12 };
        for unknown in [
            begun,
            Progress { target: Some((target, None)), ..begun },
            first,
            moment,
            Progress { target: Some((target, Some(hopeless))), ..begun },
            Progress::default(),
        ] {
            let line = line(&unknown, usize::MAX);
            assert!(!line.contains("left") && !line.contains("about") && !line.contains("Mpaths"), "{line}");
        }
        let known = Progress { spp_done: 1, fraction: 0.25, seconds: 2.0, ..begun };
        assert_eq!(line(&known, usize::MAX), " 25 %, 1 spp, 6.0 s left");
    }

    #[test]
    fn a_narrow_terminal_keeps_the_time_left() {
        let progress = Progress {
            spp_done: 960,
            spp_target: 2048,
            fraction: 0.47,
            paths: 6_200_000,
            seconds: 600.0,
            relative_rmse: Some(0.0107),
            target: None,
        };
        let target = Target { error: 0.01, confidence: 0.95 };
        let forecast = Forecast { made_at_spp: 32, spp: 2048, seconds: 99_000.0 };
        let to_target = Progress { target: Some((target, Some(forecast))), ..progress };
        for columns in 1..200 {
            let room = usize::saturating_sub(columns, bar_length(columns) + 2);
            for (progress, left) in [(progress, "11 min 16 s left"), (to_target, "1.00 % in about 27 h 20 min")] {
                let line = line(&progress, room);
                assert!(line.ends_with(left), "{line}");
                assert!(columns < 45 || line.chars().count() <= room, "{columns}: {line}");
            }
        }
        assert_eq!(line(&progress, 69), " 47 %, 960 of 2048 spp, 0.01 Mpaths/s, error 1.07 %, 11 min 16 s left");
        assert_eq!(line(&progress, 68), " 47 %, 960 of 2048 spp, error 1.07 %, 11 min 16 s left");
        assert_eq!(line(&progress, 53), " 47 %, 960 of 2048 spp, 11 min 16 s left");
        assert_eq!(line(&progress, 39), " 47 %, 960 spp, 11 min 16 s left");
    }

    #[test]
    fn figures_in_words() {
        assert_eq!(percent(0.0), "0 %");
        assert_eq!(percent(0.012345), "1.23 %");
        assert_eq!(percent(0.12345), "12.3 %");
        assert_eq!(percent(0.00012345), "0.0123 %");
        assert_eq!(percent(1.5), "150 %");
        assert_eq!(percent(f64::NAN), "NaN %");
        assert_eq!(duration(3.16), "3.2 s");
        assert_eq!(duration(125.0), "2 min 05 s");
        assert_eq!(duration(7260.0), "2 h 01 min");
        assert_eq!(duration(400_000.0), "5 days");
        assert_eq!(duration(f64::INFINITY), "more than 10 years");
    }
}
