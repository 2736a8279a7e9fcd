//! Everything the operator can do, by key, by palette and by button.

use agenticfocus::session::Step;
use egui::{Key, KeyboardShortcut, Modifiers};

/// Where a command's keys hold. Global keys are unique; steps may use the same key for different things.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Everywhere.
    Global,
    /// In one step.
    Step(Step),
}

impl Scope {
    /// The step; `None` where keys hold everywhere.
    pub fn step(self) -> Option<Step> {
        match self {
            Self::Global => None,
            Self::Step(step) => Some(step),
        }
    }
}

/// Something the operator can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum UiCommand {
    /// Open a clip or a session.
    Open,
    /// Open a folder of clips as the queue.
    OpenFolder,
    /// Open the next clip that nobody decided about.
    NextClip,
    /// Take the last step back.
    Undo,
    /// Do again what was taken back.
    Redo,
    /// Find any command by its name.
    Palette,
    /// Show what every key does.
    Keys,
    /// Confirm this step and go to the next thing that needs a person.
    Confirm,
    /// Go to the next step.
    NextStep,
    /// Go to the step before.
    PreviousStep,
    /// Choose the object.
    StepObject,
    /// Correct masks.
    StepMasks,
    /// Choose and place the template.
    StepTemplate,
    /// Correct hands.
    StepHands,
    /// Tune the robot's motion.
    StepRetarget,
    /// Judge the finished picture.
    StepComposite,
    /// Accept, reject or flag.
    StepReview,
    /// One frame back.
    PreviousFrame,
    /// One frame on.
    NextFrame,
    /// Ten frames back.
    BackTen,
    /// Ten frames on.
    OnTen,
    /// Go to the start.
    FirstFrame,
    /// Go to the end.
    LastFrame,
    /// Go to the last frame a person edited.
    PreviousEdit,
    /// Go to the next frame a person edited.
    NextEdit,
    /// Go to the last frame that wants a look.
    PreviousProblem,
    /// Go to the next frame that wants a look.
    NextProblem,
    /// Type the number of a frame.
    GoToFrame,
    /// Play the clip from here.
    PlayPause,
    /// Play slower.
    Slower,
    /// Play faster.
    Faster,
    /// Selected frames start here.
    SelectFrom,
    /// Selected frames end here.
    SelectTo,
    /// Drop the selection of frames.
    SelectNothing,
    /// Show the whole picture.
    Fit,
    /// One picture pixel is one screen pixel.
    OneToOne,
    /// Zoom the picture in.
    ZoomIn,
    /// Zoom the picture out.
    ZoomOut,
    /// Fold the queue in or out.
    ToggleQueue,
    /// Fold the inspector in or out.
    ToggleInspector,
    /// Move the keyboard to the inspector's controls.
    Controls,
    /// Point at the picture with arrow keys and Space.
    Aim,
    /// Dark colours.
    ThemeDark,
    /// Light colours.
    ThemeLight,
    /// Everything larger.
    Larger,
    /// Everything smaller.
    Smaller,
    /// Write the readable snapshot of the session.
    Checkpoint,
    /// Keep this session in another folder.
    SaveElsewhere,
    /// Hold the work in progress, or go on.
    Pause,
    /// Stop the work in progress; what was found stays.
    Cancel,
    /// Find out again what is out of date.
    Rerun,
    /// Write video, record and masks.
    Export,
    /// Close the window.
    Quit,
    /// Take the first proposed object.
    Choose1,
    /// Take the second proposed object.
    Choose2,
    /// Take the third proposed object.
    Choose3,
    /// Take the fourth proposed object.
    Choose4,
    /// Take the fifth proposed object.
    Choose5,
    /// Draw a box around the object.
    DrawBox,
    /// Click on the object, right-click beside it.
    DrawPoints,
    /// Forget the chosen object.
    NoObject,
    /// Tools edit the object's mask.
    LayerObject,
    /// Tools edit the left arm's mask.
    LayerLeftArm,
    /// Tools edit the right arm's mask.
    LayerRightArm,
    /// Add under the brush.
    Brush,
    /// Take away under the brush.
    Eraser,
    /// Swap brush and eraser.
    SwapBrush,
    /// Add a box; Shift takes away.
    BoxTool,
    /// Add a polygon, corner by corner; Shift takes away.
    Polygon,
    /// Add what a line encloses; Shift takes away.
    Lasso,
    /// Click on it, right-click beside it.
    PointsTool,
    /// Smaller brush.
    BrushSmaller,
    /// Larger brush.
    BrushLarger,
    /// Fill the mask's holes on this frame.
    FillHoles,
    /// Grow the mask on this frame.
    Grow,
    /// Shrink the mask on this frame.
    Shrink,
    /// Keep the mask of this frame as it is.
    Trust,
    /// There is nothing of it on this frame.
    Absent,
    /// Drop the edit of this frame.
    ForgetMask,
    /// Spread masks to later frames.
    PropagateForward,
    /// Spread masks to earlier frames.
    PropagateBackward,
    /// Spread masks both ways.
    PropagateBoth,
    /// Hide masks while held.
    HideMasks,
    /// Fill masks fainter.
    FillLess,
    /// Fill masks stronger.
    FillMore,
    /// Outlines of the frames before and after.
    OnionSkin,
    /// The hole in the background one pixel wider.
    HoleWider,
    /// The hole in the background one pixel narrower.
    HoleNarrower,
    /// Outline of the hole in which the background is restored.
    HoleOutline,
    /// Close the polygon, or take the points' mask.
    FinishShape,
    /// Cut the template from this frame.
    TemplateHere,
    /// Let the machine choose the clean frame.
    TemplateAuto,
    /// Paint the template's mask on its frame, or place the template again.
    TemplateMask,
    /// Drop the placement by hand on this frame.
    ForgetPlacement,
    /// Place the template between two keyframes, or leave those frames to the machine again.
    InterpolatePlacement,
    /// Move the placement one pixel left.
    NudgeLeft,
    /// Move the placement one pixel right.
    NudgeRight,
    /// Move the placement one pixel up.
    NudgeUp,
    /// Move the placement one pixel down.
    NudgeDown,
    /// Scale the placement up by one per cent.
    PlacementLarger,
    /// Scale the placement down by one per cent.
    PlacementSmaller,
    /// Commands mean the left hand.
    LeftHand,
    /// Commands mean the right hand.
    RightHand,
    /// Exchange left and right on the selected frames, or on this one.
    SwapSides,
    /// This hand is of no use on the selected frames, or on this one.
    InvalidHand,
    /// Drop corrections of this hand on the selected frames, or on this one.
    ForgetHand,
    /// Draw the hand between the ends of the selection.
    InterpolateHand,
    /// Let the machine fit the scale.
    FitBeta,
    /// Put every parameter back to its default.
    ResetRetarget,
    /// Decide the order from contact on the selected frames.
    OrderAuto,
    /// The robot covers the object on the selected frames.
    OrderRobot,
    /// The object covers the robot on the selected frames.
    OrderObject,
    /// Thumb pass on or off on the selected frames.
    OrderThumb,
    /// Show the source, the composite, or both.
    BeforeAfter,
    /// This clip is good.
    Accept,
    /// This clip is not to be used.
    Reject,
    /// Look at this clip again.
    Flag,
}

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;
const ALT: Modifiers = Modifiers::ALT;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

