"""Writes what `training/classify.py` makes of drawn pictures, for the tests: run with the folder `training` in PYTHONPATH."""

import json
from pathlib import Path

import numpy as np
import onnxruntime
import torch

from classify import MOMENT_STEP, MOMENTS, normalise, numbers, window

HERE = Path(__file__).parent
MODEL = HERE.parents[2] / "models" / "classifier.onnx"


def picture(number: int) -> np.ndarray:
    """Noise that any language can draw, and a dark thing that flies to the right and flaps."""
    y, x = np.mgrid[0:96, 0:128]
    grey = 150 + (x * 7 + y * 13 + number * 5) % 9
    wide, high = 7, 2 + number // 4 % 3
    thing = (abs(x - (30 + number)) <= wide) & (abs(y - 40) <= high)
    return np.where(thing, 60 + (x + y) % 5, grey).astype(np.uint8)


def box(number: int) -> list[float]:
    high = 2 + number // 4 % 3
    return [23.0 + number, 40.0 - high, 15.0, 2 * high + 1.0]


moments = [(MOMENTS - 1 - i) * MOMENT_STEP for i in range(MOMENTS)]
newest = 30
frames = [newest - ago for ago in moments]
windows = np.stack([window(picture(n), np.array(box(n))) for n in frames])
inputs = normalise(torch.tensor(windows[None], dtype=torch.float32))
model = onnxruntime.InferenceSession(str(MODEL))
out = {}
for camera in ("infrared", "visible"):
    of_boxes = numbers(np.array([[box(n) for n in frames]]), camera)
    said = model.run(None, {"windows": inputs.numpy(), "numbers": of_boxes})[0][0]
    out[camera] = {"numbers": of_boxes[0].round(5).tolist(), "probabilities": said.round(5).tolist()}
out["cells"] = {str(at): round(float(inputs[0].reshape(-1)[at]), 5) for at in range(0, 8 * 1024, 411)}
(HERE / "golden.json").write_text(json.dumps(out, indent=1) + "\n")
