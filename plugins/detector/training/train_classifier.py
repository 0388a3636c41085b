"""Trains the classifier of tracks from nothing, prints how it does on clips left out, and writes its ONNX.

    python train_classifier.py --data DIR --cache DIR --out classifier.onnx

Four times three of the folds 1 to 4 are learnt and the fourth is measured, by labelled boxes that are moved
and sized as a detector's are; then all four are learnt for the file. The test part is never taken. The ONNX has
the inputs `windows` [1, 8, 32, 32] (normalised) and `numbers` [1, 8], and the output `probabilities` [1, 4].
"""

import argparse
import copy
import math
from pathlib import Path

import numpy as np
import onnx
import torch
import torch.nn.functional as F

from classify import (
    CELLS,
    MOMENT_STEP,
    MOMENTS,
    NUMBERS,
    WINDOW_SIDES,
    Classifier,
    Head,
    Shapes,
    grey_of,
    normalise,
    numbers,
    rim,
    window,
)
from clips import CLASSES, TEST_FOLD, Clip, read_boxes, read_pictures, read_split
from export import OPSET

SEED = 7
HEADS = 3
STEPS, BATCH = 800, 48
HIGHEST_RATE, WEIGHT_DECAY, SMOOTHING = 5e-3, 0.05, 0.1
CLASS_WEIGHTS = (0.3, 0.25, 0.25, 0.2)
PICTURE_STEP = 2
# Wider and finer than the windows of the network, so that these can be cut out of them moved and turned.
CACHE_SIDES, CACHE_CELLS = 2.5, 72
# Of a detector's boxes on clips it does not know: shifts in sides and logarithms of sizes, within a track and of
# whole tracks.
WITHIN, WHOLE = (0.03, 0.025, 0.08, 0.08), (0.05, 0.03, 0.15, 0.15)


class Windows:
    """Wide windows around all labelled boxes, by clip."""

    def __init__(self, data: Path, cache: Path) -> None:
        self.clips = [c for c in read_split() if c.fold != TEST_FOLD and c.labels == "good"]
        path = cache / "windows.npz"
        if not path.exists():
            self.build(data, path)
        saved = np.load(path)
        self.pictures = torch.from_numpy(saved["windows"])
        self.boxes = saved["boxes"].astype(float)
        self.rows_of = [np.flatnonzero(saved["clip_ids"] == i) for i in range(len(self.clips))]

    def build(self, data: Path, path: Path) -> None:
        windows, boxes, clip_ids = [], [], []
        for clip_id, clip in enumerate(self.clips):
            labels = read_boxes(data, clip, in_time=True)
            for number, picture in enumerate(read_pictures(data, clip)):
                if number % PICTURE_STEP == 0 and number in labels:
                    wide = window(grey_of(picture), labels[number], CACHE_SIDES, CACHE_CELLS)
                    windows.append(wide.round().astype(np.uint8))
                    boxes.append(labels[number])
                    clip_ids.append(clip_id)
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(path, windows=windows, boxes=np.array(boxes, np.float32), clip_ids=clip_ids)

    def moments(self, clip_id: int, end: int, step: int) -> np.ndarray:
        """Rows of the moments up to one; where the clip begins too late, its first is repeated."""
        rows = self.rows_of[clip_id]
        return rows[np.maximum(end - step * np.arange(MOMENTS)[::-1], 0)]

    def cut(self, rows: np.ndarray, shift: torch.Tensor, sides: torch.Tensor, turn: torch.Tensor) -> torch.Tensor:
        """Windows [..., cells, cells] in grey levels: shift in sides of the box, x and y sides, [..., 2, 2] turn."""
        half = CACHE_SIDES / 2
        matrix = torch.cat([turn * (sides / CACHE_SIDES)[..., None, :], (shift / half)[..., None]], -1)
        at = F.affine_grid(matrix.reshape(-1, 2, 3), [rows.size, 1, CELLS, CELLS], align_corners=False)
        wide = self.pictures[torch.from_numpy(rows.reshape(-1))][:, None].float()
        cut = F.grid_sample(wide, at, "bilinear", "border", align_corners=False)
        return cut.reshape(*rows.shape, CELLS, CELLS)

    def as_detected(self, rows: np.ndarray, errors: np.ndarray) -> tuple[np.ndarray, torch.Tensor, torch.Tensor]:
        """Boxes with errors [n, moments, 4], and shift and side of their windows in sides of the labelled boxes."""
        boxes = self.boxes[rows]
        side = boxes[..., 2:].max(axis=-1, keepdims=True)
        sizes = boxes[..., 2:] * np.exp(errors[..., 2:])
        middles = boxes[..., :2] + boxes[..., 2:] / 2 + errors[..., :2] * side
        detected = np.concatenate([middles - sizes / 2, sizes], -1)
        grown = torch.from_numpy(sizes.max(axis=-1, keepdims=True) / side).float()
        return detected, torch.from_numpy(errors[..., :2]).float(), grown * WINDOW_SIDES


