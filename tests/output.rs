//! Picture files: exact EXR, deterministic bytes, windows, 8-bit sRGB, refusals before rendering, nothing left behind.

use std::fs;
use std::path::Path;

use exr::prelude::{ReadChannels, ReadLayers, read, read_all_flat_layers_from_file};
use texray::Error;
use texray::output::{Display, Layer, Metadata, OutputFile, Picture, Tonemap, write_whole};

fn sample(crop: Option<[u32; 4]>) -> Picture {
    let [_, _, width, height] = crop.unwrap_or([0, 0, 37, 21]);
    let value = |i: u32| [i as f32 * 0.1, 1e-30 * i as f32, 1e30 / (i + 1) as f32];
    Picture::new(37, 21, crop, (0..width * height).map(value).collect()).unwrap()
}

fn metadata() -> Metadata {
    let mut metadata = Metadata::new();
    for key in ["scene", "spp", "seed", "device", "driver", "filter", "sampler", "lights"] {
        metadata.fixed(key, format!("value of {key}"));
    }
    metadata.fixed("scene", "Zürich 東京").varying("seconds", 12.5);
    metadata
}

fn write(path: &Path, picture: &Picture) {
    OutputFile::check(path, false).unwrap().write(picture, &Display::default(), &metadata()).unwrap();
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn exr_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    for (name, crop) in [("whole.exr", None), ("crop.exr", Some([5, 3, 20, 11]))] {
        let (path, picture) = (folder.path().join(name), sample(crop));
        write(&path, &picture);
        let (width, height) = (picture.width as usize, picture.height as usize);
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(
                move |_, _| vec![[0f32; 3]; width * height],
                move |pixels: &mut Vec<[f32; 3]>, at, (r, g, b): (f32, f32, f32)| {
                    pixels[at.y() * width + at.x()] = [r, g, b];
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_file(&path)
            .unwrap();
        assert_eq!(image.layer_data.channel_data.pixels, picture.rgb);
        assert_eq!(image.layer_data.size.0, width);
        let position = image.layer_data.attributes.layer_position;
        assert_eq!((position.0, position.1), (picture.x as i32, picture.y as i32));
        let window = image.attributes.display_window;
        assert_eq!((window.position.0, window.position.1, window.size.0, window.size.1), (0, 0, 37, 21));
        let attributes = &image.layer_data.attributes.other;
        assert_eq!(attributes.len(), 8, "times are left out");
        assert!(fs::read(&path).unwrap().windows("Zürich 東京".len()).any(|bytes| bytes == "Zürich 東京".as_bytes()));
    }
}

#[test]
fn layers_stand_beside_the_colour() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.exr");
    let values = |scale: f32| (0..37 * 21).map(|i| i as f32 * scale).collect::<Vec<_>>();
    let variance =
        Layer { name: "variance", channels: vec![("R", values(1.0)), ("G", values(2.0)), ("B", values(f32::NAN))] };
    let samples = Layer { name: "samples", channels: vec![("Y", values(16.0))] };
    let picture = sample(None).with_layers(vec![variance, samples]).unwrap();
    write(&path, &picture);
    let image = read_all_flat_layers_from_file(&path).unwrap();
    let channels = &image.layer_data[0].channel_data.list;
    let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["B", "G", "R", "samples.Y", "variance.B", "variance.G", "variance.R"]);
    let bits = |at: usize| channels[at].sample_data.values_as_f32().map(f32::to_bits).collect::<Vec<_>>();
    let expected = |scale: f32| values(scale).into_iter().map(f32::to_bits).collect::<Vec<_>>();
    assert_eq!((bits(3), bits(4), bits(6)), (expected(16.0), expected(f32::NAN), expected(1.0)));
    assert_eq!(bits(2), picture.rgb.iter().map(|rgb| rgb[0].to_bits()).collect::<Vec<_>>());

    let short = Layer { name: "samples", channels: vec![("Y", vec![0.0; 5])] };
    assert!(sample(None).with_layers(vec![short]).unwrap_err().to_string().contains("samples"));
}

#[test]
fn exr_bytes_depend_on_the_picture_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write(&path, &sample(None));
    let first = fs::read(&path).unwrap();
    for round in 0..20 {
        let mut metadata = metadata();
        metadata.varying("seconds", round);
        OutputFile::check(&path, false).unwrap().write(&sample(None), &Display::default(), &metadata).unwrap();
        assert!(fs::read(&path).unwrap() == first, "round {round}");
    }
}

