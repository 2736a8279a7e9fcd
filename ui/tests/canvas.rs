//! The canvas: what it shows and what the pointer does on it.

mod support;

use std::sync::Arc;

use agenticfocus::{
    clip::FrameIndex,
    engine::Request,
    geometry::{Pixel, Side},
    image::Mask,
    segment::RleMask,
    session::{Command, MaskLayer, ObjectPromptKind, Step},
};
use agenticfocus_ui::{
    action::Action,
    canvas::{Canvas, View},
    paint,
    state::{BeforeAfter, Draft, HandDraft, Tool},
    theme::{self, Tokens},
    ui_command::UiCommand,
};
use egui::{Event, Modifiers, MouseWheelUnit, PointerButton, Pos2, Vec2, vec2};
use egui_kittest::{Harness, kittest::Queryable as _};
use support::{Bench, SIZE};

/// A canvas alone in a window, and what it asked for.
struct Desk {
    bench: Bench,
    canvas: Canvas,
}

fn harness<'a>(bench: Bench, size: Vec2) -> Harness<'a, Desk> {
    Harness::builder().with_size(size).with_pixels_per_point(1.0).build_ui_state(
        |ui, desk: &mut Desk| {
            theme::apply(ui.ctx(), &desk.bench.tokens);
            desk.canvas.show(ui, &mut desk.bench.context());
        },
        Desk { bench, canvas: Canvas::default() },
    )
}

fn on_step<'a>(step: Step) -> Harness<'a, Desk> {
    let mut bench = Bench::new(Tokens::dark());
    bench.options.step = step;
    let mut harness = harness(bench, vec2(720.0, 560.0));
    harness.run();
    harness
}

/// Where a pixel is on screen while the whole picture is shown.
fn at(harness: &Harness<'_, Desk>, x: f64, y: f64) -> Pos2 {
    let rect = harness.get_by_label("Canvas").rect().shrink(8.0);
    View::default().projection(rect, SIZE, 1.0).to_screen(Pixel::new(x, y))
}

fn button(
    harness: &Harness<'_, Desk>,
    pos: Pos2,
    button: PointerButton,
    pressed: bool,
    modifiers: Modifiers,
) {
    harness.event(Event::PointerButton { pos, button, pressed, modifiers });
}

/// Presses, moves along `path` and lets go.
fn drag(harness: &mut Harness<'_, Desk>, path: &[Pos2], which: PointerButton, modifiers: Modifiers) {
    harness.hover_at(path[0]);
    harness.run();
    button(harness, path[0], which, true, modifiers);
    for place in &path[1..] {
        harness.hover_at(*place);
        harness.run();
    }
    button(harness, path[path.len() - 1], which, false, modifiers);
    harness.run();
}

fn asked(harness: &mut Harness<'_, Desk>) -> Vec<Action> {
    std::mem::take(&mut harness.state_mut().bench.actions)
}

fn perform(harness: &mut Harness<'_, Desk>, command: UiCommand) -> bool {
    let Desk { bench, canvas } = harness.state_mut();
    canvas.perform(command, &mut bench.context())
}

#[test]
fn a_drag_paints_the_strokes_footprint_and_asks_for_one_change() {
    let mut harness = on_step(Step::Masks);
    harness.state_mut().bench.options.brush_radius = 9.0;
    let path = [at(&harness, 60.0, 60.0), at(&harness, 90.0, 70.0), at(&harness, 95.0, 110.0)];
    drag(&mut harness, &path, PointerButton::Primary, Modifiers::NONE);
    let workspace = harness.state().bench.workspace.as_ref().unwrap();
    let mut expected = workspace.mask_pixels(MaskLayer::Object, FrameIndex(22)).unwrap();
    let pixels = path.map(|place| {
        let rect = harness.get_by_label("Canvas").rect().shrink(8.0);
        View::default().projection(rect, SIZE, 1.0).to_picture(place)
    });
    for ends in [[pixels[0], pixels[0]], [pixels[0], pixels[1]], [pixels[1], pixels[2]]] {
        paint::stroke(&mut expected, ends[0], ends[1], 9.0, true);
    }
    let actions = asked(&mut harness);
    let [Action::ChangeMask { layer: MaskLayer::Object, frame: FrameIndex(22), mask }] = actions.as_slice()
    else {
        panic!("one change of a mask, not {actions:?}");
    };
    assert_eq!(*mask, expected);
}

