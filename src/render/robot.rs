//! The robot seen by its own camera.

use std::sync::Arc;

use mujoco_rs::wrappers::{mj_data::MjData, mj_model::MjModel};
use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::{
    CameraView, DeviceChoice, LayerRequest, Lighting, NearParts, Offscreen, RenderError, RenderOptions,
    RenderedView, RobotLayers, StudioLight,
    parts::{Part, parts_of_geoms},
};
use crate::{
    geometry::{PerSide, Pinhole, Side, Size},
    retarget::CameraMap,
    robot::{JointAngles, RobotModel},
};

/// How the robot is drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RobotRenderParams {
    /// Samples a pixel, for smooth edges: 0, 2, 4, 8.
    pub samples: u32,
    /// Which EGL device renders.
    pub device: DeviceChoice,
    /// Lights, fixed to the camera.
    pub lights: Vec<StudioLight>,
    /// Nothing nearer than this is drawn, metres; the robot's camera sits inside its head, close to the collar.
    pub near: f64,
}

impl Default for RobotRenderParams {
    /// Four samples; a soft key light from above and left, a weaker one from the camera.
    fn default() -> Self {
        Self {
            samples: 4,
            device: DeviceChoice::Auto,
            lights: vec![
                StudioLight { direction: [0.35, 0.75, 0.55], ambient: 0.22, diffuse: 0.52, specular: 0.35 },
                StudioLight { direction: [-0.2, 0.0, 1.0], ambient: 0.1, diffuse: 0.3, specular: 0.1 },
            ],
            near: 0.03,
        }
    }
}

/// Draws the robot through the source camera's lens from the robot's virtual camera.
///
/// It belongs to the thread that made it, as [`Offscreen`] does: make one a thread. Every frame is drawn from its own
/// joint angles alone, so frames may be given out to threads in any order.
#[derive(Debug)]
pub struct RobotRenderer {
    offscreen: Offscreen,
    robot: RobotModel,
    data: MjData<Arc<MjModel>>,
    parts: Vec<Part>,
    torso: usize,
    pinhole: Pinhole,
    params: RobotRenderParams,
}

impl RobotRenderer {
    /// A renderer of `robot` for pictures through `pinhole` (the source's intrinsics, at the wanted size).
    ///
    /// # Errors
    /// When there is no EGL device, the size is too large, or the model has no `torso_link`.
    pub fn new(robot: &RobotModel, pinhole: Pinhole, params: RobotRenderParams) -> Result<Self, RenderError> {
        let model = Arc::clone(robot.mujoco());
        let torso = (0..model.body_parentid().len())
            .find(|body| model.id_to_name(super::parts::BODY, *body) == Some("torso_link"))
            .ok_or(RenderError::NoTorso)?;
        let offscreen = Offscreen::new(&model, pinhole.size, params.samples, params.device)?;
        let parts = parts_of_geoms(&model);
        let data = MjData::try_new(model).map_err(|error| RenderError::MuJoCo(error.to_string()))?;
        Ok(Self { offscreen, robot: robot.clone(), data, parts, torso, pinhole, params })
    }

    /// OpenGL's name of the renderer in use.
    pub fn device_name(&self) -> String {
        self.offscreen.device_name()
    }

    /// The layers of one frame: the robot at `angles`, seen from `map`'s virtual camera (origin `T_offset`, axes
    /// `R_cam` in the torso frame). β does not matter to the picture: it scales the robot's work space, not its lens.
    ///
    /// # Errors
    /// When angles or map are not finite, or the OpenGL context is used on another thread.
    pub fn render(
        &mut self,
        angles: &JointAngles,
        map: &CameraMap,
        request: &LayerRequest,
    ) -> Result<RobotLayers, RenderError> {
        let mut layers = RobotLayers::empty(self.pinhole.size);
        if !(request.shown.left || request.shown.right) {
            return Ok(layers);
        }
        if !angles.0.iter().all(|angle| angle.is_finite()) {
            return Err(RenderError::NotFinite);
        }
        self.robot.write_qpos(angles, self.data.qpos_mut());
        self.data.kinematics();
        let pose = self.torso_pose() * camera_in_torso(map)?;
        let roles = self.roles(&pose, request);
        let Some(window) = self.window(&pose, &roles) else { return Ok(layers) };
        let view =
            CameraView { pinhole: window.pinhole(&self.pinhole), pose, near: self.params.near, far: 5.0 };
        let colours = self.draw(&view, &roles, Lighting::Studio(self.params.lights.clone()), true)?;
        let shares = self.draw(&view, &roles, Lighting::Flat, false)?;
        window.paste(&colours, &shares, &mut layers);
        Ok(layers)
    }

