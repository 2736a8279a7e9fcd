//! The embedded model against the public description, MuJoCo and finite differences.
#![cfg(feature = "engine")]
#![allow(clippy::unwrap_used, reason = "a broken expectation is a failed test")]

use agenticfocus::{
    geometry::Side,
    robot::{ACTUATED_DOF, JointAngles, RobotModel, SIDE_DOF, SidePosture},
};
use mujoco_rs::prelude::*;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use serde::Deserialize;

#[derive(Deserialize)]
struct PoseRow {
    angles: JointAngles,
    left: SideRow,
    right: SideRow,
}

#[derive(Deserialize)]
struct SideRow {
    wrist: [f64; 7],
    fingertips: [[f64; 3]; 5],
}

fn robot() -> RobotModel {
    RobotModel::embedded().unwrap()
}

fn angle_between(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    2.0 * (a.inverse() * b).imag().norm().asin()
}

#[test]
fn the_embedded_model_reproduces_the_table_of_the_public_description() {
    let rows: Vec<PoseRow> = serde_json::from_str(include_str!("data/g1_brainco_poses.json")).unwrap();
    let robot = robot();
    for row in &rows {
        for (side, truth) in [(Side::Left, &row.left), (Side::Right, &row.right)] {
            let posture = robot.posture(side, &row.angles);
            let [x, y, z, qw, qx, qy, qz] = truth.wrist;
            let rotation = UnitQuaternion::from_quaternion(Quaternion::new(qw, qx, qy, qz));
            assert!((posture.wrist - Vector3::new(x, y, z)).norm() < 1e-6);
            assert!(angle_between(&posture.wrist_rotation, &rotation) < 1e-6);
            for (tip, truth) in posture.tips.iter().zip(&truth.fingertips) {
                assert!((tip - Vector3::from(*truth)).norm() < 1e-6);
            }
        }
    }
}

#[test]
fn the_embedded_model_agrees_with_the_description_on_disk() {
    let shared = std::env::var_os("AGENTICFOCUS_SHARED")
        .map_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/../shared").into(), std::path::PathBuf::from);
    let Ok(text) = std::fs::read_to_string(shared.join("robots/g1_brainco/joints.json")) else {
        println!("skipped: no {}/robots/g1_brainco", shared.display());
        return;
    };
    let official: Description = serde_json::from_str(&text).unwrap();
    let robot = robot();
    let names = robot.joint_names();
    for step in 0..20 {
        let angles = spread(&robot, step);
        let value = |name: &str| {
            let index = names.iter().position(|known| known == name);
            index.map(|index| angles.0[index])
        };
        for side in Side::BOTH {
            let posture = robot.posture(side, &angles);
            let base = official.pose(&format!("{}_base_link", side.name()), &value);
            let yaw = official.pose(&format!("{}_wrist_yaw_link", side.name()), &value);
            assert!((posture.wrist - base.translation.vector).norm() < 1e-6);
            assert!(angle_between(&posture.wrist_rotation, &yaw.rotation) < 1e-6);
            for (finger, name) in ["thumb", "index", "middle", "ring", "pinky"].iter().enumerate() {
                let tip = official.pose(&official.tip(side, name), &value);
                assert!((posture.tips[finger] - tip.translation.vector).norm() < 1e-6);
            }
        }
    }
    for joint in &official.joints {
        let Some(index) = names.iter().position(|known| *known == joint.name) else { continue };
        let limits = robot.limits();
        assert_eq!(limits.lower[index], joint.lower.unwrap());
        // A finger's own limit gives way where its coupled joint would pass 1.693 rad.
        assert!((limits.upper[index] - joint.upper.unwrap()).abs() < 5e-4, "{}", joint.name);
        assert_eq!(limits.velocity[index], joint.velocity.unwrap());
    }
}

#[test]
fn reduced_kinematics_equal_those_of_mujoco() {
    let robot = robot();
    let mut data = MjData::new(robot.mujoco().clone());
    for step in 0..10 {
        let angles = spread(&robot, step);
        let qpos = robot.qpos(&angles);
        data.qpos_mut().copy_from_slice(&qpos);
        data.forward();
        let find = |kind, name: &str| robot.mujoco().name_to_id(kind, name).unwrap();
        let torso = find(MjtObjBase::mjOBJ_BODY, "torso_link");
        let origin = Vector3::from(data.xpos()[torso]);
        for side in Side::BOTH {
            let posture = robot.posture(side, &angles);
            let base = find(MjtObjBase::mjOBJ_BODY, &format!("{}_base_link", side.name()));
            assert!((Vector3::from(data.xpos()[base]) - origin - posture.wrist).norm() < 1e-12);
            for (finger, name) in agenticfocus::robot::FINGERS.iter().enumerate() {
                let site = find(MjtObjBase::mjOBJ_SITE, &format!("{}_{name}_tip_site", side.name()));
                assert!(
                    (Vector3::from(data.site_xpos()[site]) - origin - posture.tips[finger]).norm() < 1e-12
                );
            }
        }
    }
}

