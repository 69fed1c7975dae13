//! What the rows say, in words of at most 80 columns.

use super::Case;
use crate::report::{Bars, Block, Table};
use crate::study::engine::peers::Peer;
use crate::study::engine::spread::digits;
use crate::study::engine::{Row, Rows, Spread, Summary};

/// The figure of a row that matters most.
pub fn headline(row: &Row) -> String {
    let figure = |name: &str| row.values.get(name).copied();
    if let Some(rate) = figure("mpaths_per_second") {
        return format!("{} Mpaths/s", digits(rate));
    }
    if let Some(error) = figure("relative_mse_spp") {
        return format!("relMSE * spp {}", digits(error));
    }
    figure("seconds_first_picture").map(|seconds| format!("{} s", digits(seconds))).unwrap_or_default()
}

/// What the rows say. Efficiency is 1 / (relMSE · seconds) of the timed picture.
pub fn summary(rows: &Rows) -> Summary {
    let mut summary = Summary::default();
    for scene in rows.scenes() {
        let figures = Figures::of(rows, scene);
        summary.text.extend(figures.lines());
        summary.findings.extend(figures.finding());
        summary.plain.extend(figures.plain());
        summary.figure(Block::Bars(figures.bars()));
        summary.figure(Block::Text(format!("{scene}: medians and ranges of the repeats")));
        summary.figure(Block::Table(figures.table()));
    }
    summary
}

struct Figures<'a> {
    rows: &'a Rows,
    scene: &'a str,
    pixels: f64,
}

