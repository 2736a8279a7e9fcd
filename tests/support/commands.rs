//! Commands by chance: every kind, with values of every kind.

use std::collections::BTreeMap;

use agenticfocus::{
    clip::{CameraSpec, FrameIndex},
    geometry::{PerSide, Pixel, PixelBox, Side},
    retarget::{Beta, CameraAngles, CameraRotation, Method, Smoothing, WristTurn},
    session::{
        Author, Command, Entry, HandEdit, LayerOrder, LayerOrderRange, MaskEdit, MaskId, MaskLayer,
        MaskReach, ObjectAnswer, ObjectPromptKind, ObjectProposal, RetargetSettings, ReviewState, Said,
        SidesSwapped, Step,
    },
};
use nalgebra::Matrix3;
use proptest::{option, prelude::*};

/// Kinds of commands.
pub const KINDS: usize = 21;

/// Which kind: a new one does not compile until it is drawn here.
pub fn kind(command: &Command) -> usize {
    match command {
        Command::SetTask(_) => 0,
        Command::SetContentHash(_) => 1,
        Command::SetCamera(_) => 2,
        Command::SetProposals(_) => 3,
        Command::SetObject(_) => 4,
        Command::SetMask { .. } => 5,
        Command::SetTemplateFrame(_) => 6,
        Command::SetTemplateMask(_) => 7,
        Command::SetPlacement { .. } => 8,
        Command::SetHandTrack(_) => 9,
        Command::SetHandEdit { .. } => 10,
        Command::SetSidesSwapped(_) => 11,
        Command::SetRetarget(_) => 12,
        Command::SetLayerOrders(_) => 13,
        Command::SetConfirmed { .. } => 14,
        Command::SetReview(_) => 15,
        Command::Together(_) => 16,
        Command::SetReach { .. } => 17,
        Command::SetInterpolated { .. } => 18,
        Command::SetObjectAnswer(_) => 19,
        Command::SetHoleDilation(_) => 20,
    }
}

/// Few, so that commands meet.
fn frame() -> impl Strategy<Value = FrameIndex> {
    (0_u32..4).prop_map(FrameIndex)
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![-1e4..1e4_f64, Just(0.0), Just(-0.0), Just(0.1 + 0.2), Just(f64::MIN_POSITIVE), Just(1e300)]
}

fn pixel() -> impl Strategy<Value = Pixel> {
    (number(), number()).prop_map(|(x, y)| Pixel::new(x, y))
}

fn text() -> impl Strategy<Value = String> {
    "[a-zß\"\\\\\n ]{0,8}"
}

fn mask_id() -> impl Strategy<Value = MaskId> {
    "[0-9a-f]{64}".prop_map(|text| MaskId::try_from(text).unwrap())
}

fn prompt() -> impl Strategy<Value = ObjectPromptKind> {
    let points = || prop::collection::vec(pixel(), 0..3);
    prop_oneof![
        (number(), number(), number(), number())
            .prop_map(|(x0, y0, x1, y1)| ObjectPromptKind::Box(PixelBox { x0, y0, x1, y1 })),
        (points(), points()).prop_map(|(positive, negative)| ObjectPromptKind::Points { positive, negative }),
    ]
}

fn proposal() -> impl Strategy<Value = ObjectProposal> {
    let author = prop_oneof![Just(Author::Human), Just(Author::Manifest), text().prop_map(Author::Machine)];
    (text(), frame(), prompt(), 0.0..1.0_f64, text(), author).prop_map(
        |(label, frame, prompt, confidence, reason, author)| ObjectProposal {
            label,
            frame,
            prompt,
            confidence,
            reason,
            author,
        },
    )
}

fn object_answer() -> impl Strategy<Value = ObjectAnswer> {
    let said = prop_oneof![
        proposal().prop_map(Said::Object),
        text().prop_map(Said::Nothing),
        text().prop_map(Said::Unusable),
    ];
    let texts = prop::collection::vec(text(), 0..3);
    (text(), text(), text(), prop::collection::vec(frame(), 0..5), texts, said).prop_map(
        |(request, model, profile, frames, raw, said)| ObjectAnswer {
            request,
            model,
            profile,
            frames,
            raw,
            said,
        },
    )
}

fn camera() -> impl Strategy<Value = CameraSpec> {
    prop_oneof![
        Just(CameraSpec::Unknown),
        (1.0..179.0_f64).prop_map(CameraSpec::HorizontalFov),
        (1.0..1e4_f64, 1.0..1e4_f64, number(), number())
            .prop_map(|(fx, fy, cx, cy)| CameraSpec::Intrinsics { fx, fy, cx, cy }),
    ]
}

