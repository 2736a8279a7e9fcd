//! Procedural textures: table tops, walls, labels, cloth and skin.

use rand::Rng as _;
use rand_pcg::Pcg64Mcg;

/// A texture of `size` × `size` RGB pixels.
pub type Texels = Vec<u8>;

fn hash(x: i64, y: i64, z: i64) -> f64 {
    let mut h = (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
        ^ (z as u64).wrapping_mul(0x1656_67B1_9E37_79F9);
    h ^= h >> 32;
    h = h.wrapping_mul(0xD6E8_FEB8_6659_FD93);
    h ^= h >> 32;
    (h & 0xFFFF_FFFF) as f64 / f64::from(u32::MAX) * 2.0 - 1.0
}

/// Value noise in −1..1 with unit period.
pub fn noise3(x: f64, y: f64, z: f64) -> f64 {
    let (fx, fy, fz) = (x.floor(), y.floor(), z.floor());
    let fade = |t: f64| t * t * (3.0 - 2.0 * t);
    let (u, v, w) = (fade(x - fx), fade(y - fy), fade(z - fz));
    let corner = |dx: i64, dy: i64, dz: i64| hash(fx as i64 + dx, fy as i64 + dy, fz as i64 + dz);
    let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let plane = |dz: i64| {
        let low = lerp(corner(0, 0, dz), corner(1, 0, dz), u);
        lerp(low, lerp(corner(0, 1, dz), corner(1, 1, dz), u), v)
    };
    lerp(plane(0), plane(1), w)
}

/// Fractal noise in about −1..1.
pub fn fractal(x: f64, y: f64, z: f64, octaves: u32) -> f64 {
    let (mut sum, mut amplitude, mut frequency) = (0.0, 0.5, 1.0);
    for octave in 0..octaves {
        sum += amplitude * noise3(x * frequency, y * frequency, z + f64::from(octave) * 7.7);
        amplitude *= 0.55;
        frequency *= 2.03;
    }
    sum
}

/// An RGB colour, 0 to 1.
pub type Colour = [f64; 3];

/// A colour from hue (turns), saturation and value.
pub fn hsv(hue: f64, saturation: f64, value: f64) -> Colour {
    [5.0, 3.0, 1.0].map(|n: f64| {
        let k = (n + hue.rem_euclid(1.0) * 6.0).rem_euclid(6.0);
        value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0)
    })
}

fn scaled(colour: Colour, factor: f64) -> Colour {
    colour.map(|channel| channel * factor)
}

fn mixed(a: Colour, b: Colour, t: f64) -> Colour {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

/// Paints a square texture by asking for the colour at (u, v) in 0..1.
pub fn paint(size: usize, colour: impl Fn(f64, f64) -> Colour) -> Texels {
    let mut texels = Vec::with_capacity(size * size * 3);
    for row in 0..size {
        for column in 0..size {
            let pixel = colour((column as f64 + 0.5) / size as f64, (row as f64 + 0.5) / size as f64);
            texels.extend(pixel.map(|channel| (channel.clamp(0.0, 1.0) * 255.0).round() as u8));
        }
    }
    texels
}

/// What a table top or wall is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Surface {
    /// Planks with grain.
    Wood,
    /// A woven, faintly checked cloth.
    Cloth,
    /// Tiles of uneven tone with joints.
    Tiles,
    /// Stone with speckles.
    Speckle,
    /// Paint with broad, faint unevenness.
    Plaster,
}

