//! All frames of a run at once: Levenberg–Marquardt over every pose and, if wanted, the hand's shape.
//!
//! Poses couple only to the two frames before (second differences), so the normal equations are
//! block-banded; the shape couples to all and is eliminated last (an arrowhead system).

use nalgebra::{Cholesky, Const, SMatrix};

use super::{
    kinematics::{HandPose, POSE_DOF, PoseVector},
    priors::acceleration_spread,
    shape::{HandShape, SHAPE_DOF, ShapeVector},
    terms::{Normal, Sight, cost, normal},
};

type Block = SMatrix<f64, POSE_DOF, POSE_DOF>;
type Factor = Cholesky<f64, Const<POSE_DOF>>;
/// Right-hand sides: the gradient, then the shape's columns.
type Sides = SMatrix<f64, POSE_DOF, { SHAPE_DOF + 1 }>;

/// A frame in the batch.
#[derive(Clone, Debug)]
pub(super) struct BatchFrame {
    pub pose: HandPose,
    /// What was seen; `None` where the frame is to be bridged.
    pub sight: Option<Sight>,
    /// Frames right before this one that belong to the same run, at most 2.
    pub predecessors: usize,
    /// Kept as it is: the end of the run fitted before.
    pub fixed: bool,
}

/// Prior of the hand's shape.
#[derive(Clone, Debug)]
pub(super) struct ShapePrior {
    /// Mean.
    pub mean: HandShape,
    /// Spread of base points, metres.
    pub base_sigma: f64,
    /// Relative spread of bones.
    pub bone_sigma: f64,
    /// Relative spread of the hand's whole length.
    pub length_sigma: f64,
    /// How often the prior counts against one count of every frame.
    pub weight: f64,
}

impl ShapePrior {
    fn add(
        &self,
        shape: &HandShape,
        gradient: &mut ShapeVector,
        hessian: &mut SMatrix<f64, SHAPE_DOF, SHAPE_DOF>,
    ) {
        let off = shape.difference(&self.mean);
        for k in 0..SHAPE_DOF {
            let precision = self.precision(k);
            gradient[k] += off[k] * precision;
            hessian[(k, k)] += precision;
        }
        let slope = shape.length_gradient() * self.weight.sqrt() / (self.mean.length() * self.length_sigma);
        *gradient += slope * self.length_residual(shape);
        *hessian += slope * slope.transpose();
    }

    fn cost(&self, shape: &HandShape) -> f64 {
        let off = shape.difference(&self.mean);
        let parts: f64 = (0..SHAPE_DOF).map(|k| off[k] * off[k] * self.precision(k)).sum();
        0.5 * (parts + self.length_residual(shape).powi(2))
    }

    fn precision(&self, k: usize) -> f64 {
        let sigma = if k < 15 { self.base_sigma } else { self.bone_sigma };
        self.weight / (sigma * sigma)
    }

    fn length_residual(&self, shape: &HandShape) -> f64 {
        (shape.length() / self.mean.length() - 1.0) * self.weight.sqrt() / self.length_sigma
    }
}

/// Fits all frames; the shape too where `prior` is given.
pub(super) fn refine_all(
    shape: &mut HandShape,
    frames: &mut [BatchFrame],
    prior: Option<&ShapePrior>,
    iterations: usize,
) {
    let mut damping = 1e-3;
    let mut now = total_cost(shape, frames, prior);
    for _ in 0..iterations {
        let terms: Vec<Normal> =
            frames.iter().map(|f| normal(shape, &f.pose, f.sight.as_ref(), prior.is_some())).collect();
        let before = now;
        let mut improved = false;
        for _ in 0..5 {
            let Some((steps, shape_step)) = solve(shape, frames, &terms, prior, damping) else {
                damping *= 10.0;
                continue;
            };
            let candidate_shape = shape.stepped(&shape_step);
            let mut candidate: Vec<BatchFrame> = frames.to_vec();
            for (frame, step) in candidate.iter_mut().zip(&steps) {
                if !frame.fixed {
                    frame.pose = frame.pose.stepped(step);
                }
            }
            let value = total_cost(&candidate_shape, &candidate, prior);
            if value < now {
                for (frame, new) in frames.iter_mut().zip(candidate) {
                    frame.pose = new.pose;
                }
                (*shape, now, improved) = (candidate_shape, value, true);
                damping = (damping * 0.2).max(1e-8);
                break;
            }
            damping *= 8.0;
        }
        if !improved || before - now < 2e-5 * now {
            return;
        }
    }
}

fn acceleration(frames: &[BatchFrame], index: usize) -> Option<PoseVector> {
    (frames[index].predecessors >= 2).then(|| {
        let [a, b, c] = [&frames[index - 2].pose, &frames[index - 1].pose, &frames[index].pose];
        c.difference(b) - b.difference(a)
    })
}

fn total_cost(shape: &HandShape, frames: &[BatchFrame], prior: Option<&ShapePrior>) -> f64 {
    let spread = acceleration_spread();
    let mut total = prior.map_or(0.0, |p| p.cost(shape));
    for (index, frame) in frames.iter().enumerate() {
        total += cost(shape, &frame.pose, frame.sight.as_ref());
        if let Some(acceleration) = acceleration(frames, index) {
            total += 0.5 * acceleration.component_div(&spread).norm_squared();
        }
    }
    total
}

/// The banded system: diagonal blocks and, diagonal in themselves, the couplings to one and two
/// frames before.
struct Banded {
    diagonal: Vec<Block>,
    first: Vec<PoseVector>,
    second: Vec<PoseVector>,
    sides: Vec<Sides>,
}

