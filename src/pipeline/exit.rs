//! Exit codes, after `sysexits.h`.

use serde::{Deserialize, Serialize};

/// How a clip or a whole run ended. The order is that of severity within a batch:
/// 0 < 65 < 75 < 74 < 1, and 130 above all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExitCode {
    /// 0: done.
    Done,
    /// 65: the input is bad and will stay so.
    BadInput,
    /// 75: try again later.
    Temporary,
    /// 74: reading or writing failed.
    InputOutput,
    /// 1: a mistake of ours.
    Internal,
    /// 2: wrong usage.
    Usage,
    /// 130: cancelled.
    Cancelled,
}

impl ExitCode {
    /// The process's exit status.
    pub const fn status(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Internal => 1,
            Self::Usage => 2,
            Self::BadInput => 65,
            Self::InputOutput => 74,
            Self::Temporary => 75,
            Self::Cancelled => 130,
        }
    }

    /// The code for a process's exit status; what we never use counts as internal.
    pub const fn from_status(status: i32) -> Self {
        match status {
            0 => Self::Done,
            2 => Self::Usage,
            65 => Self::BadInput,
            74 => Self::InputOutput,
            75 => Self::Temporary,
            130 => Self::Cancelled,
            _ => Self::Internal,
        }
    }

    /// One word for reports.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Internal => "internal error",
            Self::Usage => "wrong usage",
            Self::BadInput => "bad input",
            Self::InputOutput => "input/output error",
            Self::Temporary => "temporary failure",
            Self::Cancelled => "cancelled",
        }
    }
}

/// The code for a failure of the file system: what time may cure is temporary.
impl From<&std::io::Error> for ExitCode {
    fn from(error: &std::io::Error) -> Self {
        use std::io::ErrorKind;
        match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => Self::Temporary,
            _ => Self::InputOutput,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ExitCode;

    #[test]
    fn the_worst_clip_decides_in_the_designs_order() {
        let ordered = [0, 65, 75, 74, 1].map(ExitCode::from_status);
        assert!(ordered.is_sorted());
        assert_eq!(ordered.map(ExitCode::status), [0, 65, 75, 74, 1]);
    }
}
