//! What inspectors ask for, found by accessible labels.

mod support;

use agenticfocus::{
    clip::FrameIndex,
    engine::{Access, Request},
    retarget::{Beta, Method, Smoothing},
    session::{
        Command, Entry, LayerOrder, LayerOrderRange, LockHolder, ObjectAnswer, RetargetSettings, ReviewState,
        Said, Step,
    },
};
use agenticfocus_ui::{
    action::Action,
    inspector::{Inspector, Verdict, checklist, reasons_of},
    state::{BeforeAfter, Work},
    theme::Tokens,
    ui_command::UiCommand,
};
use egui::accesskit::Role;
use egui_kittest::{
    Harness,
    kittest::{NodeT as _, Queryable as _},
};
use support::Bench;

struct Stage {
    bench: Bench,
    inspector: Inspector,
}

impl Stage {
    fn changes(&mut self) -> Vec<Command> {
        let actions = std::mem::take(&mut self.bench.actions).into_iter();
        actions
            .filter_map(|action| if let Action::Change(command) = action { Some(command) } else { None })
            .collect()
    }

    fn previews(&self) -> usize {
        self.bench.actions.iter().filter(|action| matches!(action, Action::Preview(_))).count()
    }

    fn has_run(&self, command: UiCommand) -> bool {
        self.bench.actions.iter().any(|action| matches!(action, Action::Run(run) if *run == command))
    }

    /// Carries changes out as the app does.
    fn keep(&mut self, command: Command) {
        let applied =
            self.bench.workspace.as_mut().map(|workspace| workspace.history.apply(Entry::Do(command)));
        assert_eq!(applied, Some(Ok(true)));
    }
}

fn at(step: Step, prepare: impl FnOnce(&mut Bench)) -> Harness<'static, Stage> {
    let mut bench = Bench::new(Tokens::dark());
    bench.options.step = step;
    prepare(&mut bench);
    let stage = Stage { bench, inspector: Inspector::default() };
    let mut harness = Harness::builder().with_size([336.0, 1400.0]).build_ui_state(
        |ui, stage: &mut Stage| {
            agenticfocus_ui::theme::apply(ui.ctx(), &stage.bench.tokens);
            stage.inspector.show(ui, &mut stage.bench.context());
        },
        stage,
    );
    harness.run_steps(3);
    harness
}

fn click(harness: &mut Harness<'static, Stage>, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(3);
}

#[test]
fn a_click_on_a_proposal_makes_it_the_persons_choice() {
    let mut harness = at(Step::Object, |_| {});
    let second = harness.state().bench.workspace.as_ref().unwrap().document().proposals[1].clone();
    click(&mut harness, &format!("Proposal 2: {}", second.label));
    assert_eq!(harness.state_mut().changes(), [Command::SetObject(Some(second.taken_by_person()))]);
}

#[test]
fn what_a_model_answered_is_read_where_somebody_unfolds_it() {
    let answer = ObjectAnswer {
        request: String::new(),
        model: "some-model".to_owned(),
        profile: "rel1000-xyxy".to_owned(),
        frames: vec![FrameIndex(0)],
        raw: vec!["{\"found\": false}".to_owned()],
        said: Said::Nothing("only hands".to_owned()),
    };
    let mut harness = at(Step::Object, |bench| {
        let workspace = bench.workspace.as_mut().unwrap();
        let found = Entry::Found(Command::SetObjectAnswer(Some(Box::new(answer))));
        workspace.history.apply(found).unwrap();
    });
    assert!(harness.query_by_label("{\"found\": false}").is_none());
    click(&mut harness, "What the model answered");
    harness.run_steps(20);
    assert!(harness.query_by_label("{\"found\": false}").is_some());
    assert!(harness.query_by_label_contains("no object: only hands").is_some());
}

#[test]
fn the_task_is_kept_once_when_the_field_is_left() {
    let mut harness = at(Step::Object, |_| {});
    harness.get_by_label("Task sentence").focus();
    harness.run_steps(2);
    harness.get_by_label("Task sentence").type_text(", slowly");
    harness.run_steps(2);
    assert!(harness.state_mut().changes().is_empty(), "still typing");
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    assert_eq!(
        harness.state_mut().changes(),
        [Command::SetTask(Some("take the lid off the cup, slowly".to_owned()))]
    );
}

