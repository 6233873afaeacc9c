"""Corrects the coordinate at edges of print: contrast.py SCAN COORDINATE.tiff

The camera's blur mixes neighbouring pixels, and the brighter ones pull the coordinate y to theirs,
by s^2 (grad B / B) . grad y. Modulation B and y are measured; s^2 is found where the surface is
smoothest after correction. Pixels at steps, or without a significant gradient, stay as they are."""

import sys

import numpy
from numpy.typing import NDArray

import slipstream

Image = NDArray[numpy.float64]

LEAST_MODULATION = 8.0    # grey levels
LEAST_GRADIENT = 0.03     # of B, relative, per pixel
DEVIATIONS = 4            # of the gradient's noise, above which it is significant
LEAST_GAIN = 0.025        # mean gain in likelihood of the significant pixels
ROUGHEST = 9              # variance of a corrected surface, in that of the whole picture
DERIVATIVE = numpy.array([1, -8, 0, 8, -1]) / 12


def along(image: Image, kernel: Image, axis: int) -> Image:
    """Correlates rows (axis 1) or columns (axis 0) with a kernel; zero beyond the picture."""
    half = len(kernel) // 2
    padded = numpy.pad(image, [(half, half) if i == axis else (0, 0) for i in (0, 1)])
    size = image.shape[axis]
    result: Image = numpy.zeros(image.shape)
    for i, weight in enumerate(kernel):
        result += weight * padded.take(range(i, i + size), axis)
    return result


def plane(y: Image, weight: Image, half: int) -> tuple[Image, Image, Image]:
    """Value and slopes, at each pixel, of the weighted plane through its window."""
    places = numpy.arange(-half, half + 1.0)
    ones = numpy.ones_like(places)

    total: Image = numpy.maximum(along(along(weight, ones, 1), ones, 0), 1e-9)

    def mean(image: Image, x: Image = ones, y: Image = ones) -> Image:
        result: Image = along(along(image, x, 1), y, 0) / total
        return result

    mx, my, m = mean(weight, places), mean(weight, ones, places), mean(weight * y)
    xx, yy = mean(weight, places**2) - mx**2, mean(weight, ones, places**2) - my**2
    xy = mean(weight, places, places) - mx * my
    tx, ty = mean(weight * y, places) - mx * m, mean(weight * y, ones, places) - my * m
    determinant = numpy.maximum(xx * yy - xy**2, 1e-3 * xx * yy + 1e-12)
    right, down = (tx * yy - ty * xy) / determinant, (ty * xx - tx * xy) / determinant
    return m - right * mx - down * my, right, down


def pull(y: Image, modulation: Image) -> tuple[float, Image]:
    """The variance s^2, pixels^2, and the pull of each pixel, to be subtracted from y."""
    lit = numpy.isfinite(y) & (modulation > LEAST_MODULATION)
    y = numpy.where(lit, y - numpy.median(y[lit]), 0)
    b: Image = numpy.nan_to_num(modulation)
    weight = (lit * b)**2

    # 1. Significant gradients of the modulation; its noise is seen in second differences.
    across, down = (along(b, DERIVATIVE, axis) / numpy.maximum(b, 1) for axis in (1, 0))
    steepness = numpy.hypot(across, down)
    bend = numpy.array([1.0, -2, 1])
    second = (along(along(b, bend, 1), bend, 0) / 6)[lit]
    noise = 1.4826 * numpy.median(abs(second)) * (2 * DERIVATIVE @ DERIVATIVE)**0.5
    strong = lit & (steepness * b > DEVIATIONS * noise) & (steepness > LEAST_GRADIENT)
    strong[:2] = strong[-2:] = strong[:, :2] = strong[:, -2:] = False
    if not strong.any():
        return 0.0, numpy.zeros_like(y)

    def roughness(image: Image) -> Image:
        return image - plane(image, weight, 5)[0]

    # 2. The s^2 that leaves the smoothest surface. Large residuals count little.
    rough = roughness(y)
    unit = (1.4826 * numpy.median(abs(rough * b)[lit]))**2
    variance, variances = 0.0, numpy.linspace(0, 2, 101)
    pulled = numpy.zeros_like(y)
    for _ in range(2):
        _, right_slope, down_slope = plane(y - variance * pulled, weight, 2)
        pulled = numpy.where(lit, right_slope * across + down_slope * down, 0)
        rough_pull = roughness(pulled)
        costs = [numpy.log1p(((rough - v * rough_pull) * b)[strong]**2 / (9 * unit)).mean()
                 for v in variances]
        variance = variances[numpy.argmin(costs)]
    if costs[0] - min(costs) < LEAST_GAIN:
        return 0.0, numpy.zeros_like(y)

    # 3. Correct where it makes the surface smoother, and leaves no step.
    # A wrong fringe order nearby counts little.
    def windows(image: Image) -> Image:
        return along(along(image, numpy.ones(7), 1), numpy.ones(7), 0)

    def local(residual: Image) -> Image:
        return windows(numpy.minimum(weight * residual**2, 100 * unit))

    after = local(rough - variance * rough_pull)
    better = (after < local(rough)) & (after < ROUGHEST * unit * windows(lit * 1.0))
    return variance, numpy.where(strong & better, variance * pulled, 0)


def main(folder: str, target: str) -> None:
    scan = slipstream.load_scan(folder)
    maps = slipstream.decode(scan.frames, scan.sequence, raw=True, minimum_modulation=5)
    assert maps.coordinate is not None and maps.modulation is not None
    variance, change = pull(maps.coordinate.astype(float), maps.modulation.astype(float))
    lit = maps.modulation > LEAST_MODULATION
    slipstream.write_map(target, numpy.where(lit, maps.coordinate - change, numpy.nan))
    print(f"s^2 = {variance:.2f} pixels^2; corrected {numpy.count_nonzero(change)} pixels")


if __name__ == "__main__":
    main(*sys.argv[1:])
