"""Writes opencv.json: what OpenCV projects and solves, for tests to compare with.

    pip install opencv-python-headless numpy
    python opencv.py > opencv.json

Everything in the file is in OpenCV's terms: image x right and y down, camera X right, Y down,
Z forward, and rvec, tvec that take N to the camera.
"""

import json

import cv2
import numpy as np

SCENES = {
    "landing": [(0, 2, -4), (0, 2, 4), (0, -2, -4), (0, -2, 4), (4, 3, 0)],
    "quad": [(0, 2, -4), (0, 2, 4), (0, -2, -4), (0, -2, 4)],
    "deck": [(x, 0, z) for x in (-6, 0, 6, 12) for z in (-5, 4)],
}
DISTORTIONS = {"landing": [-0.28, 0.07, 1e-3, -5e-4, 0.01]}
WIDTH, HEIGHT, FOCAL, MOUNT_DEG = 1280, 720, 1000.0, -2.5
CENTER_X, CENTER_Y = 640.0, 360.0
POSES = 4
# Optical X, Y, Z are our Z, -Y, X.
OPTICAL = np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0]], float)


def about(axis, angle):
    return cv2.Rodrigues(np.array(axis, float) * angle)[0]


def pose(rng, scene):
    """rvec and tvec of a pose drawn from the canonical box; the deck is seen from above."""
    distance = rng.uniform(20, 50)
    low, high = (5, 12) if scene == "deck" else (-5, 10)
    elevation, azimuth = np.radians([rng.uniform(low, high), rng.uniform(-8, 8)])
    roll, pitch, yaw = np.radians(rng.uniform(-5, 5, 3))
    position = distance * np.array([-1, np.tan(elevation), np.tan(azimuth)])
    # Passive rotations, as the products of three elementary ones.
    body = about((1, 0, 0), -roll) @ about((0, 0, 1), -pitch) @ about((0, 1, 0), -yaw)
    camera = about((0, 0, 1), -np.radians(MOUNT_DEG)) @ body
    turn = OPTICAL @ camera
    parameters = [distance, elevation, azimuth, roll, pitch, yaw]
    return parameters, cv2.Rodrigues(turn)[0], -turn @ position


def solve(points, image, matrix, distortion):
    answers = {}
    for name, flag in (("epnp", cv2.SOLVEPNP_EPNP), ("sqpnp", cv2.SOLVEPNP_SQPNP)):
        ok, rvec, tvec = cv2.solvePnP(points, image, matrix, distortion, flags=flag)
        assert ok
        answers[name] = (rvec, tvec)
    # OpenCV's own start of the iteration needs six points.
    rvec, tvec = (a.copy() for a in answers["sqpnp"])
    ok, rvec, tvec = cv2.solvePnP(
        points, image, matrix, distortion, rvec, tvec, True, flags=cv2.SOLVEPNP_ITERATIVE
    )
    assert ok
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 500, 1e-15)
    answers["iterative"] = cv2.solvePnPRefineLM(
        points, image, matrix, distortion, rvec, tvec, criteria
    )
    return {
        name: {"rvec": rvec.ravel().tolist(), "tvec": tvec.ravel().tolist()}
        for name, (rvec, tvec) in answers.items()
    }


def main():
    rng = np.random.default_rng(1)
    matrix = np.array([[FOCAL, 0, CENTER_X], [0, FOCAL, CENTER_Y], [0, 0, 1]])
    cases = []
    for scene, landmarks in SCENES.items():
        points = np.array(landmarks, float)
        for bent in (False, True) if scene in DISTORTIONS else (False,):
            distortion = np.array(DISTORTIONS[scene] if bent else [0.0] * 5)
            for sigma in (0.0, 1.0):
                for _ in range(POSES):
                    parameters, rvec, tvec = pose(rng, scene)
                    image = cv2.projectPoints(points, rvec, tvec, matrix, distortion)[0]
                    seen = image + sigma * rng.standard_normal(image.shape)
                    cases.append(
                        {
                            "scene": scene,
                            "distortion": distortion.tolist(),
                            "noise_px": sigma,
                            "parameters": [float(p) for p in parameters],
                            "projected": image.reshape(-1, 2).tolist(),
                            "seen": seen.reshape(-1, 2).tolist(),
                            "answers": solve(points, seen, matrix, distortion),
                        }
                    )
    camera = {
        "width": WIDTH,
        "height": HEIGHT,
        "fx": FOCAL,
        "fy": FOCAL,
        "cx": CENTER_X,
        "cy": CENTER_Y,
        "mount_deg": MOUNT_DEG,
    }
    print(f'{{"opencv": "{cv2.__version__}",\n"camera": {json.dumps(camera)},')
    print(f'"scenes": {json.dumps(SCENES)},\n"cases": [')
    print(",\n".join(json.dumps(case) for case in cases))
    print("]}")


main()
