//! Where the robot's wrists should be and where they are, over the composite.

use agenticfocus::{
    geometry::{Camera, Pixel, Position, Side, Torso},
    retarget::CameraMap,
};
use egui::{Color32, Stroke, vec2};

use super::super::{
    scene::Scene,
    shapes::{self, LineStyle},
};
use crate::state::Context;

/// A wrist farther than this from its target is labelled, metres.
const TOLERANCE: f64 = 0.005;

/// Draws targets as rings and reached wrists as dots.
pub(in super::super) fn show(scene: &Scene<'_>, cx: &Context<'_>) {
    let found = &scene.workspace.found;
    let (Some(motion), Some(clip)) = (&found.motion, &found.clip) else { return };
    if scene.hidden {
        return;
    }
    for side in Side::BOTH {
        let Some(report) = motion.sides[side].get(scene.frame.as_usize()).filter(|report| report.driven)
        else {
            continue;
        };
        let place = |position: Position<Torso>| {
            let pixel: Pixel = clip.intrinsics.project(&seen_by_the_camera(&motion.map, position)?)?;
            Some(scene.projection.to_screen(pixel))
        };
        let (Some(target), Some(reached)) =
            (place(report.target.position()), place(report.reached.position()))
        else {
            continue;
        };
        let colour = cx.tokens.side(side);
        let style = LineStyle { width: 2.0, colour, dashed: !report.reachable };
        shapes::rimmed_line(&scene.painter, &[target, reached], false, style);
        scene.painter.circle_stroke(target, 9.0, Stroke::new(4.0, shapes::rim_colour()));
        scene.painter.circle_stroke(target, 9.0, Stroke::new(2.0, colour));
        shapes::dot(&scene.painter, reached, 4.0, if report.reachable { colour } else { Color32::WHITE });
        if report.error_position > TOLERANCE {
            let out = if report.reachable { "" } else { ", out of reach" };
            let text = format!("{} {:.1} cm{out}", side.name(), report.error_position * 100.0);
            shapes::badge(&scene.painter, cx.tokens, target + vec2(14.0, -6.0), &text, colour);
        }
    }
}

/// The camera point that the map took to `position`.
fn seen_by_the_camera(map: &CameraMap, position: Position<Torso>) -> Option<Position<Camera>> {
    if !(map.beta.is_finite() && map.beta.abs() > 1e-9) {
        return None;
    }
    Some(Position::new(map.rotation.transpose() * (position.xyz - map.offset) / map.beta))
}

#[cfg(test)]
mod tests {
    use agenticfocus::retarget::{CameraRotation, RetargetParams};
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn going_back_through_the_map_finds_the_human_wrist() {
        let rotation = CameraRotation::default().matrix().unwrap();
        let map = CameraMap { beta: 0.8, rotation, offset: RetargetParams::default().offset };
        let human = Vector3::new(0.1, -0.05, 0.4);
        let robot = map.beta * (map.rotation * human) + map.offset;
        let back = seen_by_the_camera(&map, Position::new(robot)).unwrap();
        assert!((back.xyz - human).norm() < 1e-12);
    }
}
