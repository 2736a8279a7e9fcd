//! What keys do to the session, through the whole window.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

mod support;

use agenticfocus::{
    clip::FrameIndex,
    engine::Request,
    session::{LayerOrder, MaskEdit, MaskLayer, Step},
};
use agenticfocus_ui::{inspector::layer_order_on, ui_command::UiCommand};
use egui::{Key, Modifiers, accesskit::Role};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use support::puppet::Window;

/// The window at the first frame of the sample, in `step`.
fn window_in(step: Step) -> Window {
    let mut window = Window::with_sample();
    window.harness.state_mut().look_at(FrameIndex(0), step);
    window.harness.run_steps(2);
    window
}

fn run(window: &mut Window, command: UiCommand) {
    let key = command.keys()[0];
    window.press(key.modifiers, key.logical_key);
}

#[test]
fn auto_by_key_takes_back_an_order_that_was_forced_on_more_frames() {
    let mut window = window_in(Step::Composite);
    window.harness.state_mut().options_mut().selection = Some((FrameIndex(0), FrameIndex(9)));
    run(&mut window, UiCommand::OrderRobot);
    assert_eq!(layer_order_on(&window.document(), FrameIndex(4)).0, LayerOrder::RobotInFront);
    window.harness.state_mut().options_mut().selection = Some((FrameIndex(3), FrameIndex(5)));
    run(&mut window, UiCommand::OrderAuto);
    let document = window.document();
    // Every range that covers a frame has its say, so none may be left that forces one here.
    let forces = |frame: u32| {
        document
            .layer_orders
            .iter()
            .any(|range| (range.first.0..=range.last.0).contains(&frame) && range.order != LayerOrder::Auto)
    };
    let forced: Vec<u32> = (0..10).filter(|frame| forces(*frame)).collect();
    assert_eq!(forced, [0, 1, 2, 6, 7, 8, 9]);
}

#[test]
fn keyframes_of_the_placement_are_joined_and_parted_by_one_key() {
    let mut window = window_in(Step::Template);
    run(&mut window, UiCommand::InterpolatePlacement);
    assert!(window.says("Place the template on a frame before this one"));
    // The sample's keyframes are 20 and 42.
    window.harness.state_mut().look_at(FrameIndex(30), Step::Template);
    run(&mut window, UiCommand::InterpolatePlacement);
    let spans = |window: &Window| window.document().template.interpolated_spans().collect::<Vec<_>>();
    assert_eq!(spans(&window), [(FrameIndex(20), FrameIndex(42))]);
    assert!(window.says("Between frames 20 and 42"), "at once, before the engine answers");
    assert!(window.says("placed by you, runs to 42"));
    run(&mut window, UiCommand::InterpolatePlacement);
    assert!(spans(&window).is_empty());
}

#[test]
fn cutting_the_template_from_here_drops_a_mask_that_was_drawn_elsewhere_and_no_other() {
    let mut window = window_in(Step::Template);
    run(&mut window, UiCommand::TemplateHere);
    assert_eq!(window.document().template.frame, Some(FrameIndex(0)));
    let drawn = support::square_mask();
    let ctx = window.harness.ctx.clone();
    let action = agenticfocus_ui::action::Action::ChangeTemplateMask { mask: drawn };
    window.harness.state_mut().act(&ctx, action);
    assert!(window.document().template.mask.is_some());
    run(&mut window, UiCommand::TemplateHere);
    assert!(window.document().template.mask.is_some(), "the frame is the same");
    run(&mut window, UiCommand::TemplateAuto);
    assert_eq!((window.document().template.frame, window.document().template.mask), (None, None));
}

fn playhead(window: &Window) -> u32 {
    window.harness.state().workspace().unwrap().playhead.0
}

fn has_keyboard(window: &Window) -> bool {
    window.harness.ctx.memory(|memory| memory.focused().is_some())
}

#[test]
fn tab_walks_the_steps_and_gives_no_control_the_keyboard() {
    let mut window = window_in(Step::Object);
    window.press(Modifiers::NONE, Key::Tab);
    assert_eq!(window.harness.state().options().step, Step::Masks);
    window.press(Modifiers::SHIFT, Key::Tab);
    assert_eq!(window.harness.state().options().step, Step::Object);
    assert!(!has_keyboard(&window));
    // A button with the keyboard would be pressed by this.
    window.press(Modifiers::NONE, Key::Space);
    assert!(window.harness.state().options().playing);
}

