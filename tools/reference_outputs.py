#!/usr/bin/env python3
"""Fill the float_* columns of a vectors file with what the weights say, in NumPy.

    tools/reference_outputs.py designs/landing/weights.json designs/landing/vectors.csv

It shares nothing with hwgen but the weights format, so that the two can be held against each other.
All other columns stay as they are. Needs NumPy.
"""

import csv
import json
import sys

import numpy as np

ACTIVATIONS = {
    "tanh": np.tanh,
    "sigmoid": lambda x: 1 / (1 + np.exp(-x)),
    "relu": lambda x: np.maximum(x, 0),
    "linear": lambda x: x,
}


def layers(x, stack):
    """x: [frames][inputs]"""
    for layer in stack:
        weights = np.array(layer["weights"], dtype=float)
        bias = np.array(layer.get("bias", np.zeros(len(weights))), dtype=float)
        x = ACTIVATIONS[layer["activation"]](x @ weights.T + bias)
    return x


def main(weights_path, vectors_path):
    with open(weights_path) as file:
        net = json.load(file)
    with open(vectors_path) as file:
        rows = list(csv.DictReader(file))
    inputs = net["inputs"]
    count = len(inputs["names"])
    raw = np.array([[float(row[name]) for name in inputs["names"]] for row in rows])
    x = (raw - inputs.get("offset", np.zeros(count))) * inputs.get("scale", np.ones(count))
    x = layers(x, net.get("shared", []))
    for network in net["networks"]:
        outputs = network["outputs"]
        names = outputs["names"]
        y = layers(x, network["layers"])
        y = y * outputs.get("scale", np.ones(len(names))) + outputs.get("offset", np.zeros(len(names)))
        unit = f"_{outputs['unit']}" if outputs.get("unit") else ""
        for column, name in enumerate(names):
            for row, value in zip(rows, y[:, column]):
                row[f"float_{name}{unit}"] = f"{value:.9g}"
    with open(vectors_path, "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
