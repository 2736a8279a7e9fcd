#!/usr/bin/env python3
"""MediaPipe Hands as an AgenticFocus hand estimator (protocol agenticfocus-hands/1).

See ../README.md for the protocol. Needs mediapipe 0.10.x with its bundled hand models; nothing is
downloaded. Standard output carries the protocol alone, so everything else goes to standard error.
"""

import argparse
import json
import os
import sys
import types

PROTOCOL = "agenticfocus-hands/1"


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


def spare_matplotlib():
    """Lets MediaPipe's drawing helpers, which are never called here, find an empty matplotlib.

    They load it whole as soon as MediaPipe is imported: two thirds of the time to the first frame.
    """
    package = types.ModuleType("matplotlib")
    package.pyplot = types.ModuleType("matplotlib.pyplot")
    sys.modules.setdefault("matplotlib", package)
    sys.modules.setdefault("matplotlib.pyplot", package.pyplot)


class Estimator:
    """A tracker for consecutive frames and a detector for single pictures, made when first needed."""

    def __init__(self, options):
        self.options = options
        self.solvers = {}

    def solver(self, mode):
        if mode not in self.solvers:
            from mediapipe.python.solutions import hands

            single = mode == "single"
            self.solvers[mode] = hands.Hands(
                static_image_mode=single,
                max_num_hands=self.options.max_hands,
                model_complexity=self.options.complexity,
                min_detection_confidence=self.options.single_confidence if single else self.options.confidence,
                min_tracking_confidence=self.options.confidence,
            )
        return self.solvers[mode]

    def estimate(self, picture, mode):
        height, width = picture.shape[:2]
        result = self.solver(mode).process(picture)
        hands = []
        if not result.multi_hand_landmarks:
            return hands
        for landmarks, world, handedness in zip(
            result.multi_hand_landmarks, result.multi_hand_world_landmarks, result.multi_handedness
        ):
            label = handedness.classification[0]
            # MediaPipe names sides as a mirrored selfie shows them; an unmirrored camera sees the other one.
            side = "right" if label.label.lower() == "left" else "left"
            hands.append(
                {
                    "side": side,
                    "score": round(float(label.score), 6),
                    # MediaPipe spans the picture from edge to edge; the protocol counts from pixel centres.
                    "keypoints": [
                        [round(p.x * width - 0.5, 3), round(p.y * height - 0.5, 3)] for p in landmarks.landmark
                    ],
                    "world": [[round(p.x, 6), round(p.y, 6), round(p.z, 6)] for p in world.landmark],
                }
            )
        return hands


def serve(options):
    channel = claim_stdout()
    source = sys.stdin.buffer
    import numpy

    spare_matplotlib()
    import mediapipe

    estimator = Estimator(options)
    send(channel, {"protocol": PROTOCOL, "name": "mediapipe", "version": mediapipe.__version__})
    while line := source.readline():
        request = json.loads(line)
        if "protocol" in request:
            if request["protocol"] != PROTOCOL:
                raise SystemExit(f"the host speaks {request['protocol']!r}, this estimator {PROTOCOL!r}")
            continue
        width, height = int(request["width"]), int(request["height"])
        pixels = read_exactly(source, width * height * 3)
        picture = numpy.frombuffer(pixels, numpy.uint8).reshape(height, width, 3)
        hands = estimator.estimate(picture, request.get("mode", "track"))
        send(channel, {"id": request["id"], "hands": hands})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--confidence", type=float, default=0.5, help="detection and tracking threshold (0.5)")
    parser.add_argument("--single-confidence", type=float, default=0.3, help="detection threshold on crops (0.3)")
    parser.add_argument("--max-hands", type=int, default=2, help="hands a picture (2)")
    parser.add_argument("--complexity", type=int, default=1, choices=(0, 1), help="landmark model: 0 lite, 1 full (1)")
    serve(parser.parse_args())


if __name__ == "__main__":
    main()
