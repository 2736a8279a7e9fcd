//! Link shapes: smooth solids drawn through a few cross-sections.

use super::RobotError;

/// Points around a cross-section.
const AROUND: usize = 24;
/// Rings between two given cross-sections.
const BETWEEN: usize = 3;
/// Rings of a rounded end.
const CAP: usize = 4;

/// One cross-section, millimetres: where it lies along the axis, its centre on the other two axes, its half-widths.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Section {
    along: f64,
    centre: [f64; 2],
    half: [f64; 2],
}

/// A solid through cross-sections that stand square to one axis of the link.
///
/// Written as `<loft class="…" axis="x" square="2.4" round="4 6" at="t u v a b; …"/>`: `axis` runs through the
/// sections; `u`, `v` are the next two axes in cyclic order; sections are superellipses with exponent `square`
/// (2 an ellipse, more is boxier); `round` is how far a rounded end bulges beyond the first and the last section.
/// Millimetres throughout.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Loft {
    axis: usize,
    square: f64,
    round: [f64; 2],
    sections: Vec<Section>,
}

/// A closed triangle mesh, metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct LoftMesh {
    pub(super) vertices: Vec<[f64; 3]>,
    pub(super) faces: Vec<[usize; 3]>,
}

impl Loft {
    /// Reads the attributes of a `<loft …/>` element.
    pub(super) fn parse(element: &str) -> Result<Self, RobotError> {
        let broken = |what: &str| RobotError::Embedded(format!("{what} in {element}"));
        let numbers = |text: &str| -> Result<Vec<f64>, RobotError> {
            text.split_whitespace().map(|n| n.parse().map_err(|_| broken("no number"))).collect()
        };
        let axis = match attribute(element, "axis") {
            Some("x") => 0,
            Some("y") => 1,
            Some("z") => 2,
            _ => return Err(broken("axis is none of x, y, z")),
        };
        let square = numbers(attribute(element, "square").unwrap_or("2"))?;
        let round = numbers(attribute(element, "round").unwrap_or("0 0"))?;
        let (&[square], &[start, end]) = (&square[..], &round[..]) else {
            return Err(broken("square wants one number and round two"));
        };
        let mut sections = Vec::new();
        for section in attribute(element, "at").ok_or_else(|| broken("no sections"))?.split(';') {
            let &[along, u, v, a, b] = &numbers(section)?[..] else {
                return Err(broken("a section wants five numbers"));
            };
            sections.push(Section { along, centre: [u, v], half: [a, b] });
        }
        if sections.len() < 2 || sections.windows(2).any(|pair| pair[1].along <= pair[0].along) {
            return Err(broken("expected two or more sections in rising order"));
        }
        Ok(Self { axis, square, round: [start, end], sections })
    }

    /// The solid, with coordinates along the axes in `flip` mirrored.
    pub(super) fn mesh(&self, flip: [bool; 3]) -> LoftMesh {
        let rings = self.rings();
        let mut mesh = LoftMesh::default();
        for ring in &rings {
            mesh.vertices.extend(self.ring_points(ring));
        }
        for ring in 0..rings.len() - 1 {
            for step in 0..AROUND {
                let (here, next) = (ring * AROUND + step, ring * AROUND + (step + 1) % AROUND);
                mesh.faces.push([here, next, next + AROUND]);
                mesh.faces.push([here, next + AROUND, here + AROUND]);
            }
        }
        self.close(&mut mesh, &rings[0], false);
        self.close(&mut mesh, &rings[rings.len() - 1], true);
        for (axis, flipped) in flip.into_iter().enumerate() {
            if flipped {
                mesh.vertices.iter_mut().for_each(|vertex| vertex[axis] = -vertex[axis]);
                mesh.faces.iter_mut().for_each(|face| face.swap(0, 1));
            }
        }
        mesh
    }

    /// A flat lid with a rim of its own, so that the edge stays sharp.
    fn close(&self, mesh: &mut LoftMesh, ring: &Section, upper: bool) {
        let rim = mesh.vertices.len();
        mesh.vertices.extend(self.ring_points(ring));
        let centre = mesh.vertices.len();
        mesh.vertices.push(self.point(ring, [0.0, 0.0]));
        for step in 0..AROUND {
            let (here, next) = (rim + step, rim + (step + 1) % AROUND);
            mesh.faces.push(if upper { [here, next, centre] } else { [next, here, centre] });
        }
    }

    /// The given sections, those between them, and the rounded ends.
    fn rings(&self) -> Vec<Section> {
        let last = self.sections.len() - 1;
        let mut rings: Vec<Section> = cap(self.sections[0], -self.round[0]).into_iter().rev().collect();
        for index in 0..last {
            let around = [index.saturating_sub(1), index, index + 1, (index + 2).min(last)];
            let control = around.map(|i| self.sections[i]);
            for step in 0..BETWEEN {
                rings.push(catmull_rom(&control, step as f64 / BETWEEN as f64));
            }
        }
        rings.push(self.sections[last]);
        rings.extend(cap(self.sections[last], self.round[1]));
        rings
    }