#[test]
fn a_doubtful_frame_is_listed_with_its_reason_and_a_click_goes_there() {
    let mut harness = at(Step::Masks, |_| {});
    let workspace = harness.state().bench.workspace.as_ref().unwrap();
    let frame = workspace.problems()[0];
    let reasons = reasons_of(workspace, agenticfocus::session::MaskLayer::Object, frame).join(", ");
    assert!(!reasons.is_empty());
    click(&mut harness, &format!("Go to frame {}: {reasons}", frame.0));
    assert!(
        harness.state().bench.actions.iter().any(|action| matches!(action, Action::Seek(to) if *to == frame))
    );
}

#[test]
fn running_work_can_be_held_and_stopped_from_the_masks() {
    let running = Work::Running { stage: "object", share: 0.4, left: Some(8.0), paused: false };
    let mut harness = at(Step::Masks, |bench| bench.workspace.as_mut().unwrap().work = running);
    click(&mut harness, UiCommand::Pause.text());
    click(&mut harness, UiCommand::Cancel.text());
    assert!(harness.state().has_run(UiCommand::Pause) && harness.state().has_run(UiCommand::Cancel));
}

#[test]
fn another_clean_frame_drops_nothing_but_a_mask_drawn_on_the_old_one() {
    let mut harness = at(Step::Template, |_| {});
    let name = harness
        .query_all_by_role(Role::Button)
        .filter_map(|node| node.accesskit_node().label())
        .find(|label| label.starts_with("Cut the template from frame "))
        .unwrap();
    let frame: u32 = name.rsplit(' ').next().unwrap().parse().unwrap();
    click(&mut harness, &name);
    let changes = harness.state_mut().changes();
    assert_eq!(changes, [Command::SetTemplateFrame(Some(FrameIndex(frame)))]);
}

#[test]
fn a_keyframe_can_be_left_to_the_machine() {
    let mut harness = at(Step::Template, |_| {});
    click(&mut harness, "Leave frame 20 to the machine");
    let expected = Command::SetPlacement { frame: FrameIndex(20), transform: None };
    assert_eq!(harness.state_mut().changes(), [expected]);
}

#[test]
fn hand_length_is_typed_in_millimetres_and_reset_to_none() {
    let mut harness = at(Step::Hands, |_| {});
    type_number(&mut harness, "Length value", "190");
    let changes = harness.state_mut().changes();
    let [Command::SetRetarget(settings)] = &changes[..] else { panic!("{changes:?}") };
    assert!((settings.hand_length.unwrap() - 0.19).abs() < 1e-9);
    let settings = *settings;
    harness.state_mut().keep(Command::SetRetarget(settings));
    harness.run_steps(2);
    click(&mut harness, "Reset Length");
    assert_eq!(
        harness.state_mut().changes(),
        [Command::SetRetarget(RetargetSettings { hand_length: None, ..settings })]
    );
}

fn type_number(harness: &mut Harness<'static, Stage>, name: &str, text: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(3);
    harness.get_by_label(name).type_text(text);
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
}

#[test]
fn a_typed_beta_is_one_change_and_its_dot_puts_none_back() {
    let mut harness = at(Step::Retarget, |_| {});
    type_number(&mut harness, "β value", "0.7");
    let fixed = RetargetSettings { beta: Some(Beta::Fixed(0.7)), ..RetargetSettings::default() };
    assert_eq!(harness.state_mut().changes(), [Command::SetRetarget(fixed)]);
    harness.state_mut().keep(Command::SetRetarget(fixed));
    harness.run_steps(2);
    click(&mut harness, "Reset β");
    assert_eq!(harness.state_mut().changes(), [Command::SetRetarget(RetargetSettings::default())]);
}

