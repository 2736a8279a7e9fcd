//! Contracts against what the public exporters' graphs declare, and one mismatch of each kind for every tensor.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

use agenticfocus::{
    hands::network::HAND_POSE,
    inpaint::{network::IMAGE_INPAINT, video::VIDEO_INPAINT},
    onnx::{Contract, Declared, ElementType, Mismatch, Sizes, bind},
    segment::sam2::{SAM2_IMAGE, SAM2_VIDEO},
};

/// Inputs and outputs of each graph, one tensor a word: `name:type:size,size`; sizes may be multiples of S.
struct Export {
    exporter: &'static str,
    contract: Contract,
    graphs: Vec<(String, String)>,
}

fn sam2_video(s: i64) -> Export {
    let (q, e, t) = (s / 4, s / 8, s / 16);
    let hw = t * t;
    let map = format!("pix_feat_with_mem:f32:1,256,{t},{t}");
    Export {
        exporter: "wp133716/samurai-onnx",
        contract: SAM2_VIDEO,
        graphs: vec![
            (
                format!("image:f32:1,{s},{s},3"),
                format!(
                    "high_res_features0:f32:1,32,{q},{q} high_res_features1:f32:1,64,{e},{e} \
                     low_res_features:f32:{hw},1,256 vision_pos_embeds:f32:{hw},1,256 {map}"
                ),
            ),
            (
                format!(
                    "current_vision_feats:f32:{hw},1,256 current_vision_pos_embeds:f32:{hw},1,256 \
                     maskmem_feats:f32:{hw},-1,1,64 memory_pos_embed:f32:{hw},-1,1,64 obj_ptrs:f32:-1,1,256 \
                     obj_pos:i32:-1"
                ),
                map.clone(),
            ),
            (
                format!(
                    "point_coords:f32:1,2,2 point_labels:i32:1,2 {map} high_res_features_0:f32:1,32,{q},{q} \
                     high_res_features_1:f32:1,64,{e},{e}"
                ),
                format!(
                    "low_res_multimasks:f32:1,3,{q},{q} ious:f32:1,3 obj_ptr:f32:1,3,256 \
                     object_score_logits:f32:1,1 maskmem_tpos_enc:f32:7,1,1,64"
                ),
            ),
            (
                format!(
                    "pix_feat:f32:{hw},1,256 mask_for_mem:f32:1,1,{s},{s} object_score_logits:f32:1,1 \
                     is_mask_from_pts:bool:"
                ),
                format!("maskmem_features:f32:{hw},1,64 maskmem_pos_enc:f32:{hw},1,64"),
            ),
        ],
    }
}

fn sam2_image(s: i64) -> Vec<Export> {
    let (q, e, t) = (s / 4, s / 8, s / 16);
    let features = |names: [&str; 3]| {
        let [high_0, high_1, embedding] = names;
        format!("{high_0}:f32:1,32,{q},{q} {high_1}:f32:1,64,{e},{e} {embedding}:f32:1,256,{t},{t}")
    };
    let export = |exporter, image: &str, names, decoder: String, outputs: String| Export {
        exporter,
        contract: SAM2_IMAGE,
        graphs: vec![
            (format!("{image}:f32:-1,3,{s},{s}"), features(names)),
            (format!("{} {decoder}", features(names)), outputs),
        ],
    };
    vec![
        export(
            "vietanhdev/samexporter",
            "image",
            ["high_res_feats_0", "high_res_feats_1", "image_embed"],
            format!(
                "point_coords:f32:-1,-1,2 point_labels:f32:-1,-1 mask_input:f32:-1,1,{q},{q} has_mask_input:f32:1"
            ),
            format!("masks:f32:-1,3,{q},{q} iou_predictions:f32:-1,3"),
        ),
        export(
            "microsoft/onnxruntime",
            "image",
            ["image_features_0", "image_features_1", "image_embeddings"],
            format!(
                "point_coords:f32:-1,-1,2 point_labels:i32:-1,-1 input_masks:f32:-1,1,{q},{q} \
                 has_input_masks:f32:-1 original_image_size:i32:2"
            ),
            format!("masks:f32:-1,-1,-1,-1 iou_predictions:f32:-1,-1 low_res_masks:f32:-1,-1,{q},{q}"),
        ),
        export(
            "onnx-community, of huggingface/transformers.js",
            "pixel_values",
            ["image_embeddings.0", "image_embeddings.1", "image_embeddings.2"],
            "input_points:f32:-1,-1,-1,2 input_labels:i64:-1,-1,-1 input_boxes:f32:-1,-1,4".to_owned(),
            format!("iou_scores:f32:-1,-1,3 pred_masks:f32:-1,-1,3,{q},{q} object_score_logits:f32:-1,-1,1"),
        ),
    ]
}

fn e2fgvi(height: i64, width: i64) -> Export {
    Export {
        exporter: "E2FGVI-HQ",
        contract: VIDEO_INPAINT,
        graphs: vec![(
            format!("masked_frames:f32:1,17,3,{height},{width}"),
            format!("pred_frames:f32:11,3,{height},{width} flows:f32:1,10,2,60,108"),
        )],
    }
}

/// A detector and a regressor; `img` with its shape, and what the regressor returns beside camera and joints.
fn hand_pose(exporter: &'static str, detector: [&str; 2], img: &str, more: &str) -> Export {
    let [images, output] = detector;
    Export {
        exporter,
        contract: HAND_POSE,
        graphs: vec![
            (format!("images:f32:{images}"), format!("output0:f32:{output}")),
            (
                format!("img:f32:{img}"),
                format!("pred_cam:f32:-1,3 pred_keypoints_3d:f32:-1,21,3 pred_vertices:f32:-1,778,3 {more}"),
            ),
        ],
    }
}

