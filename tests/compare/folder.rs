//! OpenEXR files as any renderer may write them, and a folder in which texray compares them.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, IntegerBounds, Layer, LayerAttributes, SmallVec, Text, Vec2,
    WritableImage,
};
use serde_json::Value;

pub const WIDTH: usize = 64;
pub const HEIGHT: usize = 48;

/// Pixels in rows from the top.
pub type Rgb = Vec<[f32; 3]>;

/// One channel of a file: its full name and its samples.
pub struct Plane(pub &'static str, pub FlatSamples);

pub fn channel(pixels: &Rgb, i: usize) -> Vec<f32> {
    pixels.iter().map(|rgb| rgb[i]).collect()
}

/// R, G and B of pixels under a prefix.
pub fn planes(prefix: [&'static str; 3], pixels: &Rgb) -> Vec<Plane> {
    prefix.into_iter().enumerate().map(|(i, name)| Plane(name, FlatSamples::F32(channel(pixels, i)))).collect()
}

pub fn write_at(path: &Path, size: (usize, usize), position: (i32, i32), planes: Vec<Plane>) {
    let list: SmallVec<[AnyChannel<FlatSamples>; 4]> =
        planes.into_iter().map(|Plane(name, samples)| AnyChannel::new(name, samples)).collect();
    let attributes = LayerAttributes {
        layer_name: None::<Text>,
        layer_position: Vec2(position.0, position.1),
        ..LayerAttributes::default()
    };
    let mut image = Image::from_layer(Layer::new(size, attributes, Encoding::FAST_LOSSLESS, AnyChannels::sort(list)));
    image.attributes.display_window = IntegerBounds::from_dimensions((200, 100));
    image.write().to_file(path).expect("the picture can be written");
}

pub fn write(path: &Path, pixels: &Rgb) {
    write_at(path, (WIDTH, HEIGHT), (0, 0), planes(["R", "G", "B"], pixels));
}

/// A scene of sorts, eight stops deep, and the same with noise of ±30 %.
pub fn pictures() -> (Rgb, Rgb) {
    let mut state = 1u32;
    let (mut noisy, mut clean) = (Vec::new(), Vec::new());
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let across = f64::from((x + 1) as f32 / WIDTH as f32);
            let down = f64::from((y + 1) as f32 / HEIGHT as f32);
            let chess = if (x / 8 + y / 8) % 2 == 1 { 0.25 } else { 2.0 };
            let base = [across * across * 8.0, down, chess];
            clean.push(base.map(|value| value as f32));
            noisy.push(base.map(|value| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (value * (1.0 + 0.6 * (f64::from(state >> 8) / 16_777_216.0 - 0.5))) as f32
            }));
        }
    }
    (noisy, clean)
}

/// A folder in which texray runs.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, pixels: &Rgb) {
        write(&self.at(name), pixels);
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_texray"));
        command.current_dir(self.0.path()).arg("compare").args(arguments).output().expect("texray starts")
    }

    /// The JSON document of a comparison that ends with this code.
    pub fn json(&self, arguments: &[&str], code: i32) -> Value {
        let output = self.run(&[arguments, &["--json"]].concat());
        assert_eq!(output.status.code(), Some(code), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("JSON on stdout")
    }

    /// The only line on stderr of a comparison that ends with this code and prints nothing.
    pub fn refused(&self, arguments: &[&str], code: i32) -> String {
        let output = self.run(arguments);
        assert_eq!((output.status.code(), text(&output.stdout).as_str()), (Some(code), ""), "{arguments:?}");
        text(&output.stderr)
    }
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
