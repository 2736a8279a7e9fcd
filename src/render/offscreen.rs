//! Drawing a MuJoCo model into memory.
#![expect(unsafe_code, reason = "MuJoCo's visualiser is a C interface")]

use mujoco_rs::{
    mujoco_c::{mjr_readPixels, mjtLightType, mjtObj, mjtRndFlag, mjvLight},
    wrappers::{
        mj_data::MjData,
        mj_model::MjModel,
        mj_rendering::{MjrContext, MjrRectangle},
        mj_visualization::{MjvCamera, MjvGeom, MjvOption, MjvPerturb, MjvScene},
        traits::ModelType,
    },
};

use serde::{Deserialize, Serialize};

use super::{CameraView, DeviceChoice, RenderError, egl::EglContext};
use crate::{geometry::Size, image::Rgb8};

/// Longest side of a picture, pixels; every OpenGL 2 driver of today holds buffers this large.
pub(super) const MAX_SIDE: u32 = 8192;
/// Scene room beside the model's own geoms, for skins and decorations.
const EXTRA_GEOMS: usize = 64;
/// What MuJoCo's renderer shines on a scene without lights.
const AMBIENT_WITHOUT_LIGHTS: f32 = 0.3;
const GL_RGBA: i32 = 0x1908;

/// Which lights shine.
#[derive(Clone, Debug, PartialEq)]
pub enum Lighting {
    /// The lights and the head-light of the model.
    Model,
    /// Directional lights that move with the camera, in place of the model's.
    Studio(Vec<StudioLight>),
    /// None: every geom shows its own colour, unshaded (as emitted light).
    Flat,
}

/// A directional light fixed to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudioLight {
    /// Where the light shines to, camera axes.
    pub direction: [f64; 3],
    /// Strength of light from everywhere, 0 to 1.
    pub ambient: f32,
    /// Strength of light scattered by a matt surface, 0 to 1.
    pub diffuse: f32,
    /// Strength of highlights, 0 to 1.
    pub specular: f32,
}

/// What is drawn and read back.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Geom groups 0 to 5 that are drawn.
    pub groups: [bool; 6],
    /// Shadows of the lights that cast them.
    pub shadows: bool,
    /// Mirror images on reflective planes.
    pub reflections: bool,
    /// The model's skybox, where it has one; else the background is black and its coverage 0.
    pub skybox: bool,
    /// Lights.
    pub lighting: Lighting,
    /// Whether depth is read back.
    pub depth: bool,
    /// Whether geom numbers are drawn (a second pass) and read back.
    pub geom_ids: bool,
}

impl Default for RenderOptions {
    /// Groups 0, 1 and 2, the model's lights, no shadows, no reflections, no skybox; colour and depth.
    fn default() -> Self {
        Self {
            groups: [true, true, true, false, false, false],
            shadows: false,
            reflections: false,
            skybox: false,
            lighting: Lighting::Model,
            depth: true,
            geom_ids: false,
        }
    }
}

/// Called for each geom of the model about to be drawn, by its number; may recolour it (`[r, g, b, a]`) and
/// answers whether it is drawn.
pub type GeomFilter<'a> = &'a mut dyn FnMut(usize, &mut [f32; 4]) -> bool;

/// A picture as rendered. All rows go from top to bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedView {
    /// Width and height.
    pub size: Size,
    /// `[r, g, b, a]` a pixel: colour multiplied by coverage, and coverage (255 where geoms fill the pixel; always
    /// 255 with a skybox).
    pub rgba: Vec<u8>,
    /// Metres along the camera's z axis, `f32::INFINITY` where nothing was drawn; empty unless asked for.
    pub depth: Vec<f32>,
    /// Geom number at the pixel's centre, -1 where there is none; empty unless asked for.
    pub geom_ids: Vec<i32>,
}

impl RenderedView {
    /// The colours over a black background.
    pub fn rgb(&self) -> Rgb8 {
        let mut picture = Rgb8::new(self.size);
        for (out, pixel) in
            picture.data_mut().as_chunks_mut::<3>().0.iter_mut().zip(self.rgba.as_chunks::<4>().0)
        {
            out.copy_from_slice(&pixel[..3]);
        }
        picture
    }
}

/// A renderer without a window, for one model.
///
/// It belongs to the thread that made it (it is neither `Send` nor `Sync`): make one a thread. Making one takes
/// some 50 ms and uploads the model's meshes.
#[derive(Debug)]
pub struct Offscreen {
    // Dropped in this order: MuJoCo's buffers before the OpenGL context they live in.
    context: MjrContext,
    scene: MjvScene,
    egl: EglContext,
    size: Size,
}

