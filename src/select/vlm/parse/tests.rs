use proptest::prelude::*;

use super::*;

const GOOD: &str = r#"{"found": true, "object": "cup", "frame": 7, "x1": 100, "y1": 200, "x2": 300, "y2": 400,
    "px": 150, "py": 250, "hand": "right", "confidence": 0.9, "reason": "held by the {right} hand"}"#;

fn read(content: &str) -> Result<Answer, ParseError> {
    parse(content, Profile::Rel1000Xyxy)
}

fn corners(content: &str, profile: Profile) -> Option<[f64; 4]> {
    let [a, b] = parse(content, profile).ok()?.corners?;
    Some([a.x, a.y, b.x, b.y])
}

#[test]
fn the_same_answer_is_read_bare_fenced_after_thoughts_and_in_prose() {
    let bare = read(GOOD).unwrap();
    assert_eq!(
        (bare.frame, bare.confidence, bare.point),
        (Some(7.0), Some(0.9), Some(Pixel::new(150.0, 250.0)))
    );
    for wrapped in [
        format!("```json\n{GOOD}\n```"),
        format!("```\n{GOOD}"),
        format!("Sure! Here it is:\n```json\n{GOOD}\n```\nAnything else?"),
        format!("<think>a cup {{maybe}} [1, 2, 3, 4]</think>\n{GOOD}"),
        format!("the template opened the thoughts {{}} </think>{GOOD}"),
        format!("The object [a cup] is {{here}}: {GOOD} as you see."),
        format!("[{GOOD}]"),
        format!("{{\"result\": {{\"objects\": [{GOOD}]}}}}"),
    ] {
        assert_eq!(read(&wrapped).as_ref(), Ok(&bare), "{wrapped}");
    }
}

#[test]
fn other_keys_are_understood_and_lists_follow_the_profile() {
    let qwen = r#"[{"bbox_2d": [1, 2, 3, 4], "label": "cup"}]"#;
    assert_eq!(corners(qwen, Profile::AbsXyxy), Some([1.0, 2.0, 3.0, 4.0]));
    assert_eq!(read(qwen).unwrap().label.as_deref(), Some("cup"));
    let gemini = r#"{"box_2d": [1, 2, 3, 4], "label": "cup"}"#;
    assert_eq!(corners(gemini, Profile::Rel1000Yxyx), Some([2.0, 1.0, 4.0, 3.0]));
    assert_eq!(corners(gemini, Profile::Rel1000Xyxy), Some([1.0, 2.0, 3.0, 4.0]));
    assert_eq!(read(gemini).unwrap().remarks.len(), 1, "an order that may be wrong is said");
    assert_eq!(corners(r#"{"box": [["1", 2], [3, 4]]}"#, Profile::AbsXyxy), Some([1.0, 2.0, 3.0, 4.0]));
    assert_eq!(corners("[1, 2, 3, 4]", Profile::AbsXyxy), Some([1.0, 2.0, 3.0, 4.0]));
    assert_eq!(corners(GOOD, Profile::Rel1000Yxyx), Some([100.0, 200.0, 300.0, 400.0]), "named is named");
}

#[test]
fn points_in_markup_are_only_read_where_the_profile_says_so() {
    let molmo = r#" <point x="61.5" y="40.6" alt="cup">cup</point>"#;
    let answer = parse(molmo, Profile::PctPoint).unwrap();
    assert_eq!((answer.point, answer.label.as_deref()), (Some(Pixel::new(61.5, 40.6)), Some("cup")));
    assert_eq!(read(molmo), Err(ParseError::Markup));
    assert_eq!(parse("I cannot see it", Profile::PctPoint), Err(ParseError::NoPoint));
    assert!(!parse(r#"{"found": false}"#, Profile::PctPoint).unwrap().found);
}

#[test]
fn what_cannot_be_read_is_told_apart() {
    assert_eq!(read(" \n"), Err(ParseError::Empty));
    assert_eq!(read("<think>it is a cup, but"), Err(ParseError::OnlyThoughts));
    assert_eq!(read(&GOOD[..60]), Err(ParseError::CutOff));
    assert_eq!(read("It is the cup."), Err(ParseError::NoJson));
    let wrong = read(r#"{"thing": "cup", "where": "left"}"#);
    assert_eq!(wrong, Err(ParseError::WrongKeys("thing, where".to_owned())));
    assert!(matches!(read(r#"{"found": true, "object": "cup"}"#), Err(ParseError::WrongKeys(_))));
}

#[test]
fn a_wall_of_brackets_costs_no_time() {
    let began = std::time::Instant::now();
    assert!(read(&"[{".repeat(1 << 20)).is_err());
    assert!(read(&"{\"a\":".repeat(1 << 20)).is_err());
    assert!(began.elapsed().as_secs_f64() < 1.0);
}

proptest! {
    #[test]
    fn no_text_makes_the_ladder_fall(text in any::<String>(), at in 0..4_usize) {
        // Whatever it says; it must not panic.
        parse(&text, Profile::ALL[at]).ok();
    }

    #[test]
    fn no_scraps_of_answers_make_it_fall(
        scraps in prop::collection::vec(
            prop::sample::select(vec![
                "{", "}", "[", "]", "\"", "\\", ":", ",", "```", "```json\n", "<think>", "</think>", "<point", " x=\"",
                " y='", ">", "alt=", "Click(", "é", "\u{0}", "1e999", "-", "null", "\"x1\"", "\"bbox_2d\":", "[1,2,3,4]",
                "NaN", "found", GOOD,
            ]),
            0..24,
        ),
        at in 0..4_usize,
    ) {
        parse(&scraps.concat(), Profile::ALL[at]).ok();
    }

    #[test]
    fn an_answer_survives_any_prose_around_it(before in "[^{\\[<`\"]{0,40}", after in "[^<`]{0,40}") {
        prop_assert_eq!(read(&format!("{before}{GOOD}{after}")), read(GOOD));
    }
}