/// A random `surface` over a metre and a half.
pub fn surface(surface: Surface, size: usize, rng: &mut Pcg64Mcg) -> Texels {
    let z = rng.random_range(0.0..500.0);
    let tone = rng.random_range(0.75..1.0);
    match surface {
        Surface::Wood => {
            let base = scaled(hsv(rng.random_range(0.06..0.10), rng.random_range(0.35..0.65), 0.72), tone);
            let planks = f64::from(rng.random_range(4_u32..9));
            paint(size, |u, v| wood(base, planks, z, u, v))
        }
        Surface::Cloth => {
            let base = scaled(hsv(rng.random(), rng.random_range(0.1..0.45), 0.8), tone);
            let stripes = rng.random_range(9.0..16.0);
            paint(size, |u, v| cloth(base, stripes, z, u, v))
        }
        Surface::Tiles => {
            let base = scaled(hsv(rng.random(), rng.random_range(0.03..0.25), 0.75), tone);
            let count = f64::from(rng.random_range(7_u32..12));
            paint(size, |u, v| tiles(base, count, z, u, v))
        }
        Surface::Speckle => {
            let base = scaled(hsv(rng.random(), rng.random_range(0.02..0.15), 0.62), tone);
            paint(size, |u, v| {
                let broad = 0.12 * fractal(u * 9.0, v * 9.0, z, 4);
                let grain = noise3(u * 190.0, v * 190.0, z + 31.0);
                let speck = if grain > 0.55 {
                    0.20
                } else if grain < -0.6 {
                    -0.22
                } else {
                    0.0
                };
                scaled(base, 1.0 + broad + speck)
            })
        }
        Surface::Plaster => {
            let base = scaled(hsv(rng.random(), rng.random_range(0.03..0.3), 0.85), tone);
            paint(size, |u, v| {
                scaled(
                    base,
                    1.0 + 0.12 * fractal(u * 5.0, v * 5.0, z, 5) + 0.03 * noise3(u * 150.0, v * 150.0, z),
                )
            })
        }
    }
}

fn wood(base: Colour, planks: f64, z: f64, u: f64, v: f64) -> Colour {
    let plank = (v * planks).floor();
    let within = v * planks - plank;
    let shift = hash(plank as i64, 3, z as i64);
    let warp = fractal(u * 3.0 + shift * 20.0, v * 26.0, z, 4);
    let rings = ((v * planks * 9.0 + warp * 5.0 + shift * 9.0).sin() * 0.5 + 0.5).powi(2);
    let fibre = noise3(u * 26.0 + shift * 50.0, v * 420.0, z);
    let joint = if within < 0.016 { 0.62 } else { 1.0 };
    scaled(base, (0.88 + 0.13 * shift - 0.20 * rings + 0.07 * fibre + 0.1 * warp) * joint)
}

fn cloth(base: Colour, stripes: f64, z: f64, u: f64, v: f64) -> Colour {
    let weave = 0.04 * ((u * 900.0).sin() * (v * 900.0).sin());
    let wrinkle = 0.16 * fractal(u * 6.0, v * 6.0, z, 4);
    let check =
        |t: f64| if (t * stripes + 0.6 * noise3(t * stripes, 0.0, z)).fract() < 0.3 { 1.0 } else { 0.0 };
    let tone = 1.0 + weave + wrinkle - 0.10 * check(u) - 0.10 * check(v);
    scaled(base, tone)
}

fn tiles(base: Colour, count: f64, z: f64, u: f64, v: f64) -> Colour {
    let (iu, iv) = ((u * count).floor(), (v * count).floor());
    let (fu, fv) = (u * count - iu, v * count - iv);
    let tone = 0.10 * hash(iu as i64, iv as i64, z as i64);
    let marble = 0.16 * fractal(u * 14.0 + hash(iu as i64, iv as i64, 9) * 8.0, v * 14.0, z, 5);
    if fu.min(fv) < 0.03 {
        scaled([0.52, 0.5, 0.48], 1.0 + marble)
    } else {
        scaled(base, 1.0 + tone + marble)
    }
}

/// How a manipulated object is painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Finish {
    /// One colour with slight wear.
    Uniform,
    /// Bands around the object.
    Striped,
    /// A printed label with blobs and lines.
    Label,
}

