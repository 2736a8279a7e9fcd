//! `meta/modality.json`: how GR00T cuts state and action into parts.

use serde_json::{Value, json};

use super::{ANNOTATION, VIDEO};
use crate::robot::{ACTUATED_DOF, ARM_DOF, HAND_DOF};

/// Parts as [start, end) columns, the video under the name its G1 configuration asks for, the task column.
pub(super) fn modality() -> Value {
    let part = |start: usize, end: usize| json!({ "start": start, "end": end });
    let parts = json!({
        "left_arm": part(0, ARM_DOF / 2),
        "right_arm": part(ARM_DOF / 2, ARM_DOF),
        "left_hand": part(ARM_DOF, ARM_DOF + HAND_DOF / 2),
        "right_hand": part(ARM_DOF + HAND_DOF / 2, ACTUATED_DOF),
    });
    let annotation = ANNOTATION.trim_start_matches("annotation.");
    json!({
        "state": parts,
        "action": parts,
        "video": { "rs_view": { "original_key": VIDEO } },
        "annotation": { annotation: { "original_key": ANNOTATION } },
    })
}
