//! The MuJoCo scene of an episode. Every mesh and texture is filled in from memory.

use std::fmt::Write as _;

use mujoco_rs::wrappers::{mj_auxiliary::MjVfs, mj_data::MjData, mj_model::MjModel};
use nalgebra::{Isometry3, Vector3};
use rand::Rng as _;
use rand_pcg::Pcg64Mcg;

use super::{
    object::{ObjectKind, ObjectShape},
    skin::TriangleSoup,
    spec::SynthError,
    texture::{self, Finish, Surface, Texels},
};
use crate::{
    geometry::{PerSide, Side, Size},
    mujoco::compile_alone,
    render::{CameraView, DeviceChoice, Lighting, Offscreen, RenderOptions, RenderedView},
};

/// Room for the skin of one hand, triangles.
const SKIN_TRIANGLES: usize = 40_000;
/// Room for one sleeve, triangles.
const SLEEVE_TRIANGLES: usize = 16_000;
/// Side of a texture, texels.
const TEXTURE: usize = 512;
const TABLE_TEXTURE: usize = 1024;

/// Which parts of the scene are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Everything.
    All,
    /// Table, walls, clutter.
    Background,
    /// The manipulated object alone.
    Object,
}

/// What a geom belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Table, walls, clutter.
    Background,
    /// The manipulated object.
    Object,
    /// A hand with its arm.
    Hand(Side),
}

struct Mesh {
    name: String,
    soup: TriangleSoup,
    capacity: usize,
    texels: Texels,
    texture_size: usize,
    part: Part,
    shine: f64,
    /// Where a fixed mesh stands.
    pose: Isometry3<f64>,
}

/// How the scene's object looks.
#[derive(Clone, Copy, Debug)]
pub struct ObjectLook<'a> {
    /// Its shape.
    pub shape: &'a ObjectShape,
    /// Its paint.
    pub finish: Finish,
}

/// A scene ready to draw. It belongs to the thread that made it.
pub struct Scene {
    // Mutable copy whose meshes are rewritten and uploaded.
    model: MjModel,
    data: MjData<Box<MjModel>>,
    renderer: Offscreen,
    parts: Vec<Part>,
    hands: PerSide<[usize; 2]>,
}

impl std::fmt::Debug for Scene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scene").field("parts", &self.parts).finish_non_exhaustive()
    }
}

impl Scene {
    /// A random room around a table, the object, and room for two hands.
    ///
    /// # Errors
    /// When MuJoCo or the renderer refuses.
    pub fn random(
        size: Size,
        object: ObjectLook<'_>,
        keep_clear: &[[f64; 2]],
        focus: f64,
        rng: &mut Pcg64Mcg,
    ) -> Result<Self, SynthError> {
        let mut meshes = room(focus, rng);
        meshes.extend(clutter(keep_clear, focus, rng));
        let first_hand = meshes.len();
        meshes.extend(hand_meshes(rng));
        // Last, as MuJoCo numbers the geoms of the world's body before those of other bodies.
        meshes.push(Mesh {
            name: "object".into(),
            capacity: 0,
            soup: object.shape.triangles(),
            texels: texture::object(object.finish, TEXTURE, rng),
            texture_size: TEXTURE,
            part: Part::Object,
            shine: rng.random_range(0.05..0.4),
            pose: Isometry3::identity(),
        });
        let light = light(rng);
        let model = build(&meshes, &light)?;
        let renderer = Offscreen::new(&model, size, 4, DeviceChoice::Auto)?;
        let data = MjData::new(Box::new(model.clone()));
        let parts = meshes.iter().map(|mesh| mesh.part).collect();
        let hands = PerSide::from_fn(|side| [0, 1].map(|index| first_hand + 2 * side.index() + index));
        Ok(Self { model, data, renderer, parts, hands })
    }

    /// What the geom numbered `geom` by the renderer belongs to.
    pub fn part(&self, geom: i32) -> Part {
        usize::try_from(geom).ok().and_then(|geom| self.parts.get(geom).copied()).unwrap_or(Part::Background)
    }

