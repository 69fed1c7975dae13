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
                if let Ok(style) = ProgressStyle::with_template("{bar:24} {wide_msg}") {
                    bar.set_style(style);
                }
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
                bar.set_position((progress.fraction.clamp(0.0, 1.0) * BAR_STEPS) as u64);
                bar.set_message(line(progress));
            }
            Shown::Lines { last } if last.elapsed() >= LINE_EVERY => {
                *last = Instant::now();
                say(&line(progress));
            }
            Shown::Lines { .. } | Shown::Nothing => {}
        }
    }

    fn stop_requested(&self) -> bool {
        self.signals.received().is_some()
    }
}

fn line(progress: &Progress) -> String {
    let fraction = progress.fraction.clamp(0.0, 1.0);
    // Floored, so that 100 % means done.
    let mut line = format!("{:3.0} %, {}", (fraction * 100.0).floor(), progress.spp_done);
    match progress.spp_target {
        u32::MAX => line += " spp",
        target => line += &format!(" of {target} spp"),
    }
    if progress.seconds > 0.0 {
        line += &format!(", {:.2} Mpaths/s", progress.paths as f64 / progress.seconds / 1e6);
    }
    if let Some(error) = progress.relative_rmse {
        line += &format!(", error {}", percent(error));
    }
    if let Some((target, Some(forecast))) = progress.target {
        let left = (forecast.seconds - progress.seconds).max(0.0);
        line += &format!(", {} in about {}", percent(target.error), duration(left));
    } else if fraction > 0.0 {
        line += &format!(", {} left", duration(progress.seconds * (1.0 - fraction) / fraction));
    }
    line
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
        _ => format!("{} h {:02} min", (seconds / 3600.0) as u64, (seconds % 3600.0 / 60.0) as u64),
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
        assert_eq!(line(&progress), " 50 %, 128 of 256 spp, 0.31 Mpaths/s, error 2.34 %, 19.2 s left");
        let target = Target { error: 0.01, confidence: 0.95 };
        let forecast = Forecast { made_at_spp: 32, spp: 1024, seconds: 203.0 };
        let open = Progress { spp_target: u32::MAX, fraction: 0.0, target: Some((target, None)), ..progress };
        assert_eq!(line(&open), "  0 %, 128 spp, 0.31 Mpaths/s, error 2.34 %");
        let forecast = Progress { spp_target: 1024, target: Some((target, Some(forecast))), ..progress };
        assert_eq!(line(&forecast), " 50 %, 128 of 1024 spp, 0.31 Mpaths/s, error 2.34 %, 1.00 % in about 3 min 03 s");
        assert_eq!(line(&Progress { spp_target: 4, ..Progress::default() }), "  0 %, 0 of 4 spp");
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
        assert_eq!(duration(f64::INFINITY), "18446744073709551615 h 00 min");
    }
}
