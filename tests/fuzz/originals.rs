//! The files that are damaged: small ones that use every statement and key, the Cornell box, and OpenEXR pictures of
//! every kind of block and compression that the reader knows.

use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    Vec2, WritableImage, f16,
};

/// Scene, OBJ and MTL file of each family.
pub fn scenes() -> [[String; 3]; 3] {
    let committed = [
        include_str!("../../scenes/cornell-box.toml"),
        include_str!("../../scenes/cornell-box.obj"),
        include_str!("../../scenes/cornell-box.mtl"),
    ];
    let committed = committed.map(|text| text.replace("cornell-box.obj", "a.obj").replace("cornell-box.mtl", "a.mtl"));
    [committed, [TOML, OBJ, MTL].map(str::to_owned), [LIT, OBJ, MTL].map(str::to_owned)]
}

const TOML: &str = r#"
[camera]
origin = [0, 0, 4]
target = [0.5, 0, 0]
up = [0, 1, 0]
vfov = 30
[film]
width = 10
height = 20
filter = "box"
[render]
spp = 1
max_bounces = 8
[[mesh]]
file = "a.obj"
scale = [1, -2, 3]
rotate = { axis = [0, 1, 0], degrees = 30 }
translate = [1, 2, 3]
[[mesh]]
file = "a.obj"
material = "m"
matrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]
[material.m]
kd = [0, 0, 1]
ni = 1.5
[environment]
color = [1, 1, 1]
strength = 2
"#;

const LIT: &str = r#"
camera = { origin = [0.0, 0.0, 4.0], target = [0.0, 0.0, 0.0], up = [0, 1, 0], vfov = 60.0 }
mesh = [{ file = "a.obj" }, { file = "./a.obj", scale = 0.5, material = "n" }]
material.n = { ks = [1, 1, 1], ke = [0.5, 0.25, 0.125], illum = 3, d = 0.5 }
material."my wood" = { kd = [0.1, 0.2, 0.3] }
"#;

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0.5 1\nv 0 1 0\nv 1 1 0 1 1 1\nvt 0 1\nvn 0 0.5 1\nvn 0 0 0\no a\n\
                   usemtl m\nf 1/1/1 2/1/1 4/1/2 3/1/1\ng b\nusemtl n\nf -1//1 -2//1 -3//1\ns off\nf 1 2 3\nusemtl m\nf 3 2 1 4\n\
                   l 1 2\ncurv 1 2 3\n";

const MTL: &str = "newmtl m\nKd 0.1 0.2 0.3\nKe 1 2 3\nnewmtl n\nKs 1 1 1\nillum 7\nNi 1.5\nd 0.5\n\
                   map_Kd -s 1 1 1 my x.png\nKa 0 0 0\nTr 0\nPr 0.5\nbump b.png\nzz 1\n";

/// Pictures as bytes, written beside `folder`.
pub fn pictures(folder: &Path) -> Vec<Vec<u8>> {
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
    ];
    let mut pictures = Vec::new();
    for (i, compression) in compressions.into_iter().enumerate() {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(8, 8))] {
            let half = i % 2 == 1;
            let sample = |at: usize| (at as f32 * 0.37).sin().abs() * 3.0;
            let channel = |name: &'static str, shift: usize| match half {
                false => {
                    AnyChannel::new(name, FlatSamples::F32((0..SIZE.0 * SIZE.1).map(|at| sample(at + shift)).collect()))
                }
                true => AnyChannel::new(
                    name,
                    FlatSamples::F16((0..SIZE.0 * SIZE.1).map(|at| f16::from_f32(sample(at + shift))).collect()),
                ),
            };
            let names = ["B", "G", "R", "variance.B", "variance.G", "variance.R", "depth.Z"];
            let list = names.into_iter().enumerate().map(|(shift, name)| channel(name, shift)).collect();
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            let layer = Layer::new(SIZE, LayerAttributes::named("p"), encoding, AnyChannels::sort(list));
            let layers = if i < 2 {
                vec![layer]
            } else {
                vec![layer.clone(), Layer { attributes: LayerAttributes::named("q"), ..layer }]
            };
            let attributes = exr::prelude::ImageAttributes::new(exr::prelude::IntegerBounds::from_dimensions(SIZE));
            let path = folder.join("original.exr");
            Image::from_layers(attributes, layers).write().to_file(&path).expect("a picture can be written");
            pictures.push(std::fs::read(&path).expect("it was written"));
        }
    }
    pictures
}

/// Pixels of a picture.
const SIZE: (usize, usize) = (19, 13);
