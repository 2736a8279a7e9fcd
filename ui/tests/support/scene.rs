//! What the made-up clip shows: a table, a cup that is carried to the right, two arms.

use std::sync::{Arc, LazyLock};

use agenticfocus::{
    geometry::{Pinhole, Pixel, PixelBox, Side, Size},
    image::{Mask, Rgb8, Rgba8},
    landmarks::KEYPOINT_COUNT,
    segment::RleMask,
};
use nalgebra::Matrix3;

/// Frames of the clip.
pub const FRAMES: u32 = 60;
/// Its picture size.
pub const SIZE: Size = Size::new(320, 240);

/// The camera of the clip.
pub fn camera() -> Pinhole {
    Pinhole::from_horizontal_fov(80.0, SIZE).unwrap()
}

/// How far the cup was carried, 0 to 1.
fn carried(frame: u32) -> f64 {
    ((f64::from(frame) - 20.0) / 20.0).clamp(0.0, 1.0)
}

/// Centre of the cup.
pub fn object_centre(frame: u32) -> Pixel {
    let t = carried(frame);
    Pixel::new(130.0 + 80.0 * t, 128.0 - 40.0 * (t * std::f64::consts::PI).sin())
}

/// Box around the cup.
pub fn object_box(frame: u32) -> PixelBox {
    let c = object_centre(frame);
    PixelBox { x0: c.x - 22.0, y0: c.y - 28.0, x1: c.x + 22.0, y1: c.y + 28.0 }
}

/// Box around a thing that stays.
pub fn still_box() -> PixelBox {
    PixelBox { x0: 48.0, y0: 96.0, x1: 88.0, y1: 120.0 }
}

/// A point on the table's edge.
pub fn table_point() -> Pixel {
    Pixel::new(160.0, 72.0)
}

/// Template pixels (the cup cut out at frame 0) to pixels of `frame`.
pub fn placement(frame: u32) -> Matrix3<f64> {
    let b = object_box(frame);
    Matrix3::new(1.0, 0.0, b.x0, 0.0, 1.0, b.y0, 0.0, 0.0, 1.0)
}

fn in_cup(frame: u32, x: f64, y: f64) -> bool {
    let c = object_centre(frame);
    let (dx, dy) = (x - c.x, y - c.y);
    let body = dx.abs() <= 18.0 - 0.1 * dy && dy.abs() <= 26.0;
    body || (dx / 20.0).hypot((dy + 24.0) / 5.0) <= 1.0
}

/// Wrist of a side, 0 left and 1 right.
fn wrist(side: usize, frame: u32) -> Pixel {
    if side == 0 {
        let sway = (f64::from(frame) * 0.1).sin();
        return Pixel::new(70.0 + 6.0 * sway, 182.0 + 4.0 * sway);
    }
    let c = object_centre(frame);
    let near = ((f64::from(frame) - 5.0) / 15.0).clamp(0.0, 1.0);
    let away = ((f64::from(frame) - 44.0) / 12.0).clamp(0.0, 1.0);
    let gap = 70.0 * (1.0 - near) + 60.0 * away;
    Pixel::new(c.x + 46.0 + gap, c.y + 34.0 + 0.6 * gap)
}

/// The 21 keypoints of a side.
pub fn keypoints(side: usize, frame: u32) -> [Pixel; KEYPOINT_COUNT] {
    let w = wrist(side, frame);
    let toward = if side == 0 { 1.0 } else { -1.0 };
    std::array::from_fn(|index| {
        if index == 0 {
            return w;
        }
        let (finger, joint) = ((index - 1) / 4, (index - 1) % 4);
        let spread = [0.95, 0.45, 0.2, -0.05, -0.3][finger];
        let reach = [12.0, 22.0, 23.0, 22.0, 20.0][finger] + [7.0, 8.0, 8.5, 8.0, 6.5][finger] * joint as f64;
        let angle: f64 = 0.55 + spread;
        Pixel::new(w.x + toward * reach * angle.cos(), w.y - reach * angle.sin())
    })
}

