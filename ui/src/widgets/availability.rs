//! Whether a command can be carried out now, and why not.

use agenticfocus::engine::Access;

use crate::{
    state::{Context, Work, Workspace},
    ui_command::{Scope, UiCommand},
};

/// Why `command` cannot be carried out now, in words for a tooltip; `None` where it can.
pub fn blocked(cx: &Context<'_>, command: UiCommand) -> Option<String> {
    blocked_in_its_step(cx, command).or_else(|| {
        let step = command.scope().step().filter(|step| *step != cx.options.step)?;
        Some(format!("Only in the step “{}”", super::step_name(step).to_lowercase()))
    })
}

/// Why `command` could not even be carried out in the step it belongs to.
pub fn blocked_in_its_step(cx: &Context<'_>, command: UiCommand) -> Option<String> {
    use UiCommand as C;
    match command {
        C::Open
        | C::OpenFolder
        | C::Palette
        | C::Keys
        | C::ToggleQueue
        | C::ToggleInspector
        | C::Controls
        | C::ThemeDark
        | C::ThemeLight
        | C::Larger
        | C::Smaller
        | C::Quit => return None,
        C::NextClip => return no_next_clip(cx),
        _ => {}
    }
    let Some(workspace) = cx.workspace else { return Some("No clip open".to_owned()) };
    match command {
        C::Undo if workspace.history.undo_depth() == 0 => return Some("Nothing to undo".to_owned()),
        C::Redo if workspace.history.redo_depth() == 0 => return Some("Nothing to do again".to_owned()),
        C::Pause if !is_working(workspace) => return Some("No work in progress".to_owned()),
        C::Cancel if !is_working(workspace) && workspace.exporting.is_none() => {
            return Some("No work in progress".to_owned());
        }
        C::Export if workspace.exporting.is_some() => return Some("The export is running".to_owned()),
        _ => {}
    }
    if let Access::ReadOnly(holder) = &workspace.access
        && changes(command)
    {
        return Some(format!("Read-only: {holder} writes to this session"));
    }
    let unread = needs_frames(command) && workspace.frame_count() == 0;
    unread.then(|| "The clip is still being read".to_owned())
}

fn no_next_clip(cx: &Context<'_>) -> Option<String> {
    if cx.queue.items.is_empty() {
        return Some("No folder of clips open".to_owned());
    }
    let id = cx.workspace.map(|workspace| workspace.document().clip.id.as_str());
    cx.queue.next_unreviewed(id).is_none().then(|| "Every other clip of the queue is reviewed".to_owned())
}

fn is_working(workspace: &Workspace) -> bool {
    matches!(workspace.work, Work::Running { .. })
}

/// Whether the command changes the session.
fn changes(command: UiCommand) -> bool {
    use UiCommand as C;
    let only_looks = matches!(
        command,
        C::LayerObject
            | C::LayerLeftArm
            | C::LayerRightArm
            | C::HoleOutline
            | C::Brush
            | C::Eraser
            | C::SwapBrush
            | C::BoxTool
            | C::Polygon
            | C::Lasso
            | C::PointsTool
            | C::BrushSmaller
            | C::BrushLarger
            | C::OnionSkin
            | C::LeftHand
            | C::RightHand
            | C::BeforeAfter
            | C::PropagateForward
            | C::PropagateBackward
            | C::PropagateBoth
    );
    match command {
        C::Undo | C::Redo | C::Confirm | C::Checkpoint => true,
        _ => command.scope() != Scope::Global && !only_looks,
    }
}

fn needs_frames(command: UiCommand) -> bool {
    use UiCommand as C;
    matches!(
        command,
        C::PreviousFrame
            | C::NextFrame
            | C::BackTen
            | C::OnTen
            | C::FirstFrame
            | C::LastFrame
            | C::PreviousEdit
            | C::NextEdit
            | C::PreviousProblem
            | C::NextProblem
            | C::GoToFrame
            | C::PlayPause
            | C::SelectFrom
            | C::SelectTo
            | C::Aim
            | C::Export
    ) || command.scope() != Scope::Global
}
