//! What the engine "found out" about the made-up clip.

use std::sync::{Arc, LazyLock};

use agenticfocus::{
    clip::{CameraSpec, ClipFlag, ClipInfo, FrameIndex, FrameRow, Rotation},
    composite::LayerDecision,
    geometry::{PerSide, Position, Side},
    hands::{HandFrame, HandState, HandTrack},
    inpaint::{FrameCoverage, InpaintReport},
    landmarks::HandLandmarks,
    retarget::{CameraMap, CameraRotation, Method, RobotMotion, SideReport},
    robot::JointAngles,
    segment::{ArmTrack, MaskAuthor, MaskFlag, MaskFrame, MaskTrack, RleMask},
    template::{Placement, TemplateTrack},
};
use agenticfocus_ui::state::Findings;

use super::scene::{self, FRAMES, SIZE};

fn each<T>(make: impl FnMut(u32) -> T) -> Vec<T> {
    (0..FRAMES).map(make).collect()
}

fn row(at: u32) -> FrameRow {
    let pts = f64::from(at) / 30.0;
    FrameRow { index: FrameIndex(at), pts, source_frame: at, source_pts: pts, stored: at }
}

fn clip() -> ClipInfo {
    ClipInfo {
        path: "/clips/cup_lid.mp4".into(),
        hash: "0".repeat(64),
        codec: "h264".to_owned(),
        size: SIZE,
        decoded_size: SIZE,
        rotate: Rotation::Deg0,
        intrinsics: scene::camera(),
        intrinsics_source: CameraSpec::Unknown,
        source_fps: 30.0,
        source_frames: FRAMES,
        frame_table: each(row),
        flags: vec![ClipFlag::DefaultIntrinsics],
        messages: Vec::new(),
    }
}

fn object_frame(at: u32) -> MaskFrame {
    let (score, flags) = match at {
        21..=24 => (0.3, vec![MaskFlag::AreaJump]),
        33 => (0.45, vec![MaskFlag::LowOverlap, MaskFlag::ColourDrift]),
        45..=48 => (0.1, vec![MaskFlag::Lost]),
        _ => (0.78 + 0.12 * (f64::from(at) * 0.35).sin(), Vec::new()),
    };
    let lost = flags.contains(&MaskFlag::Lost);
    MaskFrame {
        mask: if lost { RleMask::empty(SIZE) } else { scene::object_mask(at) },
        author: if at == 8 { MaskAuthor::Seeded } else { MaskAuthor::Propagated },
        score,
        flags,
    }
}

fn arms_frame(at: u32) -> MaskFrame {
    MaskFrame {
        mask: scene::arms_mask(at),
        author: MaskAuthor::Seeded,
        score: if at == 40 { 0.4 } else { 0.9 },
        flags: if at == 40 { vec![MaskFlag::ColourDrift] } else { vec![MaskFlag::TouchesBorder] },
    }
}

fn hand(side: Side, at: u32) -> HandFrame {
    let state = match (side, at) {
        (Side::Left, 30..=35) | (Side::Right, 20..=23) => HandState::Bridged,
        (Side::Left, 36..=47) | (Side::Right, 0..=4) => return HandFrame::invalid(),
        _ => HandState::Observed,
    };
    let keypoints = scene::keypoints(side.index(), at);
    let camera = scene::camera();
    HandFrame {
        state,
        confidence: if state == HandState::Bridged { 0.5 } else { 0.93 },
        joints: keypoints.map(|pixel| camera.unproject(pixel, 0.45)),
        keypoints,
        mano: None,
    }
}

fn landmarks(at: u32) -> PerSide<Option<HandLandmarks>> {
    PerSide::from_fn(|side| {
        let hand = hand(side, at);
        let seen = hand.state == HandState::Observed;
        seen.then_some(HandLandmarks { keypoints: hand.keypoints, world: None, confidence: hand.confidence })
    })
}

fn report(side: Side, at: u32) -> SideReport {
    let t = f64::from(at);
    let held = (((t - 18.0) / 4.0).clamp(0.0, 1.0) * ((46.0 - t) / 4.0).clamp(0.0, 1.0)).clamp(0.0, 1.0);
    let far = side == Side::Right && (41..=43).contains(&at);
    SideReport {
        driven: hand(side, at).is_valid(),
        target: Default::default(),
        reached: Default::default(),
        fingertips: [Position::default(); 5],
        error_position: if far { 0.03 } else { 0.003 + 0.002 * (t * 0.3).sin().abs() },
        error_rotation: 0.05 + 0.03 * (t * 0.2).cos().abs(),
        limit_margin: 0.2 + 0.1 * (t * 0.15).sin(),
        reachable: !far,
        contact: if side == Side::Right { held } else { 0.0 },
    }
}

fn angles(at: u32, jitter: f64) -> JointAngles {
    JointAngles(std::array::from_fn(|joint| {
        let phase = f64::from(at) * 0.1 + joint as f64 * 0.7;
        0.5 * phase.sin() + jitter * (f64::from(at) * 2.3 + joint as f64).sin()
    }))
}