#[test]
fn the_right_button_takes_away_and_the_eraser_adds_with_it() {
    let mut harness = on_step(Step::Masks);
    let before = |harness: &Harness<'_, Desk>| {
        let workspace = harness.state().bench.workspace.as_ref().unwrap();
        workspace.mask_pixels(MaskLayer::Object, FrameIndex(22)).unwrap()
    };
    let bounds = before(&harness).bounding_box().unwrap();
    let middle = at(&harness, bounds.centre().x, bounds.centre().y);
    let outside = at(&harness, 20.0, 200.0);
    let area = before(&harness).area();
    for (tool, place, which, modifiers, grows) in [
        (Tool::Brush, middle, PointerButton::Secondary, Modifiers::NONE, false),
        (Tool::Brush, middle, PointerButton::Primary, Modifiers::SHIFT, false),
        (Tool::Eraser, middle, PointerButton::Primary, Modifiers::NONE, false),
        (Tool::Eraser, outside, PointerButton::Secondary, Modifiers::NONE, true),
    ] {
        harness.state_mut().bench.options.tool = tool;
        drag(&mut harness, &[place, place + vec2(3.0, 0.0)], which, modifiers);
        let actions = asked(&mut harness);
        let [Action::ChangeMask { mask, .. }] = actions.as_slice() else { panic!("{tool:?}: {actions:?}") };
        assert_eq!(mask.area() > area, grows, "{tool:?} with {which:?}");
        assert_ne!(mask.area(), area);
    }
}

#[test]
fn escape_in_the_middle_of_a_stroke_leaves_no_trace() {
    let mut harness = on_step(Step::Masks);
    let untouched = harness.render().unwrap();
    let (from, to) = (at(&harness, 40.0, 40.0), at(&harness, 120.0, 120.0));
    harness.hover_at(from);
    harness.run();
    button(&harness, from, PointerButton::Primary, true, Modifiers::NONE);
    harness.hover_at(to);
    harness.run();
    assert!(perform(&mut harness, UiCommand::SelectNothing));
    button(&harness, to, PointerButton::Primary, false, Modifiers::NONE);
    harness.remove_cursor();
    harness.run();
    assert!(asked(&mut harness).is_empty());
    assert_eq!(harness.render().unwrap(), untouched);
    assert!(!perform(&mut harness, UiCommand::SelectNothing), "nothing is left to drop");
}

#[test]
fn the_wheel_keeps_the_pixel_under_the_pointer() {
    let mut harness = on_step(Step::Masks);
    let place = at(&harness, 200.0, 150.0);
    harness.hover_at(place);
    harness.run();
    harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta: vec2(0.0, 240.0),
        modifiers: Modifiers::NONE,
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Unknown,
    });
    harness.run();
    harness.get_by_label("x 200  y 150");
    assert!(perform(&mut harness, UiCommand::Fit));
}

#[test]
fn a_polygon_is_closed_by_a_command_and_an_unfinished_one_is_dropped() {
    let mut harness = on_step(Step::Masks);
    harness.state_mut().bench.options.tool = Tool::Polygon;
    let corners = [(20.0, 20.0), (60.0, 22.0), (40.0, 60.0)].map(|(x, y)| at(&harness, x, y));
    for round in 0..2 {
        for corner in corners {
            drag(&mut harness, &[corner], PointerButton::Primary, Modifiers::NONE);
        }
        assert!(asked(&mut harness).is_empty());
        if round == 0 {
            assert!(perform(&mut harness, UiCommand::FinishShape));
            assert_eq!(asked(&mut harness).len(), 1);
        } else {
            assert!(perform(&mut harness, UiCommand::SelectNothing));
            assert!(!perform(&mut harness, UiCommand::FinishShape));
            assert!(asked(&mut harness).is_empty());
        }
    }
}

#[test]
fn a_box_drawn_around_the_object_becomes_the_choice() {
    let mut harness = on_step(Step::Object);
    let path = [at(&harness, 9.5, 19.5), at(&harness, 49.5, 59.5)];
    drag(&mut harness, &path, PointerButton::Primary, Modifiers::NONE);
    let actions = asked(&mut harness);
    let [Action::Change(Command::SetObject(Some(choice)))] = actions.as_slice() else {
        panic!("{actions:?}")
    };
    let ObjectPromptKind::Box(found) = &choice.prompt else { panic!("{choice:?}") };
    let expected = [10.0, 20.0, 50.0, 60.0];
    for (found, expected) in [found.x0, found.y0, found.x1, found.y1].iter().zip(expected) {
        assert!((found - expected).abs() < 0.01, "{choice:?}");
    }
}

