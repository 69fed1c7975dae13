//! The study of the published Cornell box: rendered by the published camera, beside another renderer's picture of the same data.
//!
//! Comes in: `scenes/cornell-box.toml` and a device. Goes out: a row, our picture and its variance; what is made of them is in
//! `cornell`.

use std::path::{Path, PathBuf};

use super::cornell::{self, MAX_BOUNCES, SIDE};
use crate::gpu::Context;
use crate::render::Tuning;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::study::engine::gallery::Gallery;
use crate::study::engine::spread::digits;
use crate::study::engine::subject::Subject;
use crate::study::engine::{Kind, Plan, Row, Rows, Scenes, Step, Study, Summary, Values, Watch};
use crate::{Error, Result};

/// What is stated of it.
pub const KIND: Kind = Kind {
    name: "cornell",
    help: "The Cornell box by the published camera, beside another renderer's picture of the same data",
    title: "The Cornell box",
    scenes: Scenes::Own(&["cornell-box"]),
    summary,
    opens: |context, plan, _| Ok(Box::new(Published::new(context, plan)?)),
};

/// The scene.
pub const SCENE: &str = "scenes/cornell-box.toml";
/// Name of the row and the pictures.
const BOX: &str = "cornell-box";
const CASES: [&str; 1] = ["published camera"];

/// The study.
pub struct Published {
    subject: Subject,
    gallery: Gallery,
    names: [String; 1],
    spp: u32,
}

impl Published {
    /// The study of the repository's box alone.
    pub fn new(context: &Context, plan: &Plan) -> Result<Published> {
        let mut scene = match plan.scenes.as_slice() {
            [] => Scene::load(&PathBuf::from(SCENE))?,
            [path] => Scene::load(path)?,
            _ => return Err(Error::Usage("study cornell is about one scene".into())),
        };
        cornell::prepare(&mut scene);
        Ok(Published {
            subject: Subject::new(context, scene),
            gallery: Gallery::new(&plan.folder, "cornell"),
            names: [BOX.into()],
            spp: plan.amount.of(4096, 1024, 32),
        })
    }
}

impl Study for Published {
    fn scenes(&self) -> &[String] {
        &self.names
    }

    fn case(&self, case: usize) -> String {
        CASES[case].into()
    }

    fn schedule(&self) -> Vec<Step> {
        vec![Step { scene: 0, case: 0, repeat: 0 }]
    }

    fn measure(&mut self, _step: Step, watch: &mut dyn Watch) -> Result<Option<Values>> {
        let settings = Settings { max_bounces: MAX_BOUNCES, ..self.subject.settings([SIDE; 2], self.spp) };
        let Some(rendered) = self.subject.render_warm(&settings, &Tuning::default(), watch)? else { return Ok(None) };
        let estimate = rendered.film.estimate();
        let variance: Vec<[f32; 3]> =
            estimate.variance.iter().map(|pixel| pixel.map(|channel| channel as f32)).collect();
        self.gallery.keep(BOX, "picture", [SIDE; 2], &estimate.mean)?;
        self.gallery.keep(BOX, "variance", [SIDE; 2], &variance)?;
        Ok(Some(vec![("spp", f64::from(self.spp)), ("seconds", rendered.report.seconds.render)]))
    }

    fn headline(&self, row: &Row) -> String {
        row.values.get("seconds").map(|seconds| format!("in {} s", digits(*seconds))).unwrap_or_default()
    }
}

/// What the row and the pictures say; nothing where a picture is gone.
pub fn summary(rows: &Rows, folder: &Path) -> Summary {
    let gallery = Gallery::new(folder, "cornell");
    let figure = |value| rows.median(BOX, CASES[0], value);
    let mut summary = Summary::default();
    let (Some(spp), Some(seconds), Some(rgb)) = (figure("spp"), figure("seconds"), gallery.radiance(BOX, "picture"))
    else {
        return summary;
    };
    let ours = cornell::BoxRender { rgb, variance: gallery.radiance(BOX, "variance"), spp: spp as u32, seconds };
    if let Ok(section) = cornell::section(&ours, rows.remade_by()) {
        summary.findings = section.finding;
        section.blocks.into_iter().for_each(|block| summary.figure(block));
    }
    summary
}
