//! The study of transfer: what moving bytes between host and device takes, and how much of a render it is.
//!
//! Comes in: scenes and a device. Goes out: rows of two kinds. `copies`: gigabytes a second by size, way, number of copies in flight, kind
//! of buffer and, for writes and reads in place, memory type. The scenes: a whole render that reads records and path states from texel buffers or storage
//! buffers, and the shares of upload and readback in it.

mod copies;

use crate::gpu::{Context, Direction, HostMemoryType, host_memory_types};
use crate::render::Tuning;
use crate::report::{Axis, Block, Chart, Series, axis};
use crate::settings::{Buffers, Settings};
use crate::study::engine::schedule::interleaved;
use crate::study::engine::spread::digits;
use crate::study::engine::subject::Subjects;
use crate::study::engine::summary::{Summary, Table};
use crate::study::engine::{Kind, Plan, Row, Rows, Scenes, Step, Study, Values, Watch};
use crate::{Error, Result};
use copies::Copy;

/// What is stated of it.
pub const KIND: Kind = Kind {
    name: "transfer",
    help: "Gigabytes a second between host and device, and their share of a render",
    title: "Between host and device",
    scenes: Scenes::Chosen { full: &["cornell-box", "fetched/dragon-res2"], quick: &["cornell-box"] },
    summary: |rows, _| summary(rows),
    opens: |context, plan, _| Ok(Box::new(Transfer::new(context, plan)?)),
};

/// Sizes of copies in bytes.
const SIZES: [u64; 4] = [64 << 10, 1 << 20, 16 << 20, 128 << 20];
/// Name of what is measured without a scene.
const COPIES: &str = "copies";

/// How much is measured.
struct TransferWorkload {
    size: [u32; 2],
    spp: u32,
    repeats: u32,
    /// The largest copy in bytes.
    most_bytes: u64,
}

const FULL: TransferWorkload = TransferWorkload { size: [800, 600], spp: 16, repeats: 5, most_bytes: 128 << 20 };
const QUICK: TransferWorkload = TransferWorkload { size: [400, 300], spp: 8, repeats: 3, most_bytes: 128 << 20 };
const LEAST: TransferWorkload = TransferWorkload { size: [8, 6], spp: 1, repeats: 1, most_bytes: 1 << 20 };

/// One thing to measure.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Case {
    Copy(Copy, u64),
    Render(Buffers),
}

impl Case {
    fn name(&self, memory: &[HostMemoryType]) -> String {
        match self {
            Case::Copy(copy, bytes) => format!("{}, {}", copy.name(memory), size_name(*bytes)),
            Case::Render(buffers) => records_in(*buffers).into(),
        }
    }
}

/// Name in rows of a render.
fn records_in(buffers: Buffers) -> &'static str {
    match buffers {
        Buffers::Texel => "texel buffers",
        Buffers::Storage => "storage buffers",
    }
}

fn size_name(bytes: u64) -> String {
    match bytes >> 20 {
        0 => format!("{} KiB", bytes >> 10),
        mebibytes => format!("{mebibytes} MiB"),
    }
}

/// Every copy in every size that the device allows, then the renders.
fn cases(memory: &[HostMemoryType], most_texel_bytes: u64, most_storage_bytes: u64) -> Vec<Case> {
    let mut cases = Vec::new();
    for copy in Copy::all(memory.len()) {
        let most = if copy.is_texel() { most_texel_bytes } else { most_storage_bytes };
        cases.extend(SIZES.into_iter().filter(|&bytes| bytes <= most).map(|bytes| Case::Copy(copy, bytes)));
    }
    cases.extend([Buffers::Texel, Buffers::Storage].map(Case::Render));
    cases
}

/// The study.
pub struct Transfer {
    context: Context,
    subjects: Subjects,
    names: Vec<String>,
    memory: Vec<HostMemoryType>,
    workload: TransferWorkload,
    cases: Vec<Case>,
}

impl Transfer {
    /// The study of the plan's scenes.
    pub fn new(context: &Context, plan: &Plan) -> Result<Transfer> {
        let subjects = Subjects::new(context, &plan.scenes)?;
        if subjects.names().iter().any(|name| name == COPIES) {
            return Err(Error::Usage(format!("a scene named {COPIES}, which study transfer has for its own rows")));
        }
        let info = context.device_info();
        let memory = host_memory_types(context);
        let workload = plan.amount.of(FULL, QUICK, LEAST);
        let most = info.max_memory_allocation_size.min(workload.most_bytes);
        let texel = info.max_texel_buffer_elements.saturating_mul(16).min(most);
        Ok(Transfer {
            context: context.clone(),
            names: subjects.names().iter().cloned().chain([COPIES.into()]).collect(),
            cases: cases(&memory, texel, info.max_storage_buffer_range.min(most)),
            subjects,
            memory,
            workload,
        })
    }

