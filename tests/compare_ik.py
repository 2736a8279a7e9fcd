#!/usr/bin/env python3
"""Our inverse kinematics beside pink and mink: the same robot, the same reachable wrist poses, one run.

    pip install pin-pink mink daqp          (in an environment of its own)
    cargo build --release --example solve_reachable
    python3 tests/compare_ik.py [PROGRAM] [SEED]

PROGRAM defaults to target/release/examples/solve_reachable. Prints a line a solver and, last, whether the error is
no worse and the time at least ten times less; exit status 1 where not, 0 too where a package is missing.
All are warm-started from the frame before and see both wrists; ours solves all ten fingers as well. "Posture held"
is as the product does it: two small weights choose among an arm's many ways and cost a ten-thousandth of a
millimetre. The others are asked for no posture, so they are compared with ours without.
"""
import json
import os
import statistics
import subprocess
import sys
import time

# One core for everybody.
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"

try:
    import mink
    import mujoco
    import numpy as np
    import pink
    import pinocchio as pin
except ImportError as error:
    print(f"skipped: {error}; pip install pin-pink mink daqp")
    sys.exit(0)

ITERATIONS = (1, 5)
PERIOD = 1 / 30
# Below a nanometre errors are rounding: they count as equal, millimetres.
ROUNDING = 1e-6
SIDES = ("left", "right")


def arms_only(problem):
    """The robot with its 14 arm joints alone, and a site where each wrist frame is."""
    spec = mujoco.MjSpec.from_string(problem["mjcf"])
    for equality in list(spec.equalities):
        spec.delete(equality)
    for joint in list(spec.joints):
        if joint.name not in problem["joints"]:
            spec.delete(joint)
    for side in SIDES:
        base = spec.body(f"{side}_base_link").pos
        spec.body(f"{side}_wrist_yaw_link").add_site(name=f"{side}_wrist", pos=base)
    return spec.compile()