fn assemble(frames: &[BatchFrame], terms: &[Normal], damping: f64) -> Banded {
    let precision = acceleration_spread().map(|s| 1.0 / (s * s));
    let count = frames.len();
    let mut banded = Banded {
        diagonal: terms.iter().map(|t| t.hessian).collect(),
        first: vec![PoseVector::zeros(); count],
        second: vec![PoseVector::zeros(); count],
        sides: Vec::with_capacity(count),
    };
    let mut gradients: Vec<PoseVector> = terms.iter().map(|t| t.gradient).collect();
    for index in 0..count {
        let Some(acceleration) = acceleration(frames, index) else { continue };
        let pull = acceleration.component_mul(&precision);
        for (back, factor) in [(0, 1.0), (1, -2.0), (2, 1.0)] {
            gradients[index - back] += pull * factor;
            for k in 0..POSE_DOF {
                banded.diagonal[index - back][(k, k)] += precision[k] * factor * factor;
            }
        }
        banded.first[index] += precision * -2.0;
        banded.first[index - 1] += precision * -2.0;
        banded.second[index] += precision;
    }
    for (index, frame) in frames.iter().enumerate() {
        let diagonal = &mut banded.diagonal[index];
        for k in 0..POSE_DOF {
            diagonal[(k, k)] += damping * diagonal[(k, k)] + if frame.fixed { 1e14 } else { 1e-9 };
        }
        let mut sides = Sides::zeros();
        sides.set_column(0, &-gradients[index]);
        sides.fixed_view_mut::<POSE_DOF, SHAPE_DOF>(0, 1).copy_from(&terms[index].cross);
        banded.sides.push(sides);
    }
    banded
}

/// One damped step for all poses and the shape; `None` when the system is not positive.
fn solve(
    shape: &HandShape,
    frames: &[BatchFrame],
    terms: &[Normal],
    prior: Option<&ShapePrior>,
    damping: f64,
) -> Option<(Vec<PoseVector>, ShapeVector)> {
    let banded = assemble(frames, terms, damping);
    let Some(prior) = prior else {
        let solution = solve_banded::<1>(&banded, |s| s.fixed_columns::<1>(0).into_owned())?;
        return Some((solution, ShapeVector::zeros()));
    };
    let solution = solve_banded::<{ SHAPE_DOF + 1 }>(&banded, |s| *s)?;
    let mut gradient = ShapeVector::zeros();
    let mut hessian = SMatrix::<f64, SHAPE_DOF, SHAPE_DOF>::zeros();
    for term in terms {
        gradient += term.shape_gradient;
        hessian += term.shape_hessian;
    }
    prior.add(shape, &mut gradient, &mut hessian);
    for k in 0..SHAPE_DOF {
        hessian[(k, k)] *= 1.0 + damping;
    }
    let mut right = -gradient;
    for (term, x) in terms.iter().zip(&solution) {
        right -= term.cross.tr_mul(&x.fixed_columns::<1>(0));
        hessian -= term.cross.tr_mul(&x.fixed_columns::<SHAPE_DOF>(1));
    }
    let hessian = (hessian + hessian.transpose()) * 0.5;
    let shape_step = hessian.cholesky()?.solve(&right);
    let steps = solution
        .iter()
        .map(|x| x.fixed_columns::<1>(0) - x.fixed_columns::<SHAPE_DOF>(1) * shape_step)
        .collect();
    Some((steps, shape_step))
}

/// Block Cholesky of the banded matrix and its solution for `N` right-hand sides.
fn solve_banded<const N: usize>(
    banded: &Banded,
    side: impl Fn(&Sides) -> SMatrix<f64, POSE_DOF, N>,
) -> Option<Vec<SMatrix<f64, POSE_DOF, N>>> {
    let count = banded.diagonal.len();
    let mut factors: Vec<Factor> = Vec::with_capacity(count);
    let mut first: Vec<Block> = Vec::with_capacity(count);
    let mut second: Vec<Block> = Vec::with_capacity(count);
    let mut solution: Vec<SMatrix<f64, POSE_DOF, N>> = Vec::with_capacity(count);
    for index in 0..count {
        let mut diagonal = banded.diagonal[index];
        let mut right = side(&banded.sides[index]);
        let (mut l1, mut l2) = (Block::zeros(), Block::zeros());
        if index >= 2 && banded.second[index][0] != 0.0 {
            l2 = over(&Block::from_diagonal(&banded.second[index]), &factors[index - 2]);
            diagonal -= l2 * l2.transpose();
            right -= l2 * solution[index - 2];
        }
        if index >= 1 && banded.first[index][0] != 0.0 {
            let mut coupling = Block::from_diagonal(&banded.first[index]);
            coupling -= l2 * first[index - 1].transpose();
            l1 = over(&coupling, &factors[index - 1]);
            diagonal -= l1 * l1.transpose();
            right -= l1 * solution[index - 1];
        }
        let factor = diagonal.cholesky()?;
        factor.l_dirty().solve_lower_triangular_mut(&mut right);
        factors.push(factor);
        first.push(l1);
        second.push(l2);
        solution.push(right);
    }
    for index in (0..count).rev() {
        let mut right = solution[index];
        if index + 1 < count {
            right -= first[index + 1].tr_mul(&solution[index + 1]);
        }
        if index + 2 < count {
            right -= second[index + 2].tr_mul(&solution[index + 2]);
        }
        factors[index].l_dirty().tr_solve_lower_triangular_mut(&mut right);
        solution[index] = right;
    }
    Some(solution)
}

/// `coupling · L⁻ᵀ`.
fn over(coupling: &Block, factor: &Factor) -> Block {
    let mut transposed = coupling.transpose();
    factor.l_dirty().solve_lower_triangular_mut(&mut transposed);
    transposed.transpose()
}
