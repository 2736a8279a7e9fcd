//! What is known of a frame, in words.

use agenticfocus::{
    clip::FrameIndex,
    geometry::Side,
    hands::HandState,
    segment::{MaskAuthor, MaskFlag},
    session::{LayerOrder, MaskEdit, MaskLayer},
};
use egui::{RichText, Ui};

use crate::{state::Workspace, theme::Tokens, widgets::small};

/// A flag of a mask, in words.
pub const fn flag_words(flag: MaskFlag) -> &'static str {
    match flag {
        MaskFlag::AreaJump => "area jumped",
        MaskFlag::LowOverlap => "overlaps little with the frame before",
        MaskFlag::ColourDrift => "colours drifted",
        MaskFlag::TouchesBorder => "touches the picture's border",
        MaskFlag::Occluded => "mostly hidden",
        MaskFlag::Lost => "not found",
    }
}

/// Who made the mask of `layer` on `frame` and what is doubtful about it.
pub fn mask_words(workspace: &Workspace, layer: MaskLayer, frame: FrameIndex) -> String {
    if let Some(edit) = workspace.document().masks(layer).get(&frame) {
        return match edit {
            MaskEdit::Mask(_) => "drawn by a person".to_owned(),
            MaskEdit::Absent => "marked absent by a person".to_owned(),
        };
    }
    let Some((author, score, flags)) = workspace.mask_summary(layer, frame) else {
        return "no mask yet".to_owned();
    };
    let by = match author {
        MaskAuthor::Human => "drawn by a person",
        MaskAuthor::Seeded => "found on this frame",
        MaskAuthor::Propagated => "propagated",
    };
    let trust = (100.0 * score).round();
    let mut words = format!("{by}, trust {trust:.0} %");
    for flag in flags {
        words.push_str(", ");
        words.push_str(flag_words(*flag));
    }
    words
}

/// Who placed the template on `frame`.
pub fn template_words(workspace: &Workspace, frame: FrameIndex) -> Option<String> {
    let track = workspace.found.template.as_ref()?;
    let set = track.by_hand(&workspace.document().template, frame);
    Some(match (set.map(|set| set.between), track.placements.get(frame.as_usize())?) {
        (Some(None), _) => "placed by a person".to_owned(),
        (Some(Some((first, last))), _) => format!("between a person's frames {} and {}", first.0, last.0),
        (None, Some(placement)) => format!("placed, trust {:.0} %", (100.0 * placement.confidence).round()),
        (None, None) => "the object is absent".to_owned(),
    })
}

/// How a hand is known on `frame`.
pub fn hand_words(workspace: &Workspace, side: Side, frame: FrameIndex) -> String {
    let corrected = workspace.document().hand_edits[side].get(&frame);
    let hand = workspace.found.hands.as_ref().and_then(|track| track.hands[side].get(frame.as_usize()));
    let state = match (corrected, hand) {
        (Some(edit), _) if edit.invalid => return "marked invalid by a person".to_owned(),
        (Some(_), _) => return "corrected by a person".to_owned(),
        (None, None) => return "not estimated yet".to_owned(),
        (None, Some(hand)) => hand,
    };
    match state.state {
        HandState::Observed => format!("seen, trust {:.0} %", (100.0 * state.confidence).round()),
        HandState::Bridged => "bridged over a gap".to_owned(),
        HandState::Invalid => "absent".to_owned(),
    }
}

/// Contact and layer order on `frame`.
pub fn order_words(workspace: &Workspace, frame: FrameIndex) -> Option<String> {
    let motion = workspace.found.motion.as_ref()?;
    let at = frame.as_usize();
    let contact = motion.sides.left.get(at)?.contact.max(motion.sides.right.get(at)?.contact);
    let mut words = format!("contact {:.0} %", (100.0 * contact).round());
    let said = workspace
        .document()
        .layer_orders
        .iter()
        .rev()
        .find(|range| (range.first..=range.last).contains(&frame));
    let found = workspace.found.order.as_ref().and_then(|order| order.get(at));
    words.push_str(match (said.map(|range| range.order), found) {
        (Some(LayerOrder::RobotInFront), _) => ", robot in front, set by a person",
        (Some(LayerOrder::ObjectInFront), _) => ", object in front, set by a person",
        (_, Some(found)) if found.in_front.left.min(found.in_front.right) < 0.5 => ", object in front",
        (_, Some(_)) => ", robot in front",
        (_, None) => "",
    });
    Some(words)
}

/// Everything known of `frame`, as a tooltip.
pub(super) fn show(ui: &mut Ui, tokens: &Tokens, workspace: &Workspace, frame: FrameIndex) {
    let seconds = workspace.seconds(frame);
    ui.label(RichText::new(format!("Frame {} · {seconds:.2} s", frame.0)).strong());
    let mut lines = vec![
        ("Object", mask_words(workspace, MaskLayer::Object, frame)),
        ("Arms", mask_words(workspace, MaskLayer::Arms, frame)),
        ("Left hand", hand_words(workspace, Side::Left, frame)),
        ("Right hand", hand_words(workspace, Side::Right, frame)),
    ];
    let exchanged = workspace.document().sides_swapped.iter().any(|r| (r.first..=r.last).contains(&frame));
    if exchanged {
        lines.push(("Hands", "left and right exchanged by a person".to_owned()));
    }
    if let Some(template) = template_words(workspace, frame) {
        lines.insert(2, ("Template", template));
    }
    if let Some(contact) = order_words(workspace, frame) {
        lines.push(("Order", contact));
    }
    egui::Grid::new("frame in words").num_columns(2).spacing([12.0, 2.0]).min_row_height(16.0).show(
        ui,
        |ui| {
            for (name, words) in lines {
                ui.label(small(tokens, name));
                ui.label(RichText::new(words).small());
                ui.end_row();
            }
        },
    );
}
