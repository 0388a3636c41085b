"""What a right answer is: which cells answer for an object (task-aligned), and what a wrong one costs."""

import torch
from torch.nn import functional

from augment import IGNORED

CELLS_PER_OBJECT = 10
SCORE_POWER, OVERLAP_POWER = 0.5, 4.0
BOX_GAIN, SCORE_GAIN = 7.5, 1.0


def overlap(a: torch.Tensor, b: torch.Tensor, complete: bool = False) -> torch.Tensor:
    """Intersection over union of corners; complete: less for middles apart and other shapes."""
    low = torch.maximum(a[..., :2], b[..., :2])
    high = torch.minimum(a[..., 2:], b[..., 2:])
    inner = (high - low).clamp(min=0).prod(-1)
    size_a, size_b = a[..., 2:] - a[..., :2], b[..., 2:] - b[..., :2]
    union = size_a.prod(-1) + size_b.prod(-1) - inner + 1e-7
    plain = inner / union
    if not complete:
        return plain
    hull = torch.maximum(a[..., 2:], b[..., 2:]) - torch.minimum(a[..., :2], b[..., :2])
    apart = ((a[..., :2] + a[..., 2:] - b[..., :2] - b[..., 2:]) ** 2).sum(-1) / 4
    turn_a = torch.atan(size_a[..., 0] / (size_a[..., 1] + 1e-7))
    turn_b = torch.atan(size_b[..., 0] / (size_b[..., 1] + 1e-7))
    shape = (4 / torch.pi**2) * (turn_a - turn_b) ** 2
    with torch.no_grad():
        weight = shape / (shape - plain + 1 + 1e-7)
    return plain - apart / ((hull**2).sum(-1) + 1e-7) - weight * shape


def assign(
    scores: torch.Tensor,
    boxes: torch.Tensor,
    middles: torch.Tensor,
    true_boxes: torch.Tensor,
    true_classes: torch.Tensor,
    padding: torch.Tensor,
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Targets of all cells: class scores [n, cells, c], boxes [n, cells, 4], ignored [n, cells].

    `scores` are 0..1, `true_*` are padded to the most objects of a picture, where `padding` is set.
    """
    cell_count = len(middles)
    delta = torch.cat(
        [middles[None, None] - true_boxes[:, :, None, :2], true_boxes[:, :, None, 2:] - middles], -1
    )
    inside = (delta.amin(-1) > 0) & ~padding[..., None]
    ignore = true_classes == IGNORED
    ignored = (inside & ignore[..., None]).any(1)
    inside &= ~ignore[..., None]
    iou = overlap(true_boxes[:, :, None], boxes[:, None]).clamp(min=0) * inside
    index = true_classes.clamp(min=0)[..., None].expand(-1, -1, cell_count)
    aligned = scores.transpose(1, 2).gather(1, index) ** SCORE_POWER * iou**OVERLAP_POWER * inside
    # an object that no answer overlaps yet still gets the cells inside it
    ranked = torch.where(inside, aligned + 1e-9, 0.0)
    best = ranked.topk(min(CELLS_PER_OBJECT, cell_count), -1)
    chosen = torch.zeros_like(inside).scatter(-1, best.indices, best.values > 0)
    # a cell that several objects chose belongs to the one it overlaps most
    owner = (iou + 1e-9).masked_fill(~chosen, -1).argmax(1)
    chosen &= functional.one_hot(owner, chosen.shape[1]).permute(0, 2, 1).bool()
    aligned = aligned * chosen
    top = aligned.amax(-1, keepdim=True)
    quality = aligned * (iou * chosen).amax(-1, keepdim=True) / (top + 1e-9)
    cell_quality = quality.amax(1)
    taken = chosen.any(1)
    cell_class = true_classes.clamp(min=0).gather(1, owner)
    targets = functional.one_hot(cell_class, scores.shape[-1]) * (cell_quality * taken)[..., None]
    target_boxes = true_boxes.gather(1, owner[..., None].expand(-1, -1, 4))
    return targets, target_boxes, ignored & ~taken


def loss(
    sides_as_corners: torch.Tensor,
    logits: torch.Tensor,
    middles: torch.Tensor,
    true_boxes: torch.Tensor,
    true_classes: torch.Tensor,
    padding: torch.Tensor,
) -> tuple[torch.Tensor, torch.Tensor]:
    """Cost of boxes and of scores, per unit of what there was to find."""
    with torch.no_grad():
        targets, target_boxes, ignored = assign(
            logits.sigmoid(), sides_as_corners, middles, true_boxes, true_classes, padding
        )
    total = targets.sum().clamp(min=1)
    per_score = functional.binary_cross_entropy_with_logits(logits, targets, reduction="none")
    score_loss = (per_score.sum(-1) * ~ignored).sum() / total
    weight = targets.sum(-1)
    taken = weight > 0
    apart = 1 - overlap(sides_as_corners[taken], target_boxes[taken], complete=True)
    box_loss = (apart * weight[taken]).sum() / total
    return BOX_GAIN * box_loss, SCORE_GAIN * score_loss