    fn torso_pose(&self) -> Isometry3<f64> {
        let [w, x, y, z] = self.data.xquat()[self.torso];
        Isometry3::from_parts(
            Translation3::from(Vector3::from(self.data.xpos()[self.torso])),
            UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
        )
    }

    /// What each geom is to this frame's layers; `None` when it is not drawn.
    fn roles(&self, pose: &Isometry3<f64>, request: &LayerRequest) -> Vec<Option<Role>> {
        let near = |part: Part, depth: f64, rule: NearParts| match part {
            Part::Thumb(_) => rule.thumb,
            Part::Finger(_) => rule.fingers_within.is_some_and(|limit| depth < limit),
            Part::Arm(_) | Part::Body => false,
        };
        self.parts
            .iter()
            .zip(self.data.geom_xpos())
            .map(|(part, centre)| {
                let side = part.side().filter(|side| request.shown[*side])?;
                let depth = pose.inverse_transform_point(&Vector3::from(*centre).into()).z;
                Some(Role { side, near: near(*part, depth, request.near[side]) })
            })
            .collect()
    }

    /// The part of the picture that the drawn geoms can touch; `None` when they are all out of view.
    fn window(&self, pose: &Isometry3<f64>, roles: &[Option<Role>]) -> Option<Window> {
        let mut window: Option<[f64; 4]> = None;
        let model = self.robot.mujoco();
        let spheres = self.data.geom_xpos().iter().zip(model.geom_rbound());
        for ((centre, radius), _) in spheres.zip(roles).filter(|(_, role)| role.is_some()) {
            let centre = pose.inverse_transform_point(&Vector3::from(*centre).into());
            let Some(bounds) = sphere_bounds(&self.pinhole, centre.coords, *radius, self.params.near) else {
                continue;
            };
            let old = window.unwrap_or(bounds);
            window = Some([
                old[0].min(bounds[0]),
                old[1].min(bounds[1]),
                old[2].max(bounds[2]),
                old[3].max(bounds[3]),
            ]);
        }
        Window::clipped(window?, self.pinhole.size)
    }

    fn draw(
        &mut self,
        view: &CameraView,
        roles: &[Option<Role>],
        lighting: Lighting,
        depth: bool,
    ) -> Result<RenderedView, RenderError> {
        let flat = lighting == Lighting::Flat;
        let options = RenderOptions { lighting, depth, ..RenderOptions::default() };
        self.offscreen.render_filtered(&mut self.data, view, &options, &mut |geom, rgba| {
            let Some(role) = roles.get(geom).copied().flatten() else { return false };
            if flat {
                *rgba = role.colour();
            }
            true
        })
    }
}

/// What a drawn geom is to the layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Role {
    side: Side,
    near: bool,
}

impl Role {
    /// Red: near parts of the left hand; green: near parts of the right hand; blue: everything left.
    fn colour(self) -> [f32; 4] {
        let on = |flag: bool| f32::from(u8::from(flag));
        let left = self.side == Side::Left;
        [on(self.near && left), on(self.near && !left), on(left), 1.0]
    }
}

/// A rectangle of whole pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Window {
    x: u32,
    y: u32,
    size: Size,
}

impl Window {
    /// The whole pixels that `[x0, y0, x1, y1]` touches, with one pixel of room, inside a picture of `size`.
    fn clipped(bounds: [f64; 4], size: Size) -> Option<Self> {
        let low = |value: f64, end: u32| (value.floor() - 1.0).clamp(0.0, f64::from(end)) as u32;
        let high = |value: f64, end: u32| (value.ceil() + 2.0).clamp(0.0, f64::from(end)) as u32;
        let (x0, x1) = (low(bounds[0], size.width), high(bounds[2], size.width));
        let (y0, y1) = (low(bounds[1], size.height), high(bounds[3], size.height));
        (x1 > x0 && y1 > y0).then(|| Self { x: x0, y: y0, size: Size::new(x1 - x0, y1 - y0) })
    }

    /// The lens for this part of the picture alone.
    fn pinhole(&self, whole: &Pinhole) -> Pinhole {
        let (cx, cy) = (whole.cx - f64::from(self.x), whole.cy - f64::from(self.y));
        Pinhole { cx, cy, size: self.size, ..*whole }
    }

