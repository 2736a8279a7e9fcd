//! Renders the embedded robot, or a URDF file as `robot import` takes it, as its own camera or a bystander sees it.
//!
//! `cargo run --example look_at_robot -- OUT.png [MODEL.urdf] [--view head|side|hand] [--grey 0..255] [--close 0..1]`
//! `cargo run --example look_at_robot -- --mjcf OUT.xml` writes the embedded model as one MJCF document.
//!
//! With `--view head` the layers of the pipeline are shown over a plain background; the others look at the robot
//! from outside.

use std::{error::Error, path::PathBuf, time::Instant};

use agenticfocus::{
    geometry::{PerSide, Pinhole, Size},
    render::{LayerRequest, NearParts, RobotRenderParams, RobotRenderer},
    retarget::CameraMap,
    robot::{JointAngles, RobotModel, import},
};
use nalgebra::{Matrix3, Rotation3, Vector3};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (mut out, mut model, mut view, mut grey, mut close) =
        (None, None, "head".to_owned(), 200_u8, 0.0_f64);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} wants a value"));
        match argument.as_str() {
            "--view" => view = value()?,
            "--grey" => grey = value()?.parse()?,
            "--close" => close = value()?.parse()?,
            "--mjcf" => {
                std::fs::write(value()?, RobotModel::embedded()?.mjcf())?;
                return Ok(());
            }
            _ if out.is_none() => out = Some(PathBuf::from(argument)),
            _ => model = Some(PathBuf::from(argument)),
        }
    }
    let out = out.ok_or("where should the picture go?")?;
    let robot = match model {
        Some(path) => import(&path, tempfile::tempdir()?.path())?.load()?,
        None => RobotModel::embedded()?,
    };
    let size = Size::new(640, 480);
    let pinhole = Pinhole::new(460.0, 460.0, 319.5, 239.5, size)?;
    let map = camera(&view);
    let mut renderer = RobotRenderer::new(&robot, pinhole, RobotRenderParams::default())?;
    let angles = pose(close, &robot);
    let near = NearParts { thumb: true, fingers_within: None };
    let request = LayerRequest {
        shown: PerSide { left: true, right: true },
        near: PerSide { left: near, right: near },
    };
    let layers = renderer.render(&angles, &map, &request)?;
    let start = Instant::now();
    for _ in 0..10 {
        renderer.render(&angles, &map, &request)?;
    }
    println!("{}: {:.1} ms a frame", renderer.device_name(), start.elapsed().as_secs_f64() * 100.0);
    let mut picture = Vec::new();
    for pixel in layers.full.pixels() {
        let alpha = u32::from(pixel[3]);
        for channel in &pixel[..3] {
            picture.push(((u32::from(*channel) * alpha + u32::from(grey) * (255 - alpha)) / 255) as u8);
        }
    }
    save(&out, size, &picture)?;
    Ok(())
}

/// Hands in front of the body, fingers closed by `close`.
fn pose(close: f64, robot: &RobotModel) -> JointAngles {
    let mut angles = JointAngles::default();
    let arm = [-0.5, 0.25, 0.1, 0.2, 0.3, -0.2, 0.1];
    for (joint, angle) in arm.into_iter().enumerate() {
        let mirrored = matches!(joint, 1 | 2 | 4 | 6);
        angles.0[joint] = angle;
        angles.0[7 + joint] = if mirrored { -angle } else { angle };
    }
    for actuator in 14..26 {
        angles.0[actuator] = close * robot.limits().upper[actuator];
    }
    angles
}

fn camera(view: &str) -> CameraMap {
    let look = |from: Vector3<f64>, at: Vector3<f64>| {
        let z = (at - from).normalize();
        let x = z.cross(&Vector3::z()).normalize();
        CameraMap { beta: 1.0, rotation: Matrix3::from_columns(&[x, z.cross(&x), z]), offset: from }
    };
    match view {
        "side" => look(Vector3::new(0.8, 0.7, 0.45), Vector3::new(0.15, 0.05, 0.1)),
        "front" => look(Vector3::new(1.0, 0.0, 0.3), Vector3::new(0.0, 0.0, 0.15)),
        "hand" => look(Vector3::new(0.55, 0.45, 0.35), Vector3::new(0.36, 0.14, 0.2)),
        "palm" => look(Vector3::new(0.45, -0.12, 0.35), Vector3::new(0.36, 0.14, 0.2)),
        _ => {
            let axes = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
            let pitch = Rotation3::from_axis_angle(&Vector3::y_axis(), 0.83077);
            let offset = Vector3::new(0.0576, 0.0325, 0.42987);
            CameraMap { beta: 1.0, rotation: pitch.matrix() * axes, offset }
        }
    }
}

fn save(path: &std::path::Path, size: Size, rgb: &[u8]) -> Result<(), Box<dyn Error>> {
    let mut encoder = png::Encoder::new(std::fs::File::create(path)?, size.width, size.height);
    encoder.set_color(png::ColorType::Rgb);
    Ok(encoder.write_header()?.write_image_data(rgb)?)
}
