//! Mask operations, against what they promise for any input.

use agenticfocus::{
    geometry::{Pixel, PixelBox, Size},
    image::Mask,
};
use agenticfocus_ui::paint::{self, Area, Outline};
use proptest::prelude::*;

const SIZE: Size = Size::new(37, 29);

/// A mask of a few discs, some of which touch the border.
fn mask() -> impl Strategy<Value = Mask> {
    let disc = (-4.0..41.0, -4.0..33.0, 0.5..9.0, any::<bool>());
    prop::collection::vec(disc, 0..6).prop_map(|discs| {
        let mut mask = Mask::new(SIZE);
        for (x, y, radius, inside) in discs {
            paint::stroke(&mut mask, Pixel::new(x, y), Pixel::new(x, y), radius, inside);
        }
        mask
    })
}

/// A coordinate that may be anything.
fn hostile() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -60.0..100.0,
        1 => prop::num::f64::ANY,
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -1e300, 1e18]),
    ]
}

fn position() -> impl Strategy<Value = Pixel> {
    (hostile(), hostile()).prop_map(|(x, y)| Pixel::new(x, y))
}

fn distance_to_line(p: Pixel, a: Pixel, b: Pixel) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let length = dx * dx + dy * dy;
    let t = if length > 0.0 { ((p.x - a.x) * dx + (p.y - a.y) * dy) / length } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    p.distance(Pixel::new(a.x + t * dx, a.y + t * dy))
}

fn within(area: Area) -> bool {
    area.x0 < area.x1 && area.y0 < area.y1 && area.x1 <= SIZE.width && area.y1 <= SIZE.height
}

/// Pixels that differ.
fn changed(a: &Mask, b: &Mask) -> impl Iterator<Item = (u32, u32)> {
    let all = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
    all.filter(|(x, y)| a.get(*x, *y) != b.get(*x, *y))
}

