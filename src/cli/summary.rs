//! What a render says at its end: warnings, what it cost and what it is worth.

use std::collections::BTreeMap;

use texray::render::{ErrorReport, Sampler};

use super::document::Facts;
use super::progress::{duration, percent};

/// What the user should know whether or not figures are wanted.
pub fn warnings(facts: &Facts) -> Vec<String> {
    let report = facts.report;
    let mut warnings = Vec::new();
    let counted = |counts: &BTreeMap<&str, u64>| {
        let counted = counts.iter().filter(|(_, count)| **count > 0);
        counted.map(|(name, count)| format!("{count} {name}")).collect::<Vec<_>>().join(", ")
    };
    let kinds = counted(&report.invalid_kinds);
    if !kinds.is_empty() {
        let causes = counted(&report.invalid_samples);
        warnings.push(format!("warning: invalid samples were left out: {kinds}; by first cause: {causes}"));
    }
    if report.buffers != facts.settings.buffers {
        warnings
            .push("warning: a record is too large for this device's texel buffers: storage buffers are used".into());
    }
    if report.path_buffers != facts.settings.buffers {
        warnings.push(
            "warning: path states are too large for this device's texel buffers: they are read from storage".into(),
        );
    }
    if facts.empty_pixels > 0 && report.spp > 0 {
        warnings.push(format!("warning: {} pixels have no valid sample and are black", facts.empty_pixels));
    }
    if facts.black && report.spp > 0 && facts.empty_pixels == 0 {
        warnings.push(
            "warning: the picture is black: no path has met light; does the camera see the front of a lamp, or what one \
             lights (lamps emit from the side where their corners turn counter-clockwise)?"
                .into(),
        );
    } else if let Some(error) = report.error.filter(|error| error.heavy_tailed) {
        let share = percent(error.picture.heavy_share);
        warnings.push(format!(
            "warning: heavy tail: 0.1 % of the pixels hold {share} of the squared error; its estimate cannot be relied on"
        ));
    }
    warnings
}

/// What it cost and what it is worth. Half of the error takes 4^(1/p) times the samples, p the sampler's convergence.
pub fn lines(facts: &Facts) -> Vec<String> {
    let report = facts.report;
    let times = 4f64.powf(1.0 / facts.settings.sampler.convergence());
    let error = match facts.relative_rmse {
        Some(error) if error > 0.0 => format!(
            "estimated relative RMSE {}{}; half of it takes {} spp, about {}",
            percent(error),
            bound(report.error),
            (f64::from(report.spp) * times).ceil(),
            duration(report.seconds.render * times)
        ),
        Some(_) if facts.black => "error unknown: the picture is black".into(),
        Some(_) => "estimated relative RMSE 0 %".into(),
        None if facts.settings.sampler == Sampler::Table => {
            "error unknown: a table's replicates are not independent".into()
        }
        None => "error unknown before two blocks of 16 spp".into(),
    };
    let speed = report.paths as f64 / report.seconds.render.max(1e-9) / 1e6;
    let work = format!(
        "{}x{}, {} spp, {} bounces: {} of {} rendering, {speed:.2} Mpaths/s",
        facts.settings.width,
        facts.settings.height,
        report.spp,
        facts.settings.max_bounces,
        duration(report.seconds.render),
        duration(report.seconds.total),
    );
    let bias = facts.cap_bias.map(|bias| {
        format!(
            "bias: the cap of {} bounces cuts off {} (± {}) of the light",
            facts.settings.max_bounces,
            percent(bias.bounce_cap),
            percent(bias.standard_error)
        )
    });
    [work, error].into_iter().chain(bias).collect()
}

/// The error's bound in words.
fn bound(error: Option<ErrorReport>) -> String {
    match error {
        Some(error) if error.upper.is_finite() => {
            format!(", at most {} with {} confidence", percent(error.upper), percent(error.confidence))
        }
        _ => String::new(),
    }
}
