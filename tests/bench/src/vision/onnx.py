# Runs a model with ONNX Runtime on one core, and prints how long a run takes, and where its library is.
import glob
import json
import os
import sys
import time

import numpy
import onnxruntime

options = onnxruntime.SessionOptions()
options.intra_op_num_threads = 1
session = onnxruntime.InferenceSession(sys.argv[1], options, providers=["CPUExecutionProvider"])
given = session.get_inputs()[0]
picture = numpy.random.default_rng(1).random(given.shape, dtype=numpy.float32)
seconds = []
for _ in range(int(sys.argv[2])):
    begun = time.perf_counter()
    session.run(None, {given.name: picture})
    seconds.append(time.perf_counter() - begun)
folder = os.path.join(os.path.dirname(onnxruntime.__file__), "capi")
library = sorted(glob.glob(os.path.join(folder, "libonnxruntime.so*")))
print(json.dumps({
    "version": onnxruntime.__version__,
    "seconds": float(numpy.median(seconds)),
    "library": library[0] if library else "",
}))
