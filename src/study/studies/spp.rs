//! The study of samples: what a picture looks like, how wrong it is and what it takes after 1 to 1,500 samples a pixel (thesis,
//! figures 4.7 and 4.8).
//!
//! Comes in: scenes and a device. Goes out: a row a number of samples and repeat, each repeat another seed; the first repeat's
//! pictures. The error is against a reference of twice as many samples as the largest, box filter, the scene's bounces.

use std::path::Path;

use crate::Result;
use crate::gpu::Context;
use crate::render::Tuning;
use crate::report::{Axis, Block, Chart, Point, Series, axis};
use crate::settings::Settings;
use crate::study::engine::gallery::Gallery;
use crate::study::engine::schedule::interleaved;
use crate::study::engine::spread::digits;
use crate::study::engine::subject::Subjects;
use crate::study::engine::summary::{Summary, Table};
use crate::study::engine::{Kind, Plan, Row, Rows, Scenes, Step, Study, Values, Watch};

/// What is stated of it.
pub const KIND: Kind = Kind {
    name: "spp",
    help: "Pictures, error and time at 1 to 1,500 samples a pixel",
    title: "Samples a pixel",
    scenes: Scenes::Chosen { full: &["cornell-box", "cornell-glass"], quick: &["cornell-box"] },
    summary,
    opens: |context, plan, _| Ok(Box::new(Spp::new(context, plan)?)),
};

/// Samples a pixel.
const SPP: [u32; 6] = [1, 10, 50, 200, 1000, 1500];
/// Samples of the reference.
const REFERENCE_SPP: u32 = 3000;

/// How much is measured.
struct SppWorkload {
    size: [u32; 2],
    repeats: u32,
}

const FULL: SppWorkload = SppWorkload { size: [160, 120], repeats: 3 };
const QUICK: SppWorkload = SppWorkload { size: [128, 96], repeats: 2 };
const LEAST: SppWorkload = SppWorkload { size: [8, 6], repeats: 1 };

/// The study.
pub struct Spp {
    subjects: Subjects,
    gallery: Gallery,
    workload: SppWorkload,
}

impl Spp {
    /// The study of the plan's scenes.
    pub fn new(context: &Context, plan: &Plan) -> Result<Spp> {
        Ok(Spp {
            subjects: Subjects::new(context, &plan.scenes)?,
            gallery: Gallery::new(&plan.folder, "spp"),
            workload: plan.amount.of(FULL, QUICK, LEAST),
        })
    }
}

impl Study for Spp {
    fn scenes(&self) -> &[String] {
        self.subjects.names()
    }

    fn case(&self, case: usize) -> String {
        SPP[case].to_string()
    }

    fn schedule(&self) -> Vec<Step> {
        interleaved(self.subjects.names().len(), &[0, 1, 2, 3, 4, 5], self.workload.repeats)
    }

    fn measure(&mut self, step: Step, watch: &mut dyn Watch) -> Result<Option<Values>> {
        let (size, spp) = (self.workload.size, SPP[step.case]);
        let subject = self.subjects.at(step.scene)?;
        let settings = Settings { seed: u64::from(step.repeat), ..subject.settings(size, spp) };
        let Some(rendered) = subject.render_warm(&settings, &Tuning::default(), watch)? else { return Ok(None) };
        let picture = rendered.film.mean();
        let reference = Settings { spp: REFERENCE_SPP, ..settings };
        let Some(reference) = subject.reference(&reference, watch)? else { return Ok(None) };
        let error = reference.relative_mse(&picture)?;
        let mut values = vec![
            ("spp", f64::from(spp)),
            ("seconds", rendered.report.seconds.render),
            ("relative_mse", error),
            ("mpaths_per_second", rendered.report.paths as f64 / rendered.report.seconds.render / 1e6),
        ];
        // What the program itself says of its error, where it can.
        values.extend(rendered.report.relative_rmse.map(|estimate| ("relative_rmse_estimated", estimate)));
        if step.repeat == 0 {
            let (scene, case) = (subject.scene.name.clone(), format!("{spp:04}"));
            self.gallery.keep(&scene, &case, size, &picture)?;
            if spp == SPP[SPP.len() - 1] {
                self.gallery.keep(&scene, "reference", size, &reference.mean)?;
            }
        }
        Ok(Some(values))
    }

    fn headline(&self, row: &Row) -> String {
        let figure = |name: &str| row.values.get(name).copied().unwrap_or(f64::NAN);
        format!("spp: {} s, relative RMSE {}", digits(figure("seconds")), percent(figure("relative_mse")))
    }
}

/// The root of a relative MSE in per cent.
fn percent(relative_mse: f64) -> String {
    format!("{} %", digits(100.0 * relative_mse.max(0.0).sqrt()))
}

