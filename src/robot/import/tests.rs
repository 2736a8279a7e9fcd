use std::{fs, path::PathBuf};

use super::*;

/// A sound description around whatever a test puts in.
fn urdf(body: &str) -> String {
    format!("<robot name='r'>\n{body}\n</robot>")
}

fn links(names: &[&str]) -> String {
    names.iter().map(|name| format!("<link name='{name}'/>\n")).collect()
}

fn joint(name: &str, parent: &str, child: &str, rest: &str) -> String {
    format!(
        "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/>\
         <axis xyz='0 0 1'/>{rest}</joint>\n"
    )
}

const LIMIT: &str = "<limit lower='-1' upper='1' effort='1' velocity='1'/>";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> PathBuf {
        self.0.path().join("inner/robot.urdf")
    }

    fn refusal(&self, text: &str) -> ImportError {
        fs::create_dir_all(self.path().parent().unwrap()).unwrap();
        fs::write(self.path(), text).unwrap();
        check(&self.path()).unwrap_err()
    }
}

fn refusal(text: &str) -> ImportError {
    Folder::new().refusal(text)
}

#[test]
fn document_types_are_refused_with_their_line() {
    let bomb =
        "<?xml version='1.0'?>\n<!DOCTYPE r [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]>\n<robot>&b;</robot>";
    assert!(matches!(refusal(bomb), ImportError::DocumentType { line: 2 }));
}

#[test]
fn deep_nesting_is_refused_before_the_parser_recurses() {
    let deep = urdf(&("<a>".repeat(200_000) + &"</a>".repeat(200_000)));
    assert!(matches!(refusal(&deep), ImportError::TooDeep { line: 2, .. }));
}

#[test]
fn huge_files_and_long_lists_are_refused() {
    assert!(matches!(refusal(&urdf(&" ".repeat(9 << 20))), ImportError::TooLarge { .. }));
    let many: String = (0..5000).map(|k| format!("<link name='l{k}'/>")).collect();
    assert!(matches!(refusal(&urdf(&many)), ImportError::TooLarge { .. }));
}

#[test]
fn broken_or_foreign_xml_is_refused_with_its_line() {
    assert!(matches!(refusal("<robot>\n<link name='a'>\n</robot>"), ImportError::Malformed { line: 3, .. }));
    assert!(matches!(refusal("<robot>\n<link name='a'/>"), ImportError::Malformed { .. }));
    assert!(matches!(refusal("<svg/>"), ImportError::NotUrdf(_)));
    assert!(matches!(refusal(""), ImportError::NotUrdf(_)));
}

#[test]
fn numbers_that_are_none_name_their_joint_and_link() {
    for origin in ["nan 0 0", "0 inf 0", "0 0 1e999"] {
        let text =
            urdf(&(links(&["a", "b"]) + &joint("j1", "a", "b", &format!("<origin xyz='{origin}'/>{LIMIT}"))));
        let error = refusal(&text);
        assert!(matches!(&error, ImportError::NotFinite { .. }), "{error}");
        assert!(error.to_string().contains("`j1`"));
    }
    let text = urdf("<link name='a'><visual><geometry><box size='1 nan 1'/></geometry></visual></link>");
    assert!(refusal(&text).to_string().contains("link `a`"));
}

#[test]
fn inverted_limits_and_zero_axes_name_their_joint() {
    let inverted = "<limit lower='1' upper='-1' effort='1' velocity='1'/>";
    let error = refusal(&urdf(&(links(&["a", "b"]) + &joint("j1", "a", "b", inverted))));
    assert!(matches!(error, ImportError::Limits { joint, .. } if joint == "j1"));
    let still = joint("j1", "a", "b", LIMIT).replace("0 0 1", "0 0 0");
    assert!(
        matches!(refusal(&urdf(&(links(&["a", "b"]) + &still))), ImportError::Axis { joint } if joint == "j1")
    );
    let floating = joint("j1", "a", "b", LIMIT).replace("revolute", "floating");
    let error = refusal(&urdf(&(links(&["a", "b"]) + &floating)));
    assert!(matches!(error, ImportError::JointKind { joint, .. } if joint == "j1"));
}

#[test]
fn what_is_no_tree_names_the_joint_or_link() {
    let cycle = links(&["r", "a", "b"]) + &joint("j1", "a", "b", LIMIT) + &joint("j2", "b", "a", LIMIT);
    assert!(matches!(refusal(&urdf(&cycle)), ImportError::Cycle { joint, .. } if joint == "j2"));
    let own = links(&["r", "a"]) + &joint("j1", "a", "a", LIMIT);
    assert!(matches!(refusal(&urdf(&own)), ImportError::Cycle { link, .. } if link == "a"));
    let two = links(&["a", "b", "c"]) + &joint("j1", "a", "c", LIMIT) + &joint("j2", "b", "c", LIMIT);
    assert!(matches!(refusal(&urdf(&two)), ImportError::TwoParents { link, .. } if link == "c"));
    let apart = links(&["a", "b"]);
    assert!(matches!(refusal(&urdf(&apart)), ImportError::Roots { found } if found == ["a", "b"]));
    let unknown = links(&["a"]) + &joint("j1", "a", "ghost", LIMIT);
    assert!(matches!(refusal(&urdf(&unknown)), ImportError::UnknownLink { link, .. } if link == "ghost"));
}