    /// Writes a drawn window into the layers.
    fn paste(&self, colours: &RenderedView, shares: &RenderedView, layers: &mut RobotLayers) {
        let width = self.size.width as usize;
        let stride = layers.full.size().width as usize;
        let (colours_of, shares_of) = (colours.rgba.as_chunks::<4>().0, shares.rgba.as_chunks::<4>().0);
        for row in 0..self.size.height as usize {
            let start = (self.y as usize + row) * stride + self.x as usize;
            let from = row * width..(row + 1) * width;
            layers.depth[start..start + width].copy_from_slice(&colours.depth[from.clone()]);
            let full = &mut layers.full.data_mut().as_chunks_mut::<4>().0[start..start + width];
            for (out, pixel) in full.iter_mut().zip(&colours_of[from.clone()]) {
                *out = straight(*pixel);
            }
            for (column, [near_left, near_right, left, all]) in shares_of[from].iter().enumerate() {
                let at = start + column;
                let PerSide { left: near_l, right: near_r } = &mut layers.near;
                (near_l.data[at], near_r.data[at]) = (*near_left, *near_right);
                let PerSide { left: side_l, right: side_r } = &mut layers.sides;
                (side_l.data[at], side_r.data[at]) = (*left, all.saturating_sub(*left));
            }
        }
    }
}

/// Premultiplied to straight alpha.
fn straight([r, g, b, a]: [u8; 4]) -> [u8; 4] {
    match a {
        0 => [0; 4],
        255 => [r, g, b, a],
        _ => {
            let alpha = u16::from(a);
            let divide = |value: u8| ((u16::from(value) * 255 + alpha / 2) / alpha).min(255) as u8;
            [divide(r), divide(g), divide(b), a]
        }
    }
}

/// The virtual camera in the torso frame.
fn camera_in_torso(map: &CameraMap) -> Result<Isometry3<f64>, RenderError> {
    let finite = map.rotation.iter().chain(map.offset.iter()).all(|value| value.is_finite());
    if !finite || (map.rotation * map.rotation.transpose() - Matrix3::identity()).norm() > 1e-3 {
        return Err(RenderError::NotFinite);
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(map.rotation));
    Ok(Isometry3::from_parts(map.offset.into(), rotation))
}

