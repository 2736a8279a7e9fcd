//! Making an episode.

use std::{fs, path::Path};

use nalgebra::{Isometry3, Point3, Vector3};
use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

use super::{
    grasp::{GraspKind, mirrored},
    hand_shape::HandShape,
    motion::{CameraPath, HandState, Script},
    object::{ObjectKind, ObjectShape},
    pictures::{self, ClipWriter},
    scene::{ObjectLook, Part, Pass, Scene, transform},
    skin::{self, Forearm, TriangleSoup},
    spec::{EpisodeSpec, SynthError},
    texture::Finish,
    truth::{EpisodeTruth, FrameTruth, HandTruth},
};
use crate::{
    clip::STANDARD_FPS,
    geometry::{PerSide, Pinhole, Position, Side},
    image::Rgb8,
    landmarks::keypoint,
    progress::Watch,
    render::{CameraView, RenderedView},
};

/// Grid of the skin, metres.
const SKIN_CELL: f64 = 0.0036;
/// Pixels kept around hands and object in the stored crops.
const CROP_MARGIN: u32 = 24;

/// Bits of the stored mask pictures.
pub(super) mod bits {
    pub(crate) const OBJECT_VISIBLE: u8 = 1;
    pub(crate) const OBJECT_FULL: u8 = 2;
    pub(crate) const LEFT_HAND: u8 = 4;
    pub(crate) const RIGHT_HAND: u8 = 8;
}

/// Everything that stays the same over an episode.
pub(super) struct Plan {
    pub(super) spec: EpisodeSpec,
    pub(super) pinhole: Pinhole,
    pub(super) hand: HandShape,
    pub(super) camera: CameraPath,
    pub(super) script: Script,
    sleeve: Option<f64>,
}

/// What an episode's seed draws, in the order it is drawn.
pub(super) struct Drawn {
    shape: ObjectShape,
    kind: ObjectKind,
    finish: Finish,
    pub(super) plan: Plan,
    rng: Pcg64Mcg,
}

/// Draws an episode.
pub(super) fn draw(spec: &EpisodeSpec) -> Drawn {
    let mut rng = Pcg64Mcg::seed_from_u64(spec.seed.wrapping_mul(0x9E37_79B9).wrapping_add(17));
    let kind = spec.object.unwrap_or_else(|| {
        // Neighbouring seeds take different objects.
        ObjectKind::ALL[(spec.seed % ObjectKind::ALL.len() as u64) as usize]
    });
    let shape = ObjectShape::random(kind, &mut rng);
    let finish = [Finish::Label, Finish::Striped, Finish::Uniform][rng.random_range(0..3)];
    let plan = plan(spec, kind, &shape, &mut rng);
    Drawn { shape, kind, finish, plan, rng }
}

/// Makes the episode `spec` in the folder `dir` (made if missing, files in it overwritten): `clip.mp4`,
/// `truth.json`, and in `truth/` three PNGs a frame: masks, background and object.
///
/// # Errors
/// When the scene, the renderer, the encoder or the folder fails, or `watch` cancels.
pub fn generate(spec: &EpisodeSpec, dir: &Path, watch: &dyn Watch) -> Result<EpisodeTruth, SynthError> {
    let side_fits = |side: u32| (64..=4096).contains(&side) && side.is_multiple_of(2);
    if !(side_fits(spec.size.width) && side_fits(spec.size.height) && spec.frames >= 2) {
        return Err(SynthError::Spec { size: spec.size, frames: spec.frames });
    }
    let pictures_dir = dir.join("truth");
    fs::create_dir_all(&pictures_dir).map_err(SynthError::io(&pictures_dir))?;
    let Drawn { shape, kind, finish, plan, mut rng } = draw(spec);
    let ends = [plan.script.object(0.0), plan.script.object(1.0)].map(|pose| {
        let p = pose.translation.vector;
        [p.x, p.y]
    });
    let look = ObjectLook { shape: &shape, finish };
    let mut scene = Scene::random(spec.size, look, &ends, plan.camera.focus(), &mut rng)?;
    let mut clip = ClipWriter::new(&dir.join("clip.mp4"), spec.size, spec.crf)?;
    let mut frames = Vec::with_capacity(spec.frames as usize);
    for index in 0..spec.frames {
        watch.check()?;
        frames.push(make_frame(&plan, index, &mut scene, &mut clip, &pictures_dir)?);
        watch.advance(index as usize + 1, spec.frames as usize);
    }
    clip.finish()?;
    let truth = EpisodeTruth {
        version: 1,
        spec: spec.clone(),
        pinhole: plan.pinhole,
        hand_length: plan.hand.hand_length,
        object: kind,
        finish,
        grasp: plan.script.kind,
        moving_side: plan.script.side,
        sleeves: plan.sleeve.is_some(),
        frames,
    };
    let path = dir.join("truth.json");
    let json = serde_json::to_vec(&truth).map_err(|error| SynthError::damaged(&path, error))?;
    fs::write(&path, json).map_err(SynthError::io(&path))?;
    Ok(truth)
}

