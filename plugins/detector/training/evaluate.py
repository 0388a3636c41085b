"""Measures an ONNX detector on a part of the clips: by picture, and by track."""

import argparse
import json
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import onnxruntime

from clips import CLASSES, TEST_FOLD, Clip, read_boxes, read_split
from detect import Network, of_clip
from metrics import Tally, Vote
from track import Tracker

DRONE = CLASSES.index("drone")


def session(path: Path) -> onnxruntime.InferenceSession:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])


def network(path: Path) -> Network:
    """Runs an ONNX file on one core."""
    runner = session(path)

    def run(picture: np.ndarray) -> np.ndarray:
        images = picture.transpose(2, 0, 1)[None].astype(np.float32) / 255
        return runner.run(None, {"images": images})[0][0]

    return run


def pictures_per_s(path: Path, pictures: int = 100) -> float:
    """How many pictures a second the network alone takes, on one core."""
    runner = session(path)
    images = np.zeros(runner.get_inputs()[0].shape, np.float32)
    runner.run(None, {"images": images})
    start_s = time.perf_counter()
    for _ in range(pictures):
        runner.run(None, {"images": images})
    return pictures / (time.perf_counter() - start_s)


@dataclass(frozen=True)
class Picture:
    """Labelled box as given and in time (or none), detections and tracks of one picture."""

    given: np.ndarray | None
    in_time: np.ndarray | None
    detections: np.ndarray
    tracks: np.ndarray


def collect(run: Network, data: Path, clips: list[Clip], step: int) -> dict[str, list[Picture]]:
    """Per clip its pictures."""
    pictures = {}
    for clip in clips:
        given, in_time = (read_boxes(data, clip, in_time=late) for late in (False, True))
        tracker = Tracker()
        pictures[clip.name] = [
            Picture(given.get(number), in_time.get(number), rows, tracker.step(rows))
            for number, rows in of_clip(run, data, clip, step)
        ]
    return pictures


def figures(
    clips: list[Clip],
    pictures: dict[str, list[Picture]],
    rows_of: str,
    labels: str,
    threshold: float | None,
) -> dict:
    """What the documents say of "detections" or "tracks", by labels as "given" or "in_time"."""
    tally, drones_alone = Tally(), Tally()
    for clip in clips:
        for picture in pictures[clip.name]:
            seen = getattr(picture, rows_of), getattr(picture, labels), clip.class_id
            tally.add(*seen)
            if clip.class_id == DRONE:
                drones_alone.add(*seen)
    if threshold is None:
        threshold = tally.best_threshold(DRONE)
    out: dict = {"threshold": round(threshold, 3)}
    for class_id, name in enumerate(CLASSES):
        precision, recall, f1 = tally.at(class_id, threshold)
        out[name] = {
            "f1": round(f1, 3),
            "precision": round(precision, 3),
            "recall": round(recall, 3),
            "ap50": round(tally.average_precision(class_id), 3),
            "objects": tally.objects[class_id],
        }
    out["drone_f1_on_clips_of_drones"] = round(drones_alone.at(DRONE, threshold)[2], 3)
    out["ap50_mean"] = round(float(np.mean([out[name]["ap50"] for name in CLASSES])), 3)
    votes: dict[str, Counter] = {name: Counter() for name in CLASSES}
    by_clip = {}
    for clip in clips:
        vote, alone = Vote(), Tally()
        for picture in pictures[clip.name]:
            rows = getattr(picture, rows_of)
            vote.add(rows, threshold)
            alone.add(rows, getattr(picture, labels), clip.class_id)
        votes[clip.label][vote.winner()] += 1
        drones = np.array(alone.scores[DRONE]) >= threshold
        by_clip[clip.name] = {
            "vote": vote.winner(),
            "f1": round(alone.at(clip.class_id, threshold)[2], 3),
            "called_drone_wrongly": int((drones & ~np.array(alone.right[DRONE], bool)).sum()),
            "pictures": len(pictures[clip.name]),
        }
    out["clips_called"] = {name: dict(count) for name, count in votes.items()}
    out["by_clip"] = by_clip
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--camera", choices=("infrared", "visible"), required=True)
    parser.add_argument("--model", type=Path, required=True)
    parser.add_argument("--fold", type=int, default=TEST_FOLD)
    parser.add_argument("--threshold", type=float, help="of detections; without it the best is taken")
    parser.add_argument("--track-threshold", type=float, help="of tracks; likewise")
    parser.add_argument("--out", type=Path, help="a JSON file")
    arguments = parser.parse_args()

    clips = [
        c for c in read_split(arguments.camera) if c.fold == arguments.fold and c.labels == "good"
    ]
    pictures = collect(network(arguments.model), arguments.data, clips, 1)
    result = {
        "camera": arguments.camera,
        "fold": arguments.fold,
        "clips": len(clips),
        "pictures_per_s_one_core": round(pictures_per_s(arguments.model), 1),
    }
    for rows_of, threshold in (
        ("detections", arguments.threshold),
        ("tracks", arguments.track_threshold),
    ):
        for labels in ("given", "in_time"):
            result[f"{rows_of}, labels {labels}"] = figures(
                clips, pictures, rows_of, labels, threshold
            )
    text = json.dumps(result, indent=1)
    print(text)
    if arguments.out:
        arguments.out.write_text(text + "\n")


if __name__ == "__main__":
    main()