#[test]
fn png_is_marked_srgb_and_tells_everything() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.PNG");
    let picture =
        Picture::new(4, 1, None, vec![[0.0; 3], [0.18; 3], [f32::INFINITY; 3], [-1.0, f32::NAN, 0.5]]).unwrap();
    write(&path, &picture);
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(&path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    assert!(reader.info().srgb.is_some());
    let text: Vec<_> =
        reader.info().uncompressed_latin1_text.iter().map(|t| (t.keyword.clone(), t.text.clone())).collect();
    assert!(text.contains(&("seconds".into(), "12.5".into())), "{text:?}");
    assert!(text.contains(&("spp".into(), "value of spp".into())));
    let utf8: Vec<_> = reader.info().utf8_text.iter().map(|t| t.get_text().unwrap()).collect();
    assert_eq!(utf8, ["Zürich 東京"]);
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    assert_eq!(pixels, [0, 0, 0, 118, 118, 118, 255, 255, 255, 0, 0, 188]);
}

#[test]
fn exposure_and_tonemap_reach_the_png() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let picture = Picture::new(1, 1, None, vec![[0.5; 3]]).unwrap();
    let display = Display { exposure_stops: 1.0, tonemap: Tonemap::Reinhard };
    OutputFile::check(&path, false).unwrap().write(&picture, &display, &Metadata::new()).unwrap();
    assert_eq!(image::open(&path).unwrap().to_rgb8().into_raw(), [188; 3]);
}

/// An HDR file has 8 bits of mantissa for the largest channel: relative error below 2^-7.
#[test]
fn hdr_keeps_range() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdr");
    let values = [0.0f32, 1e-5, 0.3, 1.0, 12345.0, 1e20];
    let bad = [f32::NAN, f32::INFINITY, -1.0, 1e-40];
    let picture = Picture::new(10, 1, None, values.iter().chain(&bad).map(|&value| [value; 3]).collect()).unwrap();
    write(&path, &picture);
    let back = image::open(&path).unwrap().to_rgb32f();
    for (i, &value) in values.iter().enumerate() {
        let read = back.get_pixel(i as u32, 0).0[0];
        assert!((read - value).abs() <= value / 128.0, "{read} for {value}");
    }
    let tail: Vec<f32> = (6..10).map(|i| back.get_pixel(i, 0).0[0]).collect();
    assert_eq!((tail[0], tail[2], tail[3]), (0.0, 0.0, 0.0));
    assert!(tail[1] > 9e37);
}

#[test]
fn refusals_come_before_rendering() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("there.png"), "old").unwrap();
    fs::create_dir(at("folder.png")).unwrap();
    let check = |name: &str, no_clobber| OutputFile::check(&at(name), no_clobber).unwrap_err();
    for name in ["a.jpg", "a", ".exr", "a.exr.bak"] {
        assert!(matches!(check(name, false), Error::Usage(_)), "{name}");
    }
    assert_eq!(check("a.tiff", false).exit_code(), 2);
    for (name, no_clobber) in [("missing/a.exr", false), ("folder.png", false), ("there.png", true)] {
        let error = check(name, no_clobber);
        assert_eq!(error.exit_code(), 5, "{error}");
        assert!(error.to_string().contains(name), "{error}");
    }
    assert!(OutputFile::check(&at("there.png"), false).is_ok());
    assert_eq!(names(folder.path()), ["folder.png", "there.png"], "checks leave nothing behind");
}

#[test]
fn a_failure_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("there.json");
    fs::write(&path, "old").unwrap();
    assert!(matches!(write_whole(&path, true, b"new"), Err(Error::Output { .. })));
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert!(write_whole(&folder.path().join("missing/a"), false, b"new").is_err());
    assert_eq!(names(folder.path()), ["there.json"]);
    write_whole(&path, false, b"new").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    assert_eq!(names(folder.path()), ["there.json"]);
}

/// The mode is that of any other new file of this process, and a symbolic link stays one.
#[cfg(unix)]
#[test]
fn modes_and_links_are_the_users() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("plain"), "").unwrap();
    write_whole(&at("ours"), false, b"").unwrap();
    let mode = |name: &str| fs::metadata(at(name)).unwrap().permissions().mode();
    assert_eq!(mode("ours"), mode("plain"));
    std::os::unix::fs::symlink(at("plain"), at("link")).unwrap();
    write_whole(&at("link"), false, b"through").unwrap();
    assert!(at("link").is_symlink());
    assert_eq!(fs::read(at("plain")).unwrap(), b"through");
}

#[test]
fn windows_are_checked() {
    for crop in [[0, 0, 0, 1], [30, 0, 8, 1], [0, 21, 1, 1], [u32::MAX, 0, 2, 1]] {
        assert!(matches!(Picture::new(37, 21, Some(crop), vec![[0.0; 3]; 8]), Err(Error::Internal(_))), "{crop:?}");
    }
    assert!(Picture::new(37, 21, None, vec![[0.0; 3]; 8]).is_err());
    assert!(!sample(None).is_crop());
}
