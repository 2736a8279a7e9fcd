//! The egui style that the tokens make.

use egui::{
    Color32, CornerRadius, FontFamily, FontId, Margin, Shadow, Stroke, Style, TextStyle, Theme, Vec2,
    Visuals,
    style::{ScrollStyle, Selection, Spacing, WidgetVisuals, Widgets},
    vec2,
};

use super::Tokens;

/// Numbers that change: all digits equally wide, so that nothing dances.
pub fn number_font() -> FontId {
    FontId::new(12.0, FontFamily::Monospace)
}

/// The same, small.
pub fn small_number_font() -> FontId {
    FontId::new(10.0, FontFamily::Monospace)
}

/// Gives `ctx` the look of `tokens`. Cheap where it has it already, so it may be called every frame.
pub fn apply(ctx: &egui::Context, tokens: &Tokens) {
    let theme = if tokens.dark { Theme::Dark } else { Theme::Light };
    let applied = egui::Id::unique("agenticfocus tokens");
    let same = ctx.data(|data| data.get_temp::<bool>(applied)) == Some(tokens.dark);
    if same && ctx.theme() == theme {
        return;
    }
    ctx.data_mut(|data| data.insert_temp(applied, tokens.dark));
    ctx.set_style_of(theme, style(tokens));
    ctx.set_theme(theme);
}

fn style(tokens: &Tokens) -> Style {
    let proportional = |size| FontId::new(size, FontFamily::Proportional);
    let text_styles = [
        (TextStyle::Body, proportional(Tokens::TEXT)),
        (TextStyle::Button, proportional(Tokens::TEXT)),
        (TextStyle::Small, proportional(Tokens::SMALL)),
        (TextStyle::Heading, proportional(Tokens::HEADING)),
        (TextStyle::Monospace, number_font()),
    ];
    let mut style = Style {
        text_styles: text_styles.into(),
        drag_value_text_style: TextStyle::Monospace,
        spacing: spacing(),
        visuals: visuals(tokens),
        animation_time: 0.08,
        compact_menu_style: true,
        ..Style::default()
    };
    style.interaction.selectable_labels = false;
    style.interaction.tooltip_delay = 0.4;
    style
}

fn spacing() -> Spacing {
    Spacing {
        item_spacing: Vec2::splat(Tokens::STEP),
        window_margin: Margin::same(12),
        button_padding: vec2(8.0, 2.0),
        menu_margin: Margin::same(8),
        indent: 16.0,
        interact_size: vec2(32.0, Tokens::ROW),
        slider_width: 120.0,
        slider_rail_height: 4.0,
        combo_width: 80.0,
        text_edit_width: 160.0,
        icon_width: 16.0,
        icon_width_inner: 8.0,
        icon_spacing: 8.0,
        tooltip_width: 320.0,
        menu_width: 240.0,
        menu_spacing: 2.0,
        scroll: ScrollStyle { bar_width: 8.0, ..ScrollStyle::thin() },
        ..Spacing::default()
    }
}

fn visuals(tokens: &Tokens) -> Visuals {
    let base = if tokens.dark { Visuals::dark() } else { Visuals::light() };
    let radius = CornerRadius::same(Tokens::RADIUS);
    let shade = Shadow {
        offset: [0, 4],
        blur: 16,
        spread: 0,
        color: Color32::from_black_alpha(if tokens.dark { 110 } else { 40 }),
    };
    Visuals {
        dark_mode: tokens.dark,
        override_text_color: None,
        weak_text_color: Some(tokens.muted),
        widgets: widgets(tokens),
        selection: Selection { bg_fill: tokens.selected, stroke: Stroke::new(1.0, tokens.accent) },
        hyperlink_color: tokens.accent_text,
        faint_bg_color: tokens.raised,
        extreme_bg_color: tokens.ground,
        text_edit_bg_color: Some(tokens.ground),
        code_bg_color: tokens.raised,
        warn_fg_color: tokens.alarm,
        error_fg_color: tokens.alarm,
        window_corner_radius: CornerRadius::same(2 * Tokens::RADIUS),
        window_shadow: shade,
        window_fill: tokens.panel,
        window_stroke: Stroke::new(1.0, tokens.line),
        menu_corner_radius: radius,
        panel_fill: tokens.panel,
        popup_shadow: shade,
        slider_trailing_fill: true,
        disabled_alpha: 0.45,
        ..base
    }
}

fn widgets(tokens: &Tokens) -> Widgets {
    let state = |fill, line, text| WidgetVisuals {
        bg_fill: fill,
        weak_bg_fill: fill,
        bg_stroke: Stroke::new(1.0, line),
        corner_radius: CornerRadius::same(Tokens::RADIUS),
        fg_stroke: Stroke::new(1.0, text),
        expansion: 0.0,
    };
    Widgets {
        noninteractive: state(tokens.panel, tokens.line, tokens.text),
        inactive: state(tokens.raised, tokens.line, tokens.text),
        hovered: state(tokens.hovered, tokens.muted, tokens.text),
        active: state(tokens.selected, tokens.accent, tokens.text),
        open: state(tokens.hovered, tokens.line, tokens.text),
    }
}
