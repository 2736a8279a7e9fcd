//! The thread that makes pictures.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Arc,
};

use super::{
    drafts::Drafts,
    panic_text,
    scene::{DraftWish, HandWish, PaintJob, Scene, Shared},
};
use crate::{
    clip::{FrameIndex, FrameSource, StandardClip},
    composite::Compositor,
    engine::{Event, Layers, OrbitCamera, PictureKind, PictureRequest, Shown},
    geometry::Size,
    hands::{HandFrame, fit_frame, length_of},
    image::Rgb8,
    landmarks::HandLandmarks,
    pipeline::{FramePixels, compose_frame, layers_of, render_robot, robot_renderer},
    render::{OrbitRenderer, RobotRenderer},
    robot::RobotModel,
};

/// The painter's own things; OpenGL contexts belong to its thread.
#[derive(Default)]
struct Studio {
    robot: Option<(Arc<StandardClip>, RobotModel, RobotRenderer)>,
    orbit: Option<(RobotModel, OrbitRenderer)>,
}

pub(super) fn run(shared: &Shared) {
    let (mut studio, mut drafts) = (Studio::default(), Drafts::default());
    loop {
        match shared.next_paint_job() {
            PaintJob::Stop => return,
            PaintJob::Picture(request) => {
                let painted = catch_unwind(AssertUnwindSafe(|| paint(shared, &mut studio, &request)));
                let result = painted.unwrap_or_else(|panic| {
                    // A renderer that panicked may be in any state.
                    studio = Studio::default();
                    Err(panic_text(&*panic))
                });
                shared.tell(Event::Picture { request, result });
            }
            PaintJob::Hand(wish) => {
                let fitted = catch_unwind(AssertUnwindSafe(|| fitted(shared, &wish)));
                let result = fitted.unwrap_or_else(|panic| Err(panic_text(&*panic))).map(Box::new);
                let HandWish { frame, side, keypoints } = wish;
                shared.tell(Event::HandDraft { frame, side, keypoints, result });
            }
            PaintJob::Draft(wish) => {
                let drawn = catch_unwind(AssertUnwindSafe(|| drafts.mask(shared, &clip_of(shared)?, &wish)));
                let result = drawn.unwrap_or_else(|panic| {
                    drafts = Drafts::default();
                    Err(panic_text(&*panic))
                });
                let DraftWish { layer, frame, positive, negative, .. } = wish;
                let points = (positive, negative);
                shared.tell(Event::Draft { layer, frame, points, result });
            }
        }
    }
}

fn clip_of(shared: &Shared) -> Result<Arc<StandardClip>, String> {
    let clip = shared.open_clip().and_then(|open| open.memory.latest_clip());
    clip.ok_or_else(|| "the clip is not decoded yet".to_owned())
}

fn scene_of(shared: &Shared) -> Result<Scene, String> {
    match (shared.scene(), shared.fault()) {
        (Some(scene), _) => Ok(scene),
        (None, Some(fault)) => Err(fault),
        (None, None) => Err("it is not worked out yet".to_owned()),
    }
}

/// A hand as its keypoints are dragged, as long as it was when the clip was fitted.
fn fitted(shared: &Shared, wish: &HandWish) -> Result<HandFrame, String> {
    let clip = clip_of(shared)?;
    let found = shared.scene().map(|scene| Arc::clone(&scene.found.hands));
    let length = length_of(found.as_deref(), wish.side);
    let before = found.as_ref().and_then(|track| track.hands[wish.side].get(wish.frame.as_usize()));
    let seen = HandLandmarks { keypoints: *wish.keypoints, world: None, confidence: 1.0 };
    fit_frame(&seen, wish.side, &clip.info.intrinsics, length, before).map_err(|error| error.to_string())
}

fn paint(shared: &Shared, studio: &mut Studio, request: &PictureRequest) -> Result<Shown, String> {
    let frame = request.frame;
    match request.kind {
        PictureKind::Source => Ok(Shown::Picture(Arc::new(source(&*clip_of(shared)?, frame)?))),
        PictureKind::Thumbnail { height } => {
            let picture = source(&*clip_of(shared)?, frame)?;
            let size = picture.size();
            let width = (size.width * height / size.height.max(1)).max(1);
            let small =
                picture.resized(Size::new(width, height.max(1))).map_err(|error| error.to_string())?;
            Ok(Shown::Picture(Arc::new(small)))
        }
        PictureKind::Composite => {
            let layers = layers(studio, &scene_of(shared)?, frame)?;
            Ok(Shown::Layers(Arc::new(layers)))
        }
        PictureKind::Orbit { camera, size } => {
            let picture = orbit(studio, &scene_of(shared)?, frame, &camera, size)?;
            Ok(Shown::Picture(Arc::new(picture)))
        }
    }
}

fn source(clip: &dyn FrameSource, frame: FrameIndex) -> Result<Rgb8, String> {
    clip.frame(frame).map_err(|error| error.to_string())
}

/// Whether both share one compiled model; a clip's is loaded once.
fn is_same(one: &RobotModel, other: &RobotModel) -> bool {
    Arc::ptr_eq(one.mujoco(), other.mujoco())
}

/// A frame's layers, made as the export makes them.
fn layers(studio: &mut Studio, scene: &Scene, frame: FrameIndex) -> Result<Layers, String> {
    let found = &scene.found;
    let pixels = FramePixels {
        source: source(&*found.clip, frame)?,
        background: source(&found.background.frames, frame)?,
    };
    let known = studio
        .robot
        .as_ref()
        .is_some_and(|(clip, robot, _)| Arc::ptr_eq(clip, &found.clip) && is_same(robot, &found.robot));
    if !known {
        let renderer = robot_renderer(found).map_err(|failure| failure.message)?;
        studio.robot = Some((Arc::clone(&found.clip), found.robot.clone(), renderer));
    }
    let Some((_, _, renderer)) = &mut studio.robot else { return Err("no renderer".to_owned()) };
    let robot = render_robot(renderer, found, &scene.plan, frame).map_err(|failure| failure.message)?;
    let composed = compose_frame(&Compositor::default(), found, &scene.plan, frame, &pixels, &robot)
        .map_err(|failure| failure.message)?;
    Ok(layers_of(pixels.background, robot, composed, &scene.plan.order[frame.as_usize()]))
}

fn orbit(
    studio: &mut Studio,
    scene: &Scene,
    frame: FrameIndex,
    camera: &OrbitCamera,
    size: Size,
) -> Result<Rgb8, String> {
    let robot = &scene.found.robot;
    let large_enough = |renderer: &OrbitRenderer| {
        renderer.size().width >= size.width && renderer.size().height >= size.height
    };
    let known = studio
        .orbit
        .as_ref()
        .is_some_and(|(known, renderer)| is_same(known, robot) && large_enough(renderer));
    if !known {
        let renderer = OrbitRenderer::new(robot, size).map_err(|error| error.to_string())?;
        studio.orbit = Some((robot.clone(), renderer));
    }
    let Some((_, renderer)) = &mut studio.orbit else { return Err("no renderer".to_owned()) };
    let angles = scene.found.motion.angles.get(frame.as_usize()).ok_or("beyond the clip's end")?;
    renderer.render(angles, camera, size).map_err(|error| error.to_string())
}
