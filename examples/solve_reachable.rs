//! `cargo run --example solve_reachable -- [SEED]`: wrist poses that the robot is known to reach, 150 frames at 30 FPS,
//! and how this program's solver does on them, as JSON. `tests/compare_ik.py` gives them to other solvers.
use agenticfocus::{
    geometry::Side,
    retarget::{Weights, reachable_motion, score_ik, score_ik_with},
    robot::RobotModel,
};
use serde_json::json;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seed = std::env::args().nth(1).map_or(Ok(1), |text| text.parse())?;
    let robot = RobotModel::embedded()?;
    let motion = reachable_motion(&robot, seed);
    let wrists = |side: Side| -> Vec<[f64; 7]> {
        motion.iter().map(|angles| robot.wrist(side, angles).to_xyz_wxyz()).collect()
    };
    let output = json!({
        "seed": seed,
        "mjcf": robot.mjcf(),
        "joints": robot.joint_names()[..14],
        "start": motion[0].arms(),
        // Origin of `{side}_base_link`, axes of `{side}_wrist_yaw_link`, in `torso_link`: x y z, w x y z.
        "wrists": { "left": wrists(Side::Left), "right": wrists(Side::Right) },
        // Arms and all fingers, warm-started from the frame before; as the product weighs them, and with nothing
        // that pulls away from the targets.
        "product": score_ik(&robot, seed),
        "ours": score_ik_with(&robot, seed, Weights { posture: 0.0, inertia: 0.0, ..Weights::default() }),
    });
    println!("{output}");
    Ok(())
}
