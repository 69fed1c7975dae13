//! What the rows say, in words of at most 80 columns.

use super::super::spread::digits;
use super::super::{Row, Rows, Spread};
use super::Case;
use crate::study::peers::Peer;

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

/// Lines about every scene of the rows. Efficiency is 1 / (relMSE · seconds) of the timed picture.
pub fn summary(rows: &Rows, pixels: f64) -> Vec<String> {
    let mut scenes: Vec<&str> = Vec::new();
    for row in rows.all() {
        if !scenes.contains(&row.scene.as_str()) {
            scenes.push(&row.scene);
        }
    }
    scenes.into_iter().flat_map(|scene| Figures { rows, scene, pixels }.lines()).collect()
}

struct Figures<'a> {
    rows: &'a Rows,
    scene: &'a str,
    pixels: f64,
}

impl Figures<'_> {
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
