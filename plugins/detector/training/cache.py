"""Decoded pictures in one memory-mapped file per camera, so that training need not decode.

Holds only pictures all of whose objects are known: the others may show one that nobody labelled, so
they are no background either.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from clips import SIZES_PX, Clip, read_boxes, read_extra_boxes, read_pictures, read_split

# Neighbouring pictures are nearly the same: each second one, and each fifth, are plenty.
PICTURE_STEP = {"infrared": 2, "visible": 5}
CHANNELS = {"infrared": 1, "visible": 3}
# The labels count pixels from 1: they lie so far right of and below what they label. In pictures that are mirrored it would be learned as a doubt about where
# the sides are.
LABELS_FROM_PX = 1.0


@dataclass(frozen=True)
class Cache:
    """Pictures, and for each its clip (an index into `clips`) and its objects."""

    pictures: np.ndarray  # [n, height, width, channels], uint8
    boxes: list[np.ndarray]  # for each [objects, 4]: x, y, width, height in pixels, from 0
    clip_ids: np.ndarray  # [n]
    clips: list[Clip]


def training_boxes(data: Path, clip: Clip) -> dict[int, np.ndarray]:
    """Frame number to all objects [n, 4] of the picture."""
    if clip.labels == "good":
        return {n: box[None] for n, box in read_boxes(data, clip, in_time=True).items()}
    return read_extra_boxes(clip)


def build(data: Path, camera: str, directory: Path) -> None:
    """Decodes all clips of a camera into `directory`."""
    directory.mkdir(parents=True, exist_ok=True)
    width, height = SIZES_PX[camera]
    boxes, counts, clip_ids = [], [], []
    partial = directory / f"{camera}.u8.partial"
    with partial.open("wb") as file:
        for clip_id, clip in enumerate(read_split(camera)):
            labels = training_boxes(data, clip)
            if not labels:
                continue
            for number, picture in enumerate(read_pictures(data, clip)):
                if number % PICTURE_STEP[camera] or number not in labels:
                    continue
                if picture.shape != (height, width, 3):
                    raise ValueError(f"{clip.name}: {picture.shape}")
                file.write(np.ascontiguousarray(picture[:, :, : CHANNELS[camera]]).tobytes())
                boxes.append(labels[number])
                counts.append(len(labels[number]))
                clip_ids.append(clip_id)
    np.savez(
        directory / f"{camera}.npz",
        boxes=np.concatenate(boxes).astype(np.float32),
        counts=counts,
        clip_ids=clip_ids,
    )
    partial.rename(directory / f"{camera}.u8")


def load(data: Path, camera: str, directory: Path) -> Cache:
    """Opens the cache of a camera, and builds it before where there is none."""
    path = directory / f"{camera}.u8"
    if not path.exists():
        build(data, camera, directory)
    width, height = SIZES_PX[camera]
    index = np.load(directory / f"{camera}.npz")
    shape = (len(index["counts"]), height, width, CHANNELS[camera])
    pictures = np.memmap(path, np.uint8, "r", shape=shape)
    labelled = index["boxes"] - np.float32([LABELS_FROM_PX, LABELS_FROM_PX, 0, 0])
    boxes = np.split(labelled, np.cumsum(index["counts"])[:-1])
    return Cache(pictures, boxes, index["clip_ids"], read_split(camera))
