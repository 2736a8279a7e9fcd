//! Implicit surfaces and their triangles: the flesh around posed bones.

use nalgebra::Vector3;

/// A bone's flesh: a capsule whose radius changes linearly from one end to the other.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// Centre of the first sphere, metres.
    pub a: Vector3<f64>,
    /// Centre of the second sphere, metres.
    pub b: Vector3<f64>,
    /// First radius, metres.
    pub ra: f64,
    /// Second radius, metres.
    pub rb: f64,
    /// Cones of one group melt into each other; groups other than 0 melt into group 0 only.
    pub group: usize,
    /// What the caller knows it by.
    pub tag: usize,
}

impl Cone {
    /// Signed distance of `p`, metres; exact for equal radii.
    pub fn distance(&self, p: &Vector3<f64>) -> f64 {
        let ab = self.b - self.a;
        let t = ((p - self.a).dot(&ab) / ab.norm_squared().max(1e-12)).clamp(0.0, 1.0);
        (p - self.a - ab * t).norm() - (self.ra + (self.rb - self.ra) * t)
    }
}

/// The smooth union of two distances: a polynomial blend of width `k`.
pub fn smooth_min(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

/// A blend of cones.
#[derive(Clone, Debug)]
pub struct Flesh {
    /// The cones; group 0 is the body the other groups grow out of.
    pub cones: Vec<Cone>,
    /// Blend inside group 0, metres.
    pub body_blend: f64,
    /// Blend inside the other groups, metres.
    pub limb_blend: f64,
    /// Blend of a limb into the body, metres.
    pub join_blend: f64,
}

/// At most this many groups.
const GROUPS: usize = 8;

impl Flesh {
    fn blend(&self, p: &Vector3<f64>, active: &[usize]) -> f64 {
        let mut groups = [1.0_f64; GROUPS];
        for index in active {
            let cone = &self.cones[*index];
            let blend = if cone.group == 0 { self.body_blend } else { self.limb_blend };
            groups[cone.group] = smooth_min(groups[cone.group], cone.distance(p), blend);
        }
        let mut distance = groups[0];
        for limb in &groups[1..] {
            distance = distance.min(smooth_min(groups[0], *limb, self.join_blend));
        }
        distance
    }

    fn all(&self) -> Vec<usize> {
        (0..self.cones.len()).collect()
    }

    /// The tag of the cone nearest to `p`.
    pub fn nearest_tag(&self, p: &Vector3<f64>) -> usize {
        let nearest = self.cones.iter().min_by(|a, b| a.distance(p).total_cmp(&b.distance(p)));
        nearest.map_or(0, |cone| cone.tag)
    }

    fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = Vector3::repeat(f64::NEG_INFINITY);
        for cone in &self.cones {
            for (centre, radius) in [(cone.a, cone.ra), (cone.b, cone.rb)] {
                low = low.inf(&(centre - Vector3::repeat(radius)));
                high = high.sup(&(centre + Vector3::repeat(radius)));
            }
        }
        (low, high)
    }

    /// Triangles of the surface by naive surface nets on a grid of `cell` metres, with vertices
    /// moved onto the surface and normals from its gradient.
    pub fn triangulate(&self, cell: f64) -> Surface {
        let (low, high) = self.bounds();
        let margin = Vector3::repeat(2.5 * cell);
        let grid = Grid::sample(self, low - margin, high + margin, cell);
        grid.surface(self)
    }
}

/// Indexed triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Positions, metres.
    pub vertices: Vec<Vector3<f64>>,
    /// Unit normals, one a vertex.
    pub normals: Vec<Vector3<f64>>,
    /// Indices.
    pub triangles: Vec<[u32; 3]>,
}

/// Samples a block has on each side.
const BLOCK: usize = 8;

struct Grid {
    origin: Vector3<f64>,
    cell: f64,
    dims: [usize; 3],
    values: Vec<f32>,
    /// Cones that matter in each block; empty where the surface does not pass.
    active: Vec<Vec<usize>>,
    blocks: [usize; 3],
}

