//! `agenticfocus eval` as a person runs it.
#![cfg(feature = "engine")]
#![allow(clippy::unwrap_used, reason = "a broken expectation is a failed test")]

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

fn eval(arguments: &[&str], out: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_agenticfocus"));
    command.env("XDG_DATA_HOME", out.join("no-data"));
    command.arg("eval").args(arguments).arg("--out").arg(out).output().unwrap()
}

/// Every file of a folder.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .filter(|path| path.is_file())
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(path).unwrap()))
        .collect()
}

#[test]
fn the_report_is_whole_and_the_same_bytes_for_one_thread_and_two() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    for (folder, threads) in folders.iter().zip(["1", "2"]) {
        let sweep = "smoothing=ema/zero_phase";
        let arguments =
            ["--synthetic", "3", "--seed", "11", "--frames", "45", "--threads", threads, "--sweep", sweep];
        let output = eval(&arguments, folder.path());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let [one, two] = folders.each_ref().map(|folder| files(folder.path()));
    let figures = ["position_error", "sparc_episodes", "sparc", "tradeoff"];
    let mut expected: Vec<String> =
        ["episodes.csv", "report.html", "report.json"].map(str::to_owned).to_vec();
    expected.extend(figures.iter().flat_map(|name| [format!("{name}.png"), format!("{name}.svg")]));
    expected.sort();
    assert_eq!(one.keys().cloned().collect::<Vec<_>>(), expected);
    for (name, bytes) in &one {
        assert!(two[name] == *bytes, "{name} differs");
    }
    let report: serde_json::Value = serde_json::from_slice(&one["report.json"]).unwrap();
    for method in ["ours", "masquerade", "do-as-i-do"] {
        for metric in ["position_error_cm", "sparc", "sal", "ldlj"] {
            let figure = &report["methods"][method][metric];
            let mean = figure["mean"].as_f64().unwrap();
            let ci: Vec<f64> =
                figure["ci95"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
            assert!(ci[0] <= mean && mean <= ci[1], "{method} {metric}: {figure}");
            assert_eq!(figure["episodes"].as_array().unwrap().len(), 3);
        }
    }
    for other in ["ours-masquerade", "ours-do-as-i-do"] {
        assert!(report["paired"][other]["sparc"]["ci95"].is_array(), "{other}");
    }
    let violations = report["methods"]["ours"]["limit_violations"]["mean"].as_f64();
    assert_eq!(violations, Some(0.0));
    assert!(report["notes"].to_string().contains("physics"));
    let page = String::from_utf8(one["report.html"].clone()).unwrap();
    assert_eq!(page.matches("<svg").count(), 4);
    assert!(!page.contains("<script") && page.contains("physics refinement"));
    let rows = String::from_utf8(one["episodes.csv"].clone()).unwrap();
    assert_eq!(rows.lines().count(), 1 + 3 * 4);
}

#[test]
fn a_sweep_prints_its_frontier_and_a_single_method_needs_no_other() {
    let out = tempfile::tempdir().unwrap();
    let arguments = ["--synthetic", "1", "--seed", "3", "--frames", "45", "--method", "ours"];
    let output = eval(&[&arguments[..], &["--sweep", "alpha=0.3/0.9,beta=0.8"]].concat(), out.path());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    for name in ["ema alpha=0.3 beta=0.8", "zero_phase alpha=0.9 beta=0.8"] {
        assert!(text.contains(name), "{text}");
    }
    assert!(text.contains(" *"), "{text}");
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(out.path().join("report.json")).unwrap()).unwrap();
    assert_eq!(report["sweep"].as_array().unwrap().len(), 4);
    assert_eq!(report["paired"], serde_json::json!({}));
}

#[test]
fn wrong_words_and_bad_inputs_have_their_own_exit_codes() {
    let out = tempfile::tempdir().unwrap();
    let code = |arguments: &[&str]| eval(arguments, &out.path().join("report")).status.code();
    assert_eq!(code(&[]), Some(2));
    assert_eq!(code(&["--synthetic", "1", "--method", "theirs"]), Some(2));
    assert_eq!(code(&["--synthetic", "1", "--sweep", "gamma=1"]), Some(2));
    assert_eq!(code(&["--synthetic", "1", "--frames", "1"]), Some(65));
    assert_eq!(code(&[out.path().join("missing").to_str().unwrap()]), Some(74));
    let broken = out.path().join("broken.json");
    fs::write(&broken, "{\"left_joints\": 3}").unwrap();
    assert_eq!(code(&[broken.to_str().unwrap()]), Some(65));
    assert_eq!(code(&[out.path().to_str().unwrap()]), Some(65), "a folder without a track");
    assert!(!out.path().join("report").exists());
}

#[test]
fn real_tracks_are_compared_with_themselves() {
    let root = std::env::var_os("AGENTICFOCUS_SHARED")
        .map_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/../shared").into(), PathBuf::from);
    let paths = ["clips/dexycb", "clips/whisking"].map(|path| root.join(path));
    if !paths.iter().all(|path| path.is_dir()) {
        println!("skipped: no {}", root.join("clips").display());
        return;
    }
    let out = tempfile::tempdir().unwrap();
    let output = eval(
        &[paths[0].to_str().unwrap(), paths[1].to_str().unwrap(), "--json", "--sweep", "smoothing=ema"],
        out.path(),
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let names: Vec<&str> = report["episodes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|episode| episode["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["dexycb_motion", "whisking_hands"]);
    assert_eq!(report["episodes"][0]["reference"], "track");
    println!("{:#}", report["methods"]["ours"]["position_error_cm"]);
}
