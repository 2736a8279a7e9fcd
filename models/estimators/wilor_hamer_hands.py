#!/usr/bin/env python3
"""WiLoR or HaMeR, as you installed them, as an AgenticFocus hand estimator (protocol agenticfocus-hands/1).

See ../README.md for the protocol. Neither package nor weights come with AgenticFocus: both have licences of their own.
Standard output carries the protocol alone, so everything else goes to standard error.
"""

import argparse
import importlib
import json
import os
import sys

PROTOCOL = "agenticfocus-hands/1"
SIDES = ("left", "right")


class Missing(Exception):
    """Something of the user's installation is not there; the message says what and what to do."""


def claim_stdout():
    """Keeps the real standard output for the protocol and sends every stray print to stderr."""
    channel = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return channel


def send(channel, message):
    channel.write(json.dumps(message, separators=(",", ":")).encode() + b"\n")
    channel.flush()


def read_exactly(stream, count):
    data = bytearray(count)
    view = memoryview(data)
    done = 0
    while done < count:
        got = stream.readinto(view[done:])
        if not got:
            raise EOFError(f"input ended {count - done} bytes before the picture was whole")
        done += got
    return data


def load(module, remedy):
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise Missing(f"the Python package {module} cannot be imported ({error}): {remedy}") from error


def existing(path, what, remedy):
    if not os.path.isfile(path):
        raise Missing(f"{what} is not at {path}: {remedy}")
    return path


def chosen_device(torch, wanted):
    if wanted:
        return torch.device(wanted)
    return torch.device("cuda" if torch.cuda.is_available() else "cpu")


def answer(side, score, keypoints, world):
    return {
        "side": side,
        "score": round(min(max(float(score), 0.0), 1.0), 6),
        "keypoints": [[round(float(v), 3) for v in point] for point in keypoints],
        "world": [[round(float(v), 6) for v in point] for point in world],
    }


def boxes_of(result):
    """Corners, trust and side (0 left, 1 right) of an Ultralytics result."""
    import numpy

    def array(values):
        values = values.cpu() if hasattr(values, "cpu") else values
        return numpy.asarray(values, dtype=numpy.float32)

    boxes = result.boxes
    return array(boxes.xyxy).reshape(-1, 4), array(boxes.conf).reshape(-1), array(boxes.cls).reshape(-1)


class Wilor:
    """WiLoR through the package wilor_mini, which brings its own detector."""

    name = "wilor"
    WEIGHTS = ("wilor_final.ckpt", "detector.pt", "MANO_RIGHT.pkl", "mano_mean_params.npz")

    def __init__(self, options):
        install = "install WiLoR-mini (github.com/warmshao/WiLoR-mini) into the Python that runs this script"
        torch = load("torch", "install PyTorch into the Python that runs this script")
        pipelines = load("wilor_mini.pipelines.wilor_hand_pose3d_estimation_pipeline", install)
        package = load("wilor_mini", install)
        folder = options.weights or os.path.dirname(os.path.abspath(package.__file__))
        if not options.download:
            for file in self.WEIGHTS:
                existing(
                    os.path.join(folder, "pretrained_models", file),
                    f"WiLoR's {file}",
                    "name the folder that holds pretrained_models/ with --weights, "
                    "or let the package fetch its weights with --download",
                )
        self.version = str(getattr(package, "__version__", "unknown"))
        self.options = options
        self.pipeline = pipelines.WiLorHandPose3dEstimationPipeline(
            device=chosen_device(torch, options.device),
            dtype=torch.float16 if options.half else torch.float32,
            verbose=False,
            wilor_pretrained_dir=folder,
        )

    def estimate(self, picture):
        # The pipeline turns the channels of its crops around, and its detector wants them so: blue first.
        picture = picture[:, :, ::-1].copy()
        found = self.pipeline.hand_detector(picture, conf=self.options.confidence, verbose=False)[0]
        boxes, scores, sides = boxes_of(found)
        if len(boxes) == 0:
            return []
        rescale = self.options.rescale or 2.5
        hands = self.pipeline.predict_with_bboxes(picture, boxes, sides.tolist(), rescale_factor=rescale)
        return [
            answer(
                SIDES[int(round(float(hand["is_right"])))],
                score,
                hand["wilor_preds"]["pred_keypoints_2d"].reshape(21, 2),
                hand["wilor_preds"]["pred_keypoints_3d"].reshape(21, 3),
            )
            for hand, score in zip(hands, scores)
        ]