impl<'a> Figures<'a> {
    fn of(rows: &'a Rows, scene: &'a str) -> Figures<'a> {
        let median = |value| rows.median(scene, &Case::Default.name(), value);
        let paths = median("mpaths_per_second").zip(median("seconds")).map(|(rate, seconds)| 1e6 * rate * seconds);
        let pixels = paths.zip(median("spp")).map_or(f64::NAN, |(paths, spp)| paths / spp);
        Figures { rows, scene, pixels }
    }

    fn finding(&self) -> Option<String> {
        let rate = self.rate(Case::Default)?;
        let mut text = format!("{}: {rate} Mpaths/s", self.scene);
        if let Some(efficiency) = self.efficiency(Case::Default, Case::Error) {
            text += &format!(", efficiency {} /s", digits(efficiency));
        }
        if let Some(start) = self.spread(Case::Start { cold: false }, "seconds_first_picture") {
            text += &format!(", {} s from the start of the program to the first whole picture", digits(start.median));
        }
        Some(text + ".")
    }

    fn plain(&self) -> Option<String> {
        let rate = digits(self.rate(Case::Default)?.median);
        let start = self.spread(Case::Start { cold: false }, "seconds_first_picture");
        let start = start.map_or(String::new(), |start| {
            format!("; the first picture is there {} s after the program starts", digits(start.median))
        });
        Some(format!("{}: {rate} million paths a second{start}.", self.scene))
    }

    /// Paths a second, ours and the peers'.
    fn bars(&self) -> Bars {
        let ours = [(Case::NoRoulette, "texray, no roulette"), (Case::Default, "texray")];
        let ours = ours.into_iter().filter_map(|(case, name)| {
            let is_default = matches!(case, Case::Default);
            Some(self.rate(case)?.bar(name).default_if(is_default))
        });
        let peers = Peer::ALL.into_iter().filter_map(|peer| Some(self.rate(Case::Peer(peer))?.bar(peer.name())));
        let title = format!("{}: paths a second", self.scene);
        Bars { title, unit: "Mpaths/s".into(), bars: ours.chain(peers).collect() }
    }

    fn table(&self) -> Table {
        let row = |what: &str, case: Case, value: &str, unit: &str| {
            let spread = self.spread(case, value)?;
            Some(vec![what.into(), format!("{} {unit}", digits(spread.median)), format!("{spread}")])
        };
        let start = Case::Start { cold: false };
        let rows = [
            row("paths, no roulette", Case::NoRoulette, "mpaths_per_second", "Mpaths/s"),
            row("paths", Case::Default, "mpaths_per_second", "Mpaths/s"),
            row("rays", Case::Default, "mrays_per_second", "Mrays/s"),
            row("rays a path", Case::Default, "rays_per_path", ""),
            row("node visits a ray", Case::Default, "node_visits_per_ray", ""),
            row("triangle tests a ray", Case::Default, "triangle_tests_per_ray", ""),
            row("bytes a triangle, tree and positions", Case::Default, "bytes_per_triangle", "bytes"),
            row("relMSE times samples", Case::Error, "relative_mse_spp", ""),
            row("start to first picture", start, "seconds_first_picture", "s"),
            row("the same, shaders not cached", Case::Start { cold: true }, "seconds_first_picture", "s"),
            row("one thread", Case::Threads { one: true }, "mpaths_per_second", "Mpaths/s"),
            row("all threads", Case::Threads { one: false }, "mpaths_per_second", "Mpaths/s"),
        ];
        let columns = ["what", "median", "median (range)"].map(String::from).into();
        Table { columns, rows: rows.into_iter().flatten().collect() }
    }

    fn spread(&self, case: Case, value: &str) -> Option<Spread> {
        Spread::of(self.rows.values(self.scene, &case.name(), value))
    }

    fn median(&self, case: Case, value: &str) -> Option<f64> {
        self.spread(case, value).map(|spread| spread.median)
    }

    fn rate(&self, case: Case) -> Option<Spread> {
        self.spread(case, "mpaths_per_second")
    }

    /// 1 / (relMSE · seconds) of the timed picture, whatever its samples: their number falls out.
    fn efficiency(&self, speed: Case, error: Case) -> Option<f64> {
        let error = self.median(error, "relative_mse_spp")?;
        Some(self.rate(speed)?.median * 1e6 / (self.pixels * error))
    }

    fn lines(&self) -> Vec<String> {
        let mut lines = vec![self.title()];
        for (case, what) in [(Case::NoRoulette, "no roulette"), (Case::Default, "default")] {
            lines.extend(self.speed(case, what));
        }
        let error = self.median(Case::Error, "relative_mse_spp");
        let efficiency = self.efficiency(Case::Default, Case::Error);
        if let (Some(error), Some(efficiency)) = (error, efficiency) {
            lines.push(format!("  relMSE * spp {}, efficiency {} /s", digits(error), digits(efficiency)));
        }
        lines.extend(self.start());
        if let (Some(one), Some(all)) =
            (self.rate(Case::Threads { one: true }), self.rate(Case::Threads { one: false }))
        {
            lines.push(format!("  all threads over one: {}", digits(all.median / one.median)));
        }
        lines.extend(Peer::ALL.into_iter().flat_map(|peer| self.against(peer)));
        lines
    }

    fn title(&self) -> String {
        let figure = |name| self.median(Case::Default, name).or(self.median(Case::NoRoulette, name));
        match (figure("triangles"), figure("bytes_per_triangle")) {
            (Some(triangles), Some(bytes)) => format!(
                "{}: {triangles:.0} triangles, {} bytes a triangle (positions and tree)",
                self.scene,
                digits(bytes)
            ),
            _ => self.scene.into(),
        }
    }

    fn speed(&self, case: Case, what: &str) -> Vec<String> {
        let Some(rate) = self.rate(case) else { return Vec::new() };
        let figure = |name| self.median(case, name).map_or("?".into(), digits);
        vec![
            format!("  {what}: {rate} Mpaths/s, {} Mrays/s", figure("mrays_per_second")),
            format!(
                "    {} rays a path, {} node visits and {} triangle tests a ray",
                figure("rays_per_path"),
                figure("node_visits_per_ray"),
                figure("triangle_tests_per_ray")
            ),
        ]
    }

    fn start(&self) -> Vec<String> {
        let case = Case::Start { cold: false };
        let Some(total) = self.spread(case, "seconds_first_picture") else { return Vec::new() };
        let cold = self.median(Case::Start { cold: true }, "seconds_first_picture").map_or("?".into(), digits);
        let stage = |name| self.median(case, name).map_or("?".into(), |seconds| format!("{seconds:.2}"));
        let memory = self.median(case, "bytes_peak_rss").map_or("?".into(), |bytes| digits(bytes / 1e6));
        vec![
            format!("  start to first picture {total} s, cold {cold} s, peak {memory} MB"),
            format!(
                "    load {}, tree {}, upload {}, pipeline {}, render {}; file {} s",
                stage("seconds_load"),
                stage("seconds_bvh"),
                stage("seconds_upload"),
                stage("seconds_pipeline"),
                stage("seconds_render"),
                stage("seconds_write")
            ),
        ]
    }

    /// The peer's figures, and ours over them: without roulette where it has none, by default otherwise.
    fn against(&self, peer: Peer) -> Option<String> {
        let theirs = self.rate(Case::Peer(peer))?;
        let ours = if peer == Peer::MitsubaNoRoulette { Case::NoRoulette } else { Case::Default };
        let ratio = self.rate(ours).map_or("?".into(), |ours| digits(ours.median / theirs.median));
        let mut line = format!("  {}: {theirs} Mpaths/s, ours {ratio} of it", peer.name());
        if let (Some(ours), Some(theirs)) =
            (self.efficiency(Case::Default, Case::Error), self.efficiency(Case::Peer(peer), Case::PeerError(peer)))
        {
            line += &format!("\n    efficiency {} /s, ours {} of it", digits(theirs), digits(ours / theirs));
        }
        Some(line)
    }
}
