//! The options that say what a render writes, and the files themselves.
//!
//! Comes in: parsed options, then the film of a finished render. Goes out: checked [`Outputs`] that have room on the
//! disk and in memory, then [`Saved`]: which files were written and which were not. One that fails does not keep the
//! others from being written.

use std::path::{Path, PathBuf};

use clap::{ArgAction, Args};
use texray::film::{Film, error_map};
use texray::memory::{Reservation, check, reserve};
use texray::output::cost::{Extent, check_room};
use texray::output::partial::beside_better;
use texray::output::{
    Aov, Display, Format, Layer, Metadata, OutputFile, Picture, Tonemap, check_writable, encode_indexed_png,
    is_rewritable, write_whole,
};
use texray::render::Settings;
use texray::scene::Scene;
use texray::{Error, Result};

use super::streams::json;
use super::{choices, parse, save};

/// Which files are written.
#[derive(Args)]
#[command(next_help_heading = "Files")]
pub struct OutputArgs {
    /// Picture file, .exr, .png or .hdr; may be given several times [default: SCENE.exr and SCENE.png, here]
    #[arg(short, long, value_name = "FILE", action = ArgAction::Append)]
    output: Vec<PathBuf>,
    /// Further layers of EXR files, separated by commas
    #[arg(long, value_parser = choices::of::<Aov>(), value_delimiter = ',')]
    aov: Vec<Aov>,
    /// Also write the standard error of each pixel as a picture of colours, .png (its text says what they mean)
    #[arg(long, value_name = "FILE", value_parser = parse::png)]
    error_map: Option<PathBuf>,
    /// Write the ledger of all transfers between CPU and GPU to this JSON file
    #[arg(long, value_name = "FILE")]
    ledger: Option<PathBuf>,
    /// Do not overwrite files
    #[arg(long)]
    no_clobber: bool,
    /// Overwrite a better picture too: otherwise one that a signal or a time limit cuts short goes beside a file that
    /// holds the same picture with more samples, as NAME.partial-Nspp.EXT
    #[arg(long, conflicts_with = "no_clobber")]
    overwrite: bool,
    /// Exposure of 8-bit pictures in stops, -100 to 100
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = parse::exposure, allow_negative_numbers = true)]
    #[arg(help_heading = "8-bit pictures")]
    exposure: f64,
    /// Tone map of 8-bit pictures
    #[arg(long, value_parser = choices::of::<Tonemap>(), default_value = choices::default::<Tonemap>())]
    #[arg(help_heading = "8-bit pictures")]
    tonemap: Tonemap,
}

impl OutputArgs {
    /// Checks what can be checked before the scene `scene` is read.
    pub fn check_early(&self, scene: &Path) -> Result<()> {
        self.check(&self.output, &[scene])?;
        Ok(())
    }

    /// Checks the files that will be written for a scene: none is a file that the scene names, no two are one, each can
    /// be written.
    pub fn outputs(&self, scene: &Scene) -> Result<Outputs<'_>> {
        let default: Vec<PathBuf>;
        let paths = if self.output.is_empty() {
            let stem = scene.path.file_stem().unwrap_or_default();
            let named = |end: &str| {
                let mut name = stem.to_owned();
                name.push(end);
                PathBuf::from(name)
            };
            default = [".exr", ".png"].map(named).into();
            &default
        } else {
            &self.output
        };
        let sources: Vec<_> = std::iter::once(&scene.path).chain(&scene.report.files).map(PathBuf::as_path).collect();
        let pictures = self.check(paths, &sources)?;
        if !self.aov.is_empty() && pictures.iter().all(|file| file.format() != Format::Exr) {
            return Err(Error::Usage("--aov: layers are for .exr files, and none is written".into()));
        }
        let mut aov: Vec<Aov> = Vec::new();
        self.aov.iter().for_each(|layer| {
            if !aov.contains(layer) {
                aov.push(*layer)
            }
        });
        let display = Display { exposure_stops: self.exposure, tonemap: self.tonemap };
        Ok(Outputs { arguments: self, pictures, aov, display })
    }

    fn check(&self, pictures: &[PathBuf], sources: &[&Path]) -> Result<Vec<OutputFile>> {
        let others: Vec<&Path> = self.ledger.iter().chain(&self.error_map).map(PathBuf::as_path).collect();
        let all: Vec<&Path> = pictures.iter().map(PathBuf::as_path).chain(others.iter().copied()).collect();
        pictures.iter().try_for_each(|path| Format::of(path).map(drop))?;
        save::check_distinct(sources, &all)?;
        others.iter().try_for_each(|path| check_writable(path, self.no_clobber))?;
        pictures.iter().map(|path| OutputFile::check(path, self.no_clobber)).collect()
    }
}