/// A random object texture; v runs from the bottom (1) to the top (0) of the object.
pub fn object(finish: Finish, size: usize, rng: &mut Pcg64Mcg) -> Texels {
    let z = rng.random_range(0.0..500.0);
    // Away from the hues of skin and wood, as a picture of a person's things usually is in part only.
    let hue: f64 = rng.random_range(0.18..1.0);
    let base = hsv(hue, rng.random_range(0.2..0.7), rng.random_range(0.4..0.85));
    let second =
        hsv(hue + rng.random_range(0.25..0.75), rng.random_range(0.15..0.7), rng.random_range(0.35..0.9));
    let ink = hsv(rng.random(), 0.4, 0.18);
    let bands = rng.random_range(4.0..9.0);
    paint(size, move |u, v| {
        let wear = 1.0 + 0.10 * fractal(u * 10.0, v * 10.0, z, 5) + 0.04 * noise3(u * 120.0, v * 120.0, z);
        let plain = scaled(base, wear);
        match finish {
            Finish::Uniform => plain,
            Finish::Striped => {
                let stripe = (v * bands).fract();
                if stripe < 0.42 { scaled(second, wear) } else { plain }
            }
            Finish::Label => label(plain, scaled(second, wear), ink, z, u, v),
        }
    })
}

fn label(plain: Colour, paper: Colour, ink: Colour, z: f64, u: f64, v: f64) -> Colour {
    if !(0.22..0.80).contains(&v) {
        return plain;
    }
    let blob = fractal(u * 7.0, v * 5.0, z + 90.0, 3);
    let line = (v * 34.0).floor();
    let text = (0.5..0.72).contains(&v)
        && (v * 34.0).fract() < 0.5
        && noise3(u * 46.0, line * 3.1, z) > -0.1
        && (u * 3.0).fract() < 0.75;
    if text {
        ink
    } else if blob > 0.16 {
        mixed(paper, [0.95, 0.93, 0.86], 0.7)
    } else if blob < -0.22 {
        mixed(paper, ink, 0.55)
    } else {
        paper
    }
}

/// A skin palette for [`super::skin`]: columns from palm over back and knuckle to nail, rows mottling.
pub fn skin_palette(tone: f64, size: usize) -> Texels {
    let light = [[0.93, 0.73, 0.64], [0.90, 0.68, 0.56], [0.80, 0.53, 0.43], [0.94, 0.77, 0.70]];
    let dark = [[0.60, 0.42, 0.34], [0.36, 0.23, 0.17], [0.25, 0.155, 0.12], [0.58, 0.41, 0.36]];
    let stops = [0.05, 0.35, 0.62, 0.95];
    paint(size, |u, v| {
        let segment = stops[1..3].iter().filter(|stop| u > **stop).count();
        let t = ((u - stops[segment]) / (stops[segment + 1] - stops[segment])).clamp(0.0, 1.0);
        let colour = |set: &[Colour; 4]| mixed(set[segment], set[segment + 1], t);
        let base = mixed(colour(&light), colour(&dark), tone);
        let mottle = (v - 0.5) * 2.0;
        // Redder where it is darker, as blood shines through.
        [base[0] * (1.0 + 0.06 * mottle), base[1] * (1.0 + 0.10 * mottle), base[2] * (1.0 + 0.11 * mottle)]
    })
}

/// A knitted sleeve.
pub fn sleeve(size: usize, rng: &mut Pcg64Mcg) -> Texels {
    let base = hsv(rng.random(), rng.random_range(0.15..0.75), rng.random_range(0.25..0.75));
    let z = rng.random_range(0.0..500.0);
    let ribs = rng.random_bool(0.5);
    paint(size, |u, v| {
        let rib = if ribs { 0.10 * (u * 24.0 * std::f64::consts::TAU).sin() } else { 0.0 };
        scaled(
            base,
            1.0 + rib
                + 0.14 * fractal(u * 12.0, v * 12.0, z, 4)
                + 0.06 * hash((u * 256.0) as i64, (v * 256.0) as i64, 1),
        )
    })
}
