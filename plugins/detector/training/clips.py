"""The clips: index, split, labels, pictures. Nothing here knows of a network."""

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np

CLASSES = ("drone", "bird", "airplane", "helicopter")
SIZES_PX = {"infrared": (320, 256), "visible": (640, 512)}
SPLIT_FILE = Path(__file__).with_name("split.csv")
EXTRA_LABELS_FILE = Path(__file__).with_name("extra-labels.csv")
TEST_FOLD = 0
# In these the rows are numbered from 1, not from 0: there is no row 0 but one for a picture after the
# last, and the middle of what is seen fits the row after.
LATE_LABELS = {("infrared", "bird"), ("visible", "bird"), ("visible", "drone")}


@dataclass(frozen=True)
class Clip:
    """One clip, and what `split.csv` says of it."""

    camera: str
    label: str
    name: str
    run: int
    fold: int
    labels: str  # "good", "none" or "wrong"

    @property
    def class_id(self) -> int:
        return CLASSES.index(self.label)


def read_split(camera: str | None = None) -> list[Clip]:
    """All clips of a camera (or of both), in the order of `split.csv`."""
    with SPLIT_FILE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    clips = [
        Clip(r["camera"], r["label"], r["clip"], int(r["run"]), int(r["fold"]), r["labels"])
        for r in rows
    ]
    return [clip for clip in clips if camera in (None, clip.camera)]


def read_boxes(data: Path, clip: Clip, in_time: bool) -> dict[int, np.ndarray]:
    """Frame number to (x, y, width, height) of the labelled object in pixels.

    In time: labels that are numbered from 1 are moved to the picture that they belong to. Otherwise as they are.
    """
    late = int(in_time and (clip.camera, clip.label) in LATE_LABELS)
    path = (data / clip.camera / clip.name).with_suffix(".csv")
    with path.open(newline="") as file:
        return {
            int(r["frame"]) - late: np.array([float(r[k]) for k in ("x", "y", "width", "height")])
            for r in csv.DictReader(file)
        }


def read_extra_boxes(clip: Clip) -> dict[int, np.ndarray]:
    """Frame number to all objects [n, 4] of a clip whose own labels are wrong, as `birds.py` found them."""
    with EXTRA_LABELS_FILE.open(newline="") as file:
        rows = [r for r in csv.DictReader(file) if r["clip"] == clip.name]
    frames = sorted({int(r["frame"]) for r in rows})
    return {
        frame: np.array(
            [
                [float(r[k]) for k in ("x", "y", "width", "height")]
                for r in rows
                if int(r["frame"]) == frame
            ]
        )
        for frame in frames
    }


def read_pictures(data: Path, clip: Clip) -> Iterator[np.ndarray]:
    """The clip's pictures in order, RGB, uint8."""
    with av.open(str(data / clip.camera / clip.name)) as container:
        for frame in container.decode(video=0):
            yield frame.to_ndarray(format="rgb24")
