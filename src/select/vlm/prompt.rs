//! The words of the question, and the form of its answer.

use serde_json::{Value, json};

use super::profile::Profile;
use crate::{clip::FrameIndex, geometry::Size};

/// Longest task sentence that is passed on, characters.
const LONGEST_TASK: usize = 500;

pub(super) const SYSTEM: &str = "You look at frames of one first-person video of a person's hands and name the ONE \
object that the hands manipulate. Answer with a single JSON object and nothing else.";

/// The question before the pictures.
pub(super) fn question(task: Option<&str>, frames: &[FrameIndex], profile: Profile, sent: Size) -> String {
    let indices = frames.iter().map(|frame| frame.0.to_string()).collect::<Vec<_>>().join(", ");
    let task: String = task.map(|task| task.trim().chars().take(LONGEST_TASK).collect()).unwrap_or_default();
    let task = if task.is_empty() { String::new() } else { format!("The task shown: {task}\n") };
    let convention = profile.convention(sent);
    if profile.is_point() {
        return format!(
            "{task}Point to the ONE object the person's hand manipulates in this image (frame {indices}). Exclude \
             hands, arms, the table and the container it is taken from. The point must lie on the object, not on \
             the hand; coordinates are {convention}. Answer with <point x=\"..\" y=\"..\" alt=\"name of the \
             object\"></point>, or with {{\"found\": false}} if there is none."
        );
    }
    format!(
        "{task}Find the ONE object the person's hand manipulates. Exclude hands, arms, the table and the container it \
         is taken from. The images are the frames {indices} of the video; each is preceded by its number. Choose \
         the one frame on which the object is seen best (least covered) and give there: its box x1, y1 (top-left \
         corner), x2, y2 (bottom-right corner), and px, py, a point that lies on the object, not on the hand. \
         Coordinates are {convention}; black bars at the right or bottom of an image belong to it. Keys: found, \
         object (its name in a word or two), frame (the chosen frame's number), x1, y1, x2, y2, px, py, hand \
         (left, right, both or none: which hand holds it), confidence (0 to 1), reason (one short sentence). If \
         there is no such object, answer with found = false and zeros. Answer with JSON only, in this schema: {}",
        schema()
    )
}

/// The form of the answer. Named integers instead of lists: strict modes know no length of a list.
pub(super) fn schema() -> Value {
    let integer = || json!({"type": "integer"});
    json!({
        "type": "object",
        "additionalProperties": false,
        "required": [
            "found", "object", "frame", "x1", "y1", "x2", "y2", "px", "py", "hand", "confidence", "reason"
        ],
        "properties": {
            "found": {"type": "boolean"},
            "object": {"type": "string"},
            "frame": integer(),
            "x1": integer(), "y1": integer(), "x2": integer(), "y2": integer(),
            "px": integer(), "py": integer(),
            "hand": {"type": "string", "enum": ["left", "right", "both", "none"]},
            "confidence": {"type": "number"},
            "reason": {"type": "string"}
        }
    })
}

/// What a model is told whose answer cannot be used.
pub(super) fn repair(error: &str, profile: Profile) -> String {
    let form = if profile.is_point() { "in the same form" } else { "as one JSON object in the same schema" };
    format!("That answer cannot be used: {error}. Look again and answer once more, {form}, nothing else.")
}
