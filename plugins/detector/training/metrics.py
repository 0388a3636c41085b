"""Precision, recall, F1 and average precision at an overlap of 0.5, and whose clips were called what."""

from dataclasses import dataclass, field

import numpy as np

from clips import CLASSES
from detect import overlaps

RIGHT_OVERLAP = 0.5


@dataclass
class Tally:
    """All detections of some clips, each with its score and whether it was right."""

    scores: list[list[float]] = field(default_factory=lambda: [[] for _ in CLASSES])
    right: list[list[bool]] = field(default_factory=lambda: [[] for _ in CLASSES])
    objects: list[int] = field(default_factory=lambda: [0] * len(CLASSES))

    def add(self, rows: np.ndarray, box: np.ndarray | None, class_id: int) -> None:
        """One picture: detections (best first) and the labelled x, y, width, height, if any."""
        found = False
        truth = None
        if box is not None:
            self.objects[class_id] += 1
            truth = np.concatenate([box[:2], box[:2] + box[2:]])
        for row in rows:
            said = int(row[4:].argmax())
            right = (
                truth is not None
                and not found
                and said == class_id
                and overlaps(truth, row[None])[0] >= RIGHT_OVERLAP
            )
            found |= right
            self.scores[said].append(float(row[4:].max()))
            self.right[said].append(bool(right))

    def sorted(self, class_id: int) -> tuple[np.ndarray, np.ndarray]:
        scores = np.array(self.scores[class_id])
        order = np.argsort(-scores, kind="stable")
        return scores[order], np.array(self.right[class_id], bool)[order]

    def at(self, class_id: int, threshold: float) -> tuple[float, float, float]:
        """Precision, recall and F1 of what scores at least the threshold."""
        scores, right = self.sorted(class_id)
        count = int((scores >= threshold).sum())
        hits = int(right[:count].sum())
        precision, recall = hits / max(count, 1), hits / max(self.objects[class_id], 1)
        return precision, recall, 2 * hits / max(count + self.objects[class_id], 1)

    def best_threshold(self, class_id: int) -> float:
        """The threshold with the highest F1."""
        scores, right = self.sorted(class_id)
        if not len(scores):
            return 1.0
        f1 = 2 * right.cumsum() / (np.arange(1, len(right) + 1) + self.objects[class_id])
        return float(scores[f1.argmax()])

    def average_precision(self, class_id: int) -> float:
        """Area under precision over recall, precision made falling."""
        _, right = self.sorted(class_id)
        if not len(right):
            return 0.0
        hits = right.cumsum()
        precision = hits / np.arange(1, len(right) + 1)
        falling = np.maximum.accumulate(precision[::-1])[::-1]
        return float((falling * right).sum() / max(self.objects[class_id], 1))


@dataclass
class Vote:
    """What one clip's detections say together."""

    sums: np.ndarray = field(default_factory=lambda: np.zeros(len(CLASSES)))

    def add(self, rows: np.ndarray, threshold: float) -> None:
        for row in rows:
            if row[4:].max() >= threshold:
                self.sums += row[4:]

    def winner(self) -> str:
        return CLASSES[int(self.sums.argmax())] if self.sums.any() else "nothing"
