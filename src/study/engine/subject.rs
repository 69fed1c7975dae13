//! A scene under study.
//!
//! Comes in: scene files. Goes out: renders that the watch may stop, their time free of compiling, and references: pictures of
//! many samples with what is left of their own noise. May be assumed: no picture has a reference's seed but the reference.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::compare::relative_error::{DENOMINATOR_FLOOR, relative_mse};
use crate::film::Estimate;
use crate::gpu::Context;
use crate::render::{Observer, Progress, Rendered, Renderer, StopReason, Tuning};
use crate::scene::{Filter, Scene};
use crate::settings::Settings;
use crate::study::engine::Watch;
use crate::{Error, Result};

/// Seed of references.
pub const REFERENCE_SEED: u64 = 1 << 32;
/// Width and height in pixels of the window that is rendered to have a kernel compiled.
const WARM_UP_PIXELS: u32 = 16;

/// Scenes by name, one of them loaded.
pub struct Subjects {
    context: Context,
    paths: Vec<PathBuf>,
    names: Vec<String>,
    loaded: Option<(usize, Subject)>,
}

impl Subjects {
    /// Rows go by a scene's name, so two of one name are refused; so is having none.
    pub fn new(context: &Context, paths: &[PathBuf]) -> Result<Subjects> {
        if paths.is_empty() {
            return Err(Error::Usage("no scene to study".into()));
        }
        let mut names: Vec<String> = Vec::new();
        for path in paths {
            let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
            if names.contains(&name) {
                return Err(Error::Usage(format!("{}: there are two scenes named {name}", path.display())));
            }
            names.push(name);
        }
        Ok(Subjects { context: context.clone(), paths: paths.to_vec(), names, loaded: None })
    }

    /// Their names, in the order of their numbers.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The scene of this number, loaded now if it is not; the one before is let go.
    pub fn at(&mut self, index: usize) -> Result<&mut Subject> {
        if self.loaded.as_ref().is_none_or(|(loaded, _)| *loaded != index) {
            self.loaded = None;
            self.loaded = Some((index, Subject::load(&self.context, &self.paths[index])?));
        }
        match &mut self.loaded {
            Some((_, subject)) => Ok(subject),
            None => Err(Error::Internal("a scene that was loaded and is not there".into())),
        }
    }
}

/// A scene on a device, with what is known of it so far.
pub struct Subject {
    context: Context,
    /// The scene.
    pub scene: Scene,
    /// Kernels that have been compiled, by what they were made for.
    warm: Vec<(Settings, Tuning)>,
    references: Vec<(Settings, Rc<Reference>)>,
}

/// A picture that others are compared with.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Radiance, linear Rec. 709 in the file's units.
    pub mean: Vec<[f32; 3]>,
    /// Relative MSE that it has itself, by its replicates.
    pub noise: f64,
}

impl Reference {
    /// Of a finished render.
    pub fn of(rendered: &Rendered) -> Reference {
        let estimate = rendered.film.estimate();
        Reference { noise: own_noise(&estimate), mean: estimate.mean }
    }

    /// Relative MSE of a picture of other random numbers: the difference, less the reference's own share.
    ///
    /// Fails with [`Error::Internal`] where the sizes differ.
    pub fn relative_mse(&self, picture: &[[f32; 3]]) -> Result<f64> {
        let different = relative_mse(picture, &self.mean)
            .ok_or_else(|| Error::Internal("pictures of different sizes were compared".into()))?;
        Ok(different - self.noise)
    }
}

/// The relative MSE that a picture has by its own noise, as its replicates show it: mean of variance / (mean² + 0.01), without bias
/// but for the noise in the denominator.
fn own_noise(estimate: &Estimate) -> f64 {
    let pairs = estimate.variance.iter().flatten().zip(estimate.mean.iter().flatten());
    let sum: f64 = pairs.map(|(&variance, &mean)| variance / (f64::from(mean).powi(2) + DENOMINATOR_FLOOR)).sum();
    sum / (3 * estimate.mean.len()).max(1) as f64
}

/// Passes on the wish to stop.
struct Stopping<'a>(&'a dyn Watch);

impl Observer for Stopping<'_> {
    fn progress(&mut self, _progress: &Progress) {}

    fn stop_requested(&self) -> bool {
        self.0.stop_requested()
    }
}

impl Subject {
    /// Loads the scene of this file.
    pub fn load(context: &Context, path: &Path) -> Result<Subject> {
        Ok(Subject::new(context, Scene::load(path)?))
    }

    /// A scene that is there already.
    pub fn new(context: &Context, scene: Scene) -> Subject {
        Subject { context: context.clone(), scene, warm: Vec::new(), references: Vec::new() }
    }

    /// The device.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// The scene's settings with the box filter: pixels apart from each other.
    pub fn settings(&self, [width, height]: [u32; 2], spp: u32) -> Settings {
        Settings { width, height, spp, filter: Filter::Box, ..Settings::for_scene(&self.scene) }
    }

    /// Renders; `None` where the watch stopped it.
    pub fn render(&self, settings: &Settings, tuning: &Tuning, watch: &dyn Watch) -> Result<Option<Rendered>> {
        let renderer = Renderer::new(&self.context, &self.scene, settings, tuning)?;
        let rendered = renderer.render(&mut Stopping(watch))?;
        Ok((rendered.report.stop_reason != StopReason::Interrupted).then_some(rendered))
    }

    /// Renders with the kernel compiled before: drivers compile in the first dispatch.
    pub fn render_warm(&mut self, settings: &Settings, tuning: &Tuning, watch: &dyn Watch) -> Result<Option<Rendered>> {
        let [x, y, width, height] = settings.region();
        let [w, h] = [width.min(WARM_UP_PIXELS), height.min(WARM_UP_PIXELS)];
        let crop = Some([x + (width - w) / 2, y + (height - h) / 2, w, h]);
        let warm_up = (Settings { crop, spp: 1, seed: 0, ..settings.clone() }, tuning.clone());
        if !self.warm.contains(&warm_up) {
            if self.render(&warm_up.0, &warm_up.1, watch)?.is_none() {
                return Ok(None);
            }
            self.warm.push(warm_up);
        }
        self.render(settings, tuning, watch)
    }

    /// The reference of these settings, rendered once; their seed does not count.
    pub fn reference(&mut self, settings: &Settings, watch: &dyn Watch) -> Result<Option<Rc<Reference>>> {
        let settings = Settings { seed: REFERENCE_SEED, ..settings.clone() };
        let place = match self.references.iter().position(|(made_for, _)| *made_for == settings) {
            Some(place) => place,
            None => {
                let Some(rendered) = self.render(&settings, &Tuning::default(), watch)? else { return Ok(None) };
                self.references.push((settings, Rc::new(Reference::of(&rendered))));
                self.references.len() - 1
            }
        };
        Ok(Some(self.references[place].1.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_of_a_picture_is_its_variance_over_its_square() {
        let estimate = Estimate { width: 1, height: 1, mean: vec![[1.0, 0.0, 2.0]], variance: vec![[0.101, 0.0, 0.0]] };
        assert!((own_noise(&estimate) - 0.1 / 3.0).abs() < 1e-9);
    }
}
