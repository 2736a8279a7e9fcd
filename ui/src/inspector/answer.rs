//! What a vision-language model answered when it was asked for the object.

use agenticfocus::session::{ObjectAnswer, Said};
use egui::{RichText, TextStyle, Ui};

use super::parts::{folded_section, hint};
use crate::state::{Context, Workspace};

/// Longest part of an answer that is shown, characters.
const LONGEST: usize = 2000;

/// Folded away until somebody wants to know.
pub(super) fn show(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    let Some(answer) = &workspace.document().object_answer else { return };
    folded_section(ui, cx, "What the model answered", false, |ui, cx| {
        hint(ui, cx.tokens, &meaning(answer));
        for raw in &answer.raw {
            let shown: String = raw.chars().take(LONGEST).collect();
            ui.label(RichText::new(shown).text_style(TextStyle::Monospace).color(cx.tokens.text));
        }
    });
}

fn meaning(answer: &ObjectAnswer) -> String {
    let frames: Vec<String> = answer.frames.iter().map(|frame| frame.0.to_string()).collect();
    let said = match &answer.said {
        Said::Object(object) => format!("taken as {} on frame {}", object.label, object.frame.0),
        Said::Nothing(why) => format!("no object: {why}"),
        Said::Unusable(why) => format!("not used: {why}"),
    };
    format!("{}, {}, shown frames {}: {said}", answer.model, answer.profile, frames.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use agenticfocus::clip::FrameIndex;

    #[test]
    fn an_answer_says_who_saw_what_and_what_was_made_of_it() {
        let answer = ObjectAnswer {
            request: String::new(),
            model: "m".to_owned(),
            profile: "rel1000-xyxy".to_owned(),
            frames: vec![FrameIndex(0), FrameIndex(30)],
            raw: Vec::new(),
            said: Said::Unusable("no JSON".to_owned()),
        };
        assert_eq!(meaning(&answer), "m, rel1000-xyxy, shown frames 0, 30: not used: no JSON");
    }
}