fn rotation() -> impl Strategy<Value = CameraRotation> {
    let angle = || -180.0..180.0_f64;
    prop_oneof![
        (angle(), angle(), angle()).prop_map(|(pitch_deg, yaw_deg, roll_deg)| {
            CameraRotation::Angles(CameraAngles { pitch_deg, yaw_deg, roll_deg })
        }),
        Just(CameraRotation::Rows([[0.0, 0.0, 1.0], [-1.0, -0.0, 0.0], [0.0, -1.0, 0.0]])),
    ]
}

fn retarget() -> impl Strategy<Value = RetargetSettings> {
    let beta = prop_oneof![Just(Beta::Fit), (0.05..5.0_f64).prop_map(Beta::Fixed)];
    (
        (option::of(prop::sample::select(Method::ALL.to_vec())), option::of(any::<bool>()), option::of(beta)),
        option::of(0.01..1.0_f64),
        option::of(rotation()),
        option::of(prop::array::uniform3(-10.0..10.0_f64)),
        option::of(0.1..0.3_f64),
        option::of(prop_oneof![Just(Smoothing::None), Just(Smoothing::Ema), Just(Smoothing::ZeroPhase)]),
        option::of((-180.0..180.0_f64, -180.0..180.0_f64, -180.0..180.0_f64)),
    )
        .prop_map(
            |((method, shared_map, beta), alpha, camera_rotation, offset, hand_length, smoothing, turn)| {
                RetargetSettings {
                    method,
                    shared_map,
                    beta,
                    alpha,
                    smoothing,
                    wrist: PerSide {
                        left: WristTurn::default(),
                        right: turn.map_or_else(WristTurn::default, |(roll_deg, pitch_deg, yaw_deg)| {
                            WristTurn { roll_deg, pitch_deg, yaw_deg }
                        }),
                    },
                    camera_rotation,
                    offset,
                    hand_length,
                }
            },
        )
}

fn review() -> impl Strategy<Value = ReviewState> {
    prop_oneof![
        Just(ReviewState::Unreviewed),
        Just(ReviewState::Accepted),
        text().prop_map(|reason| ReviewState::NeedsReview { reason }),
        (text(), text()).prop_map(|(reason, note)| ReviewState::Rejected { reason, note }),
        (text(), text()).prop_map(|(reason, note)| ReviewState::Flagged { reason, note }),
    ]
}

fn order() -> impl Strategy<Value = LayerOrderRange> {
    let order =
        prop_oneof![Just(LayerOrder::Auto), Just(LayerOrder::RobotInFront), Just(LayerOrder::ObjectInFront)];
    (frame(), frame(), order, option::of(any::<bool>()))
        .prop_map(|(first, last, order, thumb)| LayerOrderRange { first, last, order, thumb })
}

fn per_frame() -> impl Strategy<Value = Command> {
    let layer = prop_oneof![Just(MaskLayer::Object), Just(MaskLayer::Arms)];
    let side = prop_oneof![Just(Side::Left), Just(Side::Right)];
    let mask = prop_oneof![Just(MaskEdit::Absent), mask_id().prop_map(MaskEdit::Mask)];
    let placed = (0.5..2.0_f64, -1e3..1e3_f64, -1e-3..1e-3_f64)
        .prop_map(|(scale, along, slant)| Matrix3::new(scale, slant, along, -0.0, scale, 0.1, 0.0, 0.0, 1.0));
    let hand = (prop::collection::btree_map(0_u8..21, pixel(), 0..4), any::<bool>())
        .prop_map(|(keypoints, invalid)| HandEdit { keypoints, invalid });
    prop_oneof![
        (layer, frame(), option::of(mask)).prop_map(|(layer, frame, edit)| Command::SetMask {
            layer,
            frame,
            edit
        }),
        (frame(), option::of((any::<bool>(), any::<bool>()))).prop_map(|(frame, reach)| {
            let reach = reach.map(|(backward, forward)| MaskReach { backward, forward });
            Command::SetReach { frame, reach }
        }),
        (frame(), option::of(placed))
            .prop_map(|(frame, transform)| Command::SetPlacement { frame, transform }),
        (frame(), any::<bool>())
            .prop_map(|(frame, interpolated)| Command::SetInterpolated { frame, interpolated }),
        (frame(), side, option::of(hand)).prop_map(|(frame, side, edit)| Command::SetHandEdit {
            frame,
            side,
            edit
        }),
    ]
}