#[test]
fn the_method_is_a_setting_of_the_session_and_ours_leaves_no_trace() {
    let mut harness = at(Step::Retarget, |_| {});
    click(&mut harness, "Method: masquerade");
    let masquerade = RetargetSettings { method: Some(Method::Masquerade), ..RetargetSettings::default() };
    assert_eq!(harness.state_mut().changes(), [Command::SetRetarget(masquerade)]);
    harness.state_mut().keep(Command::SetRetarget(masquerade));
    harness.run_steps(2);
    // It smooths in its own way.
    assert!(harness.query_by_label("Smoothing: forward").is_none());
    click(&mut harness, "Method: ours");
    assert_eq!(harness.state_mut().changes(), [Command::SetRetarget(RetargetSettings::default())]);
}

#[test]
fn smoothing_and_wrists_are_settings_of_the_session_and_their_defaults_leave_no_trace() {
    let mut harness = at(Step::Retarget, |_| {});
    click(&mut harness, "Smoothing: forward");
    let forward = RetargetSettings { smoothing: Some(Smoothing::Ema), ..RetargetSettings::default() };
    assert_eq!(harness.state_mut().changes(), [Command::SetRetarget(forward)]);
    harness.state_mut().keep(Command::SetRetarget(forward));
    harness.run_steps(2);
    click(&mut harness, "Smoothing: both ways");
    assert_eq!(harness.state_mut().changes(), [Command::SetRetarget(RetargetSettings::default())]);

    assert!(harness.query_by_label("R pitch value").is_none(), "folded until it is wanted");
    click(&mut harness, "Wrist corrections");
    harness.run_steps(20);
    type_number(&mut harness, "R pitch value", "-4");
    let changes = harness.state_mut().changes();
    let [Command::SetRetarget(settings)] = &changes[..] else { panic!("{changes:?}") };
    assert_eq!(settings.wrist.right.degrees(), [0.0, -4.0, 0.0]);
    assert_eq!(settings.wrist.left.degrees(), [0.0; 3]);
}

#[test]
fn a_slider_previews_while_it_moves_and_changes_once_when_it_rests() {
    let mut harness = at(Step::Retarget, |_| {});
    let slider = harness.get_by_role_and_label(Role::Slider, "Pitch").rect();
    let from = slider.center();
    harness.drag_at(from);
    for step in 1..=4 {
        harness.hover_at(from + egui::vec2(6.0 * step as f32, 0.0));
        harness.run_steps(1);
    }
    let previews = harness.state().previews();
    assert!(previews >= 2, "{previews} previews");
    assert!(harness.state_mut().changes().is_empty(), "a change while the slider moves");
    harness.drop_at(from + egui::vec2(24.0, 0.0));
    harness.run_steps(2);
    let changes = harness.state_mut().changes();
    let [Command::SetRetarget(settings)] = &changes[..] else { panic!("{changes:?}") };
    assert!(settings.camera_rotation.is_some() && settings.beta.is_none());
}

#[test]
fn a_drag_that_ended_in_another_step_is_not_kept() {
    let mut harness = at(Step::Retarget, |_| {});
    let from = harness.get_by_role_and_label(Role::Slider, "Pitch").rect().center();
    harness.drag_at(from);
    harness.run_steps(1);
    harness.hover_at(from + egui::vec2(20.0, 0.0));
    harness.run_steps(1);
    harness.state_mut().bench.options.step = Step::Hands;
    harness.run_steps(1);
    harness.drop_at(from);
    harness.run_steps(2);
    harness.state_mut().bench.options.step = Step::Retarget;
    harness.run_steps(2);
    let last = harness.state().bench.actions.last();
    let back =
        matches!(last, Some(Action::Preview(Command::SetRetarget(s))) if *s == RetargetSettings::default());
    assert!(back, "{last:?}");
    assert!(harness.state_mut().changes().is_empty());
}

#[test]
fn the_field_of_view_is_given_for_an_unknown_camera() {
    let mut harness = at(Step::Hands, |_| {});
    type_number(&mut harness, "View value", "95");
    let camera = agenticfocus::clip::CameraSpec::HorizontalFov(95.0);
    assert_eq!(harness.state_mut().changes(), [Command::SetCamera(camera)]);
}

