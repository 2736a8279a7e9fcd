//! Fewer triangles, the same look at the size of a clip.

use std::collections::BTreeMap;

use meshopt::{SimplifyOptions, simplify_decoder};

/// Share of the triangles that is kept, where the error allows.
const SHARE: f64 = 0.1;
/// Meshes are never cut below this.
const FLOOR: usize = 200;
/// Largest deviation, as a share of the mesh's extent.
const ERROR: f32 = 0.02;

/// Quadric decimation to a tenth (Garland and Heckbert's error, as meshoptimizer computes it).
pub(super) fn decimate(triangles: &[[[f32; 3]; 3]]) -> Vec<[[f32; 3]; 3]> {
    let wanted = ((triangles.len() as f64 * SHARE) as usize).max(FLOOR);
    if triangles.len() <= wanted {
        return triangles.to_vec();
    }
    let mut numbers = BTreeMap::new();
    let mut vertices: Vec<[f32; 3]> = Vec::new();
    let mut indices = Vec::with_capacity(3 * triangles.len());
    for corner in triangles.iter().flatten() {
        // Adding zero makes one of -0.0 and 0.0.
        let key = corner.map(|value| (value + 0.0).to_bits());
        let number = *numbers.entry(key).or_insert_with(|| {
            vertices.push(*corner);
            vertices.len() as u32 - 1
        });
        indices.push(number);
    }
    let kept = simplify_decoder(&indices, &vertices, 3 * wanted, ERROR, SimplifyOptions::None, None);
    let (faces, _) = kept.as_chunks::<3>();
    if faces.is_empty() {
        return triangles.to_vec();
    }
    faces.iter().map(|face| face.map(|index| vertices[index as usize])).collect()
}
