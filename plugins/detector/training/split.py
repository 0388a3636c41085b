"""Writes `split.csv`: five folds of clips, of which fold 0 is the test part.

Neighbours in numbering whose pictures look alike are one run, of three clips at most. Runs are dealt to
five groups so that each gets its share of every class. The test part is a fifth of the clips of every
class, drawn clip by clip from all groups but group 1, on which thresholds were chosen. What is left of
groups 1 to 4 are the folds that are tuned on; what is left of group 0 goes to them clip by clip, so a few
of its runs are divided. The test part may hold neighbours of clips that are trained on, as the rest of the
published set does.
"""

import argparse
import csv
import itertools
import random
from collections import defaultdict
from pathlib import Path

import av
import cv2
import numpy as np

# camera, label, clip, run, fold, labels
Row = tuple[str, str, str, int, int, str]

SEED = 1
FOLDS = 5
TUNED_ON_GROUP = 1
RUN_CLIPS = 3
SAME_SCENE_CORRELATION = 0.9
# Looked at by eye: boxes that lie beside the birds, so they teach and measure nothing.
WRONG_LABELS = {"V_BIRD_017.mp4", "V_BIRD_021.mp4"}


def signature(path: Path) -> np.ndarray:
    """What the middle of a clip looks like, without its small objects and its brightness."""
    with av.open(str(path)) as container:
        pictures = [frame.to_ndarray(format="gray") for frame in container.decode(video=0)]
    small = cv2.resize(pictures[len(pictures) // 2], (64, 52), interpolation=cv2.INTER_AREA)
    small = cv2.medianBlur(small, 3).astype(np.float32)
    small -= small.mean()
    return small / (np.linalg.norm(small) + 1e-6)


def runs_of(clips: list[dict[str, str]], data: Path) -> list[list[dict[str, str]]]:
    """Cuts the clips of one class into runs of one scene."""
    runs: list[list[dict[str, str]]] = []
    last = None
    for clip in clips:
        now = signature(data / clip["camera"] / clip["clip"])
        alike = last is not None and float((now * last).sum()) > SAME_SCENE_CORRELATION
        if alike and len(runs[-1]) < RUN_CLIPS:
            runs[-1].append(clip)
        else:
            runs.append([clip])
        last = now
    return runs


def with_test_part(dealt: list[Row]) -> list[Row]:
    """Draws the test part of one class. What is left of group 0 goes to the other folds in turn."""
    rng = random.Random(SEED)
    choice = [row for row in dealt if row[4] != TUNED_ON_GROUP and row[5] == "good"]
    test = set(rng.sample(choice, round(len(dealt) / FOLDS)))
    others = itertools.cycle(range(TUNED_ON_GROUP + 1, FOLDS))
    return [(*row[:4], 0 if row in test else row[4] or next(others), row[5]) for row in dealt]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--out", type=Path, default=Path(__file__).with_name("split.csv"))
    arguments = parser.parse_args()

    with (arguments.data / "index.csv").open(newline="") as file:
        index = list(csv.DictReader(file))
    groups: dict[tuple[str, str], list[dict[str, str]]] = defaultdict(list)
    for row in index:
        groups[row["camera"], row["label"]].append(row)

    rng = random.Random(SEED)
    out, run_number = [], 0
    for (camera, label), clips in sorted(groups.items()):
        runs = runs_of(clips, arguments.data)
        rng.shuffle(runs)
        runs.sort(key=len, reverse=True)
        sizes, dealt = [0] * FOLDS, []
        order = rng.sample(range(FOLDS), FOLDS)
        for run in runs:
            fold = min(order, key=lambda f: sizes[f])
            sizes[fold] += len(run)
            run_number += 1
            for clip in run:
                labels = "none" if clip["labelled_frames"] == "0" else "good"
                if clip["clip"] in WRONG_LABELS:
                    labels = "wrong"
                dealt.append((camera, label, clip["clip"], run_number, fold, labels))
        out += with_test_part(sorted(dealt))
        print(camera, label, "runs", sorted(len(r) for r in runs))

    with arguments.out.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("camera", "label", "clip", "run", "fold", "labels"))
        writer.writerows(sorted(out))


if __name__ == "__main__":
    main()
