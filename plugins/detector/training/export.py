"""Writes a trained network as ONNX: pictures in, boxes and class scores out, as YOLOv8 gives them."""

import copy
from pathlib import Path

import onnx
import torch
from torch import nn

from clips import CLASSES, SIZES_PX
from model import Conv, Detector, cells, corners

OPSET = 17


class Exported(nn.Module):
    """RGB 0..1 [1, 3, height, width] to [1, 4 + classes, cells]: centre, size, scores."""

    def __init__(self, detector: Detector, width: int, height: int) -> None:
        super().__init__()
        self.detector = detector
        self.counts = [(width // s) * (height // s) for s in detector.strides_px]
        middles, sizes = cells(detector.strides_px, width, height)
        self.register_buffer("middles", middles[None])
        self.register_buffer("sizes", sizes[None])

    def forward(self, images: torch.Tensor) -> torch.Tensor:
        # sizes as plain numbers, so that the graph has no arithmetic of shapes
        flat = [
            (sides.reshape(1, 4, count), scores.reshape(1, len(CLASSES), count))
            for (sides, scores), count in zip(self.detector.grids(images), self.counts, strict=True)
        ]
        sides = torch.cat([s for s, _ in flat], 2).transpose(1, 2)
        scores = torch.cat([s for _, s in flat], 2).transpose(1, 2)
        box = corners(sides, self.middles, self.sizes)
        low, high = box[..., :2], box[..., 2:]
        rows = torch.cat([(low + high) * 0.5, high - low, scores.sigmoid()], -1)
        return rows.transpose(1, 2)


def fuse(detector: Detector) -> Detector:
    """The same network without batch normalisation, and with three channels at its entry."""
    fused = copy.deepcopy(detector).eval().float()
    for layer in fused.modules():
        if isinstance(layer, Conv):
            layer[0] = nn.utils.fuse_conv_bn_eval(layer[0], layer[1])
            layer[1] = nn.Identity()
    entry = fused.stem[0]
    if entry.in_channels == 1:
        entry.weight = nn.Parameter(entry.weight.repeat(1, 3, 1, 1) / 3)
        entry.in_channels = 3
    return fused


def export(detector: Detector, path: Path) -> None:
    width, height = SIZES_PX[detector.camera]
    module = Exported(fuse(detector), width, height).eval()
    torch.onnx.export(
        module,
        (torch.zeros(1, 3, height, width),),
        str(path),
        opset_version=OPSET,
        input_names=["images"],
        output_names=["output0"],
        dynamo=False,
    )
    graph = onnx.load(str(path))
    for key, value in (
        ("names", str(dict(enumerate(CLASSES)))),
        ("stride", str(max(detector.strides_px))),
        ("imgsz", str([height, width])),
        ("task", "detect"),
        ("camera", detector.camera),
    ):
        entry = graph.metadata_props.add()
        entry.key, entry.value = key, value
    onnx.checker.check_model(graph)
    onnx.save(graph, str(path))