class Batches:
    """Draws tracks of some clips, changed as other clips might be."""

    def __init__(self, windows: Windows, clip_ids: list[int], seed: int) -> None:
        self.windows = windows
        self.clip_ids = clip_ids
        self.of_class = [[i for i in clip_ids if windows.clips[i].class_id == c] for c in range(len(CLASSES))]
        self.rng = np.random.default_rng(seed)
        self.random = torch.Generator().manual_seed(seed)

    def uniform(self, low: float, high: float, *shape: int) -> torch.Tensor:
        return low + (high - low) * torch.rand(*shape, generator=self.random)

    def normal(self, *shape: int) -> torch.Tensor:
        return torch.randn(*shape, generator=self.random)

    def sometimes(self, share: float) -> torch.Tensor:
        """1 for a share of the samples, else 0."""
        return (self.uniform(0, 1, BATCH, 1, 1, 1) < share).float()

    def backgrounds(self) -> torch.Tensor:
        """Windows beside the objects of other clips."""
        chosen = [self.rng.choice(self.windows.rows_of[i]) for i in self.rng.choice(self.clip_ids, BATCH)]
        rows = np.repeat(np.array(chosen)[:, None], MOMENTS, 1)
        beside = self.uniform(0.9, 1.0, BATCH, 1, 2) * (self.uniform(-1, 1, BATCH, 1, 2)).sign()
        along = self.uniform(-1, 1, BATCH, 1, 2)
        upright = self.uniform(0, 1, BATCH, 1, 1) < 0.5
        first = torch.tensor([True, False])
        shift = torch.where(upright == first, beside, along) + 0.025 * self.normal(BATCH, MOMENTS, 2)
        sides = self.uniform(0.25, 0.6, BATCH, 1, 1).expand(BATCH, MOMENTS, 2)
        return self.windows.cut(rows, shift, sides, torch.eye(2).expand(BATCH, MOMENTS, 2, 2))

    def light(self, grey: torch.Tensor) -> torch.Tensor:
        """Other backgrounds, contrast, sharpness and noise."""
        level = grey[:, :, rim()].median(-1).values[..., None, None]
        at = torch.linspace(-1, 1, CELLS)
        edge = ((1 - torch.maximum(at[:, None].abs(), at.abs())) * 4).clamp(0, 1)
        faint = torch.exp(0.4 * self.uniform(-1, 0.5, BATCH, 1, 1, 1))
        moved = (grey - level) * edge * faint + self.backgrounds() * self.uniform(0.3, 1, BATCH, 1, 1, 1)
        grey = torch.where(self.sometimes(0.2) > 0, moved, grey)
        slope = 8 * (self.normal(BATCH, 1, 1, 1) * at + self.normal(BATCH, 1, 1, 1) * at[:, None])
        grey = grey + self.sometimes(0.12) * slope
        # blur by a filter of its own for each sample
        sigma = self.uniform(0.05, 1.2, BATCH, 1) * self.sometimes(0.2)[:, :, 0, 0] + 0.05
        taps = torch.exp(-(torch.arange(-2, 3) ** 2) / (2 * sigma**2))
        taps = (taps / taps.sum(1, keepdim=True)).repeat_interleave(MOMENTS, 0)[:, None, None]
        flat = grey.reshape(1, -1, CELLS, CELLS)
        flat = F.conv2d(F.pad(flat, (2, 2, 0, 0), "replicate"), taps, groups=len(taps))
        flat = F.conv2d(F.pad(flat, (0, 0, 2, 2), "replicate"), taps.mT, groups=len(taps))
        loud = -2.5 * torch.log(self.uniform(0.02, 1, BATCH, 1, 1, 1)) * self.sometimes(0.2)
        grey = flat.reshape(grey.shape) + loud * self.normal(*grey.shape)
        return grey * (1 - 2 * self.sometimes(0.3))

    def draw(self) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Normalised windows, numbers and classes."""
        windows, rng = self.windows, self.rng
        classes = rng.choice(len(CLASSES), BATCH, p=CLASS_WEIGHTS)
        ids = [self.of_class[c][rng.integers(len(self.of_class[c]))] for c in classes]
        steps = rng.choice([1, 2, 2, 3], BATCH)
        rows = np.stack(
            [
                windows.moments(i, int(rng.integers(len(windows.rows_of[i]))), int(step))
                for i, step in zip(ids, steps, strict=True)
            ]
        )
        loose = np.exp(0.5 * rng.standard_normal((BATCH, 1, 1)))
        errors = loose * np.array(WITHIN) * rng.standard_normal((BATCH, MOMENTS, 4))
        errors += np.array(WHOLE) * rng.standard_normal((BATCH, 1, 4))
        boxes, shift, side = windows.as_detected(rows, errors)
        scale = torch.exp(self.uniform(-0.06, 0.06, BATCH, 1, 1))
        stretch = torch.exp(0.032 * self.normal(BATCH, 1, 1))
        angle = self.uniform(-0.16, 0.16, BATCH)
        mirror = self.uniform(-1, 1, BATCH).sign()
        cos, sin = angle.cos(), angle.sin()
        turn = torch.stack([cos * mirror, -sin, sin * mirror, cos], -1).reshape(BATCH, 1, 2, 2)
        sides = side * scale * torch.cat([stretch, 1 / stretch], -1)
        grey = windows.cut(rows, shift, sides, turn.expand(BATCH, MOMENTS, 2, 2))
        x = normalise(self.light(grey))
        # as if the sensor were blinded by the object
        blinded = (x / self.uniform(0.5, 1, BATCH, 1, 1, 1)).clamp(-1, 1)
        x = torch.where(self.sometimes(0.12) > 0, blinded, x)
        # motion as if the moments were as far apart as they will be
        middle = boxes[..., :2] + boxes[..., 2:] / 2
        faster = (MOMENT_STEP / PICTURE_STEP / steps)[:, None, None]
        boxes[..., :2] += (middle - middle.mean(axis=1, keepdims=True)) * (faster - 1)
        each = [numbers(b[None], windows.clips[i].camera) for b, i in zip(boxes, ids, strict=True)]
        box_numbers = torch.from_numpy(np.concatenate(each))
        blur = torch.tensor([0.12, 0.04, 0.04, 0.04, 0, 0.08, 0.08, 0.08])
        box_numbers = box_numbers + blur * self.normal(BATCH, NUMBERS)
        box_numbers = box_numbers * (1 - self.sometimes(0.08)[:, 0, 0])
        return x, box_numbers, torch.from_numpy(classes)


def train(windows: Windows, clip_ids: list[int]) -> Classifier:
    """Some heads at once, on the same batches; what is kept of each is the mean of its weights over the last steps."""
    torch.manual_seed(SEED)
    batches, shapes = Batches(windows, clip_ids, SEED), Shapes()
    heads = torch.nn.ModuleList(Head() for _ in range(HEADS)).train()
    averages = copy.deepcopy(heads).eval()
    optimizer = torch.optim.AdamW(
        [
            {"params": [p for p in heads.parameters() if p.ndim > 1], "weight_decay": WEIGHT_DECAY},
            {"params": [p for p in heads.parameters() if p.ndim <= 1], "weight_decay": 0.0},
        ]
    )
    for step in range(STEPS):
        for group in optimizer.param_groups:
            falling = 0.02 + 0.98 * (1 + math.cos(math.pi * step / STEPS)) / 2
            group["lr"] = HIGHEST_RATE * min(1, (step + 1) / 50) * falling
        x, box_numbers, classes = batches.draw()
        with torch.no_grad():
            measures = shapes(x)
        optimizer.zero_grad()
        for head in heads:
            F.cross_entropy(head(measures, box_numbers), classes, label_smoothing=SMOOTHING).backward()
        optimizer.step()
        kept = min(0.99, (1 + step) / (10 + step))
        with torch.no_grad():
            for mine, new in zip(averages.state_dict().values(), heads.state_dict().values(), strict=True):
                if mine.dtype.is_floating_point:
                    mine.lerp_(new, 1 - kept)
                else:
                    mine.copy_(new)
    return Classifier(list(averages)).eval()


@torch.no_grad()
def said_of(classifier: Classifier, windows: Windows, clip_id: int, rng: np.random.Generator) -> np.ndarray:
    """Probabilities [runs, classes] along a clip, twice a second, of boxes as a detector's."""
    step = MOMENT_STEP // PICTURE_STEP
    ends = range(step * (MOMENTS - 1), len(windows.rows_of[clip_id]), 7)
    rows = np.stack([windows.moments(clip_id, end, step) for end in ends])
    errors = np.array(WITHIN) * rng.standard_normal((*rows.shape, 4))
    errors += np.array(WHOLE) * rng.standard_normal((len(rows), 1, 4))
    boxes, shift, side = windows.as_detected(rows, errors)
    turn = torch.eye(2).expand(*rows.shape, 2, 2)
    grey = windows.cut(rows, shift, side.expand(*rows.shape, 2), turn)
    box_numbers = torch.from_numpy(numbers(boxes, windows.clips[clip_id].camera))
    return classifier(normalise(grey), box_numbers).numpy()


