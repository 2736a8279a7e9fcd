//! Model folders: found, checked, loaded by the real ONNX Runtime; hostile ones end in a message.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

#[path = "support/graph_writer.rs"]
mod graph_writer;
#[path = "support/onnx_runtime.rs"]
mod onnx_runtime;

use std::{
    fs,
    path::{Path, PathBuf},
};

use agenticfocus::onnx::{
    Dim, ElementType, Graph, GraphSpec, ModelFolder, OnnxError, Registry, Sizes, TensorSpec, Trust, Value,
    hash_file,
};
use graph_writer::{Element, GraphWriter, Value as Attribute};
use onnx_runtime::runtime;

const DOUBLE: GraphSpec = GraphSpec {
    name: "double",
    inputs: &[
        TensorSpec::floats("x", &[&[Dim::Of("N")]]),
        TensorSpec::of("flag", &[ElementType::Bool], &[&[], &[Dim::Exactly(1)]]).if_there(),
    ],
    outputs: &[TensorSpec::floats("y", &[&[Dim::Of("N")]])],
    optional: false,
};

fn double() -> GraphWriter {
    GraphWriter::new().input("x", Element::F32, &[-1]).node("Add", &["x", "x"], "y", &[]).output(
        "y",
        Element::F32,
        &[-1],
    )
}

const DESCRIPTION: &str = "contract = \"test/1\"\nname = \"Double\"\nlicence = \"MIT\"\n";

fn model(root: &Path, description: &str, graph: &[u8]) -> PathBuf {
    let folder = root.join("double");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("model.toml"), description).unwrap();
    fs::write(folder.join("double.onnx"), graph).unwrap();
    folder
}

fn anyone(registry: &Registry) -> Trust<'_> {
    Trust { registry, unlisted: true }
}

fn check(root: &Path) -> Result<PathBuf, OnnxError> {
    let found = ModelFolder::find(&[root.to_owned()]).remove(0)?;
    let registry = Registry::default();
    Ok(found.checked(&[DOUBLE], anyone(&registry))?.file("double")?.to_owned())
}

#[test]
fn a_graph_runs_on_what_its_contract_calls_its_tensors() {
    let Some(runtime) = runtime() else { return };
    let root = tempfile::tempdir().unwrap();
    model(root.path(), DESCRIPTION, &double().bytes());
    let path = check(root.path()).unwrap();
    let mut graph = Graph::open(&runtime, &path, &DOUBLE, &mut Sizes::default()).unwrap();
    let x = Value::floats(&[3], vec![1.0, -2.0, 0.5]).unwrap();
    let flag = Value::flag(true).unwrap();
    let outputs = graph.run(&[("x", &x), ("flag", &flag)]).unwrap();
    assert_eq!(outputs.floats("y").unwrap(), [2.0, -4.0, 1.0]);
    assert!(matches!(graph.run(&[]), Err(OnnxError::Run { .. })));
}

#[test]
fn a_scalar_flag_is_fed_as_a_scalar_and_integers_as_the_graph_declares_them() {
    let Some(runtime) = runtime() else { return };
    const SPEC: GraphSpec = GraphSpec {
        name: "double",
        inputs: &[
            TensorSpec::of("flag", &[ElementType::Bool], &[&[], &[Dim::Exactly(1)]]),
            TensorSpec::of(
                "labels",
                &[ElementType::I32, ElementType::I64, ElementType::F32],
                &[&[Dim::Any("n")]],
            ),
        ],
        outputs: &[TensorSpec::floats("y", &[&[Dim::Any("n")]])],
        optional: false,
    };
    for element in [Element::I32, Element::I64, Element::F32] {
        let writer = GraphWriter::new()
            .input("flag", Element::Bool, &[])
            .input("labels", element, &[2])
            .node("Cast", &["flag"], "one", &[("to", Attribute::Integer(1))])
            .node("Cast", &["labels"], "numbers", &[("to", Attribute::Integer(1))])
            .node("Add", &["one", "numbers"], "y", &[])
            .output("y", Element::F32, &[2]);
        let root = tempfile::tempdir().unwrap();
        model(root.path(), DESCRIPTION, &writer.bytes());
        let path = check(root.path()).unwrap();
        let mut graph = Graph::open(&runtime, &path, &SPEC, &mut Sizes::default()).unwrap();
        let labels = Value::integers(&[2], vec![2, -1]).unwrap();
        let outputs = graph.run(&[("flag", &Value::flag(true).unwrap()), ("labels", &labels)]).unwrap();
        assert_eq!(outputs.floats("y").unwrap(), [3.0, 0.0]);
    }
}