#[test]
fn dragging_a_joint_moves_that_keypoint_alone() {
    let mut harness = on_step(Step::Hands);
    let tip = {
        let workspace = harness.state().bench.workspace.as_ref().unwrap();
        workspace.found.hands.as_ref().unwrap().hands.left[22].keypoints[8]
    };
    let path = [at(&harness, tip.x, tip.y), at(&harness, tip.x + 10.0, tip.y - 5.0)];
    drag(&mut harness, &path, PointerButton::Primary, Modifiers::NONE);
    let mut actions = asked(&mut harness);
    actions.retain(|action| !matches!(action, Action::Ask(Request::FitHand { .. })));
    let [Action::Change(Command::SetHandEdit { edit: Some(edit), .. })] = actions.as_slice() else {
        panic!("{actions:?}")
    };
    assert_eq!(edit.keypoints.keys().copied().collect::<Vec<_>>(), [8]);
    assert!(edit.keypoints[&8].distance(Pixel::new(tip.x + 10.0, tip.y - 5.0)) < 0.1);
}

#[test]
fn dragging_the_template_moves_its_placement_and_keys_nudge_it() {
    let mut harness = on_step(Step::Template);
    let (before, middle) = {
        let workspace = harness.state().bench.workspace.as_ref().unwrap();
        let track = workspace.found.template.as_ref().unwrap();
        let transform = track.placements[22].as_ref().unwrap().transform;
        let size = track.picture.size();
        let middle = transform
            * nalgebra::Vector3::new(f64::from(size.width) / 2.0, f64::from(size.height) / 2.0, 1.0);
        (transform, (middle.x / middle.z, middle.y / middle.z))
    };
    let path = [at(&harness, middle.0, middle.1), at(&harness, middle.0 + 12.0, middle.1 - 6.0)];
    drag(&mut harness, &path, PointerButton::Primary, Modifiers::NONE);
    assert!(perform(&mut harness, UiCommand::NudgeLeft));
    let actions = asked(&mut harness);
    let shifts: Vec<(f64, f64)> = actions
        .iter()
        .map(|action| match action {
            Action::Change(Command::SetPlacement { transform: Some(now), .. }) => {
                (now[(0, 2)] - before[(0, 2)], now[(1, 2)] - before[(1, 2)])
            }
            other => panic!("{other:?}"),
        })
        .collect();
    assert!((shifts[0].0 - 12.0).abs() < 0.1 && (shifts[0].1 + 6.0).abs() < 0.1, "{shifts:?}");
    assert_eq!((shifts[1].0.round(), shifts[1].1.round()), (-1.0, 0.0));
}

#[test]
fn a_session_that_others_write_to_cannot_be_painted() {
    let mut harness = on_step(Step::Masks);
    let holder = agenticfocus::session::LockHolder { program: "agenticfocus".to_owned(), pid: 7 };
    harness.state_mut().bench.workspace.as_mut().unwrap().access =
        agenticfocus::engine::Access::ReadOnly(holder);
    harness.run();
    let path = [at(&harness, 60.0, 60.0), at(&harness, 90.0, 70.0)];
    drag(&mut harness, &path, PointerButton::Primary, Modifiers::NONE);
    assert!(asked(&mut harness).is_empty());
}

#[test]
fn points_ask_for_a_mask_and_enter_takes_the_answer() {
    let mut harness = on_step(Step::Masks);
    harness.state_mut().bench.options.tool = Tool::Points;
    let (on, beside) = (at(&harness, 150.0, 120.0), at(&harness, 40.0, 40.0));
    drag(&mut harness, &[on], PointerButton::Primary, Modifiers::NONE);
    drag(&mut harness, &[beside], PointerButton::Secondary, Modifiers::NONE);
    let actions = asked(&mut harness);
    let Some(Action::Ask(Request::Segment { layer, frame, positive, negative })) = actions.last().cloned()
    else {
        panic!("{actions:?}")
    };
    assert_eq!((layer, frame, positive.len(), negative.len()), (MaskLayer::Object, FrameIndex(22), 1, 1));
    assert!(perform(&mut harness, UiCommand::FinishShape), "Enter waits for the answer");
    assert!(asked(&mut harness).is_empty());
    let made = Mask::from_fn(SIZE, |x, y| x > 100 && y > 100 && x < 160 && y < 150);
    let mask = Some(Arc::new(RleMask::encode(&made)));
    let draft = Draft { frame, positive, negative, mask, ..Draft::default() };
    harness.state_mut().bench.workspace.as_mut().unwrap().draft = Some(draft);
    harness.run();
    assert!(perform(&mut harness, UiCommand::FinishShape));
    let actions = asked(&mut harness);
    let [Action::ChangeMask { mask, .. }] = actions.as_slice() else { panic!("{actions:?}") };
    assert_eq!(*mask, made);
}

