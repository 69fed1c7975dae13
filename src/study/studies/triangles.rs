//! The study of triangles: time by their number, with the default tree, the thesis's and none (thesis, figures 4.1 to 4.3).
//!
//! Comes in: a device. Goes out: a row a number, tree and repeat for scenes that the study makes itself, scattered and clustered: time to
//! build the tree and to pack and copy it (CPU), time of a ray and a sample on the device, work of a ray. Pictures are small where
//! there is no tree, since every ray then tests every triangle; times are a ray's, so sizes fall out.

pub mod soup;

use crate::gpu::Context;
use crate::interface::TRIANGLE_TEXELS;
use crate::render::Tuning;
use crate::report::{Axis, Block, Chart, Fit, Point, Series, axis};
use crate::settings::{AccelKind, Builder, Settings};
use crate::study::engine::schedule::interleaved;
use crate::study::engine::spread::digits;
use crate::study::engine::subject::Subject;
use crate::study::engine::summary::{Summary, Table};
use crate::study::engine::{Kind, Plan, Row, Rows, Scenes, Step, Study, Values, Watch};
use crate::{Error, Result};
use soup::Placement;

/// What is stated of it.
pub const KIND: Kind = Kind {
    name: "triangles",
    help: "Time for 1 to a million triangles, scattered and clustered, with the default tree, the thesis's and none",
    title: "Numbers of triangles",
    scenes: Scenes::Own(&[]),
    summary: |rows, _| summary(rows),
    opens: |context, plan, _| Ok(Box::new(Triangles::new(context, plan)?)),
};

/// Numbers of triangles.
const COUNTS: [usize; 7] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000];
/// The most that are traced without a tree.
const MOST_BRUTE: usize = 100_000;
/// From here on growth is that of a large scene.
const LARGE: usize = 1_000;

/// What finds hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tree {
    Default,
    Thesis,
    None,
}

impl Tree {
    const ALL: [Tree; 3] = [Tree::Default, Tree::Thesis, Tree::None];

    fn name(self) -> &'static str {
        match self {
            Tree::Default => "wide",
            Tree::Thesis => "thesis",
            Tree::None => "no tree",
        }
    }

    fn choose(self, settings: &mut Settings) {
        (settings.accel, settings.builder) = match self {
            Tree::Default => (AccelKind::default(), Builder::default()),
            Tree::Thesis => (AccelKind::Binary, Builder::Median),
            Tree::None => (AccelKind::Brute, Builder::default()),
        };
    }
}

/// How much is measured.
struct TrianglesWorkload {
    size: [u32; 2],
    /// Wanted seconds of a timed render.
    seconds: f64,
    repeats: u32,
    /// The largest number of triangles.
    most: usize,
}

const FULL: TrianglesWorkload = TrianglesWorkload { size: [128, 96], seconds: 2.0, repeats: 3, most: 1_000_000 };
const QUICK: TrianglesWorkload = TrianglesWorkload { size: [64, 48], seconds: 0.3, repeats: 3, most: 1_000_000 };
const LEAST: TrianglesWorkload = TrianglesWorkload { size: [8, 8], seconds: 1e-3, repeats: 1, most: 100 };

/// The study.
pub struct Triangles {
    context: Context,
    workload: TrianglesWorkload,
    cases: Vec<(Tree, usize)>,
    names: Vec<String>,
    /// Scenes of one placement, by number of triangles, as far as they have been needed.
    subjects: (Option<Placement>, Vec<(usize, Subject)>),
    /// Samples of a timed render by placement and case.
    spp: Vec<(Placement, usize, u32)>,
}

impl Triangles {
    /// The study of scenes of its own.
    pub fn new(context: &Context, plan: &Plan) -> Result<Triangles> {
        if !plan.scenes.is_empty() {
            return Err(Error::Usage("study triangles makes its own scenes; give it none".into()));
        }
        let workload = plan.amount.of(FULL, QUICK, LEAST);
        Ok(Triangles {
            context: context.clone(),
            cases: cases(workload.most),
            workload,
            names: Placement::ALL.map(|placement| placement.name().into()).into(),
            subjects: (None, Vec::new()),
            spp: Vec::new(),
        })
    }