fn motion() -> RobotMotion {
    let offset = scene::camera().unproject(scene::table_point(), 0.4).xyz;
    RobotMotion {
        method: Method::Ours,
        map: CameraMap { beta: 0.87, rotation: CameraRotation::default().matrix().unwrap(), offset },
        alpha: 0.5,
        angles: each(|at| angles(at, 0.0)),
        raw_angles: each(|at| angles(at, 0.03)),
        sides: PerSide::from_fn(|side| each(|at| report(side, at))),
    }
}

fn template() -> TemplateTrack {
    let (picture, origin) = scene::template();
    let placed = |at: u32| Placement {
        transform: scene::placement(at),
        confidence: if (45..=48).contains(&at) { 0.2 } else { 0.9 },
        visible: if (20..=44).contains(&at) { 0.6 } else { 0.95 },
    };
    TemplateTrack {
        picture,
        origin,
        frame: FrameIndex(0),
        placements: each(|at| (at != 50).then(|| placed(at))),
        scores: each(|at| if at < 10 { 0.95 - 0.02 * f64::from(at) } else { 0.3 + 0.005 * f64::from(at) }),
    }
}

fn coverage(at: u32) -> FrameCoverage {
    let synthesised = 0.04 + 0.03 * (f64::from(at) * 0.2).sin().abs();
    let behind_template = if (20..=44).contains(&at) { 0.05 } else { 0.0 };
    FrameCoverage {
        hole: 9_000 + 40 * u64::from(at),
        seen: 1.0 - synthesised - behind_template,
        synthesised,
        behind_template,
    }
}

fn order(at: u32) -> LayerDecision {
    let behind = (25..=38).contains(&at);
    LayerDecision {
        in_front: PerSide { left: 1.0, right: if behind { 0.0 } else { 1.0 } },
        near: PerSide { left: 0.0, right: if behind { 1.0 } else { 0.0 } },
    }
}

static FINDINGS: LazyLock<Findings> = LazyLock::new(find);

/// Everything there is to find out.
pub fn sample_findings() -> Findings {
    FINDINGS.clone()
}

fn find() -> Findings {
    let object = MaskTrack { size: SIZE, frames: each(object_frame), backend: "classical".to_owned() };
    let union = MaskTrack { size: SIZE, frames: each(arms_frame), backend: "classical".to_owned() };
    let sides = PerSide::from_fn(|side| each(|at| scene::side_mask(side, at)));
    Findings {
        clip: Some(Arc::new(clip())),
        landmarks: Some(Arc::new(each(landmarks))),
        arms: Some(Arc::new(ArmTrack { union, sides })),
        choice: super::sample_proposals().into_iter().next(),
        object: Some(Arc::new(object)),
        object_frames: Default::default(),
        template: Some(Arc::new(template())),
        background: Some(Arc::new(InpaintReport {
            coverage: each(coverage),
            plates: 4,
            backend: "temporal-plate".to_owned(),
        })),
        hands: Some(Arc::new(HandTrack {
            hands: PerSide::from_fn(|side| each(|at| hand(side, at))),
            hand_length: PerSide { left: Some(0.178), right: Some(0.181) },
            backend: "mediapipe".to_owned(),
        })),
        motion: Some(Arc::new(motion())),
        order: Some(Arc::new(each(order))),
        model_faults: Default::default(),
    }
}

/// Repeats what was found until there are `count` frames.
pub fn lengthen(found: &mut Findings, count: usize) {
    fn repeat<T: Clone>(list: &[T], count: usize) -> Vec<T> {
        list.iter().cycle().take(count).cloned().collect()
    }
    if let Some(clip) = found.clip.as_mut().map(Arc::make_mut) {
        clip.frame_table = (0..count as u32).map(row).collect();
    }
    if let Some(arms) = found.arms.as_mut().map(Arc::make_mut) {
        arms.union.frames = repeat(&arms.union.frames, count);
        arms.sides = PerSide::from_fn(|side| repeat(&arms.sides[side], count));
    }
    if let Some(object) = found.object.as_mut().map(Arc::make_mut) {
        object.frames = repeat(&object.frames, count);
    }
    if let Some(hands) = found.hands.as_mut().map(Arc::make_mut) {
        hands.hands = PerSide::from_fn(|side| repeat(&hands.hands[side], count));
    }
    if let Some(motion) = found.motion.as_mut().map(Arc::make_mut) {
        motion.angles = repeat(&motion.angles, count);
        motion.raw_angles = repeat(&motion.raw_angles, count);
        motion.sides = PerSide::from_fn(|side| repeat(&motion.sides[side], count));
    }
    if let Some(background) = found.background.as_mut().map(Arc::make_mut) {
        background.coverage = repeat(&background.coverage, count);
    }
    if let Some(template) = found.template.as_mut().map(Arc::make_mut) {
        template.placements = repeat(&template.placements, count);
        template.scores = repeat(&template.scores, count);
    }
    if let Some(order) = found.order.as_mut().map(Arc::make_mut) {
        *order = repeat(order, count);
    }
}