def drone_f1(truth: np.ndarray, said: np.ndarray) -> float:
    return 2 * int(((truth == 0) & (said == 0)).sum()) / max(1, int((truth == 0).sum() + (said == 0).sum()))


def report(clips: list[Clip], said: list[np.ndarray]) -> None:
    """Of single seconds, of what is fused up to each of them, and of whole clips."""
    for camera in ("infrared", "visible"):
        own = [(c, p) for c, p in zip(clips, said, strict=True) if c.camera == camera]
        logs = [np.log(p.clip(1e-4)) for _, p in own]
        fused = [log.cumsum(axis=0) for log in logs]
        truth = np.concatenate([np.full(len(p), c.class_id) for c, p in own])
        clip_truth = np.array([c.class_id for c, _ in own])
        clip_said = np.array([f[-1].argmax() for f in fused])
        for name, true, now in (
            ("second", truth, np.concatenate(logs).argmax(axis=1)),
            ("fused", truth, np.concatenate(fused).argmax(axis=1)),
            ("clip", clip_truth, clip_said),
        ):
            print(f"{camera} {name}: accuracy {(true == now).mean():.3f}, drone F1 {drone_f1(true, now):.3f}")
        table = np.zeros((len(CLASSES), len(CLASSES)), int)
        np.add.at(table, (clip_truth, clip_said), 1)
        print(f"{camera} clips, rows are the truth: {table.tolist()}", flush=True)


