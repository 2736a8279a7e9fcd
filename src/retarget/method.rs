//! By which method a clip is retargeted.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

/// A retargeting method. The baselines are there to be compared with: the same hand tracks, robot, limits and
/// record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// AgenticFocus: wrist, palm and all five fingers through the camera-relative map, zero-phase smoothing.
    #[default]
    Ours,
    /// Masquerade (Lepert et al. 2025): the hand as a parallel gripper between thumb and middle finger.
    Masquerade,
    /// The kinematic part of Do as I Do (arXiv 2606.19333): fingertips first, four small steps a frame. Its physics
    /// refinement is left out.
    DoAsIDo,
}

impl Method {
    /// All of them, ours first.
    pub const ALL: [Self; 3] = [Self::Ours, Self::Masquerade, Self::DoAsIDo];

    /// As manifests, records and the command line spell it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::Masquerade => "masquerade",
            Self::DoAsIDo => "do-as-i-do",
        }
    }

    /// As a person reads it.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Ours => "AgenticFocus",
            Self::Masquerade => "Masquerade",
            Self::DoAsIDo => "Do as I Do",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A word that names no method.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no retargeting method {given:?}: expected one of {}", Method::ALL.map(Method::name).join(", "))]
pub struct UnknownMethod {
    /// What was given.
    pub given: String,
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(given: &str) -> Result<Self, UnknownMethod> {
        let found = Self::ALL.into_iter().find(|method| method.name() == given);
        found.ok_or_else(|| UnknownMethod { given: given.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_read_back_by_the_command_line_and_by_json() {
        for method in Method::ALL {
            assert_eq!(method.to_string().parse::<Method>().unwrap(), method);
            assert_eq!(serde_json::to_string(&method).unwrap(), format!("\"{method}\""));
        }
        assert!("Ours".parse::<Method>().unwrap_err().to_string().contains("masquerade"));
    }
}
