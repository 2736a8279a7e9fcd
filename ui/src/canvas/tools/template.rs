//! The template placed on a frame, with handles that move, turn and scale it.

use std::sync::Arc;

use agenticfocus::{clip::FrameIndex, geometry::Pixel, session::Command, template::TemplateTrack};
use egui::{Color32, ColorImage, CursorIcon, Mesh, Pos2, Shape, Vec2, pos2, vec2};
use nalgebra::Matrix3;

use super::{
    super::{
        scene::Scene,
        shapes::{self, LineStyle},
        texture::Texture,
    },
    held::{Follow, Held},
    placement,
};
use crate::{
    action::Action,
    state::{Context, Workspace},
};

/// How near the pointer must be to a handle, points.
const HIT: f32 = 10.0;
/// How far the handle that turns stands off, points.
const STEM: f32 = 28.0;
/// Pieces a side that the picture is drawn in: perspective is not straight.
const PIECES: u32 = 8;

/// What a drag does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Grip {
    Move,
    Scale,
    Turn,
}

#[derive(Clone, Copy, Debug)]
struct Drag {
    grip: Grip,
    from: Pixel,
    /// The middle when the drag began.
    centre: Pixel,
    before: Matrix3<f64>,
    now: Matrix3<f64>,
}

/// The tools of this step.
#[derive(Debug, Default)]
pub(in super::super) struct TemplateTools {
    texture: Texture,
    shown: Option<(Arc<TemplateTrack>, [Pixel; 4])>,
    drag: Held<Drag>,
}

/// Who put the template where it lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum PlacedBy {
    /// The machine.
    Machine,
    /// A person, on this frame.
    Keyframe,
    /// A person, on these frames around it.
    Between(FrameIndex, FrameIndex),
}

/// Where the template lies on `frame`, and who put it there.
pub(in super::super) fn placed(workspace: &Workspace, frame: FrameIndex) -> Option<(Matrix3<f64>, PlacedBy)> {
    let track = workspace.found.template.as_ref()?;
    if let Some(set) = track.by_hand(&workspace.document().template, frame) {
        let by = set.between.map_or(PlacedBy::Keyframe, |(first, last)| PlacedBy::Between(first, last));
        return Some((set.transform, by));
    }
    Some((track.placements.get(frame.as_usize())?.as_ref()?.transform, PlacedBy::Machine))
}

impl TemplateTools {
    /// Carries out what the pointer did and draws.
    pub fn show(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>) {
        let Some(template) = scene.workspace.found.template.clone() else { return };
        let corners = self.corners(&template, scene);
        for (frame, drag) in self.drag.follow(scene, |at, _| grab(at, &corners, scene, cx)) {
            if drag.now != drag.before {
                cx.ask(Action::Change(Command::SetPlacement { frame, transform: Some(drag.now) }));
            }
        }
        let held = self.drag.get().map(|drag| (drag.now, PlacedBy::Keyframe));
        let now = held.or_else(|| placed(scene.workspace, scene.frame));
        if let Some((transform, by)) = now.filter(|_| !scene.hidden) {
            self.draw(&transform, by, &corners, scene, cx);
        }
    }

    fn corners(&mut self, template: &Arc<TemplateTrack>, scene: &Scene<'_>) -> [Pixel; 4] {
        if let Some((shown, corners)) = &self.shown
            && Arc::ptr_eq(shown, template)
        {
            return *corners;
        }
        let size = template.picture.size();
        let extent = [size.width as usize, size.height as usize];
        let image = ColorImage::from_rgba_unmultiplied(extent, template.picture.data());
        self.texture.write(scene.painter.ctx(), "template", image, false);
        let corners = placement::frame_of(template);
        self.shown = Some((Arc::clone(template), corners));
        corners
    }

    /// Drops a drag; false when there was none.
    pub fn cancel(&mut self) -> bool {
        self.drag.cancel()
    }

    fn draw(
        &self,
        transform: &Matrix3<f64>,
        by: PlacedBy,
        corners: &[Pixel; 4],
        scene: &Scene<'_>,
        cx: &Context<'_>,
    ) {
        if let (Some(id), Some((template, _))) = (self.texture.id(), &self.shown) {
            let size = template.picture.size();
            let extent = vec2(size.width as f32, size.height as f32);
            let place = |share: Vec2| {
                let at = share * extent;
                let at = Pixel::new(f64::from(at.x) - 0.5, f64::from(at.y) - 0.5);
                scene.projection.to_screen(placement::apply(transform, at))
            };
            scene.painter.add(Shape::mesh(warped(id, place)));
        }
        let on_screen = corners.map(|at| scene.projection.to_screen(placement::apply(transform, at)));
        let style = LineStyle { width: 1.5, colour: cx.tokens.template, dashed: by == PlacedBy::Machine };
        shapes::rimmed_line(&scene.painter, &on_screen, true, style);
        if scene.is_writable() {
            let hovered = scene.hover.and_then(|at| grip_at(at, transform, corners, scene));
            let grip = self.drag.get().map(|drag| drag.grip).or(hovered);
            let (top, end) = stem(&on_screen);
            shapes::rimmed_line(&scene.painter, &[top, end], false, LineStyle::solid(1.5, style.colour));
            let radius = if grip == Some(Grip::Turn) { 7.0 } else { 5.0 };
            scene.painter.circle(end, radius, Color32::WHITE, egui::Stroke::new(2.0, style.colour));
            for corner in on_screen {
                shapes::handle(&scene.painter, corner, style.colour, grip == Some(Grip::Scale));
            }
            let icon = match grip {
                Some(Grip::Move) => CursorIcon::Move,
                Some(Grip::Scale) => CursorIcon::ResizeNwSe,
                Some(Grip::Turn) => CursorIcon::Alias,
                None => return,
            };
            scene.painter.ctx().set_cursor_icon(icon);
        }
    }
}