impl Offscreen {
    /// A renderer for `model` whose pictures have at most `size`, smoothed with `samples` samples a pixel (0 or 1 for none;
    /// the driver may give fewer).
    ///
    /// # Errors
    /// When no EGL device works or the size is outside 1 to 8192 pixels a side.
    pub fn new(model: &MjModel, size: Size, samples: u32, device: DeviceChoice) -> Result<Self, RenderError> {
        if size.width == 0 || size.height == 0 || size.width > MAX_SIDE || size.height > MAX_SIDE {
            return Err(RenderError::Size(size));
        }
        let egl = EglContext::new(device)?;
        // SAFETY: an OpenGL context was just made current on this thread; `Drop` makes it current again.
        let mut context = unsafe { MjrContext::new(model) };
        // SAFETY: only plain settings are changed, which the resize below reads. Resizing to the old size does
        // nothing, so that it is done by way of another one.
        unsafe { context.ffi_mut().offSamples = if samples > 1 { samples as i32 } else { 0 } };
        if context.off_width() == size.width as i32 && context.off_height() == size.height as i32 {
            context.resize_offscreen(1, 1);
        }
        context.resize_offscreen(size.width, size.height);
        // SAFETY: as above; the format is one that glReadPixels takes.
        unsafe { context.ffi_mut().readPixelFormat = GL_RGBA };
        context.offscreen();
        let room = usize::try_from(model.ngeom()).unwrap_or(0) + EXTRA_GEOMS;
        Ok(Self { context, scene: MjvScene::new(model, room), egl, size })
    }

    /// Largest width and height of the pictures.
    pub fn size(&self) -> Size {
        self.size
    }

    /// OpenGL's name of the renderer in use.
    pub fn device_name(&self) -> String {
        self.egl.renderer_name()
    }

    /// Uploads mesh `mesh` anew from `model`, a copy of the renderer's model with other vertices.
    ///
    /// # Errors
    /// When `model` has another layout, has no such mesh, or the OpenGL context is lost.
    pub fn upload_mesh(&self, model: &MjModel, mesh: usize) -> Result<(), RenderError> {
        if !self.context.is_asset_compatible_with_model(model) {
            return Err(RenderError::OtherModel);
        }
        self.egl.make_current()?;
        self.context.upload_mesh(model, mesh).map_err(|_| RenderError::OtherModel)
    }

    /// Draws the model as it stands in `data` (kinematics and lights computed: `forward`, or `kinematics` and
    /// `camlight`).
    ///
    /// # Errors
    /// When the camera is not finite, its picture is larger than the renderer's, or `data` is of another model.
    pub fn render(
        &mut self,
        data: &mut MjData<impl ModelType>,
        view: &CameraView,
        options: &RenderOptions,
    ) -> Result<RenderedView, RenderError> {
        self.render_filtered(data, view, options, &mut |_, _| true)
    }

