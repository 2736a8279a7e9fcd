//! `agenticfocus robot check PATH` and `robot import PATH`.

use super::{Failure, Outcome, args::RobotVerb};
use crate::{
    pipeline::{ExitCode, Installation},
    robot,
};

pub(super) fn run(verb: &RobotVerb) -> Outcome {
    let refused = |error: robot::ImportError| {
        let failure = crate::pipeline::ClipFailure::from_error(&error, ExitCode::BadInput);
        Failure::new(failure.exit, failure.message)
    };
    match verb {
        RobotVerb::Check { path } => print(&robot::check(path).map_err(refused)?),
        RobotVerb::Import { path } => {
            let imported = robot::import(path, &Installation::locate().data).map_err(refused)?;
            print(&imported.report);
            println!("stored in {}; it is the default robot now", imported.folder.display());
        }
    }
    Ok(ExitCode::Done)
}

fn print(report: &robot::RobotReport) {
    println!("robot      {}", report.name);
    println!("links      {}", report.links);
    println!("joints     {} ({} moving, {} of them coupled)", report.joints, report.moving, report.mimics);
    println!("meshes     {}", report.meshes);
    println!("triangles  {} ({} kept for rendering)", report.triangles, report.triangles_kept);
    for note in &report.notes {
        println!("note       {note}");
    }
}
