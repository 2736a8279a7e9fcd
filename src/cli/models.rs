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
    /// Find hands with this program (with its arguments, quoted) in place of a hand model and of MediaPipe; it speaks the
    /// protocol of models/README.md
    #[arg(long, value_name = "COMMAND", value_parser = command)]
    hand_estimator: Option<EstimatorWords>,
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

/// A program and its arguments, as they were written.
#[derive(Clone, Debug, Default)]
struct EstimatorWords {
    written: String,
    words: Vec<String>,
}

/// Words between blanks; quotes hold words with blanks together.
fn command(written: &str) -> Result<EstimatorWords, String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in written.chars() {
        match (c, quote) {
            (c, Some(open)) if c == open => quote = None,
            ('"' | '\'', None) => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (c, None) if c.is_whitespace() => words.extend(word.take()),
            (c, _) => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    match (quote, words.first()) {
        (Some(open), _) => Err(format!("a quote {open} is never closed")),
        (None, None) => Err("a program expected".to_owned()),
        (None, Some(_)) => Ok(EstimatorWords { written: written.to_owned(), words }),
    }
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
            estimator: self.hand_estimator.clone().unwrap_or_default().words,
        }
    }

    /// The same as words, for another program of ours.
    pub fn words(&self) -> Vec<String> {
        let flags = [("--allow-unlisted-model", self.allow_unlisted_model), ("--no-models", self.no_models)];
        let set = flags.into_iter().filter(|(_, set)| *set).map(|(flag, _)| flag.to_owned());
        let folders = self.models.iter().map(|folder| format!("--models={}", folder.to_string_lossy()));
        let provider = self.provider.map(|provider| format!("--provider={}", provider.name()));
        let blend = self.blend.map(|blend| format!("--blend={}", blend.name()));
        let estimator = self.hand_estimator.as_ref();
        let estimator = estimator.map(|estimator| format!("--hand-estimator={}", estimator.written));
        set.chain(folders).chain(provider).chain(blend).chain(estimator).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_split_at_blanks_that_are_not_quoted() {
        let words = |written: &str| command(written).map(|command| command.words);
        let expected = ["python3", "my hands.py", "--device", "", "a'b"].map(str::to_owned).to_vec();
        assert_eq!(words("python3  'my hands.py' --device \"\" \"a'b\""), Ok(expected));
        assert!(words(" ").is_err() && words("python3 'x").is_err());
    }
}