    /// As [`render`](Self::render), showing each geom `filter` to leave out or recolour.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn render_filtered(
        &mut self,
        data: &mut MjData<impl ModelType>,
        view: &CameraView,
        options: &RenderOptions,
        filter: GeomFilter<'_>,
    ) -> Result<RenderedView, RenderError> {
        self.prepare(data, view, options, filter)?;
        let mut picture = RenderedView {
            size: view.pinhole.size,
            rgba: Vec::new(),
            depth: Vec::new(),
            geom_ids: Vec::new(),
        };
        self.set_flags(options, false);
        self.draw(picture.size);
        self.read(picture.size, &mut picture.rgba, options.depth.then_some(&mut picture.depth));
        metres(&mut picture.depth, view);
        if options.geom_ids {
            self.set_flags(options, true);
            self.draw(picture.size);
            let mut colours = Vec::new();
            self.read(picture.size, &mut colours, None);
            picture.geom_ids = self.geom_ids(&colours);
        }
        Ok(picture)
    }

    /// Fills the scene: camera, geoms, lights.
    fn prepare(
        &mut self,
        data: &mut MjData<impl ModelType>,
        view: &CameraView,
        options: &RenderOptions,
        filter: GeomFilter<'_>,
    ) -> Result<(), RenderError> {
        let Size { width, height } = view.pinhole.size;
        if width == 0 || height == 0 || width > self.size.width || height > self.size.height {
            return Err(RenderError::Size(view.pinhole.size));
        }
        if !self.scene.is_compatible_with_model(data.model()) {
            return Err(RenderError::OtherModel);
        }
        let camera = view.to_gl()?;
        self.egl.make_current()?;
        // SAFETY: both cameras (left and right eye) are plain numbers, checked to be finite.
        unsafe { self.scene.ffi_mut().camera = [camera.clone(), camera] };
        let geomgroup = options.groups.map(u8::from);
        let visual = MjvOption { geomgroup, sitegroup: [0; 6], ..Default::default() };
        // A user camera leaves the scene's cameras as they were set above.
        self.scene.update(data, &visual, &MjvPerturb::default(), &mut MjvCamera::new_user());
        self.filter_geoms(filter, options.lighting == Lighting::Flat);
        self.set_lights(&options.lighting, view);
        Ok(())
    }

    /// Keeps the geoms `filter` wants, in their order.
    fn filter_geoms(&mut self, filter: GeomFilter<'_>, flat: bool) {
        let mut kept = 0;
        // SAFETY: geoms are only recoloured and moved within the part in use.
        let geoms = unsafe { self.scene.geoms_mut() };
        for index in 0..geoms.len() {
            let wanted = match geom_number(&geoms[index]) {
                Some(number) => filter(number, &mut geoms[index].rgba),
                None => true,
            };
            if wanted {
                if flat {
                    // MuJoCo adds this much ambient light of its own where a scene has no lights.
                    geoms[index].emission = 1.0 - AMBIENT_WITHOUT_LIGHTS;
                    geoms[index].specular = 0.0;
                }
                geoms.swap(kept, index);
                kept += 1;
            }
        }
        // SAFETY: `kept` is at most the number of geoms in use.
        unsafe { self.scene.ffi_mut().ngeom = kept as i32 };
    }

    fn set_lights(&mut self, lighting: &Lighting, view: &CameraView) {
        let lights = match lighting {
            Lighting::Model => return,
            Lighting::Flat => &[][..],
            Lighting::Studio(lights) => lights,
        };
        // SAFETY: the array has room for `mjMAXLIGHT` lights and no more are written.
        let scene = unsafe { self.scene.ffi_mut() };
        let count = lights.len().min(scene.lights.len());
        for (slot, light) in scene.lights.iter_mut().zip(lights) {
            *slot = light.to_scene(view);
        }
        scene.nlight = count as i32;
    }

    fn set_flags(&mut self, options: &RenderOptions, geom_ids: bool) {
        // SAFETY: flags are plain bytes, indexed by the enum made for them.
        let flags = unsafe { &mut self.scene.ffi_mut().flags };
        let on = |flag: bool| u8::from(flag && !geom_ids);
        flags[mjtRndFlag::mjRND_SHADOW as usize] = on(options.shadows);
        flags[mjtRndFlag::mjRND_REFLECTION as usize] = on(options.reflections);
        flags[mjtRndFlag::mjRND_SKYBOX as usize] = on(options.skybox);
        flags[mjtRndFlag::mjRND_FOG as usize] = 0;
        flags[mjtRndFlag::mjRND_HAZE as usize] = 0;
        flags[mjtRndFlag::mjRND_CULL_FACE as usize] = 1;
        flags[mjtRndFlag::mjRND_SEGMENT as usize] = u8::from(geom_ids);
        flags[mjtRndFlag::mjRND_IDCOLOR as usize] = u8::from(geom_ids);
    }

    fn draw(&mut self, size: Size) {
        self.scene.render(&viewport(size), &self.context);
    }

    /// Reads colours (four bytes a pixel) and depth as OpenGL holds it, top row first.
    fn read(&self, size: Size, rgba: &mut Vec<u8>, mut depth: Option<&mut Vec<f32>>) {
        rgba.resize(size.area() * 4, 0);
        if let Some(depth) = depth.as_deref_mut() {
            depth.resize(size.area(), 0.0);
        }
        let depth_pointer = depth.as_deref_mut().map_or(std::ptr::null_mut(), Vec::as_mut_ptr);
        // SAFETY: the buffers hold four bytes and one float a pixel of the viewport, as the pixel format set in
        // `new` has four channels; the context is current.
        unsafe { mjr_readPixels(rgba.as_mut_ptr(), depth_pointer, viewport(size), self.context.ffi()) };
        flip(rgba, size.width as usize * 4);
        if let Some(depth) = depth {
            flip(depth, size.width as usize);
        }
    }

    /// Scene numbers, drawn as colours, to the model's geom numbers.
    fn geom_ids(&self, colours: &[u8]) -> Vec<i32> {
        let geoms = self.scene.geoms();
        let mut of_segment = std::collections::BTreeMap::new();
        for geom in geoms {
            let number = geom_number(geom).map_or(-1, |number| number as i32);
            of_segment.insert(geom.segid + 1, number);
        }
        let decode = |p: &[u8; 4]| i32::from(p[0]) + (i32::from(p[1]) << 8) + (i32::from(p[2]) << 16);
        let mut last = (0, -1);
        let (pixels, _) = colours.as_chunks::<4>();
        pixels
            .iter()
            .map(|pixel| {
                let segment = decode(pixel);
                if segment != last.0 {
                    last = (segment, of_segment.get(&segment).copied().unwrap_or(-1));
                }
                last.1
            })
            .collect()
    }
}

