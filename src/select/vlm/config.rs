//! Whether a model is asked, which one, where, and how long it may take.

use std::{fmt, str::FromStr, time::Duration};

use serde::{Deserialize, Serialize};

use super::{
    base_url::{BaseUrl, UrlError},
    profile::Profile,
    secret::Secret,
};

/// Whether a vision-language model is asked which object a clip is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum VlmMode {
    /// Never, and kept answers are not used.
    Off,
    /// Kept answers are used; no network.
    Cache,
    /// Asked where no answer to the same question is kept.
    Live,
}

impl VlmMode {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Off, Self::Cache, Self::Live];

    /// Its name on the command line and in manifests.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Cache => "cache",
            Self::Live => "live",
        }
    }
}

impl fmt::Display for VlmMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for VlmMode {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|mode| mode.name() == text.trim());
        found.ok_or_else(|| format!("unknown mode {text:?}: expected off, cache or live"))
    }
}

/// What a clip's manifest may say: never where the model is, because who writes a manifest must not be able to send
/// pictures and the key elsewhere.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VlmWish {
    /// Whether a model is asked.
    pub mode: Option<VlmMode>,
    /// Which one.
    pub model: Option<String>,
    /// How it writes coordinates.
    pub profile: Option<Profile>,
}

/// What was said about models on the command line or in the environment; nothing by default.
#[derive(Clone, Debug, Default)]
pub struct VlmSettings {
    /// Whether one is asked (default: live with an address and a model, else only kept answers are used).
    pub mode: Option<VlmMode>,
    /// Where it is.
    pub url: Option<BaseUrl>,
    /// Which one, as the server calls it.
    pub model: Option<String>,
    /// How it writes coordinates (default: what its name suggests, else `rel1000-xyxy`).
    pub profile: Option<Profile>,
    /// How long one question may take (default: 120 s).
    pub timeout: Option<Duration>,
    /// The key.
    pub key: Option<Secret>,
    /// Why what was said cannot be followed.
    pub problem: Option<VlmConfigError>,
}

/// Why settings cannot be followed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum VlmConfigError {
    /// An address that is none.
    #[error(transparent)]
    Url(#[from] UrlError),
    /// A word that means nothing.
    #[error("{name}: {message}")]
    Value {
        /// The variable.
        name: &'static str,
        /// What is wrong with its value.
        message: String,
    },
    /// One of two that belong together.
    #[error("asking a model needs {missing}: give --vlm-url http://HOST:PORT/v1 and --vlm-model NAME")]
    Incomplete {
        /// What is missing.
        missing: &'static str,
    },
}

/// Why a profile is in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileOrigin {
    /// It was given.
    Given,
    /// The model's name tells it.
    Suggested,
    /// Nothing tells it.
    Assumed,
}

/// A model that can be asked.
#[derive(Clone, Debug)]
pub struct VlmServer {
    /// Where.
    pub url: BaseUrl,
    /// Which.
    pub model: String,
    /// How it writes coordinates.
    pub profile: Profile,
    /// Why so.
    pub profile_origin: ProfileOrigin,
    /// How long connecting may take (5 s).
    pub connect_timeout: Duration,
    /// How long one question may take, tries and waits included.
    pub total_timeout: Duration,
    /// How long after a failed try the second one comes (0.5 s); the third after twice that.
    pub first_wait: Duration,
    /// The key.
    pub key: Option<Secret>,
}

/// Where the key is looked for, and nowhere else.
pub const KEY_VARIABLE: &str = "AGENTICFOCUS_VLM_KEY";
/// How long connecting may take.
pub const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// How long one question may take.
pub const TOTAL_TIMEOUT: Duration = Duration::from_secs(120);
/// How long after a failed try the second one comes.
pub const FIRST_WAIT: Duration = Duration::from_millis(500);

/// What is done about models.
#[derive(Clone, Debug)]
pub enum VlmPlan {
    /// Nothing.
    Off,
    /// Kept answers are used; `asked_for` when somebody said so, and wants to hear when there is none.
    Replay {
        /// Whether it was said.
        asked_for: bool,
        /// Only answers of this model, where one was named.
        model: Option<String>,
        /// Only answers in this convention, where one was named.
        profile: Option<Profile>,
    },
    /// A model is asked where no answer is kept.
    Ask(VlmServer),
}

