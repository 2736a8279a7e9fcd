//! Binary segmentation as a convex problem: data costs plus edge-weighted total variation.
//!
//! Minimises `Σ cost·u + Σ g |∇u|` over `u ∈ [0, 1]`; every threshold of the minimiser is a global
//! optimum of the binary problem (Chan, Esedoglu & Nikolova 2006), found by the primal-dual scheme
//! of Chambolle & Pock 2011. Unlike a discrete cut it has no grid bias and is warm-startable.

use super::Plane;

/// Edge weights of a colour picture: `weight` in flat areas, falling across colour edges.
#[derive(Clone, Debug)]
pub struct EdgeWeights {
    /// Towards the right neighbour.
    pub right: Vec<f32>,
    /// Towards the lower neighbour.
    pub down: Vec<f32>,
}

impl EdgeWeights {
    /// Contrast-sensitive weights `weight · (floor + (1 − floor)·exp(−d² / 2σ²))` where `d` is the
    /// colour distance of neighbours and σ² the mean of `d²` over the picture (as GrabCut's β).
    pub fn from_colours(colours: &[[u8; 3]], width: usize, height: usize, weight: f32) -> Self {
        let distance = |a: usize, b: usize| -> f32 {
            let squared = |c: usize| f32::from(colours[a][c]) - f32::from(colours[b][c]);
            (0..3).map(|c| squared(c) * squared(c)).sum()
        };
        let mut right = vec![0.0; width * height];
        let mut down = vec![0.0; width * height];
        let (mut sum, mut count) = (0.0_f64, 0_u32);
        for y in 0..height {
            for x in 0..width {
                let at = y * width + x;
                if x + 1 < width {
                    right[at] = distance(at, at + 1);
                    sum += f64::from(right[at]);
                    count += 1;
                }
                if y + 1 < height {
                    down[at] = distance(at, at + width);
                    sum += f64::from(down[at]);
                    count += 1;
                }
            }
        }
        let scale = -0.5 / (sum / f64::from(count.max(1))).max(4.0) as f32;
        let floor = 0.06;
        for value in right.iter_mut().chain(down.iter_mut()) {
            *value = weight * (floor + (1.0 - floor) * (*value * scale).exp());
        }
        Self { right, down }
    }
}

/// Solves for `u` from the start value `u` (in [0, 1]); `cost` is negative where inside is likely.
pub fn tv_cut(u: &mut Plane, cost: &[f32], edges: &EdgeWeights, iterations: usize) {
    let (width, height) = (u.width, u.height);
    let mut lead = u.data.clone();
    let mut dual_x = vec![0.0_f32; width * height];
    let mut dual_y = vec![0.0_f32; width * height];
    let still = vec![0.0_f32; width];
    for _ in 0..iterations {
        ascend(&lead, [&mut dual_x, &mut dual_y], edges, (width, height));
        for y in 0..height {
            let row = y * width..(y + 1) * width;
            let above = if y == 0 { &still[..] } else { &dual_y[(y - 1) * width..y * width] };
            let duals = [&dual_x[row.clone()], &dual_y[row.clone()], above];
            descend(&mut u.data[row.clone()], &mut lead[row.clone()], duals, &cost[row]);
        }
    }
}

/// Length of the primal and of the dual step.
const STEP: f32 = 0.35;

/// `f32::clamp` without its check, which would keep the loops from running on several pixels at once.
fn limited(value: f32, least: f32, most: f32) -> f32 {
    if value < least {
        least
    } else if value > most {
        most
    } else {
        value
    }
}

/// One primal step along a row, from the duals to the right and down of it and those from above.
fn descend(u: &mut [f32], lead: &mut [f32], [right, down, above]: [&[f32]; 3], cost: &[f32]) {
    let step = |u: &mut f32, lead: &mut f32, divergence: f32, cost: f32| {
        let old = *u;
        let new = limited(old + STEP * (divergence - cost), 0.0, 1.0);
        *u = new;
        *lead = 2.0 * new - old;
    };
    let width = u.len();
    if width == 0 {
        return;
    }
    step(&mut u[0], &mut lead[0], right[0] + down[0] - above[0], cost[0]);
    let left = &right[..width - 1];
    let rest = u[1..].iter_mut().zip(&mut lead[1..]).zip(left).zip(&right[1..]);
    let rest = rest.zip(&down[1..]).zip(&above[1..]).zip(&cost[1..]);
    for ((((((u, lead), left), right), down), above), cost) in rest {
        step(u, lead, right + down - left - above, *cost);
    }
}

/// One dual step, projected onto `|p| <= g` edge by edge.
fn ascend(
    lead: &[f32],
    [dual_x, dual_y]: [&mut [f32]; 2],
    edges: &EdgeWeights,
    (width, height): (usize, usize),
) {
    for y in 0..height {
        let row = y * width..(y + 1) * width;
        let here = &lead[row.clone()];
        let next = here.iter().skip(1);
        let along = dual_x[row.clone()].iter_mut().zip(&edges.right[row.clone()]).zip(here).zip(next);
        for (((dual, limit), here), next) in along {
            *dual = limited(*dual + STEP * (next - here), -limit, *limit);
        }
        if y + 1 < height {
            let below = &lead[(y + 1) * width..(y + 2) * width];
            let down = dual_y[row.clone()].iter_mut().zip(&edges.down[row]).zip(here).zip(below);
            for (((dual, limit), here), below) in down {
                *dual = limited(*dual + STEP * (below - here), -limit, *limit);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cut_follows_the_colour_edge_and_fills_weak_spots() {
        let (width, height) = (40, 30);
        let inside = |x: usize, y: usize| (10..30).contains(&x) && (8..22).contains(&y);
        let colours: Vec<[u8; 3]> = (0..width * height)
            .map(|at| if inside(at % width, at / width) { [200, 60, 60] } else { [60, 60, 200] })
            .collect();
        let cost: Vec<f32> = (0..width * height)
            .map(|at| {
                let (x, y) = (at % width, at / width);
                let hole = x == 20 && y == 15;
                if inside(x, y) && !hole { -1.0 } else { 1.0 }
            })
            .collect();
        let edges = EdgeWeights::from_colours(&colours, width, height, 1.0);
        let mut u = Plane::zeros(width, height);
        tv_cut(&mut u, &cost, &edges, 150);
        for y in 0..height {
            for x in 0..width {
                assert_eq!(u.at(x, y) > 0.5, inside(x, y), "at {x}, {y}: {}", u.at(x, y));
            }
        }
    }
}