#[test]
fn the_view_turns_by_dragging_and_asks_for_that_picture() {
    let mut harness = at(Step::Retarget, |_| {});
    let before = harness.state().bench.options.orbit;
    let centre = harness.get_by_label("3-D view: drag turns, wheel zooms").rect().center();
    harness.drag_at(centre);
    harness.run_steps(1);
    harness.hover_at(centre + egui::vec2(40.0, 10.0));
    harness.run_steps(1);
    harness.drop_at(centre + egui::vec2(40.0, 10.0));
    harness.run_steps(1);
    let after = harness.state().bench.options.orbit;
    assert!(after.azimuth < before.azimuth && after.elevation > before.elevation);
}

#[test]
fn an_order_holds_on_the_selected_frames_alone() {
    let range = |first, last, order| LayerOrderRange {
        first: FrameIndex(first),
        last: FrameIndex(last),
        order,
        thumb: None,
    };
    let mut harness = at(Step::Composite, |bench| {
        let orders = Command::SetLayerOrders(vec![range(0, 30, LayerOrder::ObjectInFront)]);
        let workspace = bench.workspace.as_mut().unwrap();
        assert!(workspace.history.apply(Entry::Do(orders)).unwrap());
        bench.options.selection = Some((FrameIndex(10), FrameIndex(20)));
    });
    click(&mut harness, "Order: robot in front");
    assert_eq!(
        harness.state_mut().changes(),
        [Command::SetLayerOrders(vec![
            range(0, 9, LayerOrder::ObjectInFront),
            range(10, 20, LayerOrder::RobotInFront),
            range(21, 30, LayerOrder::ObjectInFront),
        ])]
    );
}

#[test]
fn an_eye_and_a_comparison_change_the_view_and_not_the_session() {
    let mut harness = at(Step::Composite, |_| {});
    click(&mut harness, "Hide robot");
    click(&mut harness, "Before");
    let stage = harness.state_mut();
    assert!(!stage.bench.options.eyes.robot.shown && stage.bench.options.eyes.object.shown);
    assert_eq!(stage.bench.options.before_after, BeforeAfter::Before);
    assert!(stage.changes().is_empty());
}

#[test]
fn a_rejection_needs_a_reason() {
    let mut harness = at(Step::Review, |_| {});
    click(&mut harness, UiCommand::Reject.text());
    assert!(harness.state_mut().changes().is_empty());
    click(&mut harness, "Reason: hands lost");
    click(&mut harness, UiCommand::Reject.text());
    let review = ReviewState::Rejected { reason: "hands lost".to_owned(), note: String::new() };
    assert_eq!(harness.state_mut().changes(), [Command::SetReview(review)]);
}

#[test]
fn the_checklist_says_what_is_doubtful_and_leads_there() {
    let mut harness = at(Step::Review, |_| {});
    let workspace = harness.state().bench.workspace.as_ref().unwrap();
    let masks = checklist(workspace).into_iter().find(|item| item.name == "Masks").unwrap();
    assert_eq!(masks.verdict, Verdict::Look);
    assert!(masks.found.contains(&format!("{} of 60", workspace.problems().len())), "{}", masks.found);
    click(&mut harness, "Go to masks");
    assert!(
        harness.state().bench.actions.iter().any(|action| matches!(action, Action::SetStep(Step::Masks)))
    );
}

#[test]
fn an_export_that_runs_can_be_stopped() {
    let mut harness =
        at(Step::Review, |bench| bench.workspace.as_mut().unwrap().exporting = Some((0.3, Some(5.0))));
    click(&mut harness, "Stop the export");
    let asked = |action: &Action| matches!(action, Action::Ask(Request::CancelExport));
    assert!(harness.state().bench.actions.iter().any(asked));
}

#[test]
fn in_a_session_of_someone_else_nothing_can_be_changed() {
    for step in Step::ALL {
        let mut harness = at(step, |bench| {
            let holder = LockHolder { program: "agenticfocus".to_owned(), pid: 7 };
            bench.workspace.as_mut().unwrap().access = Access::ReadOnly(holder);
        });
        let names: Vec<egui::Rect> =
            harness.query_all_by_role(Role::Button).map(|node| node.rect()).collect();
        for place in names {
            harness.hover_at(place.center());
            harness.drag_at(place.center());
            harness.drop_at(place.center());
            harness.run_steps(2);
        }
        assert_eq!(harness.state_mut().changes(), [], "{step:?}");
    }
}
