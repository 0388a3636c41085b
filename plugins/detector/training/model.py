"""The network: a small convolutional detector with three grids, as YOLOv8's without its anchors' ballast.

Gives for each cell the four sides of a box and one score for each class. Infrared pictures enter
at 320x256 and have grids of 4, 8 and 16 pixels, visible ones at 640x512 with 8, 16 and 32.
"""

import torch
from torch import nn

from clips import CLASSES

STRIDES_PX = {"infrared": (4, 8, 16), "visible": (8, 16, 32)}
# A side is at most this many cells from the middle of its cell.
REACH_CELLS = 8.0


class Conv(nn.Sequential):
    """Convolution, batch normalisation, SiLU."""

    def __init__(self, inputs: int, outputs: int, kernel: int, stride: int = 1) -> None:
        padding = (kernel - 1) // 2 if kernel % 2 else 0
        super().__init__(
            nn.Conv2d(inputs, outputs, kernel, stride, padding, bias=False),
            nn.BatchNorm2d(outputs, eps=1e-3, momentum=0.03),
            nn.SiLU(inplace=True),
        )


class Bottleneck(nn.Module):
    def __init__(self, width: int) -> None:
        super().__init__()
        self.first = Conv(width, width, 3)
        self.second = Conv(width, width, 3)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return x + self.second(self.first(x))


class Stage(nn.Module):
    """Half of the channels go through bottlenecks, and all that was on the way is joined (C2f)."""

    def __init__(self, inputs: int, outputs: int, depth: int) -> None:
        super().__init__()
        half = outputs // 2
        self.kept = Conv(inputs, half, 1)
        self.worked = Conv(inputs, half, 1)
        self.blocks = nn.ModuleList(Bottleneck(half) for _ in range(depth))
        self.join = Conv((2 + depth) * half, outputs, 1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        parts = [self.kept(x), self.worked(x)]
        for block in self.blocks:
            parts.append(block(parts[-1]))
        return self.join(torch.cat(parts, 1))


class Head(nn.Module):
    """Sides and scores of one grid."""

    def __init__(self, inputs: int, width: int) -> None:
        super().__init__()
        self.shared = Conv(inputs, width, 3)
        self.sides = nn.Sequential(Conv(width, width, 1), nn.Conv2d(width, 4, 1))
        self.scores = nn.Sequential(Conv(width, width, 1), nn.Conv2d(width, len(CLASSES), 1))
        # at first boxes of some three cells, and hardly any object
        nn.init.constant_(self.sides[-1].bias, -0.2)
        nn.init.constant_(self.scores[-1].bias, -5.0)

    def forward(self, x: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        x = self.shared(x)
        return self.sides(x), self.scores(x)


class Detector(nn.Module):
    """Raw outputs of all cells: `sides` [n, cells, 4] and `scores` [n, cells, classes]."""

    def __init__(self, camera: str, widths: tuple[int, int, int, int] = (16, 24, 48, 96)) -> None:
        super().__init__()
        self.camera = camera
        self.strides_px = STRIDES_PX[camera]
        stem, fine, middle, coarse = widths
        if camera == "infrared":
            self.stem = Conv(1, stem, 3, 2)
        else:
            self.stem = Conv(3, stem, 4, 4)
        self.fine = nn.Sequential(Conv(stem, fine, 3, 2), Stage(fine, fine, 1))
        self.middle = nn.Sequential(Conv(fine, middle, 3, 2), Stage(middle, middle, 1))
        self.coarse = nn.Sequential(Conv(middle, coarse, 3, 2), Stage(coarse, coarse, 1))
        self.pool = nn.MaxPool2d(5, 1, 2)
        self.context = Conv(3 * coarse, coarse, 1)
        self.grow = nn.Upsample(scale_factor=2, mode="nearest")
        self.coarse_to_middle = Conv(coarse, middle, 1)
        self.middle_out = Stage(middle, middle, 1)
        self.middle_to_fine = Conv(middle, fine, 1)
        self.heads = nn.ModuleList(
            Head(inputs, width) for inputs, width in ((fine, fine), (middle, 32), (coarse, 48))
        )

    def grids(self, x: torch.Tensor) -> list[tuple[torch.Tensor, torch.Tensor]]:
        fine = self.fine(self.stem(x))
        middle = self.middle(fine)
        coarse = self.coarse(middle)
        once = self.pool(coarse)
        coarse = self.context(torch.cat([coarse, once, self.pool(once)], 1))
        middle = self.middle_out(middle + self.grow(self.coarse_to_middle(coarse)))
        fine = fine + self.grow(self.middle_to_fine(middle))
        return [head(x) for head, x in zip(self.heads, (fine, middle, coarse), strict=True)]

    def forward(self, x: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        grids = self.grids(x)
        sides = torch.cat([s.flatten(2) for s, _ in grids], 2).transpose(1, 2)
        scores = torch.cat([s.flatten(2) for _, s in grids], 2).transpose(1, 2)
        return sides, scores


def cells(strides_px: tuple[int, ...], width: int, height: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Middles [cells, 2] and sizes [cells, 1] of all cells in pixels, in the order of the outputs."""
    middles, sizes = [], []
    for stride in strides_px:
        y, x = torch.meshgrid(
            torch.arange(height // stride), torch.arange(width // stride), indexing="ij"
        )
        middles.append((torch.stack([x, y], -1).reshape(-1, 2) + 0.5) * stride)
        sizes.append(torch.full((len(middles[-1]), 1), float(stride)))
    return torch.cat(middles), torch.cat(sizes)


def corners(sides: torch.Tensor, middles: torch.Tensor, sizes: torch.Tensor) -> torch.Tensor:
    """Raw sides to left, top, right, bottom in pixels."""
    share = sides.sigmoid()
    distances = share * share * (REACH_CELLS * sizes)
    return torch.cat([middles - distances[..., :2], middles + distances[..., 2:]], -1)


def count_macs(model: Detector, width: int, height: int) -> int:
    """Multiplications of all convolutions for one picture."""
    total = 0

    def add(layer: nn.Conv2d, _: object, out: torch.Tensor) -> None:
        nonlocal total
        total += out[0].numel() * layer.weight[0].numel()

    hooks = [m.register_forward_hook(add) for m in model.modules() if isinstance(m, nn.Conv2d)]
    with torch.no_grad():
        model.eval()(torch.zeros(1, 1 if model.camera == "infrared" else 3, height, width))
    for hook in hooks:
        hook.remove()
    return total
