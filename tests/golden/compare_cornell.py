"""Hold texray's pictures of an OBJ scene against Mitsuba 3, by hand: the full-size check of the Cornell scenes.

    python compare_cornell.py reference --obj cornell-box.obj --out box.npz --size 512 --spp 1024 --seeds 16
    python compare_cornell.py compare --reference box.npz seed1.exr seed2.exr ... seed16.exr

`reference` renders the scene in N seeds and stores the mean, the variance of the mean per pixel and channel, the
camera and the settings. `compare` reads at least 16 of texray's pictures that differ in their seed alone, and takes
their mean and its variance in the same way. They have to be made with the reference's camera, size and bounces, with
`--filter box --sampler independent`, so that pixels and samples are independent, in the OBJ's radiance units. N
pictures of 1024 / N samples make one of 1024.

It prints, for each channel, the ratio of the means with its standard error (target: within 0.3 %), and the worst z of
the 16x16 tiles: the difference of the tile's means over the square root of both pictures' variances summed over the
tile (target: at most 5). A tile is inconclusive where 1 % of its pixels hold more than half of that variance, since z
is not normal there; these are listed (target: at most 1 % of the tiles). Chance of a false alarm: 3 x 1,024 tiles at
z = 5 give 1.8e-3. Exit status 1 where a target is missed. Needs `pip install mitsuba numpy`, as mitsuba_golden.py.
"""
import argparse
import json
import sys
import time

import numpy as np

import mitsuba_scene

TILE = 16
WORST_Z = 5.0
MEAN_TOLERANCE = 3e-3
INCONCLUSIVE_SHARE = 0.01
# Share of a tile's mean that f32 arithmetic may account for (ROUNDING in tests/harness/statistics.rs).
ROUNDING = 2e-5


def reference(arguments, mi):
    """Renders the reference and stores it."""
    began = time.perf_counter()
    camera, size = mitsuba_scene.camera_of(arguments), arguments.size
    loaded = mitsuba_scene.scene(mi, arguments.obj, camera, size, size, arguments.bounces)
    mean, variance = mitsuba_scene.render_seeds(mi, loaded, arguments.spp, range(1, arguments.seeds + 1))
    settings = {"camera": camera, "size": size, "max_bounces": arguments.bounces, "spp_per_seed": arguments.spp,
                "seeds": arguments.seeds, "renderer": "mitsuba " + mi.__version__, "variant": arguments.variant,
                "scene_content": mitsuba_scene.content_hash(arguments.obj)}
    np.savez_compressed(arguments.out, mean=mean, variance=variance, settings=json.dumps(settings))
    print(f"{arguments.out}: mean {mean.mean(axis=(0, 1))}, {time.perf_counter() - began:.0f} s")


def read_pictures(mi, paths):
    """Mean and variance of the mean of several EXR files of one size."""
    images = []
    for path in paths:
        bitmap = mi.Bitmap(path).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
        images.append(np.array(bitmap, dtype=np.float64))
        if images[-1].shape != images[0].shape:
            sys.exit(f"{path} is of another size than {paths[0]}")
        if not np.isfinite(images[-1]).all():
            sys.exit(f"{path} holds a number that is not finite")
        if len(images) > 1 and np.array_equal(images[-1], images[-2]):
            sys.exit(f"{path} is the picture before it again: give each a seed of its own")
    images = np.stack(images)
    return images.mean(axis=0), images.var(axis=0, ddof=1) / len(images)


def tiles(image):
    """The pixels of each whole tile: (tiles down, tiles across, pixels, channels)."""
    down, across = image.shape[0] // TILE, image.shape[1] // TILE
    cut = image[:down * TILE, :across * TILE].reshape(down, TILE, across, TILE, 3)
    return cut.transpose(0, 2, 1, 3, 4).reshape(down, across, TILE * TILE, 3)


def compare(arguments, mi):
    """Prints the figures; returns whether all targets are met."""
    stored = np.load(arguments.reference)
    wanted, wanted_variance = stored["mean"], stored["variance"]
    print("reference:", str(stored["settings"]))
    if len(arguments.pictures) < 16:
        sys.exit(f"{len(arguments.pictures)} pictures: at least 16 seeds, or their variance means little")
    mean, variance = read_pictures(mi, arguments.pictures)
    if mean.shape != wanted.shape:
        sys.exit(f"the pictures are {mean.shape[1]}x{mean.shape[0]}, the reference {wanted.shape[1]}x{wanted.shape[0]}")

    met = True
    for channel, name in enumerate(("red", "green", "blue")):
        ours, theirs = mean[..., channel].sum(), wanted[..., channel].sum()
        error = np.sqrt(variance[..., channel].sum() / ours**2 + wanted_variance[..., channel].sum() / theirs**2)
        within = abs(ours / theirs - 1) <= MEAN_TOLERANCE
        met &= within
        print(f"{name}: mean ratio {ours / theirs:.5f} ± {error:.5f} {'ok' if within else 'MISSED'}")

    of_tile = tiles(variance + wanted_variance)
    total = of_tile.sum(axis=2)
    few = -(-TILE * TILE // 100)
    silent = np.sort(of_tile, axis=2)[:, :, -few:].sum(axis=2) > total / 2
    difference = np.abs(tiles(mean - wanted).sum(axis=2))
    excess = np.maximum(difference - ROUNDING * tiles(wanted).sum(axis=2), 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(excess == 0, 0, excess / np.sqrt(total))
    heard = np.where(silent, 0, z)
    y, x, channel = np.unravel_index(np.argmax(heard), heard.shape)
    within = heard.max() <= WORST_Z
    few_silent = silent.any(axis=2).sum() <= INCONCLUSIVE_SHARE * silent.shape[0] * silent.shape[1]
    met &= bool(within and few_silent)
    print(f"worst tile: z {heard.max():.2f} at x {x * TILE}, y {y * TILE}, channel {channel} "
          f"{'ok' if within else 'MISSED'}; root mean square z {np.sqrt((z[~silent] ** 2).mean()):.3f} (1 expected)")
    print(f"inconclusive: {silent.any(axis=2).sum()} of {silent.shape[0] * silent.shape[1]} tiles "
          f"{'ok' if few_silent else 'MISSED'}")
    for y, x in np.argwhere(silent.any(axis=2)):
        print(f"  x {x * TILE}, y {y * TILE}: z {z[y, x].round(2)}")
    return met


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    render = commands.add_parser("reference", help="render the reference")
    mitsuba_scene.add_arguments(render)
    render.add_argument("--size", type=int, default=512, help="width and height in pixels")
    render.add_argument("--out", required=True, help="NPZ file")
    check = commands.add_parser("compare", help="hold pictures against it")
    check.add_argument("--reference", required=True, help="NPZ file of `reference`")
    check.add_argument("--variant", default="scalar_rgb", help="any variant reads EXR files")
    check.add_argument("pictures", nargs="+", help="EXR files, one a seed")
    arguments = parser.parse_args()

    import mitsuba as mi
    mi.set_variant(arguments.variant)
    if arguments.command == "reference":
        reference(arguments, mi)
    elif not compare(arguments, mi):
        sys.exit(1)


main()