const fn key(modifiers: Modifiers, key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(modifiers, key)
}

/// One row of the table of commands.
struct Row {
    command: UiCommand,
    text: &'static str,
    tooltip: &'static str,
    keys: &'static [KeyboardShortcut],
    scope: Scope,
}

const fn row(
    command: UiCommand,
    text: &'static str,
    tooltip: &'static str,
    keys: &'static [KeyboardShortcut],
    scope: Scope,
) -> Row {
    Row { command, text, tooltip, keys, scope }
}

/// The one table from which keys, palette, key sheet and buttons are made; in the order of the enumeration.
#[rustfmt::skip]
const TABLE: &[Row] = &[
    row(UiCommand::Open, "Open…", "Open a clip or a session", &[key(CTRL, Key::O)], Scope::Global),
    row(UiCommand::OpenFolder, "Open folder…", "Open a folder of clips as the queue", &[key(CTRL_SHIFT, Key::O)], Scope::Global),
    row(UiCommand::NextClip, "Next unreviewed clip", "Open the next clip that nobody decided about", &[key(CTRL, Key::Enter)], Scope::Global),
    row(UiCommand::Undo, "Undo", "Take the last step back", &[key(CTRL, Key::Z)], Scope::Global),
    row(UiCommand::Redo, "Redo", "Do again what was taken back", &[key(CTRL_SHIFT, Key::Z), key(CTRL, Key::Y)], Scope::Global),
    row(UiCommand::Palette, "Command palette", "Find any command by its name", &[key(CTRL, Key::P)], Scope::Global),
    row(UiCommand::Keys, "Keys", "Show what every key does", &[key(NONE, Key::F1), key(NONE, Key::Questionmark)], Scope::Global),
    row(UiCommand::Confirm, "Confirm", "Confirm this step and go to the next thing that needs a person", &[key(NONE, Key::Enter)], Scope::Global),
    row(UiCommand::NextStep, "Next step", "Go to the next step", &[key(NONE, Key::Tab)], Scope::Global),
    row(UiCommand::PreviousStep, "Previous step", "Go to the step before", &[key(SHIFT, Key::Tab)], Scope::Global),
    row(UiCommand::StepObject, "Step: object", "Choose the object", &[key(ALT, Key::Num1)], Scope::Global),
    row(UiCommand::StepMasks, "Step: masks", "Correct masks", &[key(ALT, Key::Num2)], Scope::Global),
    row(UiCommand::StepTemplate, "Step: template", "Choose and place the template", &[key(ALT, Key::Num3)], Scope::Global),
    row(UiCommand::StepHands, "Step: hands", "Correct hands", &[key(ALT, Key::Num4)], Scope::Global),
    row(UiCommand::StepRetarget, "Step: retarget", "Tune the robot's motion", &[key(ALT, Key::Num5)], Scope::Global),
    row(UiCommand::StepComposite, "Step: composite", "Judge the finished picture", &[key(ALT, Key::Num6)], Scope::Global),
    row(UiCommand::StepReview, "Step: review", "Accept, reject or flag", &[key(ALT, Key::Num7)], Scope::Global),
    row(UiCommand::PreviousFrame, "Previous frame", "One frame back", &[key(NONE, Key::ArrowLeft), key(NONE, Key::A)], Scope::Global),
    row(UiCommand::NextFrame, "Next frame", "One frame on", &[key(NONE, Key::ArrowRight), key(NONE, Key::D)], Scope::Global),
    row(UiCommand::BackTen, "Ten frames back", "Ten frames back", &[key(SHIFT, Key::ArrowLeft)], Scope::Global),
    row(UiCommand::OnTen, "Ten frames on", "Ten frames on", &[key(SHIFT, Key::ArrowRight)], Scope::Global),
    row(UiCommand::FirstFrame, "First frame", "Go to the start", &[key(NONE, Key::Home), key(ALT, Key::ArrowLeft)], Scope::Global),
    row(UiCommand::LastFrame, "Last frame", "Go to the end", &[key(NONE, Key::End), key(ALT, Key::ArrowRight)], Scope::Global),
    row(UiCommand::PreviousEdit, "Previous edit", "Go to the last frame a person edited", &[key(NONE, Key::Comma)], Scope::Global),
    row(UiCommand::NextEdit, "Next edit", "Go to the next frame a person edited", &[key(NONE, Key::Period)], Scope::Global),
    row(UiCommand::PreviousProblem, "Previous problem", "Go to the last frame that wants a look", &[key(SHIFT, Key::Comma)], Scope::Global),
    row(UiCommand::NextProblem, "Next problem", "Go to the next frame that wants a look", &[key(SHIFT, Key::Period)], Scope::Global),
    row(UiCommand::GoToFrame, "Go to frame…", "Type the number of a frame", &[key(NONE, Key::G)], Scope::Global),
    row(UiCommand::PlayPause, "Play or pause", "Play the clip from here", &[key(NONE, Key::Space)], Scope::Global),
    row(UiCommand::Slower, "Slower", "Play slower", &[key(CTRL, Key::Comma)], Scope::Global),
    row(UiCommand::Faster, "Faster", "Play faster", &[key(CTRL, Key::Period)], Scope::Global),
    row(UiCommand::SelectFrom, "Select from here", "Selected frames start here", &[key(NONE, Key::I)], Scope::Global),
    row(UiCommand::SelectTo, "Select to here", "Selected frames end here", &[key(NONE, Key::Q)], Scope::Global),
    row(UiCommand::SelectNothing, "Select nothing", "Drop the selection of frames", &[key(NONE, Key::Escape)], Scope::Global),
    row(UiCommand::Fit, "Fit", "Show the whole picture", &[key(NONE, Key::Num0)], Scope::Global),
    row(UiCommand::OneToOne, "1:1", "One picture pixel is one screen pixel", &[key(CTRL, Key::Num0)], Scope::Global),
    row(UiCommand::ZoomIn, "Zoom in", "Zoom the picture in", &[key(NONE, Key::Plus), key(NONE, Key::Equals)], Scope::Global),
    row(UiCommand::ZoomOut, "Zoom out", "Zoom the picture out", &[key(NONE, Key::Minus)], Scope::Global),
    row(UiCommand::ToggleQueue, "Queue", "Fold the queue in or out", &[key(CTRL_SHIFT, Key::Q)], Scope::Global),
    row(UiCommand::ToggleInspector, "Inspector", "Fold the inspector in or out", &[key(CTRL_SHIFT, Key::I)], Scope::Global),
    row(UiCommand::Controls, "Controls by keyboard", "Move the keyboard to the inspector's controls: Tab goes on, Escape comes back", &[key(NONE, Key::F6)], Scope::Global),
    row(UiCommand::Aim, "Point by keyboard", "Point at the picture: arrows move a cross, Space presses there, Escape ends", &[key(NONE, Key::V)], Scope::Global),
    row(UiCommand::ThemeDark, "Dark theme", "Dark colours", &[key(CTRL_SHIFT, Key::D)], Scope::Global),
    row(UiCommand::ThemeLight, "Light theme", "Light colours", &[key(CTRL_SHIFT, Key::L)], Scope::Global),
    row(UiCommand::Larger, "Larger text", "Everything larger", &[key(CTRL, Key::Plus), key(CTRL, Key::Equals)], Scope::Global),
    row(UiCommand::Smaller, "Smaller text", "Everything smaller", &[key(CTRL, Key::Minus)], Scope::Global),
    row(UiCommand::Checkpoint, "Save now", "Write the readable snapshot of the session", &[key(CTRL, Key::S)], Scope::Global),
    row(UiCommand::SaveElsewhere, "Save elsewhere…", "Keep this session in another folder", &[key(CTRL_SHIFT, Key::S)], Scope::Global),
    row(UiCommand::Pause, "Hold or go on", "Hold the work in progress, or go on", &[key(CTRL, Key::Space)], Scope::Global),
    row(UiCommand::Cancel, "Stop work", "Stop the work in progress; what was found stays", &[key(CTRL, Key::Escape)], Scope::Global),
    row(UiCommand::Rerun, "Work again", "Find out again what is out of date", &[key(NONE, Key::F5)], Scope::Global),
    row(UiCommand::Export, "Export", "Write video, record and masks", &[key(CTRL, Key::E)], Scope::Global),
    row(UiCommand::Quit, "Quit", "Close the window", &[key(CTRL, Key::Q)], Scope::Global),
    row(UiCommand::Choose1, "Take proposal 1", "Take the first proposed object", &[key(NONE, Key::Num1)], Scope::Step(Step::Object)),
    row(UiCommand::Choose2, "Take proposal 2", "Take the second proposed object", &[key(NONE, Key::Num2)], Scope::Step(Step::Object)),
    row(UiCommand::Choose3, "Take proposal 3", "Take the third proposed object", &[key(NONE, Key::Num3)], Scope::Step(Step::Object)),
    row(UiCommand::Choose4, "Take proposal 4", "Take the fourth proposed object", &[key(NONE, Key::Num4)], Scope::Step(Step::Object)),
    row(UiCommand::Choose5, "Take proposal 5", "Take the fifth proposed object", &[key(NONE, Key::Num5)], Scope::Step(Step::Object)),
    row(UiCommand::DrawBox, "Draw a box", "Draw a box around the object", &[key(NONE, Key::R)], Scope::Step(Step::Object)),
    row(UiCommand::DrawPoints, "Click points", "Click on the object, right-click beside it", &[key(NONE, Key::P)], Scope::Step(Step::Object)),
    row(UiCommand::NoObject, "No object", "Forget the chosen object", &[key(NONE, Key::Backspace)], Scope::Step(Step::Object)),
    row(UiCommand::LayerObject, "Object mask", "Tools edit the object's mask", &[key(NONE, Key::Num1)], Scope::Step(Step::Masks)),
    row(UiCommand::LayerLeftArm, "Left arm", "Tools edit the left arm's mask", &[key(NONE, Key::Num2)], Scope::Step(Step::Masks)),
    row(UiCommand::LayerRightArm, "Right arm", "Tools edit the right arm's mask", &[key(NONE, Key::Num3)], Scope::Step(Step::Masks)),
    row(UiCommand::Brush, "Brush", "Add under the brush", &[key(NONE, Key::B)], Scope::Step(Step::Masks)),
    row(UiCommand::Eraser, "Eraser", "Take away under the brush", &[key(NONE, Key::E)], Scope::Step(Step::Masks)),
    row(UiCommand::SwapBrush, "Swap brush and eraser", "Swap brush and eraser", &[key(NONE, Key::X)], Scope::Step(Step::Masks)),
    row(UiCommand::BoxTool, "Box", "Add a box; Shift takes away", &[key(NONE, Key::R)], Scope::Step(Step::Masks)),
    row(UiCommand::Polygon, "Polygon", "Add a polygon, corner by corner; Shift takes away", &[key(NONE, Key::P)], Scope::Step(Step::Masks)),
    row(UiCommand::Lasso, "Lasso", "Add what a line encloses; Shift takes away", &[key(NONE, Key::L)], Scope::Step(Step::Masks)),
    row(UiCommand::PointsTool, "Points", "Click on it, right-click beside it", &[key(NONE, Key::S)], Scope::Step(Step::Masks)),
    row(UiCommand::BrushSmaller, "Smaller brush", "Smaller brush", &[key(NONE, Key::OpenBracket)], Scope::Step(Step::Masks)),
    row(UiCommand::BrushLarger, "Larger brush", "Larger brush", &[key(NONE, Key::CloseBracket)], Scope::Step(Step::Masks)),
    row(UiCommand::FillHoles, "Fill holes", "Fill the mask's holes on this frame", &[key(NONE, Key::F)], Scope::Step(Step::Masks)),
    row(UiCommand::Grow, "Grow", "Grow the mask on this frame", &[key(CTRL, Key::CloseBracket)], Scope::Step(Step::Masks)),
    row(UiCommand::Shrink, "Shrink", "Shrink the mask on this frame", &[key(CTRL, Key::OpenBracket)], Scope::Step(Step::Masks)),
    row(UiCommand::Trust, "Trust this frame", "Keep the mask of this frame as it is", &[key(NONE, Key::K)], Scope::Step(Step::Masks)),
    row(UiCommand::Absent, "Absent here", "There is nothing of it on this frame", &[key(NONE, Key::O)], Scope::Step(Step::Masks)),
    row(UiCommand::ForgetMask, "Leave to the machine", "Drop the edit of this frame", &[key(NONE, Key::Delete)], Scope::Step(Step::Masks)),
    row(UiCommand::PropagateForward, "Propagate forward", "Spread masks to later frames", &[key(CTRL, Key::ArrowRight), key(CTRL, Key::B)], Scope::Step(Step::Masks)),
    row(UiCommand::PropagateBackward, "Propagate backward", "Spread masks to earlier frames", &[key(CTRL, Key::ArrowLeft)], Scope::Step(Step::Masks)),
    row(UiCommand::PropagateBoth, "Propagate both ways", "Spread masks both ways", &[key(CTRL_SHIFT, Key::B)], Scope::Step(Step::Masks)),
    row(UiCommand::HideMasks, "Hide masks", "Hide masks while held", &[key(NONE, Key::H)], Scope::Global),
    row(UiCommand::FillLess, "Fainter masks", "Fill masks fainter", &[key(NONE, Key::Semicolon)], Scope::Global),
    row(UiCommand::FillMore, "Stronger masks", "Fill masks stronger", &[key(NONE, Key::Quote)], Scope::Global),
    row(UiCommand::OnionSkin, "Onion skin", "Outlines of the frames before and after", &[key(NONE, Key::N)], Scope::Step(Step::Masks)),
    row(UiCommand::HoleWider, "Wider hole", "Restore the background one pixel farther around the arms", &[key(ALT, Key::CloseBracket)], Scope::Step(Step::Masks)),
    row(UiCommand::HoleNarrower, "Narrower hole", "Restore the background one pixel less far around the arms", &[key(ALT, Key::OpenBracket)], Scope::Step(Step::Masks)),
    row(UiCommand::HoleOutline, "Outline of the hole", "Show where the background is restored behind the arms", &[key(NONE, Key::U)], Scope::Step(Step::Masks)),
    row(UiCommand::FinishShape, "Finish shape", "Close the polygon, or take the points' mask", &[key(NONE, Key::Enter)], Scope::Step(Step::Masks)),
    row(UiCommand::TemplateHere, "Template from here", "Cut the template from this frame", &[key(NONE, Key::T)], Scope::Step(Step::Template)),
    row(UiCommand::TemplateAuto, "Best frame", "Let the machine choose the clean frame", &[key(SHIFT, Key::T)], Scope::Step(Step::Template)),
    row(UiCommand::TemplateMask, "Paint its mask", "Paint the template's mask on its own frame, or place the template again", &[key(NONE, Key::B)], Scope::Step(Step::Template)),
    row(UiCommand::ForgetPlacement, "Placement by the machine", "Drop the placement by hand on this frame", &[key(NONE, Key::Delete)], Scope::Step(Step::Template)),
    row(UiCommand::InterpolatePlacement, "Interpolate placement", "Place the template between the keyframes around this frame, or leave those frames to the machine again", &[key(NONE, Key::N)], Scope::Step(Step::Template)),
    row(UiCommand::NudgeLeft, "Nudge left", "Move the placement one pixel left", &[key(NONE, Key::J)], Scope::Step(Step::Template)),
    row(UiCommand::NudgeRight, "Nudge right", "Move the placement one pixel right", &[key(NONE, Key::L)], Scope::Step(Step::Template)),
    row(UiCommand::NudgeUp, "Nudge up", "Move the placement one pixel up", &[key(NONE, Key::U)], Scope::Step(Step::Template)),
    row(UiCommand::NudgeDown, "Nudge down", "Move the placement one pixel down", &[key(NONE, Key::M)], Scope::Step(Step::Template)),
    row(UiCommand::PlacementLarger, "Larger placement", "Scale the placement up by one per cent", &[key(NONE, Key::CloseBracket)], Scope::Step(Step::Template)),
    row(UiCommand::PlacementSmaller, "Smaller placement", "Scale the placement down by one per cent", &[key(NONE, Key::OpenBracket)], Scope::Step(Step::Template)),
    row(UiCommand::LeftHand, "Left hand", "Commands mean the left hand", &[key(NONE, Key::Num1)], Scope::Step(Step::Hands)),
    row(UiCommand::RightHand, "Right hand", "Commands mean the right hand", &[key(NONE, Key::Num2)], Scope::Step(Step::Hands)),
    row(UiCommand::SwapSides, "Swap left and right", "Exchange left and right on the selected frames, or on this one", &[key(NONE, Key::W)], Scope::Step(Step::Hands)),
    row(UiCommand::InvalidHand, "Invalid hand", "This hand is of no use on the selected frames, or on this one", &[key(NONE, Key::O)], Scope::Step(Step::Hands)),
    row(UiCommand::ForgetHand, "Hand by the machine", "Drop corrections of this hand on the selected frames, or on this one", &[key(NONE, Key::Delete)], Scope::Step(Step::Hands)),
    row(UiCommand::InterpolateHand, "Interpolate hand", "Draw the hand between the ends of the selection", &[key(NONE, Key::N)], Scope::Step(Step::Hands)),
    row(UiCommand::FitBeta, "Fit β", "Let the machine fit the scale", &[key(NONE, Key::F)], Scope::Step(Step::Retarget)),
    row(UiCommand::ResetRetarget, "Reset retargeting", "Put every parameter back to its default", &[key(NONE, Key::Delete)], Scope::Step(Step::Retarget)),
    row(UiCommand::OrderAuto, "Order: auto", "Decide the order from contact on the selected frames", &[key(NONE, Key::Num1)], Scope::Step(Step::Composite)),
    row(UiCommand::OrderRobot, "Order: robot in front", "The robot covers the object on the selected frames", &[key(NONE, Key::Num2)], Scope::Step(Step::Composite)),
    row(UiCommand::OrderObject, "Order: object in front", "The object covers the robot on the selected frames", &[key(NONE, Key::Num3)], Scope::Step(Step::Composite)),
    row(UiCommand::OrderThumb, "Thumb pass", "Thumb pass on or off on the selected frames", &[key(NONE, Key::Num4)], Scope::Step(Step::Composite)),
    row(UiCommand::BeforeAfter, "Before or after", "Show the source, the composite, or both", &[key(NONE, Key::W)], Scope::Step(Step::Composite)),
    row(UiCommand::Accept, "Accept", "This clip is good", &[key(NONE, Key::Enter)], Scope::Step(Step::Review)),
    row(UiCommand::Reject, "Reject", "This clip is not to be used", &[key(NONE, Key::Backspace)], Scope::Step(Step::Review)),
    row(UiCommand::Flag, "Flag", "Look at this clip again", &[key(NONE, Key::M)], Scope::Step(Step::Review)),
];

