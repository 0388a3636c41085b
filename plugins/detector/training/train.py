"""Trains the detector of one camera from nothing, and writes weights, ONNX and the curve.

    python train.py --data DIR --camera infrared --out DIR --validation-fold 1
    python train.py --data DIR --camera infrared --out DIR

The first leaves a fold out and measures on it on the way; the second takes all folds but the test
part, which no run ever takes. The same seed gives the same run on the same machine.
"""

import argparse
import copy
import csv
import math
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import torch
from torch.utils.data import DataLoader, IterableDataset, get_worker_info

import loss as cost
from augment import CANVAS_PX, Augmenter, Sample, Source
from cache import CHANNELS, load
from clips import SIZES_PX, TEST_FOLD, Clip, read_boxes, read_split
from detect import of_clip
from evaluate import DRONE
from export import Exported, export
from metrics import Tally
from model import Detector, cells, corners, count_macs

SEED = 7
# One core computes, one process makes pictures: both cameras train side by side on two cores.
THREADS = 1
WORKERS = 1
BATCH = 32
STEPS = 16_000
WARM_UP_STEPS = 500
HIGHEST_RATE, LOWEST_RATE = 2e-3, 2e-5
WEIGHT_DECAY = 0.03
AVERAGE_OVER_STEPS = 2000
MOSAIC_SHARE = 0.6
# towards the end the pictures are as the camera gives them
PLAIN_FROM = 0.85
PLAIN_MOSAIC_SHARE = 0.1
MEASURE_EVERY_STEPS = 2000
MEASURE_PICTURE_STEP = 10

Batch = tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor]


def join(samples: list[Sample]) -> Batch:
    """Pictures [n, c, h, w] uint8, boxes and classes padded to the most objects, and where padded."""
    most = max(1, *(len(s.boxes) for s in samples))
    boxes = np.zeros((len(samples), most, 4), np.float32)
    classes = np.zeros((len(samples), most), np.int64)
    padding = np.ones((len(samples), most), bool)
    for i, sample in enumerate(samples):
        count = len(sample.boxes)
        boxes[i, :count], classes[i, :count], padding[i, :count] = sample.boxes, sample.classes, False
    pictures = torch.from_numpy(np.stack([s.picture for s in samples])).permute(0, 3, 1, 2)
    return pictures, torch.from_numpy(boxes), torch.from_numpy(classes), torch.from_numpy(padding)


class Batches(IterableDataset):
    """The batches of a run: worker w of n makes those of steps w, w + n, ..."""

    def __init__(self, own: Source, other: Source, first: int, steps: int) -> None:
        self.own, self.other, self.first, self.steps = own, other, first, steps

    def __iter__(self) -> Iterator[Batch]:
        cv2.setNumThreads(1)
        worker = get_worker_info()
        # a run that goes on draws other pictures than it would have drawn: never the same ones again
        augmenter = Augmenter(self.own, self.other, SEED * 1000 + worker.id + self.first * 1000)
        for step in range(self.first + worker.id, self.steps, worker.num_workers):
            plain = step >= PLAIN_FROM * self.steps
            share = PLAIN_MOSAIC_SHARE if plain else MOSAIC_SHARE
            yield join([augmenter.sample(share) for _ in range(BATCH)])


def rate(step: int, steps: int) -> float:
    if step < WARM_UP_STEPS:
        return HIGHEST_RATE * (step + 1) / WARM_UP_STEPS
    done = (step - WARM_UP_STEPS) / max(1, steps - WARM_UP_STEPS)
    return LOWEST_RATE + (HIGHEST_RATE - LOWEST_RATE) * (1 + math.cos(math.pi * done)) / 2


def measure(detector: Detector, data: Path, clips: list[Clip]) -> Tally:
    """Each tenth picture of some clips."""
    first = next(iter(clips))
    module = Exported(copy.deepcopy(detector).eval(), *SIZES_PX[first.camera])
    channels = CHANNELS[first.camera]

    def run(picture: np.ndarray) -> np.ndarray:
        x = torch.from_numpy(picture[:, :, :channels]).permute(2, 0, 1)[None].float() / 255
        with torch.no_grad():
            return module(x.contiguous(memory_format=torch.channels_last))[0].numpy()

    tally = Tally()
    for clip in clips:
        boxes = read_boxes(data, clip, in_time=True)
        for number, rows in of_clip(run, data, clip, MEASURE_PICTURE_STEP):
            tally.add(rows, boxes.get(number), clip.class_id)
    return tally


class Average:
    """The mean of the weights over the last steps, which does better than the weights."""

    def __init__(self, detector: Detector) -> None:
        self.detector = copy.deepcopy(detector).eval()

    @torch.no_grad()
    def update(self, detector: Detector, step: int) -> None:
        kept = min(1 - 1 / AVERAGE_OVER_STEPS, (1 + step) / (10 + step))
        for mine, new in zip(
            self.detector.state_dict().values(), detector.state_dict().values(), strict=True
        ):
            if mine.dtype.is_floating_point:
                mine.lerp_(new, 1 - kept)
            else:
                mine.copy_(new)


