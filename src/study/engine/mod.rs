//! What all studies share: the order of measurements, scenes under study, rows on disk, and what rows say.
//!
//! ```text
//! study, plan      what is asked of a study; what is asked for
//! kind             what is stated of a study, once
//! schedule         the order of measurements, and the loop over them
//! subject          a scene under study: renders without compiling in their time, references
//! seed_pair        a picture under two seeds, and its bias
//! rows, spread     raw figures on disk; medians and ranges of them
//! summary, gallery sentences, tables and figures; pictures on disk
//! peers, subprocess  other renderers, and texray in a process of its own
//! ```

pub mod gallery;
pub mod kind;
pub mod peers;
pub mod plan;
pub mod rows;
pub mod schedule;
pub mod seed_pair;
pub mod spread;
pub mod study;
pub mod subject;
pub mod subprocess;
pub mod summary;

pub use kind::{Kind, Scenes};
pub use plan::{Amount, Plan};
pub use rows::{Origin, Row, Rows};
pub use schedule::{Ended, run};
pub use spread::Spread;
pub use study::{Step, Study, Values, Watch};
pub use summary::{Summary, Table};