impl UiCommand {
    /// Every command in the table's order.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|row| row.command)
    }

    fn row(self) -> &'static Row {
        &TABLE[self as usize]
    }

    /// Its name on buttons and in the palette.
    pub fn text(self) -> &'static str {
        self.row().text
    }

    /// What it does, in a sentence without a full stop.
    pub fn tooltip(self) -> &'static str {
        self.row().tooltip
    }

    /// Its keys, the first one is shown.
    pub fn keys(self) -> &'static [KeyboardShortcut] {
        self.row().keys
    }

    /// Where its keys hold.
    pub fn scope(self) -> Scope {
        self.row().scope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_enumeration_and_every_command_has_a_key() {
        for (at, row) in TABLE.iter().enumerate() {
            assert_eq!(row.command as usize, at, "{:?}", row.command);
            assert!(!row.keys.is_empty(), "{:?} cannot be reached from the keyboard", row.command);
        }
    }

    #[test]
    fn no_key_means_two_things_in_one_place() {
        for (at, one) in TABLE.iter().enumerate() {
            for other in &TABLE[at + 1..] {
                // Enter finishes, confirms and accepts: the step's own meaning comes first.
                let shared = [UiCommand::Confirm, UiCommand::SelectNothing];
                let meet = one.scope == other.scope
                    || (one.scope == Scope::Global || other.scope == Scope::Global)
                        && !shared.contains(&one.command);
                for key in one.keys {
                    assert!(!(meet && other.keys.contains(key)), "{:?} and {:?}", one.command, other.command);
                }
            }
        }
    }
}
