//! Which files are pictures, and which are refused.

use std::fs;

use exr::prelude::{FlatSamples, f16};

use super::folder::{Folder, HEIGHT, Plane, WIDTH, channel, pictures, planes, write_at};
use super::near;

/// Half floats, prefixes, one channel, layers to choose from: what other renderers write.
#[test]
fn files_of_other_renderers() {
    let folder = Folder::new();
    let (noisy, clean) = pictures();
    folder.write("clean.exr", &clean);
    folder.write("noisy.exr", &noisy);
    let expected = folder.json(&["noisy.exr", "clean.exr"], 0)["figures"]["relative_mse"].as_f64().expect("a number");

    let half = |i: usize| FlatSamples::F16(channel(&noisy, i).into_iter().map(f16::from_f32).collect());
    let blender = [
        Plane("View.Combined.R", half(0)),
        Plane("View.Combined.G", half(1)),
        Plane("View.Combined.B", half(2)),
        Plane("View.Combined.A", FlatSamples::F32(vec![1.0; WIDTH * HEIGHT])),
        Plane("View.Depth.Z", FlatSamples::U32(vec![7; WIDTH * HEIGHT])),
    ];
    write_at(&folder.at("half.exr"), (WIDTH, HEIGHT), (0, 0), blender.into());
    let found = folder.json(&["half.exr", "clean.exr"], 0);
    assert_eq!(found["layer"], "View.Combined");
    // Half floats round by 2^-11 at most, against noise of a sixth: less than a hundredth of the squared error.
    near(&found["figures"]["relative_mse"], expected, 0.01 * expected);

    let mut two = planes(["beauty.R", "beauty.G", "beauty.B"], &noisy);
    two.extend(planes(["albedo.R", "albedo.G", "albedo.B"], &clean));
    write_at(&folder.at("two.exr"), (WIDTH, HEIGHT), (0, 0), two);
    let message = folder.refused(&["two.exr", "clean.exr"], 3);
    assert!(message.contains("name one with --layer, of \"albedo\", \"beauty\""), "{message}");
    near(&folder.json(&["two.exr", "clean.exr", "--layer", "beauty"], 0)["figures"]["relative_mse"], expected, 0.0);
    near(&folder.json(&["two.exr", "clean.exr", "--layer", "albedo"], 0)["figures"]["rmse"], 0.0, 0.0);
    let message = folder.refused(&["clean.exr", "two.exr", "--reference-layer", "depth"], 3);
    assert!(message.contains("no layer \"depth\""), "{message}");

    let grey = vec![Plane("Y", FlatSamples::F32(channel(&clean, 1)))];
    write_at(&folder.at("grey.exr"), (WIDTH, HEIGHT), (0, 0), grey);
    near(&folder.json(&["grey.exr", "grey.exr"], 0)["figures"]["rmse"], 0.0, 0.0);
}

/// RenderMan's, V-Ray's and Gaffer's names, layers in another letter case, and what only looks like a colour.
#[test]
fn channels_are_found_under_the_names_of_other_renderers() {
    let folder = Folder::new();
    let (noisy, clean) = pictures();
    folder.write("clean.exr", &clean);
    folder.write("noisy.exr", &noisy);
    let expected = folder.json(&["noisy.exr", "clean.exr"], 0)["figures"]["relative_mse"].as_f64().expect("a number");
    for (names, layer) in [
        (["Ci.r", "Ci.g", "Ci.b"], "Ci"),
        ([".R", ".G", ".B"], ""),
        (["r", "g", "b"], ""),
        (["Beauty.R", "Beauty.G", "Beauty.B"], "Beauty"),
    ] {
        let mut all = planes(names, &noisy);
        // A normal and a position: neither is a picture.
        all.extend(planes(["N.x", "N.y", "N.z"], &clean));
        all.extend(planes(["P.X", "P.Y", "P.Z"], &clean));
        write_at(&folder.at("other.exr"), (WIDTH, HEIGHT), (0, 0), all);
        let found = folder.json(&["other.exr", "clean.exr"], 0);
        assert_eq!(found["layer"], layer);
        near(&found["figures"]["relative_mse"], expected, 0.0);
        let by_name = folder.json(&["other.exr", "clean.exr", "--layer", &layer.to_uppercase()], 0);
        near(&by_name["figures"]["relative_mse"], expected, 0.0);
    }
    let mut two = planes(["Beauty.R", "Beauty.G", "Beauty.B"], &noisy);
    two.extend(planes(["BEAUTY.R", "BEAUTY.G", "BEAUTY.B"], &clean));
    write_at(&folder.at("two.exr"), (WIDTH, HEIGHT), (0, 0), two);
    near(&folder.json(&["two.exr", "clean.exr", "--layer", "BEAUTY"], 0)["figures"]["rmse"], 0.0, 0.0);
    assert!(folder.refused(&["two.exr", "clean.exr", "--layer", "beauty"], 3).contains("no layer \"beauty\""));
}

