//! A report that has everything: charts of both scales, whiskers, fits, bars, tables, pictures, and what is missing of
//! each.

use texray::report::{
    Axis, Bar, Bars, Block, Chart, NamedPicture, Pictures, Point, Report, Scale, Section, Series, Table,
};

/// Points of the sample's charts that have a place.
pub const POINTS: usize = 6 + 6 + 3 + 5;
/// Bars of the sample that have a length.
pub const BARS: usize = 3;
/// Pictures of the sample that can be drawn, differences included.
pub const PICTURES: usize = 3 + 2;

pub fn report() -> Report {
    Report {
        title: "Error <against> time & \"more\"".into(),
        findings: ["One.", "Two.", "Three.", "Four.", "Five."].map(String::from).into(),
        lead: vec!["Halving the error takes 4.0 times as long with independent samples, 3.1 times with Sobol'.".into()],
        facts: vec![
            ("device".into(), "llvmpipe".into()),
            ("command".into(), "texray study all --out docs/study".into()),
        ],
        sections: vec![charts(), bars(), table(), pictures(), gaps()],
    }
}

fn section(id: &str, title: &str, finding: &str, blocks: Vec<Block>) -> Section {
    Section {
        id: id.into(),
        title: title.into(),
        finding: vec![finding.into()],
        command: format!("texray study {id} scenes/cornell-box.toml --out DIR"),
        blocks,
    }
}

fn charts() -> Section {
    let spp = [1.0, 4.0, 16.0, 64.0, 256.0, 1024.0];
    let law = |scale: f64, slope: f64, scatter: f64| -> Vec<Point> {
        let wobble = |i: usize| 10f64.powf(scatter * [1.0, -1.3, 0.6, -0.8, 1.4, -0.9][i]);
        let of = |(i, &x): (usize, &f64)| {
            let y = scale * x.powf(slope) * wobble(i);
            Point { x, y, low: Some(y / 1.15), high: Some(y * 1.15) }
        };
        spp.iter().enumerate().map(of).collect()
    };
    let series = vec![
        Series::new("independent", law(0.9, -0.5, 0.02)).fitted(),
        Series::new("Sobol'", law(0.8, -0.61, 0.03)).fitted().default_if(true),
    ];
    let log = Chart {
        title: "Error against samples".into(),
        x: Axis::new("samples a pixel", "", Scale::Log),
        y: Axis::new("relative RMSE", "", Scale::Log),
        series,
    };
    let caps = [(1.0, 0.31), (2.0, 0.12), (3.0, 0.05), (5.0, 0.011), (8.0, f64::NAN)];
    let linear = Chart {
        title: "Energy cut by the bounce cap".into(),
        x: Axis::new("cap", "bounces", Scale::Linear),
        y: Axis::new("energy cut", "of all", Scale::Linear),
        series: vec![
            Series::new(
                "cornell-box",
                vec![
                    Point::new(1.0, 0.4),
                    Point { low: Some(0.02), high: Some(0.2), ..Point::new(2.0, 0.2) },
                    Point::new(3.0, 0.1),
                ],
            ),
            Series::new(
                "glass",
                caps.map(|(x, y)| Point::new(x, y)).into_iter().chain([Point::new(15.0, 1e-4)]).collect(),
            ),
        ],
    };
    let finding = "The error falls as samples to the −0.50 with independent numbers, −0.61 with Sobol'.";
    section("convergence", "Convergence", finding, vec![Block::Chart(log), Block::Chart(linear)])
}

fn bars() -> Section {
    let bar = |name: &str, value: f64, low: f64, high: f64| Bar {
        name: name.into(),
        value,
        low: Some(low),
        high: Some(high),
        is_default: false,
    };
    let bars = Bars {
        title: "What a guard costs".into(),
        unit: "% of the time".into(),
        bars: vec![
            bar("watertight triangles instead of Möller–Trumbore", 4.2, 3.1, 5.0),
            bar("padded boxes", 0.6, 0.1, 1.5).default_if(true),
            bar("compensated sums", -0.3, -1.2, 0.4),
            Bar {
                name: "not measured, and with a name that is longer than the width of a narrow screen".into(),
                value: f64::NAN,
                low: None,
                high: None,
                is_default: false,
            },
        ],
    };
    section("precision", "Guards", "All guards together cost 4.6 % of the time.", vec![Block::Bars(bars)])
}

fn table() -> Section {
    let row = |cells: [&str; 3]| cells.map(String::from).to_vec();
    let rows = vec![row(["cornell-box", "1.87", "38"]), row(["dragon", "0.50", ""]), vec!["room".into()]];
    let table = Table { columns: vec!["scene".into(), "Mpaths/s".into(), "triangles".into()], rows };
    let blocks = vec![Block::Table(table), Block::Text("A paragraph with <b>markup</b> in it.".into())];
    section("effects", "Effects", "Glass costs 1.3 times the time.", blocks)
}

/// A gradient with noise of a given size, by a fixed sequence.
fn picture(name: &str, [width, height]: [u32; 2], noise: f32) -> NamedPicture {
    let mut state = 1u32;
    let pixel = |i: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let random = (state >> 8) as f32 / 16_777_216.0 - 0.5;
        let base = (i % width) as f32 / width as f32;
        [base, base * 0.7, 0.3].map(|channel| (channel * (1.0 + noise * random)).max(0.0))
    };
    NamedPicture { name: name.into(), width, height, rgb: (0..width * height).map(pixel).collect() }
}

fn pictures() -> Section {
    let size = [96, 72];
    let mut broken = picture("10 spp, one pixel broken", size, 0.5);
    broken.rgb[40] = [f32::NAN, 0.0, 0.0];
    let pictures = Pictures {
        title: "The same view at 1, 10 and 1000 samples".into(),
        pictures: vec![picture("1000 spp", size, 0.0), picture("1 spp", size, 1.8), broken],
        reference: Some(0),
    };
    section("spp", "Pictures", "A thousand samples are 31.6 times as exact as one.", vec![Block::Pictures(pictures)])
}

/// Nothing here can be drawn, and the page says so.
fn gaps() -> Section {
    let axis = || Axis::new("x", "", Scale::Log);
    let chart = |series| Block::Chart(Chart { title: "Nothing".into(), x: axis(), y: axis(), series });
    let unfit = NamedPicture { name: "too few pixels".into(), width: 3, height: 3, rgb: vec![[0.0; 3]] };
    let blocks = vec![
        chart(Vec::new()),
        chart(vec![Series::new("empty", Vec::new()), Series::new("all zero", vec![Point::new(1.0, 0.0); 7]).fitted()]),
        Block::Bars(Bars::default()),
        Block::Table(Table::default()),
        Block::Pictures(Pictures::default()),
        Block::Pictures(Pictures { title: "Unfit".into(), pictures: vec![unfit], reference: Some(7) }),
    ];
    // The id of another section, and one that is no anchor.
    let mut section = section("spp", "Missing", "", blocks);
    section.finding.clear();
    section
}