def write(classifier: Classifier, path: Path) -> None:
    torch.onnx.export(
        classifier.eval(),
        (torch.zeros(1, MOMENTS, CELLS, CELLS), torch.zeros(1, NUMBERS)),
        str(path),
        opset_version=OPSET,
        input_names=["windows", "numbers"],
        output_names=["probabilities"],
        dynamo=False,
    )
    graph = onnx.load(str(path))
    entry = graph.metadata_props.add()
    entry.key, entry.value = "names", str(dict(enumerate(CLASSES)))
    onnx.checker.check_model(graph)
    onnx.save(graph, str(path))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--cache", type=Path, default=Path("cache"))
    parser.add_argument("--out", type=Path, required=True, help="the ONNX of all folds but the test part")
    parser.add_argument("--keep-folds", action="store_true", help="also OUT-without-N.onnx of each left out fold")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    windows = Windows(arguments.data, arguments.cache)

    clips, said = [], []
    rng = np.random.default_rng(SEED)
    for fold in sorted({c.fold for c in windows.clips}):
        classifier = train(windows, [i for i, c in enumerate(windows.clips) if c.fold != fold])
        for i, clip in enumerate(windows.clips):
            if clip.fold == fold:
                clips.append(clip)
                said.append(said_of(classifier, windows, i, rng))
        if arguments.keep_folds:
            write(classifier, arguments.out.with_name(f"{arguments.out.stem}-without-{fold}.onnx"))
        print(f"fold {fold} measured", flush=True)
    report(clips, said)
    write(train(windows, list(range(len(windows.clips)))), arguments.out)


if __name__ == "__main__":
    main()
