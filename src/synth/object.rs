//! The manipulated object: shape, distance and triangles.

use nalgebra::Vector3;
use rand::Rng as _;
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::skin::TriangleSoup;

/// Kinds of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObjectKind {
    /// An upright carton.
    Box,
    /// A can.
    Can,
    /// A tapered cup.
    Cup,
    /// A bottle with a neck.
    Bottle,
    /// A ball.
    Ball,
    /// A lying tool with handle and shaft.
    Tool,
}

impl ObjectKind {
    /// All kinds.
    pub const ALL: [Self; 6] = [Self::Can, Self::Box, Self::Cup, Self::Ball, Self::Bottle, Self::Tool];
}

/// A shape in the object's frame, metres: z is its axis, the origin its centre.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectShape {
    /// Half extents along x, y, z.
    Box(Vector3<f64>),
    /// A closed outline (radius, z) turned around z; from the axis at the bottom to the axis at the top.
    Turned(Vec<[f64; 2]>),
}

impl ObjectShape {
    /// A random shape of `kind`.
    pub fn random(kind: ObjectKind, rng: &mut Pcg64Mcg) -> Self {
        let mut between = |low: f64, high: f64| rng.random_range(low..high);
        match kind {
            ObjectKind::Box => {
                Self::Box(Vector3::new(between(0.022, 0.030), between(0.028, 0.040), between(0.048, 0.070)))
            }
            ObjectKind::Can => {
                let (r, h) = (between(0.026, 0.035), between(0.048, 0.064));
                Self::Turned(vec![
                    [0.0, -h],
                    [r - 0.003, -h],
                    [r, -h + 0.003],
                    [r, h - 0.004],
                    [r - 0.003, h],
                    [0.0, h],
                ])
            }
            ObjectKind::Cup => {
                let (r, h) = (between(0.036, 0.042), between(0.042, 0.054));
                let foot = r * between(0.72, 0.85);
                Self::Turned(vec![
                    [0.0, -h],
                    [foot - 0.003, -h],
                    [foot, -h + 0.003],
                    [r, h - 0.002],
                    [r - 0.0015, h],
                    [r - 0.004, h - 0.002],
                    [foot - 0.004, -h + 0.010],
                    [0.0, -h + 0.010],
                ])
            }
            ObjectKind::Bottle => {
                let (r, h, neck) = (between(0.027, 0.034), between(0.075, 0.095), between(0.011, 0.014));
                Self::Turned(vec![
                    [0.0, -h],
                    [r - 0.004, -h],
                    [r, -h + 0.005],
                    [r, 0.25 * h],
                    [r - 0.003, 0.40 * h],
                    [neck + 0.004, 0.66 * h],
                    [neck, 0.74 * h],
                    [neck, 0.84 * h],
                    [neck + 0.003, 0.845 * h],
                    [neck + 0.003, h - 0.002],
                    [neck + 0.001, h],
                    [0.0, h],
                ])
            }
            ObjectKind::Ball => {
                let r = between(0.028, 0.034);
                let steps = 20;
                Self::Turned(
                    (0..=steps)
                        .map(|i| {
                            let angle = std::f64::consts::PI * f64::from(i) / f64::from(steps);
                            [(r * angle.sin()).max(0.0), -r * angle.cos()]
                        })
                        .collect(),
                )
            }
            ObjectKind::Tool => {
                let (r, h, shaft) = (between(0.013, 0.017), between(0.085, 0.11), between(0.004, 0.006));
                Self::Turned(vec![
                    [0.0, -h],
                    [r * 0.8, -h],
                    [r, -h + 0.006],
                    [r * 0.86, -0.35 * h],
                    [r, -0.05 * h],
                    [r * 0.7, 0.02 * h],
                    [shaft, 0.04 * h],
                    [shaft, 0.93 * h],
                    [shaft * 1.6, 0.95 * h],
                    [shaft * 1.3, h],
                    [0.0, h],
                ])
            }
        }
    }

    /// Signed distance of `p`, metres.
    pub fn distance(&self, p: &Vector3<f64>) -> f64 {
        match self {
            Self::Box(half) => {
                let q = p.abs() - half;
                q.sup(&Vector3::zeros()).norm() + q.max().min(0.0)
            }
            Self::Turned(outline) => {
                let (r, z) = (p.x.hypot(p.y), p.z);
                outline_distance(outline, r, z)
            }
        }
    }

    /// Half height along z, metres.
    pub fn half_height(&self) -> f64 {
        match self {
            Self::Box(half) => half.z,
            Self::Turned(outline) => outline.iter().map(|point| point[1]).fold(0.0, f64::max),
        }
    }

    /// Largest distance from the axis at height `z`, metres.
    pub fn radius_at(&self, z: f64) -> f64 {
        match self {
            Self::Box(half) => half.x,
            Self::Turned(outline) => {
                let crossing = outline.windows(2).filter_map(|pair| {
                    let ([ra, za], [rb, zb]) = (pair[0], pair[1]);
                    let inside = za.min(zb) <= z && z <= za.max(zb) && (zb - za).abs() > 1e-9;
                    inside.then(|| ra + (rb - ra) * (z - za) / (zb - za))
                });
                crossing.fold(0.0, f64::max)
            }
        }
    }

