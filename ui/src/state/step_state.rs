//! How far a step is: what its chip shows.

/// The state of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StepState {
    /// ○ nothing yet (default).
    #[default]
    NotRun,
    /// ◐ being worked on.
    Running,
    /// ● done by the machine.
    Done,
    /// ▲ n: so many frames want a look.
    NeedsLook(usize),
    /// ✓ confirmed by a person.
    Confirmed,
}