fn per_clip() -> impl Strategy<Value = Command> {
    let swapped = (frame(), frame()).prop_map(|(first, last)| SidesSwapped { first, last });
    prop_oneof![
        option::of(text()).prop_map(Command::SetTask),
        camera().prop_map(Command::SetCamera),
        option::of(proposal()).prop_map(Command::SetObject),
        option::of(0.0..0.05_f64).prop_map(Command::SetHoleDilation),
        option::of(frame()).prop_map(Command::SetTemplateFrame),
        option::of(mask_id()).prop_map(Command::SetTemplateMask),
        option::of(text()).prop_map(Command::SetHandTrack),
        prop::collection::vec(swapped, 0..3).prop_map(Command::SetSidesSwapped),
        retarget().prop_map(Command::SetRetarget),
        prop::collection::vec(order(), 0..3).prop_map(Command::SetLayerOrders),
        (prop::sample::select(Step::ALL.to_vec()), any::<bool>())
            .prop_map(|(step, confirmed)| Command::SetConfirmed { step, confirmed }),
        review().prop_map(Command::SetReview),
    ]
}

fn nested(leaf: impl Strategy<Value = Command> + 'static) -> BoxedStrategy<Command> {
    leaf.prop_recursive(2, 8, 4, |inner| prop::collection::vec(inner, 0..4).prop_map(Command::Together))
        .boxed()
}

/// What only a machine says.
pub fn machine_command() -> BoxedStrategy<Command> {
    nested(prop_oneof![
        "[0-9a-f]{8}".prop_map(Command::SetContentHash),
        prop::collection::vec(proposal(), 0..3).prop_map(Command::SetProposals),
        option::of(object_answer()).prop_map(|answer| Command::SetObjectAnswer(answer.map(Box::new))),
    ])
}

/// What a person says.
pub fn human_command() -> BoxedStrategy<Command> {
    nested(prop_oneof![3 => per_frame(), 5 => per_clip()])
}

/// Anything.
pub fn command() -> BoxedStrategy<Command> {
    prop_oneof![6 => human_command(), 1 => machine_command()].boxed()
}

/// A command with a value out of range.
pub fn refused_command() -> impl Strategy<Value = Command> {
    let settings = RetargetSettings::default;
    let hand = |index: u8, x: f64| Command::SetHandEdit {
        frame: FrameIndex(0),
        side: Side::Left,
        edit: Some(HandEdit { keypoints: BTreeMap::from([(index, Pixel::new(x, 0.0))]), invalid: false }),
    };
    let object = |confidence: f64, prompt: ObjectPromptKind| ObjectProposal {
        label: String::new(),
        frame: FrameIndex(0),
        prompt,
        confidence,
        reason: String::new(),
        author: Author::Human,
    };
    let bounds = |x0: f64| ObjectPromptKind::Box(PixelBox { x0, y0: 0.0, x1: 9.0, y1: 9.0 });
    let beside = |y: f64| ObjectPromptKind::Points {
        positive: vec![Pixel::new(1.0, 1.0)],
        negative: vec![Pixel::new(0.0, y)],
    };
    let answer = |object: ObjectProposal| ObjectAnswer {
        request: String::new(),
        model: String::new(),
        profile: String::new(),
        frames: Vec::new(),
        raw: Vec::new(),
        said: Said::Object(object),
    };
    prop::sample::select(vec![
        Command::SetObjectAnswer(Some(Box::new(answer(object(0.5, bounds(f64::NAN)))))),
        Command::SetObject(Some(object(0.5, bounds(f64::NAN)))),
        Command::SetObject(Some(object(0.5, beside(f64::NEG_INFINITY)))),
        Command::SetProposals(vec![object(0.5, bounds(0.0)), object(f64::NAN, bounds(0.0))]),
        hand(3, f64::NAN),
        Command::SetCamera(CameraSpec::HorizontalFov(180.0)),
        Command::SetCamera(CameraSpec::Intrinsics { fx: f64::NAN, fy: 1.0, cx: 0.0, cy: 0.0 }),
        Command::SetPlacement { frame: FrameIndex(1), transform: Some(Matrix3::zeros()) },
        hand(21, 0.0),
        Command::SetHoleDilation(Some(0.06)),
        Command::SetHoleDilation(Some(f64::NAN)),
        Command::SetRetarget(RetargetSettings { alpha: Some(0.0), ..settings() }),
        Command::SetRetarget(RetargetSettings { beta: Some(Beta::Fixed(f64::INFINITY)), ..settings() }),
        Command::SetRetarget(RetargetSettings { offset: Some([0.0, f64::NAN, 0.0]), ..settings() }),
        Command::SetRetarget(RetargetSettings { hand_length: Some(1.0), ..settings() }),
    ])
}

/// Entries as they come while a person and a machine work on one session.
pub fn entries(
    human: BoxedStrategy<Command>,
    machine: BoxedStrategy<Command>,
) -> impl Strategy<Value = Vec<Entry>> {
    let entry = prop_oneof![
        5 => human.prop_map(Entry::Do),
        2 => machine.prop_map(Entry::Found),
        3 => Just(Entry::Undo),
        2 => Just(Entry::Redo),
    ];
    prop::collection::vec(entry, 0..16)
}
