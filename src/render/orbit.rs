//! The robot seen from outside.

use std::sync::Arc;

use mujoco_rs::wrappers::{mj_data::MjData, mj_model::MjModel};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::{CameraView, DeviceChoice, Lighting, Offscreen, RenderError, RenderOptions, StudioLight};
use crate::{
    engine::OrbitCamera,
    geometry::Size,
    image::Rgb8,
    robot::{JointAngles, RobotModel},
};

/// What lies behind the robot: a calm dark grey that suits both themes.
const GROUND: [u8; 3] = [38, 42, 48];

/// Draws the whole robot from an orbiting camera. It belongs to the thread that made it.
#[derive(Debug)]
pub struct OrbitRenderer {
    offscreen: Offscreen,
    robot: RobotModel,
    data: MjData<Arc<MjModel>>,
    torso: usize,
}

impl OrbitRenderer {
    /// A renderer whose pictures have at most `size`.
    ///
    /// # Errors
    /// When there is no EGL device, the size is too large, or the model has no `torso_link`.
    pub fn new(robot: &RobotModel, size: Size) -> Result<Self, RenderError> {
        let model = Arc::clone(robot.mujoco());
        let torso = (0..model.body_parentid().len())
            .find(|body| model.id_to_name(super::parts::BODY, *body) == Some("torso_link"))
            .ok_or(RenderError::NoTorso)?;
        let offscreen = Offscreen::new(&model, size, 4, DeviceChoice::Auto)?;
        let data = MjData::try_new(model).map_err(|error| RenderError::MuJoCo(error.to_string()))?;
        Ok(Self { offscreen, robot: robot.clone(), data, torso })
    }

    /// Largest width and height of the pictures.
    pub fn size(&self) -> Size {
        self.offscreen.size()
    }

    /// The robot at `angles` through `camera`, a picture of `size`.
    ///
    /// # Errors
    /// When angles or camera are not finite, or `size` is larger than the renderer's.
    pub fn render(
        &mut self,
        angles: &JointAngles,
        camera: &OrbitCamera,
        size: Size,
    ) -> Result<Rgb8, RenderError> {
        if !angles.0.iter().all(|angle| angle.is_finite()) {
            return Err(RenderError::NotFinite);
        }
        self.robot.write_qpos(angles, self.data.qpos_mut());
        self.data.kinematics();
        let [w, x, y, z] = self.data.xquat()[self.torso];
        let torso = Isometry3::from_parts(
            Translation3::from(Vector3::from(self.data.xpos()[self.torso])),
            UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
        );
        let view = CameraView::new(camera.pinhole(size), torso * camera.pose());
        let light = StudioLight { direction: [0.35, 0.75, 0.55], ambient: 0.3, diffuse: 0.6, specular: 0.2 };
        let options = RenderOptions { lighting: Lighting::Studio(vec![light]), ..RenderOptions::default() };
        let drawn = self.offscreen.render(&mut self.data, &view, &options)?;
        let mut picture = Rgb8::new(size);
        for (out, pixel) in
            picture.data_mut().as_chunks_mut::<3>().0.iter_mut().zip(drawn.rgba.as_chunks::<4>().0)
        {
            let open = 255 - u32::from(pixel[3]);
            for (channel, out) in out.iter_mut().enumerate() {
                let below = (u32::from(GROUND[channel]) * open + 127) / 255;
                *out = (u32::from(pixel[channel]) + below).min(255) as u8;
            }
        }
        Ok(picture)
    }
}
