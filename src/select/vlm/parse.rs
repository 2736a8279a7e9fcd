//! From what a model wrote to what it meant: a ladder from strict to lenient.

use serde_json::{Map, Value};

use super::{
    json_scan::{balanced, is_cut_off},
    points,
    profile::Profile,
};
use crate::geometry::Pixel;

/// Longest answer that is read, bytes: an answer is a few hundred.
const LONGEST: usize = 64 << 10;
/// How deep an answer may be wrapped (`{"result": {"objects": [{…}]}}`).
const DEEPEST: u32 = 4;

/// What a model meant, in its own coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Answer {
    /// Whether it found an object; `true` where it gave coordinates and said nothing else.
    pub found: bool,
    pub label: Option<String>,
    /// The frame's number as the model gave it.
    pub frame: Option<f64>,
    /// Two corners, x before y.
    pub corners: Option<[Pixel; 2]>,
    pub point: Option<Pixel>,
    pub hand: Option<String>,
    pub confidence: Option<f64>,
    pub reason: Option<String>,
    /// What somebody should know about how it was read.
    pub remarks: Vec<&'static str>,
}

/// Why an answer could not be read. The text is shown to the model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum ParseError {
    #[error("it is empty")]
    Empty,
    #[error("it holds only thoughts and no answer")]
    OnlyThoughts,
    #[error("it was cut off before its end: answer shorter")]
    CutOff,
    #[error("it holds no JSON")]
    NoJson,
    #[error("its JSON has neither x1, y1, x2, y2 nor px, py; it has {0}")]
    WrongKeys(String),
    #[error("it is a point in markup, which is only read with the coordinate profile pct-point")]
    Markup,
    #[error("it holds no <point x=\"..\" y=\"..\"> with percent of the image")]
    NoPoint,
}

/// Reads `content`, the text of a model that writes coordinates as `profile` says.
pub(super) fn parse(content: &str, profile: Profile) -> Result<Answer, ParseError> {
    if content.trim().is_empty() {
        return Err(ParseError::Empty);
    }
    let text = without_thoughts(&content[..content.floor_char_boundary(LONGEST)]);
    let text = text.trim();
    if text.is_empty() {
        return Err(ParseError::OnlyThoughts);
    }
    let mut wrong_keys = None;
    for candidate in [text, without_fence(text)].into_iter().chain(balanced(text)) {
        let Ok(value) = serde_json::from_str::<Value>(candidate) else { continue };
        if let Some(answer) = answer_in(&value, profile, 0) {
            return Ok(answer);
        }
        if wrong_keys.is_none() {
            wrong_keys = keys_of(&value);
        }
    }
    if let Some(point) = points::first(text) {
        let label = points::label(text);
        let answer = Answer { found: true, label, point: Some(point), ..Answer::default() };
        return if profile.is_point() { Ok(answer) } else { Err(ParseError::Markup) };
    }
    Err(match wrong_keys {
        Some(keys) => ParseError::WrongKeys(keys),
        None if is_cut_off(text) => ParseError::CutOff,
        None if profile.is_point() => ParseError::NoPoint,
        None => ParseError::NoJson,
    })
}

/// `text` without `<think>…</think>`; thoughts that never end are all there is.
fn without_thoughts(text: &str) -> String {
    let mut rest = text;
    // Templates often open the thoughts before the answer begins, so that only their end is seen.
    if let Some(end) = rest.rfind("</think>") {
        rest = &rest[end + "</think>".len()..];
    }
    match rest.find("<think>") {
        Some(start) => rest[..start].to_owned(),
        None => rest.to_owned(),
    }
}

/// What stands between the first pair of ``` lines; `text` itself where there is none.
fn without_fence(text: &str) -> &str {
    let Some((_, inside)) = text.split_once("```") else { return text };
    let inside = inside.split_once("```").map_or(inside, |(inside, _)| inside);
    // The word behind the opening fence is the language.
    inside.trim_start_matches(|c: char| c.is_ascii_alphanumeric()).trim()
}

/// The first answer in `value`, which may be wrapped in lists and objects.
fn answer_in(value: &Value, profile: Profile, depth: u32) -> Option<Answer> {
    if depth > DEEPEST {
        return None;
    }
    match value {
        Value::Object(map) => answer_of(map, profile)
            .or_else(|| map.values().find_map(|value| answer_in(value, profile, depth + 1))),
        Value::Array(items) => items
            .iter()
            .find_map(|value| if value.is_number() { None } else { answer_in(value, profile, depth + 1) })
            // A bare list only counts on its own: within an object its key must say what it is.
            .or_else(|| if depth == 0 { bare(items, profile) } else { None }),
        _ => None,
    }
}