fn distance_to_segment(p: Pixel, a: Pixel, b: Pixel) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let t = (((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy).max(1e-9)).clamp(0.0, 1.0);
    p.distance(Pixel::new(a.x + t * dx, a.y + t * dy))
}

fn arm_of(side: usize, frame: u32) -> impl Fn(u32, u32) -> bool {
    let points = keypoints(side, frame);
    let elbow = if side == 0 { Pixel::new(20.0, 250.0) } else { Pixel::new(points[0].x + 60.0, 260.0) };
    move |x, y| {
        let p = Pixel::new(f64::from(x), f64::from(y));
        if p.distance(points[0]) > 70.0 && p.y < points[0].y {
            return false;
        }
        let forearm = distance_to_segment(p, points[0], elbow) < 15.0;
        let palm = distance_to_segment(p, points[0], points[9]) < 13.0;
        let fingers = || {
            [1, 5, 9, 13, 17].iter().any(|base| distance_to_segment(p, points[*base], points[base + 3]) < 5.0)
        };
        forearm || palm || fingers()
    }
}

/// Drawn once for all tests of a binary: finger by finger and pixel by pixel takes its time.
static ARMS: LazyLock<[Vec<Mask>; 2]> = LazyLock::new(|| {
    [0, 1].map(|side| (0..FRAMES).map(|at| Mask::from_fn(SIZE, arm_of(side, at))).collect())
});

fn arms_pixels(side: usize, frame: u32) -> &'static Mask {
    &ARMS[side][frame as usize]
}

/// The visible part of the cup.
pub fn object_mask(frame: u32) -> RleMask {
    RleMask::encode(&object_pixels(frame))
}

fn object_pixels(frame: u32) -> Mask {
    let whole = Mask::from_fn(SIZE, |x, y| in_cup(frame, f64::from(x), f64::from(y)));
    whole.minus(arms_pixels(1, frame)).minus(arms_pixels(0, frame))
}

/// Both arms.
pub fn arms_mask(frame: u32) -> RleMask {
    RleMask::encode(&arms_pixels(0, frame).union(arms_pixels(1, frame)))
}

/// One arm.
pub fn side_mask(side: Side, frame: u32) -> RleMask {
    RleMask::encode(arms_pixels(side.index(), frame))
}

/// The table without anybody.
pub fn background() -> Rgb8 {
    let mut picture = Rgb8::new(SIZE);
    let still = still_box();
    for y in 0..SIZE.height {
        for x in 0..SIZE.width {
            let grain = ((x * 7 + y * 3) % 11) as u8;
            let wall = [150 - y as u8 / 3, 158 - y as u8 / 3, 166 - y as u8 / 4];
            let table = [126 + grain + y as u8 / 8, 98 + grain + y as u8 / 10, 72 + grain];
            let mut pixel = if y < 72 { wall } else { table };
            if still.contains(Pixel::new(f64::from(x), f64::from(y))) {
                pixel = [70, 90, 120];
            }
            picture.set_pixel(x, y, pixel);
        }
    }
    picture
}

fn fill(size: Size, mask: &Mask, colour: impl Fn(u32, u32) -> [u8; 3]) -> Rgba8 {
    let mut picture = Rgba8::new(size);
    for y in 0..size.height {
        for x in 0..size.width {
            if mask.get(x, y) {
                let [r, g, b] = colour(x, y);
                picture.set_pixel(x, y, [r, g, b, 255]);
            }
        }
    }
    picture
}

fn cup_colour(frame: u32) -> impl Fn(u32, u32) -> [u8; 3] {
    let c = object_centre(frame);
    move |x, y| {
        let light = (30.0 - (f64::from(x) - c.x + 6.0).abs()) as u8;
        if f64::from(y) < c.y - 19.0 {
            [228, 226, 220]
        } else {
            [150 + light, 46 + light / 2, 40 + light / 2]
        }
    }
}

