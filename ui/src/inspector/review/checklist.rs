//! What the machine checked, step by step, and what it found.

use agenticfocus::{
    clip::ClipFlag,
    geometry::Side,
    hands::HandState,
    session::{Author, Step},
};

use crate::{
    inspector::{
        composite::{coverage_in_words, whole},
        parts::backend_in_words,
        retarget::followed,
        words::author_of_proposal,
    },
    state::Workspace,
};

/// How a check came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// As it should be.
    Good,
    /// Worth a look.
    Look,
    /// Not known yet.
    Open,
}

/// One line of the checklist.
#[derive(Clone, Debug, PartialEq)]
pub struct ChecklistItem {
    /// What was checked.
    pub name: &'static str,
    /// The step in which it can be mended.
    pub step: Option<Step>,
    /// How it came out.
    pub verdict: Verdict,
    /// What was found, with numbers.
    pub found: String,
}

/// Whether all is well, and what was found; `None` where it is not known yet.
type Check = fn(&Workspace) -> Option<(bool, String)>;

/// The checklist of a session, in the method's order.
pub fn checklist(workspace: &Workspace) -> Vec<ChecklistItem> {
    let checks: [(&'static str, Option<Step>, Check); 7] = [
        ("Clip", None, clip),
        ("Object", Some(Step::Object), object),
        ("Masks", Some(Step::Masks), masks),
        ("Template", Some(Step::Template), template),
        ("Hands", Some(Step::Hands), hands),
        ("Robot", Some(Step::Retarget), robot),
        ("Background", Some(Step::Composite), background),
    ];
    let item = |(name, step, check): (&'static str, Option<Step>, Check)| {
        let confirmed = step.is_some_and(|step| workspace.document().confirmed.contains(&step));
        let (verdict, mut found) = match check(workspace) {
            None => (Verdict::Open, "not known yet".to_owned()),
            Some((good, found)) => (if good || confirmed { Verdict::Good } else { Verdict::Look }, found),
        };
        if confirmed {
            found.push_str(" · confirmed by you");
        }
        ChecklistItem { name, step, verdict, found }
    };
    checks.into_iter().map(item).collect()
}

fn clip(workspace: &Workspace) -> Option<(bool, String)> {
    let clip = workspace.found.clip.as_ref()?;
    let words: Vec<&str> = clip.flags.iter().map(|flag| flag_in_words(*flag)).collect();
    let length = format!("{} frames, {}", clip.frame_count(), clip.size);
    let found = if words.is_empty() { length } else { format!("{length}, {}", words.join(", ")) };
    let harmless = |flag: &ClipFlag| matches!(flag, ClipFlag::VariableFrameRate | ClipFlag::NonSquarePixels);
    Some((clip.flags.iter().all(harmless), found))
}

fn flag_in_words(flag: ClipFlag) -> &'static str {
    match flag {
        ClipFlag::Truncated => "ends before its container says",
        ClipFlag::Damaged => "damaged: frames may be missing",
        ClipFlag::VariableFrameRate => "frame rate varied",
        ClipFlag::NonMonotonicPts => "time stamps ran backwards",
        ClipFlag::MissingPts => "time stamps were missing",
        ClipFlag::DefaultIntrinsics => "camera not known",
        ClipFlag::NonSquarePixels => "pixels are not square",
    }
}

fn object(workspace: &Workspace) -> Option<(bool, String)> {
    let chosen = workspace.document().object.as_ref();
    let object = chosen.or(workspace.found.choice.as_ref())?;
    let who = author_of_proposal(&object.author);
    let percent = 100.0 * object.confidence;
    Some(match (&object.author, chosen) {
        (Author::Human, _) => (true, format!("{}, pointed at by you", object.label)),
        (_, Some(_)) => (true, format!("{}, proposed by {who} and chosen", object.label)),
        (_, None) => (object.confidence >= 0.5, format!("{}, by {who} with {percent:.0} %", object.label)),
    })
}

fn masks(workspace: &Workspace) -> Option<(bool, String)> {
    workspace.found.object.as_ref()?;
    let (problems, drawn) = (workspace.problems().len(), workspace.document().object_masks.len());
    let drawn = if drawn == 0 { String::new() } else { format!(", {drawn} by you") };
    Some(match problems {
        0 => (true, format!("nothing doubtful{drawn}")),
        count => (false, format!("{count} of {} frames doubtful{drawn}", workspace.frame_count())),
    })
}

fn template(workspace: &Workspace) -> Option<(bool, String)> {
    let track = workspace.found.template.as_ref()?;
    let placed = track.placements.iter().flatten();
    let (count, sure) =
        (placed.clone().count(), placed.filter(|placement| placement.confidence >= 0.5).count());
    let share = sure as f64 / count.max(1) as f64;
    let found = format!("from frame {}, sure on {:.0} % of its frames", track.frame.0, 100.0 * share);
    Some((share >= 0.9, found))
}

fn hands(workspace: &Workspace) -> Option<(bool, String)> {
    let track = workspace.found.hands.as_ref()?;
    let share = |side: Side, state: HandState| {
        let frames = &track.hands[side];
        frames.iter().filter(|hand| hand.state == state).count() as f64 / frames.len().max(1) as f64
    };
    let words = |side: Side| {
        let (seen, bridged) = (share(side, HandState::Observed), share(side, HandState::Bridged));
        format!("{} seen {:.0} %, bridged {:.0} %", side.name(), 100.0 * seen, 100.0 * bridged)
    };
    let seen = Side::BOTH.iter().any(|side| share(*side, HandState::Observed) >= 0.5);
    Some((seen, format!("{}\n{}", words(Side::Left), words(Side::Right))))
}

fn robot(workspace: &Workspace) -> Option<(bool, String)> {
    let motion = workspace.found.motion.as_ref()?;
    let mut good = true;
    let mut words = Vec::new();
    for side in Side::BOTH {
        let numbers = followed(&motion.sides[side]);
        if let (Some(error), Some(reach)) = (numbers.mean_error, numbers.reachable) {
            good &= error < 0.02 && reach >= 0.9;
            words.push(format!(
                "{} off by {:.1} cm, in reach {:.0} %",
                side.name(),
                100.0 * error,
                100.0 * reach
            ));
        }
    }
    Some(if words.is_empty() { (false, "no hand drives it".to_owned()) } else { (good, words.join("\n")) })
}

fn background(workspace: &Workspace) -> Option<(bool, String)> {
    let report = workspace.found.background.as_ref()?;
    let all = whole(&report.coverage);
    if all.hole == 0 {
        return Some((true, "nothing had to be restored".to_owned()));
    }
    let found = format!("{}\nby {}", coverage_in_words(&all), backend_in_words(&report.backend));
    Some((all.synthesised <= 0.25, found))
}
