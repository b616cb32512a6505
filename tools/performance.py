#!/usr/bin/env python3
"""performance.py BUILD PAGE NAME...: writes tables into the blocks of PAGE that begin with "<!-- generated: NAME -->" and end with
"<!-- end -->". NAME is "machine", or a benchmark that left BUILD/bench/NAME.json (bench.sh)."""

import json
import os
import re
import subprocess
import sys


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def against(value, bar, most=True):
    """A ratio beside its bar, and whether it keeps to it."""
    kept = value <= bar if most else value >= bar
    return f"{value:.2f}", f"{'at most' if most else 'at least'} {bar:g}", "yes" if kept else "**no**"


def machine(build):
    def cpu(field):
        found = re.search(rf"^{field}\s*:\s*(.*)$", open("/proc/cpuinfo").read(), re.M)
        return found.group(1) if found else "?"

    def cache(level):
        try:
            text = subprocess.run(["lscpu"], capture_output=True, text=True).stdout
            return re.search(rf"^{level} cache:\s*(.*)$", text, re.M).group(1)
        except (AttributeError, OSError):
            return "?"

    options = dict(
        line.rstrip("\n").split("=", 1)
        for line in open(f"{build}/CMakeCache.txt")
        if "=" in line and not line.startswith(("#", "//")))
    value = lambda name: next((v for k, v in options.items() if k.split(":")[0] == name), "")
    compiler = subprocess.run([value("CMAKE_CXX_COMPILER"), "--version"], capture_output=True, text=True)
    flags = f"{value('CMAKE_CXX_FLAGS')} {value('CMAKE_CXX_FLAGS_RELEASE')} -ffp-contract=off"
    return table(["measured on", ""], [
        ["processor", f"{cpu('model name')}, family {cpu('cpu family')} model {cpu('model')}, {os.cpu_count()} cores seen"],
        ["caches", f"L1d {cache('L1d')}, L2 {cache('L2')}, L3 {cache('L3')}"],
        ["compiler", compiler.stdout.splitlines()[0]],
        ["flags", f"`{' '.join(flags.split())}`, baseline instruction set; Highway adds SSE4, AVX2 and AVX-512 for its kernels"],
    ])


