//! A study as JSON, CSV, HTML and text.

mod csv;
mod findings;
mod html;
mod json;
mod table;

pub use csv::to_csv;
pub use html::to_html;
pub use json::{report_json, sweep_json};
pub use table::to_table;

use super::{Setting, Study};
use crate::retarget::Method;

/// What stands wherever figures of Do as I Do do.
const DO_AS_I_DO: &str = "Do as I Do is its kinematic part alone: spike cleaning, inverse kinematics and moving average. \
                          Its physics refinement (sampling-based control in simulation, with a mesh of the object) is \
                          left out.";

/// What a reader of the figures has to know.
fn notes(study: &Study) -> Vec<String> {
    let mut notes = Vec::new();
    if study.settings.iter().any(|setting| setting.params.method == Method::DoAsIDo) {
        notes.push(DO_AS_I_DO.to_owned());
    }
    if study.params.alignment != crate::evaluate::metrics::Alignment::None {
        notes.push(format!(
            "Paths were fitted onto the human's ({}): a constant error does not show.",
            study.params.alignment.name()
        ));
    }
    let own =
        study.episodes.iter().filter(|episode| episode.reference == super::ReferenceKind::Track).count();
    if own > 0 {
        notes.push(format!(
            "{own} of {} episodes come without truth and are compared with their own track: what a method smooths out \
             of it counts as error.",
            study.episodes.len()
        ));
    }
    notes.extend(study.notes.iter().cloned());
    notes
}

/// The parameters of a setting as JSON.
fn params_json(setting: &Setting) -> serde_json::Value {
    serde_json::to_value(&setting.params).unwrap_or(serde_json::Value::Null)
}

/// What every number depends on, one line a thing.
fn measured_how(study: &Study) -> Vec<(&'static str, String)> {
    let spectral = crate::evaluate::metrics::SpectralParams::default();
    vec![
        (
            "position error",
            format!(
                "100 ‖p̂ − p‖ of the wrist in the source camera's frame, p̂ = R_camᵀ (p_robot − T_offset) / β; one \
                 normalised timeline; alignment: {}",
                study.params.alignment.name()
            ),
        ),
        (
            "speed",
            "norm of forward differences of the wrist × 30 Hz, over the span in which the hand is known"
                .to_owned(),
        ),
        (
            "sparc",
            format!(
                "padding {}, cut-off {} Hz, amplitude threshold {}",
                spectral.padding, spectral.cutoff_hz, spectral.threshold
            ),
        ),
        ("sal", format!("spectral arc length, fixed cut-off {} Hz", super::score::SAL_CUTOFF_HZ)),
        ("ldlj", "log dimensionless jerk of the speed".to_owned()),
        ("intervals", study.params.bootstrap.describe()),
        ("paired", "first method minus the other, on the same episodes".to_owned()),
    ]
}
