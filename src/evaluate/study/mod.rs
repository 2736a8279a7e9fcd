//! Retargeting methods compared on the same hand tracks.
//!
//! An [`Episode`] is a track and what is known of the true hands; a [`Setting`] a method with its parameters.
//! [`run`](fn@run) retargets every episode by every setting and scores the robot's wrists ([`score`](fn@score));
//! [`Study`] holds the figures, [`summary`](fn@summary) their means, intervals and paired differences.
//!
//! A wrist error is a distance in the human scene, in the source camera's frame and metres: the reached wrist goes
//! back through the setting's own camera map, P̂ = R_camᵀ (p − T_offset) / β, and is compared with the true human
//! wrist P on the same frame. Where a method maps the hand elsewhere (another β, another view) that alone is no
//! error; where its arm cannot follow, or its hand is posed so that the wrist lies elsewhere, it is.

mod episode;
mod figure;
mod metric;
mod report;
mod run;
mod score;
mod setting;
mod sources;
mod summary;
mod sweep;

pub use episode::{Episode, Reference, ReferenceKind};
pub use figure::{FIGURES, Figure, FigureError, draw_figures};
pub use metric::{Metric, Scores};
pub use report::{report_json, sweep_json, to_csv, to_html, to_table};
pub use run::{EpisodeResult, Study, StudyError, StudyParams, run};
pub use score::score;
pub use setting::Setting;
pub use sources::{SourceError, Sources, find_sources};
pub use summary::{Summary, summary};
pub use sweep::{Sweep, SweepError, frontier};