#[test]
fn the_middle_button_and_space_move_the_picture_and_paint_nothing() {
    let mut harness = on_step(Step::Masks);
    let (from, to) = (at(&harness, 100.0, 100.0), at(&harness, 120.0, 90.0));
    drag(&mut harness, &[from, to], PointerButton::Middle, Modifiers::NONE);
    harness.get_by_label("x 100  y 100");
    assert!(!harness.state_mut().canvas.took_space());
    harness.key_down(egui::Key::Space);
    drag(&mut harness, &[to, from], PointerButton::Primary, Modifiers::NONE);
    harness.key_up(egui::Key::Space);
    harness.run();
    harness.get_by_label("x 100  y 100");
    assert!(harness.state_mut().canvas.took_space());
    assert!(asked(&mut harness).is_empty());
}

#[test]
fn the_wheel_with_alt_sizes_the_brush_and_leaves_the_view() {
    let mut harness = on_step(Step::Masks);
    let place = at(&harness, 100.0, 100.0);
    harness.hover_at(place);
    harness.run();
    let before = harness.state().bench.options.brush_radius;
    let (unit, delta) = (MouseWheelUnit::Point, vec2(0.0, 60.0));
    let (phase, source) = (egui::TouchPhase::Move, egui::MouseWheelSource::Unknown);
    harness.event_modifiers(
        Event::MouseWheel { unit, delta, modifiers: Modifiers::ALT, phase, source },
        Modifiers::ALT,
    );
    harness.run();
    assert!(harness.state().bench.options.brush_radius > before);
    harness.get_by_label("x 100  y 100");
}

#[test]
fn a_stroke_goes_to_the_frame_it_was_drawn_on() {
    let mut harness = on_step(Step::Masks);
    let from = at(&harness, 40.0, 40.0);
    harness.hover_at(from);
    harness.run();
    button(&harness, from, PointerButton::Primary, true, Modifiers::NONE);
    harness.run();
    harness.state_mut().bench.workspace.as_mut().unwrap().playhead = FrameIndex(23);
    harness.run();
    button(&harness, from, PointerButton::Primary, false, Modifiers::NONE);
    harness.run();
    let actions = asked(&mut harness);
    let [Action::ChangeMask { frame: FrameIndex(22), .. }] = actions.as_slice() else {
        panic!("{actions:?}")
    };
}

#[test]
fn the_templates_mask_is_painted_on_its_own_frame() {
    let mut harness = on_step(Step::Template);
    assert!(perform(&mut harness, UiCommand::TemplateMask));
    assert!(matches!(asked(&mut harness).as_slice(), [Action::Seek(FrameIndex(0))]));
    harness.state_mut().bench.workspace.as_mut().unwrap().playhead = FrameIndex(0);
    harness.run();
    let path = [at(&harness, 30.0, 30.0), at(&harness, 60.0, 30.0)];
    drag(&mut harness, &path, PointerButton::Primary, Modifiers::NONE);
    let actions = asked(&mut harness);
    let [Action::ChangeTemplateMask { mask }] = actions.as_slice() else { panic!("{actions:?}") };
    assert!(mask.get(45, 30));
    assert!(perform(&mut harness, UiCommand::SelectNothing), "Esc goes back to placing");
    assert!(!perform(&mut harness, UiCommand::SelectNothing));
}

