//! The study of convergence: error against time for samplers, light strategies, hemisphere sampling and Russian roulette.
//!
//! Comes in: scenes and a device. Goes out: a row a variant, number of samples and repeat, each repeat another seed. Each variant
//! differs from the defaults in one choice. All of them are after the same picture, so one reference of the defaults serves all; the
//! box filter, the scene's bounces.

use std::collections::BTreeSet;

use crate::Result;
use crate::compare::relative_error::mean;
use crate::gpu::Context;
use crate::render::Tuning;
use crate::report::{Axis, Block, Chart, Fit, Point, Series, axis};
use crate::settings::{Hemisphere, Lights, Roulette, Sampler, Settings};
use crate::study::engine::schedule::interleaved;
use crate::study::engine::spread::digits;
use crate::study::engine::subject::Subjects;
use crate::study::engine::summary::{Summary, Table};
use crate::study::engine::{Kind, Plan, Row, Rows, Scenes, Step, Study, Values, Watch};

/// What is stated of it.
pub const KIND: Kind = Kind {
    name: "convergence",
    help: "Error against time for samplers, light strategies, hemisphere sampling and roulette",
    title: "Error against time",
    scenes: Scenes::Chosen { full: &["cornell-box", "cornell-glass", "bunny"], quick: &["cornell-box"] },
    summary: |rows, _| summary(rows),
    opens: |context, plan, _| Ok(Box::new(Convergence::new(context, plan)?)),
};