    fn subject(&mut self, placement: Placement, count: usize) -> Result<&mut Subject> {
        if self.subjects.0 != Some(placement) {
            self.subjects = (Some(placement), Vec::new());
        }
        let subjects = &mut self.subjects.1;
        let place = match subjects.iter().position(|(made_of, _)| *made_of == count) {
            Some(place) => place,
            None => {
                subjects.push((count, Subject::new(&self.context, soup::scene(count, placement)?)));
                subjects.len() - 1
            }
        };
        Ok(&mut subjects[place].1)
    }
}

fn cases(most: usize) -> Vec<(Tree, usize)> {
    let of = |tree| COUNTS.into_iter().filter(|&count| count <= most).map(move |count| (tree, count));
    Tree::ALL.into_iter().flat_map(of).filter(|&(tree, count)| tree != Tree::None || count <= MOST_BRUTE).collect()
}

fn name(tree: Tree, count: usize) -> String {
    format!("{} {count}", tree.name())
}

/// A smaller picture where a ray tests thousands of triangles: a quarter and an eighth as wide and high.
fn size(workload: &TrianglesWorkload, tree: Tree, count: usize) -> [u32; 2] {
    let divisor = match (tree, count) {
        (Tree::None, 100_000..) => 4,
        (Tree::None, 10_000..) => 2,
        _ => 1,
    };
    workload.size.map(|pixels| pixels / divisor)
}

impl Study for Triangles {
    fn scenes(&self) -> &[String] {
        &self.names
    }

    fn case(&self, case: usize) -> String {
        let (tree, count) = self.cases[case];
        name(tree, count)
    }

    fn schedule(&self) -> Vec<Step> {
        let cases: Vec<usize> = (0..self.cases.len()).collect();
        interleaved(self.names.len(), &cases, self.workload.repeats)
    }

    fn measure(&mut self, step: Step, watch: &mut dyn Watch) -> Result<Option<Values>> {
        let (placement, (tree, count)) = (Placement::ALL[step.scene], self.cases[step.case]);
        let (size, wanted) = (size(&self.workload, tree, count), self.workload.seconds);
        let known = self.spp.iter().find(|known| (known.0, known.1) == (placement, step.case)).map(|known| known.2);
        let subject = self.subject(placement, count)?;
        let mut settings = subject.settings(size, 1);
        tree.choose(&mut settings);
        let spp = match known {
            Some(spp) => spp,
            None => {
                let Some(pilot) = subject.render_warm(&settings, &Tuning::default(), watch)? else { return Ok(None) };
                let spp = (wanted / pilot.report.seconds.render.max(1e-4)).round().clamp(1.0, 4096.0) as u32;
                self.spp.push((placement, step.case, spp));
                spp
            }
        };
        let subject = self.subject(placement, count)?;
        settings.spp = spp;
        settings.seed = u64::from(step.repeat);
        let Some(rendered) = subject.render(&settings, &Tuning::default(), watch)? else { return Ok(None) };
        let report = rendered.report;
        let (seconds, rays, paths) = (report.seconds.render, report.rays as f64, report.paths as f64);
        let bytes = report.tree.node_bytes + (count + soup::LIGHT_TRIANGLES) * TRIANGLE_TEXELS as usize * 16;
        Ok(Some(vec![
            ("triangles", count as f64),
            ("spp", f64::from(spp)),
            ("pixels", f64::from(size[0] * size[1])),
            ("seconds", seconds),
            ("ns_per_ray", 1e9 * seconds / rays),
            ("us_per_path", 1e6 * seconds / paths),
            ("rays_per_path", rays / paths),
            ("node_visits_per_ray", report.node_visits as f64 / rays),
            ("triangle_tests_per_ray", report.triangle_tests as f64 / rays),
            ("seconds_bvh", report.seconds.bvh),
            ("seconds_upload", report.seconds.upload),
            ("bytes_tree_and_positions", bytes as f64),
        ]))
    }

    fn headline(&self, row: &Row) -> String {
        let figure = |name: &str| row.values.get(name).copied().unwrap_or(f64::NAN);
        format!(
            "triangles: {} ns a ray, tree in {} ms",
            digits(figure("ns_per_ray")),
            digits(1e3 * figure("seconds_bvh"))
        )
    }
}

