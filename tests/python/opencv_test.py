"""A scanner is made of OpenCV's arrays in the shapes that OpenCV gives them."""

import numpy
import pytest

import slipstream

CAMERA = numpy.array([[500.0, 0, 160], [0, 500, 120], [0, 0, 1]])
PROJECTOR = numpy.array([[1000.0, 0, 640], [0, 1000, 400], [0, 0, 1]])
SIZES = {"camera_size": (320, 240), "projector_size": (1280, 800)}
# As cv2.stereoCalibrate returns them.
RESULTS = {
    "camera_matrix": CAMERA,
    "camera_distortion": numpy.array([[0.1, -0.02, 0.001, 0.002, 0.01]]),
    "projector_matrix": PROJECTOR,
    "projector_distortion": numpy.zeros((1, 5)),
    "rotation": numpy.eye(3),
    "translation": numpy.array([[-100.0], [0], [10]]),
}


def made(**changes):
    return slipstream.Scanner(**{**RESULTS, **SIZES, **changes})


@pytest.mark.parametrize("shape", [(1, 4), (1, 5), (5, 1), (5,), (8,), (1, 8), (12, 1), (14, 1),
                                   (1, 14), (0,)])
def test_distortion_is_a_row_or_a_column(shape):
    given = 0.01 * numpy.arange(1, numpy.prod(shape) + 1).reshape(shape)
    expected = list(given.ravel()) + [0.0] * (14 - given.size)
    assert made(camera_distortion=given).camera_distortion == expected
    assert made(projector_distortion=given.tolist()).projector_distortion == expected
    assert made(camera_distortion=given.astype("f4")).camera_distortion == pytest.approx(expected)


def test_no_distortion():
    for given in [None, []]:
        assert made(camera_distortion=given).camera_distortion == [0.0] * 14


@pytest.mark.parametrize("shape", [(3,), (3, 1), (1, 3)])
def test_translation_is_a_row_or_a_column(shape):
    given = RESULTS["translation"].reshape(shape)
    assert made(translation=given).translation == pytest.approx([-100, 0, 10])


def test_results_of_stereo_calibration_are_in_its_order():
    scanner = slipstream.Scanner.from_opencv(*RESULTS.values(), **SIZES)
    assert scanner == made()
    assert slipstream.Scanner.from_opencv(
        CAMERA, None, PROJECTOR, None, numpy.eye(3), (-100, 0, 10), **SIZES
    ).translation == pytest.approx([-100, 0, 10])
    with pytest.raises(TypeError, match="Scanner.from_opencv.*: camera_size is missing"):
        slipstream.Scanner.from_opencv(*RESULTS.values())
    with pytest.raises(TypeError, match="^rotation is missing$"):
        slipstream.Scanner.from_opencv(CAMERA, None, PROJECTOR, **SIZES)


def test_all_results_of_stereo_calibration_go_in_at_once():
    results = (0.3, *RESULTS.values(), numpy.zeros((3, 3)), numpy.zeros((3, 3)))
    assert slipstream.Scanner.from_opencv(results, **SIZES) == made()
    with pytest.raises(slipstream.Error, match="^rotation: the results .* have it already$"):
        slipstream.Scanner.from_opencv(results, rotation=numpy.eye(3), **SIZES)

    # cv2.fisheye.stereoCalibrate gives nine as well, of lenses that the scanner does not have.
    of_fisheye = (*results[:7], (numpy.zeros((3, 1)),), (numpy.zeros((3, 1)),))
    with pytest.raises(slipstream.Error, match="^camera_matrix: 9 results without E and F"):
        slipstream.Scanner.from_opencv(of_fisheye, **SIZES)


def test_what_opencv_returns_goes_in():
    cv2 = pytest.importorskip("cv2", reason="package cv2 is not installed")
    board = numpy.float32([(20 * i, 20 * j, 0) for j in range(6) for i in range(9)])
    seen = {"camera": [], "projector": []}
    turns = numpy.random.default_rng(1).uniform(-0.4, 0.4, (8, 3))
    for turn in turns:
        place = cv2.Rodrigues(turn)[0] @ board.T + [[-80], [-50], [700]]
        for device, moved in [("camera", place), ("projector", place + RESULTS["translation"])]:
            lens = RESULTS[f"{device}_matrix"], RESULTS[f"{device}_distortion"]
            seen[device].append(cv2.projectPoints(moved, *numpy.zeros((2, 3)), *lens)[0])

    seen = {device: numpy.float32(corners) for device, corners in seen.items()}
    results = cv2.stereoCalibrate(
        [board] * len(turns), seen["camera"], seen["projector"], CAMERA,
        RESULTS["camera_distortion"], PROJECTOR, RESULTS["projector_distortion"],
        SIZES["camera_size"], flags=cv2.CALIB_FIX_INTRINSIC)

    scanner = slipstream.Scanner.from_opencv(results, **SIZES)
    assert scanner.translation == pytest.approx([-100, 0, 10], abs=0.05)
    assert scanner.camera_distortion[:5] == list(RESULTS["camera_distortion"][0])
    assert scanner.projector_matrix == pytest.approx(PROJECTOR)


@pytest.mark.parametrize("name, value, message", [
    ("camera_matrix", CAMERA.ravel(),
     "camera_matrix: an array of shape (9,) and type float64; expected shape (3, 3)"),
    ("projector_matrix", numpy.eye(3, 4),
     "projector_matrix: an array of shape (3, 4) and type float64; expected shape (3, 3)"),
    ("rotation", numpy.zeros((3, 1)),
     "rotation: an array of shape (3, 1) and type float64; expected shape (3, 3), as "
     "cv2.Rodrigues(rotation)[0]"),
    ("translation", numpy.zeros((2, 1)),
     "translation: an array of shape (2, 1) and type float64; expected 3 numbers"),
    ("camera_distortion", numpy.zeros((2, 2)),
     "camera_distortion: an array of shape (2, 2) and type float64; expected shape (N,), (N, 1) or "
     "(1, N)"),
    ("projector_distortion", numpy.zeros((1, 6)),
     "projector_distortion: 6 distortion coefficients; expected 0, 4, 5, 8, 12 or 14"),
])
def test_the_array_of_a_wrong_shape_is_named(name, value, message):
    for make in [made, lambda **changes: slipstream.Scanner.from_opencv(
            **{**RESULTS, **SIZES, **changes})]:
        with pytest.raises(slipstream.Error) as error:
            make(**{name: value})
        assert str(error.value) == message


def test_an_array_of_other_things_is_named():
    with pytest.raises(TypeError, match="^camera_matrix cannot be 'x'; expected numbers$"):
        made(camera_matrix="x")