/// Pixel bounds `[x0, y0, x1, y1]` of a sphere; unbounded where it reaches behind the near plane, `None` where
/// all of it lies behind.
fn sphere_bounds(pinhole: &Pinhole, centre: Vector3<f64>, radius: f64, near: f64) -> Option<[f64; 4]> {
    if centre.z + radius <= near {
        return None;
    }
    if centre.z - radius < near {
        return Some([f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY]);
    }
    // The nearest point's depth bounds the spread on the picture from above.
    let depth = centre.z - radius;
    let interval = |offset: f64, focal: f64, principal: f64| {
        let low = (offset - radius) / if offset < radius { depth } else { centre.z + radius };
        let high = (offset + radius) / if offset > -radius { depth } else { centre.z + radius };
        (focal * low + principal, focal * high + principal)
    };
    let (x0, x1) = interval(centre.x, pinhole.fx, pinhole.cx);
    let (y0, y1) = interval(centre.y, pinhole.fy, pinhole.cy);
    Some([x0, y0, x1, y1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Camera, Position};

    const SIZE: Size = Size::new(320, 240);

    fn head_camera() -> CameraMap {
        let axes = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
        let pitch = Rotation3::from_axis_angle(&Vector3::y_axis(), 0.83);
        CameraMap { beta: 1.0, rotation: pitch.matrix() * axes, offset: Vector3::new(0.0576, 0.0, 0.43) }
    }

    fn renderer() -> Option<(RobotModel, Pinhole, RobotRenderer)> {
        let robot = RobotModel::embedded().unwrap();
        let pinhole = Pinhole::new(230.0, 225.0, 155.0, 122.0, SIZE).unwrap();
        match RobotRenderer::new(&robot, pinhole, RobotRenderParams::default()) {
            Ok(renderer) => Some((robot, pinhole, renderer)),
            Err(RenderError::NoContext { tried }) => {
                println!("skipped: no EGL device ({tried})");
                None
            }
            Err(error) => panic!("{error}"),
        }
    }

    fn raised() -> JointAngles {
        let mut angles = JointAngles::default();
        for (joint, angle) in [-0.5, 0.25, 0.1, 0.2, 0.3, -0.2, 0.1].into_iter().enumerate() {
            angles.0[joint] = angle;
            angles.0[7 + joint] = if matches!(joint, 1 | 2 | 4 | 6) { -angle } else { angle };
        }
        angles
    }

    #[test]
    fn fingertips_are_drawn_where_the_virtual_camera_projects_them() {
        let Some((robot, pinhole, mut renderer)) = renderer() else { return };
        let (angles, map) = (raised(), head_camera());
        let layers = renderer.render(&angles, &map, &LayerRequest::default()).unwrap();
        for side in Side::BOTH {
            for tip in robot.fingertips(side, &angles) {
                let seen = Position::<Camera>::new(map.rotation.transpose() * (tip.xyz - map.offset));
                let pixel = pinhole.project(&seen).unwrap();
                // A tip lies on the surface, so its pixel may be half outside.
                let around = (0..9).map(|k| {
                    let (x, y) = (pixel.x.round() as usize + k % 3 - 1, pixel.y.round() as usize + k / 3 - 1);
                    y * SIZE.width as usize + x
                });
                let seen_here = around.clone().any(|at| {
                    layers.sides[side].data[at] > 100 && f64::from(layers.depth[at]) < seen.xyz.z + 0.01
                });
                assert!(seen_here, "{side:?} tip at {pixel:?}");
                assert!(around.into_iter().all(|at| layers.sides[side.other()].data[at] == 0));
            }
        }
    }

    #[test]
    fn near_parts_lie_inside_their_side_and_edges_have_no_dark_fringe() {
        let Some((_, _, mut renderer)) = renderer() else { return };
        let layers = renderer.render(&raised(), &head_camera(), &LayerRequest::default()).unwrap();
        for (side, near) in layers.near.iter() {
            assert!(!near.is_empty(), "{side:?} thumb");
            for (near, all) in near.data.iter().zip(&layers.sides[side].data) {
                assert!(*near <= all.saturating_add(1));
            }
        }
        let near = layers.near_layer(Side::Left);
        assert!(near.pixels().zip(&layers.near.left.data).all(|(pixel, coverage)| pixel[3] == *coverage));
        let (mut edge, mut darker) = (0, 0);
        for y in 1..SIZE.height - 1 {
            for x in 1..SIZE.width - 1 {
                let pixel = layers.full.pixel(x, y);
                if !(30..220).contains(&pixel[3]) {
                    continue;
                }
                // Shading falls off towards an outline by itself, so a few may well be darker.
                let around = (0..9).map(|k| layers.full.pixel(x + k % 3 - 1, y + k / 3 - 1));
                if let Some(darkest) = around.filter(|p| p[3] == 255).map(|p| p[1]).min() {
                    edge += 1;
                    darker += u32::from(pixel[1].saturating_add(25) < darkest);
                }
            }
        }
        assert!(
            edge > 200 && darker * 5 < edge,
            "{darker} of {edge} edge pixels are darker than their neighbours"
        );
    }

    #[test]
    fn a_side_that_is_not_shown_leaves_no_trace() {
        let Some((_, _, mut renderer)) = renderer() else { return };
        let mut request = LayerRequest::default();
        request.shown.right = false;
        let layers = renderer.render(&raised(), &head_camera(), &request).unwrap();
        assert!(
            layers.sides.right.is_empty() && layers.near.right.is_empty() && !layers.sides.left.is_empty()
        );
        request.shown.left = false;
        let layers = renderer.render(&raised(), &head_camera(), &request).unwrap();
        assert_eq!(layers, RobotLayers::empty(SIZE));
    }

    #[test]
    fn a_frame_does_not_depend_on_the_frames_before_it() {
        let Some((_, _, mut renderer)) = renderer() else { return };
        let first = renderer.render(&raised(), &head_camera(), &LayerRequest::default()).unwrap();
        renderer.render(&JointAngles::default(), &head_camera(), &LayerRequest::default()).unwrap();
        let again = renderer.render(&raised(), &head_camera(), &LayerRequest::default()).unwrap();
        assert!(first == again);
    }

    #[test]
    fn angles_that_are_no_numbers_are_refused() {
        let Some((_, _, mut renderer)) = renderer() else { return };
        let mut angles = raised();
        angles.0[3] = f64::NAN;
        let result = renderer.render(&angles, &head_camera(), &LayerRequest::default());
        assert!(matches!(result, Err(RenderError::NotFinite)));
    }
}
