//! The flags about vision-language models.

use std::time::Duration;

use clap::Args;

use crate::{
    pipeline::Installation,
    select::vlm::{BaseUrl, Profile, VlmMode},
};

/// How a model is asked for the object. The key comes from the environment alone.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Object by a vision-language model")]
pub(super) struct VlmArguments {
    /// Ask a model for the object of clips without a prompt: off; cache (answers kept in sessions, no network); live
    /// [default: live with an address and a model, else kept answers are used]
    #[arg(long, value_name = "MODE")]
    vlm: Option<VlmMode>,
    /// Address of an OpenAI-compatible server, for example http://localhost:8000/v1 (or AGENTICFOCUS_VLM_URL); its key,
    /// if it wants one, in AGENTICFOCUS_VLM_KEY
    #[arg(long, value_name = "URL")]
    vlm_url: Option<BaseUrl>,
    /// The model's name on that server (or AGENTICFOCUS_VLM_MODEL)
    #[arg(long, value_name = "NAME")]
    vlm_model: Option<String>,
    /// How it writes coordinates: rel1000-xyxy, abs-xyxy, rel1000-yxyx or pct-point [default: what its name suggests,
    /// else rel1000-xyxy]
    #[arg(long, value_name = "PROFILE", hide_short_help = true)]
    vlm_profile: Option<Profile>,
    /// How long one question may take
    #[arg(long, value_name = "SECONDS", hide_short_help = true, value_parser = clap::value_parser!(u32).range(1..=3600))]
    vlm_timeout: Option<u32>,
}

impl VlmArguments {
    /// The parts found on this machine, with what was said here over what the environment says.
    pub(super) fn installation(&self) -> Installation {
        let mut installation = Installation::locate();
        let Self { vlm, vlm_url, vlm_model, vlm_profile, vlm_timeout } = self.clone();
        let settings = &mut installation.vlm;
        settings.mode = vlm.or(settings.mode);
        settings.url = vlm_url.or(settings.url.take());
        settings.model = vlm_model.or(settings.model.take());
        settings.profile = vlm_profile.or(settings.profile);
        settings.timeout =
            vlm_timeout.map(|seconds| Duration::from_secs(seconds.into())).or(settings.timeout);
        installation
    }

    /// The same as words, for a worker.
    pub(super) fn words(&self) -> Vec<String> {
        let words = [
            ("--vlm", self.vlm.map(|mode| mode.to_string())),
            ("--vlm-url", self.vlm_url.as_ref().map(BaseUrl::to_string)),
            ("--vlm-model", self.vlm_model.clone()),
            ("--vlm-profile", self.vlm_profile.map(|profile| profile.to_string())),
            ("--vlm-timeout", self.vlm_timeout.map(|seconds| seconds.to_string())),
        ];
        words.into_iter().filter_map(|(name, value)| Some(format!("{name}={}", value?))).collect()
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Program {
        #[command(flatten)]
        vlm: VlmArguments,
    }

    #[test]
    fn a_worker_is_told_what_the_batch_was_told() {
        let said = [
            "--vlm=live",
            "--vlm-url=http://h:1/v1",
            "--vlm-model=-odd name",
            "--vlm-profile=abs-xyxy",
            "--vlm-timeout=7",
        ];
        let program = Program::parse_from(["program"].into_iter().chain(said));
        assert_eq!(program.vlm.words(), said);
        assert!(Program::try_parse_from(["program", "--vlm=on"]).is_err());
        assert!(Program::try_parse_from(["program", "--vlm-profile=xyxy"]).is_err());
    }
}