/// Files that will be written, checked.
pub struct Outputs<'a> {
    arguments: &'a OutputArgs,
    pictures: Vec<OutputFile>,
    aov: Vec<Aov>,
    display: Display,
}

impl Outputs<'_> {
    /// Refuses pictures that the disk has no room for, and holds the memory that saving them will take, until it is
    /// dropped, beside what the film holds itself.
    pub fn reserve(&self, settings: &Settings) -> Result<Reservation> {
        let extent = self.extent(settings);
        let plain = Extent { further_channels: 0, ..extent };
        let bytes = |format: Format| format.file_bytes(if format == Format::Exr { extent } else { plain });
        let files = self.pictures.iter().map(|file| (file.path(), bytes(file.format())));
        let map = self.arguments.error_map.iter().map(|path| (path.as_path(), bytes(Format::Png)));
        check_room(files.chain(map))?;
        let pixels = u64::from(extent.width) * u64::from(extent.height);
        let (of_film, saving) = (Film::read_out_bytes(pixels), extent.picture_bytes() + self.encoding_bytes(extent));
        let beside = saving.saturating_sub(of_film);
        // What is held is not touched, and so is still there for the film to find: both are asked for together.
        let replicates = settings
            .replicates
            .unwrap_or_else(|| Film::replicates(u64::from(settings.width) * u64::from(settings.height)));
        let film = Film::bytes(pixels, replicates);
        check("memory for the film and for saving the pictures", film.saturating_add(beside))?;
        reserve("memory for saving the pictures", beside)
    }

    fn extent(&self, settings: &Settings) -> Extent {
        let [_, _, width, height] = settings.region();
        Extent { width, height, further_channels: self.aov.iter().map(|layer| layer.channels()).sum() }
    }

    /// Bytes that the largest of the files takes while it is encoded.
    fn encoding_bytes(&self, extent: Extent) -> u64 {
        let plain = Extent { further_channels: 0, ..extent };
        let formats = self.pictures.iter().map(OutputFile::format).chain([Format::Png]);
        let bytes = |format: Format| format.encoding_bytes(if format == Format::Exr { extent } else { plain });
        formats.map(bytes).max().unwrap_or(0)
    }

    /// Writes all files of a render that has taken `spp` samples. `cut_short`: a signal or a time limit has ended it
    /// before its samples, and its pictures take the place of no better ones.
    pub fn write(&self, ending: &Ending<'_>, metadata: &Metadata) -> Result<Saved> {
        ending.film.let_go();
        let (picture, map) = self.read_out(ending)?;
        let mut saved = Saved {
            picture,
            display: self.display,
            encoding_bytes: self.encoding_bytes(self.extent(ending.settings)),
            pictures: Vec::new(),
            files: Vec::new(),
            warnings: Vec::new(),
            failures: Vec::new(),
        };
        let map_file = self.arguments.error_map.as_deref().map(Job::ErrorMap);
        let mut jobs: Vec<Job<'_>> = self.pictures.iter().map(Job::Picture).chain(map_file).collect();
        // Stopped before the first sample, there is no picture.
        if ending.spp == 0 {
            jobs.clear();
        }
        jobs.extend(self.arguments.ledger.as_deref().map(Job::Ledger));
        // A pipe may wait for its reader: files come first.
        jobs.sort_by_key(|job| !is_rewritable(job.path()));
        for job in jobs {
            self.write_one(job, ending, metadata, &map, &mut saved);
        }
        Ok(saved)
    }

    fn write_one(&self, job: Job<'_>, ending: &Ending<'_>, metadata: &Metadata, map: &[u8], saved: &mut Saved) {
        let spares = ending.cut_short && !self.arguments.overwrite;
        let no_clobber = self.arguments.no_clobber;
        match job {
            Job::Picture(file) => {
                let place = if spares { file.beside_better(&self.display, metadata, ending.spp) } else { file.clone() };
                let written = place.write(&saved.picture, &self.display, metadata);
                if written.is_ok() {
                    saved.pictures.push(place.written());
                }
                saved.note(file.path(), place.path(), written);
            }
            Job::ErrorMap(path) => {
                let mut metadata = metadata.clone();
                metadata.subject("shows", "standard error");
                let better = beside_better(path, &metadata, ending.spp).filter(|_| spares);
                let place = better.as_deref().unwrap_or(path);
                let (width, height) = (saved.picture.width, saved.picture.height);
                let png = encode_indexed_png(width, height, &error_map::palette(), error_map::LEGEND, map, &metadata);
                let png = png.map_err(|message| Error::output(place, message));
                saved.note(path, place, png.and_then(|png| write_whole(place, no_clobber, &png)));
            }
            Job::Ledger(path) => {
                let text = json(ending.ledger);
                saved.failures.extend(text.and_then(|text| write_whole(path, no_clobber, text.as_bytes())).err());
            }
        }
    }

    /// The picture with the layers asked for, and the error map, if one is wanted.
    fn read_out(&self, ending: &Ending<'_>) -> Result<(Picture, Vec<u8>)> {
        let (film, settings) = (ending.film, ending.settings);
        let picture = |mean| Picture::new(settings.width, settings.height, settings.crop, mean);
        if self.aov.is_empty() && self.arguments.error_map.is_none() {
            return Ok((picture(film.mean())?, Vec::new()));
        }
        let estimate = film.estimate();
        let map = if self.arguments.error_map.is_some() { error_map::error_map(&estimate) } else { Vec::new() };
        let layers = self.aov.iter().map(|&aov| Layer::of(aov, film, &estimate)).collect();
        Ok((picture(estimate.mean)?.with_layers(layers)?, map))
    }
}