fn bare(items: &[Value], profile: Profile) -> Option<Answer> {
    let corners = corners_of(items, profile)?;
    Some(Answer { found: true, corners: Some(corners), ..Answer::default() })
}

fn answer_of(map: &Map<String, Value>, profile: Profile) -> Option<Answer> {
    let get = |names: &[&str]| names.iter().find_map(|name| map.get(*name));
    let number_at = |name: &str| map.get(name).and_then(number);
    let text_at = |names: &[&str]| get(names).and_then(Value::as_str).map(str::to_owned);
    let list = |names: &[&str]| get(names).and_then(Value::as_array);

    let pixel = |x: &str, y: &str| Some(Pixel::new(number_at(x)?, number_at(y)?));
    let named = pixel("x1", "y1").zip(pixel("x2", "y2")).map(|(a, b)| [a, b]);
    let corners =
        named.or_else(|| corners_of(list(&["bbox_2d", "box_2d", "bbox", "box", "bounding_box"])?, profile));
    let point = pixel("px", "py")
        .or_else(|| point_of(list(&["point_2d", "point"])?, profile))
        .or_else(|| pixel("x", "y"));
    let said = map.get("found").and_then(truth);
    if said != Some(false) && corners.is_none() && point.is_none() {
        return None;
    }
    let mut remarks = Vec::new();
    if map.contains_key("box_2d") && named.is_none() && !profile.is_y_first() {
        remarks.push("the key box_2d often means y first: try --vlm-profile rel1000-yxyx if the box is off");
    }
    if map.contains_key("bbox_2d") && named.is_none() && profile.is_y_first() {
        remarks.push("the key bbox_2d often means x first: try another --vlm-profile if the box is off");
    }
    Some(Answer {
        found: said.unwrap_or(true),
        label: text_at(&["object", "label", "name"]),
        frame: get(&["frame", "frame_index", "frame_idx"]).and_then(number),
        corners,
        point,
        hand: text_at(&["hand"]),
        confidence: get(&["confidence", "score"]).and_then(number),
        reason: text_at(&["reason", "explanation"]),
        remarks,
    })
}

fn corners_of(list: &[Value], profile: Profile) -> Option<[Pixel; 2]> {
    // `[[x, y], [x, y]]` and `[[x1, y1, x2, y2]]` are written, too.
    let flat: Vec<f64> = list
        .iter()
        .flat_map(|value| value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice))
        .map(number)
        .collect::<Option<_>>()?;
    let [a, b, c, d] = flat[..] else { return None };
    let at = |first, second| {
        if profile.is_y_first() { Pixel::new(second, first) } else { Pixel::new(first, second) }
    };
    Some([at(a, b), at(c, d)])
}

fn point_of(list: &[Value], profile: Profile) -> Option<Pixel> {
    let numbers: Vec<f64> = list.iter().map(number).collect::<Option<_>>()?;
    let [a, b] = numbers[..] else { return None };
    Some(if profile.is_y_first() { Pixel::new(b, a) } else { Pixel::new(a, b) })
}

/// A number, also one that was written as a text.
fn number(value: &Value) -> Option<f64> {
    value.as_f64().or_else(|| value.as_str()?.trim().parse().ok())
}

fn truth(value: &Value) -> Option<bool> {
    value.as_bool().or_else(|| match value.as_str()?.trim().to_ascii_lowercase().as_str() {
        "true" | "yes" => Some(true),
        "false" | "no" => Some(false),
        _ => None,
    })
}

/// The keys of an object without coordinates, for its author.
fn keys_of(value: &Value) -> Option<String> {
    let map = match value {
        Value::Object(map) => map,
        Value::Array(items) => items.iter().find_map(Value::as_object)?,
        _ => return None,
    };
    let keys = map.keys().take(12).map(|key| key.chars().take(24).collect::<String>());
    let keys = keys.collect::<Vec<_>>().join(", ");
    Some(if keys.is_empty() { "no keys".to_owned() } else { keys })
}

#[cfg(test)]
mod tests;
