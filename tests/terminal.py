"""The program on a terminal of its own."""

import os
import pty
import select
import subprocess
import sys


def on_terminal(*words, width, errors=False, cwd=None, **env):
    """Run a command on a terminal; return its exit code and what it shows.

    Our side of the terminal is kept open until the command has ended: a terminal that
    is closed says so to who reads it before it gives what was last written to it, if
    the two happen at once.
    """
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "rcc_sim", *words],
        stdout=theirs,
        stderr=theirs if errors else subprocess.DEVNULL,
        env=os.environ | {"COLUMNS": str(width), "TERM": "xterm"} | env,
        cwd=cwd,
        close_fds=True,
    )
    shown, ended = b"", False
    while not ended:
        ended = process.poll() is not None
        while select.select([ours], [], [], 0.02)[0]:
            shown += os.read(ours, 65536)
    os.close(theirs)
    os.close(ours)
    return process.returncode, shown.decode()