impl StudioLight {
    fn to_scene(self, view: &CameraView) -> mjvLight {
        let [x, y, z] = self.direction;
        let direction = view.pose.rotation * nalgebra::Vector3::new(x, y, z).normalize();
        mjvLight {
            id: -1,
            pos: view.pose.translation.vector.cast::<f32>().into(),
            dir: direction.cast::<f32>().into(),
            type_: mjtLightType::mjLIGHT_DIRECTIONAL as i32,
            texid: -1,
            attenuation: [1.0, 0.0, 0.0],
            cutoff: 90.0,
            exponent: 0.0,
            ambient: [self.ambient; 3],
            diffuse: [self.diffuse; 3],
            specular: [self.specular; 3],
            headlight: 0,
            castshadow: 0,
            bulbradius: 0.0,
            intensity: 0.0,
            range: 10.0,
            softness: 0.0,
        }
    }
}

impl Drop for Offscreen {
    fn drop(&mut self) {
        // MuJoCo frees its buffers in whatever context is current, so it must be theirs.
        let _ = self.egl.make_current();
    }
}

fn viewport(size: Size) -> MjrRectangle {
    MjrRectangle::new(0, 0, size.width as i32, size.height as i32)
}

fn geom_number(geom: &MjvGeom) -> Option<usize> {
    (geom.objtype == mjtObj::mjOBJ_GEOM as i32).then(|| usize::try_from(geom.objid).ok()).flatten()
}

/// Turns rows of `stride` values upside down: OpenGL's first row is the lowest.
fn flip<T>(values: &mut [T], stride: usize) {
    let rows = values.len() / stride.max(1);
    for row in 0..rows / 2 {
        let (top, bottom) = values.split_at_mut((rows - 1 - row) * stride);
        top[row * stride..(row + 1) * stride].swap_with_slice(&mut bottom[..stride]);
    }
}