    fn ring_points(&self, ring: &Section) -> impl Iterator<Item = [f64; 3]> {
        let power = 2.0 / self.square;
        (0..AROUND).map(move |step| {
            let (sin, cos) = (std::f64::consts::TAU * step as f64 / AROUND as f64).sin_cos();
            let bent = |value: f64| value.signum() * value.abs().powf(power);
            self.point(ring, [bent(cos), bent(sin)])
        })
    }

    fn point(&self, ring: &Section, unit: [f64; 2]) -> [f64; 3] {
        let mut point = [0.0; 3];
        point[self.axis] = ring.along / 1000.0;
        for (k, unit) in unit.into_iter().enumerate() {
            point[(self.axis + 1 + k) % 3] = (ring.centre[k] + ring.half[k] * unit) / 1000.0;
        }
        point
    }
}

/// A quarter of an ellipse from `section` outwards, without the section itself.
fn cap(section: Section, bulge: f64) -> Vec<Section> {
    if bulge == 0.0 {
        return Vec::new();
    }
    (1..=CAP)
        .map(|step| {
            // Short of the pole: the lid closes what is left.
            let (sin, cos) = (1.45 * step as f64 / CAP as f64).sin_cos();
            Section { along: section.along + bulge * sin, half: section.half.map(|h| h * cos), ..section }
        })
        .collect()
}

/// Between `control[1]` and `control[2]`: half-widths and centre on a Catmull–Rom curve, position straight.
fn catmull_rom(control: &[Section; 4], t: f64) -> Section {
    let blend = |p: [f64; 4]| {
        let slope = [0.5 * (p[2] - p[0]), 0.5 * (p[3] - p[1])];
        let (t2, t3) = (t * t, t * t * t);
        (2.0 * t3 - 3.0 * t2 + 1.0) * p[1]
            + (t3 - 2.0 * t2 + t) * slope[0]
            + (3.0 * t2 - 2.0 * t3) * p[2]
            + (t3 - t2) * slope[1]
    };
    Section {
        along: control[1].along + t * (control[2].along - control[1].along),
        centre: [0, 1].map(|k| blend(control.map(|section| section.centre[k]))),
        half: [0, 1].map(|k| blend(control.map(|section| section.half[k]))),
    }
}

impl LoftMesh {
    /// As an MJCF mesh asset called `name`.
    pub(super) fn to_mjcf(&self, name: &str) -> String {
        use std::fmt::Write as _;
        let mut xml = format!("<mesh name=\"{name}\" vertex=\"");
        for [x, y, z] in &self.vertices {
            let _ = write!(xml, "{x:.6} {y:.6} {z:.6} ");
        }
        xml.push_str("\" face=\"");
        for [a, b, c] in &self.faces {
            let _ = write!(xml, "{a} {b} {c} ");
        }
        xml.push_str("\"/>\n");
        xml
    }
}

/// The value of `name="…"` in an element.
pub(super) fn attribute<'a>(element: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = element.split_once(&format!(" {name}=\""))?;
    Some(rest.split_once('"')?.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(mesh: &LoftMesh) -> f64 {
        let at = |i: usize| nalgebra::Vector3::from(mesh.vertices[i]);
        mesh.faces.iter().map(|f| at(f[0]).dot(&at(f[1]).cross(&at(f[2]))) / 6.0).sum()
    }

    #[test]
    fn a_straight_loft_has_the_volume_of_its_cylinder_and_faces_outwards() {
        let loft = Loft::parse(r#"<loft axis="y" at="0 3 4 10 10; 20 3 4 10 10"/>"#).unwrap();
        let expected = std::f64::consts::PI * 0.01_f64.powi(2) * 0.02;
        for flip in [[false; 3], [false, true, false], [true, true, false], [true; 3]] {
            let found = volume(&loft.mesh(flip));
            assert!((found / expected - 1.0).abs() < 0.03, "{found} against {expected}");
        }
    }

    #[test]
    fn every_edge_of_the_walls_is_shared_and_ends_bulge_as_asked() {
        let loft =
            Loft::parse(r#"<loft axis="z" round="2 5" at="0 0 0 8 6; 10 0 0 9 6; 30 1 0 5 5"/>"#).unwrap();
        let mesh = loft.mesh([false; 3]);
        let top = mesh.vertices.iter().map(|v| v[2]).fold(f64::MIN, f64::max);
        assert!((top - 0.035).abs() < 1e-4, "{top}");
        assert!(mesh.faces.iter().flatten().all(|index| *index < mesh.vertices.len()));
    }

    #[test]
    fn broken_sections_are_named() {
        for text in
            [r#"<loft axis="w" at="0 0 0 1 1; 1 0 0 1 1"/>"#, r#"<loft axis="x" at="0 0 0 1; 1 0 0 1 1"/>"#]
        {
            assert!(Loft::parse(text).unwrap_err().to_string().contains("loft"));
        }
    }
}