#[test]
fn every_step_looks_as_it_should() {
    // One window for all: a renderer takes long to start.
    let mut harness = harness(Bench::new(Tokens::dark()), vec2(720.0, 560.0));
    for (theme, tokens) in [("dark", Tokens::dark()), ("light", Tokens::light())] {
        for step in Step::ALL {
            let bench = &mut harness.state_mut().bench;
            bench.tokens = tokens.clone();
            bench.options.step = step;
            let compares = step == Step::Composite;
            bench.options.before_after = if compares { BeforeAfter::Wipe(0.5) } else { BeforeAfter::After };
            harness.run();
            harness.snapshot(format!("canvas_{}_{theme}", format!("{step:?}").to_lowercase()));
        }
        let bench = std::mem::replace(&mut harness.state_mut().bench, Bench::empty(tokens));
        harness.run();
        harness.get_by_label("No clip open");
        harness.snapshot(format!("canvas_empty_{theme}"));
        harness.state_mut().bench = bench;
    }
}

/// Gives the robot wrists a little beside the human's, the right one out of reach.
fn with_wrists(bench: &mut Bench) {
    use agenticfocus::geometry::{Pose, Position, Side};
    let Some(workspace) = &mut bench.workspace else { return };
    let found = &mut workspace.found;
    let (Some(hands), Some(motion)) = (found.hands.clone(), found.motion.as_mut()) else { return };
    let motion = Arc::make_mut(motion);
    let map = motion.map;
    for side in Side::BOTH {
        for (report, hand) in motion.sides[side].iter_mut().zip(&hands.hands[side]) {
            let wanted = map.beta * (map.rotation * hand.wrist().xyz) + map.offset;
            let short = if side == Side::Right { 0.04 } else { 0.0 };
            let place = |xyz| Pose::from_parts(Position::new(xyz), nalgebra::UnitQuaternion::identity());
            report.driven = true;
            report.target = place(wanted);
            report.reached = place(wanted - map.rotation * nalgebra::Vector3::new(short, 0.0, 0.0));
            (report.error_position, report.reachable) = (short, side == Side::Left);
        }
    }
}

#[test]
fn the_eraser_stays_within_the_arm_that_is_meant() {
    let mut harness = on_step(Step::Masks);
    let (at_left, at_right) = {
        let workspace = harness.state().bench.workspace.as_ref().unwrap();
        let sides = &workspace.found.arms.as_ref().unwrap().sides;
        let [left, right] = [&sides.left[22], &sides.right[22]].map(RleMask::decode);
        // Well inside one arm and far from the other.
        let place = |one: &Mask, other: &Mask| {
            let inner = paint::shrink(one, 5).minus(&paint::grow(other, 12));
            let pixels = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
            pixels.into_iter().find(|(x, y)| inner.get(*x, *y)).unwrap()
        };
        (place(&left, &right), place(&right, &left))
    };
    let options = &mut harness.state_mut().bench.options;
    (options.mask_layer, options.side, options.tool) = (MaskLayer::Arms, Side::Left, Tool::Eraser);
    options.brush_radius = 6.0;
    harness.run();
    let erase = |harness: &mut Harness<'_, Desk>, (x, y): (u32, u32)| {
        let place = at(harness, f64::from(x), f64::from(y));
        drag(harness, &[place, place + vec2(4.0, 0.0)], PointerButton::Primary, Modifiers::NONE);
        asked(harness).iter().any(|action| matches!(action, Action::ChangeMask { .. }))
    };
    assert!(!erase(&mut harness, at_right), "the right arm is not meant");
    assert!(erase(&mut harness, at_left));
}

#[test]
fn a_joint_that_is_dragged_asks_for_the_hand_in_space_as_it_moves() {
    let mut harness = on_step(Step::Hands);
    let (frame, joint) = (FrameIndex(15), 11);
    harness.state_mut().bench.workspace.as_mut().unwrap().playhead = frame;
    harness.run();
    let tip = {
        let workspace = harness.state().bench.workspace.as_ref().unwrap();
        workspace.found.hands.as_ref().unwrap().hands.left[15].keypoints[joint]
    };
    let from = at(&harness, tip.x, tip.y);
    harness.hover_at(from);
    harness.run();
    button(&harness, from, PointerButton::Primary, true, Modifiers::NONE);
    harness.hover_at(from + vec2(20.0, -30.0));
    harness.run();
    let actions = asked(&mut harness);
    let fits: Vec<_> = actions
        .iter()
        .filter_map(|action| match action {
            Action::Ask(Request::FitHand { frame: at, side: Side::Left, keypoints }) if *at == frame => {
                Some(keypoints[joint])
            }
            _ => None,
        })
        .collect();
    assert_eq!(fits.len(), 1, "{actions:?}");
    assert!(fits[0].distance(tip) > 5.0);
    harness.run();
    assert!(asked(&mut harness).is_empty(), "nothing new, nothing asked");
    button(&harness, from + vec2(20.0, -30.0), PointerButton::Primary, false, Modifiers::NONE);
    harness.run();
    assert!(matches!(&asked(&mut harness)[..], [Action::Change(Command::SetHandEdit { .. })]));
}