    /// Places the object.
    pub fn place_object(&mut self, pose: &Isometry3<f64>) {
        let q = pose.rotation;
        self.data.mocap_pos_mut()[0] = pose.translation.vector.into();
        self.data.mocap_quat_mut()[0] = [q.w, q.i, q.j, q.k];
        self.data.kinematics();
        self.data.camlight();
    }

    /// Replaces the skin and sleeve of a hand by triangles in world coordinates.
    ///
    /// # Errors
    /// When the renderer's context is lost.
    pub fn set_hand(
        &mut self,
        side: Side,
        skin: &TriangleSoup,
        sleeve: &TriangleSoup,
    ) -> Result<(), SynthError> {
        for (mesh, soup) in self.hands[side].into_iter().zip([skin, sleeve]) {
            fill(&mut self.model, mesh, soup);
            self.renderer.upload_mesh(&self.model, mesh)?;
        }
        Ok(())
    }

    /// Draws a pass; geom numbers are read back for all but the background.
    ///
    /// # Errors
    /// When the renderer fails.
    pub fn draw(&mut self, view: &CameraView, pass: Pass) -> Result<RenderedView, SynthError> {
        let groups = match pass {
            Pass::All => [true, true, true, false, false, false],
            Pass::Background => [true, false, false, false, false, false],
            Pass::Object => [false, true, false, false, false, false],
        };
        let options = RenderOptions {
            groups,
            shadows: true,
            reflections: false,
            skybox: false,
            lighting: Lighting::Model,
            depth: false,
            geom_ids: pass != Pass::Background,
        };
        Ok(self.renderer.render(&mut self.data, view, &options)?)
    }
}

fn quad(corners: [[f64; 3]; 4], uv: [[f64; 2]; 4]) -> TriangleSoup {
    let p = corners.map(Vector3::from);
    let normal = (p[1] - p[0]).cross(&(p[2] - p[0])).normalize();
    let mut soup = TriangleSoup::default();
    for index in [0, 1, 2, 0, 2, 3] {
        soup.positions.push(p[index].cast::<f32>().into());
        soup.normals.push(normal.cast::<f32>().into());
        soup.uv.push(uv[index].map(|t| t as f32));
    }
    soup
}

/// A rectangle cut into a grid, so that lamps light it smoothly (OpenGL lights vertices).
fn sheet(origin: [f64; 3], along: [f64; 3], across: [f64; 3], texture_scale: f64) -> TriangleSoup {
    const CELLS: usize = 24;
    let (o, a, b) = (Vector3::from(origin), Vector3::from(along), Vector3::from(across));
    let mut soup = TriangleSoup::default();
    for i in 0..CELLS {
        for j in 0..CELLS {
            let at = |di: usize, dj: usize| ((i + di) as f64 / CELLS as f64, (j + dj) as f64 / CELLS as f64);
            let corner = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            let points = corner.map(|(s, t)| (o + a * s + b * t).into());
            let uv = corner.map(|(s, t)| [s * a.norm() / texture_scale, t * b.norm() / texture_scale]);
            let cell = quad(points, uv);
            soup.positions.extend(cell.positions);
            soup.normals.extend(cell.normals);
            soup.uv.extend(cell.uv);
        }
    }
    soup
}

fn fixed(name: &str, soup: TriangleSoup, texels: Texels, texture_size: usize) -> Mesh {
    let pose = Isometry3::identity();
    Mesh {
        name: name.into(),
        soup,
        capacity: 0,
        texels,
        texture_size,
        part: Part::Background,
        shine: 0.0,
        pose,
    }
}