/// A render that has ended with a picture.
pub struct Ending<'a> {
    /// What it was asked for.
    pub settings: &'a Settings,
    /// What it has accumulated.
    pub film: &'a Film,
    /// Its transfers.
    pub ledger: &'a serde_json::Value,
    /// Samples that every pixel has.
    pub spp: u32,
    /// Whether a signal or a time limit has ended it before its samples.
    pub cut_short: bool,
}

/// One file to write.
enum Job<'a> {
    Picture(&'a OutputFile),
    ErrorMap(&'a Path),
    Ledger(&'a Path),
}

impl Job<'_> {
    fn path(&self) -> &Path {
        match self {
            Job::Picture(file) => file.path(),
            Job::ErrorMap(path) | Job::Ledger(path) => path,
        }
    }
}

/// What was written of a render.
pub struct Saved {
    picture: Picture,
    display: Display,
    encoding_bytes: u64,
    /// Pictures that were written.
    pictures: Vec<OutputFile>,
    /// Names of pictures and error map that were written.
    pub files: Vec<String>,
    /// What the user should know: better pictures that were kept.
    pub warnings: Vec<String>,
    /// Why files were not written, an error each.
    pub failures: Vec<Error>,
}

impl Saved {
    /// Writes the pictures once more, with facts that were not known before. What went to a pipe or a device stays as
    /// it is, and so do pictures that cannot be written again: they lack these facts, and a warning says so.
    pub fn rewrite(&mut self, metadata: &Metadata) {
        for file in self.pictures.iter().filter(|file| is_rewritable(file.path())) {
            let room = reserve("memory for saving a picture again", self.encoding_bytes).map(drop);
            let written = room.and_then(|()| file.write(&self.picture, &self.display, metadata));
            if let Err(error) = written {
                self.warnings.push(format!("warning: a picture is saved without its bias, which came later: {error}"));
            }
        }
    }

    fn note(&mut self, asked: &Path, path: &Path, written: Result<()>) {
        match written {
            Ok(()) => {
                self.files.push(path.display().to_string());
                if asked != path {
                    self.warnings.push(format!(
                        "warning: {} holds more samples of this picture and is kept; this one is in {} (--overwrite \
                         replaces)",
                        asked.display(),
                        path.display()
                    ));
                }
            }
            Err(error) => self.failures.push(error),
        }
    }
}