#[test]
fn work_in_progress_looks_as_it_should() {
    let mut harness = harness(Bench::new(Tokens::dark()), vec2(720.0, 560.0));
    harness.state_mut().bench.options.step = Step::Masks;
    harness.state_mut().bench.options.onion_skin = true;
    harness.state_mut().bench.options.tool = Tool::Polygon;
    harness.run();
    for (x, y) in [(100.0, 40.0), (150.0, 50.0), (140.0, 90.0)] {
        let corner = at(&harness, x, y);
        drag(&mut harness, &[corner], PointerButton::Primary, Modifiers::NONE);
    }
    let place = at(&harness, 110.0, 80.0);
    harness.hover_at(place);
    harness.run();
    harness.snapshot("canvas_polygon_dark");
    assert!(perform(&mut harness, UiCommand::Eraser));
    for _ in 0..8 {
        perform(&mut harness, UiCommand::ZoomIn);
    }
    let middle = harness.get_by_label("Canvas").rect().center();
    harness.hover_at(middle);
    harness.run();
    button(&harness, middle, PointerButton::Primary, true, Modifiers::NONE);
    harness.hover_at(middle + vec2(60.0, 40.0));
    harness.run();
    harness.snapshot("canvas_eraser_dark");
    assert!(perform(&mut harness, UiCommand::SelectNothing) && perform(&mut harness, UiCommand::Fit));
    button(&harness, middle, PointerButton::Primary, false, Modifiers::NONE);
    let Desk { bench, .. } = harness.state_mut();
    with_wrists(bench);
    bench.options.step = Step::Retarget;
    harness.remove_cursor();
    harness.run();
    harness.snapshot("canvas_wrists_dark");
    let bench = &mut harness.state_mut().bench;
    bench.options.step = Step::Hands;
    bench.workspace.as_mut().unwrap().playhead = FrameIndex(15);
    let tip = bench.workspace.as_ref().unwrap().found.hands.as_ref().unwrap().hands.left[15].keypoints[11];
    harness.run();
    let tip = at(&harness, tip.x, tip.y);
    harness.hover_at(tip);
    harness.run();
    harness.snapshot("canvas_joint_dark");
    let to = tip + vec2(24.0, -36.0);
    button(&harness, tip, PointerButton::Primary, true, Modifiers::NONE);
    harness.hover_at(to);
    harness.run();
    let workspace = harness.state_mut().bench.workspace.as_mut().unwrap();
    let hand = Box::new(workspace.found.hands.as_ref().unwrap().hands.left[15].clone());
    let (frame, side, keypoints) = (FrameIndex(15), Side::Left, Box::new(hand.keypoints));
    workspace.hand_draft = Some(HandDraft { frame, side, keypoints, hand });
    harness.run();
    harness.snapshot("canvas_hand_fit_dark");
    button(&harness, to, PointerButton::Primary, false, Modifiers::NONE);
    let options = &mut harness.state_mut().bench.options;
    options.step = Step::Masks;
    (options.mask_layer, options.side, options.hole_outline) = (MaskLayer::Arms, Side::Left, true);
    options.onion_skin = false;
    harness.run();
    harness.snapshot("canvas_hole_dark");
}

#[test]
fn a_picture_that_cannot_be_had_is_explained() {
    use agenticfocus::engine::{PictureKind, PictureRequest, Revision};
    let mut bench = Bench::new(Tokens::dark());
    bench.pictures.clear();
    let request = PictureRequest { frame: FrameIndex(22), kind: PictureKind::Source, revision: Revision(0) };
    let words = "Frame 22 not decoded: cup_lid.mp4 ends after frame 20. Check the file, then work again";
    bench.pictures.take(request, Err(words.to_owned()));
    let mut harness = harness(bench, vec2(720.0, 560.0));
    harness.run();
    harness.get_by_label(words);
    harness.snapshot("canvas_fault_dark");
}
