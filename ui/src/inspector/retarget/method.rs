//! By which method the clip is retargeted.

use agenticfocus::{retarget::Method, session::RetargetSettings};
use egui::{Button, Ui};

use crate::{inspector::parts::hint, state::Context};

/// The method, with the default where nothing is set.
pub(super) fn method_of(settings: &RetargetSettings) -> Method {
    settings.method.unwrap_or_default()
}

/// `settings` with another method; the default is left out again, and so is what only another method knows.
fn with_method(settings: &RetargetSettings, method: Method) -> RetargetSettings {
    let shared_map = settings.shared_map.filter(|_| method == Method::Masquerade);
    RetargetSettings { method: (method != Method::default()).then_some(method), shared_map, ..*settings }
}

/// A button a method; `Some` where a person chose.
pub(super) fn show(ui: &mut Ui, cx: &Context<'_>, settings: &RetargetSettings) -> Option<RetargetSettings> {
    let now = method_of(settings);
    let width = (ui.available_width() - 2.0 * ui.spacing().item_spacing.x) / 3.0;
    let mut chosen = None;
    ui.horizontal(|ui| {
        for method in Method::ALL {
            let button = Button::selectable(method == now, method.title()).frame_when_inactive(true);
            let name = format!("Method: {}", method.name());
            let response = ui.add_sized([width, 24.0], button).accessible_name(name);
            if response.on_hover_text(meaning_of(method)).clicked() {
                chosen = Some(with_method(settings, method));
            }
        }
    });
    if now == Method::Masquerade {
        ui.add_space(4.0);
        let mut shared = settings.shared_map.unwrap_or(false);
        let text = "Camera map of AgenticFocus, β fitted";
        if ui.checkbox(&mut shared, text).on_hover_text("Otherwise its own, with β = 1").changed() {
            chosen = Some(RetargetSettings { shared_map: shared.then_some(true), ..*settings });
        }
    }
    if now != Method::Ours {
        hint(ui, cx.tokens, "A published method, to compare with: it smooths in its own way");
    }
    chosen
}

fn meaning_of(method: Method) -> &'static str {
    match method {
        Method::Ours => "Wrist, palm and all five fingers",
        Method::Masquerade => "The hand as a gripper between thumb and middle finger",
        Method::DoAsIDo => "Fingertips first; its kinematic part, without the physics that follows",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ours_leaves_no_trace_and_a_baseline_keeps_the_rest() {
        let settings = RetargetSettings { alpha: Some(0.3), ..RetargetSettings::default() };
        let baseline = with_method(&settings, Method::Masquerade);
        assert_eq!((method_of(&baseline), baseline.alpha), (Method::Masquerade, Some(0.3)));
        let shared = RetargetSettings { shared_map: Some(true), ..baseline };
        assert_eq!(with_method(&shared, Method::Ours), settings);
    }
}