impl VlmSettings {
    /// What the environment says: `AGENTICFOCUS_VLM` (the mode), `…_URL`, `…_MODEL`, `…_PROFILE` and, only there,
    /// `AGENTICFOCUS_VLM_KEY`.
    pub fn from_environment(variable: impl Fn(&str) -> Option<String>) -> Self {
        let said = |name: &str| variable(name).filter(|text| !text.trim().is_empty());
        let mut settings = Self {
            model: said("AGENTICFOCUS_VLM_MODEL").map(|text| text.trim().to_owned()),
            key: said(KEY_VARIABLE).as_deref().and_then(Secret::new),
            ..Self::default()
        };
        let mut problem = None;
        let mut value = |name: &'static str, message: String| {
            problem.get_or_insert(VlmConfigError::Value { name, message });
        };
        match said("AGENTICFOCUS_VLM").map(|text| text.parse()).transpose() {
            Ok(mode) => settings.mode = mode,
            Err(message) => value("AGENTICFOCUS_VLM", message),
        }
        match said("AGENTICFOCUS_VLM_PROFILE").map(|text| text.parse()).transpose() {
            Ok(profile) => settings.profile = profile,
            Err(message) => value("AGENTICFOCUS_VLM_PROFILE", message),
        }
        match said("AGENTICFOCUS_VLM_URL").map(|text| text.parse::<BaseUrl>()).transpose() {
            Ok(url) => settings.url = url,
            Err(error) => value("AGENTICFOCUS_VLM_URL", error.to_string()),
        }
        settings.problem = problem;
        settings
    }

    /// What is done for a clip whose manifest says `wish`.
    ///
    /// # Errors
    /// When what was said cannot be followed.
    pub fn plan(&self, wish: &VlmWish) -> Result<VlmPlan, VlmConfigError> {
        let mode = wish.mode.or(self.mode);
        if mode == Some(VlmMode::Off) {
            return Ok(VlmPlan::Off);
        }
        if let Some(problem) = &self.problem {
            return Err(problem.clone());
        }
        let profile = wish.profile.or(self.profile);
        let model = wish.model.as_deref().or(self.model.as_deref()).map(str::trim);
        let model = model.filter(|model| !model.is_empty()).map(str::to_owned);
        match (mode, &self.url, model) {
            (Some(VlmMode::Cache), _, model) => Ok(VlmPlan::Replay { asked_for: true, model, profile }),
            (_, Some(url), Some(model)) => Ok(VlmPlan::Ask(self.server(url, model, profile))),
            (Some(_), None, _) => Err(VlmConfigError::Incomplete { missing: "an address" }),
            (_, Some(_), None) => Err(VlmConfigError::Incomplete { missing: "a model's name" }),
            (None, None, model) => Ok(VlmPlan::Replay { asked_for: false, model, profile }),
        }
    }

    fn server(&self, url: &BaseUrl, model: String, given: Option<Profile>) -> VlmServer {
        let suggested = Profile::suggested(&model);
        let profile_origin = match (given, suggested) {
            (Some(_), _) => ProfileOrigin::Given,
            (None, Some(_)) => ProfileOrigin::Suggested,
            (None, None) => ProfileOrigin::Assumed,
        };
        VlmServer {
            url: url.clone(),
            profile: given.or(suggested).unwrap_or_default(),
            profile_origin,
            model,
            connect_timeout: CONNECT_TIMEOUT,
            total_timeout: self.timeout.unwrap_or(TOTAL_TIMEOUT),
            first_wait: FIRST_WAIT,
            key: self.key.clone(),
        }
    }
}

impl VlmServer {
    /// Which profile is in use and why, as a line for the log.
    pub(super) fn profile_line(&self) -> String {
        let why = match self.profile_origin {
            ProfileOrigin::Given => "given",
            ProfileOrigin::Suggested => "suggested by the model's name",
            ProfileOrigin::Assumed => {
                "assumed, the model's name tells nothing: give --vlm-profile where boxes are off"
            }
        };
        format!("coordinate profile {} ({why})", self.profile)
    }

    /// The back end's name in sessions and records.
    pub fn backend(&self) -> String {
        format!("vlm {}", self.model)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from(variables: &[(&str, &str)]) -> VlmSettings {
        VlmSettings::from_environment(|name| {
            variables.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned())
        })
    }

    const URL: (&str, &str) = ("AGENTICFOCUS_VLM_URL", "http://localhost:8000/v1");
    const MODEL: (&str, &str) = ("AGENTICFOCUS_VLM_MODEL", "qwen2.5vl:7b");

    #[test]
    fn a_model_is_asked_only_where_address_and_name_are_known() {
        let quiet = from(&[]).plan(&VlmWish::default()).unwrap();
        assert!(matches!(quiet, VlmPlan::Replay { asked_for: false, .. }));
        let Ok(VlmPlan::Ask(server)) = from(&[URL, MODEL]).plan(&VlmWish::default()) else { panic!() };
        assert_eq!((server.profile, server.profile_origin), (Profile::AbsXyxy, ProfileOrigin::Suggested));
        assert_eq!(server.total_timeout, Duration::from_secs(120));
        for half in [vec![URL], vec![("AGENTICFOCUS_VLM", "live"), MODEL]] {
            assert!(matches!(from(&half).plan(&VlmWish::default()), Err(VlmConfigError::Incomplete { .. })));
        }
        let off = VlmWish { mode: Some(VlmMode::Off), ..VlmWish::default() };
        assert!(matches!(from(&[URL, MODEL]).plan(&off), Ok(VlmPlan::Off)));
        let cache = VlmWish { mode: Some(VlmMode::Cache), ..VlmWish::default() };
        assert!(matches!(
            from(&[URL, MODEL]).plan(&cache),
            Ok(VlmPlan::Replay { asked_for: true, model: Some(_), .. })
        ));
    }

    #[test]
    fn a_variable_that_means_nothing_is_named_and_the_key_is_not() {
        let settings = from(&[URL, MODEL, ("AGENTICFOCUS_VLM", "on"), ("AGENTICFOCUS_VLM_KEY", "canary")]);
        let error = settings.plan(&VlmWish::default()).unwrap_err().to_string();
        assert!(error.contains("AGENTICFOCUS_VLM") && error.contains("off, cache or live"), "{error}");
        assert!(!format!("{settings:?}").contains("canary"));
    }
}
