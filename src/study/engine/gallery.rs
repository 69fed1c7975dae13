//! The pictures that a study keeps beside its rows.
//!
//! Comes in: radiance of a case. Goes out: an EXR and a PNG in the study's folder, named after study, scene and case.

use std::path::{Path, PathBuf};

use crate::Result;
use crate::compare::read::{DataWindow, read};
use crate::output::{Display, Metadata, OutputFile, Picture};
use crate::report::{Block, NamedPicture, Pictures};

/// A folder of pictures.
#[derive(Clone, Debug)]
pub struct Gallery {
    folder: PathBuf,
    study: &'static str,
}

impl Gallery {
    /// The pictures of `study` in `folder`, which exists when the first is kept.
    pub fn new(folder: &Path, study: &'static str) -> Gallery {
        Gallery { folder: folder.into(), study }
    }

    /// Where the picture of a case is, without an extension.
    pub fn path(&self, scene: &str, case: &str) -> PathBuf {
        self.folder.join(format!("{}-{scene}-{}", self.study, case.replace(' ', "-")))
    }

    /// The picture of a case, if it can be read.
    pub fn radiance(&self, scene: &str, case: &str) -> Option<Vec<[f32; 3]>> {
        Some(read(&self.exr(scene, case), None).ok()?.rgb)
    }

    fn exr(&self, scene: &str, case: &str) -> PathBuf {
        PathBuf::from(format!("{}.exr", self.path(scene, case).display()))
    }

    /// A figure of the pictures of these cases (with their labels) that are there, the one of this index for reference; `None` where
    /// none is.
    pub fn figure(&self, scene: &str, title: &str, cases: &[(String, String)], reference: usize) -> Option<Block> {
        let wanted = cases.get(reference).map(|(case, _)| case);
        let mut pictures = Pictures { title: title.into(), ..Pictures::default() };
        for (case, label) in cases {
            let Ok(picture) = read(&self.exr(scene, case), None) else { continue };
            let DataWindow { width, height, .. } = picture.window;
            if wanted == Some(case) {
                pictures.reference = Some(pictures.pictures.len());
            }
            pictures.pictures.push(NamedPicture {
                name: label.clone(),
                width: width as u32,
                height: height as u32,
                rgb: picture.rgb,
            });
        }
        (!pictures.pictures.is_empty()).then_some(Block::Pictures(pictures))
    }

    /// Keeps a picture of `width` x `height` pixels.
    pub fn keep(&self, scene: &str, case: &str, size: [u32; 2], rgb: &[[f32; 3]]) -> Result<()> {
        let picture = Picture::new(size[0], size[1], None, rgb.to_vec())?;
        let mut metadata = Metadata::new();
        metadata.fixed("study", self.study).fixed("scene", scene).fixed("case", case);
        let path = self.path(scene, case);
        for extension in ["exr", "png"] {
            // Not `with_extension`: a name may have a dot.
            let file = PathBuf::from(format!("{}.{extension}", path.display()));
            OutputFile::check(&file, false)?.write(&picture, &Display::default(), &metadata)?;
        }
        Ok(())
    }
}
