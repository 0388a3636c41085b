"""What a tracked object is, told from its last second: windows around its box at eight moments.

A detector sees one picture, and on clips it was not trained on it finds the object but often names it
wrongly. Here shape, how the shape changes (birds flap) and motion are measured by fixed formulas, and
only a small network behind them is trained: with some hundred clips a deep network learns the clips.
"""

import cv2
import numpy as np
import torch
from torch import nn

from clips import CLASSES

MOMENTS, MOMENT_STEP = 8, 4  # the newest picture, and each fourth before it
CELLS = 32
WINDOW_SIDES = 1.2  # side of the window in longer sides of the box
LOWEST_CONTRAST = 6.0  # grey levels that count as 1, at least
HIGHEST = 1.5
NUMBERS = 8
SHAPES = 15  # measured of each window

SIZE_OF_PIXEL = {"infrared": 1.0, "visible": 0.5}  # so that sizes of both cameras compare
CAMERA_NUMBER = {"infrared": -0.5, "visible": 0.5}


def grey_of(picture: np.ndarray) -> np.ndarray:
    """RGB, uint8, to grey, uint8: 0.299 R + 0.587 G + 0.114 B, rounded."""
    return cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)


def points(low: float, side: float, count: int, length: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pixels before and after each of some points along one axis, and the share of the one after.

    The middle of pixel i is at i + 0.5. Outside of the picture its outermost pixel goes on.
    """
    at = low + (np.arange(count) + 0.5) * (side / count) - 0.5
    before = np.floor(at)
    share = (at - before).astype(np.float32)
    before = before.astype(int)
    return before.clip(0, length - 1), (before + 1).clip(0, length - 1), share


def window(grey: np.ndarray, box: np.ndarray, sides: float = WINDOW_SIDES, cells: int = CELLS) -> np.ndarray:
    """Square [cells, cells] around the middle of a box (x, y, width, height), in grey levels.

    Bilinear; where a cell is larger than a pixel, it is the mean of fine x fine points.
    """
    side = sides * float(max(box[2:]))
    fine = max(1, int(np.ceil(side / cells)))
    low = box[:2] + box[2:] / 2 - side / 2
    left, right, x_share = points(low[0], side, cells * fine, grey.shape[1])
    above, below, y_share = points(low[1], side, cells * fine, grey.shape[0])
    upper, lower = (grey[rows].astype(np.float32) for rows in (above, below))
    rows = upper + (lower - upper) * y_share[:, None]
    all_points = rows[:, left] + (rows[:, right] - rows[:, left]) * x_share
    return all_points.reshape(cells, fine, cells, fine).mean(axis=(1, 3))


def rim() -> torch.Tensor:
    """Which cells are among the outermost two."""
    inner = torch.zeros(CELLS, CELLS, dtype=torch.bool)
    inner[2:-2, 2:-2] = True
    return ~inner


def normalise(windows: torch.Tensor) -> torch.Tensor:
    """Grey levels [n, moments, cells, cells] to -1.5..1.5: background 0, the object's strongest about 1.

    The background is each window's median of the rim (of 240 values the 120th), the scale is one for all moments,
    so that a change of contrast stays.
    """
    flat = windows - windows[:, :, rim()].median(-1).values[..., None, None]
    quarter = CELLS // 4
    peaks = flat[:, :, quarter:-quarter, quarter:-quarter].abs().amax((2, 3))
    scale = peaks.mean(1).clamp_min(LOWEST_CONTRAST)[:, None, None, None]
    return (flat / scale).clamp(-HIGHEST, HIGHEST)


def numbers(boxes: np.ndarray, camera: str) -> np.ndarray:
    """What the boxes [n, moments, 4] (x, y, width, height; the oldest first) say of size, shape and motion."""
    size = boxes[..., 2:].max(axis=-1)
    log_size = np.log(size * SIZE_OF_PIXEL[camera])
    log_aspect = np.log(boxes[..., 2] / boxes[..., 3])
    middle = boxes[..., :2] + boxes[..., 2:] / 2
    moment = np.arange(MOMENTS) - (MOMENTS - 1) / 2
    # the straight line through the middles, and what is left beside it, both in sizes
    slope = (middle * moment[:, None]).sum(axis=1) / (moment**2).sum()
    beside = middle - middle.mean(axis=1, keepdims=True) - slope[:, None] * moment[:, None]
    mean_size = size.mean(axis=1)
    way = slope * (MOMENTS - 1) / mean_size[:, None]
    length = np.hypot(way[:, 0], way[:, 1])
    wobble = np.sqrt((beside**2).sum(axis=2).mean(axis=1)) / mean_size
    columns = [
        log_size.mean(axis=1) - 3,
        2 * log_aspect.mean(axis=1),
        5 * log_aspect.std(axis=1),
        5 * log_size.std(axis=1),
        np.full(len(boxes), CAMERA_NUMBER[camera]),
        np.log(length + 0.1) + 0.5,
        np.log(wobble + 0.05) + 2,
        2 * np.abs(way[:, 0]) / (length + 0.1) - 1,
    ]
    return np.stack(columns, axis=1).astype(np.float32)


class Shapes(nn.Module):
    """Measures of the object in normalised windows: their means, spreads and changes over the moments."""

    count = 3 * SHAPES + 3

    def __init__(self) -> None:
        super().__init__()
        at = torch.linspace(-1, 1, CELLS)
        y, x = (v.reshape(-1) for v in torch.meshgrid(at, at, indexing="ij"))
        far = torch.maximum(x.abs(), y.abs())
        powers = [x**0, x, y, x**2, y**2, x * y, x**3, y**3, x**4, y**4]
        self.register_buffer("powers", torch.stack(powers, 1))
        self.register_buffer("inside", (far < 0.8).float())
        self.register_buffer("outside", (far > 0.9).float())

    def of_each(self, windows: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Measures [n, moments, SHAPES], and windows [n, moments, cells] with a peak of 1."""
        across = (windows[..., 1:] - windows[..., :-1]).abs().sum((2, 3))
        down = (windows[..., 1:, :] - windows[..., :-1, :]).abs().sum((2, 3))
        flat = windows.reshape(-1, MOMENTS, CELLS * CELLS)
        strength = flat.abs()
        peak = (strength * self.inside).amax(2, keepdim=True).clamp_min(0.15)
        noise = (strength * self.outside).sum(2) / self.outside.sum() / peak[..., 0]
        # the object's cells are those of more than a quarter of the peak
        weight = (strength / peak - 0.25).clamp(0, 0.5) * self.inside
        sums = weight @ self.powers
        mass = sums[..., 0].clamp_min(0.05)
        _, x, y, x2, y2, xy, x3, y3, x4, y4 = (sums / mass[..., None]).unbind(-1)
        # moments around the middle of the object
        wide = (x2 - x * x).clamp_min(1e-4)
        high = (y2 - y * y).clamp_min(1e-4)
        slant = xy - x * y
        x_skew = x3 - 3 * x * x2 + 2 * x * x * x
        y_skew = y3 - 3 * y * y2 + 2 * y * y * y
        x_fourth = x4 - 4 * x * x3 + 6 * x * x * x2 - 3 * x * x * x * x
        y_fourth = y4 - 4 * y * y3 + 6 * y * y * y2 - 3 * y * y * y * y
        spread = wide + high
        apart = ((wide - high) * (wide - high) + 4 * slant * slant + 1e-8).sqrt()
        long = (spread + apart) / 2
        short = ((spread - apart) / 2).clamp_min(1e-4)
        cube = spread * spread.sqrt()
        one_sign = (flat * weight).sum(2).abs() / (strength * weight).sum(2).clamp_min(1e-3)
        measures = [
            long.log() / 2,
            (long / short).log() / 2,
            mass.log(),
            (wide - high) / spread,
            slant.abs() / spread,
            (mass / (long * short).sqrt() / 100).clamp(0, 20),
            (y_skew / cube).clamp(-3, 3),
            (x_skew / cube).abs().clamp(0, 3),
            (x_fourth / (wide * wide)).clamp(0, 8),
            (y_fourth / (high * high)).clamp(0, 8),
            one_sign,
            peak[..., 0],
            (noise + 0.02).log(),
            ((across + 0.1) / (down + 0.1)).log(),
            ((across + down + 0.1) / (strength.sum(2) + 0.1)).log(),
        ]
        return torch.stack(measures, 2), flat / peak

    def forward(self, windows: torch.Tensor) -> torch.Tensor:
        measures, flat = self.of_each(windows)
        mean = measures.mean(1)
        off = measures - mean[:, None]
        spread = ((off * off).mean(1) + 1e-6).sqrt()
        change = (measures[:, 1:] - measures[:, :-1]).abs().mean(1)
        # how alike the windows of neighbouring moments are, and the first and the last
        flat = flat - flat.mean(2, keepdim=True)
        flat = flat / ((flat * flat).sum(2, keepdim=True) + 1e-4).sqrt()
        alike = (flat[:, 1:] * flat[:, :-1]).sum(2)
        ends = (flat[:, -1] * flat[:, 0]).sum(1)
        likeness = torch.stack([alike.mean(1), alike.amin(1), ends], 1)
        return torch.cat([mean, spread, change, likeness], 1)


class Head(nn.Module):
    """From measures [n, Shapes.count] and numbers to raw scores of the classes: the trained part."""

    def __init__(self, hidden: int = 96) -> None:
        super().__init__()
        self.standardise = nn.BatchNorm1d(Shapes.count, affine=False)
        self.layers = nn.Sequential(
            nn.Dropout(0.2),
            nn.Linear(Shapes.count + NUMBERS, hidden),
            nn.ReLU(),
            nn.Dropout(0.2),
            nn.Linear(hidden, len(CLASSES)),
        )
        self.drop = nn.Dropout(0.2)

    def forward(self, measures: torch.Tensor, box_numbers: torch.Tensor) -> torch.Tensor:
        if self.training:
            plain = self.standardise(measures)
        else:  # written out, as a runtime may know batch normalisation of pictures only
            scale = (self.standardise.running_var + self.standardise.eps).rsqrt()
            plain = (measures - self.standardise.running_mean) * scale
        return self.layers(torch.cat([self.drop(plain.clamp(-4, 4)), box_numbers], 1))


class Classifier(nn.Module):
    """Several heads, whose scores are averaged: normalised windows and numbers to probabilities [n, classes]."""

    def __init__(self, heads: list[Head]) -> None:
        super().__init__()
        self.shapes = Shapes()
        self.heads = nn.ModuleList(heads)

    def forward(self, windows: torch.Tensor, box_numbers: torch.Tensor) -> torch.Tensor:
        measures = self.shapes(windows)
        scores = torch.stack([head(measures, box_numbers) for head in self.heads]).mean(0)
        return scores.softmax(1)


def fuse(detector_scores: np.ndarray, probabilities: np.ndarray) -> np.ndarray:
    """Class scores of a track, from what both have said of it up to now.

    `detector_scores` is the mean of its detections' class scores, `probabilities` [runs, classes] are all
    that the classifier gave of it. The largest score of the detector stays as "there is something".
    """
    shares = np.log(detector_scores / detector_scores.sum() + 0.02)
    seen = np.zeros(len(CLASSES))
    if len(probabilities):
        # the first runs see less than a second, and count less
        trust = min(1.0, (len(probabilities) + 1) / 4)
        seen = trust * np.log(probabilities.clip(1e-4)).mean(axis=0)
    # of the two the classifier is the one that is right on clips that neither knows
    odds = 2 * seen + shares
    classes = np.exp(odds - odds.max())
    return detector_scores.max() * classes / classes.sum()