fn room(focus: f64, rng: &mut Pcg64Mcg) -> Vec<Mesh> {
    let kinds = [Surface::Wood, Surface::Cloth, Surface::Tiles, Surface::Speckle];
    let table_kind = kinds[rng.random_range(0..kinds.len())];
    let walls = [Surface::Plaster, Surface::Tiles, Surface::Plaster, Surface::Wood];
    let wall_kind = walls[rng.random_range(0..walls.len())];
    let far = focus + rng.random_range(0.28..0.6);
    let wall = far + rng.random_range(0.0..0.5);
    let table = sheet([-1.0, -0.4, 0.0], [2.0, 0.0, 0.0], [0.0, far + 0.4, 0.0], 1.0);
    let edge = quad(
        [[-1.0, far, -0.04], [1.0, far, -0.04], [1.0, far, 0.0], [-1.0, far, 0.0]]
            .map(|p: [f64; 3]| [-p[0], p[1], p[2]]),
        [[0.0, 0.0], [2.0, 0.0], [2.0, 0.04], [0.0, 0.04]],
    );
    let mut table_soup = table;
    table_soup.positions.extend(edge.positions);
    table_soup.normals.extend(edge.normals);
    table_soup.uv.extend(edge.uv);
    vec![
        fixed("table", table_soup, texture::surface(table_kind, TABLE_TEXTURE, rng), TABLE_TEXTURE),
        fixed(
            "wall",
            sheet([2.5, wall, -0.8], [0.0, 0.0, 3.0], [-5.0, 0.0, 0.0], 1.4),
            texture::surface(wall_kind, TABLE_TEXTURE, rng),
            TABLE_TEXTURE,
        ),
        fixed(
            "floor",
            sheet([-2.5, -1.0, -0.75], [5.0, 0.0, 0.0], [0.0, wall + 1.0, 0.0], 1.2),
            texture::surface(Surface::Speckle, TEXTURE, rng),
            TEXTURE,
        ),
    ]
}

fn clutter(keep_clear: &[[f64; 2]], focus: f64, rng: &mut Pcg64Mcg) -> Vec<Mesh> {
    let count = rng.random_range(3..7);
    let mut taken: Vec<[f64; 2]> = keep_clear.to_vec();
    let mut meshes = Vec::new();
    for index in 0..count {
        for _try in 0..30 {
            let at = [rng.random_range(-0.45..0.45), focus + rng.random_range(-0.12..0.28)];
            if taken.iter().any(|other| (other[0] - at[0]).hypot(other[1] - at[1]) < 0.13) {
                continue;
            }
            taken.push(at);
            meshes.push(clutter_piece(index, at, rng));
            break;
        }
    }
    meshes
}

fn clutter_piece(index: usize, [x, y]: [f64; 2], rng: &mut Pcg64Mcg) -> Mesh {
    let kinds = [ObjectKind::Can, ObjectKind::Cup, ObjectKind::Box, ObjectKind::Ball];
    let flat = rng.random_bool(0.45);
    let shape = if flat {
        ObjectShape::Box(Vector3::new(
            rng.random_range(0.04..0.09),
            rng.random_range(0.05..0.1),
            rng.random_range(0.004..0.015),
        ))
    } else {
        ObjectShape::random(kinds[rng.random_range(0..kinds.len())], rng)
    };
    let finish = [Finish::Uniform, Finish::Striped, Finish::Label][rng.random_range(0..3)];
    let mut mesh =
        fixed(&format!("clutter{index}"), shape.triangles(), texture::object(finish, TEXTURE, rng), TEXTURE);
    let yaw = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::z_axis(), rng.random_range(-1.5..1.5));
    mesh.pose = Isometry3::from_parts(nalgebra::Translation3::new(x, y, shape.half_height()), yaw);
    mesh.shine = 0.1;
    mesh
}

fn hand_meshes(rng: &mut Pcg64Mcg) -> Vec<Mesh> {
    let skin = texture::skin_palette(rng.random_range(0.0_f64..1.0).powf(1.4), 128);
    let cloth = texture::sleeve(256, rng);
    Side::BOTH
        .into_iter()
        .flat_map(|side| {
            let mesh = |what: &str, capacity, texels: &Texels, texture_size, shine| Mesh {
                name: format!("{}_{what}", side.name()),
                soup: TriangleSoup::default(),
                capacity,
                texels: texels.clone(),
                texture_size,
                part: Part::Hand(side),
                shine,
                pose: Isometry3::identity(),
            };
            [
                mesh("skin", SKIN_TRIANGLES, &skin, 128, 0.12),
                mesh("sleeve", SLEEVE_TRIANGLES, &cloth, 256, 0.0),
            ]
        })
        .collect()
}

