//! The transfer ledger: every byte copied between CPU and GPU, and why.
//!
//! Comes in: an entry a copy, from [`Uploader`](super::Uploader) and [`Readback`](super::Readback), in the moment the copy
//! is recorded. Goes out: the entries, totals, a table. Copies that differ in nothing but when they were made share an
//! entry, so a long render's ledger stays short. Times arrive when the work has ended: read the ledger after the waits.

use std::fmt::Write as _;

use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::timer::Clock;

/// Which way the bytes went.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// From the host to the device.
    Up,
    /// From the device to the host.
    Down,
    /// Nowhere: the buffer was not needed and neither made nor copied.
    Absent,
}

/// Copies of one kind into or out of one buffer.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct LedgerEntry {
    /// Name of the device's buffer.
    pub buffer: String,
    /// Which way.
    pub direction: Direction,
    /// Bytes of all the copies.
    pub bytes: u64,
    /// Number of copies.
    pub copies: u32,
    /// Memory that the bytes arrived in.
    pub memory_type: String,
    /// "staged": through a buffer that both sides reach.
    pub how: String,
    /// The barriers around the copy, writer -> reader.
    pub barrier: String,
    /// What the device took for the copies of at least 64 KiB, by timestamps; 0 where the queue has none. (Around a
    /// smaller copy the timestamps would take longer than the copy: 30 microseconds on lavapipe.)
    pub milliseconds: f64,
    /// What the bytes are needed for.
    pub why: String,
}

/// The ledger.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    lines: Vec<(LedgerEntry, Clock)>,
}

impl Ledger {
    /// The entries, in order of first copy, with the times known so far.
    pub fn entries(&self) -> Vec<LedgerEntry> {
        let lines = self.lines.iter();
        lines.map(|(entry, clock)| LedgerEntry { milliseconds: clock.milliseconds(), ..entry.clone() }).collect()
    }

    /// Bytes copied from host to device.
    pub fn bytes_up(&self) -> u64 {
        self.total(Direction::Up)
    }

    /// Bytes copied from device to host.
    pub fn bytes_down(&self) -> u64 {
        self.total(Direction::Down)
    }

    /// Notes a buffer that was not needed, and why.
    pub fn absent(&mut self, buffer: &str, why: &str) {
        self.add(LedgerEntry {
            buffer: buffer.to_string(),
            direction: Direction::Absent,
            bytes: 0,
            copies: 0,
            memory_type: String::new(),
            how: String::new(),
            barrier: String::new(),
            milliseconds: 0.0,
            why: why.to_string(),
        });
    }

    /// A table of at most 80 columns: a line a buffer and direction, then the totals.
    pub fn table(&self) -> String {
        let mut rows: Vec<LedgerEntry> = Vec::new();
        for entry in self.entries() {
            match rows.iter_mut().find(|row| row.buffer == entry.buffer && row.direction == entry.direction) {
                Some(row) => {
                    row.bytes += entry.bytes;
                    row.copies += entry.copies;
                    row.milliseconds += entry.milliseconds;
                }
                None => rows.push(entry),
            }
        }
        let mut text = String::new();
        let mut line = |cells: [&str; 6]| {
            let [buffer, way, bytes, copies, ms, why] = cells;
            let (buffer, why) = (cut(buffer, 18), cut(why, 22));
            let row = format!("{buffer:<18} {way:<6} {bytes:>13} {copies:>6} {ms:>9} {why}");
            let _ = writeln!(text, "{}", row.trim_end());
        };
        line(["buffer", "way", "bytes", "copies", "ms", "why"]);
        for row in &rows {
            let way = match row.direction {
                Direction::Up => "up",
                Direction::Down => "down",
                Direction::Absent => "absent",
            };
            let ms = format!("{:.3}", row.milliseconds);
            match row.direction {
                Direction::Absent => line([&row.buffer, way, "-", "-", "-", &row.why]),
                _ => line([&row.buffer, way, &row.bytes.to_string(), &row.copies.to_string(), &ms, &row.why]),
            }
        }
        for (way, direction) in [("up", Direction::Up), ("down", Direction::Down)] {
            let matching = || rows.iter().filter(|row| row.direction == direction);
            let copies = matching().map(|row| row.copies).sum::<u32>();
            let ms = format!("{:.3}", matching().map(|row| row.milliseconds).sum::<f64>());
            line(["total", way, &self.total(direction).to_string(), &copies.to_string(), &ms, ""]);
        }
        text
    }