/// Depth buffer values (0 near, 1 far, hyperbolic between) to metres.
fn metres(depth: &mut [f32], view: &CameraView) {
    let (near, far) = (view.near as f32, view.far as f32);
    for value in depth {
        *value = if *value >= 1.0 { f32::INFINITY } else { near / (1.0 - *value * (1.0 - near / far)) };
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

    use super::*;
    use crate::geometry::{Camera, Pinhole, Position};

    const SIZE: Size = Size::new(320, 200);

    fn odd_pinhole() -> Pinhole {
        Pinhole::new(310.0, 275.0, 131.3, 117.8, SIZE).unwrap()
    }

    fn tilted_pose() -> Isometry3<f64> {
        Isometry3::from_parts(
            Translation3::new(0.3, -0.2, 1.1),
            UnitQuaternion::from_euler_angles(2.1, 0.2, -0.6),
        )
    }

    fn spheres(points: &[Vector3<f64>], radius: f64) -> MjModel {
        let geoms: String = points
            .iter()
            .map(|p| format!("<geom type='sphere' size='{radius}' pos='{} {} {}'/>", p.x, p.y, p.z))
            .collect();
        crate::mujoco::compile_alone(|| {
            MjModel::from_xml_string(&format!("<mujoco><worldbody>{geoms}</worldbody></mujoco>"))
        })
        .unwrap()
    }

    fn renderer(model: &MjModel, samples: u32) -> Option<Offscreen> {
        match Offscreen::new(model, SIZE, samples, DeviceChoice::Auto) {
            Ok(renderer) => Some(renderer),
            Err(RenderError::NoContext { tried }) => {
                println!("skipped: no EGL device ({tried})");
                None
            }
            Err(error) => panic!("{error}"),
        }
    }

    #[test]
    fn points_land_where_the_pinhole_projects_them_with_their_depth() {
        let pinhole = odd_pinhole();
        let in_camera: Vec<Vector3<f64>> = (0..12)
            .map(|k| {
                let pixel = crate::geometry::Pixel::new(
                    30.0 + 85.0 * f64::from(k % 4),
                    25.0 + 70.0 * f64::from(k / 4),
                );
                pinhole.unproject(pixel, 0.4 + 0.05 * f64::from(k)).xyz
            })
            .collect();
        let world: Vec<_> = in_camera.iter().map(|p| (tilted_pose() * Point3::from(*p)).coords).collect();
        let model = spheres(&world, 0.004);
        let Some(mut renderer) = renderer(&model, 8) else { return };
        let mut data = MjData::new(&model);
        data.forward();
        let options = RenderOptions { lighting: Lighting::Flat, geom_ids: true, ..RenderOptions::default() };
        for (number, point) in in_camera.iter().enumerate() {
            let view = CameraView::new(pinhole, tilted_pose());
            let picture =
                renderer.render_filtered(&mut data, &view, &options, &mut |geom, _| geom == number).unwrap();
            let expected = pinhole.project(&Position::<Camera>::new(*point)).unwrap();
            let (mut sum, mut x, mut y) = (0.0, 0.0, 0.0);
            for (index, pixel) in picture.rgba.as_chunks::<4>().0.iter().enumerate() {
                let weight = f64::from(pixel[3]);
                sum += weight;
                x += weight * (index % SIZE.width as usize) as f64;
                y += weight * (index / SIZE.width as usize) as f64;
            }
            let error = (x / sum - expected.x).hypot(y / sum - expected.y);
            assert!(error < 0.1, "geom {number}: {error} px off {expected:?}");
            let at = expected.y.round() as usize * SIZE.width as usize + expected.x.round() as usize;
            assert!((f64::from(picture.depth[at]) - (point.z - 0.004)).abs() < 1e-3, "{}", picture.depth[at]);
            assert_eq!(picture.geom_ids[at], number as i32);
            assert_eq!(picture.geom_ids[0], -1);
            assert!(picture.depth[0].is_infinite());
        }
    }

    #[test]
    fn colour_is_premultiplied_by_coverage() {
        let model = spheres(&[Vector3::new(0.0, 0.0, 1.0)], 0.2);
        let Some(mut renderer) = renderer(&model, 4) else { return };
        let mut data = MjData::new(&model);
        data.forward();
        let pinhole = Pinhole::new(300.0, 300.0, 159.5, 99.5, SIZE).unwrap();
        let options = RenderOptions { lighting: Lighting::Flat, ..RenderOptions::default() };
        let picture = renderer
            .render_filtered(
                &mut data,
                &CameraView::new(pinhole, Isometry3::identity()),
                &options,
                &mut |_, rgba| {
                    *rgba = [1.0, 0.5, 0.0, 1.0];
                    true
                },
            )
            .unwrap();
        let mut partial = 0;
        for [r, g, b, a] in picture.rgba.as_chunks::<4>().0 {
            assert!((i32::from(*r) - i32::from(*a)).abs() <= 1, "red {r} of coverage {a}");
            assert!((2 * i32::from(*g) - i32::from(*a)).abs() <= 3, "green {g} of coverage {a}");
            assert_eq!(*b, 0);
            partial += usize::from(*a > 0 && *a < 255);
        }
        assert!(partial > 50, "{partial} smoothed edge pixels");
    }

    #[test]
    fn pictures_may_be_larger_than_the_models_own_buffer() {
        let model = spheres(&[Vector3::new(0.0, 0.0, 1.0)], 0.2);
        let size = Size::new(2048, 1537);
        let Ok(mut renderer) = Offscreen::new(&model, size, 0, DeviceChoice::Auto) else { return };
        let mut data = MjData::new(&model);
        data.forward();
        let pinhole = Pinhole::from_horizontal_fov(60.0, size).unwrap();
        let view = CameraView::new(pinhole, Isometry3::identity());
        let picture = renderer.render(&mut data, &view, &RenderOptions::default()).unwrap();
        assert_eq!(picture.rgb().pixel(0, 0), [0; 3]);
        assert_eq!(picture.rgba[(768 * 2048 + 1024) * 4 + 3], 255);
    }

    #[test]
    fn a_picture_of_no_size_is_refused() {
        let model = spheres(&[], 0.2);
        let refused = Offscreen::new(&model, Size::new(0, 10), 0, DeviceChoice::Auto);
        assert!(matches!(refused, Err(RenderError::Size(_))));
    }
}