#[test]
fn names_that_occur_twice_are_refused() {
    let error = refusal(&urdf(&links(&["a", "a"])));
    assert!(matches!(error, ImportError::Duplicate { kind: "link", name } if name == "a"));
    let text = links(&["a", "b", "c"]) + &joint("j", "a", "b", LIMIT) + &joint("j", "b", "c", LIMIT);
    assert!(matches!(refusal(&urdf(&text)), ImportError::Duplicate { kind: "joint", name } if name == "j"));
}

#[test]
fn joints_that_follow_nothing_are_refused() {
    for target in ["ghost", "j1"] {
        let mimic = format!("{LIMIT}<mimic joint='{target}'/>");
        let error = refusal(&urdf(&(links(&["a", "b"]) + &joint("j1", "a", "b", &mimic))));
        assert!(matches!(error, ImportError::Mimic { joint, .. } if joint == "j1"));
    }
}

#[test]
fn meshes_outside_the_folder_are_never_opened() {
    let folder = Folder::new();
    fs::create_dir_all(folder.path().parent().unwrap()).unwrap();
    let secret = folder.0.path().join("secret.stl");
    fs::write(&secret, [0; 134]).unwrap();
    std::os::unix::fs::symlink(&secret, folder.path().with_file_name("link.stl")).unwrap();
    let absolute = secret.display().to_string();
    let file = format!("file://{absolute}");
    for written in
        ["../secret.stl", "link.stl", &absolute, &file, "package://r/../secret.stl", "http://x/y.stl"]
    {
        let error = folder.refusal(&urdf(&format!(
            "<link name='a'><visual><geometry><mesh filename='{written}'/></geometry></visual></link>"
        )));
        assert!(matches!(&error, ImportError::MeshOutside { link, .. } if link == "a"), "{written}: {error}");
    }
}

#[test]
fn missing_or_broken_meshes_name_their_link_and_unknown_packages_do_not_panic() {
    let folder = Folder::new();
    fs::create_dir_all(folder.path().parent().unwrap()).unwrap();
    fs::write(folder.path().with_file_name("short.stl"), [0; 90]).unwrap();
    fs::write(folder.path().with_file_name("shape.dae"), "<COLLADA/>").unwrap();
    let refused = |written: &str| {
        folder.refusal(&urdf(&format!(
            "<link name='a'><visual><geometry><mesh filename='{written}'/></geometry></visual></link>"
        )))
    };
    assert!(
        matches!(refused("package://nosuch/x.stl"), ImportError::MissingMesh { link, .. } if link == "a")
    );
    assert!(matches!(refused("short.stl"), ImportError::Mesh { link, .. } if link == "a"));
    assert!(matches!(refused("shape.dae"), ImportError::Mesh { link, .. } if link == "a"));
}

#[test]
fn a_sound_robot_that_is_no_g1_is_refused_by_what_it_lacks() {
    let error = refusal(&urdf(&(links(&["a", "b"]) + &joint("j1", "a", "b", LIMIT))));
    assert!(matches!(&error, ImportError::Robot(_)), "{error}");
    assert!(error.to_string().contains("left_shoulder_pitch_joint"), "{error}");
}

#[test]
fn the_official_description_becomes_the_default_robot() {
    let shared = std::env::var_os("AGENTICFOCUS_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let path = shared.join("robots/g1_brainco/g1_29dof_mode_15_brainco_hand.urdf");
    if !path.is_file() {
        println!("skipped: {} is not there", path.display());
        return;
    }
    let data = tempfile::tempdir().unwrap();
    assert!(default_robot(data.path()).unwrap().is_none());
    let imported = import(&path, data.path()).unwrap();
    let report = &imported.report;
    assert_eq!(report.triangles, 626_921, "{report:?}");
    assert!(report.triangles_kept < 90_000, "{} triangles", report.triangles_kept);
    assert_eq!(
        (report.mimics, report.notes.iter().filter(|note| note.contains("fixed at 0")).count()),
        (10, 10)
    );
    let robot = default_robot(data.path()).unwrap().unwrap();
    let embedded = RobotModel::embedded().unwrap();
    let mut angles = crate::robot::JointAngles::default();
    for (index, angle) in angles.0.iter_mut().enumerate() {
        let (lower, upper) = (embedded.limits().lower[index], embedded.limits().upper[index]);
        *angle = lower + (upper - lower) * (0.2 + 0.02 * index as f64);
    }
    for side in crate::geometry::Side::BOTH {
        let distance =
            robot.wrist(side, &angles).position().distance(&embedded.wrist(side, &angles).position());
        assert!(distance < 1e-6, "{side:?}: wrists {distance} m apart");
        for (one, other) in robot.fingertips(side, &angles).iter().zip(embedded.fingertips(side, &angles)) {
            assert!(one.distance(&other) < 1e-6);
        }
    }
}