/// Twice the area that closed lines enclose, holes taken off.
fn enclosed(lines: &[Outline]) -> i64 {
    let of = |line: &Outline| {
        let ends = line.corners.iter().zip(line.corners.iter().cycle().skip(1));
        ends.map(|(a, b)| i64::from(a[0]) * i64::from(b[1]) - i64::from(b[0]) * i64::from(a[1])).sum::<i64>()
    };
    lines.iter().map(of).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_stroke_is_every_pixel_within_its_radius(
        (ax, ay) in (-5.0..42.0, -5.0..34.0), (bx, by) in (-5.0..42.0, -5.0..34.0), radius in 0.8..9.0
    ) {
        let (a, b) = (Pixel::new(ax, ay), Pixel::new(bx, by));
        let mut mask = Mask::new(SIZE);
        paint::stroke(&mut mask, a, b, radius, true);
        for y in 0..SIZE.height {
            for x in 0..SIZE.width {
                let far = distance_to_line(Pixel::new(f64::from(x), f64::from(y)), a, b) - radius;
                prop_assert!(far.abs() < 1e-6 || mask.get(x, y) == (far < 0.0), "({x}, {y}) is {far} off");
            }
        }
    }

    #[test]
    fn taking_away_what_was_added_leaves_the_old_mask_beside_it(
        old in mask(), a in position(), b in position(), radius in 0.5..9.0
    ) {
        let mut new = old.clone();
        let added = paint::stroke(&mut new, a, b, radius, true);
        paint::stroke(&mut new, a, b, radius, false);
        let mut footprint = Mask::new(SIZE);
        paint::stroke(&mut footprint, a, b, radius, true);
        prop_assert_eq!(new, old.minus(&footprint));
        prop_assert_eq!(added.is_none() && !footprint.is_empty(), false);
    }

    #[test]
    fn nothing_leaves_the_picture_and_nothing_outside_the_told_area_changes(
        old in mask(), points in prop::collection::vec(position(), 0..7), radius in hostile(), inside in any::<bool>()
    ) {
        let first = points.first().copied().unwrap_or_default();
        let last = points.last().copied().unwrap_or_default();
        let given = PixelBox { x0: first.x, y0: first.y, x1: last.x, y1: last.y };
        for shape in 0..3 {
            let mut new = old.clone();
            let area = match shape {
                0 => paint::stroke(&mut new, first, last, radius, inside),
                1 => paint::fill_polygon(&mut new, &points, inside),
                _ => paint::fill_box(&mut new, &given, inside),
            };
            prop_assert!(area.is_none_or(within));
            for (x, y) in changed(&old, &new) {
                let told = area.is_some_and(|a| (a.x0..a.x1).contains(&x) && (a.y0..a.y1).contains(&y));
                prop_assert!(told, "({}, {}) changed outside {:?}", x, y, area);
            }
        }
    }

    #[test]
    fn filling_holes_twice_is_filling_them_once(old in mask()) {
        let mut once = old.clone();
        paint::fill_holes(&mut once);
        prop_assert_eq!(once.union(&old), once.clone());
        let mut twice = once.clone();
        paint::fill_holes(&mut twice);
        prop_assert_eq!(twice, once);
    }

    #[test]
    fn growing_is_exact_and_shrinking_is_growing_the_outside(old in mask(), radius in 0_u32..6) {
        let (grown, shrunk) = (paint::grow(&old, radius), paint::shrink(&old, radius));
        let near = |x: u32, y: u32, inside: bool| {
            let reach = i64::from(radius);
            (-reach..=reach).any(|dy| (-reach..=reach).any(|dx| {
                let (u, v) = (i64::from(x) + dx, i64::from(y) + dy);
                let there = u >= 0 && v >= 0 && u < i64::from(SIZE.width) && v < i64::from(SIZE.height);
                there && dx * dx + dy * dy <= reach * reach && old.get(u as u32, v as u32) == inside
            }))
        };
        for y in 0..SIZE.height {
            for x in 0..SIZE.width {
                prop_assert_eq!(grown.get(x, y), near(x, y, true));
                prop_assert_eq!(shrunk.get(x, y), !near(x, y, false));
            }
        }
        // Closing keeps the mask, opening adds nothing.
        prop_assert_eq!(paint::shrink(&grown, radius).union(&old), paint::shrink(&grown, radius));
        prop_assert_eq!(paint::grow(&shrunk, radius).minus(&old).area(), 0);
    }

    #[test]
    fn the_outline_encloses_exactly_the_mask(old in mask()) {
        let lines = paint::outline(&old);
        prop_assert_eq!(enclosed(&lines), 2 * old.area() as i64);
        prop_assert!(lines.iter().all(|line| old.get(line.inside[0], line.inside[1])));
    }
}

#[test]
fn a_polygon_takes_the_pixels_whose_centres_it_encloses() {
    let corners = [(1.5, 1.5), (5.5, 1.5), (5.5, 4.5), (1.5, 4.5)].map(|(x, y)| Pixel::new(x, y));
    let mut mask = Mask::new(SIZE);
    paint::fill_polygon(&mut mask, &corners, true);
    assert_eq!(mask, Mask::from_fn(SIZE, |x, y| (2..6).contains(&x) && (2..5).contains(&y)));
    // Twice around is outside again.
    let twice: Vec<Pixel> = corners.iter().chain(&corners).copied().collect();
    let mut even = Mask::new(SIZE);
    paint::fill_polygon(&mut even, &twice, true);
    assert!(even.is_empty());
}

#[test]
fn a_ring_is_filled_and_a_bay_is_not() {
    let ring = |x: u32, y: u32| {
        (5..15).contains(&x) && (5..15).contains(&y) && !((8..12).contains(&x) && (8..12).contains(&y))
    };
    let mut mask = Mask::from_fn(SIZE, |x, y| ring(x, y) || (x > 20 && !(y == 10 && x > 25)));
    paint::fill_holes(&mut mask);
    assert!(mask.get(10, 10), "the ring's hole");
    assert!(!mask.get(30, 10), "a bay open to the picture's border");
}

#[test]
fn a_thin_fast_stroke_has_no_gaps() {
    let mut mask = Mask::new(SIZE);
    paint::stroke(&mut mask, Pixel::new(0.3, 0.4), Pixel::new(35.7, 27.1), 0.1, true);
    for x in 1..35 {
        assert!((0..SIZE.height).any(|y| mask.get(x, y)), "column {x} is empty");
    }
}