/// What the rows say.
pub fn summary(rows: &Rows) -> Summary {
    let mut summary = Summary::default();
    for scene in rows.scenes() {
        let figure = |tree, count, value: &str| rows.median(scene, &name(tree, count), value);
        let text = |value: Option<f64>| value.map_or("-".into(), digits);
        let title = format!(
            "{scene} triangles: milliseconds to build the tree (CPU), nanoseconds of a ray (device); thesis: its tree"
        );
        let mut table =
            Table::new(title, &["triangles", "build", "ray", "thesis: build", "ray", "no tree: ray", "bytes each"]);
        for count in COUNTS {
            let bytes = figure(Tree::Default, count, "bytes_tree_and_positions");
            let row = [
                figure(Tree::Default, count, "seconds_bvh").map(|seconds| 1e3 * seconds),
                figure(Tree::Default, count, "ns_per_ray"),
                figure(Tree::Thesis, count, "seconds_bvh").map(|seconds| 1e3 * seconds),
                figure(Tree::Thesis, count, "ns_per_ray"),
                figure(Tree::None, count, "ns_per_ray"),
                bytes.map(|bytes| bytes / (count + soup::LIGHT_TRIANGLES) as f64),
            ];
            if row.iter().any(Option::is_some) {
                table.rows.push([count.to_string()].into_iter().chain(row.map(text)).collect());
            }
        }
        charts(rows, scene).into_iter().for_each(|block| summary.figure(block));
        summary.table(table);
        summary.findings.extend(growth(scene, figure));
        summary.plain.extend(plain(scene, figure));
    }
    summary.findings.extend(placement(rows));
    summary
}

/// Time of a ray and time to build, by the number.
fn charts(rows: &Rows, scene: &str) -> [Block; 2] {
    let series = |tree: Tree, value: &str| {
        let point = |count: usize| Some(rows.spread(scene, &name(tree, count), value)?.point(count as f64));
        let label = match tree {
            Tree::Default => "default tree",
            Tree::Thesis => "the thesis's tree",
            Tree::None => "no tree",
        };
        Series::new(label, COUNTS.into_iter().filter_map(point).collect()).default_if(tree == Tree::Default)
    };
    let chart = |title: &str, y: Axis, series| {
        let x = Axis::new("triangles", "", axis::Scale::Log);
        Block::Chart(Chart { title: format!("{scene} triangles: {title}"), x, y, series })
    };
    [
        chart(
            "a ray on the device",
            Axis::new("time of a ray", "ns", axis::Scale::Log),
            Tree::ALL.map(|tree| series(tree, "ns_per_ray")).into(),
        ),
        chart(
            "the tree on the CPU",
            Axis::new("time to build", "s", axis::Scale::Log),
            [Tree::Default, Tree::Thesis].map(|tree| series(tree, "seconds_bvh")).into(),
        ),
    ]
}

/// The law of a ray's time in the number of triangles, from [`LARGE`] on.
fn law(tree: Tree, figure: impl Fn(Tree, usize, &str) -> Option<f64>) -> Option<Fit> {
    let counts = COUNTS.into_iter().filter(|&count| count >= LARGE || tree == Tree::None && count >= 10);
    let points = counts.filter_map(|count| Some(Point::new(count as f64, figure(tree, count, "ns_per_ray")?)));
    Fit::of(&points.collect::<Vec<_>>())
}

fn growth(scene: &str, figure: impl Fn(Tree, usize, &str) -> Option<f64> + Copy) -> Option<String> {
    let most = COUNTS[COUNTS.len() - 1];
    let grows = |tree| Some(figure(tree, most, "ns_per_ray")? / figure(tree, LARGE, "ns_per_ray")?);
    let (wide, thesis, none) = (law(Tree::Default, figure)?, law(Tree::Thesis, figure)?, law(Tree::None, figure)?);
    let at_most = |tree| figure(tree, most, "ns_per_ray");
    let brute = figure(Tree::None, MOST_BRUTE, "ns_per_ray")? / figure(Tree::Default, MOST_BRUTE, "ns_per_ray")?;
    Some(format!(
        "{scene}: from 1,000 to 1,000,000 triangles a ray takes {} times as long with the default tree (power {:.2}) and {} with the \
         thesis's ({:.2}), which takes {} times as long at a million. Without a tree time goes with the number to the power {:.2}; at \
         100,000 the tree is {} times as fast.",
        digits(grows(Tree::Default)?),
        wide.slope,
        digits(grows(Tree::Thesis)?),
        thesis.slope,
        digits(at_most(Tree::Thesis)? / at_most(Tree::Default)?),
        none.slope,
        digits(brute),
    ))
}

