"""Overhead of a call from Python: ``python python/benchmarks/calls.py [ANALYSIS_LOOP]``.

ANALYSIS_LOOP is the example of that name, built by ``cargo build --release -p arcmin --example analysis_loop``.
Measured on an idle machine; not a test.
"""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable

import arcmin


def best_of(times: int, calls: int, call: Callable[[], object]) -> float:
    """Time of a call in ms."""
    best = float("inf")
    for _ in range(times):
        started = time.perf_counter()
        for _ in range(calls):
            call()
        best = min(best, (time.perf_counter() - started) * 1e3 / calls)
    return best


def in_rust(analysis: str, calls: int) -> float | None:
    """Time of a call of the same loop in Rust in ms."""
    if len(sys.argv) < 2:
        return None
    words = [sys.argv[1], analysis, str(calls)]
    return float(subprocess.run(words, capture_output=True, text=True, check=True).stdout)


def main() -> None:
    design = arcmin.Design.template("rv-40e")
    calls = 1000
    ours = best_of(3, calls, lambda: arcmin.contact(design))
    print(f"contact from Python {ours:.3f} ms a call")
    if theirs := in_rust("contact", calls):
        print(f"in Rust {theirs:.3f} ms a call: Python at {100 * theirs / ours:.1f} % of its speed")
    cheap = best_of(5, 2000, lambda: arcmin.check(design)) * 1e3
    print(f"check {cheap:.1f} µs a call, computation included")
    if alone := in_rust("check", 10 * calls):
        print(f"in Rust {1e3 * alone:.1f} µs a call: the way through Python costs {cheap - 1e3 * alone:.1f} µs")

    def work() -> None:
        for _ in range(calls):
            arcmin.contact(design)

    started = time.perf_counter()
    work()
    one = time.perf_counter() - started
    both = [threading.Thread(target=work) for _ in range(2)]
    started = time.perf_counter()
    for thread in both:
        thread.start()
    for thread in both:
        thread.join()
    print(f"two threads do twice the work in {(time.perf_counter() - started) / one:.2f} of the time")


if __name__ == "__main__":
    main()
