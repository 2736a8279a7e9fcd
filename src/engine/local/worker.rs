//! The thread that finds everything out about a clip, again and again as its document changes.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Arc,
};

use super::{
    listener::{PassedOn, WorkListener},
    panic_text,
    scene::{OpenClip, Scene, Shared, Wish},
};
use crate::{
    engine::{Event, Finding, WorkFailure},
    pipeline::{ClipFailure, ExitCode, layer_evidence, plan_layers, understand_document},
};

pub(super) fn run(shared: &Shared) {
    while let Some((open, wish)) = shared.next_wish() {
        let worked = catch_unwind(AssertUnwindSafe(|| work(shared, &open, &wish)));
        let result = worked.unwrap_or_else(|panic| {
            let message = panic_text(&*panic);
            Err(ClipFailure { stage: None, exit: ExitCode::Internal, message })
        });
        let told = match &result {
            Ok(_) => Ok(()),
            Err(failure) if failure.exit == ExitCode::Cancelled => Err(None),
            Err(failure) => Err(Some(told(failure))),
        };
        shared.finish(&open, result.map_err(|failure| failure.message));
        shared.tell(Event::WorkEnded { revision: wish.revision, result: told });
    }
}

/// A failure as the window shows it.
pub(super) fn told(failure: &ClipFailure) -> WorkFailure {
    WorkFailure {
        stage: failure.stage.map(|stage| stage.name().to_owned()),
        message: failure.message.clone(),
    }
}

fn work(shared: &Shared, open: &OpenClip, wish: &Wish) -> Result<Scene, ClipFailure> {
    let revision = wish.revision;
    let listener = WorkListener::new(shared, revision);
    let mut decisions = PassedOn { shared, revision };
    let surroundings = (&shared.installation, &listener as _, &shared.cancel);
    let found = understand_document(
        &open.job,
        &wish.document,
        &open.folder,
        &open.memory,
        &mut decisions,
        surroundings,
    )?;
    let evidence = match shared.scene() {
        Some(old) if same_pictures(&old, &found) => old.evidence,
        _ => Arc::new(layer_evidence(&found)?),
    };
    let plan = Arc::new(plan_layers(&wish.document, &found, &evidence));
    let order = Arc::new(plan.order.clone());
    shared.tell(Event::Found { revision, finding: Finding::Order(order) });
    Ok(Scene { revision, found: Arc::new(found), evidence, plan })
}

/// Whether what was seen of hands and object is what it was before.
fn same_pictures(old: &Scene, new: &crate::pipeline::Understood) -> bool {
    let old = &old.found;
    let same_template = match (&old.template, &new.template) {
        (Some(old), Some(new)) => Arc::ptr_eq(old, new),
        (None, None) => true,
        _ => false,
    };
    Arc::ptr_eq(&old.arms, &new.arms)
        && Arc::ptr_eq(&old.object, &new.object)
        && Arc::ptr_eq(&old.hands, &new.hands)
        && same_template
}