    fn render(&mut self, step: Step, buffers: Buffers, watch: &dyn Watch) -> Result<Option<Values>> {
        let (size, spp) = (self.workload.size, self.workload.spp);
        let subject = self.subjects.at(step.scene)?;
        let settings = Settings { buffers, seed: u64::from(step.repeat), ..subject.settings(size, spp) };
        let Some(rendered) = subject.render_warm(&settings, &Tuning::default(), watch)? else { return Ok(None) };
        let (report, entries) = (rendered.report, rendered.ledger.entries());
        let device_seconds = |direction| {
            let of = entries.iter().filter(|entry| entry.direction == direction);
            of.map(|entry| entry.milliseconds).sum::<f64>() / 1e3
        };
        let seconds = report.seconds;
        Ok(Some(vec![
            ("bytes_up", report.bytes.uploaded as f64),
            ("bytes_down", report.bytes.read_back as f64),
            ("seconds_upload", seconds.upload),
            ("seconds_readback", seconds.readback),
            ("seconds_device_up", device_seconds(Direction::Up)),
            ("seconds_device_down", device_seconds(Direction::Down)),
            ("seconds_render", seconds.render),
            ("us_per_path", 1e6 * seconds.render / report.paths as f64),
            ("path_states_as_texels", f64::from(report.path_buffers == Buffers::Texel)),
        ]))
    }
}

impl Study for Transfer {
    fn scenes(&self) -> &[String] {
        &self.names
    }

    fn case(&self, case: usize) -> String {
        self.cases[case].name(&self.memory)
    }

    fn schedule(&self) -> Vec<Step> {
        let (copies, renders): (Vec<usize>, Vec<usize>) =
            (0..self.cases.len()).partition(|&place| matches!(self.cases[place], Case::Copy(..)));
        let scenes = self.subjects.names().len();
        let copies =
            interleaved(1, &copies, self.workload.repeats).into_iter().map(|step| Step { scene: scenes, ..step });
        copies.chain(interleaved(scenes, &renders, self.workload.repeats)).collect()
    }

    fn measure(&mut self, step: Step, watch: &mut dyn Watch) -> Result<Option<Values>> {
        match self.cases[step.case].clone() {
            Case::Render(buffers) => self.render(step, buffers, watch),
            Case::Copy(copy, bytes) => copy.measure(&self.context, &self.memory, bytes).map(Some),
        }
    }

    fn headline(&self, row: &Row) -> String {
        let figure = |name: &str| row.values.get(name).copied();
        match (figure("gb_per_second"), figure("seconds_render")) {
            (Some(rate), _) => format!("{} GB/s", digits(rate)),
            (None, Some(seconds)) => format!("rendered in {} s", digits(seconds)),
            (None, None) => String::new(),
        }
    }
}

/// What the rows say.
pub fn summary(rows: &Rows) -> Summary {
    let mut summary = copies(rows);
    for scene in rows.scenes().into_iter().filter(|&scene| scene != COPIES) {
        summary.extend(shares(rows, scene));
    }
    summary
}

/// The way in which a render uploads its records.
const DEFAULT_WAY: &str = "up, staged, 2 in flight, texel";

fn copies(rows: &Rows) -> Summary {
    // A case is named by its way and its size.
    let mut ways: Vec<&str> = Vec::new();
    for row in rows.all().iter().filter(|row| row.scene == COPIES) {
        if let Some((way, _)) = row.case.rsplit_once(", ")
            && !ways.contains(&way)
        {
            ways.push(way);
        }
    }
    let mut summary = Summary::default();
    if ways.is_empty() {
        return summary;
    }
    let rate = |way: &str, bytes: u64| rows.spread(COPIES, &format!("{way}, {}", size_name(bytes)), "gb_per_second");
    let head: Vec<String> = ["copy".to_owned()].into_iter().chain(SIZES.map(size_name)).collect();
    let title =
        "Gigabytes a second between host and device, medians; staged copies include the host's own write or read";
    let mut table = Table { title: title.into(), head, rows: Vec::new() };
    let mut series = Vec::new();
    for &way in &ways {
        let rates = SIZES.map(|bytes| rate(way, bytes));
        let cells = rates.map(|rate| rate.map_or("-".into(), |rate| digits(rate.median)));
        table.rows.push([way.to_owned()].into_iter().chain(cells).collect());
        let points = SIZES.into_iter().zip(rates).filter_map(|(bytes, rate)| Some(rate?.point(bytes as f64)));
        series.push(Series::new(way, points.collect()).default_if(way == DEFAULT_WAY));
    }
    summary.figure(Block::Chart(Chart {
        title: "Copies between host and device".into(),
        x: Axis::new("size of a copy", "bytes", axis::Scale::Log),
        y: Axis::new("rate", "GB/s", axis::Scale::Log),
        series,
    }));
    summary.table(table);
    let large = |way: &str| Some(digits(rate(way, 16 << 20)?.median));
    let names = [
        "up, staged, 1 in flight, texel",
        "up, staged, 2 in flight, texel",
        "up, staged, 2 in flight, storage",
        "down, staged, 2 in flight",
    ];
    if let [Some(one), Some(two), Some(storage), Some(down)] = names.map(large) {
        summary.findings.push(format!(
            "Copies of 16 MiB go up at {one} GB/s with one in flight and {two} with two ({storage} into a storage buffer), and come \
             down at {down} GB/s with two in flight."
        ));
    }
    summary
}

