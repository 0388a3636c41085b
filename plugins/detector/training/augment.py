"""Makes training pictures: windows and mosaics out of the cache, with objects of other clips on them.

A clip has one background and one object, so what a detector must not learn is that they belong
together: objects are cut out and put onto other clips' backgrounds.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from cache import CHANNELS, LABELS_FROM_PX, Cache
from clips import CLASSES, SIZES_PX

# What is computed at once in training. Whole objects must fit, much empty sky is not needed.
CANVAS_PX = {"infrared": (224, 192), "visible": (320, 256)}
# Boxes are drawn with a margin in pixels, which other scales would not have: most stay near 1.
SCALES, WIDE_SCALES, WIDE_SHARE = (0.88, 1.14), (0.5, 2.0), 0.15
OTHER_CAMERA_SHARE = 0.2
CLASS_WEIGHTS = (0.36, 0.26, 0.2, 0.18)
SMALLEST_BOX_PX = {"infrared": 5.0, "visible": 10.0}
IGNORED = -1  # class of a box that is neither to be found nor background
NOISE_BANK = 1 << 22


@dataclass(frozen=True)
class Sample:
    picture: np.ndarray  # [height, width, channels], uint8
    boxes: np.ndarray  # [n, 4]: left, top, right, bottom in pixels
    classes: np.ndarray  # [n]


def affine(scale: float, angle_rad: float, mirror: bool) -> np.ndarray:
    cos, sin = np.cos(angle_rad) * scale, np.sin(angle_rad) * scale
    matrix = np.array([[cos, -sin], [sin, cos]])
    if mirror:
        matrix[:, 0] = -matrix[:, 0]
    return matrix


def for_cv2(matrix: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """The same transformation [2, 3], for functions that count from the middle of the first pixel and not from its edge."""
    half = np.full(2, 0.5)
    return np.column_stack([matrix, matrix @ half + offset - half])


def turned_size(size: np.ndarray, scale: float, angle_rad: float) -> np.ndarray:
    """Size of the box around a scaled and turned object, taken for an ellipse."""
    cos, sin = np.cos(angle_rad) ** 2, np.sin(angle_rad) ** 2
    width2, height2 = size[0] ** 2, size[1] ** 2
    return scale * np.sqrt([width2 * cos + height2 * sin, width2 * sin + height2 * cos])


class Source:
    """The pictures of some clips of one camera."""

    def __init__(self, cache: Cache, clip_ids: set[int], camera: str) -> None:
        self.cache = cache
        self.camera = camera
        self.pictures_of = {i: np.flatnonzero(cache.clip_ids == i) for i in sorted(clip_ids)}
        self.clips_of = [
            [i for i in self.pictures_of if cache.clips[i].class_id == c and len(self.pictures_of[i])]
            for c in range(len(CLASSES))
        ]

    def pick(self, rng: np.random.Generator, camera: str) -> tuple[np.ndarray, np.ndarray, int]:
        """A class by weight, a clip of it, a picture of that, as if the given camera had taken it.

        Gives the picture, its boxes in any order, and their class.
        """
        class_id = int(rng.choice(len(CLASSES), p=CLASS_WEIGHTS))
        number = rng.choice(self.pictures_of[rng.choice(self.clips_of[class_id])])
        picture, boxes = self.cache.pictures[number], rng.permutation(self.cache.boxes[number])
        if self.camera == camera:
            return picture, boxes, class_id
        width, height = SIZES_PX[camera]
        if camera == "infrared":
            # what is dark against the sky is often warm
            grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
            picture = cv2.resize(grey, (width, height), interpolation=cv2.INTER_AREA)
            if rng.random() < 0.6:
                picture = 255 - picture
            return picture[:, :, None], boxes / 2, class_id
        picture = cv2.resize(picture, (width, height), interpolation=cv2.INTER_CUBIC)
        if rng.random() < 0.6:
            picture = 255 - picture
        sky = np.array([[rng.uniform(0.5, 1.0)], [rng.uniform(0.7, 1.0)], [1.0]])
        return cv2.transform(picture[:, :, None], sky), boxes * 2, class_id


class Augmenter:
    """Draws samples from the clips of a camera, and now and then from those of the other one."""

    def __init__(self, own: Source, other: Source, seed: int) -> None:
        self.own, self.other = own, other
        self.camera = own.camera
        self.canvas_px = CANVAS_PX[own.camera]
        self.rng = np.random.default_rng(seed)
        self.noise = self.rng.standard_normal(NOISE_BANK, np.float32)

    def pick(self) -> tuple[np.ndarray, np.ndarray, int]:
        source = self.other if self.rng.random() < OTHER_CAMERA_SHARE else self.own
        return source.pick(self.rng, self.camera)

    def pick_scale(self, size: np.ndarray, room: np.ndarray) -> float:
        """A scale at which the object is neither lost nor larger than its room."""
        low, high = WIDE_SCALES if self.rng.random() < WIDE_SHARE else SCALES
        scale = float(np.exp(self.rng.uniform(np.log(low), np.log(high))))
        scale = max(scale, SMALLEST_BOX_PX[self.camera] / float(np.sqrt(size.prod())))
        return min(scale, float((0.9 * room / size).min()))

    def window(self, width: int, height: int) -> Sample:
        """A part of one picture, most often with its object in it."""
        rng = self.rng
        source, boxes, class_id = self.pick()
        box = boxes[0]
        centre, size = box[:2] + box[2:] / 2, box[2:]
        room = np.array([width, height], float)
        scale = self.pick_scale(size, room)
        angle = rng.uniform(-0.15, 0.15) if rng.random() < 0.4 else 0.0
        mirror = bool(rng.random() < 0.5)
        matrix = affine(scale, angle, mirror)
        inverse = np.linalg.inv(matrix)
        out_size = turned_size(size, scale, angle)
        source_room = np.array([source.shape[1], source.shape[0]], float)
        if rng.random() < 0.8:
            margin = np.minimum(out_size / 2, room / 2)
            at = rng.uniform(margin, room - margin)
            # middle of the window in the source, kept inside it as far as the window fits
            middle = centre + inverse @ (room / 2 - at)
        else:
            middle = rng.uniform((0, 0), source_room)
        half = np.abs(inverse) @ (room / 2)
        low_edge, high_edge = half, source_room - half
        middle = np.where(low_edge < high_edge, np.clip(middle, low_edge, high_edge), source_room / 2)
        offset = room / 2 - matrix @ middle
        picture = cv2.warpAffine(
            source, for_cv2(matrix, offset), (width, height), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        picture = picture.reshape(height, width, source.shape[2])

        kept, classes = [], []
        for box in boxes:
            middle_out = matrix @ (box[:2] + box[2:] / 2) + offset
            out_size = turned_size(box[2:], scale, angle)
            whole = np.concatenate([middle_out - out_size / 2, middle_out + out_size / 2])
            seen = np.clip(whole, 0, [width, height, width, height])
            share = (seen[2:] - seen[:2]).clip(0).prod() / out_size.prod()
            if share > 0.05:
                kept.append(seen)
                classes.append(class_id if share > 0.5 else IGNORED)
        return Sample(picture, np.array(kept).reshape(-1, 4), np.array(classes, int))

    def mosaic(self) -> Sample:
        """Four windows side by side."""
        width, height = self.canvas_px
        cut_x = int(self.rng.integers(int(0.35 * width), int(0.65 * width)))
        cut_y = int(self.rng.integers(int(0.35 * height), int(0.65 * height)))
        canvas = np.empty((height, width, CHANNELS[self.camera]), np.uint8)
        boxes, classes = [], []
        for left, right in ((0, cut_x), (cut_x, width)):
            for top, bottom in ((0, cut_y), (cut_y, height)):
                part = self.window(right - left, bottom - top)
                canvas[top:bottom, left:right] = part.picture
                boxes.append(part.boxes + np.array([left, top, left, top]))
                classes.append(part.classes)
        return Sample(canvas, np.concatenate(boxes), np.concatenate(classes))

    def cut_out(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, int] | None:
        """An object without its background: difference, opaque picture, its box in them, class."""
        source, boxes, class_id = self.pick()
        box = boxes[0]
        margin = max(3, int(0.35 * box[2:].max()))
        left, top = np.floor(box[:2] - margin).astype(int)
        right, bottom = np.ceil(box[:2] + box[2:] + margin).astype(int)
        if left < 0 or top < 0 or right > source.shape[1] or bottom > source.shape[0]:
            return None
        if max(right - left, bottom - top) > 160:
            return None
        patch = source[top:bottom, left:right].astype(np.float32)
        ring = np.ones(patch.shape[:2], bool)
        ring[margin:-margin, margin:-margin] = False
        background = np.median(patch[ring], axis=0)
        if np.abs(patch[ring] - background).mean() > 6:
            return None  # trees or clouds around it, that would come along
        return patch - background, patch, box - np.array([left, top, 0, 0]), class_id

    def paste(self, sample: Sample) -> Sample:
        """Puts the object of another clip somewhere onto the picture."""
        rng = self.rng
        cut = self.cut_out()
        if cut is None:
            return sample
        difference, opaque, cut_box, class_id = cut
        size = cut_box[2:]
        room = np.array(self.canvas_px, float)
        scale = self.pick_scale(size, room / 2)
        angle = rng.uniform(-0.3, 0.3)
        matrix = affine(scale, angle, bool(rng.random() < 0.5))
        out_size = turned_size(size, scale, angle)
        shape = np.array(difference.shape[1::-1])
        out_shape = np.ceil(np.abs(matrix) @ shape).astype(int) + 2
        at = np.floor(rng.uniform((0, 0), np.maximum(room - out_shape, 1))).astype(int)
        offset = out_shape / 2 - matrix @ (shape / 2)
        middle = at + matrix @ (cut_box[:2] + size / 2) + offset
        box = np.concatenate([middle - out_size / 2, middle + out_size / 2])
        if (at + out_shape > room).any() or overlaps(box, sample.boxes):
            return sample
        full = for_cv2(matrix, offset)
        target = tuple(int(v) for v in out_shape)

        def warp(picture: np.ndarray) -> np.ndarray:
            warped = cv2.warpAffine(picture, full, target, flags=cv2.INTER_LINEAR)
            return warped.reshape(target[1], target[0], -1)

        window = np.outer(edge_window(shape[1]), edge_window(shape[0])).astype(np.float32)
        canvas = sample.picture.copy()
        area = canvas[at[1] : at[1] + target[1], at[0] : at[0] + target[0]]
        mask = warp(window)
        strength = np.abs(difference).max(axis=2)
        if rng.random() < 0.5:
            gain = rng.uniform(0.4, 1.2)
            if self.camera == "visible" and rng.random() < 0.3:
                gain = -gain  # lit from the other side
            changed = area + gain * warp(difference) * mask
        else:
            full_at = max(20.0, 0.5 * float(strength.max()))
            alpha = warp(np.clip((strength - 3) / full_at, 0, 1)) * mask
            changed = area * (1 - alpha) + warp(opaque) * alpha
        area[:] = np.clip(changed, 0, 255).astype(np.uint8)
        return Sample(
            canvas, np.concatenate([sample.boxes, box[None]]), np.append(sample.classes, class_id)
        )

    def light(self, picture: np.ndarray) -> np.ndarray:
        """Other light, other camera, other encoder."""
        rng = self.rng
        channels = picture.shape[2]
        out = picture
        gains = np.ones(channels)
        if channels == 3:
            grey = np.full((3, 3), 1 / 3)
            saturation = 0.0 if rng.random() < 0.1 else rng.uniform(0.4, 1.5)
            out = cv2.transform(out, saturation * np.eye(3) + (1 - saturation) * grey)
            gains = rng.uniform(0.88, 1.12, 3)
        # contrast, brightness and gamma in one table
        mean = float(out[::4, ::4].mean())
        levels = np.arange(256.0)[:, None] * gains
        levels = (levels - mean) * rng.uniform(0.6, 1.4) + mean + rng.uniform(-35, 35)
        levels = np.clip(levels, 0, 255)
        if rng.random() < 0.3:
            levels = 255 * (levels / 255) ** rng.uniform(0.6, 1.6)
        if rng.random() < 0.02:
            levels = 255 - levels
        out = cv2.LUT(out, levels.round().astype(np.uint8)[None])
        if rng.random() < 0.25:
            out = cv2.GaussianBlur(out, (0, 0), rng.uniform(0.3, 0.9))
        if rng.random() < 0.4:
            start = int(rng.integers(0, NOISE_BANK - out.size))
            noise = self.noise[start : start + out.size] * np.float32(min(rng.exponential(4.0), 12.0))
            out = cv2.add(out.reshape(-1), noise, dtype=cv2.CV_8U)
        out = out.reshape(picture.shape)
        if rng.random() < 0.35:
            quality = int(rng.integers(25, 80))
            coded = cv2.imencode(".jpg", out, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
            out = cv2.imdecode(coded, cv2.IMREAD_UNCHANGED)
        return out.reshape(picture.shape)

    def sample(self, mosaic_share: float) -> Sample:
        if self.rng.random() < mosaic_share:
            sample = self.mosaic()
        else:
            sample = self.window(*self.canvas_px)
        for _ in range(int(self.rng.integers(0, 3))):
            sample = self.paste(sample)
        # told as the labels tell it
        return Sample(self.light(sample.picture), sample.boxes + LABELS_FROM_PX, sample.classes)


def overlaps(box: np.ndarray, boxes: np.ndarray) -> bool:
    low = np.maximum(box[:2], boxes[:, :2])
    high = np.minimum(box[2:], boxes[:, 2:])
    return bool((high > low).all(axis=1).any())


def edge_window(length: int) -> np.ndarray:
    """1 in the middle, falling to 0 over the outermost sixth on both sides."""
    at = (np.arange(length) + 0.5) / length
    return np.clip(6 * np.minimum(at, 1 - at), 0, 1)