impl Grid {
    fn sample(flesh: &Flesh, low: Vector3<f64>, high: Vector3<f64>, cell: f64) -> Self {
        let blocks: [usize; 3] =
            std::array::from_fn(|axis| ((high[axis] - low[axis]) / cell / BLOCK as f64).ceil() as usize + 1);
        let dims = blocks.map(|count| count * BLOCK);
        let values = vec![1.0; dims[0] * dims[1] * dims[2]];
        let active = vec![Vec::new(); blocks[0] * blocks[1] * blocks[2]];
        let mut grid = Self { origin: low, cell, dims, values, active, blocks };
        let all = flesh.all();
        for bz in 0..blocks[2] {
            for by in 0..blocks[1] {
                for bx in 0..blocks[0] {
                    grid.fill_block(flesh, &all, [bx, by, bz]);
                }
            }
        }
        grid
    }

    fn fill_block(&mut self, flesh: &Flesh, all: &[usize], block: [usize; 3]) {
        let half = BLOCK as f64 * self.cell * 0.5;
        let centre = self.origin
            + Vector3::from(block.map(|index| index as f64)) * (2.0 * half)
            + Vector3::repeat(half - 0.5 * self.cell);
        let reach = half * 3.0_f64.sqrt() * 1.1 + 2.0 * self.cell;
        let centre_value = flesh.blend(&centre, all);
        let slot = (block[2] * self.blocks[1] + block[1]) * self.blocks[0] + block[0];
        let blend = flesh.body_blend.max(flesh.limb_blend).max(flesh.join_blend);
        if centre_value.abs() < reach {
            let near = |index: &&usize| flesh.cones[**index].distance(&centre) < 2.0 * reach + blend;
            self.active[slot] = all.iter().filter(near).copied().collect();
        }
        for dz in 0..BLOCK {
            for dy in 0..BLOCK {
                for dx in 0..BLOCK {
                    let [x, y, z] = [block[0] * BLOCK + dx, block[1] * BLOCK + dy, block[2] * BLOCK + dz];
                    let value = if self.active[slot].is_empty() {
                        centre_value
                    } else {
                        flesh.blend(&self.point([x, y, z]), &self.active[slot])
                    };
                    let index = self.index([x, y, z]);
                    self.values[index] = value as f32;
                }
            }
        }
    }

    fn index(&self, at: [usize; 3]) -> usize {
        (at[2] * self.dims[1] + at[1]) * self.dims[0] + at[0]
    }

    fn point(&self, at: [usize; 3]) -> Vector3<f64> {
        self.origin + Vector3::from(at.map(|index| index as f64)) * self.cell
    }

    fn block_of(&self, at: [usize; 3]) -> &[usize] {
        let [bx, by, bz] = at.map(|index| index / BLOCK);
        &self.active[(bz * self.blocks[1] + by) * self.blocks[0] + bx]
    }

    /// The mean crossing of a cell's edges, in grid units from its low corner; `None` without crossing.
    fn cell_vertex(&self, at: [usize; 3]) -> Option<Vector3<f64>> {
        let corner = |bits: usize| [at[0] + (bits & 1), at[1] + (bits >> 1 & 1), at[2] + (bits >> 2)];
        let values: [f32; 8] = std::array::from_fn(|bits| self.values[self.index(corner(bits))]);
        let inside = values.iter().filter(|value| **value < 0.0).count();
        if inside == 0 || inside == 8 {
            return None;
        }
        let (mut sum, mut count) = (Vector3::zeros(), 0.0);
        for first in 0..8_usize {
            for axis in 0..3 {
                let second = first | 1 << axis;
                if second == first || (values[first] < 0.0) == (values[second] < 0.0) {
                    continue;
                }
                let t = f64::from(values[first] / (values[first] - values[second]));
                let mut offset =
                    Vector3::new((first & 1) as f64, (first >> 1 & 1) as f64, (first >> 2) as f64);
                offset[axis] += t;
                sum += offset;
                count += 1.0;
            }
        }
        Some(sum / count)
    }

