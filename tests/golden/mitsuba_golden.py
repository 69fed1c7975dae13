"""Make a golden: a small linear picture by Mitsuba 3 with the variance of each of its numbers.

    python mitsuba_golden.py --obj cornell-box.obj --out cornell-box

Comes in: an OBJ scene (see mitsuba_scene.py). Goes out: OUT.bin, little-endian f32: the means (height x width x 3,
rows from the top, linear Rec. 709), then the variances of these means in the same order; and OUT.json, which states
the sizes and how the numbers were made. `tests/harness/golden.rs` reads both. Radiance is in the file's units.

The variance is that of the mean over independent seeds (at least 16: the relative standard deviation of a variance
from n normal values is sqrt(2/(n-1)), 37 % at 16, which a region of pixels averages out). Needs `pip install mitsuba
numpy` and, for the LLVM variant, libLLVM 19 or later. Not part of any test run: goldens change by hand, in a commit of
their own.
"""
import argparse
import json
import os
import shlex
import sys
import time

import numpy as np

import mitsuba_scene


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    mitsuba_scene.add_arguments(parser)
    parser.add_argument("--out", required=True, help="OUT.bin and OUT.json are written")
    parser.add_argument("--size", type=int, default=64, help="width and height in pixels")
    arguments = parser.parse_args()
    if arguments.seeds < 16:
        parser.error(f"--seeds {arguments.seeds}: at least 16, or the variance means little")

    import mitsuba as mi
    mi.set_variant(arguments.variant)
    began = time.perf_counter()
    camera, size = mitsuba_scene.camera_of(arguments), arguments.size
    loaded = mitsuba_scene.scene(mi, arguments.obj, camera, size, size, arguments.bounces)
    mean, variance = mitsuba_scene.render_seeds(mi, loaded, arguments.spp, range(1, arguments.seeds + 1))
    if not (np.isfinite(mean).all() and np.isfinite(variance).all()):
        sys.exit("the picture holds a number that is not finite: no golden written")

    with open(arguments.out + ".bin", "wb") as file:
        file.write(mean.astype("<f4").tobytes())
        file.write(variance.astype("<f4").tobytes())
    command = ["mitsuba_golden.py", *(os.path.basename(word) if os.sep in word else word for word in sys.argv[1:])]
    header = {
        "layout": "f32 little-endian: mean[height][width][3], variance_of_mean[height][width][3]",
        "width": size, "height": size, "channels": 3,
        "scene": os.path.basename(arguments.obj), "scene_content": mitsuba_scene.content_hash(arguments.obj),
        "camera": camera, "filter": "box", "max_bounces": arguments.bounces,
        "spp_per_seed": arguments.spp, "seeds": arguments.seeds, "first_seed": 1,
        "renderer": "mitsuba " + mi.__version__, "variant": arguments.variant,
        "command": shlex.join(command), "seconds": round(time.perf_counter() - began, 1),
    }
    with open(arguments.out + ".json", "w", encoding="utf-8") as file:
        json.dump(header, file, indent=2)
        file.write("\n")
    error = np.sqrt(variance.mean()) / mean.mean()
    print(f"{arguments.out}: mean {mean.mean(axis=(0, 1))}, relative RMSE {error:.2e}, {header['seconds']} s")


main()