/// The placement, held by what is under the pointer.
fn grab(at: Pos2, corners: &[Pixel; 4], scene: &Scene<'_>, cx: &mut Context<'_>) -> Option<Drag> {
    let (before, _) = placed(scene.workspace, scene.frame).filter(|_| scene.is_writable())?;
    let grip = grip_at(at, &before, corners, scene)?;
    cx.options.playing = false;
    let centre = placement::apply(&before, placement::middle(corners));
    Some(Drag { grip, from: scene.pixel(at), centre, before, now: before })
}

impl Follow for Drag {
    fn follow(&mut self, to: Pixel) {
        let (from, to) = ((self.from.x - self.centre.x, self.from.y - self.centre.y), (to.x, to.y));
        let rel = (to.0 - self.centre.x, to.1 - self.centre.y);
        self.now = match self.grip {
            Grip::Move => placement::moved(&self.before, to.0 - self.from.x, to.1 - self.from.y),
            Grip::Scale => {
                let scale = rel.0.hypot(rel.1) / from.0.hypot(from.1).max(1.0);
                placement::turned(&self.before, self.centre, scale.clamp(0.05, 20.0), 0.0)
            }
            Grip::Turn => {
                let angle = rel.1.atan2(rel.0) - from.1.atan2(from.0);
                placement::turned(&self.before, self.centre, 1.0, angle)
            }
        };
    }
}

/// Where the stem of the turning handle starts and ends: outwards from the top edge.
fn stem(on_screen: &[Pos2; 4]) -> (Pos2, Pos2) {
    let top = on_screen[0] + (on_screen[1] - on_screen[0]) / 2.0;
    let bottom = on_screen[3] + (on_screen[2] - on_screen[3]) / 2.0;
    let outwards = (top - bottom).normalized();
    (top, top + if outwards.length() > 0.5 { outwards } else { vec2(0.0, -1.0) } * STEM)
}

/// What a press at `at` takes hold of.
fn grip_at(at: Pos2, transform: &Matrix3<f64>, corners: &[Pixel; 4], scene: &Scene<'_>) -> Option<Grip> {
    let on_screen = corners.map(|corner| scene.projection.to_screen(placement::apply(transform, corner)));
    if stem(&on_screen).1.distance(at) <= HIT {
        return Some(Grip::Turn);
    }
    if on_screen.iter().any(|corner| corner.distance(at) <= HIT) {
        return Some(Grip::Scale);
    }
    let back = transform.try_inverse()?;
    let inside = placement::apply(&back, scene.pixel(at));
    let within = inside.x >= corners[0].x
        && inside.x <= corners[2].x
        && inside.y >= corners[0].y
        && inside.y <= corners[2].y;
    within.then_some(Grip::Move)
}

/// A texture bent so that its corner at share (0, 0) to (1, 1) of it lies where `place` says.
fn warped(id: egui::TextureId, place: impl Fn(Vec2) -> Pos2) -> Mesh {
    let mut mesh = Mesh::with_texture(id);
    for row in 0..=PIECES {
        for column in 0..=PIECES {
            let share = vec2(column as f32, row as f32) / PIECES as f32;
            mesh.vertices.push(egui::epaint::Vertex {
                pos: place(share),
                uv: pos2(share.x, share.y),
                color: Color32::WHITE,
            });
        }
    }
    let at = |row: u32, column: u32| row * (PIECES + 1) + column;
    for row in 0..PIECES {
        for column in 0..PIECES {
            let (a, b) = (at(row, column), at(row, column + 1));
            let (c, d) = (at(row + 1, column), at(row + 1, column + 1));
            mesh.add_triangle(a, b, c);
            mesh.add_triangle(c, b, d);
        }
    }
    mesh
}

/// `command`'s change of the placement on the frame at hand.
pub(in super::super) fn nudged(
    cx: &Context<'_>,
    change: impl Fn(&Matrix3<f64>, Pixel) -> Matrix3<f64>,
) -> Option<Command> {
    let workspace = cx.workspace.filter(|workspace| workspace.is_writable())?;
    let frame = workspace.playhead;
    let track = workspace.found.template.as_ref()?;
    let (before, _) = placed(workspace, frame)?;
    let centre = placement::apply(&before, placement::middle(&placement::frame_of(track)));
    Some(Command::SetPlacement { frame, transform: Some(change(&before, centre)) })
}

/// Moves a placement.
pub(in super::super) fn shift(dx: f64, dy: f64) -> impl Fn(&Matrix3<f64>, Pixel) -> Matrix3<f64> {
    move |transform, _| placement::moved(transform, dx, dy)
}

/// Scales a placement about its own middle.
pub(in super::super) fn scale(by: f64) -> impl Fn(&Matrix3<f64>, Pixel) -> Matrix3<f64> {
    move |transform, centre| placement::turned(transform, centre, by, 0.0)
}