impl Plan {
    /// The hands that exist at `seconds`, a share `t` of the episode.
    pub(super) fn hands(&self, seconds: f64, t: f64) -> PerSide<Option<HandState>> {
        PerSide::from_fn(|side| {
            if side == self.script.side { Some(self.script.hand(t)) } else { self.script.idle(seconds, t) }
        })
    }
}

fn plan(spec: &EpisodeSpec, kind: ObjectKind, shape: &ObjectShape, rng: &mut Pcg64Mcg) -> Plan {
    let (width, height) = (f64::from(spec.size.width), f64::from(spec.size.height));
    let focal = 0.5 * width / (0.5 * rng.random_range(58.0_f64..74.0).to_radians()).tan();
    let pinhole = Pinhole {
        fx: focal,
        fy: focal,
        cx: 0.5 * (width - 1.0) + rng.random_range(-0.012..0.012) * width,
        cy: 0.5 * (height - 1.0) + rng.random_range(-0.012..0.012) * height,
        size: spec.size,
    };
    let hand = HandShape { hand_length: rng.random_range(0.172..0.200) };
    let camera = CameraPath::random(rng);
    let chance = rng.random();
    let grasp = spec.grasp.unwrap_or(GraspKind::of(kind, chance));
    let drawn = rng.random_bool(0.5);
    let both = spec.both_hands.unwrap_or(drawn);
    let script = Script::random(kind, grasp, shape, &hand, both, camera.focus(), rng);
    let sleeve = rng.random_bool(0.5).then(|| rng.random_range(0.07..0.17));
    Plan { spec: spec.clone(), pinhole, hand, camera, script, sleeve }
}

fn make_frame(
    plan: &Plan,
    index: u32,
    scene: &mut Scene,
    clip: &mut ClipWriter,
    dir: &Path,
) -> Result<FrameTruth, SynthError> {
    let seconds = f64::from(index) / STANDARD_FPS;
    let t = f64::from(index) / f64::from(plan.spec.frames - 1);
    let camera_to_world = plan.camera.at(seconds);
    let object = plan.script.object(t);
    let states = plan.hands(seconds, t);
    let mut hands = PerSide { left: None, right: None };
    for (side, state) in states.iter() {
        let Some(state) = state else { continue };
        let posed = plan.hand.pose(&state.pose);
        let (skin, sleeve) = cover(plan, side, state, &posed);
        scene.set_hand(side, &skin, &sleeve)?;
        let contact = side == plan.script.side && plan.script.holds(t);
        hands[side] = Some(hand_truth(plan, side, state, &posed.joints, &camera_to_world, contact));
    }
    scene.place_object(&object);
    let view = CameraView::new(plan.pinhole, camera_to_world);
    let all = scene.draw(&view, Pass::All)?;
    let background = scene.draw(&view, Pass::Background)?;
    let alone = scene.draw(&view, Pass::Object)?;
    let masks = masks(scene, &all, &alone);
    let mut frame = blurred(&all);
    pictures::sensor_noise(&mut frame, plan.spec.noise, plan.spec.seed << 20 | u64::from(index));
    clip.push(&frame)?;
    let crop = store(dir, index, &masks, &background, &alone)?;
    let count = |bit: u8| masks.iter().filter(|value| **value & bit != 0).count() as f64;
    let (visible, full) = (count(bits::OBJECT_VISIBLE), count(bits::OBJECT_FULL));
    Ok(FrameTruth {
        camera_to_world,
        object_to_camera: camera_to_world.inverse() * object,
        hands,
        object_hidden: if full > 0.0 { 1.0 - visible / full } else { 0.0 },
        crop,
    })
}