    fn surface(&self, flesh: &Flesh) -> Surface {
        let all = flesh.all();
        let mut surface = Surface::default();
        let mut slots = vec![u32::MAX; self.values.len()];
        for z in 0..self.dims[2] - 1 {
            for y in 0..self.dims[1] - 1 {
                for x in 0..self.dims[0] - 1 {
                    let Some(offset) = self.cell_vertex([x, y, z]) else { continue };
                    let block = self.block_of([x, y, z]);
                    let active = if block.is_empty() { &all } else { block };
                    let mut p = self.point([x, y, z]) + offset * self.cell;
                    let mut normal = gradient(flesh, &p, active);
                    p -= normal * flesh.blend(&p, active).clamp(-self.cell, self.cell);
                    normal = gradient(flesh, &p, active);
                    slots[self.index([x, y, z])] = surface.vertices.len() as u32;
                    surface.vertices.push(p);
                    surface.normals.push(normal);
                }
            }
        }
        self.connect(&slots, &mut surface);
        surface
    }

    fn connect(&self, slots: &[u32], surface: &mut Surface) {
        for z in 1..self.dims[2] - 1 {
            for y in 1..self.dims[1] - 1 {
                for x in 1..self.dims[0] - 1 {
                    let here = self.values[self.index([x, y, z])] < 0.0;
                    for axis in 0..3 {
                        let mut next = [x, y, z];
                        next[axis] += 1;
                        if here == (self.values[self.index(next)] < 0.0) {
                            continue;
                        }
                        let quad = self.quad([x, y, z], axis).map(|at| slots[self.index(at)]);
                        if quad.contains(&u32::MAX) {
                            continue;
                        }
                        let [a, b, c, d] = quad;
                        let triangles = if here { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                        surface.triangles.extend(triangles);
                    }
                }
            }
        }
    }

    /// The four cells around the edge from `at` along `axis`, counter-clockwise seen from its end.
    fn quad(&self, at: [usize; 3], axis: usize) -> [[usize; 3]; 4] {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(du, dv)| {
            let mut cell = at;
            cell[u] -= du;
            cell[v] -= dv;
            cell
        })
    }
}

fn gradient(flesh: &Flesh, p: &Vector3<f64>, active: &[usize]) -> Vector3<f64> {
    const STEP: f64 = 4e-4;
    let mut normal = Vector3::zeros();
    for axis in 0..3 {
        let mut offset = Vector3::zeros();
        offset[axis] = STEP;
        normal[axis] = flesh.blend(&(p + offset), active) - flesh.blend(&(p - offset), active);
    }
    normal.try_normalize(1e-12).unwrap_or_else(Vector3::z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_closed_round_and_faces_outwards() {
        let centre = Vector3::new(0.01, -0.02, 0.03);
        let cone = Cone { a: centre, b: centre, ra: 0.02, rb: 0.02, group: 0, tag: 0 };
        let flesh = Flesh { cones: vec![cone], body_blend: 0.005, limb_blend: 0.005, join_blend: 0.005 };
        let surface = flesh.triangulate(0.003);
        let mut volume = 0.0;
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|index| surface.vertices[index as usize] - centre);
            volume += a.dot(&b.cross(&c)) / 6.0;
        }
        let expected = 4.0 / 3.0 * std::f64::consts::PI * 0.02_f64.powi(3);
        assert!((volume / expected - 1.0).abs() < 0.03, "{volume} {expected}");
        for (p, n) in surface.vertices.iter().zip(&surface.normals) {
            assert!(((p - centre).norm() - 0.02).abs() < 1e-4);
            assert!((p - centre).normalize().dot(n) > 0.999);
        }
    }
}
