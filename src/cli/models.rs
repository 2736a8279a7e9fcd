//! Options of learned models, for every command that runs the pipeline.

use std::path::PathBuf;

use clap::Args;

use crate::{
    inpaint::video::Blend,
    onnx::{Provider, RuntimeOptions},
    pipeline::ModelOptions,
};

/// Learned models.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Learned models")]
pub struct ModelArguments {
    /// Look for models in this folder first (then in the user's data folder, then in ./models)
    #[arg(long, value_name = "DIR")]
    models: Vec<PathBuf>,
    /// Run model files that no registry.toml lists
    #[arg(long)]
    allow_unlisted_model: bool,
    /// Leave learned models alone: the embedded back ends only
    #[arg(long, conflicts_with_all = ["models", "allow_unlisted_model", "provider", "blend"])]
    no_models: bool,
    /// What runs models: cpu, cuda, tensorrt or coreml, where the installed ONNX Runtime offers it [default: cpu]
    #[arg(long, value_name = "NAME", value_parser = provider)]
    provider: Option<Provider>,
    /// How a background network's windows are blended: triangular, or reference as its authors do [default: triangular]
    #[arg(long, value_name = "RULE", value_parser = blend)]
    blend: Option<Blend>,
}

fn provider(name: &str) -> Result<Provider, String> {
    let known = || Provider::ALL.map(Provider::name).join(", ");
    let found = Provider::ALL.into_iter().find(|provider| provider.name() == name);
    found.ok_or_else(|| format!("one of {} expected", known()))
}

fn blend(name: &str) -> Result<Blend, String> {
    let found = Blend::ALL.into_iter().find(|blend| blend.name() == name);
    found.ok_or_else(|| format!("one of {} expected", Blend::ALL.map(Blend::name).join(", ")))
}

impl ModelArguments {
    /// What they say.
    pub fn options(&self) -> ModelOptions {
        let usual = RuntimeOptions::default();
        ModelOptions {
            folders: self.models.clone(),
            allow_unlisted: self.allow_unlisted_model,
            off: self.no_models,
            runtime: RuntimeOptions { provider: self.provider.unwrap_or_default(), ..usual },
            blend: self.blend.unwrap_or_default(),
        }
    }

    /// The same as words, for another program of ours.
    pub fn words(&self) -> Vec<String> {
        let flags = [("--allow-unlisted-model", self.allow_unlisted_model), ("--no-models", self.no_models)];
        let set = flags.into_iter().filter(|(_, set)| *set).map(|(flag, _)| flag.to_owned());
        let folders = self.models.iter().map(|folder| format!("--models={}", folder.to_string_lossy()));
        let provider = self.provider.map(|provider| format!("--provider={}", provider.name()));
        let blend = self.blend.map(|blend| format!("--blend={}", blend.name()));
        set.chain(folders).chain(provider).chain(blend).collect()
    }
}