def optimizer_of(detector: Detector) -> torch.optim.Optimizer:
    decayed = [p for p in detector.parameters() if p.ndim > 1]
    others = [p for p in detector.parameters() if p.ndim <= 1]
    return torch.optim.AdamW(
        [{"params": decayed, "weight_decay": WEIGHT_DECAY}, {"params": others, "weight_decay": 0.0}],
        lr=HIGHEST_RATE,
        betas=(0.9, 0.99),
    )


def keep(path: Path, detector: Detector, average: Average, optimizer: torch.optim.Optimizer, step: int) -> None:
    """Writes what a run needs to go on after `step`."""
    partial = path.with_suffix(".partial")
    parts = {
        "detector": detector.state_dict(),
        "average": average.detector.state_dict(),
        "optimizer": optimizer.state_dict(),
        "step": step,
    }
    torch.save(parts, partial)
    partial.rename(path)


def restore(path: Path, detector: Detector, average: Average, optimizer: torch.optim.Optimizer) -> int:
    """The step after which the run goes on."""
    parts = torch.load(path)
    detector.load_state_dict(parts["detector"])
    average.detector.load_state_dict(parts["average"])
    optimizer.load_state_dict(parts["optimizer"])
    return parts["step"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--camera", choices=("infrared", "visible"), required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cache", type=Path, default=Path("cache"), help="5 GB for both cameras")
    parser.add_argument("--validation-fold", type=int, choices=(1, 2, 3, 4))
    parser.add_argument("--steps", type=int, default=STEPS)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)

    torch.manual_seed(SEED)
    torch.set_num_threads(THREADS)
    camera, steps = arguments.camera, arguments.steps
    left_out = {TEST_FOLD, arguments.validation_fold}
    sources = []
    for of in (camera, *(c for c in SIZES_PX if c != camera)):
        cache = load(arguments.data, of, arguments.cache)
        learned = {
            int(i) for i in np.unique(cache.clip_ids) if cache.clips[i].fold not in left_out
        }
        sources.append(Source(cache, learned, of))
    validation = [
        c for c in read_split(camera) if c.fold == arguments.validation_fold and c.labels == "good"
    ]
    detector = Detector(camera).to(memory_format=torch.channels_last)
    width, height = SIZES_PX[camera]
    macs = count_macs(copy.deepcopy(detector), width, height)
    print(f"{camera}: {len(sources[0].pictures_of)} clips, {macs / 1e9:.3f} GMAC a picture", flush=True)
    detector.train()
    average = Average(detector)
    optimizer = optimizer_of(detector)
    middles, sizes = cells(detector.strides_px, *CANVAS_PX[camera])
    kept = arguments.out / f"{camera}-kept.pt"
    first = 0
    if kept.exists():
        first = restore(kept, detector, average, optimizer)
        print(f"goes on after step {first}", flush=True)
    batches = DataLoader(
        Batches(*sources, first, steps), batch_size=None, num_workers=WORKERS, prefetch_factor=4
    )

    curve = csv.writer((arguments.out / f"{camera}-curve.csv").open("a" if first else "w", newline="", buffering=1))
    if not first:
        curve.writerow(("step", "seconds", "rate", "box_loss", "score_loss", "drone_f1", "ap50_mean"))
    start_s, sums = time.monotonic(), np.zeros(2)
    for step, (pictures, boxes, classes, padding) in enumerate(batches, first):
        for group in optimizer.param_groups:
            group["lr"] = rate(step, steps)
        x = (pictures.float() / 255).contiguous(memory_format=torch.channels_last)
        with torch.autocast("cpu", torch.bfloat16):
            sides, scores = detector(x)
        box_cost, score_cost = cost.loss(
            corners(sides.float(), middles, sizes), scores.float(), middles, boxes, classes, padding
        )
        optimizer.zero_grad()
        (box_cost + score_cost).backward()
        torch.nn.utils.clip_grad_norm_(detector.parameters(), 10.0)
        optimizer.step()
        average.update(detector, step)
        sums += (box_cost.item(), score_cost.item())

        done = step + 1
        if done % 500 == 0 or done == steps:
            f1 = mean = ""
            if validation and (done % MEASURE_EVERY_STEPS == 0 or done == steps):
                tally = measure(average.detector, arguments.data, validation)
                f1 = round(tally.at(DRONE, tally.best_threshold(DRONE))[2], 4)
                mean = round(float(np.mean([tally.average_precision(c) for c in range(4)])), 4)
            count = (done - 1) % 500 + 1
            seconds = round(time.monotonic() - start_s)
            row = (done, seconds, f"{rate(step, steps):.6f}", *(sums / count).round(4), f1, mean)
            curve.writerow(row)
            print(*row, flush=True)
            sums[:] = 0
            keep(kept, detector, average, optimizer, done)
    torch.save(average.detector.state_dict(), arguments.out / f"{camera}.pt")
    export(average.detector, arguments.out / f"{camera}.onnx")


if __name__ == "__main__":
    main()