fn hand_poses() -> Vec<Export> {
    let pose = ["1,3,640,640", "1,69,8400"];
    let matrices = "global_orient:f32:-1,1,3,3 hand_pose:f32:-1,15,3,3 betas:f32:-1,10";
    let axes = "global_orient:f32:1,1,3 hand_pose:f32:1,15,3 betas:f32:1,10";
    vec![
        hand_pose("WiLoR", pose, "-1,3,256,256", matrices),
        hand_pose("WiLoR-mini", ["1,3,512,512", "1,69,5376"], "1,256,256,3", axes),
        hand_pose("HaMeR, boxes alone", ["1,3,640,640", "1,6,8400"], "1,3,256,256", ""),
        hand_pose("HaMeR, boxes already chosen", ["1,3,640,640", "1,300,6"], "-1,3,256,256", matrices),
    ]
}

fn lama() -> Export {
    Export {
        exporter: "LaMa",
        contract: IMAGE_INPAINT,
        graphs: vec![(
            "image:f32:-1,3,512,512 mask:f32:-1,1,512,512".to_owned(),
            "output:f32:-1,3,512,512".to_owned(),
        )],
    }
}

fn exports() -> Vec<Export> {
    let mut all = vec![e2fgvi(240, 432), e2fgvi(480, 864), lama()];
    all.extend(hand_poses());
    for side in [512, 1024] {
        all.push(sam2_video(side));
        all.extend(sam2_image(side));
    }
    all
}

fn tensors(words: &str) -> Vec<Declared> {
    let tensor = |word: &str| {
        let mut parts = word.split(':');
        let (name, kind, shape) = (parts.next().unwrap(), parts.next().unwrap(), parts.next().unwrap());
        let element = match kind {
            "f32" => Ok(ElementType::F32),
            "i32" => Ok(ElementType::I32),
            "i64" => Ok(ElementType::I64),
            "bool" => Ok(ElementType::Bool),
            other => Err(other.to_owned()),
        };
        let shape =
            shape.split(',').filter(|size| !size.is_empty()).map(|size| size.parse().unwrap()).collect();
        Declared { name: name.to_owned(), element, shape }
    };
    words.split_whitespace().map(tensor).collect()
}

#[test]
fn what_the_public_exporters_declare_is_accepted() {
    for Export { exporter, contract, graphs } in exports() {
        let mut sizes = Sizes::default();
        for (spec, (inputs, outputs)) in contract.graphs.iter().zip(&graphs) {
            if let Err(mismatch) = bind(spec, &tensors(inputs), &tensors(outputs), &mut sizes) {
                panic!("{exporter}, {}: {mismatch}", spec.name);
            }
        }
        let symbol = match contract.id {
            id if id == VIDEO_INPAINT.id => "H",
            id if id == HAND_POSE.id => "N",
            _ => "S",
        };
        assert!(sizes.get(symbol).is_ok_and(|size| size >= 240), "{exporter}");
    }
}

#[test]
fn each_tensor_that_differs_is_named_with_what_was_expected_of_it() {
    for Export { exporter, contract, graphs } in exports() {
        for (spec, (inputs, outputs)) in contract.graphs.iter().zip(&graphs) {
            let (inputs, outputs) = (tensors(inputs), tensors(outputs));
            let all = inputs.len() + outputs.len();
            for at in 0..all {
                let probe = |change: &dyn Fn(&mut Declared)| {
                    let mut both = [inputs.clone(), outputs.clone()];
                    let (side, at) = if at < inputs.len() { (0, at) } else { (1, at - inputs.len()) };
                    change(&mut both[side][at]);
                    bind(spec, &both[0], &both[1], &mut Sizes::default()).map(|_| both[side][at].name.clone())
                };
                let name =
                    if at < inputs.len() { &inputs[at].name } else { &outputs[at - inputs.len()].name };
                let parts = spec.inputs.iter().chain(spec.outputs);
                // Outputs that nobody reads may be anything; of two names for one part only the first counts.
                let Some(part) = parts.clone().find(|part| part.is_named(name)) else { continue };
                let shadowed = name != part.name && outputs.iter().any(|other| other.name == part.name);
                if shadowed {
                    continue;
                }
                let expected = part.to_string();
                let says = |found: Result<String, Mismatch>, kind: &str| {
                    let error = found.expect_err(&format!("{exporter}: {name} of another {kind} was taken"));
                    assert!(error.to_string().contains(&expected), "{exporter}: {error}");
                };
                says(probe(&|tensor| tensor.element = Err("f64".to_owned())), "type");
                says(probe(&|tensor| tensor.shape.extend([7, 7])), "rank");
                let renamed = probe(&|tensor| tensor.name = "other".to_owned());
                if outputs.iter().filter(|other| part.is_named(&other.name)).count() > 1 {
                    // Another output goes by one of the part's names.
                    continue;
                }
                if part.optional && at >= inputs.len() {
                    assert!(renamed.is_ok(), "{exporter}: nobody needs {name}");
                } else if part.optional {
                    assert!(matches!(renamed, Err(Mismatch::Unexpected { .. })), "{exporter}: {renamed:?}");
                } else {
                    says(renamed, "name");
                }
            }
        }
    }
}