fn light(rng: &mut Pcg64Mcg) -> String {
    let azimuth = rng.random_range(-1.0..1.0_f64);
    let key = Vector3::new(-azimuth.sin() * 0.7, 0.35 * azimuth.cos(), -1.0);
    // Near the scene, so that the shadow map's depth is fine enough.
    let lamp = Vector3::new(0.0, 0.4, 0.0) - key.normalize() * 1.1;
    // A lit room: most light is diffuse, so shadows are there but modest.
    let strength = rng.random_range(0.13..0.21);
    let warm = rng.random_range(-0.03..0.03);
    let lit = |direction: [f64; 3], at: [f64; 3], shadow: bool, colour: [f64; 3]| {
        let text = |v: [f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
        format!(
            "<light directional='true' dir='{}' pos='{}' castshadow='{shadow}' diffuse='{}' \
             specular='0.1 0.1 0.1' ambient='0 0 0'/>",
            text(direction),
            text(at),
            text(colour)
        )
    };
    let first = lit(key.into(), lamp.into(), true, [strength + warm, strength, strength - warm]);
    let second = lit([0.6, 0.5, -1.0], [0.0, 0.0, 2.0], false, [0.25, 0.25, 0.26]);
    let third = lit([-0.7, 0.3, -0.8], [0.0, 0.0, 2.0], false, [0.23; 3]);
    first + &second + &third
}

/// Compiles placeholders of the right capacity, then fills in triangles and texels.
fn build(meshes: &[Mesh], light: &str) -> Result<MjModel, SynthError> {
    const DOCUMENT: &str = "scene.xml";
    let mut assets = String::new();
    let mut world = String::new();
    let mut files = MjVfs::new();
    for (index, mesh) in meshes.iter().enumerate() {
        let triangles = mesh.capacity.max(mesh.soup.positions.len() / 3);
        let size = mesh.texture_size;
        let _ = write!(
            assets,
            "<texture name='t{index}' type='2d' builtin='flat' rgb1='1 1 1' width='{size}' height='{size}'/>\
             <material name='m{index}' texture='t{index}' specular='{0}' shininess='0.35' reflectance='0'/>",
            mesh.shine
        );
        let file = format!("{}.msh", mesh.name);
        files
            .add_from_buffer(&file, &placeholder(triangles))
            .map_err(|error| SynthError::Scene(error.to_string()))?;
        let _ = write!(assets, "<mesh name='{}' inertia='shell' file='{file}'/>", mesh.name);
        let group = match mesh.part {
            Part::Background => 0,
            Part::Object => 1,
            Part::Hand(_) => 2,
        };
        let geom = format!(
            "<geom name='{0}' type='mesh' mesh='{0}' material='m{index}' group='{group}' contype='0' conaffinity='0' mass='0'/>",
            mesh.name
        );
        if mesh.part == Part::Object {
            let _ = write!(
                world,
                "<body name='object' mocap='true'><inertial pos='0.1 0.2 0.3' mass='1' diaginertia='1 1 1'/>{geom}</body>"
            );
        } else {
            world.push_str(&geom);
        }
    }
    let xml = format!(
        "<mujoco><statistic center='0 0.4 0' extent='0.8'/>\
         <visual><headlight ambient='0.34 0.34 0.35' diffuse='0.18 0.18 0.18' specular='0.05 0.05 0.05'/>\
         <quality shadowsize='2048'/><map shadowclip='1.0' shadowscale='0.7' znear='0.3' zfar='2.6'/></visual>\
         <asset>{assets}</asset><worldbody>{light}{world}</worldbody></mujoco>"
    );
    files.add_from_buffer(DOCUMENT, xml.as_bytes()).map_err(|error| SynthError::Scene(error.to_string()))?;
    let mut model = compile_alone(|| MjModel::from_xml_vfs(DOCUMENT, &files))
        .map_err(|error| SynthError::Scene(error.to_string()))?;
    for (index, mesh) in meshes.iter().enumerate() {
        let start = usize::try_from(model.tex_adr()[index]).unwrap_or(0);
        model.tex_data_mut()[start..start + mesh.texels.len()].copy_from_slice(&mesh.texels);
        let mut soup = mesh.soup.clone();
        transform(&mut soup, &mesh.pose);
        fill(&mut model, index, &soup);
    }
    for pose in model.geom_pos_mut() {
        *pose = [0.0; 3];
    }
    for rotation in model.geom_quat_mut() {
        *rotation = [1.0, 0.0, 0.0, 0.0];
    }
    Ok(model)
}

/// Moves triangles by `pose`.
pub fn transform(soup: &mut TriangleSoup, pose: &Isometry3<f64>) {
    let pose = pose.cast::<f32>();
    for p in &mut soup.positions {
        *p = (pose * nalgebra::Point3::from(*p)).coords.into();
    }
    for n in &mut soup.normals {
        *n = (pose.rotation * Vector3::from(*n)).into();
    }
}

/// Distinct small triangles on a ball, so that the compiler keeps every one of them, as a MuJoCo
/// MSH file: binary, since its XML reader is slow at, and now and then trips over, long number lists.
fn placeholder(triangles: usize) -> Vec<u8> {
    let corners = 3 * triangles;
    // No capacity comes near 2^31 triangles.
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX).to_le_bytes();
    let mut file = [corners, corners, corners, triangles].map(count).concat();
    for triangle in 0..triangles {
        let angle = triangle as f64 * 2.399_963;
        let height = 1.0 - 2.0 * (triangle as f64 + 0.5) / triangles as f64;
        let radius = (1.0 - height * height).sqrt();
        let centre = [radius * angle.cos() + 0.3, radius * angle.sin() + 0.2, height + 0.1];
        for corner in 0..3 {
            for (axis, at) in centre.iter().enumerate() {
                let offset = if axis == corner { 0.02 } else { 0.0 };
                file.extend(((at + offset) as f32).to_le_bytes());
            }
        }
    }
    for _ in 0..corners {
        file.extend([0.0_f32, 0.0, 1.0].map(f32::to_le_bytes).as_flattened());
    }
    file.resize(file.len() + corners * 2 * size_of::<f32>(), 0);
    for corner in 0..corners {
        file.extend(count(corner));
    }
    file
}