#[test]
fn coupled_joints_stay_inside_their_own_limits() {
    let robot = robot();
    let model = robot.mujoco();
    for angles in [JointAngles(robot.limits().lower), JointAngles(robot.limits().upper)] {
        let qpos = robot.qpos(&angles);
        for (joint, range) in model.jnt_range().iter().enumerate() {
            let angle = qpos[model.jnt_qposadr()[joint] as usize];
            assert!(angle >= range[0] - 1e-12 && angle <= range[1] + 1e-12);
        }
    }
}

#[test]
fn the_palm_of_the_robot_is_turned_against_its_wrist_by_seven_degrees() {
    for side in Side::BOTH {
        let degrees = robot().chain(side).palm_in_wrist().angle().to_degrees();
        assert!((degrees - 7.4).abs() < 0.2, "{degrees}");
    }
}

#[test]
fn a_description_without_hands_is_refused_by_name() {
    let mjcf = "<mujoco><worldbody><body name='torso_link'/></worldbody></mujoco>";
    let error = RobotModel::from_mjcf(mjcf, &[]).unwrap_err();
    assert!(error.to_string().contains("left_shoulder_pitch_joint"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn jacobians_equal_finite_differences(shares in prop::collection::vec(0.05_f64..0.95, ACTUATED_DOF)) {
        let robot = robot();
        let limits = robot.limits();
        let angles = JointAngles(std::array::from_fn(|i| {
            limits.lower[i] + shares[i] * (limits.upper[i] - limits.lower[i])
        }));
        for side in Side::BOTH {
            let chain = robot.chain(side);
            let at = |angles: &[f64; SIDE_DOF]| {
                let mut posture = SidePosture::default();
                chain.pose(angles, &mut posture);
                posture
            };
            let q = angles.side(side);
            let here = at(&q);
            let (wrist, turn) = (chain.wrist_jacobian(&here), chain.wrist_rotation_jacobian(&here));
            for joint in 0..SIDE_DOF {
                let h = 1e-6;
                let (mut less, mut more) = (q, q);
                less[joint] -= h;
                more[joint] += h;
                let (less, more) = (at(&less), at(&more));
                let slope = (more.wrist - less.wrist) / (2.0 * h);
                prop_assert!((slope - wrist.column(joint)).norm() < 1e-8);
                let slope = (more.wrist_rotation * less.wrist_rotation.inverse()).scaled_axis() / (2.0 * h);
                prop_assert!((slope - turn.column(joint)).norm() < 1e-8);
                for finger in 0..5 {
                    let slope = (more.tips[finger] - less.tips[finger]) / (2.0 * h);
                    prop_assert!((slope - chain.tip_jacobian(&here, finger).column(joint)).norm() < 1e-8);
                }
            }
        }
    }
}

/// Angles spread over the limits, different for every `step`.
fn spread(robot: &RobotModel, step: usize) -> JointAngles {
    let limits = robot.limits();
    JointAngles(std::array::from_fn(|i| {
        let share = ((step * ACTUATED_DOF + i) as f64 * 0.618_033_988_75).fract();
        limits.lower[i] + share * (limits.upper[i] - limits.lower[i])
    }))
}

#[derive(Deserialize)]
struct Description {
    joints: Vec<Joint>,
}

#[derive(Deserialize)]
struct Joint {
    name: String,
    #[serde(rename = "type")]
    kind: String,
    parent: String,
    child: String,
    xyz: [f64; 3],
    rpy: [f64; 3],
    axis: Option<[f64; 3]>,
    lower: Option<f64>,
    upper: Option<f64>,
    velocity: Option<f64>,
    mimic: Option<Mimic>,
}

#[derive(Deserialize)]
struct Mimic {
    joint: String,
    multiplier: f64,
    offset: f64,
}

impl Description {
    fn tip(&self, side: Side, finger: &str) -> String {
        let wanted = format!("{}_{finger}_tip", side.name());
        let mut children = self.joints.iter().map(|joint| &joint.child);
        children.find(|child| child.trim_end_matches("_Link") == wanted).unwrap().clone()
    }

    /// The pose of `link` in `torso_link`, multiplied up from the numbers of the description.
    fn pose(&self, link: &str, value: &dyn Fn(&str) -> Option<f64>) -> Isometry3<f64> {
        if link == "torso_link" {
            return Isometry3::identity();
        }
        let joint = self.joints.iter().find(|joint| joint.child == link).unwrap();
        let [roll, pitch, yaw] = joint.rpy;
        let offset = Isometry3::from_parts(
            Translation3::from(Vector3::from(joint.xyz)),
            UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        );
        let angle = match &joint.mimic {
            Some(mimic) => value(&mimic.joint).unwrap() * mimic.multiplier + mimic.offset,
            None if joint.kind == "revolute" => value(&joint.name).unwrap(),
            None => 0.0,
        };
        let axis = Vector3::from(joint.axis.unwrap_or([0.0, 0.0, 1.0]));
        self.pose(&joint.parent, value) * offset * UnitQuaternion::from_scaled_axis(axis * angle)
    }
}
