//! Which pixels of the arms' mask are the left arm's and which the right one's.

use agenticfocus::{geometry::Side, image::Mask, segment::RleMask};

use super::Area;

/// The machine's split of the arms on one frame, drawn out to every pixel of the picture.
#[derive(Clone, Debug)]
pub struct SideSplit {
    left: Mask,
    right: Mask,
    /// Middles of both, where they have any pixels.
    middles: [Option<[f64; 2]>; 2],
}

impl SideSplit {
    /// From the masks of both arms, which have one size.
    pub fn new(left: &RleMask, right: &RleMask) -> Self {
        let (left, right) = (left.decode(), right.decode());
        let middle =
            |mask: &Mask| Area::of(mask).map(|a| [a.x0 + a.x1, a.y0 + a.y1].map(|v| f64::from(v) / 2.0));
        let middles = [middle(&left), middle(&right)];
        Self { left, right, middles }
    }

    /// The arm that a pixel belongs to; what neither claims is the nearer one's.
    pub fn side(&self, x: u32, y: u32) -> Side {
        if self.right.get(x, y) {
            return Side::Right;
        }
        if self.left.get(x, y) {
            return Side::Left;
        }
        let distance = |to: [f64; 2]| (to[0] - f64::from(x)).hypot(to[1] - f64::from(y));
        let right = match self.middles {
            [Some(left), Some(right)] => distance(right) < distance(left),
            [None, None] => 2 * x > self.left.size().width,
            [left, _] => left.is_none(),
        };
        if right { Side::Right } else { Side::Left }
    }

    /// The pixels of `mask` that belong to `side`.
    #[must_use]
    pub fn part(&self, mask: &Mask, side: Side) -> Mask {
        Mask::from_fn(mask.size(), |x, y| mask.get(x, y) && self.side(x, y) == side)
    }

    /// Gives back to `mask` what it lost within `area` of the arm that is not `side`.
    pub fn protect_other(&self, mask: &mut Mask, before: &Mask, area: Area, side: Side) {
        for y in area.y0..area.y1 {
            for x in area.x0..area.x1 {
                if before.get(x, y) && !mask.get(x, y) && self.side(x, y) != side {
                    mask.set(x, y, true);
                }
            }
        }
    }
}