/// Writes triangles into mesh `index`; what it has room for beyond them shrinks to a point.
fn fill(model: &mut MjModel, index: usize, soup: &TriangleSoup) {
    let range = |start: &[i32], count: &[i32]| {
        let first = usize::try_from(start[index]).unwrap_or(0);
        first..first + usize::try_from(count[index]).unwrap_or(0)
    };
    let vertices = range(model.mesh_vertadr(), model.mesh_vertnum());
    let normals = range(model.mesh_normaladr(), model.mesh_normalnum());
    let texels = range(model.mesh_texcoordadr(), model.mesh_texcoordnum());
    let kept = soup.positions.len().min(vertices.len());
    let rest = soup.positions.last().copied().unwrap_or([0.0, 0.0, -5.0]);
    let slots = &mut model.mesh_vert_mut()[vertices];
    slots[..kept].copy_from_slice(&soup.positions[..kept]);
    slots[kept..].fill(rest);
    let slots = &mut model.mesh_normal_mut()[normals];
    let kept_normals = kept.min(slots.len());
    slots[..kept_normals].copy_from_slice(&soup.normals[..kept_normals]);
    let slots = &mut model.mesh_texcoord_mut()[texels];
    let kept_texels = kept.min(slots.len());
    slots[..kept_texels].copy_from_slice(&soup.uv[..kept_texels]);
}
