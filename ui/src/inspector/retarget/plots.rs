//! Joints against their limits, position error, wrist speed.

use agenticfocus::{clip::FrameIndex, geometry::Side, retarget::RobotMotion, robot::JointAngles};
use egui::{Button, ComboBox, RichText, Ui};
use egui_plot::{Axis, HLine, LineStyle, Span};

use super::{
    limits::{Joint, joints},
    numbers::wrist_speed,
    word_of,
};
use crate::{
    action::Action,
    inspector::{
        hands::mark_of,
        parts::{Trace, TraceStyle, legend, time_plot},
    },
    state::{Context, Workspace},
};

/// Share of a joint's range beside a limit that is shaded.
const NEAR_LIMIT: f64 = 0.05;

/// Which joint is drawn.
#[derive(Debug, Default)]
pub(super) struct Plots {
    joint: Option<usize>,
}

impl Plots {
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        workspace: &Workspace,
        motion: &RobotMotion,
    ) {
        let width = (ui.available_width() - 2.0 * ui.spacing().item_spacing.x) / 3.0;
        let tabs = [
            ("Joints", "Plot of joints"),
            ("Error", "Plot of position error"),
            ("Speed", "Plot of wrist speed"),
        ];
        ui.horizontal(|ui| {
            for (index, (text, name)) in tabs.into_iter().enumerate() {
                let button = Button::selectable(cx.options.plot == index, text).frame_when_inactive(true);
                if ui.add_sized([width, 24.0], button).accessible_name(name).clicked() {
                    cx.options.plot = index;
                }
            }
        });
        let clicked = match cx.options.plot {
            0 => self.joint(ui, cx, workspace, motion),
            1 => sides(ui, cx, workspace, "Position error", " cm", |side| {
                motion.sides[side].iter().map(|r| r.driven.then_some(100.0 * r.error_position)).collect()
            }),
            _ => sides(ui, cx, workspace, "Wrist speed", " m/s", |side| wrist_speed(&motion.sides[side])),
        };
        if let Some(frame) = clicked {
            cx.ask(Action::Seek(frame));
        }
    }

    fn choose(&mut self, ui: &mut Ui, cx: &Context<'_>, motion: &RobotMotion) -> &'static Joint {
        let joints = joints();
        let mut chosen = *self.joint.get_or_insert_with(|| tightest(motion, joints));
        let name = |joint: &Joint| format!("{} {}", word_of(joint.side), joint.name);
        ui.horizontal(|ui| {
            let label = ui.label(RichText::new("Joint").color(cx.tokens.muted));
            ComboBox::from_id_salt("joint")
                .selected_text(name(&joints[chosen]))
                .width(ui.available_width())
                .show_ui(ui, |ui| {
                    for joint in joints {
                        ui.selectable_value(&mut chosen, joint.index, name(joint));
                    }
                })
                .response
                .labelled_by(label.id);
        });
        self.joint = Some(chosen);
        &joints[chosen]
    }

    fn joint(
        &mut self,
        ui: &mut Ui,
        cx: &Context<'_>,
        workspace: &Workspace,
        motion: &RobotMotion,
    ) -> Option<FrameIndex> {
        let joint = self.choose(ui, cx, motion);
        let tokens = cx.tokens;
        let (colour, _) = mark_of(tokens, joint.side);
        let degrees = |angles: &[JointAngles]| -> Vec<Option<f64>> {
            angles.iter().map(|angles| Some(angles.0[joint.index].to_degrees())).collect()
        };
        let solved = degrees(&motion.raw_angles);
        let traces = [
            Trace { name: "As solved", values: solved, colour: tokens.muted, style: TraceStyle::Dotted },
            Trace { name: "Smoothed", values: degrees(&motion.angles), colour, style: TraceStyle::Solid },
        ];
        let clicked = time_plot(ui, tokens, "joint", "°", workspace.playhead, &traces, |plot| {
            let Some([lower, upper]) = joint.limits else { return };
            let band = NEAR_LIMIT * (upper - lower);
            for (limit, inner) in [(lower, lower + band), (upper, upper - band)] {
                let shade = Span::new("", limit.min(inner)..=limit.max(inner)).axis(Axis::Y);
                plot.span(shade.fill(tokens.hole.gamma_multiply(0.18)).border_width(0.0));
                let style = LineStyle::Dashed { length: 4.0 };
                plot.hline(HLine::new("", limit).color(tokens.hole).style(style).allow_hover(false));
            }
        });
        ui.horizontal(|ui| {
            legend(ui, tokens, colour, TraceStyle::Solid, "smoothed");
            legend(ui, tokens, tokens.muted, TraceStyle::Dotted, "as solved");
            legend(ui, tokens, tokens.hole, TraceStyle::Dashed, "limit");
        });
        clicked
    }
}

/// The arm joint that comes nearest to a limit. Fingers are left out: an open hand is at its limits.
fn tightest(motion: &RobotMotion, joints: &[Joint]) -> usize {
    let margin = |joint: &Joint| {
        let [lower, upper] = joint.limits.unwrap_or([-180.0, 180.0]);
        let room = |angle: f64| (angle - lower).min(upper - angle) / (upper - lower);
        motion.angles.iter().map(|angles| room(angles.0[joint.index].to_degrees())).fold(0.5, f64::min)
    };
    let arms = joints.iter().take(agenticfocus::robot::ARM_DOF);
    arms.min_by(|a, b| margin(a).total_cmp(&margin(b))).map_or(0, |joint| joint.index)
}

fn sides(
    ui: &mut Ui,
    cx: &Context<'_>,
    workspace: &Workspace,
    id: &str,
    unit: &str,
    values: impl Fn(Side) -> Vec<Option<f64>>,
) -> Option<FrameIndex> {
    let style = |side| if side == Side::Left { TraceStyle::Solid } else { TraceStyle::Dashed };
    let traces = Side::BOTH.map(|side| Trace {
        name: word_of(side),
        values: values(side),
        colour: mark_of(cx.tokens, side).0,
        style: style(side),
    });
    let line = cx.tokens.line;
    let clicked = time_plot(ui, cx.tokens, id, unit, workspace.playhead, &traces, |plot| {
        // 0 is always in sight: a small error must look small.
        plot.hline(HLine::new("", 0.0).color(line).allow_hover(false));
    });
    ui.horizontal(|ui| {
        for side in Side::BOTH {
            legend(ui, cx.tokens, mark_of(cx.tokens, side).0, style(side), word_of(side));
        }
    });
    clicked
}
