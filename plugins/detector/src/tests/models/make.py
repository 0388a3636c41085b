"""Writes the small models that the tests load: one that is right, and those that are not."""

from pathlib import Path

import numpy as np
from onnx import TensorProto, checker, helper, numpy_helper, save

HERE = Path(__file__).parent
# middle, size, and scores of four classes, for two boxes: one that is sure, one that is not
BOXES = np.array([[16, 40], [12, 40], [8, 4], [6, 4], [0.9, 0.05], [0.05, 0.02], [0.02, 0.02], [0.01, 0.01]], np.float32)


def model(name: str, shape: list[int], nodes: list, constants: dict[str, np.ndarray], out: list[int]) -> None:
    graph = helper.make_graph(
        nodes,
        name,
        [helper.make_tensor_value_info("images", TensorProto.FLOAT, shape)],
        [helper.make_tensor_value_info("output0", TensorProto.FLOAT, out)],
        [numpy_helper.from_array(value, key) for key, value in constants.items()],
    )
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    checker.check_model(made)
    save(made, str(HERE / f"{name}.onnx"))


def boxes_plus(inner: list, last: str) -> list:
    """The boxes, and nothing of the picture: what `last` is, is multiplied away, unless it is no number."""
    return [
        *inner,
        helper.make_node("Mul", [last, "nothing"], ["zero"]),
        helper.make_node("Add", ["boxes", "zero"], ["output0"]),
    ]


constants = {"boxes": BOXES[None], "nothing": np.zeros((1, 1, 1), np.float32)}
mean = [
    helper.make_node("ReduceMean", ["images"], ["mean4"], axes=[1, 2, 3], keepdims=1),
    helper.make_node("Reshape", ["mean4", "shape"], ["mean"]),
]
constants["shape"] = np.array([1, 1, 1], np.int64)
model("constant", [1, 3, 48, 64], boxes_plus(mean, "mean"), constants, [1, 8, 2])
model("four-channels", [1, 4, 48, 64], boxes_plus(mean, "mean"), constants, [1, 8, 2])
model("five-rows", [1, 3, 48, 64], boxes_plus(mean, "mean"), {**constants, "boxes": BOXES[None, :5]}, [1, 5, 2])

# The square root of what is left of a quarter: of no brighter picture than that.
root = [
    *mean,
    helper.make_node("Sub", ["quarter", "mean"], ["left"]),
    helper.make_node("Sqrt", ["left"], ["root"]),
]
quarter = {**constants, "quarter": np.full((1, 1, 1), 0.25, np.float32)}
model("no-numbers", [1, 3, 48, 64], boxes_plus(root, "root"), quarter, [1, 8, 2])

# Seven billion multiplications.
slow = [
    helper.make_node("Conv", ["images", "weights"], ["wide"], kernel_shape=[7, 7], pads=[3, 3, 3, 3]),
    helper.make_node("ReduceMean", ["wide"], ["mean4"], axes=[1, 2, 3], keepdims=1),
    helper.make_node("Reshape", ["mean4", "shape"], ["mean"]),
]
weights = {**constants, "weights": np.full((64, 3, 7, 7), 1e-3, np.float32)}
model("slow", [1, 3, 864, 864], boxes_plus(slow, "mean"), weights, [1, 8, 2])
