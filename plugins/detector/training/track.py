"""A plain tracker to judge a detector with: links boxes by place, averages the classes of a track.

It only looks back. It is a measure, not what flies: the node has its own tracker.
"""

from dataclasses import dataclass

import numpy as np

LOWEST_SCORE = 0.08
HITS_TO_CONFIRM = 4
MISSES_TO_SHOW = 3
MISSES_TO_KEEP = 15
GATE_SIZES = 1.2  # how far from where it is expected, in sizes of the box
SPEED_SHARE = 0.4  # of each newly seen speed that is believed


@dataclass
class Track:
    box: np.ndarray
    speed_px: np.ndarray
    score_sum: np.ndarray
    hits: int = 1
    misses: int = 0

    def row(self) -> np.ndarray:
        """Box, and the mean of its class scores over all its life."""
        return np.concatenate([self.box, self.score_sum / self.hits])


class Tracker:
    def __init__(self) -> None:
        self.tracks: list[Track] = []

    def step(self, rows: np.ndarray) -> np.ndarray:
        """Takes the detections of the next picture, gives the confirmed tracks, the surest first."""
        rows = rows[rows[:, 4:].max(axis=1) >= LOWEST_SCORE] if len(rows) else rows
        for track in self.tracks:
            track.box = track.box + np.tile(track.speed_px, 2)
        free = list(range(len(rows)))
        for track in sorted(self.tracks, key=lambda t: -t.hits):
            chosen = self.nearest(track, rows, free)
            if chosen is None:
                track.misses += 1
                continue
            free.remove(chosen)
            box = rows[chosen, :4]
            moved = (box[:2] + box[2:] - track.box[:2] - track.box[2:]) / 2
            track.speed_px = track.speed_px + SPEED_SHARE * moved
            track.box = box
            track.score_sum = track.score_sum + rows[chosen, 4:]
            track.hits += 1
            track.misses = 0
        self.tracks = [
            t for t in self.tracks if t.misses <= (MISSES_TO_KEEP if t.hits >= HITS_TO_CONFIRM else 2)
        ]
        self.tracks += [Track(rows[i, :4], np.zeros(2), rows[i, 4:].copy()) for i in free]
        shown = [
            t.row() for t in self.tracks if t.hits >= HITS_TO_CONFIRM and t.misses <= MISSES_TO_SHOW
        ]
        shown.sort(key=lambda row: -row[4:].max())
        return np.array(shown).reshape(-1, rows.shape[1])

    @staticmethod
    def nearest(track: Track, rows: np.ndarray, free: list[int]) -> int | None:
        best, best_cost = None, GATE_SIZES
        size = float(np.sqrt((track.box[2:] - track.box[:2]).prod()))
        for i in free:
            apart = np.abs(rows[i, :2] + rows[i, 2:4] - track.box[:2] - track.box[2:]).max() / 2
            cost = apart / (size * (1 + 0.3 * track.misses))
            if cost < best_cost:
                best, best_cost = i, cost
        return best
