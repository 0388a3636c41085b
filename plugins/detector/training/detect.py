"""From the network's outputs to detections: the best class of each cell, then suppression of doubles."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from clips import Clip, read_pictures

LOWEST_SCORE = 0.03
SAME_OBJECT_OVERLAP = 0.45
MOST_CANDIDATES = 200

# [height, width, 3] uint8 to the output `output0` [4 + classes, cells]
Network = Callable[[np.ndarray], np.ndarray]


def overlaps(box: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """Intersection over union of one box with many, all as corners."""
    low = np.maximum(box[:2], boxes[:, :2])
    high = np.minimum(box[2:4], boxes[:, 2:4])
    inner = (high - low).clip(0).prod(axis=1)
    own = (box[2:4] - box[:2]).prod()
    return inner / (own + (boxes[:, 2:4] - boxes[:, :2]).prod(axis=1) - inner + 1e-9)


def detections(output: np.ndarray) -> np.ndarray:
    """Rows of left, top, right, bottom and the class scores, the best first."""
    scores = output[4:].max(axis=0)
    kept = np.flatnonzero(scores > LOWEST_SCORE)
    kept = kept[np.argsort(-scores[kept], kind="stable")][:MOST_CANDIDATES]
    centre, half = output[:2, kept].T, output[2:4, kept].T / 2
    rows = np.concatenate([centre - half, centre + half, output[4:, kept].T], axis=1)
    chosen = []
    while len(rows):
        chosen.append(rows[0])
        rows = rows[1:][overlaps(rows[0], rows[1:]) < SAME_OBJECT_OVERLAP]
    return np.array(chosen).reshape(-1, output.shape[0])


def of_clip(network: Network, data: Path, clip: Clip, step: int = 1) -> Iterator[tuple[int, np.ndarray]]:
    """Frame number and detections of each `step`-th picture."""
    for number, picture in enumerate(read_pictures(data, clip)):
        if number % step == 0:
            yield number, detections(network(picture))