/// What the rows say.
pub fn summary(rows: &Rows, folder: &Path) -> Summary {
    let gallery = Gallery::new(folder, "spp");
    let mut summary = Summary::default();
    for scene in rows.scenes() {
        let title = format!("{scene}: error by samples a pixel");
        let mut table = Table::new(title, &["spp", "seconds", "range", "relative RMSE", "its own estimate"]);
        let of = |spp: u32, value: &str| rows.median(scene, &spp.to_string(), value);
        for spp in SPP {
            let Some(seconds) = rows.spread(scene, &spp.to_string(), "seconds") else { continue };
            table.rows.push(vec![
                spp.to_string(),
                digits(seconds.median),
                format!("{} to {}", digits(seconds.least), digits(seconds.most)),
                of(spp, "relative_mse").map_or("?".into(), percent),
                of(spp, "relative_rmse_estimated").map_or("-".into(), |e| format!("{} %", digits(100.0 * e))),
            ]);
        }
        summary.figure(chart(rows, scene));
        let reference = ("reference".to_owned(), "reference".to_owned());
        let pictures = SPP.map(|spp| (format!("{spp:04}"), label(rows, scene, spp)));
        let pictures: Vec<_> = [reference].into_iter().chain(pictures).collect();
        let title = format!("{scene} after 1 to 1,500 samples a pixel, and the reference of {REFERENCE_SPP}");
        gallery.figure(scene, &title, &pictures, 0).into_iter().for_each(|block| summary.figure(block));
        summary.table(table);
        summary.findings.extend(finding(scene, of));
        summary.plain.extend(plain(scene, of));
    }
    summary
}

/// Samples, time and error of a picture.
fn label(rows: &Rows, scene: &str, spp: u32) -> String {
    let of = |value| rows.median(scene, &spp.to_string(), value);
    let seconds = of("seconds").map_or(String::new(), |seconds| format!(", {} s", digits(seconds)));
    let error = of("relative_mse").map_or(String::new(), |error| format!(", error {}", percent(error)));
    format!("{spp} sample{}{seconds}{error}", if spp == 1 { "" } else { "s" })
}

/// Error against time.
fn chart(rows: &Rows, scene: &str) -> Block {
    let point = |spp: u32| {
        let of = |value| rows.spread(scene, &spp.to_string(), value);
        let error = of("relative_mse")?;
        let [y, low, high] = [error.median, error.least, error.most].map(|mse| 100.0 * mse.max(0.0).sqrt());
        Some(Point { x: of("seconds")?.median, y, low: Some(low), high: Some(high) })
    };
    Block::Chart(Chart {
        title: format!("{scene}: error against time"),
        x: Axis::new("time", "s", axis::Scale::Log),
        y: Axis::new("relative RMSE", "%", axis::Scale::Log),
        series: vec![Series::new("1 to 1,500 samples", SPP.into_iter().filter_map(point).collect()).fitted()],
    })
}

/// What samples cost and bring.
fn plain(scene: &str, of: impl Fn(u32, &str) -> Option<f64>) -> Vec<String> {
    let at = |spp: u32| Some((of(spp, "seconds")?, of(spp, "relative_mse")?));
    let (Some((short, few)), Some((long, many))) = (at(10), at(1000)) else { return Vec::new() };
    // Along the power law through both, in the time for half the error.
    let times = 2f64.powf((long / short).ln() / (few / many).sqrt().ln());
    let first = format!(
        "{scene}: 10 samples a pixel take {} s and leave an error of {}; 1,000 samples take {} s and leave {}.",
        digits(short),
        percent(few),
        digits(long),
        percent(many)
    );
    let second = format!("{scene}: halving the error takes about {} times as long.", digits(times));
    [first].into_iter().chain((times.is_finite() && many < few).then_some(second)).collect()
}

/// What ten times the samples bring: from 10 to 1,000.
fn finding(scene: &str, of: impl Fn(u32, &str) -> Option<f64>) -> Option<String> {
    let (few, many) = (of(10, "relative_mse")?, of(1000, "relative_mse")?);
    let (short, long) = (of(10, "seconds")?, of(1000, "seconds")?);
    Some(format!(
        "{scene}: 1,000 samples instead of 10 take {} times as long and bring the error from {} to {}, {} times less; ten times \
         less would take a hundred times the samples if all were independent.",
        digits(long / short),
        percent(few),
        percent(many),
        digits((few / many).max(0.0).sqrt()),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_account_has_medians_and_says_what_samples_bring() {
        let row = |seconds, error| [("seconds", seconds), ("relative_mse", error)];
        let rows = [(0, "10", row(1.0, 0.01)), (1, "10", row(3.0, 0.03)), (0, "1000", row(200.0, 0.0002))];
        let rows: Vec<_> = rows.iter().map(|(repeat, case, values)| ("box", *case, *repeat, &values[..])).collect();
        let summary = summary(&Rows::synthetic(&rows), Path::new("nowhere"));
        assert_eq!(summary.tables()[0].rows[0], ["10", "2.00", "1.00 to 3.00", "14.1 %", "-"]);
        assert_eq!(summary.tables()[0].rows.len(), 2);
        assert!(summary.findings[0].contains("take 100 times as long"), "{:?}", summary.findings);
        assert!(summary.findings[0].contains("from 14.1 % to 1.41 %, 10.0 times less"), "{:?}", summary.findings);
        assert!(summary.lines().iter().all(|line| line.chars().count() <= 80));
    }
}