    /// Triangles with texture coordinates; v runs from the top (0) to the bottom (1).
    pub fn triangles(&self) -> TriangleSoup {
        match self {
            Self::Box(half) => box_triangles(half),
            Self::Turned(outline) => turned_triangles(outline),
        }
    }
}

fn outline_distance(outline: &[[f64; 2]], r: f64, z: f64) -> f64 {
    let mut nearest = f64::INFINITY;
    let mut inside = false;
    let mut previous = outline[outline.len() - 1];
    for point in outline {
        let ([ra, za], [rb, zb]) = (previous, *point);
        let (dr, dz) = (rb - ra, zb - za);
        // The closing side lies on the axis: it bounds the polygon but is no surface.
        if !(ra == 0.0 && rb == 0.0) {
            let t = (((r - ra) * dr + (z - za) * dz) / (dr * dr + dz * dz)).clamp(0.0, 1.0);
            nearest = nearest.min((r - ra - dr * t).hypot(z - za - dz * t));
        }
        if (za > z) != (zb > z) && r < ra + dr * (z - za) / dz {
            inside = !inside;
        }
        previous = *point;
    }
    if inside { -nearest } else { nearest }
}

fn box_triangles(half: &Vector3<f64>) -> TriangleSoup {
    let mut soup = TriangleSoup::default();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |a: f64, b: f64| {
                let mut p = Vector3::zeros();
                p[axis] = sign * half[axis];
                p[u] = a * sign * half[u];
                p[v] = b * half[v];
                p
            };
            let mut normal = Vector3::<f64>::zeros();
            normal[axis] = sign;
            let quad = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            for index in [0, 1, 2, 0, 2, 3] {
                let p: Vector3<f64> = quad[index];
                soup.positions.push(p.cast::<f32>().into());
                soup.normals.push(normal.cast::<f32>().into());
                let flat = [(p.x / half.x + 1.0) * 0.25, (p.y / half.y + 1.0) * 0.25];
                let texel = match axis {
                    0 => [flat[1] + 0.5 * f64::from(sign > 0.0), (1.0 - p.z / half.z) * 0.5],
                    1 => [flat[0] + 0.5 * f64::from(sign > 0.0), (1.0 - p.z / half.z) * 0.5],
                    _ => [flat[0], flat[1] * 0.3],
                };
                soup.uv.push(texel.map(|t| t as f32));
            }
        }
    }
    soup
}

fn turned_triangles(outline: &[[f64; 2]]) -> TriangleSoup {
    const SIDES: usize = 48;
    let top = outline.iter().map(|point| point[1]).fold(f64::MIN, f64::max);
    let bottom = outline.iter().map(|point| point[1]).fold(f64::MAX, f64::min);
    let smooth = outline.len() > 18;
    let mut soup = TriangleSoup::default();
    for (row, pair) in outline.windows(2).enumerate() {
        let flat_normal = |i: usize| {
            let ([ra, za], [rb, zb]) = (outline[i], outline[i + 1]);
            let n = nalgebra::Vector2::new(zb - za, ra - rb);
            n.try_normalize(1e-12).unwrap_or_else(nalgebra::Vector2::x)
        };
        let here = flat_normal(row);
        let blend = |other: Option<usize>| match other {
            Some(index) if smooth => (here + flat_normal(index)).normalize(),
            _ => here,
        };
        let low = blend(row.checked_sub(1));
        let high = blend((row + 2 < outline.len()).then_some(row + 1));
        for side in 0..SIDES {
            let corners = [(0, side), (0, side + 1), (1, side + 1), (1, side)];
            for index in [0, 1, 2, 0, 2, 3] {
                let (end, step) = corners[index];
                let angle = std::f64::consts::TAU * step as f64 / SIDES as f64;
                let [r, z] = pair[end];
                let n = if end == 0 { low } else { high };
                soup.positions.push([r * angle.cos(), r * angle.sin(), z].map(|c| c as f32));
                soup.normals.push([n.x * angle.cos(), n.x * angle.sin(), n.y].map(|c| c as f32));
                let inward = if n.x < -0.5 { 0.93 } else { 1.0 - (z - bottom) / (top - bottom) };
                soup.uv.push([(step as f64 / SIDES as f64) as f32, inward as f32]);
            }
        }
    }
    soup
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;

    use super::*;

    #[test]
    fn triangles_lie_on_the_surface_and_face_outwards() {
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        for kind in ObjectKind::ALL {
            let shape = ObjectShape::random(kind, &mut rng);
            let soup = shape.triangles();
            for (triangle, normals) in soup.positions.chunks_exact(3).zip(soup.normals.chunks_exact(3)) {
                let [a, b, c] = [0, 1, 2].map(|i| Vector3::from(triangle[i]).cast::<f64>());
                let face = (b - a).cross(&(c - a));
                if face.norm() < 1e-9 {
                    continue;
                }
                let centre = (a + b + c) / 3.0;
                assert!(shape.distance(&centre).abs() < 6e-4, "{kind:?} {}", shape.distance(&centre));
                assert!(face.normalize().dot(&Vector3::from(normals[0]).cast()) > 0.6, "{kind:?}");
                assert!(shape.distance(&(centre + face.normalize() * 8e-4)) > 0.0, "{kind:?}");
            }
        }
    }
}
