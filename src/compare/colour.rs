//! Colour spaces of FLIP: linear Rec. 709 to YCxCz and to CIELAB, with the constants of its reference code.

/// Linear Rec. 709 to CIE XYZ (10,135,552 / 24,577,794 and so on in the reference code).
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];
/// CIE XYZ to linear Rec. 709.
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.241_003_232_976_358, -1.537_398_969_488_785, -0.498_615_881_996_363],
    [-0.969_224_252_202_516, 1.875_929_983_695_176, 0.041_554_226_340_085],
    [0.055_639_419_851_975, -0.204_011_206_123_910, 1.057_148_977_187_533],
];

fn times(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ of white.
fn white() -> [f64; 3] {
    times(&TO_XYZ, [1.0; 3])
}

/// Linear Rec. 709 to YCxCz: opponent colours in which filters act on contrast.
pub fn ycxcz(rgb: [f64; 3]) -> [f64; 3] {
    let xyz = times(&TO_XYZ, rgb);
    let white = white();
    let [x, y, z] = [0, 1, 2].map(|i| xyz[i] / white[i]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// YCxCz to linear Rec. 709.
pub fn from_ycxcz([y, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (y + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    let white = white();
    times(&FROM_XYZ, [0, 1, 2].map(|i| relative[i] * white[i]))
}

/// Linear Rec. 709 to CIELAB with Hunt's adjustment: colour differences weigh less where it is dark.
pub fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    let xyz = times(&TO_XYZ, rgb);
    let white = white();
    let f = |t: f64| {
        let delta: f64 = 6.0 / 29.0;
        if t > delta.powi(3) { t.cbrt() } else { t / (3.0 * delta * delta) + 4.0 / 29.0 }
    };
    let [x, y, z] = [0, 1, 2].map(|i| f(xyz[i] / white[i]));
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// HyAB distance of two colours in CIELAB: city-block in lightness, Euclidean in colour.
pub fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_trips_and_known_colours() {
        for rgb in [[0.1, 0.5, 0.9], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 0.0]] {
            let back = from_ycxcz(ycxcz(rgb));
            assert!(rgb.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-6), "{rgb:?} {back:?}");
        }
        assert!((hunt_lab([1.0; 3])[0] - 100.0).abs() < 1e-9);
        // sRGB's green in CIELAB is (87.737, -86.185, 83.181); Hunt's adjustment scales the last two by 0.877.
        let green = hunt_lab([0.0, 1.0, 0.0]);
        assert!((green[0] - 87.737).abs() < 0.02 && (green[1] + 75.6).abs() < 0.1 && (green[2] - 72.98).abs() < 0.1);
        assert_eq!(hyab([1.0, 3.0, 0.0], [3.0, 0.0, 4.0]), 7.0);
    }
}