/// A pipe is read to its end, and a picture of another format is told what is compared.
#[test]
fn pipes_are_read_and_other_formats_named() {
    let folder = Folder::new();
    let (noisy, clean) = pictures();
    folder.write("clean.exr", &clean);
    folder.write("noisy.exr", &noisy);
    if cfg!(unix) {
        let line = format!("'{}' compare <(cat noisy.exr) <(sleep 0.2; cat noisy.exr)", env!("CARGO_BIN_EXE_texray"));
        let bash = std::process::Command::new("bash").current_dir(folder.at("")).args(["-c", &line]).output();
        let bash = bash.expect("bash runs");
        let text = String::from_utf8_lossy(&bash.stdout);
        assert!(bash.status.success() && text.contains("infinite: the pictures are equal"), "{bash:?}");
    }
    for (start, name) in
        [(&b"\x89PNG\r\n\x1a\n"[..], "a PNG"), (b"\xff\xd8\xff\xe0", "a JPEG"), (b"#?RADIANCE\n", "a Radiance HDR")]
    {
        fs::write(folder.at("other.exr"), start).expect("a file can be written");
        let message = folder.refused(&["other.exr", "clean.exr"], 3);
        assert!(
            message.starts_with(&format!("error: other.exr: this is {name}, and compare takes OpenEXR")),
            "{message}"
        );
    }
}

#[test]
fn what_is_no_picture_or_another_window_is_refused_by_name() {
    let folder = Folder::new();
    let (noisy, clean) = pictures();
    folder.write("clean.exr", &clean);
    let rgb = ["R", "G", "B"];
    write_at(&folder.at("wide.exr"), (HEIGHT, WIDTH), (0, 0), planes(rgb, &noisy));
    write_at(&folder.at("moved.exr"), (WIDTH, HEIGHT), (3, -2), planes(rgb, &noisy));
    let message = folder.refused(&["wide.exr", "clean.exr"], 2);
    assert!(
        message.contains("wide.exr: its data window is 48x64 at (0, 0), that of clean.exr is 64x48 at (0, 0)"),
        "{message}"
    );
    let message = folder.refused(&["moved.exr", "clean.exr"], 2);
    assert!(message.contains("64x48 at (3, -2)"), "{message}");
    // Both moved alike: the same pixels of the image.
    assert_eq!(folder.json(&["moved.exr", "moved.exr"], 0)["figures"]["rmse"], 0.0);

    write_at(&folder.at("depth.exr"), (WIDTH, HEIGHT), (0, 0), vec![Plane("Z", FlatSamples::F32(channel(&clean, 0)))]);
    let message = folder.refused(&["depth.exr", "clean.exr"], 3);
    assert!(message.contains("depth.exr: channels R, G, B or Y needed, Z found"), "{message}");
    fs::write(folder.at("text.exr"), "not a picture").expect("a file can be written");
    let whole = fs::read(folder.at("clean.exr")).expect("it is there");
    fs::write(folder.at("cut.exr"), &whole[..whole.len() / 2]).expect("a file can be written");
    // A header that claims a data window of 2^29 columns: its last column follows the attribute's name, type, size and
    // corner.
    let mut vast = whole.clone();
    let start = b"dataWindow\0box2i\0\x10\0\0\0";
    let at = vast.windows(start.len()).position(|bytes| bytes == start).expect("a data window") + start.len() + 8;
    vast[at..at + 4].copy_from_slice(&(1i32 << 29).to_le_bytes());
    fs::write(folder.at("vast.exr"), vast).expect("a file can be written");
    let message = folder.refused(&["vast.exr", "clean.exr"], 3);
    let text = "vast.exr: not a readable OpenEXR file: the pixels of its header take at least ";
    assert!(message.contains(text) && message.contains(&format!("and it has {}", whole.len())), "{message}");
    for name in ["text.exr", "cut.exr", "missing.exr"] {
        let message = folder.refused(&[name, "clean.exr"], 3);
        assert!(message.starts_with(&format!("error: {name}: not a readable OpenEXR file")), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}