#[test]
fn a_file_that_is_not_listed_is_refused_unless_that_is_allowed() {
    let root = tempfile::tempdir().unwrap();
    let folder = model(root.path(), DESCRIPTION, &double().bytes());
    let found = ModelFolder::find(&[root.path().to_owned()]).remove(0).unwrap();
    let strict = Registry::load(None).unwrap();
    let refused = found.checked(&[DOUBLE], Trust { registry: &strict, unlisted: false });
    assert!(matches!(refused, Err(OnnxError::Unlisted { .. })), "{refused:?}");
    assert!(found.checked(&[DOUBLE], anyone(&strict)).is_ok());

    let hash = hash_file(&folder.join("double.onnx")).unwrap();
    let list = format!(
        "[[model]]\nname = \"D\"\ncontract = \"test/1\"\nlicence = \"MIT\"\nrecipe = \"mine\"\nsha256 = [\"{hash}\"]\n"
    );
    fs::write(root.path().join("registry.toml"), list).unwrap();
    let own = Registry::load(Some(root.path())).unwrap();
    assert!(found.checked(&[DOUBLE], Trust { registry: &own, unlisted: false }).is_ok());
}

#[test]
fn an_altered_file_is_refused_even_where_unlisted_ones_are_allowed() {
    let root = tempfile::tempdir().unwrap();
    let description = format!("{DESCRIPTION}[sha256]\n\"double.onnx\" = \"{}\"\n", "0".repeat(64));
    model(root.path(), &description, &double().bytes());
    assert!(matches!(check(root.path()), Err(OnnxError::Altered { .. })));
}

#[test]
fn nothing_outside_the_folder_is_ever_named() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("secret.bin"), [0; 16]).unwrap();
    for name in ["../secret.bin", "/etc/passwd", "a/../../secret.bin", "", ".", ".."] {
        let graph = double().external("w", &[4], name);
        model(root.path(), DESCRIPTION, &graph.bytes());
        assert!(matches!(check(root.path()), Err(OnnxError::Outside { .. })), "weights in {name:?}");
        let description = format!("{DESCRIPTION}[files]\ndouble = \"{name}\"\n");
        model(root.path(), &description, &double().bytes());
        assert!(matches!(check(root.path()), Err(OnnxError::Outside { .. })), "a graph in {name:?}");
    }
    #[cfg(unix)]
    {
        let graph = double().external("w", &[4], "weights.bin");
        let folder = model(root.path(), DESCRIPTION, &graph.bytes());
        std::os::unix::fs::symlink("../secret.bin", folder.join("weights.bin")).unwrap();
        assert!(matches!(check(root.path()), Err(OnnxError::Outside { .. })), "weights by a link");
    }
}

#[test]
fn broken_graphs_end_in_a_message() {
    let Some(runtime) = runtime() else { return };
    let whole = double().bytes();
    let root = tempfile::tempdir().unwrap();
    let mut cases: Vec<(Vec<u8>, &str)> = vec![
        (Vec::new(), "empty"),
        (b"not an ONNX file at all, only text".to_vec(), "text"),
        (double().bytes_of_set(999).clone(), "an operator set of the future"),
        (GraphWriter::new().node("NoSuchOperator", &["x"], "y", &[]).bytes(), "an unknown operator"),
        (double().node("EPContext", &["x"], "z", &[]).bytes(), "an operator that reads files"),
    ];
    cases.extend((1..whole.len()).step_by(7).map(|length| (whole[..length].to_vec(), "cut off")));
    for at in (0..whole.len()).step_by(5) {
        let mut flipped = whole.clone();
        flipped[at] ^= 0x15;
        cases.push((flipped, "one byte changed"));
    }
    for (bytes, what) in cases {
        model(root.path(), DESCRIPTION, &bytes);
        let opened = check(root.path())
            .and_then(|path| Graph::open(&runtime, &path, &DOUBLE, &mut Sizes::default()).map(drop));
        // A changed byte may leave a graph that works; nothing else may.
        if what != "one byte changed" {
            assert!(opened.is_err(), "{what} ({} bytes) was taken", bytes.len());
        }
    }
}

#[test]
fn a_file_too_large_for_a_graph_is_refused_without_being_read() {
    let root = tempfile::tempdir().unwrap();
    let folder = model(root.path(), DESCRIPTION, &[]);
    let file = fs::OpenOptions::new().write(true).open(folder.join("double.onnx")).unwrap();
    file.set_len(3 << 30).unwrap();
    assert!(matches!(check(root.path()), Err(OnnxError::TooLarge { .. })));
}

#[test]
fn a_wrong_description_names_its_key() {
    let root = tempfile::tempdir().unwrap();
    model(root.path(), &format!("{DESCRIPTION}colour = 3\n"), &double().bytes());
    let error = check(root.path()).unwrap_err().to_string();
    assert!(error.contains("colour") && error.contains("line 4"), "{error}");
}
