"""Writes `extra-labels.csv`: birds of two clips whose own labels are wrong, found by their motion.

The camera of both stands still before a plain sky, so what differs from the median of three
seconds is a bird. Looked at by eye. For training alone: nothing is measured on these clips.
"""

import argparse
import csv
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from clips import EXTRA_LABELS_FILE, read_pictures, read_split

CLIPS = ("V_BIRD_017.mp4", "V_BIRD_021.mp4")
HALF_WINDOW_PICTURES, PICTURE_STEP = 45, 3
DIFFERENT, SPREADS = 20, 2
# The people who labelled the other birds left some 8 pixels around them.
MARGIN_PX, SMALLEST_PX = 8, 22


def moving(pictures: np.ndarray, number: int) -> Iterator[tuple[int, int, int, int]]:
    """Left, top, width, height of what moves in one of the grey pictures."""
    low, high = max(0, number - HALF_WINDOW_PICTURES), number + HALF_WINDOW_PICTURES
    around = pictures[low:high:PICTURE_STEP]
    still = np.median(around, axis=0)
    spread = np.percentile(np.abs(around - still), 90, axis=0).astype(np.float32)
    allowed = DIFFERENT + SPREADS * cv2.dilate(spread, np.ones((9, 9)))
    different = (np.abs(pictures[number] - still) > allowed).astype(np.uint8)
    joined = cv2.dilate(different, np.ones((7, 7)))
    for left, top, width, height, _ in cv2.connectedComponentsWithStats(joined)[2][1:]:
        # without what joining added
        yield left + 3, top + 3, width - 6, height - 6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    arguments = parser.parse_args()
    with EXTRA_LABELS_FILE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("clip", "frame", "x", "y", "width", "height"))
        for clip in read_split("visible"):
            if clip.name not in CLIPS:
                continue
            pictures = np.stack(
                [cv2.cvtColor(p, cv2.COLOR_RGB2GRAY) for p in read_pictures(arguments.data, clip)]
            )
            for number in range(0, len(pictures), 5):
                for left, top, width, height in moving(pictures, number):
                    pad_x = max(MARGIN_PX, (SMALLEST_PX - width) // 2)
                    pad_y = max(MARGIN_PX, (SMALLEST_PX - height) // 2)
                    row = (left - pad_x, top - pad_y, width + 2 * pad_x, height + 2 * pad_y)
                    writer.writerow((clip.name, number, *row))


if __name__ == "__main__":
    main()