fn plain(scene: &str, figure: impl Fn(Tree, usize, &str) -> Option<f64>) -> Option<String> {
    let most = COUNTS[COUNTS.len() - 1];
    let of = |tree, count| figure(tree, count, "ns_per_ray");
    Some(format!(
        "{scene} triangles: {} times as many make a ray take {} times as long; at 100,000 the tree makes it {} times \
         as fast as \
         testing all of them.",
        most / LARGE,
        digits(of(Tree::Default, most)? / of(Tree::Default, LARGE)?),
        digits(of(Tree::None, MOST_BRUTE)? / of(Tree::Default, MOST_BRUTE)?)
    ))
}

/// What it costs that triangles stand together.
fn placement(rows: &Rows) -> Option<String> {
    let of = |placement: Placement, tree, value: &str| rows.median(placement.name(), &name(tree, MOST_BRUTE), value);
    let ratio =
        |tree, value: &str| Some(of(Placement::Clustered, tree, value)? / of(Placement::Scattered, tree, value)?);
    Some(format!(
        "Placement, at 100,000 triangles: clustered ones take {} times a ray's time of scattered ones with the default tree, {} with the \
         thesis's and {} without a tree; a whole path {}, {} and {} times, as it has other numbers of rays.",
        digits(ratio(Tree::Default, "ns_per_ray")?),
        digits(ratio(Tree::Thesis, "ns_per_ray")?),
        digits(ratio(Tree::None, "ns_per_ray")?),
        digits(ratio(Tree::Default, "us_per_path")?),
        digits(ratio(Tree::Thesis, "us_per_path")?),
        digits(ratio(Tree::None, "us_per_path")?),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_with_every_tree_but_the_largest_without_one() {
        let cases = cases(QUICK.most);
        assert_eq!(cases.len(), 20);
        assert!(!cases.contains(&(Tree::None, 1_000_000)) && cases.contains(&(Tree::None, 100_000)));
        assert_eq!(size(&QUICK, Tree::None, 100_000), [16, 12]);
        assert_eq!(size(&QUICK, Tree::Thesis, 1_000_000), QUICK.size);
    }

    #[test]
    fn growth_is_read_off_the_medians() {
        // A ray: 100 ns and the sixth root of the number; the thesis's tree twice; brute force a nanosecond a triangle.
        let time = |tree, count: usize| match tree {
            Tree::Default => 100.0 * (count as f64).powf(1.0 / 6.0),
            Tree::Thesis => 200.0 * (count as f64).powf(1.0 / 6.0),
            Tree::None => count as f64,
        };
        let mut figures = Vec::new();
        for placement in Placement::ALL {
            for (tree, count) in cases(QUICK.most) {
                let slower = if placement == Placement::Clustered { 1.5 } else { 1.0 };
                let values = [("ns_per_ray", slower * time(tree, count)), ("us_per_path", time(tree, count))];
                figures.push((placement.name(), name(tree, count), values));
            }
        }
        let rows: Vec<_> =
            figures.iter().map(|(scene, case, values)| (*scene, case.as_str(), 0, &values[..])).collect();
        let summary = summary(&Rows::synthetic(&rows));
        let finding = &summary.findings[0];
        let words =
            ["takes 3.16 times as long with the default tree (power 0.17)", "which takes 2.00 times", "power 1.00"];
        assert!(words.iter().all(|words| finding.contains(words)), "{finding}");
        let finding = &summary.findings[2];
        assert!(finding.contains("take 1.50 times") && finding.contains("a whole path 1.00, 1.00"), "{finding}");
        assert!(summary.lines().iter().all(|line| line.chars().count() <= 80), "{:#?}", summary.lines());
    }
}
