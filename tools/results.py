"""Makes docs/results.md from what `tools/results` measured."""

import json
import pathlib
import sys

HEAD = """# Placed and routed

Cores with their real weights, emitted for a device (`hwgen emit --device`), verified (`hwgen verify`: model and simulators equal in every register, blocks of the device in place of portable cells), synthesised, placed and routed (`hwgen synth`) in a shell of three pins.
This page is written by `tools/results`.
"""


def millions(value):
    return f"{value / 1e6:.2f}"


def main():
    directory = pathlib.Path(sys.argv[1])
    print(HEAD)
    tools = None
    rows, paths = [], []
    for name in sys.argv[2:]:
        read = lambda what: json.loads((directory / f"{name}.{what}.json").read_text())
        emit, verify, synth = read("emit"), read("verify"), read("synth")
        if not synth.get("fmax_mhz"):
            message = synth.get("error", {}).get("message", "no result")
            rows.append([name, synth.get("device", "-"), message] + ["-"] * 9)
            continue
        tools = synth["tools"]
        fmax, cells = synth["fmax_mhz"], synth["cells"]
        rows.append(
            [
                name,
                synth["device"],
                "equal" if verify["verified"] else "**differs**",
                cells["multipliers"],
                f"{100 * emit['mac_utilization']:.0f} %",
                cells["lut4"],
                cells["ff"],
                f"{fmax['min']:.0f} / **{fmax['median']:.0f}** / {fmax['max']:.0f}",
                f"{synth['latency_cycles']} / {synth['interval_cycles']}",
                f"{synth['latency_ns']:.0f}",
                millions(synth["inferences_per_second"]),
                f"{100 * synth['share_of_limit']:.0f} %",
            ]
        )
        slowest = min(
            zip(fmax["per_seed"], synth["critical_paths"]), key=lambda pair: pair[0]["mhz"]
        )[1]
        paths.append(
            [
                name,
                f"{slowest['logic_ns'] + slowest['routing_ns']:.1f}",
                f"{slowest['logic_ns']:.1f}",
                f"{slowest['routing_ns']:.1f}",
                " > ".join(f"`{part}`" for part in slowest["through"]),
            ]
        )
    if tools:
        print(
            ", ".join(f"{tool['name']} {tool['version']}" for tool in tools)
            + f"; {len(fmax['per_seed'])} seeds, the slowest speed grade.\n"
        )
    table(
        ["design", "device", "verified", "multipliers", "busy", "LUT4", "flip-flops",
         "clock, MHz: least / median / most", "latency / interval, clocks", "latency, ns",
         "million poses a second", "of the limit"],
        rows,
    )
    print(
        "\n`busy` is the share of the arrays' multipliers that does useful work in a clock; `limit` is what "
        "all multipliers of the device could do at the clock that one reaches alone (430 MHz). "
        "Latency and rate are those at the median clock.\n"
    )
    print("The slowest path of the slowest seed, in ns:\n")
    table(["design", "all", "logic", "routing", "through"], paths)


def table(head, rows):
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |")


main()
