"""MKL PARDISO through pypardiso: pardiso.py FILE. Threads: MKL_NUM_THREADS."""

import statistics
import sys
import time

import numpy as np
import scipy.sparse as sp
from pypardiso import PyPardisoSolver

RUNS, MANY = 5, 8


def measure(name, runs, work):
    wall, cpu = [], []
    for run in range(-(runs > 1), runs):
        w, c = time.perf_counter(), time.process_time()
        work()
        if run >= 0:
            wall.append(time.perf_counter() - w)
            cpu.append(time.process_time() - c)
    print(f"{name} {statistics.median(wall):.6f} {statistics.median(cpu):.6f}")


with open(sys.argv[1], "rb") as file:
    n, entries = np.fromfile(file, np.int64, 2)
    start = np.fromfile(file, np.int32, n + 1)
    row = np.fromfile(file, np.int32, entries)
    value = np.fromfile(file, np.float64, entries)
# The lower triangle by columns is the upper triangle by rows.
upper = sp.csr_matrix((value, row, start), shape=(n, n))
full = upper + sp.triu(upper, 1).T

solver = PyPardisoSolver(mtype=2)
solver.set_iparm(1, 1)  # not the defaults
solver.set_iparm(2, 2)  # METIS
solver.set_iparm(8, 0)  # no refinement
solver.set_iparm(10, 8)
solver.set_iparm(18, -1)
solver.set_iparm(19, -1)


def phase(number, b):
    solver.set_phase(number)
    return solver._call_pardiso(upper, b)


def loads(columns):
    dof, column = np.meshgrid(np.arange(n), np.arange(columns), indexing="ij")
    return np.asfortranarray(1.0 + (dof * 7 + column) % 13)


one = loads(1)
measure("analysis", 1, lambda: phase(11, one))
measure("numeric", RUNS, lambda: phase(22, one))
for columns in (1, MANY):
    b = loads(columns)
    x = None

    def solve():
        global x
        x = phase(33, b)

    measure("solve" if columns == 1 else "solve8", RUNS, solve)
    rest = full @ x - b
    worst = max(np.linalg.norm(rest[:, j]) / np.linalg.norm(b[:, j]) for j in range(columns))
    print(f"residual {worst:.3e}")
print(f"entries {solver.get_iparm(18)}")
