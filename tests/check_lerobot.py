"""Checks a LeRobot dataset (v3.0 or v2.1) against the format's rules, with pyarrow and pandas alone.

usage: check_lerobot.py DATASET
"""

import json
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq

VIDEO = "observation.images.cam_left_high"
COLUMNS = ["observation.state", "action", "timestamp", "frame_index", "episode_index", "index", "task_index"]
QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}


def expect(condition, message):
    if not condition:
        sys.exit(f"check_lerobot: {message}")


def json_lines(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def probe(path):
    out = subprocess.run(
        ["ffprobe", "-v", "error", "-select_streams", "v:0", "-show_entries",
         "stream=codec_name,pix_fmt,width,height,avg_frame_rate,time_base:packet=pts", "-of", "json", str(path)],
        check=True, capture_output=True).stdout
    report = json.loads(out)
    stream = report["streams"][0]
    base = Fraction(stream["time_base"])
    return stream, sorted(Fraction(packet["pts"]) * base for packet in report["packets"])


def check_features(info):
    features = info["features"]
    for name in COLUMNS + [VIDEO]:
        expect(name in features, f"info.json declares no {name}")
    for name in ("observation.state", "action"):
        expect(features[name]["shape"] == [26] and len(features[name]["names"]) == 26, f"{name}: not 26 names")
        expect(features[name]["dtype"] == "float32", f"{name}: not float32")
    expect(features["timestamp"] == {"dtype": "float32", "shape": [1], "names": None}, "timestamp's declaration")
    expect(info["fps"] == 30 and isinstance(info["fps"], int), "fps is not the integer 30")
    expect(info["splits"] == {"train": f"0:{info['total_episodes']}"}, "splits")
    expect(info["robot_type"] == "Unitree_G1_Brainco", "robot_type")


def check_table(path, info, episode, first_index, length, task):
    table = pq.read_table(path)
    names = COLUMNS + [name for name in info["features"] if name.startswith("annotation.")]
    expect(table.column_names == names, f"{path}: columns {table.column_names}")
    expect(pq.ParquetFile(path).num_row_groups == 1, f"{path}: not one row group")
    frame = table.to_pandas()
    expect(len(frame) == length, f"{path}: {len(frame)} rows, expected {length}")
    expect((frame.episode_index == episode).all(), f"{path}: episode_index")
    expect((frame.frame_index == np.arange(length)).all(), f"{path}: frame_index")
    expect((frame["index"] == first_index + np.arange(length)).all(), f"{path}: index")
    expect((frame.task_index == task).all(), f"{path}: task_index")
    expect(frame.timestamp.dtype == np.float32, f"{path}: timestamp's type")
    expect(np.array_equal(frame.timestamp, np.arange(length, dtype=np.float32) / np.float32(30)), f"{path}: timestamp")
    state, action = (np.stack(frame[name]) for name in ("observation.state", "action"))
    expect(state.shape == action.shape == (length, 26) and state.dtype == np.float32, f"{path}: state's shape")
    expect(np.isfinite(state).all() and np.isfinite(action).all(), f"{path}: not finite")
    expect(np.array_equal(action[:-1], state[1:]) and np.array_equal(action[-1], state[-1]), f"{path}: action")
    expect(((state[:, 14:] >= 0) & (state[:, 14:] <= 1)).all(), f"{path}: hand commands outside 0..1")
    return frame, state, action


def check_video(path, info, length):
    stream, times = probe(path)
    height, width, _ = info["features"][VIDEO]["shape"]
    expect((stream["width"], stream["height"]) == (width, height), f"{path}: size")
    expect((stream["codec_name"], stream["pix_fmt"]) == ("h264", "yuv420p"), f"{path}: codec")
    expect(len(times) == length, f"{path}: {len(times)} frames, expected {length}")
    expect(times[0] == 0, f"{path}: the first time stamp is {times[0]}")
    expect(all(abs(time - Fraction(k, 30)) < Fraction(1, 10**4) for k, time in enumerate(times)),
           f"{path}: no constant 30 FPS")


def check_stats(stats, name, values):
    values = values.reshape(len(values), -1).astype(np.float64)
    expect(stats["count"] == [len(values)], f"{name}: count {stats['count']}")
    expected = {"min": values.min(0), "max": values.max(0), "mean": values.mean(0), "std": values.std(0)}
    expected |= {key: np.quantile(values, q, axis=0) for key, q in QUANTILES.items() if key in stats}
    for key, value in expected.items():
        expect(np.allclose(np.ravel(stats[key]), value, rtol=1e-6, atol=1e-7), f"{name}: {key}")


def check_picture_stats(stats, name):
    for key in ("min", "max", "mean", "std"):
        value = np.array(stats[key])
        expect(value.shape == (3, 1, 1), f"{name}: {key} has shape {value.shape}")
        expect(((value >= 0) & (value <= 1)).all(), f"{name}: {key} outside 0..1")


def check_v30(root, info):
    tasks = pd.read_parquet(root / "meta/tasks.parquet")
    expect(tasks.index.name == "task" and list(tasks.columns) == ["task_index"], "tasks.parquet: the sentence is no index")
    expect(all(isinstance(task, str) for task in tasks.index), "tasks.parquet: a task that is no sentence")
    episodes = pd.concat([pd.read_parquet(path) for path in sorted((root / "meta/episodes").glob("*/*.parquet"))])
    expect(len(episodes) == info["total_episodes"], "as many rows as episodes")
    everything, first = [], 0
    for number, row in enumerate(episodes.to_dict("records")):
        expect(row["episode_index"] == number and row["dataset_from_index"] == first, f"episode {number}: place")
        expect(row["dataset_to_index"] == first + row["length"], f"episode {number}: end")
        data = root / info["data_path"].format(chunk_index=row["data/chunk_index"], file_index=row["data/file_index"])
        task = int(tasks.loc[row["tasks"][0], "task_index"])
        frame, state, action = check_table(data, info, number, first, row["length"], task)
        video = root / info["video_path"].format(
            video_key=VIDEO, chunk_index=row[f"videos/{VIDEO}/chunk_index"], file_index=row[f"videos/{VIDEO}/file_index"])
        check_video(video, info, row["length"])
        expect(row[f"videos/{VIDEO}/from_timestamp"] == 0, "from_timestamp")
        expect(abs(row[f"videos/{VIDEO}/to_timestamp"] - row["length"] / 30) < 1e-9, "to_timestamp")
        for name, values in (("observation.state", state), ("action", action)):
            own = {key: row[f"stats/{name}/{key}"] for key in ("min", "max", "mean", "std", "count", *QUANTILES)}
            own["count"] = list(own["count"])
            check_stats(own, f"episode {number} {name}", values)
        first += row["length"]
        everything.append((frame, state, action))
    stats = json.loads((root / "meta/stats.json").read_text())
    check_stats(stats["observation.state"], "observation.state", np.concatenate([s for _, s, _ in everything]))
    check_stats(stats["action"], "action", np.concatenate([a for _, _, a in everything]))
    for name in ("timestamp", "frame_index", "episode_index", "index", "task_index"):
        check_stats(stats[name], name, np.concatenate([f[name].to_numpy() for f, _, _ in everything]))
    check_picture_stats(stats[VIDEO], VIDEO)
    return first


def check_v21(root, info):
    tasks = json_lines(root / "meta/tasks.jsonl")
    expect([task["task_index"] for task in tasks] == list(range(info["total_tasks"])), "tasks.jsonl")
    numbers = {task["task"]: task["task_index"] for task in tasks}
    episodes, all_stats = json_lines(root / "meta/episodes.jsonl"), json_lines(root / "meta/episodes_stats.jsonl")
    expect(len(episodes) == len(all_stats) == info["total_episodes"] == info["total_videos"], "episodes.jsonl")
    expect(info["total_chunks"] == -(-len(episodes) // info["chunks_size"]), "total_chunks")
    first = 0
    for number, (episode, stats) in enumerate(zip(episodes, all_stats)):
        expect(episode["episode_index"] == stats["episode_index"] == number, "episode_index")
        place = {"episode_chunk": number // info["chunks_size"], "episode_index": number}
        data, task = root / info["data_path"].format(**place), numbers[episode["tasks"][0]]
        frame, state, action = check_table(data, info, number, first, episode["length"], task)
        expect((frame["annotation.human.task_description"] == task).all(), "annotation.human.task_description")
        check_video(root / info["video_path"].format(video_key=VIDEO, **place), info, episode["length"])
        check_stats(stats["stats"]["observation.state"], "observation.state", state)
        check_stats(stats["stats"]["action"], "action", action)
        check_picture_stats(stats["stats"][VIDEO], VIDEO)
        first += episode["length"]
    modality = json.loads((root / "meta/modality.json").read_text())
    for kind in ("state", "action"):
        parts = sorted((part["start"], part["end"]) for part in modality[kind].values())
        expect(parts == [(0, 7), (7, 14), (14, 20), (20, 26)], f"modality.json: {kind}")
    expect(modality["video"]["rs_view"]["original_key"] == VIDEO, "modality.json: video")
    return first


def main():
    root = Path(sys.argv[1])
    info = json.loads((root / "meta/info.json").read_text())
    check_features(info)
    versions = {"v3.0": check_v30, "v2.1": check_v21}
    frames = versions[info["codebase_version"]](root, info)
    expect(frames == info["total_frames"], f"{frames} frames, info.json says {info['total_frames']}")
    print(f"check_lerobot: {info['total_episodes']} episodes, {frames} frames of {info['codebase_version']}: sound")


if __name__ == "__main__":
    main()
