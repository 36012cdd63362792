"""The figures as a table."""

import datetime
import importlib.metadata
import os
import platform
import re
from pathlib import Path


def machine(splatvol_version, threads):
    """Who measured."""
    try:
        names = [line.split(":")[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
                 if line.startswith("model name")]
    except OSError:
        names = []
    return {"processor": names[0] if names else platform.processor(), "processors": os.cpu_count(),
            "system": platform.platform(), "threads": threads,
            "vtk": importlib.metadata.version("vtk"), "splatvol": splatvol_version}


def title(document):
    """Who measured, as a line."""
    device = f"{document['device']}; " if document.get("device") else ""
    return (f"{device}{document['processor']}, {document['processors']} processors, {document['threads']} threads; "
            f"VTK {document['vtk']}; {document['splatvol']}")


def progress(case):
    """One case, as a line."""
    parts = [f"{case['volume']} {case['transfer-function']}:"]
    for name in ("vtk", "splatvol"):
        times, quality = case.get("times", {}).get(name), case.get("quality", {}).get(name)
        if times or quality:
            parts.append(f"{name} {_ms(times)} CPU ms, {_db(quality)} dB;")
    return " ".join(parts)


def table(document):
    """All cases, as Markdown."""
    lines = [
        title(document), "",
        "Milliseconds per frame: median [least..most]. Ratio: VTK / splatvol, median over rounds (each round's). "
        "Others: most of the machine that other programs used during a batch.", "",
        "| volume | tf | VTK CPU | splatvol CPU | CPU ratio | VTK wall | splatvol wall | wall ratio | others "
        "| VTK PSNR, SSIM | splatvol PSNR, SSIM |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for case in document["cases"]:
        times, quality = case.get("times", {}), case.get("quality", {})
        row = [case["volume"], case["transfer-function"]]
        for key in ("cpu", "wall"):
            row += [_range(times.get(name), f"{key}_ms") for name in ("vtk", "splatvol")]
            row.append(_ratio(times.get(f"ratio_{key}")))
        others = [found["others"] for found in times.values() if found.get("others") is not None]
        row.append(f"{max(others):.0%}" if others else "-")
        row += [f"{_db(quality.get(name))} dB, {quality[name]['ssim']:.4f}" if name in quality else "-"
                for name in ("vtk", "splatvol")]
        lines.append("| " + " | ".join(row) + " |")
    return "\n".join(lines)


def record(document, folder, flags):
    """Writes the tables to this machine's file in a folder; returns its path. One file per processor, threads and flags."""
    parts = [document.get("device") or document["processor"] or "unknown", f"{document['threads']} threads", *flags]
    name = "-".join(filter(None, (re.sub(r"[^a-z0-9.]+", "-", part.lower()).strip("-") for part in parts)))
    made = cold_start_table(document) if "cold-start" in document else table(document)
    kind = "cold-start-" if "cold-start" in document else ""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{kind}{name}.md"
    flags = " ".join(flags) or "none"
    path.write_text(f"# {datetime.date.today().isoformat()}\n\nFlags of splatvol: {flags}.\n\n{made}\n")
    return path


def cold_start_table(document):
    """Whole processes, as Markdown."""
    lines = [title(document), "", "Seconds from process start to picture written, median [least..most].", "",
             "| program | volume | wall | CPU |", "|---|---|---|---|"]
    for found in document["cold-start"]:
        lines.append(f"| {found['program']} | {found['volume']} | {_seconds(found['wall_s'])} "
                     f"| {_seconds(found['cpu_s'])} |")
    return "\n".join(lines)


def _ms(times):
    return f"{times['cpu_ms']['median']:.0f}" if times else "-"


def _db(quality):
    return f"{quality['psnr_db']:.1f}" if quality else "-"


def _range(times, key):
    if not times:
        return "-"
    found = times[key]
    digits = 1 if found["median"] < 20 else 0
    return f"{found['median']:.{digits}f} [{found['min']:.{digits}f}..{found['max']:.{digits}f}]"


def _ratio(ratio):
    if not ratio:
        return "-"
    return f"{ratio['median']:.2f} ({', '.join(f'{x:.2f}' for x in ratio['rounds'])})"


def _seconds(found):
    return f"{found['median']:.2f} [{found['min']:.2f}..{found['max']:.2f}]"