fn shares(rows: &Rows, scene: &str) -> Summary {
    let title = format!("{scene}: transfer in a whole render");
    let mut table =
        Table::new(title, &["records in", "MB up", "s upload", "MB down", "s readback", "s render", "us a path"]);
    let median = |buffers, value: &str| rows.median(scene, records_in(buffers), value);
    for buffers in [Buffers::Texel, Buffers::Storage] {
        if median(buffers, "seconds_render").is_none() {
            continue;
        }
        let text = |value: &str, workload: f64| median(buffers, value).map_or("?".into(), |v| digits(v / workload));
        table.rows.push(vec![
            records_in(buffers).into(),
            text("bytes_up", 1e6),
            text("seconds_upload", 1.0),
            text("bytes_down", 1e6),
            text("seconds_readback", 1.0),
            text("seconds_render", 1.0),
            text("us_per_path", 1.0),
        ]);
    }
    let mut summary = Summary::default();
    summary.table(table);
    let texel = |value| median(Buffers::Texel, value);
    // Path states do not fit every device's texel buffers; then both runs read them from storage.
    let what = if texel("path_states_as_texels") == Some(1.0) { "records and path states" } else { "records" };
    if let (Some(up), Some(down), Some(render), Some(path), Some(storage)) = (
        texel("seconds_upload"),
        texel("seconds_readback"),
        texel("seconds_render"),
        texel("us_per_path"),
        median(Buffers::Storage, "us_per_path"),
    ) {
        summary.plain.push(format!(
            "{scene}: copies between processor and device take {:.1} % of a render's time.",
            100.0 * (up + down) / (up + render)
        ));
        summary.findings.push(format!(
            "{scene}: packing and upload take {:.2} % of a render's time, waiting for and adding up what comes back {:.2} %; a path takes \
             {} times as long with {what} read from storage buffers as from texel buffers.",
            100.0 * up / (up + render),
            100.0 * down / (up + render),
            digits(storage / path)
        ));
    }
    summary
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_device_does_not_allow_is_not_asked_of_it() {
        let all = cases(&[], u64::MAX, u64::MAX);
        let few = cases(&[], 1 << 20, u64::MAX);
        let texels =
            |cases: &[Case]| cases.iter().filter(|case| matches!(case, Case::Copy(copy, _) if copy.is_texel())).count();
        assert_eq!((texels(&all), texels(&few)), (8, 4));
        assert_eq!(all.last(), Some(&Case::Render(Buffers::Storage)));
        assert_eq!((size_name(64 << 10), size_name(128 << 20)), ("64 KiB".into(), "128 MiB".into()));
    }

    #[test]
    fn shares_are_of_upload_and_render_together() {
        let values = |path| {
            [
                ("bytes_up", 2e6),
                ("bytes_down", 8e6),
                ("seconds_upload", 0.1),
                ("seconds_readback", 0.05),
                ("seconds_render", 0.9),
                ("us_per_path", path),
            ]
        };
        let figures = [("texel buffers", values(1.0)), ("storage buffers", values(1.25))];
        let rows: Vec<_> = figures.iter().map(|(case, values)| ("box", *case, 0, &values[..])).collect();
        let summary = shares(&Rows::synthetic(&rows), "box");
        assert_eq!(summary.tables()[0].rows[0][1..4], ["2.00", "0.100", "8.00"]);
        let finding = &summary.findings[0];
        assert!(
            finding.contains("10.00 %") && finding.contains("5.00 %") && finding.contains("1.25 times"),
            "{finding}"
        );
        assert!(summary.lines().iter().all(|line| line.chars().count() <= 80), "{:#?}", summary.lines());
    }
}