def targets_of(problem, model):
    """World poses of the wrists, frame by frame, as (rotation, position)."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    torso = model.body("torso_link").id
    turn, origin = data.xmat[torso].reshape(3, 3), data.xpos[torso]
    frames = []
    for rows in zip(*(problem["wrists"][side] for side in SIDES)):
        poses = []
        for row in rows:
            rotation = np.zeros(9)
            mujoco.mju_quat2Mat(rotation, np.array(row[3:]))
            poses.append((turn @ rotation.reshape(3, 3), turn @ np.array(row[:3]) + origin))
        frames.append(poses)
    return frames


class Pinocchio:
    """The same chain for pinocchio, joint by joint, so that no parser comes between."""

    def __init__(self, model, names):
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        self.model = pin.Model()
        at = {}
        for name in names:
            joint = model.joint(name)
            body = joint.bodyid[0]
            pose = pin.SE3(data.xmat[body].reshape(3, 3), data.xpos[body])
            parent = body
            while True:
                parent = model.body_parentid[parent]
                if parent == 0 or model.body_jntnum[parent]:
                    break
            parent_id, parent_pose = at.get(parent, (0, pin.SE3.Identity()))
            joint_id = self.model.addJoint(
                parent_id,
                pin.JointModelRevoluteUnaligned(*joint.axis),
                parent_pose.actInv(pose),
                name,
                np.array([50.0]),
                np.array([37.0]),
                np.array([joint.range[0]]),
                np.array([joint.range[1]]),
            )
            at[body] = (joint_id, pose)
        for side in SIDES:
            site = model.site(f"{side}_wrist").id
            body = model.site_bodyid[site]
            joint_id, pose = at[body]
            place = pin.SE3(data.site_xmat[site].reshape(3, 3), data.site_xpos[site])
            frame = pin.Frame(f"{side}_wrist", joint_id, 0, pose.actInv(place), pin.FrameType.OP_FRAME)
            self.model.addFrame(frame)
        self.data = self.model.createData()


def run_pink(robot, start, targets, iterations):
    configuration = pink.Configuration(robot.model, robot.data, start.copy())
    tasks = [
        pink.FrameTask(f"{side}_wrist", position_cost=1.0, orientation_cost=1.0) for side in SIDES
    ]
    solved, times = [], []
    for poses in targets:
        began = time.process_time()
        for task, (rotation, position) in zip(tasks, poses):
            task.set_target(pin.SE3(rotation, position))
        for _ in range(iterations):
            velocity = pink.solve_ik(configuration, tasks, PERIOD, solver="daqp")
            configuration.integrate_inplace(velocity, PERIOD)
        times.append(time.process_time() - began)
        solved.append(configuration.q.copy())
    return solved, times


def run_mink(model, start, targets, iterations):
    configuration = mink.Configuration(model)
    configuration.update(start.copy())
    tasks = [
        mink.FrameTask(f"{side}_wrist", "site", position_cost=1.0, orientation_cost=1.0) for side in SIDES
    ]
    limits = [mink.ConfigurationLimit(model)]
    solved, times = [], []
    for poses in targets:
        began = time.process_time()
        for task, (rotation, position) in zip(tasks, poses):
            task.set_target(mink.SE3.from_rotation_and_translation(mink.SO3.from_matrix(rotation), position))
        for _ in range(iterations):
            velocity = mink.solve_ik(configuration, tasks, PERIOD, solver="daqp", damping=1e-12, limits=limits)
            configuration.integrate_inplace(velocity, PERIOD)
        times.append(time.process_time() - began)
        solved.append(configuration.q.copy())
    return solved, times


def errors_of(model, solved, targets):
    """Mean and largest distance of the wrists, millimetres, and mean angle, degrees."""
    data = mujoco.MjData(model)
    distances, angles = [], []
    for q, poses in zip(solved, targets):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        for side, (rotation, position) in zip(SIDES, poses):
            site = model.site(f"{side}_wrist").id
            distances.append(1e3 * np.linalg.norm(data.site_xpos[site] - position))
            trace = np.trace(rotation.T @ data.site_xmat[site].reshape(3, 3))
            angles.append(np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1))))
    return float(np.mean(distances)), float(np.max(distances)), float(np.mean(angles))


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "target/release/examples/solve_reachable"
    seed = sys.argv[2] if len(sys.argv) > 2 else "1"
    problem = json.loads(subprocess.run([program, seed], check=True, capture_output=True).stdout)
    model = arms_only(problem)
    targets = targets_of(problem, model)
    # MuJoCo orders joints as the tree does: left arm, right arm, as ours.
    names = [model.joint(index).name for index in range(model.njnt)]
    start = np.array([problem["start"][problem["joints"].index(name)] for name in names])
    ours = problem["ours"]
    line = "{:<20}{:>10.1e} mm mean{:>10.1e} mm max{:>10.1e} deg{:>9.4f} ms a frame"
    keys = ("position_error_mm", "position_error_max_mm", "rotation_error_deg", "time_ms")
    product, own = ([figures[key] for key in keys] for figures in (problem["product"], ours))
    print(line.format("ours, posture held", *product))
    print(line.format("ours", *own))
    robot = Pinocchio(model, names)
    verdict = True
    for iterations in ITERATIONS:
        for name, (solved, times) in (
            ("pink", run_pink(robot, start, targets, iterations)),
            ("mink", run_mink(model, start, targets, iterations)),
        ):
            mean, largest, angle = errors_of(model, solved, targets)
            milliseconds = 1e3 * statistics.median(times)
            print(line.format(f"{name}, {iterations} iterations", mean, largest, angle, milliseconds))
            if iterations == max(ITERATIONS):
                verdict &= own[0] <= max(mean, ROUNDING) and 10 * max(own[3], product[3]) <= milliseconds
    print("error no worse and ten times faster:", "yes" if verdict else "NO")
    sys.exit(0 if verdict else 1)


if __name__ == "__main__":
    main()