class Hamer:
    """HaMeR through the package hamer, with hands from a detector of two classes, left and right."""

    name = "hamer"

    def __init__(self, options):
        install = "install HaMeR (github.com/geopavlakos/hamer) into the Python that runs this script"
        self.torch = load("torch", "install PyTorch into the Python that runs this script")
        models = load("hamer.models", install)
        self.dataset = load("hamer.datasets.vitdet_dataset", install).ViTDetDataset
        self.recursive_to = load("hamer.utils", install).recursive_to
        yolo = load("ultralytics", "install it: HaMeR has no hand detector of its own").YOLO
        if not options.detector:
            raise Missing("HaMeR has no hand detector of its own: name one with --detector, for example WiLoR's detector.pt")
        checkpoint = options.weights or models.DEFAULT_CHECKPOINT
        existing(checkpoint, "HaMeR's checkpoint", "name it with --weights, or run HaMeR's fetch_demo_data.sh")
        existing(options.detector, "the hand detector", "name it with --detector")
        self.version = str(getattr(load("hamer", install), "__version__", "unknown"))
        self.options = options
        self.device = chosen_device(self.torch, options.device)
        model, self.config = models.load_hamer(checkpoint)
        self.model = model.to(self.device)
        self.model.eval()
        self.detector = yolo(options.detector)

    def estimate(self, picture):
        import numpy

        height, width = picture.shape[:2]
        picture = picture[:, :, ::-1].copy()
        found = self.detector(picture, conf=self.options.confidence, verbose=False)[0]
        boxes, scores, sides = boxes_of(found)
        if len(boxes) == 0:
            return []
        rescale = self.options.rescale or 2.0
        dataset = self.dataset(self.config, picture, boxes, sides, rescale_factor=rescale)
        hands = []
        for batch in self.torch.utils.data.DataLoader(dataset, batch_size=8, shuffle=False, num_workers=0):
            batch = self.recursive_to(batch, self.device)
            with self.torch.no_grad():
                out = self.model(batch)

            def array(values):
                values = values.detach().cpu() if hasattr(values, "detach") else values
                return numpy.asarray(values, dtype=numpy.float64)

            cameras, joints = array(out["pred_cam"]), array(out["pred_keypoints_3d"])
            centres, sizes, right = array(batch["box_center"]), array(batch["box_size"]), array(batch["right"])
            focal = self.config.EXTRA.FOCAL_LENGTH / self.config.MODEL.IMAGE_SIZE * max(width, height)
            for camera, points, centre, size, is_right in zip(cameras, joints, centres, sizes, right):
                mirror = 2.0 * float(is_right) - 1.0
                points = points * [mirror, 1.0, 1.0]
                scaled = float(size) * camera[0] + 1e-9
                middle = numpy.array([width / 2.0, height / 2.0])
                shift = 2.0 * (centre - middle) / scaled + camera[1:3] * [mirror, 1.0]
                placed = points + [shift[0], shift[1], 2.0 * focal / scaled]
                seen = focal * placed[:, :2] / placed[:, 2:] + middle
                hands.append((SIDES[int(round(float(is_right)))], seen, points))
        return [answer(side, score, seen, world) for (side, seen, world), score in zip(hands, scores)]


def serve(options):
    channel = claim_stdout()
    source = sys.stdin.buffer
    numpy = load("numpy", "install it into the Python that runs this script")
    estimator = {"wilor": Wilor, "hamer": Hamer}[options.model](options)
    send(channel, {"protocol": PROTOCOL, "name": estimator.name, "version": estimator.version})
    while line := source.readline():
        request = json.loads(line)
        if "protocol" in request:
            if request["protocol"] != PROTOCOL:
                raise SystemExit(f"the host speaks {request['protocol']!r}, this estimator {PROTOCOL!r}")
            continue
        width, height = int(request["width"]), int(request["height"])
        pixels = read_exactly(source, width * height * 3)
        picture = numpy.frombuffer(pixels, numpy.uint8).reshape(height, width, 3)
        send(channel, {"id": request["id"], "hands": estimator.estimate(picture)})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", choices=("wilor", "hamer"), default="wilor", help="the installed package (wilor)")
    parser.add_argument("--weights", help="wilor: folder with pretrained_models/; hamer: checkpoint (the package's own place)")
    parser.add_argument("--detector", help="hamer: Ultralytics model of left (0) and right (1) hands")
    parser.add_argument("--download", action="store_true", help="wilor: let the package fetch missing weights")
    parser.add_argument("--device", help="for example cpu, cuda or cuda:1 (cuda where there is one)")
    parser.add_argument("--half", action="store_true", help="wilor: 16-bit floats")
    parser.add_argument("--confidence", type=float, default=0.3, help="detection threshold (0.3)")
    parser.add_argument("--rescale", type=float, help="by what boxes are enlarged (wilor 2.5, hamer 2)")
    try:
        serve(parser.parse_args())
    except Missing as missing:
        raise SystemExit(str(missing)) from None


if __name__ == "__main__":
    main()