def frame(result):
    out = []
    simds = [name for name in ("AVX-512", "AVX2", "SSE4", "NEON", "portable")
             if f"posed {name}" in result["frames"][0]["times"]]
    posed, whole, skin, various = [], [], [], []
    for case in result["frames"]:
        times, n = case["times"], case["triangles"]
        big = n > 500000
        for name in simds:
            bar = {"AVX-512": 1.0, "AVX2": 1.5}.get(name)
            ratio = times[f"posed {name}"] / times["eigen"]
            posed.append([f"{n:,}", name, f"{1e3 * times[f'posed {name}']:.3f} ms", f"{1e9 * times[f'posed {name}'] / n:.2f} ns",
                          *(against(ratio, round((1.4 if big else 1.6) * bar, 2)) if bar else (f"{ratio:.2f}", "", ""))])
            ratio = times[f"whole {name}"] / times["staged"]
            limits = against(ratio, 0.45 if big else 0.75) if bar else (f"{ratio:.2f}", "", "")
            whole.append([f"{n:,}", name, f"{1e3 * times[f'whole {name}']:.3f} ms", f"{1e9 * times[f'whole {name}'] / n:.2f} ns", *limits])
            rate = case["vertices"] / times[f"skin {name}"] / 1e6
            skin.append([f"{case['vertices']:,}", name, f"{rate:.0f} million",
                         *(against(rate, 200, most=False)[1:] if name == "AVX2" else ("", ""))])
        various.append([f"{n:,}", "vertices and triangles of the source in random order, over the same in order",
                        *against(times["shuffled"] / times[f"whole {result['best']}"], 1.05)])
        if big:
            various.append([f"{n:,}", f"{result['best']}, from posed positions, clusters in pages of 2 MiB, over Eigen in pages of 4 KiB",
                            f"{times['large pages'] / times['eigen']:.2f}", "", ""])
            various.append([f"{n:,}", "two threads, times as fast as one",
                            *against(times[f"whole {result['best']}"] / case["two threads"], 1.8, most=False)])
        for form, bar in (("whole", 42), ("posed", 42)):
            what = "with the pose from a palette" if form == "whole" else "from the host's positions"
            various.append([f"{n:,}", f"bytes a triangle, read and written, {what}; staged: {case['bytes']['staged'] / n:.1f}",
                            *against(case["bytes"][form] / n, bar)])
    layers = result["layers"]
    for name in dict.fromkeys((result["best"], "AVX2" if "AVX2" in simds else result["best"])):
        layer_bar = 0.525 if name == "AVX2" else 0.35  # half as much again without AVX-512
        times = lambda what, form: layers["times"][f"{what} {form} {name}"]
        for form, what in (("posed", "from posed positions"), ("whole", "whole frame")):
            various.append([f"{layers['triangles']:,}", f"{name}, {what}: directional over area",
                            *against(times("1", form) / times("area", form), 1.25)])
            for count in (2, 3, 4):
                more = (times(str(count), form) - times(str(count - 1), form)) / times("1", form)
                various.append([f"{layers['triangles']:,}", f"{name}, {what}: layer {count}, over the first", *against(more, layer_bar)])
            more = (times("8", form) - times("4", form)) / 4 / times("1", form)
            various.append([f"{layers['triangles']:,}", f"{name}, {what}: layers 5 to 8, each over the first", *against(more, layer_bar)])
    large = result["frames"][-1]
    best = large["times"]
    out.append("From posed positions, over Eigen's CSR product with the ring weights (`eigen`), which took " +
               " and ".join(f"{1e3 * case['times']['eigen']:.3f} ms for {case['triangles']:,} triangles" for case in result["frames"]) + ":\n\n" +
               table(["triangles", "", "frame", "a triangle", "over Eigen", "bar", "kept"], posed))
    out.append("The whole frame, posed by a palette with four influences, over the frozen staged frame, which took " +
               " and ".join(f"{1e3 * case['times']['staged']:.3f} ms for {case['triangles']:,} triangles" for case in result["frames"]) + ":\n\n" +
               table(["triangles", "", "frame", "a triangle", "over staged", "bar", "kept"], whole))
    out.append(f"Skinning alone: positions, normals and tangents, four influences, one thread (96 bytes read and written a vertex; one thread reads "
               f"{result['read_bandwidth'] / 1e9:.1f} GB/s from memory):\n\n" +
               table(["vertices", "", "vertices a second", "bar", "kept"], skin))
    out.append(table(["triangles", "what", "figure", "bar", "kept"], various))
    dawn = result["dawn"]
    rows = []
    for name, seconds in dawn["times"].items():
        if name != "copy":
            bar = against(seconds / dawn["times"]["copy"], 4) if name.startswith("whole") else (f"{seconds / dawn['times']['copy']:.2f}", "", "")
            rows.append([name.replace("whole ", "positions "), f"{1e3 * seconds:.3f} ms", f"{1 / seconds:,.0f}", *bar,
                         f"{1e3 * dawn['cold'][name]:.3f} ms", f"{dawn['cold'][name] / dawn['cold']['copy']:.2f}"])
    out.append(f"The \"Dawn\" character: {dawn['triangles']:,} triangles, {dawn['vertices']:,} vertices, 98 bones with four influences, 50 morph targets of which 5 "
               f"are active and move {dawn['moved']:,} vertices; positions written, one thread. It must touch {dawn['bytes'] / 1e6:.1f} MB. One memcpy of so many bytes that "
               f"has just run, as the frame has (the bar's), takes {1e3 * dawn['times']['copy']:.3f} ms; from memory to memory, the caches full of something else, "
               f"{1e3 * dawn['cold']['copy']:.3f} ms:\n\n" +
               table(["", "frame", "frames a second", "over the memcpy", "bar", "kept", "frame from memory", "over a memcpy from memory"], rows))
    loading = result["loading"]
    n = result["frames"][0]["triangles"]
    out.append(f"An asset of {n:,} triangles without maps ({loading['file'] / 1e3:.0f} kB) loads in {1e3 * loading['load']:.0f} ms; its clusters are cut in "
               f"{1e3 * loading['build']:.0f} ms.")
    return "\n\n".join(out)


def google(result):
    """Google Benchmark's own JSON."""
    rows = []
    for run in result["benchmarks"]:
        if run.get("run_type") == "aggregate" or "error_message" in run:
            continue
        fixed = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions", "repetition_index",
                 "threads", "iterations", "real_time", "cpu_time", "time_unit", "label"}
        counters = [f"{key} {value:,.3g}" if value < 1000 else f"{key} {value:,.0f}" for key, value in run.items() if key not in fixed]
        time, unit = run["real_time" if "real_time" in run["name"] else "cpu_time"], run["time_unit"]
        if unit == "ms" and time >= 1000:
            time, unit = time / 1000, "s"
        name = run["name"].replace("/process_time", "").replace("/real_time", "")
        rows.append([f"`{name}`", f"{time:.3g} {unit}", ", ".join(counters)])
    return table(["benchmark", "time", "counters"], rows)


def main():
    build, page, names = sys.argv[1], sys.argv[2], sys.argv[3:]
    text = open(page).read()
    for name in names:
        if name == "machine":
            body = machine(build)
        else:
            result = json.load(open(f"{build}/bench/{name}.json"))
            body = frame(result) if name == "frame_bench" else google(result)
        block = re.compile(rf"(<!-- generated: {name} -->\n).*?(<!-- end -->)", re.S)
        if not block.search(text):
            sys.exit(f"performance.py: {page}: no block for {name}: add its marks")
        text = block.sub(lambda match: match.group(1) + "\n" + body + "\n\n" + match.group(2), text)
    with open(page + ".new", "w") as out:
        out.write(text)
    os.replace(page + ".new", page)


main()