#[test]
fn a_control_with_the_keyboard_has_the_keys_that_work_it_until_escape() {
    let mut window = window_in(Step::Retarget);
    run(&mut window, UiCommand::Controls);
    assert!(has_keyboard(&window));
    let on_pitch = |window: &Window| {
        let slider = window.harness.get_by_role_and_label(Role::Slider, "Pitch");
        slider.accesskit_node().is_focused()
    };
    for _ in 0..12 {
        if !on_pitch(&window) {
            window.press(Modifiers::NONE, Key::Tab);
        }
    }
    assert!(on_pitch(&window));
    window.press(Modifiers::NONE, Key::ArrowRight);
    assert!(window.document().retarget.camera_rotation.is_some(), "the slider moved");
    assert_eq!((playhead(&window), window.harness.state().options().step), (0, Step::Retarget));
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!has_keyboard(&window));
    window.press(Modifiers::NONE, Key::ArrowRight);
    assert_eq!(playhead(&window), 1);
}

#[test]
fn a_polygon_is_drawn_mended_and_finished_by_keyboard_alone() {
    let mut window = window_in(Step::Masks);
    window.harness.state_mut().look_at(FrameIndex(5), Step::Masks);
    run(&mut window, UiCommand::LayerRightArm);
    let inside = |window: &Window, x: u32, y: u32| {
        let workspace = window.harness.state().workspace().unwrap();
        workspace.mask_pixels(MaskLayer::Arms, FrameIndex(5)).unwrap().get(x, y)
    };
    assert!(!inside(&window, 170, 130) && !inside(&window, 155, 137), "nothing there before");
    run(&mut window, UiCommand::Polygon);
    run(&mut window, UiCommand::Aim);
    // A square of 20 pixels from the middle of the picture on.
    for arrow in [Key::ArrowRight, Key::ArrowDown, Key::ArrowLeft] {
        window.press(Modifiers::NONE, Key::Space);
        window.press(Modifiers::SHIFT, arrow);
        window.press(Modifiers::SHIFT, arrow);
    }
    window.press(Modifiers::NONE, Key::Space);
    // Its last corner goes on to the left.
    window.harness.key_down(Key::Space);
    window.harness.run_steps(2);
    window.press(Modifiers::SHIFT, Key::ArrowLeft);
    window.harness.key_up(Key::Space);
    window.harness.run_steps(2);
    assert_eq!(playhead(&window), 5, "arrows moved the cross");
    run(&mut window, UiCommand::FinishShape);
    assert!(inside(&window, 170, 130) && inside(&window, 155, 137));
    window.press(Modifiers::NONE, Key::Escape);
    window.press(Modifiers::NONE, Key::ArrowRight);
    assert_eq!(playhead(&window), 6);
}

#[test]
fn one_arm_is_absent_or_shrunk_and_the_other_stays_as_it_is() {
    let mut window = window_in(Step::Masks);
    let frame = FrameIndex(5);
    window.harness.state_mut().look_at(frame, Step::Masks);
    let arms = |window: &Window| {
        window.harness.state().workspace().unwrap().mask_pixels(MaskLayer::Arms, frame).unwrap()
    };
    let sides = window.harness.state().workspace().unwrap().found.arms.clone().unwrap();
    let [left, right] = [&sides.sides.left, &sides.sides.right].map(|side| side[frame.as_usize()].decode());
    assert!(!left.minus(&right).is_empty() && !right.is_empty(), "both arms are there");

    run(&mut window, UiCommand::LayerRightArm);
    run(&mut window, UiCommand::Shrink);
    let shrunk = arms(&window);
    assert!(shrunk.intersection_area(&right) < right.area());
    assert_eq!(shrunk.minus(&right), left.minus(&right));
    run(&mut window, UiCommand::Undo);

    run(&mut window, UiCommand::LayerLeftArm);
    run(&mut window, UiCommand::Absent);
    assert_eq!(arms(&window), right);
    run(&mut window, UiCommand::LayerRightArm);
    run(&mut window, UiCommand::Absent);
    assert_eq!(window.document().arm_masks.get(&frame), Some(&MaskEdit::Absent));
}

#[test]
fn the_hole_is_widened_by_a_key_which_shows_it_and_which_undo_takes_back() {
    let mut window = window_in(Step::Masks);
    window.asked();
    run(&mut window, UiCommand::HoleWider);
    // Three pixels of 320 are the default.
    assert_eq!(window.document().hole_dilation, Some(4.0 / 320.0));
    assert!(window.harness.state().options().hole_outline);
    assert!(
        window.asked().iter().any(|request| matches!(request, Request::Work { .. })),
        "it is restored anew"
    );
    run(&mut window, UiCommand::HoleNarrower);
    assert_eq!(window.document().hole_dilation, Some(3.0 / 320.0));
    run(&mut window, UiCommand::Undo);
    run(&mut window, UiCommand::Undo);
    assert_eq!(window.document().hole_dilation, None);
    run(&mut window, UiCommand::HoleOutline);
    assert!(!window.harness.state().options().hole_outline);
}