    /// Enters a copy and returns the clock for its time.
    pub(super) fn add(&mut self, entry: LedgerEntry) -> Clock {
        fn key(entry: &LedgerEntry) -> (Direction, [&str; 5]) {
            (entry.direction, [&entry.buffer, &entry.memory_type, &entry.how, &entry.barrier, &entry.why])
        }
        if let Some((line, clock)) = self.lines.iter_mut().find(|(line, _)| key(line) == key(&entry)) {
            line.bytes += entry.bytes;
            line.copies += entry.copies;
            return clock.clone();
        }
        let clock = Clock::default();
        self.lines.push((entry, clock.clone()));
        clock
    }

    fn total(&self, direction: Direction) -> u64 {
        self.lines.iter().filter(|(entry, _)| entry.direction == direction).map(|(entry, _)| entry.bytes).sum()
    }
}

impl Serialize for Ledger {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut ledger = serializer.serialize_struct("Ledger", 3)?;
        ledger.serialize_field("bytes_up", &self.bytes_up())?;
        ledger.serialize_field("bytes_down", &self.bytes_down())?;
        ledger.serialize_field("entries", &self.entries())?;
        ledger.end()
    }
}

/// `text` in at most `width` characters, a cut marked by `…`.
fn cut(text: &str, width: usize) -> String {
    match text.chars().count() > width {
        true => text.chars().take(width - 1).chain(['…']).collect(),
        false => text.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn up(buffer: &str, bytes: u64, why: &str) -> LedgerEntry {
        LedgerEntry {
            buffer: buffer.to_string(),
            direction: Direction::Up,
            bytes,
            copies: 1,
            memory_type: "device-local, heap 0".to_string(),
            how: "staged".to_string(),
            barrier: "transfer write -> compute shader read/write".to_string(),
            milliseconds: 0.0,
            why: why.to_string(),
        }
    }

    #[test]
    fn like_copies_share_an_entry_and_its_clock() {
        let mut ledger = Ledger::default();
        for bytes in [100, 28] {
            ledger.add(up("nodes", bytes, "the tree")).add(std::time::Duration::from_millis(2));
        }
        ledger.add(up("nodes", 1, "another reason"));
        let entries = ledger.entries();
        assert_eq!(entries.len(), 2);
        assert_eq!((entries[0].bytes, entries[0].copies, entries[0].milliseconds), (128, 2, 4.0));
        assert_eq!((ledger.bytes_up(), ledger.bytes_down()), (129, 0));
    }

    #[test]
    fn the_table_adds_up_by_buffer_and_fits_eighty_columns() {
        let mut ledger = Ledger::default();
        ledger.add(up("a name that is much too long to fit", 123_456_789_012, "and a reason that is longer still"));
        ledger.add(up("nodes", 64, "the tree"));
        ledger.add(up("nodes", 64, "the tree, again"));
        ledger.absent("corners", "no triangle is smooth");
        let table = ledger.table();
        assert!(table.lines().all(|line| line.chars().count() <= 80), "{table}");
        assert!(table.lines().any(|line| line.starts_with("nodes") && line.contains(" 128 ")), "{table}");
        assert!(table.lines().any(|line| line.starts_with("corners") && line.contains("absent")), "{table}");
        assert!(table.contains("123456789140"), "{table}");
    }

    #[test]
    fn json_has_totals_and_entries() {
        let mut ledger = Ledger::default();
        ledger.add(up("nodes", 64, "the tree"));
        ledger.absent("corners", "no triangle is smooth");
        let json = serde_json::to_value(&ledger).unwrap();
        assert_eq!(json["bytes_up"], 64);
        assert_eq!(json["entries"][0]["direction"], "up");
        assert_eq!(json["entries"][1]["direction"], "absent");
    }
}