/// A variant by its name, and what it changes.
type Variant = (&'static str, fn(&mut Settings));

/// The variants; the first has the defaults.
const VARIANTS: [Variant; 8] = [
    ("default", |_| ()),
    ("sampler independent", |settings| settings.sampler = Sampler::Independent),
    ("sampler table", |settings| settings.sampler = Sampler::Table),
    ("lights area", |settings| settings.lights = Lights::Area),
    ("lights bsdf", |settings| settings.lights = Lights::Bsdf),
    ("hemisphere uniform", |settings| settings.hemisphere = Hemisphere::Uniform),
    ("roulette off", |settings| settings.roulette = Roulette::Off),
    ("roulette 0.7", |settings| settings.roulette = Roulette::Fixed(0.7)),
];
/// Relative MSE of a picture whose relative RMSE is 1 %.
const ONE_PER_CENT: f64 = 1e-4;

/// How much is measured.
struct ConvergenceWorkload {
    size: [u32; 2],
    /// Samples a pixel.
    levels: &'static [u32],
    repeats: u32,
    reference_spp: u32,
}

const FULL: ConvergenceWorkload =
    ConvergenceWorkload { size: [96, 72], levels: &[16, 32, 64, 128, 256, 512, 1024], repeats: 3, reference_spp: 8192 };
const QUICK: ConvergenceWorkload =
    ConvergenceWorkload { size: [64, 48], levels: &[16, 64, 256, 1024], repeats: 2, reference_spp: 4096 };
const LEAST: ConvergenceWorkload =
    ConvergenceWorkload { size: [8, 6], levels: &[16, 32, 64], repeats: 1, reference_spp: 128 };

/// The study.
pub struct Convergence {
    subjects: Subjects,
    workload: ConvergenceWorkload,
}

impl Convergence {
    /// The study of the plan's scenes.
    pub fn new(context: &Context, plan: &Plan) -> Result<Convergence> {
        let workload = plan.amount.of(FULL, QUICK, LEAST);
        Ok(Convergence { subjects: Subjects::new(context, &plan.scenes)?, workload })
    }

    /// Variant and samples of a case.
    fn parts(&self, case: usize) -> (Variant, u32) {
        let levels = self.workload.levels;
        (VARIANTS[case / levels.len()], levels[case % levels.len()])
    }
}

fn name(variant: &str, spp: u32) -> String {
    format!("{variant}, {spp} spp")
}

impl Study for Convergence {
    fn scenes(&self) -> &[String] {
        self.subjects.names()
    }

    fn case(&self, case: usize) -> String {
        let ((variant, _), spp) = self.parts(case);
        name(variant, spp)
    }

    fn schedule(&self) -> Vec<Step> {
        let cases: Vec<usize> = (0..VARIANTS.len() * self.workload.levels.len()).collect();
        interleaved(self.subjects.names().len(), &cases, self.workload.repeats)
    }

    fn measure(&mut self, step: Step, watch: &mut dyn Watch) -> Result<Option<Values>> {
        let ((_, change), spp) = self.parts(step.case);
        let subject = self.subjects.at(step.scene)?;
        let defaults = subject.settings(self.workload.size, spp);
        let reference = Settings { spp: self.workload.reference_spp, ..defaults.clone() };
        let mut settings = Settings { seed: u64::from(step.repeat), ..defaults };
        change(&mut settings);
        let Some(rendered) = subject.render_warm(&settings, &Tuning::default(), watch)? else { return Ok(None) };
        let Some(reference) = subject.reference(&reference, watch)? else { return Ok(None) };
        let picture = rendered.film.mean();
        let error = reference.relative_mse(&picture)?;
        Ok(Some(vec![
            ("spp", f64::from(spp)),
            ("pixels", picture.len() as f64),
            ("seconds", rendered.report.seconds.render),
            ("relative_mse", error),
            ("relative_mse_spp", error * f64::from(spp)),
            ("mean_to_reference", mean(&picture) / mean(&reference.mean)),
            ("rays_per_path", rendered.report.rays as f64 / rendered.report.paths as f64),
            ("table_wraps", rendered.report.table_wraps as f64),
        ]))
    }

    fn headline(&self, row: &Row) -> String {
        let figure = |name: &str| row.values.get(name).copied().unwrap_or(f64::NAN);
        let error = 100.0 * figure("relative_mse").max(0.0).sqrt();
        format!("in {} s: relative RMSE {} %", digits(figure("seconds")), digits(error))
    }
}

/// What the rows say of a variant on a scene.
struct Curve {
    name: &'static str,
    /// Error by samples, each repeat a point.
    fit: Fit,
    /// Of a sample of every pixel, from the largest number of samples.
    seconds_a_sample: f64,
    /// Relative MSE times samples at the largest number.
    relative_mse_spp: f64,
}

impl Curve {
    fn of(rows: &Rows, scene: &str, variant: &'static str, levels: &[u32]) -> Option<Curve> {
        let mut points = Vec::new();
        for &spp in levels {
            let errors = rows.values(scene, &name(variant, spp), "relative_mse").collect::<Vec<_>>();
            points.extend(errors.into_iter().map(|error| Point::new(f64::from(spp), error)));
        }
        let most = *levels.last()?;
        let median = |value| rows.median(scene, &name(variant, most), value);
        Some(Curve {
            name: variant,
            fit: Fit::of(&points)?,
            seconds_a_sample: median("seconds")? / f64::from(most),
            relative_mse_spp: median("relative_mse_spp")?,
        })
    }

    /// Seconds until the relative RMSE is 1 %, by the fitted law.
    fn seconds_to_one_per_cent(&self) -> f64 {
        let spp = 10f64.powf((ONE_PER_CENT.log10() - self.fit.intercept) / self.fit.slope);
        spp * self.seconds_a_sample
    }
}

/// The numbers of samples that were measured of a scene.
fn levels(rows: &Rows, scene: &str) -> Vec<u32> {
    let of_scene = rows.all().iter().filter(|row| row.scene == scene);
    let levels: BTreeSet<u32> = of_scene.filter_map(|row| Some(*row.values.get("spp")? as u32)).collect();
    levels.into_iter().collect()
}

/// What the rows say.
pub fn summary(rows: &Rows) -> Summary {
    let mut summary = Summary::default();
    for scene in rows.scenes() {
        let levels = levels(rows, scene);
        let curves: Vec<Curve> =
            VARIANTS.iter().filter_map(|(variant, _)| Curve::of(rows, scene, variant, &levels)).collect();
        let pixels = levels.last().and_then(|&most| rows.median(scene, &name(VARIANTS[0].0, most), "pixels"));
        let size = pixels.map_or(String::new(), |pixels| format!(" ({pixels:.0} pixels)"));
        let title = format!(
            "{scene}: relative MSE by samples as a power law; milliseconds of a sample of every pixel; seconds to 1 % relative RMSE{size}"
        );
        let mut table = Table::new(title, &["choice", "slope (95 %)", "ms", "relMSE*spp", "s to 1 %", "ratio"]);
        let first = curves.first().filter(|curve| curve.name == VARIANTS[0].0).map(Curve::seconds_to_one_per_cent);
        for curve in &curves {
            let seconds = curve.seconds_to_one_per_cent();
            table.rows.push(vec![
                curve.name.into(),
                slope(curve),
                digits(1e3 * curve.seconds_a_sample),
                digits(curve.relative_mse_spp),
                digits(seconds),
                first.map_or("?".into(), |first| digits(seconds / first)),
            ]);
        }
        summary.figure(chart(rows, scene, &levels));
        summary.table(table);
        summary.findings.extend(finding(scene, &curves));
        summary.plain.extend(plain(scene, &curves));
    }
    summary
}

/// Error against time, a series a variant.
fn chart(rows: &Rows, scene: &str, levels: &[u32]) -> Block {
    let series = |variant: &str| {
        let point = |&spp: &u32| {
            let of = |value| rows.spread(scene, &name(variant, spp), value);
            Some(of("relative_mse")?.point(of("seconds")?.median))
        };
        Series::new(variant, levels.iter().filter_map(point).collect()).fitted().default_if(variant == VARIANTS[0].0)
    };
    Block::Chart(Chart {
        title: format!("{scene}: error against time"),
        x: Axis::new("time", "s", axis::Scale::Log),
        y: Axis::new("relative MSE", "", axis::Scale::Log),
        series: VARIANTS.map(|(variant, _)| series(variant)).into(),
    })
}

/// A slope with its 95 % interval.
fn slope(curve: &Curve) -> String {
    format!("{:.2} ({:.2} to {:.2})", curve.fit.slope, curve.fit.slope_low, curve.fit.slope_high)
}

fn plain(scene: &str, curves: &[Curve]) -> Option<String> {
    let default = curves.iter().find(|curve| curve.name == VARIANTS[0].0)?;
    let times = |curve: &Curve| curve.seconds_to_one_per_cent() / default.seconds_to_one_per_cent();
    let seconds = digits(default.seconds_to_one_per_cent());
    let mut others: Vec<&Curve> = curves.iter().filter(|curve| curve.name != default.name).collect();
    others.sort_by(|a, b| times(a).total_cmp(&times(b)));
    let (Some(best), Some(worst)) = (others.first(), others.last()) else {
        return Some(format!("{scene}: an error of 1 % takes {seconds} s with the defaults."));
    };
    Some(format!(
        "{scene}: an error of 1 % takes {seconds} s with the defaults; with one choice changed, from {} times as long \
         ({}) to {} \
         times ({}).",
        digits(times(best)),
        best.name,
        digits(times(worst)),
        worst.name
    ))
}

fn finding(scene: &str, curves: &[Curve]) -> Option<String> {
    let default = curves.iter().find(|curve| curve.name == VARIANTS[0].0)?;
    let slope =
        |curve: &Curve| format!("{:.2} ({:.2} to {:.2})", curve.fit.slope, curve.fit.slope_low, curve.fit.slope_high);
    let mut text = format!(
        "{scene}: with the defaults the squared error falls as samples to the power {}, to 1 % in {} s",
        slope(default),
        digits(default.seconds_to_one_per_cent())
    );
    if let Some(independent) = curves.iter().find(|curve| curve.name == "sampler independent") {
        text += &format!("; with independent samples {}", slope(independent));
    }
    let others = curves.iter().filter(|curve| curve.name != default.name);
    let times = |curve: &Curve| curve.seconds_to_one_per_cent() / default.seconds_to_one_per_cent();
    if let Some(dearest) = others.max_by(|a, b| times(a).total_cmp(&times(b))) {
        text += &format!("; the dearest single change is {}, {} times the time", dearest.name, digits(times(dearest)));
    }
    Some(text + ".")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors of two variants that fall as powers of -1 and -0.5 of the samples, with both repeats 10 % off the law.
    fn rows(levels: &[u32]) -> Rows {
        let mut figures = Vec::new();
        for (variant, power) in [("default", -1.0f64), ("sampler independent", -0.5)] {
            for &spp in levels {
                for (repeat, off) in [(0, 1.1), (1, 1.0 / 1.1)] {
                    let error = 0.08 * f64::from(spp).powf(power) * off;
                    let values = [
                        ("spp", f64::from(spp)),
                        ("relative_mse", error),
                        ("relative_mse_spp", error * f64::from(spp)),
                        ("seconds", 0.01 * f64::from(spp)),
                    ];
                    figures.push((name(variant, spp), repeat, values));
                }
            }
        }
        let rows: Vec<_> =
            figures.iter().map(|(case, repeat, values)| ("box", case.as_str(), *repeat, &values[..])).collect();
        Rows::synthetic(&rows)
    }

    #[test]
    fn slopes_and_times_are_those_of_the_law() {
        let rows = rows(QUICK.levels);
        let curve = Curve::of(&rows, "box", "default", QUICK.levels).unwrap();
        assert!((curve.fit.slope + 1.0).abs() < 1e-9, "{:?}", curve.fit);
        // 0.08 / n = 10^-4 at 800 samples of 0.01 s.
        assert!((curve.seconds_to_one_per_cent() - 8.0).abs() < 1e-6);
        assert!(Curve::of(&rows, "box", "lights area", QUICK.levels).is_none());
        let summary = summary(&rows);
        // 0.08 / sqrt(n) = 10^-4 at 640,000 samples: 800 times as many.
        assert_eq!(summary.tables()[0].rows[1][4..], ["6400", "800"]);
        let finding = &summary.findings[0];
        assert!(
            finding.contains("power -1.00 (-1.0") && finding.contains("sampler independent, 800 times"),
            "{finding}"
        );
        assert!(summary.lines().iter().all(|line| line.chars().count() <= 80), "{:#?}", summary.lines());
    }
}