fn cover(
    plan: &Plan,
    side: Side,
    state: &HandState,
    posed: &super::hand_shape::PosedHand,
) -> (TriangleSoup, TriangleSoup) {
    let to_wrist = state.wrist.inverse() * Point3::from(state.elbow);
    let direction = mirrored(side, to_wrist.coords).normalize();
    // The forearm's back turns with the hand, a little less than the hand itself.
    let back = Vector3::y() - direction * direction.y;
    let back = back.try_normalize(1e-6).unwrap_or_else(Vector3::z);
    let arm = Forearm { direction, back, length: 0.42, sleeve: plan.sleeve };
    let (mut skin, mut sleeve) = skin::cover(&plan.hand, posed, &arm, SKIN_CELL);
    for soup in [&mut skin, &mut sleeve] {
        if side == Side::Right {
            mirror(soup);
        }
        transform(soup, &state.wrist);
    }
    (skin, sleeve)
}

/// Mirrors in z and keeps the faces' outer sides outside.
fn mirror(soup: &mut TriangleSoup) {
    for vector in soup.positions.iter_mut().chain(&mut soup.normals) {
        vector[2] = -vector[2];
    }
    for index in (0..soup.positions.len()).step_by(3) {
        soup.positions.swap(index, index + 1);
        soup.normals.swap(index, index + 1);
        soup.uv.swap(index, index + 1);
    }
}

pub(super) fn hand_truth(
    plan: &Plan,
    side: Side,
    state: &HandState,
    joints: &[Vector3<f64>; 21],
    camera_to_world: &Isometry3<f64>,
    contact: bool,
) -> HandTruth {
    let to_camera = camera_to_world.inverse() * state.wrist;
    let joints = joints.map(|p| Position::new((to_camera * Point3::from(mirrored(side, p))).coords));
    let keypoints = joints.map(|joint| plan.pinhole.project(&joint).unwrap_or_default());
    let size = plan.pinhole.size;
    let inside = |k: usize| {
        let p = keypoints[k];
        joints[k].xyz.z > 0.02
            && (0.0..f64::from(size.width)).contains(&p.x)
            && (0.0..f64::from(size.height)).contains(&p.y)
    };
    let in_view = inside(keypoint::WRIST) && (0..21).filter(|k| inside(*k)).count() >= 15;
    HandTruth { joints, keypoints, in_view, contact }
}

fn masks(scene: &Scene, all: &RenderedView, alone: &RenderedView) -> Vec<u8> {
    all.geom_ids
        .iter()
        .zip(&alone.geom_ids)
        .map(|(seen, object)| {
            let full = if *object >= 0 { bits::OBJECT_FULL } else { 0 };
            full | match scene.part(*seen) {
                _ if *seen < 0 => 0,
                Part::Background => 0,
                Part::Object => bits::OBJECT_VISIBLE | bits::OBJECT_FULL,
                Part::Hand(Side::Left) => bits::LEFT_HAND,
                Part::Hand(Side::Right) => bits::RIGHT_HAND,
            }
        })
        .collect()
}

fn blurred(view: &RenderedView) -> Rgb8 {
    let mut picture = view.rgb();
    let size = picture.size();
    pictures::lens_blur(size, Rgb8::CHANNELS, picture.data_mut());
    picture
}

