"""Many runs of one drive in one loop: parameters in, a record of each run out.

Each run is exactly that of ``run_imposed`` or ``run_commanded``; only what it comes to
is kept, so that a hundred thousand runs need the memory of one trace.
"""

from rcc_sim.jit import jit
from rcc_sim.physics.record import Schema, floats
from rcc_sim.physics.run import run_commanded, run_imposed

RESULT: Schema = floats(
    "t", "s", "E", "E_abs", "v_max", "P_max", "P_min", "tau_max", "tau_min", "i_q_max",
    "a_x_max", "a_x_min", "a_y_max", "r_max", "i_max", "limited", "short", "outside",
    "slip", "P_over",
)  # fmt: skip
"""What a run came to: sums, and the peaks of its rows."""


@jit
def clear(work, blank):
    """Forget the run before: every record as it began."""
    work[0][0] = blank[0][0]
    work[1][0] = blank[1][0]
    work[2][0] = blank[2][0]
    work[3][0] = blank[3][0]
    work[4][0] = blank[4][0]


@jit
def sum_up(rows, flow, result):
    """Write what the rows of one run come to."""
    last = rows[len(rows) - 1]
    first = rows[0]
    result.t = last.t - first.t
    result.s = last.s
    result.E = last.E
    result.E_abs = flow.E_abs
    result.limited = flow.limited
    result.short = flow.short
    result.outside = flow.outside
    result.slip = flow.slip
    result.P_over = flow.P_over
    result.v_max = first.v
    result.P_max = rows[1].P
    result.P_min = rows[1].P
    result.tau_max = rows[1].tau
    result.tau_min = rows[1].tau
    result.i_q_max = 0.0
    result.a_x_max = rows[1].a_x
    result.a_x_min = rows[1].a_x
    result.a_y_max = 0.0
    result.r_max = 0.0
    result.i_max = rows[1].i
    for k in range(1, len(rows)):
        row = rows[k]
        result.v_max = max(result.v_max, row.v)
        result.P_max = max(result.P_max, row.P)
        result.P_min = min(result.P_min, row.P)
        result.tau_max = max(result.tau_max, row.tau)
        result.tau_min = min(result.tau_min, row.tau)
        result.i_q_max = max(result.i_q_max, abs(row.i_q))
        result.a_x_max = max(result.a_x_max, row.a_x)
        result.a_x_min = min(result.a_x_min, row.a_x)
        result.a_y_max = max(result.a_y_max, abs(row.a_y))
        result.r_max = max(result.r_max, abs(row.r))
        result.i_max = max(result.i_max, row.i)


@jit
def rescale(cycle, scales, i, drive):
    """Write the times and speeds of a run: the cycle's, by the run's own factors."""
    for k in range(len(cycle[0])):
        drive[0][k] = cycle[0][k] * scales[i, 0]
        drive[1][k] = cycle[1][k] * scales[i, 1]


@jit
def batch_imposed(P, work, blank, cycle, scales, drive, maps, rows, sinks, out, ends):
    """Do the imposed run of each record of P; fill ``out`` and ``ends`` (the ledgers).

    ``cycle`` holds time and speed; ``scales`` the factors of both, a row a run.
    ``blank`` are the records of a run that has not begun; ``rows`` and ``sinks`` are
    room for one run, the times and speeds in ``drive`` likewise.
    """
    for i in range(len(P)):
        clear(work, blank)
        rescale(cycle, scales, i, drive)
        run_imposed(P[i : i + 1], work, drive, maps, rows, sinks)
        sum_up(rows, work[4][0], out[i])
        ends[i] = sinks[len(sinks) - 1]


@jit
def batch_commanded(
    P, work, blank, cycle, scales, drive, maps, lines, rows, sinks, counts, out, ends
):
    """Do the commanded run of each record of P, as ``batch_imposed`` does.

    ``counts`` holds, a row a run, the ticks per row and the number of rows.
    """
    for i in range(len(P)):
        clear(work, blank)
        rescale(cycle, scales, i, drive[0])
        lines[0][:] = 0.0
        lines[1][:] = 0.0
        n = counts[i, 1]
        run_commanded(
            P[i : i + 1], work, drive, maps, lines, rows[:n], sinks[:n], counts[i, 0], 1
        )
        sum_up(rows[:n], work[4][0], out[i])
        ends[i] = sinks[n - 1]
