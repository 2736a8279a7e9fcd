use super::*;

/// A frame whose left half is arm, sent in a picture with a bar at the bottom.
struct Scene {
    letterbox: Letterbox,
    frames: [FrameIndex; 2],
}

impl Scene {
    fn new() -> Self {
        let letterbox =
            Letterbox { clip: Size::new(200, 100), sent: Size::new(448, 448), content: Size::new(448, 224) };
        Self { letterbox, frames: [FrameIndex(0), FrameIndex(8)] }
    }

    fn validate(&self, answer: &Answer, profile: Profile) -> Result<Selection, Invalid> {
        let arms = |_| Mask::from_fn(Size::new(200, 100), |x, _| x < 100);
        let shown = Shown { profile, frames: &self.frames, letterbox: &self.letterbox, arms: &arms };
        validate(answer, &shown)
    }
}

fn boxed(corners: [f64; 4]) -> Answer {
    let [x1, y1, x2, y2] = corners;
    let corners = Some([Pixel::new(x1, y1), Pixel::new(x2, y2)]);
    Answer { found: true, frame: Some(8.0), corners, ..Answer::default() }
}

fn close(a: &PixelBox, b: [f64; 4]) -> bool {
    [a.x0 - b[0], a.y0 - b[1], a.x1 - b[2], a.y1 - b[3]].iter().all(|error| error.abs() < 1e-9)
}

#[test]
fn a_box_comes_back_in_the_clip_s_pixels_under_every_profile() {
    let scene = Scene::new();
    // The clip's (120, 20) to (180, 80), the corners in any order.
    for (profile, corners) in [
        (Profile::Rel1000Xyxy, [600.0, 100.0, 900.0, 400.0]),
        (Profile::Rel1000Yxyx, [900.0, 400.0, 600.0, 100.0]),
        (Profile::AbsXyxy, [268.8, 179.2, 403.2, 44.8]),
    ] {
        let selection = scene.validate(&boxed(corners), profile).unwrap();
        let Place::Box(bounds) = selection.place else { panic!() };
        assert!(close(&bounds, [120.0, 20.0, 180.0, 80.0]), "{profile}: {bounds:?}");
        assert_eq!((selection.frame, selection.confidence), (FrameIndex(8), 0.5));
    }
    let point = Answer { point: Some(Pixel::new(75.0, 25.0)), ..boxed([0.0; 4]) };
    let selection = scene.validate(&point, Profile::PctPoint).unwrap();
    assert_eq!(selection.place, Place::Point(Pixel::new(150.0, 50.0)));
}

#[test]
fn boxes_that_cannot_be_are_refused_each_for_its_reason() {
    let scene = Scene::new();
    let refused = |answer: &Answer| scene.validate(answer, Profile::Rel1000Xyxy).unwrap_err();
    assert!(matches!(refused(&boxed([600.0, 100.0, 2400.0, 400.0])), Invalid::Outside { .. }));
    assert!(matches!(refused(&boxed([600.0, 600.0, 900.0, 900.0])), Invalid::Outside { .. }), "on the bar");
    assert!(matches!(refused(&boxed([600.0, 100.0, 604.0, 101.0])), Invalid::Area { .. }));
    assert!(matches!(refused(&boxed([0.0; 4])), Invalid::Area { .. }));
    assert!(matches!(refused(&boxed([0.0, 0.0, 1000.0, 500.0])), Invalid::Area { .. }));
    assert!(matches!(refused(&boxed([100.0, 100.0, 510.0, 400.0])), Invalid::OnHand { .. }));
    assert!(matches!(refused(&boxed([f64::NAN, 1.0, 2.0, 3.0])), Invalid::NotFinite));
    assert!(matches!(refused(&boxed([f64::INFINITY, 1.0, 2.0, 3.0])), Invalid::NotFinite));
    let fine = boxed([600.0, 100.0, 900.0, 400.0]);
    assert!(matches!(refused(&Answer { frame: None, ..fine.clone() }), Invalid::NoFrame(_)));
    assert!(matches!(refused(&Answer { frame: Some(7.0), ..fine.clone() }), Invalid::OtherFrame { .. }));
    assert!(matches!(refused(&Answer { corners: None, ..fine }), Invalid::NoBox));
    let on_hand = Answer { point: Some(Pixel::new(25.0, 25.0)), ..boxed([0.0; 4]) };
    assert_eq!(scene.validate(&on_hand, Profile::PctPoint), Err(Invalid::PointOnHand));
}

#[test]
fn what_lies_a_little_outside_is_cut_off_and_said() {
    let scene = Scene::new();
    let selection = scene.validate(&boxed([800.0, 100.0, 1100.0, 400.0]), Profile::Rel1000Xyxy).unwrap();
    let Place::Box(bounds) = selection.place else { panic!() };
    assert!(close(&bounds, [160.0, 20.0, 200.0, 80.0]), "{bounds:?}");
    assert_eq!(selection.remarks.len(), 1);
}

#[test]
fn words_of_a_model_are_one_short_line() {
    let scene = Scene::new();
    let answer = Answer {
        label: Some("\u{1b}[31mcup\n\n of  tea".to_owned()),
        reason: Some("x".repeat(4000)),
        hand: Some("right".to_owned()),
        confidence: Some(85.0),
        ..boxed([600.0, 100.0, 900.0, 400.0])
    };
    let selection = scene.validate(&answer, Profile::Rel1000Xyxy).unwrap();
    assert_eq!((selection.label.as_str(), selection.confidence), ("[31mcup of tea", 0.85));
    assert!(selection.reason.ends_with("… (right hand)") && selection.reason.len() < 330);
}