/// Writes the truth pictures and says where the crop lies.
fn store(
    dir: &Path,
    index: u32,
    masks: &[u8],
    background: &RenderedView,
    alone: &RenderedView,
) -> Result<[u32; 4], SynthError> {
    let size = background.size;
    let name = |what: &str| dir.join(format!("{index:06}.{what}.png"));
    pictures::write_png(&name("masks"), size, png::ColorType::Grayscale, masks)?;
    let inside = crate::image::Mask::from_bytes(size, masks.to_vec());
    let bounds = inside.and_then(|mask| mask.bounding_box());
    let crop = bounds.map_or([0, 0, 1, 1], |bounds| {
        let low = |value: f64| (value as u32).saturating_sub(CROP_MARGIN);
        let (x0, y0) = (low(bounds.x0), low(bounds.y0));
        let x1 = (bounds.x1 as u32 + CROP_MARGIN).min(size.width);
        let y1 = (bounds.y1 as u32 + CROP_MARGIN).min(size.height);
        [x0, y0, x1 - x0, y1 - y0]
    });
    let cut = |channels: usize, bytes: &[u8]| {
        let stride = size.width as usize * channels;
        let columns = crop[0] as usize * channels..(crop[0] + crop[2]) as usize * channels;
        let rows = bytes.chunks_exact(stride).skip(crop[1] as usize).take(crop[3] as usize);
        rows.flat_map(|row| &row[columns.clone()]).copied().collect::<Vec<u8>>()
    };
    let crop_size = crate::geometry::Size::new(crop[2], crop[3]);
    let plate = blurred(background);
    pictures::write_png(&name("background"), crop_size, png::ColorType::Rgb, &cut(3, plate.data()))?;
    let mut object = alone.rgba.clone();
    pictures::lens_blur(size, 4, &mut object);
    straighten(&mut object);
    pictures::write_png(&name("object"), crop_size, png::ColorType::Rgba, &cut(4, &object))?;
    Ok(crop)
}

/// Divides colours by their coverage.
fn straighten(rgba: &mut [u8]) {
    for pixel in rgba.as_chunks_mut::<4>().0 {
        let alpha = u32::from(pixel[3]);
        for channel in &mut pixel[..3] {
            let straight = (u32::from(*channel) * 255 + alpha / 2).checked_div(alpha);
            *channel = straight.unwrap_or(0).min(255) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{clip::FrameIndex, geometry::Size, progress::Unwatched, render::RenderError, synth::Episode};

    #[test]
    fn a_seed_always_makes_the_same_bytes_and_its_truth_agrees_with_its_pictures() {
        let spec = EpisodeSpec {
            seed: 2,
            size: Size::new(160, 120),
            frames: 3,
            both_hands: Some(true),
            ..EpisodeSpec::default()
        };
        let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        for folder in &folders {
            match generate(&spec, folder.path(), &Unwatched) {
                Ok(_) => {}
                Err(SynthError::Render(RenderError::NoContext { tried })) => {
                    println!("skipped: no EGL device ({tried})");
                    return;
                }
                Err(error) => panic!("{error}"),
            }
        }
        for file in ["clip.mp4", "truth.json", "truth/000001.masks.png", "truth/000002.object.png"] {
            let read = |index: usize| fs::read(folders[index].path().join(file)).unwrap();
            assert!(read(0) == read(1), "{file} differs");
        }
        let episode = Episode::load(folders[0].path()).unwrap();
        let middle = FrameIndex(1);
        let (visible, full) = (episode.object_visible(middle).unwrap(), episode.object_full(middle).unwrap());
        assert!(full.area() > 50 && visible.minus(&full).is_empty());
        let hidden = 1.0 - visible.area() as f64 / full.area() as f64;
        assert!((hidden - episode.truth.frames[1].object_hidden).abs() < 1e-9);
        for (side, hand) in episode.truth.frames[1].hands.iter() {
            let Some(hand) = hand.as_ref().filter(|hand| hand.in_view) else { continue };
            let mask = episode.hand(middle, side).unwrap().union(&visible);
            let covered = hand.keypoints.iter().filter(|p| mask.get(p.x.round() as u32, p.y.round() as u32));
            assert!(covered.count() >= 14, "{side:?}");
        }
    }
}
