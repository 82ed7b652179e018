"""Poses in the conventions of OpenCV, ROS and aerospace, by OpenCV and SciPy.

Writes conversions.json and the camera files opencv<version>.* beside this script, once with
OpenCV 4 and once with OpenCV 5, whose files differ:
    pip install opencv-python-headless numpy scipy
    python3 conversions.py

Nothing here follows the Rust code. Attitudes are built from their definitions in the wanted
frame (SciPy's intrinsic ZYX), and pixels come from cv2.projectPoints.
"""

import json
import pathlib

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

HERE = pathlib.Path(__file__).parent
WIDTH, HEIGHT = 1280, 720
CAMERA_MATRIX = np.array([[1010.0, 0, 650.0], [0, 990.0, 355.0], [0, 0, 1]])
DISTORTION = np.array([-0.28, 0.07, 1e-3, -5e-4, 0.01])
MOUNT_DEG = -2.5  # the camera looks down by this
OFFSET_M = 0.5
# Landmarks in the deck's frame of ROS: x forward, y left, z up.
LANDMARKS_ROS = np.array(
    [[0, 4, 2], [0, -4, 2], [0, 4, -2], [0, -4, -2], [4, 0, 3.0]], dtype=float
)

# Axes by name: deck (x forward, y up, z right) of ROS, front-right-down of ROS.
DECK_OF_ROS = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0.0]])
FRD_OF_ROS = np.array([[1, 0, 0], [0, -1, 0], [0, 0, -1.0]])
# ROS body (x forward, y left, z up) to optical frame (x right, y down, z ahead), REP 103.
OPTICAL_OF_ROS = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0.0]])


def case(position_ros, yaw, pitch, roll):
    """A body at a place of the deck's ROS frame, turned by angles about ROS axes."""
    turn = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    r = turn.as_matrix()
    # Looking down by an angle is a positive turn about y, which points left.
    mount = Rotation.from_euler("Y", np.deg2rad(-MOUNT_DEG)).as_matrix()
    camera_ros = position_ros + r @ [OFFSET_M, 0, 0]
    optical_of_deck_ros = OPTICAL_OF_ROS @ mount.T @ r.T
    tvec = -optical_of_deck_ros @ camera_ros
    rvec, _ = cv2.Rodrigues(optical_of_deck_ros)
    rvec_deck, _ = cv2.Rodrigues(optical_of_deck_ros @ DECK_OF_ROS.T)
    pixels = None
    if ((LANDMARKS_ROS - camera_ros) @ r @ mount)[:, 0].min() > 1:
        pixels, _ = cv2.projectPoints(LANDMARKS_ROS, rvec, tvec, CAMERA_MATRIX, DISTORTION)
        pixels = pixels.reshape(-1, 2).tolist()
    x, y, z, w = turn.as_quat(canonical=True)
    r_frd = FRD_OF_ROS @ r @ FRD_OF_ROS.T
    yaw_frd, pitch_frd, roll_frd = Rotation.from_matrix(r_frd).as_euler("ZYX")
    frd = Rotation.from_matrix(r_frd).as_quat(canonical=True)
    return {
        "position_m": (DECK_OF_ROS @ camera_ros).tolist(),
        "rodrigues_rad": Rotation.from_matrix(DECK_OF_ROS @ r @ DECK_OF_ROS.T)
        .as_rotvec()
        .tolist(),
        "opencv_deck": {"rvec": rvec_deck.ravel().tolist(), "tvec": tvec.tolist()},
        "opencv_rep103": {"rvec": rvec.ravel().tolist(), "tvec": tvec.tolist()},
        "rep103": {
            "position": position_ros.tolist(),
            "wxyz": [w, x, y, z],
            "rpy": [roll, pitch, yaw],
        },
        "frd": {
            "position": (FRD_OF_ROS @ position_ros).tolist(),
            "wxyz": [frd[3], frd[0], frd[1], frd[2]],
            "rpy": [roll_frd, pitch_frd, yaw_frd],
        },
        "pixels_xy": pixels,
    }


def main():
    rng = np.random.default_rng(1)
    cases = [case(np.array([-20.0, 0, 0]), 0, 0, 0)]
    for _ in range(12):  # ahead of the deck, little turned: seen
        place = np.array([rng.uniform(-50, -15), rng.uniform(-3, 3), rng.uniform(-1, 4)])
        cases.append(case(place, *rng.uniform(-0.1, 0.1, 3)))
    for _ in range(12):  # anywhere
        yaw, roll = rng.uniform(-3.1, 3.1, 2)
        cases.append(case(rng.uniform(-20, 20, 3), yaw, rng.uniform(-1.5, 1.5), roll))
    data = {
        "versions": {"opencv": cv2.__version__, "numpy": np.__version__},
        "mount_deg": MOUNT_DEG,
        "offset_m": OFFSET_M,
        "landmarks_m": (LANDMARKS_ROS @ DECK_OF_ROS.T).tolist(),
        "cases": cases,
    }
    (HERE / "conversions.json").write_text(json.dumps(data, indent=1) + "\n")
    for suffix in ["yaml", "xml", "json"]:
        file = cv2.FileStorage(str(HERE / "cameras" / f"opencv{cv2.__version__[0]}.{suffix}"), cv2.FILE_STORAGE_WRITE)
        file.write("calibration_time", "Sun 22 Nov 2026 12:00:00")
        file.write("image_width", WIDTH)
        file.write("image_height", HEIGHT)
        file.write("camera_matrix", CAMERA_MATRIX)
        file.write("distortion_coefficients", DISTORTION)
        file.release()


if __name__ == "__main__":
    main()
