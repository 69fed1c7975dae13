//! The order of a study's measurements, and the loop over them.
//!
//! Comes in: a study and the rows that there are. Goes out: the rows that it lacks, one by one.

use super::{Row, Rows, Step, Study, Watch};
use crate::Result;

/// How a study ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Everything is measured.
    Whole,
    /// Stopped by the watch; what there is is on disk.
    Stopped,
}

/// `cases` of `scenes`, a scene after the other, in each repeat by repeat.
pub fn interleaved(scenes: usize, cases: &[usize], repeats: u32) -> Vec<Step> {
    (0..scenes)
        .flat_map(|scene| {
            (0..repeats).flat_map(move |repeat| cases.iter().map(move |&case| Step { scene, case, repeat }))
        })
        .collect()
}

/// Measures what `rows` lack.
pub fn run(study: &mut dyn Study, rows: &mut Rows, watch: &mut dyn Watch) -> Result<Ended> {
    let schedule = study.schedule();
    for (index, &step) in schedule.iter().enumerate() {
        let (scene, case) = (study.scenes()[step.scene].clone(), study.case(step.case));
        if rows.has(&scene, &case, step.repeat) {
            continue;
        }
        if watch.stop_requested() {
            return Ok(Ended::Stopped);
        }
        let Some(values) = study.measure(step, watch)? else { return Ok(Ended::Stopped) };
        let values = values.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        let row = Row { scene, case, repeat: step.repeat, values };
        let line = format!("{} {} {}", row.scene, row.case, study.headline(&row));
        rows.add(row)?;
        watch.measured(index + 1, schedule.len(), line.trim_end());
    }
    Ok(Ended::Whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_go_through_all_cases_before_any_comes_again() {
        let steps = interleaved(2, &[4, 7], 2);
        let places: Vec<_> = steps.iter().map(|step| (step.scene, step.repeat, step.case)).collect();
        assert_eq!(places[..4], [(0, 0, 4), (0, 0, 7), (0, 1, 4), (0, 1, 7)]);
        assert_eq!((places.len(), places[4]), (8, (1, 0, 4)));
    }
}