static SOURCES: LazyLock<Vec<Arc<Rgb8>>> =
    LazyLock::new(|| (0..FRAMES).map(|at| Arc::new(filmed(at))).collect());

/// Frame as filmed.
pub fn source(frame: u32) -> Arc<Rgb8> {
    Arc::clone(&SOURCES[frame as usize])
}

fn filmed(frame: u32) -> Rgb8 {
    let mut picture = background();
    let cup = Mask::from_fn(SIZE, |x, y| in_cup(frame, f64::from(x), f64::from(y)));
    fill(SIZE, &cup, cup_colour(frame)).draw_over(&mut picture);
    for side in 0..2 {
        let skin =
            fill(SIZE, arms_pixels(side, frame), |x, y| [206 - (x % 9) as u8, 160 - (y % 7) as u8, 132]);
        skin.draw_over(&mut picture);
    }
    picture
}

/// Robot, object and the robot's near parts.
pub fn layers(frame: u32) -> (Rgba8, Rgba8, Rgba8) {
    let arms = arms_pixels(0, frame).union(arms_pixels(1, frame));
    let metal = |x: u32, y: u32| [196 - (x % 16) as u8, 200 - (y % 16) as u8, 206];
    let robot = fill(SIZE, &arms, metal);
    let cup = Mask::from_fn(SIZE, |x, y| in_cup(frame, f64::from(x), f64::from(y)));
    let object = fill(SIZE, &cup, cup_colour(frame));
    let points = keypoints(1, frame);
    let thumb = Mask::from_fn(SIZE, |x, y| {
        distance_to_segment(Pixel::new(f64::from(x), f64::from(y)), points[1], points[4]) < 5.0
    });
    (robot, object, fill(SIZE, &thumb, metal))
}

/// The cup cut out whole at frame 0, with the column and row of its corner.
pub fn template() -> (Rgba8, (u32, u32)) {
    let b = object_box(0);
    let (x0, y0) = (b.x0 as u32, b.y0 as u32);
    let size = Size::new(b.width() as u32 + 1, b.height() as u32 + 1);
    let mask = Mask::from_fn(size, |x, y| in_cup(0, f64::from(x + x0), f64::from(y + y0)));
    let colour = cup_colour(0);
    (fill(size, &mask, |x, y| colour(x + x0, y + y0)), (x0, y0))
}

/// A picture made smaller by taking every nth pixel.
pub fn shrunk(picture: &Rgb8, height: u32) -> Rgb8 {
    let from = picture.size();
    let size = Size::new(from.width * height / from.height, height);
    let mut small = Rgb8::new(size);
    for y in 0..size.height {
        for x in 0..size.width {
            let pixel = picture.pixel(x * from.width / size.width, y * from.height / size.height);
            small.set_pixel(x, y, pixel);
        }
    }
    small
}

/// Something like a robot seen from outside.
pub fn orbit(size: Size) -> Rgb8 {
    let mut picture = Rgb8::new(size);
    let (cx, cy) = (f64::from(size.width) / 2.0, f64::from(size.height) / 2.0);
    for y in 0..size.height {
        for x in 0..size.width {
            let p = Pixel::new(f64::from(x), f64::from(y));
            let limb = |x0: f64, y0: f64, x1: f64, y1: f64| {
                distance_to_segment(p, Pixel::new(cx + x0, cy + y0), Pixel::new(cx + x1, cy + y1))
            };
            let body = limb(0.0, -30.0, 0.0, 40.0) < 26.0;
            let arms = limb(-30.0, -30.0, -50.0, 20.0) < 9.0 || limb(30.0, -30.0, 60.0, 10.0) < 9.0;
            let ground = 60 + (40.0 * p.y / f64::from(size.height)) as u8;
            picture.set_pixel(x, y, if body || arms { [190, 196, 204] } else { [ground; 3] });
        }
    }
    picture
}
